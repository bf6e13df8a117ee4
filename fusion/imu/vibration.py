"""Vibration of what carries an IMU: its spectrum, given or learnt, and noise that has it.

A term of the noise keeps between blocks what it needs, so that blocks one after another are what
one long block would be. Each draws from a generator of its own, so that no term's numbers depend on
another's.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen

MOTION_HZ = 10.0
"""Hands, heads and vehicles move below; what is read above is vibration. Voluntary motion of a hand
ends near 5 Hz, its tremor lies at 8 to 12 Hz (R. Stiles, J. Appl. Physiol. 40, 1976)."""
_RESOLUTION_HZ = 1.0  # fine enough to keep the tones of rotors apart
_FEWEST_WINDOWS = 8
_LONGEST_KERNEL = 1 << 14
_FIELDS = ("gyro_rad2_s2_hz", "accel_m2_s4_hz")


@dataclass(frozen=True, eq=False)
class VibrationSpectrum:
    """One-sided power spectral densities of what vibration adds to an IMU's readings.

    Between the frequencies densities run straight; outside them there is no vibration. The axes
    vibrate independently, and the pose of what carries the IMU is not changed.

    Args:
        frequency_hz: ``(K,)`` increasing, from 0 on, K at least 2.
        gyro_rad2_s2_hz: ``(K, 3)`` of the angular rate, (rad/s)²/Hz.
        accel_m2_s4_hz: ``(K, 3)`` of the specific force, (m/s²)²/Hz.

    Raises:
        ValueError: other shapes, NaN or infinity, frequencies that do not increase, negative
            densities.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.imu import VibrationSpectrum
        >>> rotors = np.array([[0.0], [0.0], [0.01], [0.0]]) * np.ones(3)
        >>> shake = VibrationSpectrum([0.0, 70.0, 80.0, 90.0], 1e-4 * rotors, rotors)
        >>> shake.accel_rms_m_s2.round(3)
        array([0.316, 0.316, 0.316])
    """

    frequency_hz: FloatArray
    gyro_rad2_s2_hz: FloatArray
    accel_m2_s4_hz: FloatArray

    def __post_init__(self) -> None:
        hz = checked_floats(self.frequency_hz, "VibrationSpectrum.frequency_hz", ())
        if hz.ndim != 1 or hz.size < 2 or hz[0] < 0.0 or np.any(np.diff(hz) <= 0.0):
            raise ValueError(
                "VibrationSpectrum.frequency_hz: expected two or more that increase, from 0 on, "
                f"got shape {hz.shape}"
            )
        object.__setattr__(self, "frequency_hz", frozen(hz))
        for name in _FIELDS:
            values = checked_floats(getattr(self, name), f"VibrationSpectrum.{name}", (3,))
            if values.shape != (hz.size, 3) or np.any(values < 0.0):
                raise ValueError(
                    f"VibrationSpectrum.{name}: expected shape {(hz.size, 3)} and no number below "
                    f"0, got {values.shape} and {np.min(values, initial=0.0):g}"
                )
            object.__setattr__(self, name, frozen(values))

    @classmethod
    def learnt(
        cls, imu: ImuStream, above_hz: float = MOTION_HZ, noise: ImuNoise | None = None
    ) -> VibrationSpectrum:
        """The spectrum of a recording above the frequencies of motion, by Welch's method.

        It holds whatever the sensor's filter left, and ends at half the recording's rate: what
        vibrates faster was folded below it. Samples are taken as even.

        Args:
            imu: a recording in motion; its longest segment without gaps is used.
            above_hz: what is slower is taken for motion and left out.
            noise: white noise of the sensor that is not vibration, and is taken off; None for none.

        Raises:
            ValueError: `above_hz` not between 0 and half the rate, or fewer than eight windows of
                a second without a gap.

        Examples:
            >>> import numpy as np
            >>> from motorcade.fusion import ImuStream
            >>> from motorcade.fusion.imu import VibrationSpectrum
            >>> shaken = np.random.default_rng(0).normal(0.0, 0.5, (4000, 2, 3))
            >>> imu = ImuStream(5_000_000 * np.arange(4000), 0.1 * shaken[:, 0], shaken[:, 1])
            >>> VibrationSpectrum.learnt(imu, above_hz=60.0).accel_rms_m_s2.round(1)
            array([0.3, 0.3, 0.3])
        """
        from scipy.signal import welch

        rate_hz = imu.rate_hz
        if not 0.0 <= above_hz < 0.5 * rate_hz:
            raise ValueError(
                f"above_hz: expected from 0 to {0.5 * rate_hz:g} Hz, half the recording's rate, "
                f"got {above_hz}"
            )
        part = _longest_even(imu)
        window = 2 ** int(np.ceil(np.log2(rate_hz / _RESOLUTION_HZ)))
        if part.stop - part.start < _FEWEST_WINDOWS * window:
            raise ValueError(
                f"imu: expected {_FEWEST_WINDOWS * window / rate_hz:.0f} s without a gap to learn "
                f"its vibration from, got {(part.stop - part.start) / rate_hz:.1f} s"
            )
        spectra = []
        for values, density in (
            (imu.angular_rate_rad_s, noise.gyro_density_rad_s_rthz if noise else 0.0),
            (imu.specific_force_m_s2, noise.accel_density_m_s2_rthz if noise else 0.0),
        ):
            hz, power = welch(values[part], rate_hz, nperseg=window, axis=0)
            power = np.maximum(power - 2.0 * density**2, 0.0)
            power[[0, -1]] = power[[1, -2]]  # bins that hold half the power
            power[hz < above_hz] = 0.0
            spectra.append(power)
        return cls(hz, *spectra)

    @property
    def gyro_rms_rad_s(self) -> FloatArray:
        """``(3,)`` root of the mean square of the vibration."""
        return np.sqrt(np.trapezoid(self.gyro_rad2_s2_hz, self.frequency_hz, axis=0))

    @property
    def accel_rms_m_s2(self) -> FloatArray:
        """``(3,)`` root of the mean square of the vibration."""
        return np.sqrt(np.trapezoid(self.accel_m2_s4_hz, self.frequency_hz, axis=0))


def _longest_even(imu: ImuStream) -> slice:
    """The longest run of samples without a step of more than one and a half median steps."""
    steps = np.diff(imu.time_ns)
    edges = np.flatnonzero(steps > 1.5 * np.median(steps)) + 1
    edges = np.concatenate([[0], edges, [len(imu)]])
    longest = int(np.argmax(np.diff(edges)))
    return slice(int(edges[longest]), int(edges[longest + 1]))


class VibrationNoise:
    """Noise of a given spectrum: white noise through a filter of its square root, in blocks.

    Args:
        spectrum: of the vibration.
        rate_hz: at which it is sampled; what vibrates faster than half of it is folded below.
        lowpass_hz: of the gyroscope's and of the accelerometer's own filter, which comes first.
        block: values that are made at a time.
        rng: seeds the noise.
    """

    def __init__(
        self,
        spectrum: VibrationSpectrum,
        rate_hz: float,
        lowpass_hz: tuple[float, float],
        block: int,
        rng: np.random.Generator,
    ):
        finest_hz = float(np.min(np.diff(spectrum.frequency_hz)))
        # Two points of the filter's response between two of the spectrum.
        wanted = 2.0 * rate_hz / finest_hz
        length = 2 ** int(np.ceil(np.log2(np.clip(wanted, 64, _LONGEST_KERNEL))))
        hz: FloatArray = np.arange(length // 2 + 1) * (rate_hz / length)
        power = np.concatenate(
            [
                _folded(spectrum.frequency_hz, getattr(spectrum, name), cutoff_hz, hz, rate_hz)
                for name, cutoff_hz in zip(_FIELDS, lowpass_hz, strict=True)
            ]
        )
        # Even about its middle; white noise of deviation one has the density 2 / rate.
        response = np.fft.irfft(np.sqrt(0.5 * rate_hz * power), axis=-1)
        kernel = np.roll(response, length // 2, axis=-1)
        self._rng, self._size = own_generator(rng), block + length - 1
        self._response = np.fft.rfft(kernel, self._size, axis=-1)
        self._white = self._rng.standard_normal((length - 1, 6)).T
        self._block = block

    def block(self) -> FloatArray:
        """The next values ``(block, 6)``, of angular rate and specific force."""
        fresh = self._rng.standard_normal((self._block, 6)).T
        white = np.concatenate([self._white, fresh], axis=-1)
        self._white = white[:, self._block :]
        block = np.fft.irfft(np.fft.rfft(white, axis=-1) * self._response, self._size, axis=-1)
        return block[:, -self._block :].T


def _folded(
    known_hz: FloatArray, density: FloatArray, cutoff_hz: float, hz: FloatArray, rate_hz: float
) -> FloatArray:
    """Densities ``(3, M)`` at `hz`, up to half the rate, of what a filter leaves and is sampled."""
    total = np.zeros((3, len(hz)))
    for fold in range(int(known_hz[-1] / rate_hz + 0.5) + 1):
        for beyond in {fold * rate_hz, -fold * rate_hz}:
            faster = np.abs(hz + beyond)
            passed = 1.0 / (1.0 + (faster / cutoff_hz) ** 4)
            for axis, column in enumerate(density.T):
                total[axis] += passed * np.interp(faster, known_hz, column, left=0.0, right=0.0)
    return total


_DRAWN = 1 << 16
# Flicker: a pole every two octaves, a zero between two poles, from half the rate down to where the
# recording is a tenth of a period. The spectrum is then 1/f to 2 % up to a tenth of the rate, 17 %
# above it at a third, where white noise covers it.
_POLE_RATIO = 4.0
_HIGHEST_POLE, _LOWEST_PERIODS = 0.5, 0.1


def reserve_normals(rng: np.random.Generator, count: int) -> np.random.Generator:
    """A generator that gives the next `count` normal numbers of `rng`, which is moved past them."""
    here = deepcopy(rng)
    place = np.empty(min(count, _DRAWN))
    for first in range(0, count, _DRAWN):
        rng.standard_normal(out=place[: min(_DRAWN, count - first)])
    return here


def reserve_losses(
    rng: np.random.Generator, count: int, dropped_share: float
) -> tuple[np.random.Generator, int]:
    """As `reserve_normals` for a number in [0, 1) a sample; and how many samples are not lost."""
    here, kept = deepcopy(rng), 0
    for first in range(0, count, _DRAWN):
        drawn = rng.random(min(_DRAWN, count - first))
        kept += int(np.count_nonzero(drawn >= dropped_share))
    return here, kept


def own_generator(rng: np.random.Generator) -> np.random.Generator:
    """A new generator, seeded by `rng`."""
    return np.random.default_rng(rng.integers(0, 2**63, 4))


class BiasWalk:
    """A random walk from zero; through a gap it goes on for as long as it lasts."""

    def __init__(self, density: FloatArray, step_s: float, count: int, rng: np.random.Generator):
        self._density, self._step_s = density, step_s
        self._rng = reserve_normals(rng, 3 * (count - 1))
        self._last: FloatArray | None = None
        self._last_ns = 0

    def block(self, time_ns: IntArray) -> FloatArray:
        """Its values ``(n, 3)`` at the next stamps."""
        begins = self._last is None
        last = np.zeros(3) if self._last is None else self._last
        steps = self._density * np.sqrt(self._step_s)
        steps = steps * self._rng.standard_normal((len(time_ns) - begins, 3))
        earlier = time_ns[:1] if begins else np.array([self._last_ns])
        longer = np.diff(np.concatenate([earlier, time_ns[begins:]])) * (1e-9 / self._step_s)
        gaps = longer > 1.5
        steps[gaps] *= np.sqrt(longer[gaps])[:, None]
        values = np.cumsum(np.concatenate([last[None], steps]), axis=0)
        self._last, self._last_ns = values[-1].copy(), int(time_ns[-1])
        return values if begins else values[1:]


class WhiteNoise:
    """Independent normal numbers."""

    def __init__(self, density: FloatArray, step_s: float, count: int, rng: np.random.Generator):
        self._density, self._step_s = density, step_s
        self._rng = reserve_normals(rng, 3 * count)

    def block(self, count: int) -> FloatArray:
        """The next values ``(count, 3)``."""
        white: FloatArray = self._rng.standard_normal((count, 3)) / np.sqrt(self._step_s)
        white *= self._density
        return white


class Flicker:
    """Noise whose spectrum is 1/f, from zero: white noise through poles and zeros by turns.

    Source: M. Keshner, "1/f noise", Proceedings of the IEEE 70, 1982; a chain of first-order
    sections whose mean slope is half that of an integrator.
    """

    def __init__(
        self, instability: FloatArray, rate_hz: float, duration_s: float, rng: np.random.Generator
    ):
        lowest_hz = _LOWEST_PERIODS / duration_s
        octaves = np.log(_HIGHEST_POLE * rate_hz / lowest_hz) / np.log(_POLE_RATIO)
        poles_hz = _HIGHEST_POLE * rate_hz * _POLE_RATIO ** -np.arange(np.ceil(octaves) + 1)
        zeros_hz = poles_hz * np.sqrt(_POLE_RATIO)
        zero, pole = np.exp(-2.0 * np.pi * np.stack([zeros_hz, poles_hz]) / rate_hz)
        unit, none = np.ones_like(pole), np.zeros_like(pole)
        self._sections = np.stack([unit, -zero, none, unit, -pole, none], axis=-1)
        middle_hz = float(np.sqrt(np.prod(poles_hz[[0, -1]])))
        self._gain = np.asarray(instability) * self._unit_gain(rate_hz, middle_hz)
        self._state = np.zeros((len(poles_hz), 2, 3))
        self._rng = own_generator(rng)

    def _unit_gain(self, rate_hz: float, hz: float) -> float:
        """What white noise of deviation one wants for a spectrum B² / (π f) of B = 1, one-sided."""
        from scipy.signal import sosfreqz

        _, response = sosfreqz(self._sections, [hz], fs=rate_hz)
        return float(np.sqrt(rate_hz / (2.0 * np.pi * hz)) / np.abs(response[0]))

    def block(self, count: int) -> FloatArray:
        """The next values ``(count, 3)``."""
        from scipy.signal import sosfilt

        white = self._gain * self._rng.standard_normal((count, 3))
        filtered, self._state = sosfilt(self._sections, white, axis=0, zi=self._state)
        return np.asarray(filtered)


class LowPass:
    """A Butterworth filter of second order, settled on the first reading of each segment."""

    def __init__(self, cutoff_hz: float, rate_hz: float):
        from scipy.signal import butter, sosfilt_zi

        self._sections = butter(2, cutoff_hz, fs=rate_hz, output="sos")
        self._settled = sosfilt_zi(self._sections)[..., None]
        self._state: FloatArray = np.zeros((1, 2, 3))

    def block(self, readings: FloatArray, begins: IntArray) -> FloatArray:
        """The next readings ``(n, 3)`` filtered; `begins` are those that open a segment."""
        from scipy.signal import sosfilt

        opening = begins.tolist()
        edges = [0, *(at for at in opening if at > 0), len(readings)]
        parts = []
        for first, last in pairwise(edges):
            if first in opening:
                self._state = self._settled * readings[first]
            part, self._state = sosfilt(
                self._sections, readings[first:last], axis=0, zi=self._state
            )
            parts.append(part)
        return np.concatenate(parts)
