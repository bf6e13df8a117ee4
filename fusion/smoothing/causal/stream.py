"""What every causal filter shares: poses in one after another, or a whole trajectory at once.

The state lives in compiled code (`motorcade.fusion.smoothing.native`) and does not grow. A filter
takes the kind of its first pose, Motor or Similarity, and keeps to it until it is reset.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable
from math import isfinite
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from motorcade.fusion.smoothing.checks import checked_cutoff
from motorcade.fusion.smoothing.native import _scans
from motorcade.fusion.smoothing.native._scans import Scan
from motorcade.fusion.smoothing.representations import Representation, representation_named
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive

P = TypeVar("P", Motor, Similarity)


class CausalFilter(ABC):
    """A filter that sees a pose and those before it.

    Args:
        representation: a name of `REPRESENTATIONS`: what the filter's differences are.

    Raises:
        ValueError: an unknown representation.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import MOTIONS
        >>> from motorcade.fusion.smoothing.causal import ConstantVelocityFilter
        >>> from motorcade.fusion.smoothing.causal.stream import CausalFilter
        >>> from motorcade.fusion.smoothing.causal import OneEuro
        >>> path = MOTIONS["handheld"].sampled(rate_hz=30.0, duration_s=1.0)
        >>> def streamed(live: CausalFilter) -> list:
        ...     return [live.update(*one) for one in zip(path.motors, path.time_ns, strict=True)]
        >>> for live in (OneEuro(), ConstantVelocityFilter(noise_m=0.005, noise_rad=0.01)):
        ...     last = live.smooth(path).motors[-1]
        ...     print(np.array_equal(last.coefficients, streamed(live)[-1].coefficients))
        True
        True
    """

    _cutoffs_hz: ClassVar[tuple[str, ...]] = ()

    def __init__(self, representation: str = "motor") -> None:
        self._averaged_as = representation_named(representation)
        self.representation = representation
        self.reset()

    @abstractmethod
    def _scan(self, scale: bool) -> Scan:
        """A compiled filter that has seen nothing, of motors or similarities."""

    def reset(self) -> None:
        """Forget all poses; the next one begins anew and may be of another kind."""
        self._running: Scan | None = None
        self._kind: type[Motor] | type[Similarity] | None = None

    def update(self, pose: P, time_ns: int) -> P:
        """The filtered pose at a stamp, from a measured one; the first comes back as it is.

        Args:
            pose: one Motor or Similarity, no batch; the result is in float64.
            time_ns: stamp in integer nanoseconds, after those before. Gaps need no care: all steps
                are by time.

        Raises:
            ValueError: a batch of poses, a stamp that is no integer or not after the last one,
                or a result beyond float64. The filter is then as it was.
            TypeError: another kind of pose than before.
        """
        running = self._running
        if running is None or type(pose) is not self._kind:
            running = self._begin(pose)
        out = np.empty(pose._size)
        running.update(self._averaged_as.to_compiled(pose).coefficients, time_ns, out)
        return self._averaged_as.from_compiled(pose._trusted(out))

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """What `update` gives for a trajectory's poses in turn, to the last bit.

        A stream that this filter is fed with goes on as if nothing had been.

        Raises:
            ValueError: a cut-off that is not below half the sampling rate (of the median interval),
                or a result beyond float64.
        """
        for name in self._cutoffs_hz:
            checked_cutoff(getattr(self, name), trajectory, name)
        scan = self._scan(isinstance(trajectory.poses, Similarity))
        return self._run(scan, trajectory)

    def _run(
        self, scan: Scan, trajectory: Trajectory, noise: FloatArray | None = None
    ) -> Trajectory:
        measured = coefficients_of(trajectory, self._averaged_as)
        out = np.empty(measured.shape, measured.dtype)
        scan.run(measured, trajectory.time_ns, out, noise)
        return trajectory_of(trajectory, out, self._averaged_as)

    def _begin(self, pose: Motor | Similarity) -> Scan:
        if not isinstance(pose, Motor | Similarity):
            raise TypeError(f"pose: expected a Motor or Similarity, got {type(pose).__name__}")
        if self._kind is not None:
            raise TypeError(
                f"pose: expected a {self._kind.__name__} like those before, got "
                f"{type(pose).__name__}; reset() begins anew"
            )
        if pose.shape:
            raise ValueError(f"pose: expected one pose, got a batch of shape {pose.shape}")
        self._running = self._scan(isinstance(pose, Similarity))
        self._kind = type(pose)
        return self._running


def coefficients_of(trajectory: Trajectory, representation: Representation) -> FloatArray:
    """Coefficients ``(N, 8)`` or ``(N, 12)`` as the compiled scans want them."""
    poses = representation.to_compiled(trajectory.poses)
    return np.ascontiguousarray(poses.coefficients, dtype=np.float64)


def trajectory_of(
    like: Trajectory, coefficients: FloatArray, representation: Representation
) -> Trajectory:
    """Scanned coefficients with the stamps and frames of the trajectory that was scanned."""
    poses = representation.from_compiled(type(like.poses)._trusted(coefficients))
    return Trajectory(like.time_ns, poses, like.parent, like.child)


F = TypeVar("F", bound=CausalFilter)


class FilterMethod(Generic[F]):
    """A filter over a whole trajectory; called as ``method(trajectory, representation, **its)``.

    Parameters, their defaults and refusals are those of the filter.

    Args:
        kind: the filter.
        smoothed: what is done with a trajectory and the filter; by default the filter runs forward.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS
        >>> noisy = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> METHODS["exponential"](noisy, REPRESENTATIONS["motor"], cutoff_hz=3.0)
        Trajectory(world_T_camera, 61 poses, 2.000 s)
    """

    def __init__(
        self,
        kind: type[F],
        smoothed: Callable[[Trajectory, F], Trajectory] = lambda path, model: model.smooth(path),
    ) -> None:
        self._kind, self._smoothed = kind, smoothed
        trajectory, representation, _ = inspect.signature(self.__call__).parameters.values()
        own = [
            parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for name, parameter in inspect.signature(kind).parameters.items()
            if name != "representation"
        ]
        self.__signature__ = inspect.Signature([trajectory, representation, *own])

    def __call__(
        self, trajectory: Trajectory, representation: Representation, **parameters: Any
    ) -> Trajectory:
        """Smooth a trajectory.

        Raises:
            ValueError: parameters that the filter refuses, for themselves or for the trajectory.
            TypeError: parameters that the filter does not have.
        """
        model = self._kind(**parameters, representation=representation.name)
        return self._smoothed(trajectory, model)


# Low-pass filters: exponential, with a trend, and with a cut-off that follows the speed.


class Exponential(CausalFilter):
    """Move towards each pose by the share ``1 - exp(-2π cutoff_hz dt)`` of the way.

    A steady motion is followed with a lag of about ``1 / (2π cutoff_hz)`` seconds. On motors and
    similarities neither the choice of world nor of body changes the result.

    Args:
        cutoff_hz: frequency that is damped to 0.71. It must lie below half the sampling rate,
            which only a whole trajectory tells: `smooth` refuses it, `update` does not.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing.causal import Exponential
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = Exponential(cutoff_hz=2.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        4.5 cm behind
    """

    _cutoffs_hz = ("cutoff_hz",)

    def __init__(self, cutoff_hz: float = 4.0, representation: str = "motor") -> None:
        self.cutoff_hz = checked_positive(cutoff_hz, "cutoff_hz", "Hz")
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        return _scans.exponential(self._averaged_as.compiled, scale, self.cutoff_hz)


exponential = FilterMethod(Exponential)
"""`Exponential` over a whole trajectory."""


class DoubleExponential(CausalFilter):
    """Extrapolate the level along the trend, correct it, and let the trend follow the level.

    C. C. Holt's linear method (1957; Int. J. of Forecasting 20, 2004) by time instead of index:
    the level takes the share ``1 - exp(-2π cutoff_hz dt)`` of the innovation, the trend the share
    ``1 - exp(-2π trend_cutoff_hz dt)`` of what the level has just done. A steady motion is followed
    without lag; after a sudden stop the level overshoots by about the speed over
    ``2π trend_cutoff_hz``, and after a gap the trend has run on through it.

    Args:
        cutoff_hz: of the level. Like the other it must lie below half the sampling rate, which only
            a whole trajectory tells: `smooth` refuses it, `update` does not.
        trend_cutoff_hz: of the trend; lower than the level's, or the filter rings.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing.causal import DoubleExponential
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = DoubleExponential(cutoff_hz=2.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        0.0 cm behind
    """

    _cutoffs_hz = ("cutoff_hz", "trend_cutoff_hz")

    def __init__(
        self, cutoff_hz: float = 4.0, trend_cutoff_hz: float = 1.0, representation: str = "motor"
    ) -> None:
        self.cutoff_hz = checked_positive(cutoff_hz, "cutoff_hz", "Hz")
        self.trend_cutoff_hz = checked_positive(trend_cutoff_hz, "trend_cutoff_hz", "Hz")
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        return _scans.double_exponential(
            self._averaged_as.compiled, scale, self.cutoff_hz, self.trend_cutoff_hz
        )


double_exponential = FilterMethod(DoubleExponential)
"""`DoubleExponential` over a whole trajectory."""


class OneEuro(CausalFilter):
    """A first-order low-pass of cut-off ``min_cutoff_hz + beta · speed``, for each block.

    G. Casiez, N. Roussel, D. Vogel, 1€ filter: a simple speed-based low-pass filter for noisy input
    in interactive systems, CHI 2012, with its shares ``1 / (1 + 1 / (2π f dt))`` and its speed: the
    low-passed difference between the pose that comes and the filtered one before, over dt.
    Rotation, translation and scale each have a cut-off of their own, from the length of their part
    of the speed where the paper takes each coordinate for itself: axes would show otherwise.
    Where the speed hardly changes the cut-off hardly does, and nothing is gained on the exponential
    filter: behind someone who walks at an even pace it lags as far at equal jitter, where stops and
    turns come it lags a quarter to a half as far (`make bench SUITE=lag`).
    Choosing another world does not change the result on motors; choosing another origin in the
    body does, since it moves at another speed.

    By its defaults what rests is smoothed, and what moves goes through nearly as it came. Cut-offs
    are where the paper starts; with slopes of 100 the lag adds to the error of few paths, with 10
    it did of most (EuRoC's V1_02 and four synthetic motions at 20 and 60 Hz under sixteen kinds of
    noise). Other flights at 20 Hz keep their error (1.00 of it) and lose a little jitter.

    It breaks down on a camera that moves: parameters tuned on the ground truth of every single
    path leave 0.90 of the error there, `LiveSmoother` 0.76 with nothing to tune (`make bench
    SUITE=smoothers` and `SUITE=live`). Take this filter where things rest most of the time, or in
    programs that must be small.

    Args:
        min_cutoff_hz: cut-off at rest.
        beta_per_rad: cut-off that is gained for a rotation of 1 rad/s, in Hz; less smooths and lags
            more.
        beta_per_m: the same for a translation of 1 m/s.
        beta_scale: the same for a growth of 1 a second, of the scale's logarithm where the
            representation is "similarity"; rigid poses have none.
        derivative_cutoff_hz: cut-off of the speed's low-pass. This and `min_cutoff_hz` must lie
            below half the sampling rate, which only a whole trajectory tells: `smooth` refuses
            them, `update` does not.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, a beta that is negative, or an unknown
            representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import OneEuro
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = OneEuro(min_cutoff_hz=1.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        0.1 cm behind
    """

    _cutoffs_hz = ("min_cutoff_hz", "derivative_cutoff_hz")

    def __init__(
        self,
        min_cutoff_hz: float = 1.0,
        beta_per_rad: float = 100.0,
        beta_per_m: float = 100.0,
        beta_scale: float = 100.0,
        derivative_cutoff_hz: float = 1.0,
        representation: str = "motor",
    ) -> None:
        self.min_cutoff_hz = checked_positive(min_cutoff_hz, "min_cutoff_hz", "Hz")
        self.beta_per_rad = _checked_beta(beta_per_rad, "beta_per_rad")
        self.beta_per_m = _checked_beta(beta_per_m, "beta_per_m")
        self.beta_scale = _checked_beta(beta_scale, "beta_scale")
        self.derivative_cutoff_hz = checked_positive(
            derivative_cutoff_hz, "derivative_cutoff_hz", "Hz"
        )
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        slopes = (self.beta_per_rad, self.beta_per_m, self.beta_scale)
        return _scans.one_euro(
            self._averaged_as.compiled, scale, self.min_cutoff_hz, slopes, self.derivative_cutoff_hz
        )


def _checked_beta(value: float, name: str) -> float:
    if not (isfinite(value) and value >= 0.0):
        raise ValueError(f"{name}: expected a number of at least 0, got {value}")
    return float(value)


one_euro = FilterMethod(OneEuro)
"""`OneEuro` over a whole trajectory."""
