"""Poses of a file and an IMU's readings fused: what `motorcade fuse` does.

Everything is on the clock of the poses, and in their world, which need not be upright: an IMU tells
up. Noise that nobody states is estimated: that of the poses from how rough they are, that of the
IMU as the pipeline takes it, ten times the data sheet's white noise.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, LearntNoise, fuse, learn_noise
from motorcade.fusion.filter.fuse import checked_lag
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.measurements.interface import Measurements
from motorcade.fusion.measurements.poses import RelativePoseMeasurements
from motorcade.fusion.measurements.positions import PositionMeasurements
from motorcade.fusion.metrics.poses.alignment import Pairs, align_heading
from motorcade.fusion.smoothing import choose
from motorcade.fusion.smoothing.batch.inliers import first_sizes
from motorcade.fusion.sync.synchronise import synchronise
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.stamps import checked_span_ns
from motorcade.replays.io.files import write_bytes
from motorcade.replays.stages.inertial.filter_input import assumed_noise, levelled
from motorcade.replays.stages.inertial.fused import ALIGNMENT_SIGMA_DEG, LEVELLED_SIGMA_DEG
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import UsedImu
from motorcade.tracking import PoseMeasurements

_LOG = logging.getLogger("motorcade.replays")
Estimated = Literal["extrinsics", "offset"]
_FLOOR_M, _FLOOR_RAD = 1e-4, 1e-4
"""No pose is believed beyond this, as in tracking: errors that last are in no roughness."""
_FEWEST_POSITIONS = 4
_UNEXPLAINED = 0.5
"""Of how far positions spread: a path that leaves more apart explains less than 3/4 of them."""
_AXES = ("rx", "ry", "rz", "tx", "ty", "tz")


@dataclass(frozen=True)
class FusingOptions:
    """What is known besides poses and readings; what is None is estimated or usual.

    Fields:
        noise: the IMU's data sheet; None: ADIS16448's.
        noise_factor, walk_factor: times its white densities and its bias walks; None: 10 and 1,
            and densities that fit where the poses contradict these.
        learn_noise: learn the IMU's noise from the recording, starting from that.
        imu_T_camera: where the poses' frame sits on the IMU; None: the poses are the IMU's.
        offset_s: what the IMU's clock shows at an event minus what that of the poses does.
        estimate: what the motion of both is to tell before: extrinsics, offset.
        sigma_m, sigma_rad: deviations of the poses, an axis; None: from how rough they are.
        gravity_m_s2: size of gravity.
        gravity_sigma_rad: how far the world's z may be from up, an axis; a world that leans by more
            than 3° is set upright first, with 3° at least.
        extrinsics_sigma_rad, extrinsics_sigma_m: how far extrinsics that are given may be off, an
            axis; None: 1° and nothing.
        gate: probability that a good pose passes.
        online: every pose of what came before it alone.
        lag_s: every pose of what came up to so much after it; None: of all.
        least_accepted: share of the poses below which there is no result.
        positions_sigma_m: deviation of positions beside the poses, an axis.
        antenna_m: where they were measured, from the IMU, in its axes.

    Raises:
        ValueError: a deviation or factor that is not above zero; a lag below it, or with `online`.

    >>> import numpy as np
    >>> from motorcade.replays.tasks.fusing import FusingOptions
    >>> FusingOptions(sigma_m=0.01, sigma_rad=np.deg2rad(0.5), online=True).estimate
    ()
    """

    noise: ImuNoise | None = None
    noise_factor: float | None = None
    walk_factor: float | None = None
    learn_noise: bool = False
    imu_T_camera: Motor | None = None
    offset_s: float = 0.0
    estimate: tuple[Estimated, ...] = ()
    sigma_m: float | None = None
    sigma_rad: float | None = None
    gravity_m_s2: float = 9.81
    gravity_sigma_rad: float = float(np.deg2rad(ALIGNMENT_SIGMA_DEG["recorded"]))
    extrinsics_sigma_rad: float | None = None
    extrinsics_sigma_m: float | None = None
    gate: float = 0.9999
    online: bool = False
    lag_s: float | None = None
    least_accepted: float = 0.5
    positions_sigma_m: float = 3.0
    antenna_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("noise_factor", "walk_factor", "sigma_m", "sigma_rad", "positions_sigma_m"):
            value = getattr(self, name)
            if value is not None:
                checked_positive(value, name)
        checked_lag(self.ahead_s, not self.online)
        checked_span_ns(self.offset_s, "offset_s")

    @property
    def ahead_s(self) -> float:
        """The lag, infinite where there is none."""
        return np.inf if self.lag_s is None else self.lag_s


@dataclass(frozen=True, eq=False)
class FusedPoses:
    """A fused path in the world and on the clock of the poses, and what was found besides.

    Fields:
        fused: the filter's result; its gravity is in the poses' world.
        sigma_m, sigma_rad: deviations that the poses were taken to have.
        lean_rad: how far the world's z was from up, where it was set upright for that; else 0.
        imu_T_camera: extrinsics that the filter started from.
        offset_s, offset_sigma_s: taken off the IMU's stamps; its deviation where it was estimated.
        poses: how many were given.
        noise: what was learnt of the IMU's noise, where that was asked for.
    """

    fused: Fused
    sigma_m: float
    sigma_rad: float
    lean_rad: float
    imu_T_camera: Motor
    offset_s: float
    offset_sigma_s: float | None
    poses: int
    noise: LearntNoise | None = None

    def as_dict(self) -> dict[str, Any]:
        """Figures, ready for JSON; keys carry units."""
        fused = self.fused
        nis = fused.nis[np.isfinite(fused.nis)]
        last = fused.imu_T_camera[-1]
        return {
            "poses": self.poses,
            "fused_poses": len(fused.trajectory),
            "positions_kept": {kind.name: float(kind.accepted.mean()) for kind in fused.also},
            "refused": int(np.count_nonzero(~fused.accepted)),
            "nis_per_dimension": float(nis.mean()) / 6.0 if nis.size else None,
            "sigma_m": self.sigma_m,
            "sigma_deg": float(np.rad2deg(self.sigma_rad)),
            "world_lean_deg": float(np.rad2deg(self.lean_rad)),
            "offset_ms": 1e3 * self.offset_s,
            "offset_sigma_ms": self.offset_sigma_s and 1e3 * self.offset_sigma_s,
            "imu_T_camera_wxyz": last.rotor.as_quaternion().tolist(),
            "imu_T_camera_translation_m": last.translation_m.tolist(),
            "gravity_m_s2": fused.gravity_m_s2[-1].tolist(),
            "gyro_bias_rad_s": fused.gyro_bias_rad_s.mean(axis=0).tolist(),
            "accel_bias_m_s2": fused.accel_bias_m_s2.mean(axis=0).tolist(),
            "doubts": list(fused.doubts),
            "health": fused.health.as_dict(),
            "noise": None if self.noise is None else self.noise.as_dict(),
        }


def fuse_poses(
    poses: Trajectory,
    imu: ImuStream,
    options: FusingOptions | None = None,
    stamps_ns: IntArray | None = None,
    positions: Trajectory | None = None,
) -> FusedPoses:
    """Fuse a path, in metres, with the readings of an IMU that moved with it.

    Args:
        poses: ``world_T_camera``; the world may lean.
        imu: its readings, on its own clock.
        options: what is known besides.
        stamps_ns: rising stamps on the poses' clock at which the path is wanted; None: theirs.
        positions: of an antenna on the same clock, in any upright world. They hold a path that
            drifts: its poses then count by the steps between them (see `_held`).

    Raises:
        ValueError: streams that do not overlap, fewer than 16 poses where their noise is to be
            estimated, motion that does not tell what is to be estimated, or more poses that the
            IMU contradicts than `least_accepted` leaves room for.

    >>> import numpy as np
    >>> from motorcade.fusion import ADIS16448, ContinuousPath
    >>> from motorcade.fusion import evaluate, simulate_camera_poses, simulate_imu
    >>> from motorcade.fusion.motions import gimbal_crossing
    >>> from motorcade.replays.tasks.fusing import FusingOptions, fuse_poses
    >>> rng = np.random.default_rng(0)
    >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
    >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
    >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng).trajectory
    >>> found = fuse_poses(measured, sensor.stream, FusingOptions(noise_factor=1.0))
    >>> evaluate(found.fused.trajectory, sensor.path).rotation_deg.rmse < 0.3
    True
    """
    chosen = options or FusingOptions()
    sheet = chosen.noise or ADIS16448
    measured, sigma_m, sigma_rad = _measurements(poses, chosen)
    chosen, offset_sigma_s = _synchronised(poses, imu, sheet, chosen)
    shift_ns = round(chosen.offset_s * 1e9)
    stream = ImuStream(imu.time_ns - shift_ns, imu.angular_rate_rad_s, imu.specific_force_m_s2)
    imu_T_camera = Motor.identity() if chosen.imu_T_camera is None else chosen.imu_T_camera
    noise = assumed_noise(sheet, "recorded", chosen.noise_factor, chosen.walk_factor)
    level = levelled(
        CameraPoses(measured, poses.time_ns, np.full(len(poses), np.nan), "slam", "as given"),
        UsedImu(None, sheet, imu_T_camera, "recorded"),
        stream,
    )
    also: tuple[Measurements, ...] = ()
    if positions is not None:
        held, also = _held(level.measurements, positions, imu_T_camera, chosen)
        level = replace(level, measurements=held)
    settings = _settings(chosen, offset_sigma_s or 0.0, leaned=level.leaned)
    learned = None
    if chosen.learn_noise:
        learned = learn_noise(level.measurements, stream, noise, imu_T_camera, settings=settings)
        noise = learned.noise
    fused = fuse(
        level.measurements,
        stream,
        noise,
        imu_T_camera,
        poses.time_ns if stamps_ns is None else stamps_ns,
        also=also,
        settings=settings,
        smoothed=not chosen.online,
        lag_s=chosen.ahead_s,
        state_covariances=False,
        fits_noise=chosen.noise_factor is None and chosen.walk_factor is None and learned is None,
    )
    accepted = fused.accepted[np.isfinite(fused.nis)]
    if np.mean(accepted) < chosen.least_accepted:
        raise ValueError(
            f"{np.count_nonzero(~accepted)} of {len(accepted)} poses were refused (up to "
            f"{1.0 - chosen.least_accepted:.0%} may be), so that the path is not to be believed: "
            f"{_cause(fused)}"
        )
    back = level.level_T_world.inverse()
    fused = replace(
        fused,
        trajectory=fused.trajectory.transformed_by(left=back),
        velocity_m_s=back.rotor.apply(fused.velocity_m_s),
        gravity_m_s2=back.rotor.apply(fused.gravity_m_s2),
    )
    lean_rad = float(np.deg2rad(level.lean_deg))
    return FusedPoses(
        fused,
        sigma_m,
        sigma_rad,
        lean_rad,
        imu_T_camera,
        chosen.offset_s,
        offset_sigma_s,
        len(poses),
        learned,
    )


def _held(
    measured: PoseMeasurements, positions: Trajectory, imu_T_camera: Motor, options: FusingOptions
) -> tuple[PoseMeasurements, tuple[Measurements, ...]]:
    """Poses and what holds their path: positions turned about the vertical into their world.

    As far as both lie apart beyond the positions' own deviation, the path drifts. An error that
    lasts is one error, in however many poses: all of them together then weigh as one of that size,
    and the steps between them as they are.

    Raises:
        ValueError: fewer than four positions beside the poses, such as tell no heading, or such as
            the path leaves as far apart as it would if they stood still.
    """
    path, sigma_m = measured.trajectory, options.positions_sigma_m
    stamps = positions.time_ns
    beside = np.flatnonzero((stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1]))
    if len(beside) < _FEWEST_POSITIONS:
        raise ValueError(
            f"positions: expected {_FEWEST_POSITIONS} or more between the first pose and the "
            f"last, got {len(beside)}; both must be on one clock"
        )
    stamps, places = stamps[beside], positions.motors[beside]
    antenna = (path.motors_at(stamps) @ imu_T_camera.inverse()).apply(options.antenna_m)
    spread_m = float(np.hypot(*places.translation_m[:, :2].std(axis=0)))
    if spread_m < sigma_m:
        raise ValueError(
            f"positions: expected them spread by more than their deviation, {sigma_m:g} m, since "
            f"they tell the heading, got {spread_m:.1f} m; say --positions-sigma-m as it is"
        )
    rows = np.arange(len(stamps))
    pairs = Pairs(stamps, places, Motor.from_translation(antenna), rows, rows)
    aligned = align_heading(pairs).apply(places).translation_m
    apart_m = float(np.sqrt(np.square(aligned - antenna)[:, :2].sum(axis=1).mean()))
    if apart_m > _UNEXPLAINED * spread_m:
        raise ValueError(
            f"positions: expected them along the poses' path, got {apart_m:.1f} m between them "
            f"where they spread by {spread_m:.1f} m, however they are turned: are both of "
            "one recording, on one clock, the poses in metres?"
        )
    drift_m = np.sqrt(max(np.square(aligned - antenna).mean() - sigma_m**2, 0.0))
    _LOG.info("positions: %.2f m of drift in the poses, %.1f m across", drift_m, spread_m)
    covariance = np.asarray(measured.covariance)
    steps = RelativePoseMeasurements.along(path, 2.0 * covariance[1:], imu_T_camera)
    spread = np.diag(np.repeat([drift_m / spread_m, drift_m], 3)) ** 2
    fixes = PositionMeasurements(
        time_ns=stamps,
        position_m=aligned,
        covariance=sigma_m**2 * np.eye(3),
        arm_m=np.array(options.antenna_m),
    )
    drifting = PoseMeasurements(path, covariance + len(path) * spread)
    return drifting, (fixes, steps) if drift_m > 0.0 else (fixes,)


def _cause(fused: Fused) -> str:
    """The worst that is known of it, and what to do."""
    causes = [one for one in fused.health.findings if one.fault != "measurements_refused"]
    if causes:
        return causes[0].summary
    return "check whether both are of one recording, and the noise that is stated of either"


def _measurements(
    poses: Trajectory, options: FusingOptions
) -> tuple[PoseMeasurements, float, float]:
    """The poses with covariances, and the deviations of place and rotation in them."""
    sigma_m, sigma_rad = options.sigma_m, options.sigma_rad
    if sigma_m is None or sigma_rad is None:
        chosen, (rotation, translation) = choose(poses), first_sizes(poses)
        sigma_m = sigma_m or max(chosen.noise_m or translation.noise, _FLOOR_M)
        sigma_rad = sigma_rad or max(chosen.noise_rad or rotation.noise, _FLOOR_RAD)
    spread = np.diag(np.repeat([sigma_rad**2, sigma_m**2], 3))
    covariance = np.tile(spread, (len(poses), 1, 1))
    return PoseMeasurements(poses, covariance), sigma_m, sigma_rad


def _synchronised(
    poses: Trajectory, imu: ImuStream, noise: ImuNoise, options: FusingOptions
) -> tuple[FusingOptions, float | None]:
    """The options with what the motion tells besides, and the deviation of the offset."""
    if not options.estimate:
        return options, None
    synchronised = synchronise(poses, imu, noise)
    offset_sigma_s = None
    if "extrinsics" in options.estimate:
        options = replace(
            options,
            imu_T_camera=synchronised.imu_T_camera,
            extrinsics_sigma_rad=float(synchronised.rotation_sigma_rad.max()),
            extrinsics_sigma_m=float(synchronised.lever_arm_sigma_m.max()),
        )
    if "offset" in options.estimate:
        options = replace(options, offset_s=synchronised.offset_s)
        offset_sigma_s = synchronised.offset_sigma_s
    return options, offset_sigma_s


def _settings(options: FusingOptions, offset_sigma_s: float, *, leaned: bool) -> FilterSettings:
    turn_rad, shift_m = options.extrinsics_sigma_rad, options.extrinsics_sigma_m
    if turn_rad is None:
        calibrated = options.imu_T_camera is not None
        turn_rad = float(np.deg2rad(ALIGNMENT_SIGMA_DEG["recorded"])) if calibrated else 0.0
    up_rad = options.gravity_sigma_rad
    return FilterSettings(
        gravity_m_s2=options.gravity_m_s2,
        gate=options.gate,
        gravity_sigma_rad=max(up_rad, float(np.deg2rad(LEVELLED_SIGMA_DEG))) if leaned else up_rad,
        extrinsics_sigma_rad=turn_rad,
        extrinsics_sigma_m=shift_m or 0.0,
        time_offset_sigma_s=offset_sigma_s,
    )


def write_covariance(path: Path, time_ns: IntArray, covariance: FloatArray) -> None:
    """Write covariances ``(N, 6, 6)`` as CSV: a stamp (ns), then the upper triangle row by row.

    They are of the right perturbation in the moving frame's axes: rotation (rad), then place (m).

    Raises OSError: a file that cannot be written.
    """
    rows, columns = np.triu_indices(6)
    names = [f"{_AXES[i]}_{_AXES[j]}" for i, j in zip(rows, columns, strict=True)]
    lines = [f"#timestamp [ns],{','.join(names)} [rad and m, right perturbation]"]
    for stamp, values in zip(time_ns.tolist(), covariance[:, rows, columns].tolist(), strict=True):
        lines.append(f"{stamp},{','.join(map(repr, values))}")
    write_bytes(path, ("\n".join(lines) + "\n").encode("ascii"))
