"""Stage `integrity`: whether the stages agree with each other and with the images.

It gathers what measuring the poses found of what it was told (`CameraPoses.audit`), and adds checks
of its own. None of these needs a ground truth, and none has a constant that was chosen on a
recording, or that follows from what it judges: a frame or a measurement fails by the probability of
the filter's gate, or by what a corner can scatter in an image of this size; so many may fail as
ordinary data hold outliers, and chance adds to them. What all stages believe alike
is not seen: a wrong size of the board's squares scales the whole world, and the images with it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.metrics import most_by_chance, normalised_squared
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.replays.stages.inertial.filter_input import inertial_health, other_rate
from motorcade.replays.stages.values.camera_poses import BoardPoses, CameraPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.inertial import UsedImu
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.tracking import registration_px
from motorcade.tracking.audit import (
    DEPTH_ON_COLOUR_PX,
    AuditFinding,
    Verdict,
    centre_finding,
    scatter_px,
)

CONTAMINATION = 0.1
"""Share of outliers that ordinary data hold at most: 1 to 10 % are the rule (F. R. Hampel,
E. M. Ronchetti, P. J. Rousseeuw and W. A. Stahel, Robust Statistics, 1986, section 1.2c)."""
UNCOVERED = 0.5
"""Share of the frames that may lack a pose: beyond it, more of a path is bridged than measured."""
FREEDOM = 6
"""Of a pose."""
_SMOOTH_LESS = "smooth less (smoothed.window_s, smoothed.parameters)"


def integrity(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: UsedImu,
    fused: FusedPath,
    smoothed: SmoothedPaths,
    board_poses: BoardPoses | None = None,
) -> Integrity:
    """Check the run, and choose the path that the character is placed and drawn along.

    Coverage: frames without a pose, half of which may be. Inertial: faults of the IMU, its
    extrinsics and its stamps (see `check_health`), of which there may be none. Innovations:
    measured poses that the filter's gate would not let pass; without a filter there are none to
    judge. Then the images decide, where poses were measured in them.
    Registration: frames in which what is drawn along the first smoothed path lies off the corners
    of board or markers, or off the points of SLAM's map, by more than they can scatter
    (`scatter_px`), whatever the measured poses leave. Elsewhere agreement: measured poses that the
    smoothed path misses by more than the gate allows them. Of these three a tenth may fail, and
    what chance adds to that. The measured path is drawn along where the smoothed one fails in the
    images more often than it does, or misses most of the measured poses.
    """
    measured = camera_poses.measurements.trajectory
    name, path = next(iter(smoothed.trajectories.items()))
    checks = [_coverage(camera_poses, path)]
    if fused.by == "imu":
        checks.append(_inertial(recording, camera_poses, imu))
    if np.any(np.isfinite(fused.nis)):
        checks.append(_innovations(fused))
    paths = {"measured": measured, "fused": fused.trajectory} | smoothed.trajectories
    registration = _registered_px(paths, recording, camera_poses, board_poses)
    if registration:
        sighted = camera_poses.sighted
        seen_by = camera_of(recording) if sighted is None else sighted.camera
        limit_px = scatter_px(seen_by, camera_poses.corner_px)
        if camera_poses.origin == "slam" and recording.frames[0].read_depth is not None:
            limit_px = max(limit_px, DEPTH_ON_COLOUR_PX)  # its points stand where depth puts them
        checks.append(_registration_check(registration, name, limit_px))
        kept = _off(registration[name], limit_px) > _off(registration["measured"], limit_px)
    else:
        checks.append(_agreement(camera_poses, path))
        kept = (checks[-1].figure or 0.0) > UNCOVERED
    kept = kept and not checks[-1].passed
    if imu.origin == "recorded" and not all(check.passed for check in checks):
        checks += other_rate(camera_poses, imu.stream(recording))
    centre = None if recording.camera is None else centre_finding(recording.camera)
    checks += [] if centre is None else [centre]
    checks += _unseen(recording, camera_poses)
    return Integrity(
        (*checks, *camera_poses.audit),
        registration,
        measured if kept else path,
        "measured" if kept else "smoothed",
    )


def _unseen(recording: Recording, camera_poses: CameraPoses) -> list[AuditFinding]:
    """What was stated and gave no pose, or does not come together."""
    stated: dict[str, tuple[object, str]] = {
        "board": (recording.board, "or leave [board] out"),
        "markers": (recording.markers, "or leave [markers] out"),
        "slam": (recording.baseline_m, "or leave [stereo] out"),
    }
    reasons = (text.partition(": ")[::2] for text in camera_poses.skipped)
    unseen: list[tuple[str, str, object, str]] = [
        (f"stated_{name}", why, *stated[name]) for name, why in reasons if name in stated
    ]
    if recording.layout == "tum_rgbd":
        unseen += [("depth_stamps", doubt, recording, "") for doubt in recording.doubts]
    return [
        AuditFinding(name, "contradicted", None, "", why, advice)
        for name, why, value, advice in unseen
        if value is not None
    ]


def _coverage(camera_poses: CameraPoses, path: Trajectory) -> AuditFinding:
    times_ns = camera_poses.frame_times_ns
    posed = np.isin(times_ns, camera_poses.measurements.trajectory.time_ns)
    posed &= (times_ns >= path.time_ns[0]) & (times_ns <= path.time_ns[-1])
    count, missing = len(times_ns), int(np.count_nonzero(~posed))
    allowed = int(UNCOVERED * count)
    summary = f"{missing} of {count} frames have no pose (up to {allowed} may)"
    advice = "look at the images there: blur, light, and whether what poses come from is in view"
    return _counted("coverage", missing, count, allowed, summary, advice)


def _inertial(recording: Recording, camera_poses: CameraPoses, imu: UsedImu) -> AuditFinding:
    """Faults that the readings show beside the measured poses; these may be of a leaning world."""
    health = inertial_health(recording, camera_poses, imu)
    verdict: Verdict = "unknown" if health.unknown else "consistent"
    if health.findings:
        verdict = "contradicted"
    return AuditFinding("inertial", verdict, float(len(health.findings)), "faults", health.summary)


def _innovations(fused: FusedPath) -> AuditFinding:
    nis = fused.nis[np.isfinite(fused.nis)]
    beyond, refused = _beyond_gate(nis), int(np.count_nonzero(~fused.accepted))
    allowed = most_by_chance(len(nis), CONTAMINATION)
    mean = _shown(float(np.mean(nis)) / FREEDOM)
    summary = (
        f"{beyond} of {len(nis)} measured poses contradict the IMU (up to {allowed} may): the mean "
        f"NIS is {mean} a dimension where 1 is expected; {refused} were refused"
    )
    advice = "mend what the IMU's check names, or state its noise and the poses' as they are"
    return _counted("innovations", beyond, len(nis), allowed, summary, advice)


def _registration_check(
    registration: dict[str, FloatArray], name: str, limit_px: float
) -> AuditFinding:
    off_px = registration[name]
    off, allowed = _off(off_px, limit_px), most_by_chance(len(off_px), CONTAMINATION)
    summary = (
        f"in {off} of {len(off_px)} frames (up to {allowed} may) what is drawn along the smoothed "
        f"path lies more than {limit_px:.2g} px off: {_shown(_median(off_px))} px in the median, "
        f"{_shown(_median(registration['measured']))} px along the measured poses"
    )
    advice = f"{_SMOOTH_LESS}, or look at what the filter made of the poses"
    if _off(registration["measured"], limit_px) > allowed:
        advice = (
            "the measured poses do not explain the images: look at the camera, at the board or "
            "markers as stated, at blur, and at what moves"
        )
    return _counted("registration", off, len(off_px), allowed, summary, advice)


def _agreement(camera_poses: CameraPoses, path: Trajectory) -> AuditFinding:
    measured, covariance = (
        camera_poses.measurements.trajectory,
        camera_poses.measurements.covariance,
    )
    inside = (measured.time_ns >= path.time_ns[0]) & (measured.time_ns <= path.time_ns[-1])
    apart = path.motors_at(measured.time_ns[inside]).local(measured.motors[inside])
    beyond = _beyond_gate(normalised_squared(apart, covariance[inside]))
    allowed = most_by_chance(len(apart), CONTAMINATION)
    turned = float(np.rad2deg(np.median(np.linalg.norm(apart[:, :3], axis=-1))))
    shifted = float(np.median(np.linalg.norm(apart[:, 3:], axis=-1)))
    unit = "m" if camera_poses.metric else "units"
    summary = (
        f"the smoothed path misses {beyond} of {len(apart)} measured poses (up to {allowed} may): "
        f"by {_shown(shifted)} {unit} and {_shown(turned)}° in the median"
    )
    advice = f"{_SMOOTH_LESS}, or state the poses' noise as it is"
    return _counted("agreement", beyond, len(apart), allowed, summary, advice)


def _counted(
    name: str, failures: int, count: int, allowed: int, summary: str, advice: str
) -> AuditFinding:
    """A check of which so many may fail in a run that is right."""
    verdict: Verdict = "consistent" if failures <= allowed else "doubtful"
    return AuditFinding(name, verdict, failures / max(count, 1), "share", summary, advice)


def _registered_px(
    paths: dict[str, Trajectory],
    recording: Recording,
    camera_poses: CameraPoses,
    board_poses: BoardPoses | None,
) -> dict[str, FloatArray]:
    """How far what is drawn lies from the footage; none where poses are not from images."""
    board, camera, sighted = recording.board, recording.camera, camera_poses.sighted
    if sighted is not None:
        return {name: sighted.registration_px(path) for name, path in paths.items()}
    if board_poses is None or board is None or camera is None:
        return {}
    seen, world_T_board = board_poses.track, recording.world_T_board
    return {
        name: registration_px(path, seen, board, camera, world_T_board, board_poses.corners_m)
        for name, path in paths.items()
    }


def _shown(number: float) -> str:
    """Three digits, or all before the point."""
    return f"{number:,.0f}" if number >= 100.0 else f"{number:.3g}"


def _median(registration: FloatArray) -> float:
    """Median over frames; NaN, a corner behind the camera, counts as infinitely far."""
    if not registration.size:
        return 0.0
    return float(np.median(np.where(np.isnan(registration), np.inf, registration)))


def _off(registration: FloatArray, limit_px: float) -> int:
    inside: NDArray[np.bool_] = registration <= limit_px
    return int(np.count_nonzero(~inside))


def _beyond_gate(squared: FloatArray) -> int:
    return int(np.count_nonzero(squared > FilterSettings().gate_limit(FREEDOM)))
