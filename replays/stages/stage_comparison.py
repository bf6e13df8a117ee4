"""Each stage's path beside the one that it was given: by ground truth, or by held-out poses.

Paths are judged at the same stamps, so that one is not the worse for going on where another has
ended. By the ground truth a difference of 2 % is told, and whether it is within chance; by held-out
poses, which have errors of their own, only what chance does not explain.

Every fifth measured pose is left out, the stage is run again without them, and the path is asked
where the camera was there. What comes of the tracked poses alone is their cubic: a fair rival, as
it bends with the motion. Errors that last from frame to frame, as of a wrong calibration, are in
the held-out poses as well, and are not seen.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics import (
    Align,
    absolute_translation_m,
    alignment_of,
    associate,
    rotation_rad,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import NOT_COMPARED, StageComparison
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.tracking import PoseMeasurements

TOLERANCE = 0.02
"""Relative to the error before; below it nobody would choose one path for it."""
_BLOCKS = 20
_CHANCE = 2.09
"""Student's t of 19 degrees of freedom, beyond which 5 % lie: errors of 20 segments, which last
within a segment and hardly from one to the next."""
_LEAST = np.finfo(np.float64).tiny
_OUTLIER = 5.0
"""A held-out pose that every path misses by so many times its median is an outlier itself."""

Errors = dict[str, tuple[FloatArray, FloatArray]]


def compared_by_truth(
    recording: Recording,
    camera_poses: CameraPoses,
    fused: FusedPath,
    smoothed: SmoothedPaths,
    align: Align,
) -> StageComparison:
    """Errors of all paths at the stamps that all of them and the ground truth have."""
    truth = recording.truth
    if truth is None:
        raise ValueError(f"{recording.name}: expected a ground truth to judge by, got none")
    paths = _paths(camera_poses, fused, smoothed)
    common = _common(paths)
    errors: Errors = {}
    for name, path in paths.items():
        pairs = associate(path[np.isin(path.time_ns, common)], truth)
        aligned = alignment_of(pairs, align).apply(pairs.estimate)
        errors[name] = (
            absolute_translation_m(aligned, pairs.reference),
            np.rad2deg(rotation_rad(aligned, pairs.reference)),
        )
    return _compared("ground truth", errors, fused, "m")


def compared_by_held_out(
    camera_poses: CameraPoses, fused: FusedPath, smoothed: SmoothedPaths | None = None
) -> StageComparison:
    """Errors of all paths, made without some measured poses, at the stamps of these."""
    measured = camera_poses.measurements.trajectory
    held_out_paths = {"fused": fused.held_out}
    if smoothed is not None:
        held_out_paths["smoothed"] = smoothed.held_out
    there = {name: path for name, path in held_out_paths.items() if path is not None}
    if len(there) < len(held_out_paths):
        return NOT_COMPARED
    stamps = judged_stamps(measured)
    paths = {"camera_poses": measured[~np.isin(measured.time_ns, stamps)], **there}
    stamps = stamps[_inside(tuple(paths.values()), stamps)]
    if len(stamps) < _BLOCKS // 4:
        return NOT_COMPARED
    true = measured.motors[np.searchsorted(measured.time_ns, stamps)]
    errors = {name: _apart(at_stamps(path, stamps), true) for name, path in paths.items()}
    position = np.stack([one[0] for one in errors.values()])
    good = np.any(position <= _OUTLIER * np.median(position, axis=1, keepdims=True), axis=0)
    errors = {name: (m[good], deg[good]) for name, (m, deg) in errors.items()}
    unit = "m" if camera_poses.metric else "units"
    return _compared("held-out poses", errors, fused, unit)


def _paths(
    camera_poses: CameraPoses, fused: FusedPath, smoothed: SmoothedPaths
) -> dict[str, Trajectory]:
    """By the stage that made it; of the smoothed ones the first, which is drawn along."""
    return {
        "camera_poses": camera_poses.measurements.trajectory,
        "fused": fused.trajectory,
        "smoothed": next(iter(smoothed.trajectories.values())),
    }


def _common(paths: dict[str, Trajectory]) -> IntArray:
    """Stamps of all paths; only of measured ones, so that no path is judged where it bridges."""
    stamps = [path.time_ns for path in paths.values()]
    shared = stamps[0]
    for path_stamps in stamps[1:]:
        shared = np.intersect1d(shared, path_stamps)
    return shared


def _inside(paths: tuple[Trajectory, ...], stamps: IntArray) -> NDArray[np.bool_]:
    """Whether every path has two poses on both sides, or one there."""
    good = np.ones(len(stamps), dtype=np.bool_)
    for path in paths:
        row = np.searchsorted(path.time_ns, stamps)
        good &= ((row > 1) & (row < len(path) - 1)) | np.isin(stamps, path.time_ns)
        good &= len(path) >= 4
    return good


def _apart(estimated: Motor, true: Motor) -> tuple[FloatArray, FloatArray]:
    return absolute_translation_m(estimated, true), np.rad2deg(rotation_rad(estimated, true))


def _compared(
    judged_by: Literal["ground truth", "held-out poses"],
    errors: Errors,
    fused: FusedPath,
    unit: str,
) -> StageComparison:
    """The figures, and a sentence for each that grew."""
    names = list(errors)
    rms = {name: (_rms(m), _rms(deg)) for name, (m, deg) in errors.items()}
    worse = []
    for before, after in pairwise(names):
        grown = []
        chance = True
        for which, shown in enumerate((unit, "°")):
            was, now = rms[before][which], rms[after][which]
            surely = _beyond_chance(errors[before][which], errors[after][which])
            if now > (1.0 + TOLERANCE) * was and (surely or judged_by == "ground truth"):
                grown.append(_grown(was, now, shown))
                chance = chance and not surely
        if grown:
            why = "which is within chance" if chance else _reason(after, fused)
            worse.append(
                f"{after} is farther from the {judged_by} than {before} "
                f"({' and '.join(grown)}): {why}"
            )
    count = len(errors[names[0]][0])
    position, rotation = ({name: rms[name][k] for name in names} for k in (0, 1))
    return StageComparison(judged_by, count, position, rotation, tuple(worse))


def _grown(was: float, now: float, unit: str) -> str:
    factor = 1e3 if unit == "m" else 1.0
    shown = "mm" if unit == "m" else unit
    gap = "" if shown == "°" else " "
    return f"{factor * was:.3g} to {factor * now:.3g}{gap}{shown}"


def _reason(stage: str, fused: FusedPath) -> str:
    """What a stage does that can do this, with the figure that tells."""
    if stage == "smoothed":
        return "what it took away was motion, or noise that both have"
    if fused.by == "odometry":
        return "the odometry contradicts the measured poses"
    nis = fused.nis[np.isfinite(fused.nis)]
    mean = float(np.mean(nis)) / 6.0 if nis.size else float("nan")
    refused = int(np.count_nonzero(~fused.accepted))
    return (
        f"the IMU contradicts the measured poses (mean NIS {mean:.3g} a dimension where 1 is "
        f"expected, {refused} refused)"
    )


def _beyond_chance(before: FloatArray, after: FloatArray) -> bool:
    """Whether errors grew by a factor that segments of the recording do not have by chance.

    Of differences of squares, a segment where the path is lost would hide how all others grew.
    """
    if len(before) < 2 * _BLOCKS:
        return False
    was, now = (
        np.log([max(np.mean(part**2), _LEAST) for part in np.array_split(errors, _BLOCKS)])
        for errors in (before, after)
    )
    grown = now - was
    return bool(grown.mean() > _CHANCE * grown.std(ddof=1) / np.sqrt(_BLOCKS))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


EVERY = 5
"""Of so many measured poses one is held out: its neighbours on both sides are kept, and those that
a cubic takes besides."""
FEWEST = 40
"""Measured poses below which too few are held out (8) for a root mean square to mean anything."""
REACH = 3.0
"""A held-out pose with no kept one within so many usual intervals stands in a gap, where only
prediction is judged, not the path."""


def held_out(count: int) -> NDArray[np.bool_]:
    """Which of so many measured poses ``(count,)`` are held out; none of a few."""
    rows = np.arange(count) % EVERY == EVERY // 2
    return rows if count >= FEWEST else np.zeros(count, dtype=np.bool_)


def without_held_out(camera_poses: CameraPoses) -> CameraPoses | None:
    """The measured poses that are kept; None where there are too few to hold any out."""
    poses = camera_poses.measurements
    kept = ~held_out(len(poses))
    if kept.all():
        return None
    measurements = PoseMeasurements(poses.trajectory[kept], poses.covariance[kept])
    return replace(
        camera_poses, measurements=measurements, reprojection_px=camera_poses.reprojection_px[kept]
    )


def judged_stamps(measured: Trajectory) -> IntArray:
    """Stamps of held-out poses with kept ones near on both sides."""
    out = held_out(len(measured))
    kept_ns, stamps = measured.time_ns[~out], measured.time_ns[out]
    after = np.searchsorted(kept_ns, stamps)
    inside = (after > 1) & (after < len(kept_ns) - 1)
    stamps, after = stamps[inside], after[inside]
    usual_ns = float(np.median(np.diff(measured.time_ns)))
    near: NDArray[np.bool_] = kept_ns[after] - kept_ns[after - 1] <= REACH * usual_ns
    return stamps[near]


def at_stamps(path: Trajectory, stamps: IntArray) -> Motor:
    """Poses ``(n,)`` of a path: its own where it has some there, else the cubic of four neighbours.

    The stamps have two poses of the path on both sides.
    """
    row = np.searchsorted(path.time_ns, stamps)
    own = path.time_ns[np.minimum(row, len(path) - 1)] == stamps
    first = np.clip(row - 2, 0, len(path) - 4)
    rows = np.where(own[:, None], row[:, None], first[:, None] + np.arange(4))
    base = path.motors[rows[:, 1]]
    around = base[:, None].local(path.motors[rows])
    times = (path.time_ns[rows] - stamps[:, None]) * 1e-9
    weights = _lagrange(np.where(own[:, None], np.arange(4), times))  # of one pose, any would do
    return base.retract(np.einsum("nk,nkc->nc", weights, around))


def _lagrange(times: FloatArray) -> FloatArray:
    """Weights ``(n, 4)`` of the cubic through times ``(n, 4)``, at zero."""
    weights = np.ones_like(times)
    for k in range(4):
        for j in range(4):
            if j != k:
                weights[:, k] *= -times[:, j] / (times[:, k] - times[:, j])
    return weights
