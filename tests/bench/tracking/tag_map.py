"""`make bench SUITE=tracking`, map: an unknown layout of markers from TagSLAM's test_21 alone.

Corners of a rig's cameras are all that goes in: no reference, no odometry, and of the cameras'
places only the first one's, which defines the rig. What comes out is compared with TagSLAM's own
result, which was made from the same corners and odometry: agreement, not accuracy.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.replays.io.readers.tagslam.recording import read_reference
from motorcade.tracking.markers.mapping import map_markers, track_rig
from tests.bench.tracking.tag_flips import tagslam_folder

__all__ = ["bench_map", "map_table", "reference_path"]

RECORDING = "test_21"
_CASES: tuple[tuple[str, tuple[str, ...], bool], ...] = (
    ("first camera only", ("cam0",), True),
    ("four cameras", ("cam0", "cam1", "cam2", "cam3"), True),
    ("four cameras, flips left in", ("cam0", "cam1", "cam2", "cam3"), False),
)


def reference_path(root: Path) -> Trajectory:
    """World_T_rig by TagSLAM, from its transforms; `root` is the recording's folder."""
    reference = read_reference(root)
    poses = Motor.stack([frame["rig"] for frame in reference.world_T_frame])
    return Trajectory(reference.time_ns, poses, "world", "rig")


def bench_map(folder: Path | None = None) -> list[dict[str, Any]]:
    """Map test_21 in each way, and track it by the map of all cameras.

    Args:
        folder: where TagSLAM's recordings lie; None looks in `MOTORCADE_DATA`, or else in
            `../shared/data`.
    """
    root = (folder or tagslam_folder()) / RECORDING
    if not tagslam.recognise(root):
        return []
    recording, reference = tagslam.read_corners(root), reference_path(root)
    rows = []
    for name, cameras, over_time in _CASES:
        streams = {camera: recording.streams[camera] for camera in cameras}
        known = {"cam0": recording.rig_T_camera["cam0"]}
        start = time.perf_counter()
        found = map_markers(streams, recording.side_m, known, over_time=over_time)
        seconds = time.perf_counter() - start
        frames = np.unique(np.concatenate([one.time_ns[one.frame] for one in streams.values()]))
        with_marker = _frames_with_marker(found.time_ns, frames)
        row = {"case": name, "markers": len(found.marker_map), "left_out": len(found.left_out)}
        rows.append(row | _figures(found.trajectory, reference, with_marker, seconds))
        if over_time and len(cameras) > 1:
            start = time.perf_counter()
            again = track_rig(found.marker_map, streams, found.rig_T_camera)
            row = {"case": "tracked by that map", "markers": len(found.marker_map), "left_out": 0}
            seconds = time.perf_counter() - start
            rows.append(row | _figures(again.trajectory, reference, with_marker, seconds))
    return rows


def _frames_with_marker(rig_ns: Any, seen_ns: Any) -> int:
    """How many of the rig's frames hold a stamp at which some camera saw a marker."""
    nearest = np.abs(rig_ns[:, None] - seen_ns[None, :])
    return len(np.unique(np.argmin(nearest, axis=0)))


def _figures(
    path: Trajectory, reference: Trajectory, with_marker: int, seconds: float
) -> dict[str, Any]:
    judged = evaluate(path, reference, align="se3")
    return {
        "frames_with_marker": with_marker,
        "frames_posed": len(path),
        "ape_rmse_m": judged.ape_m.rmse,
        "rotation_rmse_deg": judged.rotation_deg.rmse,
        "seconds": seconds,
    }


def map_table(rows: list[Mapping[str, Any]]) -> str:
    """A row a case."""
    if not rows:
        return f"map: {RECORDING} is not here; set MOTORCADE_DATA to the recordings' folder"
    title = f"{RECORDING}, map of markers"
    lines = [f"{title:<30}{'markers':>9}{'frames posed':>16}{'APE mm':>9}{'deg':>7}{'s':>7}"]
    for row in rows:
        posed = f"{row['frames_posed']} of {row['frames_with_marker']}"
        lines.append(
            f"{row['case']:<30}{row['markers']:>9}{posed:>16}{1e3 * row['ape_rmse_m']:>9.2f}"
            f"{row['rotation_rmse_deg']:>7.2f}{row['seconds']:>7.1f}"
        )
    return "\n".join(lines)
