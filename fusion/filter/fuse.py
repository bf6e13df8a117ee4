"""`fuse`: camera poses and an IMU in, one trajectory with its uncertainty out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.health import fused_health
from motorcade.fusion.filter.native._filter import Engine
from motorcade.fusion.filter.pose_filter import KINDS
from motorcade.fusion.filter.settings import FilterSettings, engine
from motorcade.fusion.filter.sourced import Judgement, checked_also, judgements, schedule
from motorcade.fusion.health.stamps import check_stamps
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import Measurements
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements


def covered(measurements: PoseMeasurements, imu: ImuStream, shift_ns: int = 0) -> PoseMeasurements:
    """The measurements within the IMU's span, their stamps `shift_ns` later on its clock.

    Raises:
        ValueError: spans that do not overlap.
    """
    first, last = int(imu.time_ns[0]), int(imu.time_ns[-1])
    stamps = measurements.trajectory.time_ns + shift_ns
    inside = (stamps >= first) & (stamps <= last)
    if not np.any(inside):
        unit = check_stamps(stamps, imu.time_ns)
        raise ValueError(
            f"measurements and imu: expected spans that overlap, got {stamps[0]} to {stamps[-1]} "
            f"ns and {first} to {last} ns" + ("" if unit is None else f": {unit.summary}")
        )
    if np.all(inside):
        return measurements
    return PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])


def wanted_stamps(
    measured_ns: IntArray, imu: ImuStream, stamps_ns: IntArray | None = None
) -> IntArray:
    """The stamps asked for that lie between the first measurement and the IMU's end.

    Args:
        measured_ns: on the IMU's clock; all of them where no others are asked for.
        imu: whose span bounds the path.
        stamps_ns: rising integers.

    Raises:
        ValueError: stamps that are no rising integers, or none that can be served.
    """
    if stamps_ns is None:
        return measured_ns
    start, last = measured_ns[0], imu.time_ns[-1]
    given = np.asarray(stamps_ns)
    if given.dtype.kind != "i" or given.ndim != 1 or np.any(np.diff(given) <= 0):
        raise ValueError("stamps_ns: expected rising integer nanoseconds (M,), got others")
    wanted: IntArray = given[(given >= start) & (given <= last)].astype(np.int64)
    if wanted.size == 0:
        raise ValueError(f"stamps_ns: expected some within [{start}, {last}], got none")
    return wanted


def by_stretch(
    fused: Callable[[PoseMeasurements, ImuStream, IntArray | None], Fused],
    measurements: PoseMeasurements,
    imu: ImuStream,
    stamps_ns: IntArray | None,
    shift_ns: int = 0,
) -> Fused:
    """Fuse each stretch of a stream that gaps split for itself, and join the results.

    Raises:
        ValueError: what `fused` refuses, or no measurement in any stretch.
    """
    parts = imu.stretches()
    if len(parts) == 1:
        return fused(measurements, parts[0], stamps_ns)
    measured_ns = measurements.trajectory.time_ns + shift_ns
    wanted = measured_ns if stamps_ns is None else wanted_stamps(measured_ns, imu, stamps_ns)
    made = []
    for part in parts:
        first, last = part.time_ns[[0, -1]]
        inside = np.flatnonzero((measured_ns >= first) & (measured_ns <= last))
        if not inside.size:
            continue
        here = wanted[(wanted >= measured_ns[inside[0]]) & (wanted <= last)]
        if here.size:
            own = PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])
            made.append(fused(own, part, here))
    if not made:
        raise ValueError(
            f"measurements and imu: expected stamps in one of the {len(parts)} stretches between "
            "gaps of the imu, got none"
        )
    return made[0] if len(made) == 1 else Fused.joined(made)


_EXTRINSICS = slice(17, 23)


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused path and what was known along it, at N stamps.

    Fields:
        trajectory: ``world_T_camera``.
        velocity_m_s: ``(N, 3)`` of the IMU, in the world.
        gyro_bias_rad_s, accel_bias_m_s2: ``(N, 3)``.
        covariance: ``(N, 6, 6)`` of the camera pose, right perturbation, rotation (rad) first.
        state_covariance: ``(N, 15, 15)`` of the IMU's state: rotation (rad), position (m) and
            velocity (m/s) of the right perturbation, in the IMU's axes, then both biases. Where
            more is estimated ``(N, 24, 24)``: tilt of gravity (2, rad), right perturbation of
            `imu_T_camera` (6), time offset (s); variances of what is not estimated are zero. It has
            no rows where it was not asked for.
        nis: ``(N,)`` normalised innovations squared of the forward pass, six degrees of freedom;
            NaN where nothing was measured and at the start.
        accepted: ``(N,)`` false where a measurement was left out.
        gravity_m_s2: ``(N, 3)`` in the world.
        imu_T_camera: Motor ``(N,)``.
        time_offset_s: ``(N,)``; a camera's stamp plus this is the IMU's time.
        also: what became of the other kinds of measurements, in their order.
        given_up_ns: ``(K, 2)`` first and last stamps of spans in which a filter that runs live is
            wrong, as it knows afterwards: until it finds that the start was, that the map was
            relocated, or that what it took for a relocated map was not.
        health: whether IMU and poses belong together as stated, and what is wrong where not; it
            is written to the log besides.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import fuse
        >>> from motorcade.ga import Motor
        >>> fused = fuse(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> sigma_m = np.sqrt(np.einsum("nii->ni", fused.covariance)[:, 3:])
        >>> bool(np.all(sigma_m < 0.01)), fused.state_covariance.shape
        (True, (61, 15, 15))
    """

    trajectory: Trajectory
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    covariance: FloatArray
    state_covariance: FloatArray
    nis: FloatArray
    accepted: NDArray[np.bool_]
    gravity_m_s2: FloatArray
    imu_T_camera: Motor
    time_offset_s: FloatArray
    also: tuple[Judgement, ...] = ()
    given_up_ns: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    health: Health = field(default_factory=Health)

    @classmethod
    def joined(cls, parts: Sequence[Fused]) -> Fused:
        """One path of several, one after another."""
        first = parts[0].trajectory
        whole = {
            each.name: np.concatenate([getattr(one, each.name) for one in parts])
            for each in fields(cls)
            if each.name not in ("trajectory", "imu_T_camera", "also", "health")
        }
        poses = Motor.concatenate([one.trajectory.motors for one in parts])
        stamps = np.concatenate([one.trajectory.time_ns for one in parts])
        return cls(
            trajectory=Trajectory(stamps, poses, first.parent, first.child),
            imu_T_camera=Motor.concatenate([one.imu_T_camera for one in parts]),
            also=tuple(map(Judgement.joined, zip(*(one.also for one in parts), strict=True))),
            health=Health(),
            **whole,
        )


def fuse(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    smoothed: bool = True,
    time_offset_s: float = 0.0,
    state_covariances: bool = True,
) -> Fused:
    """Fuse measured camera poses with an IMU, by the code of `PoseFilter`.

    Inertial data are integrated at their full rate. Memory: about 1.5 kB a measurement, 0.9 kB a
    stamp asked for, and 1.8 or 4.6 kB more for its `state_covariance`; what the backward pass needs
    besides is made again, piece by piece. Where the world's z is not up the accelerometer
    contradicts the camera, and the tilt ends up in its bias as far as the motion allows, unless
    `FilterSettings.gravity_sigma_rad` is set.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. A gap in
            it is bridged by the line between the samples on both sides, with the uncertainty that
            `FilterSettings` states; a gap of more than ten seconds splits the stream, and each
            stretch is fused for itself: stamps between them are left out.
        noise: the IMU's densities and bias walks. Those of a data sheet are too small for a
            sensor in the hand or in flight; `ImuNoise.scaled` until the mean NIS is about 6.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: rising stamps of the IMU's clock at which the path is wanted, measured there or
            not; by default those of the measurements. Stamps before the first measurement or
            outside the IMU's span are left out.
        also: other kinds of measurements (`motorcade.fusion.measurements`), from the first pose on.
            Python predicts each, in about 50 µs, twice where `smoothed`.
        settings: gravity, gate, initial tilt error, what else to estimate.
        smoothed: look ahead as well (backward pass); without it every estimate knows only its
            past, as if it ran live, and `nis` and `accepted` are as judged live.
        time_offset_s: what is added to the measurements' stamps to be the IMU's time; a first
            guess where `FilterSettings.time_offset_sigma_s` is above zero.
        state_covariances: without them the result's `state_covariance` has no rows.

    Raises:
        ValueError: the IMU and the measurements do not overlap in time, or `stamps_ns` are no
            rising integers or none of them can be served; samples more than ten seconds apart; an
            offset of more than thirty years.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import evaluate, fuse
        >>> from motorcade.ga import Motor
        >>> fused = fuse(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> for found in (measured.trajectory, fused.trajectory):
        ...     print(f"{evaluate(found, sensor.path).rotation_deg.rmse:.1f}°")
        1.0°
        0.2°
    """
    chosen, kinds = settings or FilterSettings(), checked_also(also)
    shift_ns = checked_span_ns(time_offset_s, "time_offset_s")

    def one(given: PoseMeasurements, stream: ImuStream, stamps: IntArray | None) -> Fused:
        return _fused(
            given, stream, noise, imu_T_camera, stamps, kinds, chosen, smoothed, time_offset_s,
            state_covariances,
        )  # fmt: skip

    found = by_stretch(one, measurements, imu, stamps_ns, shift_ns)
    given = measurements.trajectory, imu, imu_T_camera, time_offset_s, chosen
    accepted = found.accepted[np.isfinite(found.nis)]
    outcome = accepted, found.gyro_bias_rad_s, found.accel_bias_m_s2
    return replace(found, health=fused_health(*given, outcome))


def _fused(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None,
    also: Sequence[Measurements],
    chosen: FilterSettings,
    smoothed: bool,
    time_offset_s: float,
    state_covariances: bool,
) -> Fused:
    """Fuse along one stretch of the stream."""
    shift_ns = round(time_offset_s * 1e9)
    used = covered(measurements, imu, shift_ns)
    wanted = wanted_stamps(used.trajectory.time_ns + shift_ns, imu, stamps_ns)
    relates = any(one.since_ns is not None for one in also)
    run = engine(chosen, noise, imu_T_camera, time_offset_s, keeps_earlier=relates)
    made = _Made.empty(len(wanted))
    size = chosen.error_size
    whole = np.zeros((len(wanted) if state_covariances else 0, size, size))
    columns = [
        np.ascontiguousarray(values)
        for values in (imu.time_ns, imu.angular_rate_rad_s, imu.specific_force_m_s2)
    ]
    run.hold(*columns)
    _schedule(run, used)
    first_ns, last_ns = int(used.trajectory.time_ns[0]) + shift_ns, int(imu.time_ns[-1])
    schedule(run, also, first_ns, last_ns)
    run.outputs(
        np.ascontiguousarray(wanted),
        *made.arrays,
        whole=whole if state_covariances else None,
        final=smoothed,
    )
    run.play()
    if smoothed:
        run.smooth()
    nis, accepted = _judged(run, used.trajectory.time_ns + shift_ns, wanted, live=not smoothed)
    found = made.fused(wanted, measurements.trajectory, whole, nis, accepted, chosen.gravity_m_s2)
    return replace(
        found,
        also=judgements(also, *run.judged(), live=not smoothed),
        given_up_ns=run.doubted()[0],
    )


@dataclass(frozen=True, eq=False)
class _Made:
    """What the compiled filter fills, one row a stamp.

    `others` are the rotor of gravity, the extrinsics and the time offset.
    """

    pose: FloatArray
    velocity: FloatArray
    bias: FloatArray
    covariance: FloatArray
    others: FloatArray

    @classmethod
    def empty(cls, count: int) -> _Made:
        shapes = ((count, 8), (count, 3), (count, 6), (count, 6, 6), (count, 13))
        return cls(*(np.zeros(shape) for shape in shapes))

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.pose, self.velocity, self.bias, self.covariance, self.others

    def fused(
        self,
        wanted: IntArray,
        measured: Trajectory,
        whole: FloatArray,
        nis: FloatArray,
        accepted: NDArray[np.bool_],
        gravity_m_s2: float,
    ) -> Fused:
        """The result, seen from the camera."""
        imu_T_camera = Motor.normalize(self.others[:, 4:12])
        poses = Motor.normalize(self.pose) @ imu_T_camera
        return Fused(
            trajectory=Trajectory(wanted, poses, measured.parent, measured.child),
            velocity_m_s=self.velocity,
            gyro_bias_rad_s=self.bias[:, :3],
            accel_bias_m_s2=self.bias[:, 3:],
            covariance=self.covariance,
            state_covariance=whole,
            nis=nis,
            accepted=accepted,
            gravity_m_s2=Rotor(self.others[:, :4]).apply(np.array([0.0, 0.0, -gravity_m_s2])),
            imu_T_camera=imu_T_camera,
            time_offset_s=self.others[:, 12],
        )


def camera_covariance(covariance: FloatArray, imu_T_camera: Motor) -> FloatArray:
    """Covariance ``(*, 6, 6)`` of the camera's pose from that of the state ``(*, N, N)``."""
    adjoint = imu_T_camera.inverse().adjoint()
    effect = np.zeros((*adjoint.shape[:-1], covariance.shape[-1]))
    effect[..., :6] = adjoint
    if covariance.shape[-1] > _EXTRINSICS.stop:
        effect[..., _EXTRINSICS] = np.eye(6)
    seen: FloatArray = effect @ covariance @ np.swapaxes(effect, -1, -2)
    return seen


def _schedule(run: Engine, measurements: PoseMeasurements) -> None:
    path = measurements.trajectory
    rows = np.hstack([path.motors.coefficients, measurements.covariance.reshape(-1, 36)])
    stamps = np.ascontiguousarray(path.time_ns)
    run.schedule(KINDS["camera_pose"], stamps, rows, None, None, -1)


def _judged(
    run: Engine, measured_ns: IntArray, wanted: IntArray, *, live: bool
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """By wanted stamp, the innovation of the measurement there and whether it was believed."""
    about, values = run.judged()
    nis, accepted = np.full(len(wanted), np.nan), np.ones(len(wanted), dtype=np.bool_)
    real = (about[:, 2] == KINDS["camera_pose"]) & (about[:, 1] >= 0)
    stamps, values = measured_ns[about[real, 1]], values[real, 2:] if live else values[real, :2]
    row = np.minimum(np.searchsorted(wanted, stamps), len(wanted) - 1)
    here = wanted[row] == stamps
    nis[row[here]], accepted[row[here]] = values[here, 0], values[here, 1] > 0.0
    return nis, accepted
