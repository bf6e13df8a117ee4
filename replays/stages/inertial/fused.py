"""Stage `fused`: one path between frames and through blackouts, by an IMU or an odometry."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, fuse, latency_curve
from motorcade.fusion.filter import learn_noise as noise_of
from motorcade.fusion.filter.unjudged import fuse_unjudged
from motorcade.fusion.graph.odometry import fuse_odometry
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import checked_positive
from motorcade.replays.io.recording import Odometry, Recording
from motorcade.replays.stages.inertial.filter_input import (
    Levelled,
    assumed_noise,
    inertial_health,
    levelled,
)
from motorcade.replays.stages.stage_comparison import compared_by_held_out, without_held_out
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import UsedImu
from motorcade.replays.stages.values.paths import FusedPath, FusedWith
from motorcade.tracking import PoseMeasurements

log = logging.getLogger("motorcade.fused")

FusedBy = Literal["auto", "imu", "odometry", "nothing"]
ALIGNMENT_SIGMA_DEG = {"recorded": 1.0, "reference": 0.0}
"""How far the world's z may be from up, and the camera's calibrated attitude on the IMU from the
true one, by where the IMU came from; a simulated one knows both."""
LEVELLED_SIGMA_DEG = 3.0
"""The same of z, where up was taken from the mean of the accelerometer: what the motion adds to
that in a few seconds."""


def fused(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: UsedImu,
    *,
    by: FusedBy = "auto",
    look_ahead: bool = True,
    lag_s: float | None = None,
    lag_curve: bool = False,
    learn_noise: bool = False,
    noise_factor: float | None = None,
    walk_factor: float | None = None,
    alignment_sigma_deg: float | None = None,
    gate: float = 0.9999,
    initial_tilt_deg: float = 0.0,
) -> FusedPath:
    """Join the measured poses with what else was recorded, at the time of every frame.

    `by=auto` filters with the IMU; where there is none, an odometry bridges what the camera did not
    see, unless measured poses that were held out say that it makes the path worse. Nothing is fused
    where nothing else was recorded, or where lengths have no unit: the path then stays as it was
    tracked. So do measured poses outside the time of what is fused.

    The rest is the filter's. `look_ahead` adds the backward pass; without it every estimate knows
    only its past, with `lag_s` no more than so much of its future, as if the path were answered
    that much later while it is recorded. `lag_curve` finds what each of several lags would leave.
    `noise_factor` multiplies the IMU's white densities: by default 10 for a recorded
    IMU, 1 for one simulated from the ground truth; `walk_factor` its bias walks, by default 1;
    `learn_noise` goes on from that to what predicts the poses of this recording best, if it does.
    `alignment_sigma_deg` above zero has the vertical of the world and the attitude of the camera on
    the IMU estimated, from so much doubt about each axis: by default 1 for a recorded IMU, else 0.
    `gate` is the probability with which a good measurement passes; `initial_tilt_deg` starts so far
    off upright.

    Raises ValueError where `by` asks for what is not there, or for what looks ahead without leave.
    """
    asked = _FilterKnobs(
        look_ahead=look_ahead,
        lag_s=lag_s,
        learn_noise=learn_noise,
        noise_factor=noise_factor,
        walk_factor=walk_factor,
        alignment_sigma_deg=alignment_sigma_deg,
        gate=gate,
        initial_tilt_deg=initial_tilt_deg,
    )
    odometry = recording.odometry
    to_the_end = look_ahead and lag_s is None
    chosen = _chosen(camera_poses, imu, odometry, to_the_end) if by == "auto" else by
    _check_choice(by, chosen, camera_poses, imu, odometry, to_the_end)
    harm: str | None = None

    def path_of(poses: CameraPoses, whole: FusedPath | None = None) -> FusedPath:
        if chosen == "nothing":
            return _as_tracked(poses, harm or _reason(poses, imu, odometry, by))
        if chosen == "odometry":
            return _with_the_rest(_by_odometry(poses, odometry), poses)
        try:
            return _with_the_rest(_by_imu(poses, recording, imu, asked, lag_curve, whole), poses)
        except ValueError as fault:
            health = inertial_health(recording, poses, imu)
            if not health.findings:
                raise
            raise ValueError(f"the filter finds no path: {health.summary}") from fault

    if chosen == "odometry" and by == "auto":
        harm = _harm(camera_poses, path_of)
        if harm is not None:
            chosen = "nothing"
            log.warning("%s: the path is left as tracked: %s", recording.name, harm)
    path = path_of(camera_poses)
    if path.noise is not None:
        log.info("%s", path.noise.summary)
    kept = None if recording.truth is not None else without_held_out(camera_poses)
    return replace(
        path,
        held_out=None if kept is None else path_of(kept, path).trajectory,
        lag_s=asked.ahead_s,
    )


@dataclass(frozen=True)
class _FilterKnobs:
    """The knobs of `fused` that are the filter's; refused if wrong, whether one runs or not."""

    look_ahead: bool
    lag_s: float | None
    learn_noise: bool
    noise_factor: float | None
    walk_factor: float | None
    alignment_sigma_deg: float | None
    gate: float
    initial_tilt_deg: float

    def __post_init__(self) -> None:
        if self.lag_s is not None:
            checked_positive(self.lag_s, "fused.lag_s")
            if not self.look_ahead:
                raise ValueError("fused.lag_s: expected none without fused.look_ahead, got one")
        factors = (("noise_factor", self.noise_factor), ("walk_factor", self.walk_factor))
        for name, factor in factors:
            if factor is not None:
                checked_positive(factor, f"fused.{name}")
        FilterSettings(
            gate=self.gate,
            initial_tilt_error_rad=float(np.deg2rad(self.initial_tilt_deg)),
            gravity_sigma_rad=float(np.deg2rad(self.alignment_sigma_deg or 0.0)),
        )

    @property
    def ahead_s(self) -> float:
        """How much of its future each pose knows."""
        if not self.look_ahead:
            return 0.0
        return np.inf if self.lag_s is None else self.lag_s


def _check_choice(
    by: FusedBy,
    chosen: FusedWith,
    camera_poses: CameraPoses,
    imu: UsedImu,
    odometry: Odometry | None,
    to_the_end: bool,
) -> None:
    if chosen != "nothing" and not camera_poses.metric:
        raise ValueError(f"fused.by={by}: lengths of the tracked path have no unit")
    if chosen == "odometry" and odometry is not None and not to_the_end:
        raise ValueError("fused.by=odometry looks ahead always; choose fused.by=imu without")
    if chosen == "imu" and imu.origin == "none":
        raise ValueError(f"fused.by=imu, but {imu.absent}")


def _chosen(
    camera_poses: CameraPoses, imu: UsedImu, odometry: Odometry | None, look_ahead: bool
) -> FusedWith:
    if not camera_poses.metric:
        return "nothing"
    if imu.origin != "none":
        return "imu"
    usable = odometry and look_ahead and not camera_poses.has_odometry
    return "odometry" if usable else "nothing"


def _reason(camera_poses: CameraPoses, imu: UsedImu, odometry: Odometry | None, by: FusedBy) -> str:
    """Why nothing is fused, as the end of a sentence."""
    if by == "nothing":
        return "fused.by=nothing"
    if not camera_poses.metric:
        return "lengths have no unit, so nothing can be fused with it"
    if camera_poses.has_odometry:
        return f"{imu.absent}, and the recorded odometry is in the measured poses already"
    if odometry is not None:
        return f"{imu.absent}, and the recorded odometry is joined only where fused.look_ahead is"
    return f"{imu.absent}, so there is nothing to fuse it with"


def _harm(camera_poses: CameraPoses, path_of: Callable[[CameraPoses], FusedPath]) -> str | None:
    """In what the odometry makes the path surely worse, by measured poses held out; or None."""
    kept = without_held_out(camera_poses)
    if kept is None:
        return None
    joined = path_of(kept)
    compared = compared_by_held_out(camera_poses, replace(joined, held_out=joined.trajectory))
    return next((f"with the recorded odometry {gain}" for gain in compared.worse), None)


def _as_tracked(camera_poses: CameraPoses, reason: str) -> FusedPath:
    return _unjudged(camera_poses.measurements, "nothing", f"left as tracked: {reason}")


def _with_the_rest(whole: FusedPath, camera_poses: CameraPoses) -> FusedPath:
    """The path and, as they were tracked, the measured poses at whose stamps it has none."""
    measured, path = camera_poses.measurements, whole.trajectory
    stamps = measured.trajectory.time_ns
    rest = np.flatnonzero(~np.isin(stamps, path.time_ns))
    if not len(rest):
        return whole
    time_ns = np.concatenate([path.time_ns, stamps[rest]])
    motors = Motor.concatenate([path.motors, measured.trajectory.motors[rest]])
    order = np.argsort(time_ns)
    joined = (
        (whole.covariance, measured.covariance[rest]),
        (whole.nis, np.full(len(rest), np.nan)),
        (whole.accepted, np.ones(len(rest), dtype=np.bool_)),
    )
    covariance, nis, accepted = (np.concatenate(parts)[order] for parts in joined)
    return replace(
        whole,
        trajectory=Trajectory(time_ns[order], motors[order], path.parent, path.child),
        covariance=covariance,
        nis=nis,
        accepted=accepted,
        summary=f"{whole.summary}; {len(rest)} poses outside its span are left as tracked",
    )


def _unjudged(measured: PoseMeasurements, by: FusedWith, summary: str) -> FusedPath:
    count = len(measured)
    accepted = np.ones(count, dtype=np.bool_)
    return FusedPath(
        measured.trajectory, measured.covariance, np.full(count, np.nan), accepted, by, summary
    )


def _by_odometry(camera_poses: CameraPoses, odometry: Odometry | None) -> FusedPath:
    """The pose graph's path at the times of the frames, between its nodes by the screw motion."""
    if odometry is None:
        raise ValueError("fused.by=odometry, but the recording holds none")
    graph = fuse_odometry(
        camera_poses.measurements, odometry.trajectory, odometry.odometry_T_camera
    )
    path, times_ns = graph.trajectory, camera_poses.frame_times_ns
    stamps = times_ns[(times_ns >= path.time_ns[0]) & (times_ns <= path.time_ns[-1])]
    rows = np.searchsorted(path.time_ns, stamps)
    at = Trajectory(stamps, path.motors_at(stamps), path.parent, path.child)
    summary = "fused with the recorded odometry, which bridges what the camera did not see"
    return _unjudged(PoseMeasurements(at, graph.covariance[rows]), "odometry", summary)


def _by_imu(
    poses: CameraPoses,
    recording: Recording,
    imu: UsedImu,
    asked: _FilterKnobs,
    lag_curve: bool,
    whole: FusedPath | None,
) -> FusedPath:
    """The filter's path at the times of the frames, with what was learnt on the way.

    Of some poses alone it takes what was learnt of the noise from the `whole` path: a few figures
    of thousands of readings hardly know the others. What is wrong was told with that.
    """
    noise = assumed_noise(imu.noise, imu.origin, asked.noise_factor, asked.walk_factor)
    stream = imu.stream(recording)
    level = levelled(poses, imu, stream)
    settings = filter_settings(
        imu, asked.initial_tilt_deg, asked.alignment_sigma_deg, asked.gate, leaned=level.leaned
    )
    learnt = None if whole is None else whole.noise
    if asked.learn_noise and learnt is None:
        upright = replace(settings, initial_tilt_error_rad=0.0)
        inputs = level.measurements, stream, noise, imu.imu_T_camera
        learnt = noise_of(*inputs, settings=upright)
    if learnt is not None:
        noise = learnt.noise

    def with_lag(lag_s: float, *, judged: bool = False) -> Fused:
        return (partial(fuse, fits_noise=False) if judged else fuse_unjudged)(
            level.measurements,
            stream,
            noise,
            imu.imu_T_camera,
            poses.frame_times_ns,
            settings=settings,
            lag_s=lag_s,
            state_covariances=False,
        )

    filtered = _in_their_world(
        with_lag(asked.ahead_s, judged=whole is None), imu, level, asked.lag_s
    )
    curve = latency_curve(with_lag) if lag_curve and whole is None else None
    return replace(filtered, latency=curve, noise=learnt)


def _in_their_world(
    estimate: Fused, imu: UsedImu, level: Levelled, lag_s: float | None
) -> FusedPath:
    """The filter's path in the world of the measured poses, whose z may lean."""
    summary = f"fused with the {'recorded' if imu.origin == 'recorded' else 'simulated'} IMU"
    if lag_s is not None:
        summary += f", each pose by what was measured up to {lag_s:g} s after it"
    if level.leaned:
        summary += f" (the world's z leans {level.lean_deg:.0f}° from up)"
    return FusedPath(
        estimate.trajectory.transformed_by(left=level.level_T_world.inverse()),
        estimate.covariance,
        estimate.nis,
        estimate.accepted,
        "imu",
        summary,
    )


def filter_settings(
    imu: UsedImu,
    initial_tilt_deg: float = 0.0,
    alignment_sigma_deg: float | None = None,
    gate: float = 0.9999,
    *,
    leaned: bool = False,
) -> FilterSettings:
    """What the filter assumes besides; `leaned`: up was taken from the accelerometer's mean."""
    if alignment_sigma_deg is None:
        alignment_sigma_deg = ALIGNMENT_SIGMA_DEG[imu.origin]
    sigma_rad = float(np.deg2rad(alignment_sigma_deg))
    up_rad = float(np.deg2rad(max(alignment_sigma_deg, LEVELLED_SIGMA_DEG)))
    return FilterSettings(
        gate=gate,
        initial_tilt_error_rad=float(np.deg2rad(initial_tilt_deg)),
        gravity_sigma_rad=up_rad if leaned else sigma_rad,
        extrinsics_sigma_rad=sigma_rad,
    )
