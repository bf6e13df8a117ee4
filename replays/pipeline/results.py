"""What a run leaves in its output folder, each file at once or not at all."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from motorcade.ga import Trajectory
from motorcade.replays.engine.graph import GraphRun
from motorcade.replays.io.files import copy_file, write_bytes
from motorcade.replays.io.trajectories import write_trajectory
from motorcade.replays.pipeline.report.summary import without_nan

_OUR_TRAJECTORY = re.compile(r"(camera_poses|fused|smoothed)_[a-z_]+\.tum")
FILES = {
    "overlay.mp4": ("overlay", "path"),
    "report.html": ("report", "page"),
    "report.json": ("report", "summary"),
    "footage.mp4": ("report", "footage"),
    "viewer.html": ("report", "viewer"),
    "marker_map.json": ("marker_poses", "marker_map"),
    "slam_map.npz": ("slam_poses", "slam_map"),
    "slam_history.csv": ("slam_poses", "slam_history"),
}
"""Which stage leaves each file for users, and which field of its value that is: a path or, of a
map, a value with `save`.
"""
OWN_MANIFEST = "manifest.toml"
"""What a run that was told too little found out, as a manifest that repeats it."""


def require_writable(folder: Path) -> None:
    """Make `folder` where it is missing; OSError naming it where nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(
            f"{folder}: results cannot be written there ({error.strerror}); choose another --out"
        ) from error


def write_results(
    run: GraphRun, out: Path, about: Mapping[str, Any], manifest: str | None = None
) -> dict[str, Any]:
    """Write what a run computed into `out`, and the run log `run.json`, which begins with `about`.

    `manifest` is what was found out of a recording that told too little. Files of an earlier run
    that this one did not make are removed, so that what lies in `out` belongs together. Returns
    the report, or the run log of a run that stopped before it.
    """
    run_log = _run_log(run, about)
    written = _write_trajectories(run, out / "trajectories") | _write_files(run, out)
    if manifest is not None:
        write_bytes(out / OWN_MANIFEST, manifest.encode())
    write_bytes(out / "run.json", (json.dumps(run_log, indent=2) + "\n").encode())
    of_earlier_runs = [out / name for name in FILES] + [
        path
        for path in (out / "trajectories").glob("*.tum")
        if _OUR_TRAJECTORY.fullmatch(path.name)
    ]
    for path in of_earlier_runs:
        if path not in written:
            path.unlink(missing_ok=True)
    pages = run.outputs.get("report")
    return run_log if pages is None else dict(json.loads(pages.summary.read_text("utf-8")))


def trajectories(run: GraphRun) -> dict[str, Trajectory]:
    """`<stage>_<representation>` of every trajectory that a run computed."""
    named = {}
    if "camera_poses" in run.outputs:
        named["camera_poses_motor"] = run.outputs["camera_poses"].measurements.trajectory
    if "fused" in run.outputs:
        named["fused_motor"] = run.outputs["fused"].trajectory
    if "smoothed" in run.outputs:
        for representation, trajectory in run.outputs["smoothed"].trajectories.items():
            named[f"smoothed_{representation}"] = trajectory
    return named


def _run_log(run: GraphRun, about: Mapping[str, Any]) -> dict[str, Any]:
    """What was run, how each stage came to its output and what time that took, and the errors."""
    run_log = dict(about) | {
        "stages": {record.stage: asdict(record) for record in run.records},
        "chosen": dict(run.chosen),
        "unavailable": dict(run.unavailable),
    }
    poses, film = run.outputs.get("camera_poses"), run.outputs.get("overlay")
    if poses is not None:
        run_log["tracking"] = {"seconds": poses.seconds, "frames_per_s": poses.frames_per_s}
    if film is not None:
        run_log["drawing"] = {"seconds": film.seconds}
    if "integrity" in run.outputs:
        run_log["integrity"] = run.outputs["integrity"].as_dict()
    if "errors" in run.outputs:
        judged = run.outputs["errors"]
        run_log |= {"align": judged.align, "errors": without_nan(judged.figures)}
        run_log |= {"unaligned": judged.unaligned or None}
        run_log |= {"stage_comparison": judged.stages.as_dict()}
    return run_log


def _write_trajectories(run: GraphRun, folder: Path) -> set[Path]:
    named = {folder / f"{name}.tum": one for name, one in trajectories(run).items()}
    for path, trajectory in named.items():
        write_trajectory(trajectory, path)
    return set(named)


def _write_files(run: GraphRun, out: Path) -> set[Path]:
    """The video, the report, and the maps that poses were measured in."""
    written = set()
    for name, (stage, field) in FILES.items():
        value = getattr(run.outputs.get(stage), field, None)
        if value is None:
            continue
        if isinstance(value, Path):
            copy_file(value, out / name)
        else:
            _save(value.save, out / name)
        written.add(out / name)
    return written


def _save(save: Callable[[Path], None], path: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        save(Path(folder) / path.name)
        copy_file(Path(folder) / path.name, path)
