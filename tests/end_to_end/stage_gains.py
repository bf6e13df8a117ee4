"""What each stage of the pipeline gains on every recording at hand, or why it does not.

    python -m tests.end_to_end.stage_gains [NAME …] [--out DIR]

Runs every recording below `MOTORCADE_DATA` up to the errors, and prints how far camera_poses, fused
and smoothed are from the ground truth at the stamps that all of them have. EuRoC's flights come
without images here: camera poses are simulated from their ground truth, with a blackout of two
seconds. Below stands what the run says of it: stages that are worse, and doubts. Ends with 1 where
a stage is more than 2 % worse than the one before and the run does not say so, where a path that
is turned beyond recognition is not doubted, or where a measured pose is lost. With `--out` results
are kept, and not computed again.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.replays.demo.recording import ensure_demo_recording
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.replays.pipeline.job import Job, run_job
from tests.bench.data import data_folder

MANIFESTS = Path(__file__).resolve().parents[2] / "docs" / "manifests"
STAGES = ("camera_poses", "fused", "smoothed")
TOLERANCE = 0.02
BEYOND_RECOGNITION_DEG = 30.0
FLIGHTS = {
    "MH_05": ("imu/flights/MH05_imu.txt", "imu/flights/MH_05_difficult.csv"),
    "V1_02": ("imu/V102_imu.txt", "imu/V1_02_medium.csv"),
    "V1_03": ("imu/flights/V103_imu.txt", "imu/flights/V1_03_difficult.csv"),
    "V2_02": ("imu/flights/V202_imu.txt", "imu/flights/V2_02_medium.csv"),
}
FLIGHT = """name = "{name}"
settings = ["tracked.by=simulated", "camera_poses.blackouts_s=40,42"]
[frames]
images = "*.png"
stamps = "stamps.txt"
stamps_unit = "ns"
[camera]
model = "pinhole"
fx = 60.0
fy = 60.0
cx = 31.5
cy = 23.5
[truth]
file = "truth.csv"
format = "euroc"
convention = "world_T_imu"
[imu]
file = "imu.csv"
imu_T_camera = [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]
"""


@dataclass(frozen=True)
class Given:
    """A recording to run."""

    name: str
    path: Path
    manifest: Path | None = None


def recordings(data: Path, made: Path, names: list[str]) -> Iterator[Given]:
    """Those below the folder of recordings; flights and the demo's are written into another one."""
    tags = data / "tags" / "tagslam"
    for path in sorted(tags.glob("test_*"), key=lambda one: int(one.name.partition("_")[2])):
        yield Given(path.name, path)
    replays = data / "replays"
    for name, manifest in (
        ("vamr_board", "vamr_board.toml"),
        ("euroc_V1_01", "euroc_v1_01.toml"),
        ("kitti_short", None),
        ("7scenes_redkitchen", None),
        ("7scenes_redkitchen_200", None),
        ("gopro/karma.mp4", "gopro_karma.toml"),
    ):
        if (replays / name).exists():
            yield Given(name, replays / name, manifest and MANIFESTS / manifest)
    for name, (imu, truth) in FLIGHTS.items():
        if (data / imu).is_file():
            yield Given(name, _flight(made / name, name, data / imu, data / truth))
    if not names or "demo" in names:
        yield Given("demo", ensure_demo_recording(made / "demo", 0))


def _flight(folder: Path, name: str, imu: Path, truth: Path) -> Path:
    """A flight as a recording, with two grey images that nothing looks at."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(2):
        cv2.imwrite(str(folder / f"{number}.png"), np.full((48, 64), 128, np.uint8))
    shutil.copy(imu, folder / "imu.csv")
    shutil.copy(truth, folder / "truth.csv")
    start_ns = int(read_trajectory(truth).time_ns[0])
    (folder / "stamps.txt").write_text(f"{start_ns}\n{start_ns + 50_000_000}\n")
    (folder / "motorcade.toml").write_text(FLIGHT.format(name=name), encoding="utf-8")
    return folder


def row(given: Given, out: Path) -> tuple[str, list[str]]:
    """A line of the table, and what is wrong."""
    try:
        log = run_job(Job(given.path, out, given.manifest, until="errors"))
    except (ValueError, OSError, RuntimeError) as refused:
        return f"{given.name:<24}{'refused: ' + str(refused).splitlines()[0]:.150}", []
    compared = log["stage_comparison"]
    doubts = log["integrity"]["doubts"]
    faults = unsaid(compared) + lost(out / "trajectories")
    turned_deg = compared["rotation_rmse_deg"].get("camera_poses", 0.0)
    if turned_deg > BEYOND_RECOGNITION_DEG and not doubts:
        faults.append(f"the tracked path is turned by {turned_deg:.0f}° and not doubted")
    shown = [f"{given.name:<24}"]
    for stage in STAGES:
        if stage in compared["position_rmse_m"]:
            off_m, off_deg = (
                compared[key][stage] for key in ("position_rmse_m", "rotation_rmse_deg")
            )
            shown.append(f"{1e3 * off_m:>10.4g}{off_deg:>9.4f}")
        else:
            shown.append(f"{'–':>10}{'–':>9}")
    shown.append(f"{compared['poses']:>7}  {compared['judged_by']}")
    lines = ["".join(shown)]
    notes = [*compared["worse"], *([log["unaligned"]] if log["unaligned"] else [])]
    lines += [f"    {note}" for note in notes] + [f"    doubtful: {one}" for one in doubts]
    return "\n".join(lines), [f"{given.name}: {fault}" for fault in faults]


def unsaid(compared: dict[str, Any]) -> list[str]:
    """Stages that are worse than the one before, of which the run says nothing."""
    faults = []
    for before, after in pairwise(STAGES):
        for key in ("position_rmse_m", "rotation_rmse_deg"):
            found = compared[key]
            if after not in found or compared["judged_by"] != "ground truth":
                continue
            grown = found[after] > (1.0 + TOLERANCE) * found[before]
            if grown and not any(one.startswith(after) for one in compared["worse"]):
                faults.append(f"{after} is worse than {before} in silence ({key})")
    return faults


def lost(folder: Path) -> list[str]:
    """Stages that have no pose where one was measured."""
    measured, *others = (read_trajectory(folder / f"{stage}_motor.tum") for stage in STAGES)
    return [
        f"{stage} lost {count} of {len(measured)} measured poses"
        for stage, path in zip(STAGES[1:], others, strict=True)
        if (count := int(np.count_nonzero(~np.isin(measured.time_ns, path.time_ns))))
    ]


def main(arguments: list[str] | None = None) -> int:
    """Run and print; 1 where something is worse in silence."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="of recordings; all of them")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keeps results, for another time")
    given = parser.parse_args(arguments)
    heads = "".join(f"{stage + ' mm':>15}{'°':>4}" for stage in STAGES)
    print(f"{'':<24}{heads}{'poses':>7}  judged by", flush=True)
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as scratch:
        out = given.out or Path(scratch) / "out"
        for one in recordings(data_folder(), Path(scratch) / "made", given.names):
            if given.names and one.name not in given.names:
                continue
            line, wrong = row(one, out / one.name.replace("/", "_"))
            print(line, flush=True)
            faults += wrong
    for fault in faults:
        print(f"WRONG: {fault}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
