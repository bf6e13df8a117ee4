"""Each stage's path beside the one that it was given: by ground truth, or by held-out poses.

Paths are judged at the same stamps, so that one is not the worse for going on where another has
ended. By the ground truth a difference of 2 % is told, and whether it is within chance; by held-out
poses (`fusion.prediction`), which have errors of their own, only what chance does not explain. The
stage is run again without them; what comes of the tracked poses alone is the curve through them: a
fair rival, as it bends with the motion.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from itertools import pairwise
from typing import Literal

import numpy as np

from motorcade.fusion.metrics import (
    Align,
    absolute_translation_m,
    alignment_of,
    associate,
    rotation_rad,
)
from motorcade.fusion.prediction import held_out, judged_stamps, surely_grown
from motorcade.fusion.smoothing import PathCurve
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import NOT_COMPARED, StageComparison
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.tracking import PoseMeasurements

TOLERANCE = 0.02
"""Relative to the error before; below it nobody would choose one path for it."""
_CHANCE = 0.025
"""Of each of two figures, position and rotation."""
_FEWEST = 5
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
    paths = {
        "camera_poses": camera_poses.measurements.trajectory,
        "fused": fused.trajectory,
        "smoothed": next(iter(smoothed.trajectories.values())),  # which is drawn along
    }
    # All are measured ones, so that no path is judged where it bridges.
    common = reduce(np.intersect1d, [path.time_ns for path in paths.values()])
    errors: Errors = {}
    for name, path in paths.items():
        pairs = associate(path[np.isin(path.time_ns, common)], truth)
        aligned = alignment_of(pairs, align).apply(pairs.estimate)
        errors[name] = _apart(aligned, pairs.reference)
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
    paths = {"camera_poses": measured[~held_out(len(measured))], **there}
    for path in paths.values():
        stamps = stamps[(stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1])]
    if len(stamps) < _FEWEST or min(map(len, paths.values())) < _FEWEST:
        return NOT_COMPARED
    true = measured.motors[np.searchsorted(measured.time_ns, stamps)]
    at_held_out = {name: PathCurve(path).at(stamps) for name, path in paths.items()}
    errors = {name: _apart(predicted, true) for name, predicted in at_held_out.items()}
    position = np.stack([one[0] for one in errors.values()])
    good = np.any(position <= _OUTLIER * np.median(position, axis=1, keepdims=True), axis=0)
    errors = {name: (m[good], deg[good]) for name, (m, deg) in errors.items()}
    unit = "m" if camera_poses.metric else "units"
    return _compared("held-out poses", errors, fused, unit)


def _apart(
    estimated: Motor | Similarity, true: Motor | Similarity
) -> tuple[FloatArray, FloatArray]:
    ours, others = estimated.rigid, true.rigid
    return absolute_translation_m(ours, others), np.rad2deg(rotation_rad(ours, others))


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
            surely = surely_grown(errors[before][which], errors[after][which], _CHANCE)
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


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


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
