"""Visual SLAM on every recording present: accuracy of every frame, and milliseconds a frame.

Each recording is run as it is, with a part switched off, and with mapping in a second thread (then
in the recording's own time, frames as they would come). A loop is drawn, since no recording here
has one. Where lengths are metres the paths are compared after a rigid alignment, with one camera
alone after a similarity. Nothing is tuned a recording. The recordings lie where MOTORCADE_DATA
says.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.ga import Trajectory
from tests.bench.data import data_folder

if TYPE_CHECKING:
    from motorcade.replays.io.recording import Recording

__all__ = ["bench_slam", "slam_table"]

_RUNS = (
    ("7scenes_redkitchen", "depth"),
    ("7scenes_redkitchen", "one camera"),
    ("kitti_short", "one camera"),
    ("vamr_board", "one camera"),
)
_SWITCHES: dict[str, dict[str, bool]] = {
    "": {},
    "no local mapping": {"adjust": False},
    "no culling": {"cull_keyframes": False},
    "two threads": {"threads": True},
}
_LOOP = {**_SWITCHES, "no loop closing": {"close_loops": False}}
_MANIFESTS = Path(__file__).parents[3] / "docs" / "manifests"


def bench_slam(switches: Iterable[str] = _LOOP) -> dict[str, Any]:
    """Run every recording that is present, and a drawn loop, with each of these parts switched off.

    Args:
        switches: of `_LOOP`; "" is none, as recordings are run.
    """
    from motorcade.replays.io.readers.opening import open_recording
    from tests.textured_room.recording import write_recording
    from tests.textured_room.scenarios import scenario

    rows, left_out, chosen = [], [], tuple(switches)
    folder = data_folder()
    for name, kind in _RUNS:
        root = folder / "replays" / name
        if not root.is_dir():
            left_out.append(f"{name}: not below {folder}; set MOTORCADE_DATA")
            continue
        manifest = _MANIFESTS / f"{name}.toml"
        recording = open_recording(root, manifest if manifest.is_file() else None)
        rows += [_run(recording, name, kind, one) for one in _SWITCHES if one in chosen]
    with tempfile.TemporaryDirectory() as drawn:
        write_recording(Path(drawn), scenario("loop"), name="drawn loop")
        recording = open_recording(Path(drawn))
        for kind in ("depth", "pair", "one camera"):
            rows += [_run(recording, "drawn loop", kind, one) for one in _LOOP if one in chosen]
    return {"rows": rows, "left_out": sorted(set(left_out))}


def _run(recording: Recording, name: str, kind: str, switch: str) -> dict[str, Any]:
    from motorcade.tracking.slam import SlamSettings, VisualSlam

    if recording.camera is None or recording.truth is None:
        raise ValueError(f"{name}: expected a camera and a ground truth, got a recording without")
    baseline_m = recording.baseline_m if kind == "pair" else None
    settings = SlamSettings(baseline_m=baseline_m, **_LOOP[switch])
    slam, spent = VisualSlam(recording.camera, settings), []
    begun = perf_counter()
    for frame in recording.frames:
        gray = frame.gray()
        depth_m = frame.depth_m() if kind == "depth" else None
        right = frame.right() if kind == "pair" else None
        if settings.threads:
            due_s = 1e-9 * (frame.time_ns - recording.frames.time_ns[0])
            sleep(max(due_s - (perf_counter() - begun), 0.0))
        start = perf_counter()
        slam.track(frame.time_ns, gray, depth_m, right)
        spent.append(1e3 * (perf_counter() - start))
    start = perf_counter()
    result = slam.finish()
    row: dict[str, Any] = {
        "recording": name,
        "kind": kind,
        "switch": switch,
        "frames": len(spent),
        "states": dict(Counter(result.states)),
        "keyframes": len(result.map.time_ns),
        "loops": len(result.loops),
        "frame_mean_ms": float(np.mean(spent)),
        "frame_median_ms": float(np.median(spent)),
        "frame_worst_ms": float(np.max(spent)),
        "frame_p95_ms": float(np.quantile(spent, 0.95)),
        "finish_s": perf_counter() - start,
    }
    for which, path in (("final", result.trajectory), ("online", result.online)):
        row[which] = None
        if path is not None and len(path) >= 3:
            row[which] = _figures(path, recording.truth, result.metric)
    return row


def _figures(path: Trajectory, truth: Trajectory, metric: bool) -> dict[str, Any]:
    from motorcade.fusion.metrics import evaluate

    found = evaluate(path, truth, align="se3" if metric else "sim3")
    first = evaluate(path[:100], truth, align="se3" if metric else "sim3")
    length_m = float(np.linalg.norm(np.diff(truth.poses.translation_m, axis=0), axis=1).sum())
    expected = truth.motors_at(path.time_ns[[0, -1]])
    turns = [poses[0].inverse() @ poses[1] for poses in (expected, path.motors[[0, -1]])]
    apart_rad = float((turns[0].inverse() @ turns[1]).rotor.angle())
    return {
        "poses": len(path),
        "ape_rmse_m": found.ape_m.rmse,
        "first_100_ape_rmse_m": first.ape_m.rmse,
        "rotation_rmse_deg": found.rotation_deg.rmse,
        "ape_over_path": found.ape_m.rmse / length_m,
        "end_rotation_deg_m": float(np.degrees(apart_rad)) / length_m,
    }


def slam_table(found: Mapping[str, Any]) -> str:
    """A line a run and path."""
    heads = ("APE mm", "0-99 mm", "APE/path%", "end deg/m", "ms", "worst ms", "keyframes")
    lines = [f"{'visual SLAM, every frame':<60}{'poses':>9}" + "".join(f"{h:>10}" for h in heads)]
    for row in found["rows"]:
        for which in ("online", "final"):
            path = row[which]
            switch = f", {row['switch']}" if row["switch"] else ""
            name = f"{row['recording']}, {row['kind']}{switch}, {which}"
            if path is None:
                lines.append(f"{name:<60} no path: {row['states']}")
                continue
            poses = f"{path['poses']}/{row['frames']}"
            lines.append(
                f"{name:<60}{poses:>9}{1e3 * path['ape_rmse_m']:>10.2f}"
                f"{1e3 * path['first_100_ape_rmse_m']:>10.2f}{100 * path['ape_over_path']:>10.3f}"
                f"{path['end_rotation_deg_m']:>10.4f}{row['frame_mean_ms']:>10.1f}"
                f"{row['frame_worst_ms']:>10.1f}{row['keyframes']:>10}"
            )
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)
