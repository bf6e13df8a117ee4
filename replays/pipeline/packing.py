"""Arrays as JSON (bytes in base64, little-endian, and a shape), and the camera's paths."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.fusion.metrics.poses.alignment import Alignment
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.pipeline.report.findings import LABELS, Findings, told_paths
from motorcade.replays.stages.view.overlay import extrapolated

KINDS = {"f32": "<f4", "f64": "<f8", "u32": "<u4"}


def packed(values: ArrayLike, kind: str = "f32") -> dict[str, Any]:
    """An array for `look.js`: "f32" for what is drawn, "f64" for poses and stamps, "u32".

    >>> from motorcade.replays.pipeline.packing import packed
    >>> packed([[1.0, 2.0]])
    {'f32': 'AACAPwAAAEA=', 'shape': [1, 2]}
    """
    array = np.ascontiguousarray(values, dtype=KINDS[kind])
    return {kind: text(array.tobytes()), "shape": list(array.shape)}


def packed_smooth(values: ArrayLike, finest: float) -> dict[str, Any]:
    """Rows ``(F, …)`` that change little from one to the next, each column in 16 bits.

    They are told as second differences, column after column, which the pages' compression makes a
    few bits each. Where 16 bits would be coarser than `finest` in some column, they are "f32".
    """
    array = np.asarray(values, dtype=np.float64)
    columns = array.reshape(len(array), -1)
    largest = np.abs(columns).max(axis=0, initial=0.0)
    step = np.where(largest > 0.0, largest, 1.0) / 32767
    if not np.all(largest <= 32767 * finest):  # nor where one is NaN
        return packed(array)
    numbers = np.rint(columns / step).astype(np.int64)
    blank = np.zeros((1, numbers.shape[1]), np.int64)
    twice = np.diff(np.diff(numbers, axis=0, prepend=blank), axis=0, prepend=blank)
    data = np.ascontiguousarray(twice.T).astype("<i2")  # modulo 2^16, as they are added up again
    return {"i16": text(data.tobytes()), "step": packed(step, "f64"), "shape": list(array.shape)}


def text(data: bytes) -> str:
    """Bytes in base64."""
    return base64.b64encode(data).decode("ascii")


MOST_POINTS = 5_000
"""Of a path's line; a longer one is thinned evenly."""


def shown_paths(findings: Findings, time_ns: IntArray) -> list[dict[str, Any]]:
    """Every path of a run, in its own world, with its poses at the frames' stamps ``(F,)``.

    The ground truth is brought into that world by the inverse of the alignment that errors are told
    by. A pose is NaN where a path has none.
    """
    measured = findings.camera_poses.measurements.trajectory
    trajectories = findings.smoothed.trajectories | {"fused": findings.fused.trajectory}
    paths_told = told_paths(findings)
    paths = {
        name: measured if name == "measured" else extrapolated(trajectories[name], measured)
        for name in paths_told
    }
    truth = _truth(findings)
    if truth is not None:
        paths["truth"] = truth
    start_ns = int(time_ns[0])
    return [
        _shown(name, paths_told.get(name) or LABELS[name], path, time_ns, start_ns)
        for name, path in paths.items()
    ]


def drawn_name(findings: Findings) -> str:
    """The path that the film is drawn along."""
    if findings.integrity.drawn_is == "measured":
        return "measured"
    return next(iter(findings.smoothed.trajectories))


def drawn_rows(findings: Findings, time_ns: IntArray) -> FloatArray:
    """Poses ``(F, 7)`` of the path that the film is drawn along, at the frames' stamps."""
    measured = findings.camera_poses.measurements.trajectory
    return rows_at(extrapolated(findings.integrity.drawn, measured), time_ns)


def _shown(
    name: str, label: str, path: Trajectory, time_ns: IntArray, start_ns: int
) -> dict[str, Any]:
    step = -(-len(path) // MOST_POINTS)
    return {
        "name": name,
        "label": label,
        "line_s": packed((path.time_ns[::step] - start_ns) * 1e-9, "f64"),
        "line_m": packed(path.poses.translation_m[::step]),
        "at_frames": packed(rows_at(path, time_ns), "f64"),
    }


def rows_at(path: Trajectory, time_ns: IntArray) -> FloatArray:
    """Poses ``(F, 7)`` at stamps: x y z, then w x y z of the quaternion; NaN outside the path."""
    rows = np.full((len(time_ns), 7), np.nan)
    inside = (time_ns >= path.time_ns[0]) & (time_ns <= path.time_ns[-1])
    if np.any(inside):
        rows[inside] = rows_of(path.motors_at(time_ns[inside]))
    return rows


def rows_of(poses: Motor) -> FloatArray:
    """Poses ``(*, 7)``: x y z, then w x y z."""
    wxyz, places = poses.as_quaternion_translation()
    return np.concatenate([places, wxyz], axis=-1)


def scaled_rows(poses: Motor | Similarity) -> FloatArray:
    """Poses ``(*, 8)``: x y z, then w x y z, then the scale."""
    if isinstance(poses, Motor):
        rows = rows_of(poses)
        return np.concatenate([rows, np.ones_like(rows[..., :1])], axis=-1)
    rigid, scale = poses.as_motor_scale()
    return np.concatenate([rows_of(rigid), scale[..., None]], axis=-1)


def _truth(findings: Findings) -> Trajectory | None:
    """The ground truth in the run's world, over the time of the frames; None without."""
    truth, poses = findings.recording.truth, findings.camera_poses
    if truth is None:
        return None
    times_ns = poses.frame_times_ns
    inside = (truth.time_ns >= times_ns.min()) & (truth.time_ns <= times_ns.max())
    if not np.any(inside):
        return None
    judged = next(iter(findings.smoothed.trajectories.values()))
    fit = alignment_of(associate(judged, truth), findings.errors.align)
    return back_home(fit).apply_to(truth[inside])


def back_home(fit: Alignment) -> Alignment:
    """From the ground truth's world to that of the run: the inverse of an alignment."""
    turn = fit.rotor.inverse()
    return Alignment(turn, -turn.apply(fit.translation_m) / fit.scale, 1.0 / fit.scale)
