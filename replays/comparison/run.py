"""A plan from beginning to end: parameters, cells, figures; also on a recording of one's own.

What is finished is kept in ``OUT/.finished``, a folder for each search and cell, named after all
that it depends on: its fields or poses, and the code. A run that was stopped goes on where it was,
one with more seeds or methods computes those, and one after a change of the code begins anew.

A recording's estimate is aligned once with its ground truth and cut into blocks of equal numbers of
poses. Parameters are chosen on every second block. The blocks between are judged, each smoothed by
itself; they take the place of seeds in the other tables. Errors of neighbouring blocks are
correlated, so intervals are narrower here than they should be.

Ties that theory predicts hold for every path and are shown in figures: the largest difference over
a path, and its bound; all other ties depend on chance and on the data. Kalman filters on motors and
similarities have no such ties in rotation: they propagate the errors of rotation, translation and
scale together. Splines fitted to motors weigh rotations and translations in one sum of squares.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import (
    Align,
    alignment_of,
    associate,
    frame_change_defect,
    seconds_per_pose,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, smooth
from motorcade.ga import Motor, Trajectory, blend
from motorcade.replays.comparison.evaluator import PathEvaluator, RecordedTruth, digest_of
from motorcade.replays.comparison.plan import (
    COMPARED,
    ComparisonCell,
    ComparisonPlan,
    DegradedMotion,
    MeasuredRow,
    Setting,
    measured_rows,
    run_cell,
    why,
)
from motorcade.replays.comparison.statistics import Sample
from motorcade.replays.comparison.tables import write_tables
from motorcade.replays.comparison.tuning import SearchPlace, Tuned, Tuning, run_tuning, tuned
from motorcade.replays.engine.jobs import finished


def run_comparison(plan: ComparisonPlan, out: Path, executor: str = "local") -> dict[str, Any]:
    """Run a plan, write its tables into `out`, and return what ``results.json`` holds.

    Args:
        plan: what to run.
        out: folder for the results; what earlier runs finished there is used.
        executor: see `motorcade.replays.engine.jobs.outcomes`; the results do not depend on
            it, but for times.

    Raises:
        KeyboardInterrupt: stopped by Ctrl-C; what is finished is kept, and no table is written.
        ValueError, RuntimeError: the executor is unknown or cannot be reached.
        OSError: a folder that cannot be written.
    """
    tuned = _tuned(plan, out, executor)
    cells = list(_cells(plan, tuned))
    measured = finished(run_cell, {cell: asdict(cell) for cell in cells}, out, executor, "cells")
    samples = tuple(Sample.of(cell, rows) for cell, rows in measured.items())
    first = plan.motions[0], plan.degradations[0]
    traits = [
        Trait(plan.inputs(*first, plan.tuning_seeds[0]), tuned[*first, *pair].setting)
        for pair in plan.pairs()
    ]
    # Alone, one after another: they are timed.
    timed = finished(run_trait, {trait: asdict(trait) for trait in traits}, out, "local", "times")
    return write_tables(out, plan.as_dict(), samples, tuned, list(timed.values()), exact_ties())


def _cells(
    plan: ComparisonPlan, tuned: dict[tuple[str, str, str, str], Tuned]
) -> Iterator[ComparisonCell]:
    for motion in plan.motions:
        for degradation in plan.degradations:
            settings = tuple(tuned[motion, degradation, *pair].setting for pair in plan.pairs())
            for seed in plan.test_seeds:
                yield ComparisonCell(plan.inputs(motion, degradation, seed), settings)


def _tuned(
    plan: ComparisonPlan, out: Path, executor: str
) -> dict[tuple[str, str, str, str], Tuned]:
    """What was found for (motion, degradation, method, representation)."""
    lenders = {
        (motion, place): place.lender(_rigid(plan, motion))
        for motion in plan.motions
        for place in _places(plan)
    }
    wanted: dict[tuple[str, str], dict[tuple[str, str], None]] = {}
    for (motion, _), lending in lenders.items():
        pairs = wanted.setdefault((motion, lending.degradation), {})
        pairs[lending.method, lending.representation] = None
    searches = [
        Tuning(tuple(plan.inputs(*place, seed) for seed in plan.tuning_seeds), tuple(pairs))
        for place, pairs in wanted.items()
    ]
    about = {search: asdict(search) for search in searches}
    searched = {
        (search.inputs[0].motion, SearchPlace(search.inputs[0].degradation, *pair)): tuned
        for search, results in finished(run_tuning, about, out, executor, "searches").items()
        for pair, tuned in zip(search.pairs, results, strict=True)
    }
    tuned = {}
    for (motion, place), lender in lenders.items():
        result = searched[motion, lender]
        key = (motion, place.degradation, place.method, place.representation)
        tuned[key] = result if lender == place else place.borrowed(result)
    return tuned


def _places(plan: ComparisonPlan) -> list[SearchPlace]:
    return [SearchPlace(name, *pair) for name in plan.degradations for pair in plan.pairs()]


def _rigid(plan: ComparisonPlan, motion: str) -> bool:
    return plan.recording(motion) is not None or MOTIONS[motion].versor is Motor


_FEWEST_IN_BLOCK = 50
_MOST_BLOCKS = 40
_DEGRADATION = "recorded"

Pair = tuple[str, str]
"""Names of a method and of a representation."""


@dataclass(frozen=True, eq=False)
class RecordedBlocks:
    """Blocks of the aligned estimate, and the reference of all of it."""

    paths: tuple[Trajectory, ...]
    truth: Trajectory

    def digest(self) -> str:
        """SHA-256 of all stamps and poses."""
        return digest_of(self.truth, *self.paths)

    def inputs(self) -> list[tuple[Trajectory, PathEvaluator]]:
        """Each block with the evaluator of its stamps."""
        known = RecordedTruth(self.truth)
        return [(path, PathEvaluator(path.time_ns, known)) for path in self.paths]


@dataclass(frozen=True, eq=False)
class RecordedSearch:
    """The parameters of a method in a representation are to be found on blocks."""

    pair: Pair
    blocks: RecordedBlocks

    def about(self) -> list[Any]:
        """All that the result depends on, ready for JSON."""
        return [*self.pair, self.blocks.digest()]


@dataclass(frozen=True, eq=False)
class RecordedCell:
    """Blocks are to be smoothed by every setting and measured."""

    settings: tuple[Setting, ...]
    blocks: RecordedBlocks

    def about(self) -> list[Any]:
        """All that the result depends on, ready for JSON."""
        settings = [[one.method, one.representation, one.parameters] for one in self.settings]
        return [settings, self.blocks.digest()]


def run_search(search: RecordedSearch) -> Tuned:
    """What is found for the method and representation."""
    inputs = search.blocks.inputs()
    raw = [evaluator.errors([path])[0] for path, evaluator in inputs]
    return tuned(*search.pair, inputs, raw)


def run_recorded_cell(cell: RecordedCell) -> tuple[MeasuredRow, ...]:
    """The rows of the blocks, one block after another."""
    return tuple(
        row
        for path, evaluator in cell.blocks.inputs()
        for row in measured_rows(path, evaluator, cell.settings)
    )


def compare_recorded(
    estimate: Trajectory,
    truth: Trajectory,
    out: Path,
    name: str = "recording",
    methods: Sequence[str] = (),
    representations: Sequence[str] = (),
    align: Align = "se3",
    executor: str = "local",
) -> dict[str, Any]:
    """Compare all, or the named, smoothers on a recording; returns what ``results.json`` holds.

    Args:
        estimate: rigid poses; those that the ground truth does not cover are left out.
        truth: ground truth: rigid poses of the same moving frame.
        out: folder for ``cells.csv``, ``groups.csv`` and ``results.json``; what an earlier call
            finished there is used.
        name: stands for the motion.
        methods: names of `METHODS`.
        representations: of `REPRESENTATION_NAMES`; by default those of the standard plan.
        align: "se3" where the worlds differ, "sim3" where the scale does too, else "none".
        executor: see `motorcade.replays.engine.jobs.outcomes`.

    Raises:
        ValueError: fewer than 200 poses within the ground truth, positions that cannot be aligned,
            or an unknown executor.
        KeyboardInterrupt: stopped by Ctrl-C; what is finished is kept, and no table is written.
        RuntimeError: the executor cannot be reached.
        OSError: a folder that cannot be written.
    """
    blocks = _blocks(_aligned(estimate, truth, align))
    judged = blocks[1::2]
    pairs = [(m, r) for m in methods or METHODS for r in representations or COMPARED]
    tuned = _tuned_on_blocks(pairs, RecordedBlocks(blocks[::2], truth), out, executor)
    settings = tuple(tuned[pair].setting for pair in pairs)
    cells = [RecordedCell(settings, RecordedBlocks((path,), truth)) for path in judged]
    measured = finished(
        run_recorded_cell, {cell: cell.about() for cell in cells}, out, executor, "blocks"
    )
    samples = [
        Sample.named(name, _DEGRADATION, 2 * i + 1, measured[cell]) for i, cell in enumerate(cells)
    ]
    traits = [measured_trait(setting, judged[0]) for setting in settings]
    plan = {
        "motions": [name],
        "degradations": [_DEGRADATION],
        "methods": list(dict.fromkeys(method for method, _ in pairs)),
        "representations": list(dict.fromkeys(one for _, one in pairs)),
        "test_seeds": list(range(1, len(blocks), 2)),
        "tuning_seeds": list(range(0, len(blocks), 2)),
        "align": align,
        "blocks": [
            {
                "seed": i,
                "first_ns": int(path.time_ns[0]),
                "last_ns": int(path.time_ns[-1]),
                "poses": len(path),
            }
            for i, path in enumerate(blocks)
        ],
    }
    places = {(name, _DEGRADATION, *pair): one for pair, one in tuned.items()}
    return write_tables(out, plan, samples, places, traits, exact_ties())


def _aligned(estimate: Trajectory, truth: Trajectory, align: Align) -> Trajectory:
    """The poses that the ground truth covers, in its world."""
    known = RecordedTruth(truth)
    kept = np.flatnonzero(known.covers(known.seconds(estimate.time_ns)))
    fewest = 4 * _FEWEST_IN_BLOCK
    if kept.size < fewest:
        raise ValueError(
            f"estimate: expected {fewest} poses or more within the ground truth, got {kept.size} "
            f"of {len(estimate)}"
        )
    covered = estimate[kept]
    poses, _ = known.poses(known.seconds(covered.time_ns))
    true = Trajectory(covered.time_ns, poses, covered.parent, covered.child)
    return alignment_of(associate(covered, true), align).apply_to(covered)


def _blocks(path: Trajectory) -> tuple[Trajectory, ...]:
    count = min(_MOST_BLOCKS, 2 * (len(path) // (2 * _FEWEST_IN_BLOCK)))
    edges = np.linspace(0, len(path), count + 1).astype(int)
    return tuple(path[first:last] for first, last in pairwise(edges))


def _tuned_on_blocks(
    pairs: Sequence[Pair], blocks: RecordedBlocks, out: Path, executor: str
) -> dict[Pair, Tuned]:
    """What was found for every method and representation."""
    about = {search: search.about() for search in (RecordedSearch(pair, blocks) for pair in pairs)}
    results = finished(run_search, about, out, executor, "searches")
    return {search.pair: result for search, result in results.items()}


_FRAMES_SEED = 20240229


@dataclass(frozen=True)
class Trait:
    """A setting, and the poses that it is tried on."""

    inputs: DegradedMotion
    setting: Setting


def run_trait(trait: Trait) -> dict[str, str | int | float]:
    """`measured_trait` on these poses."""
    return measured_trait(trait.setting, trait.inputs.drawn()[0])


def measured_trait(setting: Setting, path: Trajectory) -> dict[str, str | int | float]:
    """Largest difference between smoothing first and changing the frame first, and the time.

    The world's frame (left) and the sensor's (right) are changed by motors of any turn, with
    shifts of about a metre. The time is that of the fastest of three runs, a pose, called from
    Python.
    """
    fields: dict[str, str | int | float] = {
        "method": setting.method,
        "representation": setting.representation,
        "poses": len(path),
    }
    rng = np.random.default_rng(_FRAMES_SEED)
    left, right = Motor.random(rng), Motor.random(rng)
    try:
        defect = frame_change_defect(setting.smooth, path, left, right)
        time_s = seconds_per_pose(setting.smooth, path)
    except Exception as error:  # one failing method never ends the others; its row says why
        return fields | {"failure": why(error)}
    return fields | {
        "left_defect_m": defect.left_m,
        "left_defect_rad": defect.left_rad,
        "right_defect_m": defect.right_m,
        "right_defect_rad": defect.right_rad,
        "time_us_per_pose": 1e6 * time_s,
        "failure": "",
    }


_BOUND = 1e-9
_ONE_BY_ONE = (
    "exponential",
    "double_exponential",
    "one_euro",
    "gaussian",
    "savitzky_golay",
    "local_polynomial",
)
_TWISTS = (*_ONE_BY_ONE, "spline")
_POSITIONS_APART = (
    *_TWISTS,
    "constant_velocity",
    "constant_acceleration",
    "rts_constant_velocity",
    "rts_constant_acceleration",
)


def exact_ties() -> list[dict[str, Any]]:
    """Every tie with what theory says and what was measured on a noisy path of 300 poses."""
    path = _noisy("walk_and_look")
    linear = smooth(path, "gaussian", "dual_quaternion", sigma_s=0.1, order=0)
    rows = [
        _tie_row(
            "the linear blend of rigid motors is the dual quaternion linear blend",
            "motor coefficients and dual quaternions are the same eight numbers up to order and "
            "sign, and both are projected to the nearest unit one",
            "gaussian of order 0",
            ("motors blended", "dual_quaternion"),
            _apart(_blended(path, 0.1), linear),
        )
    ]
    for method in _POSITIONS_APART:
        smoothed = cache(partial(smooth, path, method))
        for theory, reason, first, second, which, methods in _LAWS:
            if method not in methods:
                continue
            try:
                metres, radians = _apart(smoothed(first), smoothed(second))
            except Exception as error:  # one failing method never ends the others; its row says why
                row = _tie_row(theory, reason, method, (first, second), (None, None))
                rows.append(row | {"holds": False, "failure": why(error)})
                continue
            costs = (
                metres if which != "rotation" else None,
                radians if which != "position" else None,
            )
            rows.append(_tie_row(theory, reason, method, (first, second), costs))
    return rows


_LAWS = (
    (
        "similarity equals motor on rigid paths",
        "with scale 1 a similarity's logarithm is the motor's twist and a zero",
        "similarity",
        "motor",
        "both",
        _TWISTS,
    ),
    (
        "motor and rotor give the same orientations",
        "the turning part of twists composes without regard to translations",
        "motor",
        "rotor",
        "rotation",
        _ONE_BY_ONE,
    ),
    (
        "rotor and quaternion give the same positions",
        "both carry translations beside the rotation, in the world",
        "rotor",
        "quaternion",
        "position",
        _POSITIONS_APART,
    ),
    (
        "quaternion and Euler angles give the same positions",
        "both carry translations beside the rotation, in the world",
        "quaternion",
        "euler",
        "position",
        _POSITIONS_APART,
    ),
)


def _noisy(motion: str) -> Trajectory:
    clean = MOTIONS[motion].sampled(30.0, 10.0)
    return Gaussian(0.005, float(np.deg2rad(0.5))).apply(clean, np.random.default_rng(20240229))


def _blended(path: Trajectory, sigma_s: float) -> Trajectory:
    """Every pose a blend of motors within four deviations, with Gaussian weights."""
    poses = []
    for now_ns in path.time_ns:
        near = np.abs(path.time_ns - now_ns) <= round(4e9 * sigma_s)
        offset = (path.time_ns[near] - now_ns) * 1e-9 / sigma_s
        poses.append(blend(path.motors[near], np.exp(-0.5 * offset**2)))
    return Trajectory(path.time_ns, Motor.stack(poses), path.parent, path.child)


def _apart(first: Trajectory, second: Trajectory) -> tuple[float, float]:
    shift = np.linalg.norm(first.motors.translation_m - second.motors.translation_m, axis=-1)
    turn = (first.motors.rotor.inverse() @ second.motors.rotor).angle()
    return float(np.max(shift)), float(np.max(turn))


def _tie_row(
    theory: str,
    reason: str,
    method: str,
    names: tuple[str, str],
    differences: tuple[float | None, float | None],
) -> dict[str, Any]:
    return {
        "theory": theory,
        "reason": reason,
        "method": method,
        "first": names[0],
        "second": names[1],
        "largest_difference_m": differences[0],
        "largest_difference_rad": differences[1],
        "bound": _BOUND,
        "holds": all(value is None or value <= _BOUND for value in differences),
        "failure": "",
    }
