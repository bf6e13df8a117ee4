"""Stage `errors`: every path of the run against the ground truth, as figures and over time."""

from __future__ import annotations

from typing import Literal

import numpy as np

from motorcade.fusion.metrics import (
    Align,
    NotObservableError,
    absolute_translation_m,
    accelerations,
    alignment_of,
    associate,
    jitter_above,
    rotation_rad,
)
from motorcade.fusion.metrics.evaluation import evaluate
from motorcade.ga import Trajectory
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.stage_comparison import compared_by_held_out, compared_by_truth
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import (
    AccelerationSeries,
    ErrorSeries,
    Integrity,
    PathErrors,
)
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths

_FEWEST_PAIRS = 3


def errors(
    recording: Recording,
    camera_poses: CameraPoses,
    fused: FusedPath,
    smoothed: SmoothedPaths,
    integrity: Integrity,
    *,
    align: Literal["auto", "none", "se3", "sim3"] = "auto",
    jitter_above_hz: float = 5.0,
) -> PathErrors:
    """Evaluate every path.

    `align=auto` aligns (se3) where the poses were tracked, since the board's or the first camera's
    frame need not be the ground truth's, with the scale (sim3) where their unit of length is free,
    and not at all where they were simulated from the ground truth. Without one only the jitter
    above `jitter_above_hz` is given. Each stage's path is compared with the one before, by the
    ground truth or else by measured poses that it was made without.
    """
    paths = {"measured": camera_poses.measurements.trajectory, "fused": fused.trajectory}
    paths |= smoothed.trajectories
    start_ns = int(paths["measured"].time_ns[0])
    stuck = {name: _registration(name, integrity) for name in paths}
    acceleration = {name: _acceleration(path, start_ns) for name, path in paths.items()}
    truth = recording.truth
    how: Align = _fitting(camera_poses) if align == "auto" else align
    few = None if truth is None else _too_few(paths, truth, how)
    if truth is None or few is not None:
        figures = {
            name: _figures_without_truth(path, jitter_above_hz) for name, path in paths.items()
        }
        stages = compared_by_held_out(camera_poses, fused, smoothed)
        return PathErrors("none", _joined(figures, stuck), {}, acceleration, stages, few or "")
    figures = {name: _figures(path, truth, how) for name, path in paths.items()}
    series = {name: _series(path, truth, how, start_ns) for name, path in paths.items()}
    stages = compared_by_truth(recording, camera_poses, fused, smoothed, how)
    return PathErrors(how, _joined(figures, stuck), series, acceleration, stages)


def _too_few(paths: dict[str, Trajectory], truth: Trajectory, align: Align) -> str | None:
    """Why no error can be told: fewer poses of the ground truth than an alignment takes."""
    fewest = min(len(associate(path, truth)) for path in paths.values())
    if align == "none" or fewest >= _FEWEST_PAIRS:
        return None
    return (
        f"the ground truth has {fewest} poses at stamps of the path, and {_FEWEST_PAIRS} are "
        "needed to align them"
    )


def _fitting(camera_poses: CameraPoses) -> Align:
    if camera_poses.origin == "simulated":
        return "none"
    return "se3" if camera_poses.metric else "sim3"


def _figures(path: Trajectory, truth: Trajectory, align: Align) -> dict[str, float | None]:
    figures = evaluate(path, truth, align=align).as_dict()
    return {key: value for key, value in figures.items() if not isinstance(value, str)}


def _figures_without_truth(path: Trajectory, frequency_hz: float) -> dict[str, float | None]:
    """Jitter above `frequency_hz`, or above a quarter of the rate of slow recordings."""
    if len(path) < 2:
        return {}
    frequency_hz = min(frequency_hz, 0.25 / float(np.median(np.diff(path.time_s))))
    try:
        jitter = jitter_above(path, frequency_hz)
    except NotObservableError:
        return {"angular_jitter_rad_s2": None, "linear_jitter_m_s2": None}
    return {
        "angular_jitter_rad_s2": jitter.angular_rad_s2,
        "linear_jitter_m_s2": jitter.linear_m_s2,
        "jitter_above_hz": frequency_hz,
    }


def _registration(name: str, integrity: Integrity) -> dict[str, float | None]:
    """How far what is drawn along the path moves against the footage; nothing without corners."""
    distances_px = integrity.registration_px.get(name)
    if distances_px is None:
        return {}
    seen = distances_px[np.isfinite(distances_px)]  # a corner behind the camera has no distance
    return {"registration_rmse_px": float(np.sqrt(np.mean(seen**2))) if seen.size else None}


def _joined(
    first: dict[str, dict[str, float | None]], second: dict[str, dict[str, float | None]]
) -> dict[str, dict[str, float | None]]:
    return {name: first[name] | second[name] for name in first}


def _series(path: Trajectory, truth: Trajectory, align: Align, start_ns: int) -> ErrorSeries:
    pairs = associate(path, truth)
    aligned = alignment_of(pairs, align).apply(pairs.estimate)
    return ErrorSeries(
        time_s=np.asarray((pairs.time_ns - start_ns) * 1e-9),
        position_m=absolute_translation_m(aligned, pairs.reference),
        rotation_deg=np.rad2deg(rotation_rad(aligned, pairs.reference)),
    )


def _acceleration(path: Trajectory, start_ns: int) -> AccelerationSeries:
    if len(path) < 3:
        return AccelerationSeries(np.zeros(0), np.zeros(0))
    _, angular = accelerations(path.time_s, path.motors)
    time_s = np.asarray((path.time_ns[1:-1] - start_ns) * 1e-9)
    return AccelerationSeries(time_s, np.linalg.norm(angular, axis=-1))
