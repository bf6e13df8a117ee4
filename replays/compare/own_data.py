"""The comparison on a recording of one's own: an estimated trajectory and its truth.

The estimate is aligned once, as it comes, and cut into blocks of equal numbers of poses. Parameters
are chosen on every second block by the same search as everywhere, and the blocks between are
judged, each smoothed by itself; they stand where seeds stand in the other tables. Errors of
neighbouring blocks go together, so that intervals are narrower here than they ought to be.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import Align, alignment_of, associate
from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.compare.cells import measured_rows
from motorcade.replays.compare.figures.statistics import Sample
from motorcade.replays.compare.figures.tables import Outcome, write_tables
from motorcade.replays.compare.measure.evaluator import PathEvaluator
from motorcade.replays.compare.measure.ties import exact_ties
from motorcade.replays.compare.measure.traits import measured_trait
from motorcade.replays.compare.measure.truth import RecordedTruth
from motorcade.replays.compare.tuning import BORROWS, Tuned, borrowed, tuned
from motorcade.replays.engine.progress import track

__all__ = ["compare_recorded"]

_FEWEST_IN_BLOCK = 50
_MOST_BLOCKS = 40
_DEGRADATION = "recorded"

Block = tuple[Trajectory, PathEvaluator]


def compare_recorded(
    estimate: Trajectory,
    truth: Trajectory,
    out: Path,
    name: str = "recording",
    methods: Sequence[str] = (),
    representations: Sequence[str] = (),
    align: Align = "se3",
) -> dict[str, Any]:
    """Compare all, or the named, smoothers on a recording; returns what ``results.json`` holds.

    Args:
        estimate: rigid poses; those that the truth does not cover are left out.
        truth: rigid poses of the same moving frame.
        out: folder for ``cells.csv``, ``groups.csv`` and ``results.json``.
        name: stands for the motion.
        methods: names of `METHODS`.
        representations: names of `REPRESENTATIONS`.
        align: "se3" where the worlds differ, "sim3" where the scale does too, else "none".

    Raises:
        ValueError: fewer than 200 poses within the truth, or positions that cannot be aligned.
        OSError: a folder that cannot be written.
    """
    known = RecordedTruth(truth)
    blocks = _blocks(_aligned(estimate, known, align), known)
    tuning, judged = blocks[::2], blocks[1::2]
    pairs = [(m, r) for m in methods or METHODS for r in representations or REPRESENTATIONS]
    found = _tuned(pairs, tuning)
    settings = [found[pair].setting for pair in pairs]
    samples = [
        Sample.named(name, _DEGRADATION, 2 * i + 1, measured_rows(path, evaluator, settings))
        for i, (path, evaluator) in enumerate(track(judged, "blocks", len(judged)))
    ]
    traits = [measured_trait(setting, judged[0][0]) for setting in settings]
    plan = {
        "motions": [name],
        "degradations": [_DEGRADATION],
        "methods": list(dict.fromkeys(method for method, _ in pairs)),
        "representations": list(dict.fromkeys(one for _, one in pairs)),
        "test_seeds": [2 * i + 1 for i in range(len(judged))],
        "tuning_seeds": [2 * i for i in range(len(tuning))],
        "align": align,
        "left_out": [],
        "blocks": [
            {
                "seed": i,
                "first_ns": int(path.time_ns[0]),
                "last_ns": int(path.time_ns[-1]),
                "poses": len(path),
            }
            for i, (path, _) in enumerate(blocks)
        ],
    }
    places = {(name, _DEGRADATION, *pair): one for pair, one in found.items()}
    outcome = Outcome(plan, tuple(samples), places, tuple(traits), exact_ties())
    return write_tables(outcome, out)


def _aligned(estimate: Trajectory, truth: RecordedTruth, align: Align) -> Trajectory:
    """The poses that the truth covers, in its world."""
    kept = np.flatnonzero(truth.covers(truth.seconds(estimate.time_ns)))
    fewest = 4 * _FEWEST_IN_BLOCK
    if kept.size < fewest:
        raise ValueError(
            f"estimate: expected {fewest} poses or more within the truth, got {kept.size} of "
            f"{len(estimate)}"
        )
    covered = estimate[kept]
    poses, _ = truth.poses(truth.seconds(covered.time_ns))
    true = Trajectory(covered.time_ns, poses, covered.parent, covered.child)
    return alignment_of(associate(covered, true), align).apply_to(covered)


def _blocks(path: Trajectory, truth: RecordedTruth) -> list[Block]:
    count = min(_MOST_BLOCKS, 2 * (len(path) // (2 * _FEWEST_IN_BLOCK)))
    edges = np.linspace(0, len(path), count + 1).astype(int)
    parts = [path[first:last] for first, last in pairwise(edges)]
    return [(part, PathEvaluator(part.time_ns, truth)) for part in parts]


def _tuned(pairs: Sequence[tuple[str, str]], blocks: Sequence[Block]) -> dict[Any, Tuned]:
    """What was found for every method and representation."""
    raw: list[FloatArray] = [evaluator.errors([path])[0] for path, evaluator in blocks]
    made: dict[tuple[str, str], Tuned] = {}

    def search(method: str, representation: str) -> Tuned:
        pair = (method, representation)
        if pair not in made:
            made[pair] = tuned(*pair, blocks, raw)
        return made[pair]

    for method, representation in track(pairs, "parameters", len(pairs)):
        if method in BORROWS:
            lent = search(BORROWS[method][0], representation)
            made[method, representation] = borrowed(method, representation, lent)
        else:
            search(method, representation)
    return made
