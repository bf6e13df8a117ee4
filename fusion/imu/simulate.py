"""An IMU simulated along a path: what the sensor would have read, with its noise and its faults.

The simulated sensor rides on a path in continuous time, see `ContinuousPath`.

Readings pass through the sensor's faults in the order of the hardware: the path is felt a delay
late, through the sensor's own low-pass filter, with the vibration that it leaves; the axes turn,
mix and scale what is felt; biases and noise are added, the amplifier saturates, the converter
rounds, and the wire loses samples and blurs their stamps.

Angular rate and acceleration are exact derivatives of the path, so there is no error of
differencing. The world has z up; an accelerometer at rest reads +g upward.

Simulated camera poses stand in for a tracker where there is ground truth but no images. What goes
wrong beyond noise is a degradation: outliers, blackouts, stamps that are late, or several in turn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from motorcade.fusion.imu.continuous_path import ContinuousPath
from motorcade.fusion.imu.faults import PERFECT, ImuFaults
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.imu.vibration import (
    BiasWalk,
    Flicker,
    LowPass,
    VibrationNoise,
    VibrationSpectrum,
    WhiteNoise,
    own_generator,
    reserve_losses,
)
from motorcade.fusion.motions.degradations import Degradation
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.motion import SplineSample, sampled_motion
from motorcade.ga.stamps import check_count, checked_rate, checked_span_ns, stamps_at_rate
from motorcade.tracking.measurements import PoseMeasurements

MOST_STREAMED = 10**9
"""Samples that a simulation in chunks may have: eleven days at 1 kHz."""


@dataclass(frozen=True, eq=False)
class SimulatedImu:
    """A simulated stream and its ground truth, sample by sample ``(N,)``.

    Fields:
        stream: what the sensor reads, at stamps of its own clock.
        gyro_bias_rad_s, accel_bias_m_s2: the true biases ``(N, 3)``: first ones, walks, flicker
            and what warming adds.
        path: the true poses ``world_T_imu`` when samples were taken, at stamps of the path's
            clock: those of the stream less its time offset and jitter.
        velocity_m_s: the true velocity in the world ``(N, 3)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> sensor.stream
        ImuStream(301 samples, 100.0 Hz, 3.000 s)
        >>> sensor.path
        Trajectory(world_T_imu, 301 poses, 3.000 s)
    """

    stream: ImuStream
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    path: Trajectory
    velocity_m_s: FloatArray


def simulate_imu(
    world_T_imu: Trajectory | ContinuousPath,
    rate_hz: float,
    noise: ImuNoise | tuple[ImuNoise, ...] | None,
    rng: np.random.Generator,
    gravity_m_s2: float = 9.81,
    knot_spacing_s: float = 0.1,
    *,
    faults: ImuFaults = PERFECT,
    vibration: VibrationSpectrum | None = None,
    imu_T_child: Motor | None = None,
    time_offset_s: float = 0.0,
) -> SimulatedImu:
    """Simulate an IMU that moves along `world_T_imu`, or is bolted to what does.

    Args:
        world_T_imu: poses, two or more, or a path; world z up.
        rate_hz: samples a second, from the first stamp to the last; none where gaps split the
            path, see `ContinuousPath.through`.
        noise: white noise σ/√Δt and bias walks σ_b√Δt (Kalibr), of all axes or of x, y and z; None
            for none.
        rng: source of the noise; the same seed gives the same bytes.
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        knot_spacing_s: knots of the spline through poses, see `ContinuousPath.through`.
        faults: scale, misalignment, biases and their drift, filters and delays, range, steps,
            jitter and losses.
        vibration: what shakes the sensor besides; its poses stay those of the path.
        imu_T_child: where the poses are those of a camera or a vehicle: that frame in the IMU's
            axes (``imu_T_camera``); None where they are the IMU's own.
        time_offset_s: what the IMU's clock shows more than that of the poses, Kalibr's
            ``t_imu = t_camera + offset``; rounded to nanoseconds.

    Raises:
        ValueError: a rate, gravity or spacing that is not positive, an offset of more than thirty
            years, a rate or losses that leave fewer than two samples or make more than ten
            million, filters and jitter that the rate is too low for, a single pose, or motion too
            fast for the knots.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> sensor.stream
        ImuStream(301 samples, 100.0 Hz, 3.000 s)
    """
    path = _as_path(world_T_imu, rate_hz, knot_spacing_s, imu_T_child)
    check_count(_count(path, rate_hz), f"rate_hz of {rate_hz:g}")
    sensor = SimulatedSensor(
        path, rate_hz, noise, rng, gravity_m_s2, faults, vibration, time_offset_s
    )
    return sensor.simulated(Readings.joined(list(sensor.blocks())))


def simulate_imu_in_chunks(
    world_T_imu: Trajectory | ContinuousPath,
    rate_hz: float,
    noise: ImuNoise | tuple[ImuNoise, ...] | None,
    rng: np.random.Generator,
    gravity_m_s2: float = 9.81,
    knot_spacing_s: float = 0.1,
    *,
    faults: ImuFaults = PERFECT,
    vibration: VibrationSpectrum | None = None,
    imu_T_child: Motor | None = None,
    time_offset_s: float = 0.0,
    chunk_size: int = 1 << 15,
) -> Iterator[SimulatedImu]:
    """As `simulate_imu`, but in chunks, so that memory does not grow with the length.

    Chunks one after another are what `simulate_imu` gives, to the last bit, whatever their size;
    `chunk_size` counts the samples in each, at least 2, but for the last, which holds what is left.

    Raises:
        ValueError: as `simulate_imu`, before the first chunk is asked for; but up to a billion
            samples may be made.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion.imu import simulate_imu_in_chunks
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> rng = np.random.default_rng(0)
        >>> chunks = simulate_imu_in_chunks(path, 100.0, ADIS16448, rng, chunk_size=120)
        >>> [len(chunk.stream) for chunk in chunks]
        [120, 120, 61]
    """
    if chunk_size < 2:
        raise ValueError(f"chunk_size: expected at least 2 samples, got {chunk_size}")
    path = _as_path(world_T_imu, rate_hz, knot_spacing_s, imu_T_child)
    if not _count(path, rate_hz) <= MOST_STREAMED:
        raise ValueError(
            f"rate_hz of {rate_hz:g}: expected at most {MOST_STREAMED} samples, got "
            f"{_count(path, rate_hz):.6g}; choose a lower rate or a shorter time"
        )
    sensor = SimulatedSensor(
        path, rate_hz, noise, rng, gravity_m_s2, faults, vibration, time_offset_s
    )
    return map(sensor.simulated, _cut(sensor.blocks(), chunk_size))


def _as_path(
    path: Trajectory | ContinuousPath,
    rate_hz: float,
    knot_spacing_s: float,
    imu_T_child: Motor | None,
) -> ContinuousPath:
    checked_rate(checked_positive(rate_hz, "rate_hz"), "rate_hz")
    if isinstance(path, Trajectory):
        path = ContinuousPath.through(path, knot_spacing_s)
    return path if imu_T_child is None else path.seen_from(imu_T_child)


def _count(path: ContinuousPath, rate_hz: float) -> float:
    return sum((last - first) * rate_hz for first, last in path.segments_s)


def _cut(blocks: Iterator[Readings], size: int) -> Iterator[Readings]:
    """The same readings in parts of `size`; the last has two or more, and at most one above."""
    waiting: list[Readings] = []
    count = 0
    for block in blocks:
        waiting.append(block)
        count += len(block)
        if count < size + 2:
            continue
        joined, first = Readings.joined(waiting), 0
        while count >= size + 2:
            yield joined[first : first + size]
            first, count = first + size, count - size
        waiting = [joined[first:]]
    yield Readings.joined(waiting)


BLOCK = 1 << 13
"""Samples that are made at a time: as many as stay in a processor's cache."""
_JITTER_CUT = 0.4


@dataclass(frozen=True, eq=False)
class Readings:
    """Samples with all that is known of them, ``(n,)`` or ``(n, *)``."""

    time_ns: IntArray
    angular_rate_rad_s: FloatArray
    specific_force_m_s2: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    true_ns: IntArray
    pose: FloatArray
    velocity_m_s: FloatArray

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, part: slice | IntArray) -> Readings:
        return Readings(*(getattr(self, field.name)[part] for field in fields(self)))

    @staticmethod
    def joined(parts: list[Readings]) -> Readings:
        """One after another."""
        if len(parts) == 1:
            return parts[0]
        names = [field.name for field in fields(Readings)]
        return Readings(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in names)
        )


class SimulatedSensor:
    """An IMU on a path, with noise and faults as of `simulate_imu`; to be read once.

    Raises:
        ValueError: fewer than two samples, by the rate or by losses; filters or jitter that the
            rate is too low for.
    """

    def __init__(
        self,
        path: ContinuousPath,
        rate_hz: float,
        noise: ImuNoise | tuple[ImuNoise, ...] | None,
        rng: np.random.Generator,
        gravity_m_s2: float,
        faults: ImuFaults,
        vibration: VibrationSpectrum | None,
        time_offset_s: float,
    ) -> None:
        _check_rate(faults, rate_hz)
        self._path, self._faults = path, faults
        self._gravity = checked_positive(gravity_m_s2, "gravity_m_s2")
        self._offset_ns = checked_span_ns(time_offset_s, "time_offset_s")
        self._stamps = _EvenStamps(path, rate_hz)
        self._step_ns = 1e9 / rate_hz
        count = self._stamps.count
        walks, white = _noise_terms(noise, 1.0 / rate_hz, count, rng)
        self._losses: np.random.Generator | None = None
        if faults.dropped_share > 0.0:
            self._losses, kept = reserve_losses(rng, count, faults.dropped_share)
            if kept < 2:
                raise ValueError(
                    "ImuFaults.dropped_share: expected two samples or more to be left of "
                    f"{count}, got a share of {faults.dropped_share}"
                )
        flicker = [
            Flicker(np.asarray(b), rate_hz, path.duration_s, rng) if np.any(b) else None
            for b in (faults.gyro_flicker_rad_s, faults.accel_flicker_m_s2)
        ]
        drifts = (
            (faults.gyro_bias_rad_s, faults.gyro_bias_rad_s_k, faults.gyro_scale_k),
            (faults.accel_bias_m_s2, faults.accel_bias_m_s2_k, faults.accel_scale_k),
        )
        self._errors = [
            _Errors(np.asarray(bias), np.asarray(bias_k), np.asarray(scale_k), *noises)
            for (bias, bias_k, scale_k), noises in zip(
                drifts, zip(walks, flicker, white, strict=True), strict=True
            )
        ]
        self._jitter = own_generator(rng) if faults.stamp_jitter_s > 0.0 else None
        cutoffs = faults.gyro_lowpass_hz, faults.accel_lowpass_hz
        self._vibration = None
        if vibration is not None:
            self._vibration = VibrationNoise(vibration, rate_hz, cutoffs, BLOCK, rng)
        self._lowpass = [LowPass(hz, rate_hz) if np.isfinite(hz) else None for hz in cutoffs]

    def simulated(self, readings: Readings) -> SimulatedImu:
        """Readings as the sensor's clock stamps them, and their ground truth."""
        stamps, path = readings.time_ns + self._offset_ns, self._path
        return SimulatedImu(
            ImuStream(stamps, readings.angular_rate_rad_s, readings.specific_force_m_s2),
            readings.gyro_bias_rad_s,
            readings.accel_bias_m_s2,
            Trajectory(readings.true_ns, Motor(readings.pose), path.parent, path.child),
            readings.velocity_m_s,
        )

    def blocks(self) -> Iterator[Readings]:
        """All readings, in blocks that may be empty where samples were lost."""
        for first in range(0, self._stamps.count, BLOCK):
            yield self._block(first, min(self._stamps.count, first + BLOCK))

    def _block(self, first: int, last: int) -> Readings:
        faults = self._faults
        true_ns, opened_ns, begins = self._stamps.between(first, last)
        exact = self._at(true_ns, opened_ns, 0.0)
        felt = self._felt(exact, true_ns, opened_ns, begins)
        since_ns = (true_ns - self._path.start_ns).astype(np.float64)
        warmed_k = faults.warmed_k(1e-9 * since_ns)
        (rate, gyro_bias), (force, accel_bias) = (
            errors.added(signal, true_ns, warmed_k)
            for errors, signal in zip(self._errors, felt, strict=True)
        )
        readings = Readings(
            self._stamped(true_ns), faults.converted_rate(rate), faults.converted_force(force),
            gyro_bias, accel_bias, true_ns, exact.pose.coefficients, exact.world_velocity_m_s,
        )  # fmt: skip
        if self._losses is None:
            return readings
        return readings[np.flatnonzero(self._losses.random(len(true_ns)) >= faults.dropped_share)]

    def _at(self, true_ns: IntArray, opened_ns: IntArray, delay_s: float) -> SplineSample:
        """The motion so long before stamps ``(n,)``, but not before their segments' starts."""
        late_ns = np.maximum(true_ns - round(delay_s * 1e9), opened_ns)
        seconds = np.minimum((late_ns - self._path.start_ns) * 1e-9, self._path.duration_s)
        return sampled_motion(self._path.twists(seconds))

    def _felt(
        self, exact: SplineSample, true_ns: IntArray, opened_ns: IntArray, begins: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """Angular rate and specific force ``(n, 3)`` in the sensor's axes, through its filters."""
        faults = self._faults
        delays = faults.gyro_delay_s, faults.accel_delay_s
        moved = [self._at(true_ns, opened_ns, late) if late > 0.0 else exact for late in delays]
        rate = moved[0].body_angular_rate_rad_s @ faults.gyro_matrix.T
        force = specific_force_m_s2(moved[1], self._gravity)
        sensitivity = np.asarray(faults.gyro_g_sensitivity_rad_s_m)
        if np.any(sensitivity):
            rate += specific_force_m_s2(moved[0], self._gravity) @ sensitivity.T
        rate, force = (
            signal if lowpass is None else lowpass.block(signal, begins)
            for signal, lowpass in zip((rate, force), self._lowpass, strict=True)
        )
        if self._vibration is not None:
            vibrating = self._vibration.block()[: len(true_ns)]
            rate += vibrating[:, :3] @ faults.gyro_matrix.T + vibrating[:, 3:] @ sensitivity.T
            force = force + vibrating[:, 3:]
        return rate, force @ faults.accel_matrix.T

    def _stamped(self, true_ns: IntArray) -> IntArray:
        """What the stamps show of when samples were taken."""
        if self._jitter is None:
            return true_ns
        drawn = self._faults.stamp_jitter_s * 1e9 * self._jitter.standard_normal(len(true_ns))
        cut = _JITTER_CUT * self._step_ns
        return true_ns + np.trunc(np.clip(drawn, -cut, cut)).astype(np.int64)


def specific_force_m_s2(motion: SplineSample, gravity_m_s2: float) -> FloatArray:
    """What a perfect accelerometer reads ``(*, 3)``: acceleration minus gravity, in its axes."""
    up = np.array([0.0, 0.0, gravity_m_s2])
    return motion.pose.rotor.inverse().apply(motion.world_acceleration_m_s2 + up)


@dataclass(frozen=True, eq=False)
class _Errors:
    """What the gyroscope or the accelerometer makes of what it feels."""

    bias: FloatArray
    bias_k: FloatArray
    scale_k: FloatArray
    walk: BiasWalk | None
    flicker: Flicker | None
    white: WhiteNoise | None

    def added(
        self, felt: FloatArray, true_ns: IntArray, warmed_k: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Readings and true biases ``(n, 3)`` at the next stamps."""
        bias = np.tile(self.bias, (len(true_ns), 1))
        if self.walk is not None:
            bias += self.walk.block(true_ns)
        if self.flicker is not None:
            bias += self.flicker.block(len(true_ns))
        if np.any(warmed_k):
            bias += warmed_k[:, None] * self.bias_k
            felt = felt * (1.0 + warmed_k[:, None] * self.scale_k)
        reading = felt + bias
        if self.white is not None:
            reading += self.white.block(len(true_ns))
        return reading, bias


def _noise_terms(
    noise: ImuNoise | tuple[ImuNoise, ...] | None,
    step_s: float,
    count: int,
    rng: np.random.Generator,
) -> tuple[list[BiasWalk | None], list[WhiteNoise | None]]:
    """Walks and white noise of the gyroscope and of the accelerometer."""
    if noise is None:
        return [None, None], [None, None]
    axes = (noise,) * 3 if isinstance(noise, ImuNoise) else noise
    if len(axes) != 3:
        raise ValueError(f"noise: expected that of all axes, or of three, got {len(axes)}")
    gyro, gyro_walk, accel, accel_walk = (
        np.array([getattr(axis, field.name) for axis in axes]) for field in fields(ImuNoise)
    )
    return (
        [BiasWalk(one, step_s, count, rng) for one in (gyro_walk, accel_walk)],
        [WhiteNoise(one, step_s, count, rng) for one in (gyro, accel)],
    )


def _check_rate(faults: ImuFaults, rate_hz: float) -> None:
    for name in ("gyro_lowpass_hz", "accel_lowpass_hz"):
        cutoff_hz = getattr(faults, name)
        if np.isfinite(cutoff_hz) and not cutoff_hz < 0.5 * rate_hz:
            raise ValueError(
                f"ImuFaults.{name}: expected less than half the rate of {rate_hz:g} Hz, or "
                f"infinity, got {cutoff_hz:g}"
            )
    if not faults.stamp_jitter_s <= 0.25 / rate_hz:
        raise ValueError(
            f"ImuFaults.stamp_jitter_s: expected at most a quarter of the interval of "
            f"{1.0 / rate_hz:g} s, got {faults.stamp_jitter_s:g}"
        )


class _EvenStamps:
    """Even stamps in every segment of a path, from its start on, without a list of them."""

    def __init__(self, path: ContinuousPath, rate_hz: float) -> None:
        spans = np.array(path.segments_s)
        self._step_ns = 1e9 / rate_hz
        self._opened_ns = path.start_ns + np.round(spans[:, 0] * 1e9).astype(np.int64)
        self._length_ns = np.round((spans[:, 1] - spans[:, 0]) * 1e9).astype(np.int64)
        counts = np.floor((spans[:, 1] - spans[:, 0]) * rate_hz + 1e-6).astype(np.int64) + 1
        self._first = np.concatenate([[0], np.cumsum(counts)])
        self.count = int(self._first[-1])
        if self.count < 2:
            expected = f"expected two samples or more within {path.duration_s} s"
            raise ValueError(f"rate_hz: {expected}, got {rate_hz} Hz")

    def between(self, first: int, last: int) -> tuple[IntArray, IntArray, IntArray]:
        """Stamps ``(n,)`` from one number to before another, and the starts of their segments.

        The third are the indices of those that open a segment.
        """
        number = np.arange(first, last)
        segment = np.searchsorted(self._first, number, side="right") - 1
        within = number - self._first[segment]
        offsets = np.round(within * self._step_ns).astype(np.int64)
        opened_ns: IntArray = self._opened_ns[segment]
        stamps = opened_ns + np.minimum(offsets, self._length_ns[segment])
        return stamps, opened_ns, np.flatnonzero(within == 0)


_MOST = 1e9  # of any of the numbers, whose squares are covariances


def simulate_camera_poses(
    truth: Trajectory,
    rate_hz: float,
    sigma_m: float,
    sigma_rad: float,
    rng: np.random.Generator,
    degradation: Degradation | None = None,
) -> PoseMeasurements:
    """Measure `truth` at `rate_hz` with independent Gaussian errors in the camera's axes.

    Args:
        truth: ``world_T_camera``; between its stamps it follows the screw.
        rate_hz: measurements a second, from the first stamp of `truth` to its last, but none in
            gaps of more than ten seconds (see `motorcade.ga.stamps`).
        sigma_m: deviation of the position an axis, above zero.
        sigma_rad: deviation of the rotation an axis; both also make the measurements' covariance.
        rng: source of the errors.
        degradation: what happens to the noisy poses besides, such as
            ``InTurn((Outliers(0.02, 0.5, 0.5), Blackouts(2.0, 15.0), Latency(0.02)))``; the
            covariances do not tell of it.

    Raises:
        ValueError: a rate or deviation that is not positive, or a rate that makes more than
            50,000 poses and 500 more a pose of `truth`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> measured.trajectory
        Trajectory(world_T_imu, 61 poses, 3.000 s)
    """
    for name, value in (("rate_hz", rate_hz), ("sigma_m", sigma_m), ("sigma_rad", sigma_rad)):
        if checked_positive(value, name) > _MOST:
            raise ValueError(f"{name}: expected at most {_MOST:g}, got {value}")
    stamps = stamps_at_rate(truth.time_ns, rate_hz, "rate_hz")
    sigma = np.repeat([sigma_rad, sigma_m], 3)
    noise = Motor.from_twist(sigma * rng.standard_normal((len(stamps), 6)))
    measured = truth.resampled(stamps).transformed_by(right=noise)
    if degradation is not None:
        measured = degradation.apply(measured, rng)
    return PoseMeasurements(measured, np.tile(np.diag(sigma**2), (len(measured), 1, 1)))
