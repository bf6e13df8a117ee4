"""`python -m tests.end_to_end.tagslam [TEST ...]`: TagSLAM's own tests as a scoreboard.

Each recording is mapped by all that it states, and the path of its rig (or, where its cameras stand
still, of the body that moves before them) compared with TagSLAM's result, in the same world and
after rigid alignment; the better one counts. Agreement is not accuracy: the reference was made from
the same corners. Beside each row stand the last figures kept here, and the audit where it denies
something. `--keep` writes the new ones. Ends with 1 where a recording fails, or agrees worse than
it did by a tenth and a millimetre.

    python -m tests.end_to_end.tagslam               # all at hand
    python -m tests.end_to_end.tagslam 1 21 --keep   # two of them, and their figures kept
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.readers.ros.reader import EmptyBag
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.replays.io.readers.tagslam.recording import TagSlamReference, read_reference
from motorcade.tracking.audit import worst
from motorcade.tracking.markers.scenes import map_scene
from motorcade.tracking.markers.scenes.mapped import MappedScene
from tests.bench.tracking.tag_flips import tagslam_folder

KEPT = Path(__file__).with_name("tagslam.json")
AGREES_M, AGREES_DEG = 0.010, 0.5
FEWEST = 3


def judged_body(found: MappedScene) -> str:
    """Name of the body whose path is compared."""
    scene, seen = found.scene, found.seen
    names = {body.name: body for body in scene.bodies}
    carrier = names[scene.camera_body[seen.names[0]]]
    if carrier.moves:
        return carrier.name
    counts = np.bincount(seen.marker_body[seen.marker], minlength=len(scene.bodies))
    moving = [k for k, body in enumerate(scene.bodies) if body.moves]
    return scene.bodies[max(moving, key=lambda k: int(counts[k]))].name


def path_of(reference: TagSlamReference, body: str) -> Trajectory | None:
    """TagSLAM's path of a body; None where it has too few poses."""
    rows = [row for row, frames in enumerate(reference.world_T_frame) if body in frames]
    if len(rows) < FEWEST:
        return None
    poses = Motor.stack([reference.world_T_frame[row][body] for row in rows])
    return Trajectory(reference.time_ns[rows], poses, "world", body)


def row_of(root: Path) -> dict[str, Any]:
    """Map a recording and compare it with its reference."""
    recording = tagslam.read_corners(root)
    start = time.process_time()
    found = map_scene(recording.streams, recording.scene)
    seconds = time.process_time() - start
    body = judged_body(found)
    path = found.body(body).trajectory
    row: dict[str, Any] = {
        "posed": len(path),
        "frames": len(found.seen.time_ns),
        "seconds": seconds,
        "verdict": worst(found.audit),
        "denied": [one.sentence for one in found.audit if not one.passed],
    }
    try:
        reference = path_of(read_reference(root), body)
    except EmptyBag:
        reference = None
    if reference is None:
        return row | {"reference": 0}
    both = [evaluate(path, reference, align=how) for how in ("none", "se3")]
    best = min(both, key=lambda one: one.ape_m.rmse / AGREES_M + one.rotation_deg.rmse / AGREES_DEG)
    return row | {
        "reference": len(reference),
        "pairs": best.pairs,
        "rmse_m": best.ape_m.rmse,
        "median_m": best.ape_m.median,
        "rotation_rmse_deg": best.rotation_deg.rmse,
    }


def agrees(row: dict[str, Any]) -> bool | None:
    """Whether a path agrees with its reference; None where there is nothing to agree with."""
    if "rmse_m" not in row:
        return None
    return bool(row["rmse_m"] <= AGREES_M and row["rotation_rmse_deg"] <= AGREES_DEG)


def line(name: str, row: dict[str, Any], kept: dict[str, Any]) -> str:
    """A row of the table, with the last figures beside."""
    posed = f"{row['posed']} of {row['frames']}"
    if "rmse_m" not in row:
        return f"{name:<9}{posed:>15}{'the reference holds nothing':>44}{row['seconds']:>8.1f} s"
    last = f"{1e3 * kept['rmse_m']:.1f}" if "rmse_m" in kept else "–"
    mark = "agrees" if agrees(row) else "apart"
    return (
        f"{name:<9}{posed:>15}{row['pairs']:>8}{1e3 * row['rmse_m']:>10.1f} mm "
        f"({1e3 * row['median_m']:.1f}, last {last}){row['rotation_rmse_deg']:>8.3f}° "
        f"{row['seconds']:>7.1f} s  {mark}"
    )


def worse(row: dict[str, Any], kept: dict[str, Any]) -> bool:
    """Whether a path agrees worse than it did."""
    if "rmse_m" not in kept:
        return False
    return bool(row.get("rmse_m", np.inf) > 1.1 * kept["rmse_m"] + 0.001)


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 1 where something failed or got worse."""
    parser = argparse.ArgumentParser(description="TagSLAM's own tests as a scoreboard")
    parser.add_argument("tests", nargs="*", metavar="TEST", help="numbers; all at hand by default")
    parser.add_argument("--keep", action="store_true", help="keep these figures")
    given = parser.parse_args(arguments)
    folder = tagslam_folder()
    roots = sorted(
        (one for one in folder.glob("test_*") if tagslam.recognise(one)),
        key=lambda one: int(one.name.partition("_")[2]),
    )
    if given.tests:
        roots = [one for one in roots if one.name.partition("_")[2] in given.tests]
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    made, failed = {}, []
    for root in roots:
        try:
            row = row_of(root)
        except Exception as fault:  # a scoreboard tells of every recording
            failed.append(f"{root.name}: {type(fault).__name__}: {fault}")
            print(failed[-1], flush=True)
            continue
        before = kept.get(root.name, {})
        print(line(root.name, row, before), flush=True)
        for one in row["denied"]:
            print(f"           {one}", flush=True)
        if worse(row, before):
            failed.append(f"{root.name}: agrees worse than it did")
        made[root.name] = {
            key: round(value, 5) if isinstance(value, float) else value
            for key, value in row.items()
            if key not in ("denied", "seconds")
        }
    judged = [one for one in map(agrees, made.values()) if one is not None]
    print(f"{sum(judged)} of {len(judged)} agree to {1e3 * AGREES_M:.0f} mm and {AGREES_DEG}°")
    if given.keep:
        KEPT.write_text(json.dumps(kept | made, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    for one in failed:
        print(f"FAILED {one}", file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
