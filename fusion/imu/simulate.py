"""An IMU simulated along a path: what the sensor would have read, with its noise and its faults.

The simulated sensor rides on a path in continuous time, see `ContinuousPath`.

Readings pass through the sensor's faults in the order of the hardware: the path is felt a delay
late, through the sensor's own low-pass filter, with the vibration that it leaves; the axes turn,
mix and scale what is felt; biases and noise are added, the amplifier saturates, the converter
rounds, and the wire loses samples and blurs their stamps.

Angular rate and acceleration are exact derivatives of the path, so there is no error of
differencing. The world has z up; an accelerometer at rest reads +g upward.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.continuous_path import ContinuousPath
from motorcade.fusion.imu.faults import PERFECT, ImuFaults
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.sensor import Readings, SimulatedSensor
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.imu.vibration import VibrationSpectrum
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.ga.stamps import check_count, checked_rate, checked_span_ns

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
        path, rate_hz, noise, rng, checked_positive(gravity_m_s2, "gravity_m_s2"), faults, vibration
    )
    offset_ns = checked_span_ns(time_offset_s, "time_offset_s")
    return _simulated(Readings.joined(list(sensor.blocks())), path, offset_ns)


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
        path, rate_hz, noise, rng, checked_positive(gravity_m_s2, "gravity_m_s2"), faults, vibration
    )
    offset_ns = checked_span_ns(time_offset_s, "time_offset_s")
    return (_simulated(readings, path, offset_ns) for readings in _cut(sensor.blocks(), chunk_size))


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
    return sum((last - first) * rate_hz for first, last in path.stretches_s)


def _simulated(readings: Readings, path: ContinuousPath, offset_ns: int) -> SimulatedImu:
    return SimulatedImu(
        ImuStream(
            readings.time_ns + offset_ns, readings.angular_rate_rad_s, readings.specific_force_m_s2
        ),
        readings.gyro_bias_rad_s,
        readings.accel_bias_m_s2,
        Trajectory(readings.true_ns, Motor(readings.pose), path.parent, path.child),
        readings.velocity_m_s,
    )


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
