"""`python -m tests.end_to_end.believed --runs 500 --seed N`: is a tracker ever confident and wrong?

Short runs are drawn (see `drawn_runs`), tracked and judged by the pipeline, and their poses
compared with the truth. A run is right where each pose lies within three of its own standard
deviations (the probability of which holds for the run's poses together, six dimensions each) and
half of the frames have one. Poses by loose tags are compared within their map, whose world is one
small tag's frame: it is laid on the truth rigidly, by least squares, weighed by their deviations.
A run is doubted where its integrity has not passed, or where it ended with a reason. Printed are
all runs that are wrong and not doubted, and those that are right and doubted although nothing in
them contradicts what was stated; then how many of each there were. Ends with 1 where any is
confident and wrong, or more than 2 % of the right ones are doubted.

    python -m tests.end_to_end.believed --runs 40 --only shuffled   # one happening, all targets
    python -m tests.end_to_end.believed --only loose.moved.17       # one run again
"""

from __future__ import annotations

import argparse
import collections
import logging
import sys
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import show_progress
from motorcade.replays.engine.stage import Chosen
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.board_poses import board_poses
from motorcade.replays.stages.camera.camera_poses import camera_poses
from motorcade.replays.stages.camera.marker_poses import marker_poses
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.integrity import integrity
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.values.camera_poses import BoardPoses, CameraPoses
from motorcade.replays.stages.values.errors import Integrity
from tests.end_to_end.drawn_runs import HAPPENINGS, TARGETS, DrawnRun, draw_run

THREE_SIGMA = 0.0027
"""Probability of lying farther off in one dimension."""
MOST_DOUBTED = 0.02


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Fields:
        name: target, happening and seed.
        right: whether each of its poses is.
        doubts: what its integrity says, or why it ended; empty where it is believed.
        planted: whether a doubt is what it deserves.
        worst: the farthest pose, in deviations; its error in mm and degrees.
        seconds: of tracking and judging.
    """

    name: str
    right: bool
    doubts: tuple[str, ...]
    planted: bool
    worst: tuple[float, float, float]
    seconds: float

    @property
    def line(self) -> str:
        """A row of the table."""
        sigmas, off_mm, off_deg = self.worst
        what = "right" if self.right else "wrong"
        told = "; ".join(self.doubts)[:170] or "believed"
        return f"{self.name:<28}{what:<6}{sigmas:8.1f} σ{off_mm:9.2f} mm{off_deg:8.3f}°  {told}"


def judged(name: str) -> Outcome:
    """Draw the run of a name, track it, and compare."""
    target, happening, seed = name.split(".")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        folder.mkdir()
        drawn = draw_run(int(seed), target, happening, folder)
        start = time.process_time()
        try:
            poses, checked = tracked_and_checked(drawn.recording)
        except ValueError as reason:
            doubts = (f"ended: {reason}",)
            seconds = time.process_time() - start
            return Outcome(name, False, doubts, drawn.planted, (np.nan,) * 3, seconds)
        seconds = time.process_time() - start
    right, worst = compared(drawn, poses)
    return Outcome(name, right, checked.doubts, drawn.planted, worst, seconds)


def tracked_and_checked(recording: Recording) -> tuple[CameraPoses, Integrity]:
    """The pipeline's stages up to `integrity`, without its cache."""
    by_board = recording.board is not None
    tracked = board_poses(recording) if by_board else marker_poses(recording)
    poses = camera_poses(Chosen(tracked))
    inertial = imu(recording, poses)
    path = fused(recording, poses, inertial)
    smooth = smoothed(path, representations=("motor",))
    board = tracked if isinstance(tracked, BoardPoses) else None
    return tracked, integrity(recording, poses, inertial, path, smooth, board)


def compared(drawn: DrawnRun, poses: CameraPoses) -> tuple[bool, tuple[float, float, float]]:
    """Whether all poses are right, and the worst, in the world that fits them best."""
    path, covariance = poses.measurements.trajectory, poses.measurements.covariance
    rows = np.searchsorted(drawn.recording.frames.time_ns, path.time_ns)
    results = []
    for key, truth in _worlds(drawn, poses).items():
        precision = np.linalg.inv(covariance)
        if drawn.recording.markers is not None:  # where its world lies, a map is free to choose
            truth = _laid_on(truth, rows, path.motors, precision)
        off: FloatArray = path.motors.local(truth[rows])
        squared = np.einsum("ni,nij,nj->n", off, precision, off)
        results.append((float(np.median(squared)), key, squared, off))
    if not results:
        return False, (np.inf,) * 3
    _, _, squared, off = min(results, key=lambda one: one[:2])
    limit = chi2.isf(THREE_SIGMA / len(squared), 6)
    at = int(np.argmax(squared))
    worst = (
        float(np.sqrt(squared[at])),
        1e3 * float(np.linalg.norm(off[at, 3:])),
        float(np.rad2deg(np.linalg.norm(off[at, :3]))),
    )
    enough = 2 * len(squared) >= len(drawn.recording.frames)
    return bool(squared.max() <= limit and enough), worst


def _laid_on(truth: Motor, rows: IntArray, path: Motor, precision: FloatArray) -> Motor:
    """The truth, moved as one to where the poses' own deviations make it likeliest."""
    turns = (truth[rows] @ path.inverse()).as_twist()
    truth = Motor.from_twist(np.median(turns, axis=0)).inverse() @ truth
    for _ in range(5):
        by_world = path.inverse().adjoint()
        told = by_world.swapaxes(-1, -2) @ precision
        pull = np.einsum("nij,nj->i", told, path.local(truth[rows]))
        moved = np.linalg.solve(np.einsum("nij,njk->ik", told, by_world), pull)
        truth = Motor.from_twist(-moved) @ truth
    return truth


def _worlds(drawn: DrawnRun, poses: CameraPoses) -> dict[int, Motor]:
    """The worlds that poses may be in: of loose tags that of the one whose frame the map has."""
    if drawn.recording.markers is None:
        return drawn.world_T_camera
    known = poses.marker_map  # type: ignore[attr-defined]
    away = np.linalg.norm(known.world_T_marker.as_twist(), axis=-1)
    anchor = int(known.marker_ids[int(np.argmin(away))])
    return {key: one for key, one in drawn.world_T_camera.items() if key == anchor}


def names_of(runs: int, seed: int, only: str | None) -> list[str]:
    """Runs to draw: all targets and happenings in turn, with seeds of their own."""
    kinds = [f"{target}.{happening}" for happening in HAPPENINGS for target in TARGETS]
    if only is not None:
        if only.count(".") == 2:
            return [only]
        kinds = [one for one in kinds if only == one or only in one.split(".")]
    return [f"{kinds[k % len(kinds)]}.{1000 * seed + k // len(kinds)}" for k in range(runs)]


def main(arguments: list[str] | None = None) -> int:
    """Print what is confident and wrong; 1 where something is."""
    parser = argparse.ArgumentParser(description="is a tracker ever confident and wrong?")
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="a target, a happening, both, or one run by its name")
    parser.add_argument("--all", action="store_true", help="a line for every run")
    asked = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    logging.disable()
    show_progress(False)
    outcomes, start = [], time.monotonic()
    for name in names_of(asked.runs, asked.seed, asked.only):
        outcome = judged(name)
        outcomes.append(outcome)
        false_alarm = outcome.right and bool(outcome.doubts) and not outcome.planted
        wrong = not outcome.right and not outcome.doubts
        if asked.all or wrong or false_alarm or asked.only == name:
            print(("WRONG " if wrong else "DOUBT " if false_alarm else "      ") + outcome.line)
            sys.stdout.flush()
    confident = [one for one in outcomes if not one.right and not one.doubts]
    right = [one for one in outcomes if one.right and not one.planted]
    alarms = [one for one in right if one.doubts]
    counts = collections.Counter((one.right, bool(one.doubts)) for one in outcomes)
    print(
        f"{len(outcomes)} runs in {time.monotonic() - start:.0f} s, seed {asked.seed}: "
        f"{len(confident)} confident and wrong; right {counts[True, False]}, right and doubted "
        f"{counts[True, True]} ({len(alarms)} of {len(right)} without a contradiction), wrong and "
        f"doubted or ended {counts[False, True]}"
    )
    return int(bool(confident) or len(alarms) > MOST_DOUBTED * max(len(right), 1))


if __name__ == "__main__":
    sys.exit(main())
