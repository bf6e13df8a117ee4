"""The comparison on a recording of one's own: an estimated trajectory and its ground truth.

The estimate is aligned once, as it comes, and cut into blocks of equal numbers of poses. Parameters
are chosen on every second block by the same search as everywhere. The blocks between are judged,
each smoothed by itself; they take the place of seeds in the other tables. Errors of neighbouring
blocks are correlated, so intervals are narrower here than they should be.

Searches and blocks are jobs as in `motorcade.replays.comparison.run`: kept in ``OUT/.finished``,
and named after the poses that they depend on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import Align, alignment_of, associate
from motorcade.fusion.smoothing import METHODS
from motorcade.ga import Trajectory
from motorcade.replays.comparison.cells import MeasuredRow, Setting, measured_rows
from motorcade.replays.comparison.evaluator import PathEvaluator
from motorcade.replays.comparison.plan import COMPARED
from motorcade.replays.comparison.statistics import Sample
from motorcade.replays.comparison.tables import Outcome, write_tables
from motorcade.replays.comparison.traits import exact_ties, measured_trait
from motorcade.replays.comparison.truth import RecordedTruth, digest_of
from motorcade.replays.comparison.tuning import Tuned, tuned
from motorcade.replays.engine.jobs import finished

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
        executor: see `motorcade.replays.engine.executors.outcomes`.

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
    found = _tuned(pairs, RecordedBlocks(blocks[::2], truth), out, executor)
    settings = tuple(found[pair].setting for pair in pairs)
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
    places = {(name, _DEGRADATION, *pair): one for pair, one in found.items()}
    outcome = Outcome(plan, tuple(samples), places, tuple(traits), exact_ties())
    return write_tables(outcome, out)


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


def _tuned(
    pairs: Sequence[Pair], blocks: RecordedBlocks, out: Path, executor: str
) -> dict[Pair, Tuned]:
    """What was found for every method and representation."""
    about = {search: search.about() for search in (RecordedSearch(pair, blocks) for pair in pairs)}
    results = finished(run_search, about, out, executor, "searches")
    return {search.pair: result for search, result in results.items()}
