"""Analytic motions: products of exponentials, with exact twists, accelerations and jerks.

``pose(t) = Π exp(axis_i f_i(t))``, the first factor nearest to the world. With
``P_k = P_{k-1} exp(a f)`` the body twist follows factor by factor, ``w_k = y + a f'`` where
``y = Ad(exp(-a f)) w_{k-1}``, and as ``y' = Ad w' + [y, a f']`` so do all its derivatives. It is
the product of exponentials of robot arms (R. W. Brockett, Robotic manipulators and the product of
exponentials formula, 1984) with a joint for each factor.

The factors run on signals, which give their value and first three derivatives. Time is in seconds
and may be any real number.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor, Similarity, Trajectory, TwistSample
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.ga.motion import twist_bracket
from motorcade.ga.stamps import check_count, checked_rate

# The step that starts and ends at rest with no acceleration and no jerk: 35u⁴ - 84u⁵ + 70u⁶ - 20u⁷.
_STEP = np.polynomial.Polynomial((0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0))


class Signal(ABC):
    """A scalar function of time.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.motion import Polynomial, Signal, Sines
        >>> signals = Polynomial((0.0, 1.0)), Sines.single(0.1, 0.5)
        >>> [isinstance(one, Signal) for one in signals], signals[0].derivatives(np.zeros(5)).shape
        ([True, True], (4, 5))
    """

    @abstractmethod
    def derivatives(self, time_s: FloatArray) -> FloatArray:
        """Value and first three derivatives ``(4, *)`` at times ``(*)``."""


@dataclass(frozen=True)
class Polynomial(Signal):
    """``c0 + c1 t + c2 t² + …``, lowest power first; one number is a constant.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.motion import Polynomial
        >>> value, slope, _, _ = Polynomial((1.0, 2.0)).derivatives(np.array([0.0, 3.0]))
        >>> value, slope
        (array([1., 7.]), array([2., 2.]))
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        _as_tuple(self, "coefficients")

    def derivatives(self, time_s: FloatArray) -> FloatArray:
        """Value and first three derivatives ``(4, *)``."""
        whole = np.polynomial.Polynomial(self.coefficients)
        return np.stack([np.broadcast_to(whole.deriv(k)(time_s), time_s.shape) for k in range(4)])


@dataclass(frozen=True)
class Sines(Signal):
    """``Σ a sin(2π f t + φ)``: band-limited, of equal power at all times.

    Args:
        amplitudes: in the unit of the signal.
        frequencies_hz: above zero.
        phases_rad: at time zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.motion import Sines
        >>> value, slope, _, _ = Sines.single(0.1, frequency_hz=0.5).derivatives(np.array([0.5]))
        >>> value
        array([0.1])
    """

    amplitudes: tuple[float, ...]
    frequencies_hz: tuple[float, ...]
    phases_rad: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("amplitudes", "frequencies_hz", "phases_rad"):
            _as_tuple(self, name)
        count = len(self.amplitudes)
        if not len(self.frequencies_hz) == len(self.phases_rad) == count:
            raise ValueError(
                f"Sines: expected one frequency and one phase for each of {count} amplitudes, got "
                f"{len(self.frequencies_hz)} and {len(self.phases_rad)}"
            )
        if not min(self.frequencies_hz) > 0.0:
            raise ValueError(
                f"Sines.frequencies_hz: expected above 0, got {min(self.frequencies_hz)}"
            )

    @classmethod
    def single(cls, amplitude: float, frequency_hz: float, phase_rad: float = 0.0) -> Sines:
        """One sine."""
        return cls((amplitude,), (frequency_hz,), (phase_rad,))

    @classmethod
    def random(
        cls, rng: np.random.Generator, rms: float, band_hz: tuple[float, float], count: int = 12
    ) -> Sines:
        """Sines spread over a band, amplitudes falling as 1/f, random phases.

        Frequencies divide the band in equal ratios, each moved within its own part, so they have
        no common period.

        Raises:
            ValueError: a negative `rms`, a band that is not 0 < low < high, or no sines.
        """
        low, high = band_hz
        if not (0.0 < low < high < np.inf) or count < 1 or not 0.0 <= rms < np.inf:
            raise ValueError(
                "Sines.random: expected rms >= 0, 0 < low < high and count >= 1, got "
                f"rms {rms}, band_hz {band_hz}, count {count}"
            )
        places = (np.arange(count) + rng.random(count)) / count
        frequencies = low * (high / low) ** places
        shape = 1.0 / frequencies
        amplitudes = rms * shape * np.sqrt(2.0 / np.sum(shape**2))
        phases = rng.uniform(-np.pi, np.pi, count)
        return cls(tuple(amplitudes), tuple(frequencies), tuple(phases))

    def derivatives(self, time_s: FloatArray) -> FloatArray:
        """Value and first three derivatives ``(4, *)``."""
        amplitude, phase = np.array(self.amplitudes), np.array(self.phases_rad)
        rate = 2.0 * np.pi * np.array(self.frequencies_hz)
        angle = time_s[..., None] * rate + phase
        sine, cosine = np.sin(angle), np.cos(angle)
        value, slope = sine @ amplitude, cosine @ (amplitude * rate)
        second, third = sine @ (-amplitude * rate**2), cosine @ (-amplitude * rate**3)
        return np.stack([value, slope, second, third])


@dataclass(frozen=True)
class Stops(Signal):
    """Move from level to level and rest at each, round and round.

    Each move takes `move_s` and is a polynomial of degree 7 whose velocity, acceleration and jerk
    vanish at both ends; each rest takes `rest_s`. At time zero the first move starts.

    Args:
        levels: two or more, in the unit of the signal; after the last comes the first again.
        move_s, rest_s: durations, above zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.motion import Stops
        >>> Stops((0.0, 1.0), move_s=1.0, rest_s=0.5).derivatives(np.array([0.5, 1.25]))[0]
        array([0.5, 1. ])
    """

    levels: tuple[float, ...]
    move_s: float
    rest_s: float

    def __post_init__(self) -> None:
        _as_tuple(self, "levels")
        if len(self.levels) < 2:
            raise ValueError(f"Stops.levels: expected 2 or more, got {len(self.levels)}")
        for name in ("move_s", "rest_s"):
            checked_positive(getattr(self, name), f"Stops.{name}")

    def derivatives(self, time_s: FloatArray) -> FloatArray:
        """Value and first three derivatives ``(4, *)``."""
        stage = self.move_s + self.rest_s
        index = np.floor(time_s / stage)
        fraction = np.clip((time_s - index * stage) / self.move_s, 0.0, 1.0)
        levels = np.array(self.levels)
        which = (index % levels.size).astype(np.int64)
        change = (np.roll(levels, -1) - levels)[which]
        rates = np.stack([change * _STEP.deriv(k)(fraction) / self.move_s**k for k in range(4)])
        rates[0] += levels[which]
        return rates


def _as_tuple(signal: Signal, name: str) -> None:
    """Keep finite numbers as a tuple of floats, so that signals stay hashable values."""
    values: ArrayLike = getattr(signal, name)
    checked = checked_floats(values, f"{type(signal).__name__}.{name}", ())
    if checked.ndim != 1 or checked.size == 0:
        raise ValueError(
            f"{type(signal).__name__}.{name}: expected one or more numbers, got shape "
            f"{checked.shape}"
        )
    object.__setattr__(signal, name, tuple(map(float, checked)))


V = TypeVar("V", Motor, Similarity)


@dataclass(frozen=True, eq=False)
class Factor:
    """``exp(twist · signal(t))``: turn, screw, shift or growth along one axis.

    Args:
        twist: ``(6,)`` rotation (rad) and translational part (m) for a signal of 1, or ``(7,)``
            with the logarithm of the scale behind them.
        signal: how far, over time.

    Examples:
        >>> from motorcade.fusion.motions import Factor, Motion
        >>> from motorcade.fusion.motions.motion import Polynomial
        >>> from motorcade.ga import Motor
        >>> turning = Factor([0, 0, 1, 0, 0, 0], Polynomial((0.0, 0.5)))  # 0.5 rad/s about z
        >>> Motion((turning,), Motor).at(2.0).pose.rotor.as_rotation_vector()
        array([-0.,  0.,  1.])
    """

    twist: FloatArray
    signal: Signal

    def __post_init__(self) -> None:
        twist = np.asarray(self.twist)
        size = 7 if twist.shape[-1:] == (7,) else 6
        checked = checked_floats(twist, "Factor.twist", (size,))
        if checked.ndim != 1:
            raise ValueError(f"Factor.twist: expected shape (6,) or (7,), got {checked.shape}")
        object.__setattr__(self, "twist", frozen(checked))


@dataclass(frozen=True, eq=False)
class Motion(Generic[V]):
    """A pose as a closed function of time, ``world_T_camera`` by default.

    Args:
        factors: from the world to the moving frame.
        versor: Motor, or Similarity where the twists have seven numbers.

    Raises:
        ValueError: no factors, or twists of a size that does not fit the versor.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import Factor, Motion
        >>> from motorcade.fusion.motions.motion import Polynomial
        >>> from motorcade.ga import Motor
        >>> ahead = Factor([0, 0, 0, 1, 0, 0], Polynomial((0.0, 2.0)))  # 2 m/s along x
        >>> turning = Factor([0, 0, 1, 0, 0, 0], Polynomial((0.0, np.pi)))
        >>> motion = Motion((ahead, turning), Motor)  # world_T_camera
        >>> motion.at(0.5).body_twist.round(6)  # x of the camera points along y of the world by now
        array([ 0.      ,  0.      ,  3.141593,  0.      , -2.      ,  0.      ])
        >>> motion.sampled(rate_hz=30.0, duration_s=2.0)
        Trajectory(world_T_camera, 61 poses, 2.000 s)
    """

    factors: tuple[Factor, ...]
    versor: type[V]

    def __post_init__(self) -> None:
        size = 7 if self.versor is Similarity else 6
        sizes = [factor.twist.size for factor in self.factors]
        if not sizes or set(sizes) != {size}:
            raise ValueError(
                f"Motion.factors: expected one or more with twists of {size} numbers, got {sizes}"
            )

    def at(self, time_s: ArrayLike) -> TwistSample[V]:
        """Pose, body twist and its derivative at times ``(*)`` in seconds; exact at all times.

        Raises:
            ValueError: NaN or infinity.
        """
        times: FloatArray = checked_floats(time_s, "Motion.at(time_s)", ())
        pose = self.versor.identity(times.shape)
        twist = rate = np.zeros((*times.shape, self.factors[0].twist.size))
        for factor in self.factors:
            step, (first, second) = self._step(factor, times, 2)
            back = step.inverse()
            twist, rate = back.transform_twist(twist), back.transform_twist(rate)
            rate = rate + twist_bracket(twist, first) + second
            pose, twist = pose @ step, twist + first
        return TwistSample(pose, twist, rate)

    def twist_jerk(self, time_s: ArrayLike) -> FloatArray:
        """Second derivative of the body twist ``(*, 6)`` (similarities: 7) at times ``(*)``."""
        times: FloatArray = checked_floats(time_s, "Motion.twist_jerk(time_s)", ())
        twist = rate = jerk = np.zeros((*times.shape, self.factors[0].twist.size))
        for factor in self.factors:
            step, (first, second, third) = self._step(factor, times, 3)
            back = step.inverse()
            twist, rate, jerk = (back.transform_twist(part) for part in (twist, rate, jerk))
            crossed = rate + twist_bracket(twist, first)
            jerk = jerk + twist_bracket(rate + crossed, first) + twist_bracket(twist, second)
            twist, rate, jerk = twist + first, crossed + second, jerk + third
        return jerk

    def sampled(
        self,
        rate_hz: float,
        duration_s: float,
        start_ns: int = 0,
        start_s: float = 0.0,
        parent: str = "world",
        child: str = "camera",
    ) -> Trajectory:
        """The motion at even stamps.

        Args:
            rate_hz: poses a second.
            duration_s: from the first stamp to the last, at most.
            start_ns: the first stamp.
            start_s: time of the motion at the first stamp.
            parent: name of the frame that poses map to.
            child: name of the frame that moves.

        Raises:
            ValueError: a rate or duration that is not positive.
        """
        offset_ns = even_stamps(rate_hz, duration_s)
        poses = self.at(start_s + offset_ns * 1e-9).pose
        return Trajectory(start_ns + offset_ns, poses, parent, child)

    def _step(self, factor: Factor, times: FloatArray, order: int) -> tuple[V, list[FloatArray]]:
        """What one factor moves by, and so many derivatives of the twist that does."""
        signal = factor.signal.derivatives(times)[: order + 1]
        value, *slopes = (part[..., None] * factor.twist for part in signal)
        return self.versor.from_twist(value), slopes


def even_stamps(rate_hz: float, duration_s: float) -> IntArray:
    """Stamps ``(N,)`` in nanoseconds from zero to at most `duration_s`, rounded each for itself.

    Raises:
        ValueError: a rate or duration that is not positive and finite, or more than ten million
            stamps.

    Examples:
        >>> from motorcade.fusion.motions.motion import even_stamps
        >>> even_stamps(rate_hz=30.0, duration_s=0.1)
        array([        0,  33333333,  66666667, 100000000])
    """
    checked_rate(checked_positive(rate_hz, "rate_hz"), "rate_hz")
    checked_positive(duration_s, "duration_s")
    check_count(duration_s * rate_hz, f"rate_hz of {rate_hz:g} over {duration_s:g} s")
    count = int(np.floor(duration_s * rate_hz + 1e-6)) + 1
    return np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
