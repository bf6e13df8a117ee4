"""Errors are evo's to 1e-6, over the product of the options that both have, on real trajectories.

Long trajectories take evo a second a case: there the tests walk a share of the product, and
``python -m tests.fusion.metrics.test_evos_options`` all of it (a quarter of an hour), with the
largest difference on each trajectory.

KITTI's matrices are rotations to their own rounding (1e-6), which evo keeps and we take off: there
the product is of poses that are rigid, and of the files as they are to that rounding.
"""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    Delta,
    Matched,
    NotObservableError,
    absolute_errors,
    match,
    relative_errors,
)
from motorcade.ga import Trajectory
from motorcade.replays.io.trajectories import read_trajectory

pytest.importorskip("evo")
from evo.core.filters import FilterException
from evo.core.trajectory import PosePath3D

from tests.fusion.metrics import evos

FREIBURG, DESK, KITTI = "freiburg1_xyz-groundtruth", "fr2_desk_groundtruth", "KITTI_00_gt"
PAIRS = {
    "freiburg1_xyz-ORB_kf_mono": FREIBURG,
    "freiburg1_xyz-rgbdslam": FREIBURG,
    "freiburg1_xyz-rgbdslam_drift": FREIBURG,
    "freiburg1_xyz-rgbdslam_drift_short": FREIBURG,
    "fr2_desk_ORB": DESK,
    "fr2_desk_ORB_kf_mono": DESK,
    "KITTI_00_ORB": KITTI,
    "KITTI_00_SPTAM": KITTI,
}
LONG = {"freiburg1_xyz-rgbdslam", "freiburg1_xyz-rgbdslam_drift", "fr2_desk_ORB"}
Pair = tuple[PosePath3D, PosePath3D]
ALIGNMENTS = [
    {"align": how, "n_to_align": first}
    for how in ("none", "se3", "sim3", "scale", "origin", "scaled_origin")
    for first in (None, 12)
    if first is None or how not in ("none", "origin")
]
ALIGNED_ON_ROADS = [one | {"n_to_align": one["n_to_align"] and 200} for one in ALIGNMENTS]
"""KITTI's first twelve poses lie nearly on a line, which leaves a turn about it free."""
PLANES = [{"plane": plane} for plane in (None, "xy", "xz", "yz")]
ASSOCIATIONS = [
    {"interpolate": between, "offset_s": offset_s, "max_difference_s": most_s}
    for between in (False, True)
    for offset_s, most_s in ((0.0, 0.01), (0.013, 0.02))
]
WINDOWS = [(None, None), (0.1, None), (None, 0.9), (0.2, 0.8)]
"""As shares of the estimate's span."""
DELTAS = [
    {"value": value, "unit": unit, "all_pairs": everywhere, "pairs_from": side}
    for value, unit in ((1, "frames"), (7, "frames"), (0.3, "m"), (12.0, "deg"), (0.2, "rad"))
    for everywhere in (False, True)
    for side in ("reference", "estimate")
    if unit != "frames" or side == "reference"
]


def files(data_dir: Path, name: str) -> tuple[Path, Path]:
    return tuple(data_dir / "trajectories" / f"{one}.txt" for one in (name, PAIRS[name]))


def read(paths: tuple[Path, Path]) -> tuple[list[Trajectory], list[PosePath3D]]:
    """Both as ours and as evo's; KITTI's from poses that are rigid."""
    if not paths[0].name.startswith("KITTI"):
        return [read_trajectory(path) for path in paths], [evos.read(path) for path in paths]
    ours = [read_trajectory(path, rate_hz=10.0) for path in paths]
    return ours, [PosePath3D(poses_se3=list(one.motors.as_matrix())) for one in ours]


def in_time(estimate: Trajectory) -> Iterator[dict[str, Any]]:
    """All associations in all windows."""
    start_s, end_s = (estimate.time_ns[i] * 1e-9 for i in (0, -1))
    for association, shares in itertools.product(ASSOCIATIONS, WINDOWS):
        ends = (None if share is None else start_s + share * (end_s - start_s) for share in shares)
        yield association | dict(zip(("start_s", "end_s"), ends, strict=True))


def absolute_difference(found: Matched, theirs: Pair) -> float:
    """Of metres, degrees and both at once; the other relations are these in other units."""
    worst = 0.0
    for relation in ("full", "trans_part", "rot_part", "angle_deg"):
        ours = absolute_errors(found.pairs.estimate, found.pairs.reference, relation)
        expected = evos.absolute(theirs, relation)
        assert ours.shape == expected.shape
        worst = max(worst, float(np.max(np.abs(ours - expected))))
    return worst


def relative_difference(found: Matched, theirs: Pair, delta: dict[str, Any]) -> float:
    """Over all relations; of errors above one, as a share of them."""
    pairs = found.pairs.estimate, found.pairs.reference
    try:
        ours = relative_errors(*pairs, Delta(**delta), tuple(evos.RELATIONS))
    except NotObservableError:
        with pytest.raises(FilterException, match="empty index list"):
            evos.relative(theirs, "full", delta)
        return 0.0
    worst = 0.0
    for relation, errors in zip(evos.RELATIONS, ours, strict=True):
        expected = evos.relative(theirs, relation, delta)
        assert errors.shape == expected.shape
        difference = np.abs(errors - expected) / np.maximum(np.abs(expected), 1.0)
        worst = max(worst, float(np.max(difference, initial=0.0)))
    return worst


def walk(data_dir: Path, name: str, share: float, rng: np.random.Generator) -> tuple[int, float]:
    """Compare absolute errors in a share of all cases; how many those were, and the worst."""
    (estimate, reference), paths = read(files(data_dir, name))
    cases, worst = 0, 0.0
    on_roads = name.startswith("KITTI")
    alignments = ALIGNED_ON_ROADS if on_roads else ALIGNMENTS
    for times in [{}] if on_roads else in_time(estimate):
        synced = evos.in_time(*paths, times)
        for alignment, plane in itertools.product(alignments, PLANES):
            if rng.random() > share:
                continue
            options = times | alignment | plane
            found = match(estimate, reference, **options)
            worst = max(worst, absolute_difference(found, evos.in_space(synced, options)))
            cases += 1
    return cases, worst


def walk_relative(data_dir: Path, name: str) -> float:
    """Compare relative errors for every delta and relation; the worst difference.

    All pairs by angle on the starts alone: evo takes minutes to search long trajectories.
    """
    (estimate, reference), paths = read(files(data_dir, name))
    worst = 0.0
    for options in ({"align": "sim3", "plane": "yz"}, {"align": "scaled_origin"}):
        theirs = evos.matched(*paths, options)
        found = match(estimate, reference, **options)
        start = replace(found, pairs=found.pairs.first(400))
        by_frames_and_path = [
            delta
            for delta in DELTAS
            if not (delta["all_pairs"] and delta["unit"] in ("deg", "rad"))
        ]
        for delta in by_frames_and_path:
            worst = max(worst, relative_difference(found, theirs, delta))
        for path in theirs:
            path.reduce_to_ids(range(min(path.num_poses, 400)))
        for delta in DELTAS:
            worst = max(worst, relative_difference(start, theirs, delta))
    return worst


@pytest.mark.parametrize(
    "name", ["freiburg1_xyz-ORB_kf_mono", "freiburg1_xyz-rgbdslam_drift_short"]
)
def test_absolute_errors_are_evos_on_a_share_of_the_product(data_dir, rng, name):
    cases, worst = walk(data_dir, name, 0.1, rng)
    assert cases > 30
    assert worst < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_absolute_errors_are_evos_on_every_trajectory(data_dir, rng, name):
    share = 0.1 if name in LONG else 1.0
    cases, worst = walk(data_dir, name, share, rng)
    assert cases >= 40 * share * (1 if name.startswith("KITTI") else 10)
    assert worst < 1e-6


@pytest.mark.parametrize("delta", DELTAS, ids=str)
def test_relative_errors_are_evos_for_every_delta(data_dir, delta):
    (estimate, reference), paths = read(files(data_dir, "freiburg1_xyz-rgbdslam_drift_short"))
    for options in ({"align": "sim3", "plane": "xy"}, {"align": "none", "interpolate": True}):
        theirs = evos.matched(*paths, options)
        assert relative_difference(match(estimate, reference, **options), theirs, delta) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_relative_errors_are_evos_on_every_trajectory(data_dir, name):
    assert walk_relative(data_dir, name) < 1e-6


@pytest.mark.parametrize("relation", ["full", "trans_part", "rot_part", "angle_rad"])
def test_kittis_files_give_evos_errors_to_their_own_rounding(data_dir, relation):
    """Seven digits a number: 1e-6 of 500 m in positions, 1e-5 in turns."""
    paths = files(data_dir, "KITTI_00_ORB")
    options = {"align": "se3"}
    theirs = evos.matched(*(evos.read(path) for path in paths), options)
    found = match(*(read_trajectory(path, rate_hz=10.0) for path in paths), **options)
    ours = absolute_errors(found.pairs.estimate, found.pairs.reference, relation)
    np.testing.assert_allclose(ours, evos.absolute(theirs, relation), atol=2e-4)


def main() -> None:
    """The whole product on every trajectory, or on those named: a row each."""
    data_dir = Path(os.environ["MOTORCADE_DATA"])
    print(f"{'trajectory':36}{'cases':>6}{'absolute':>12}{'relative':>12}", flush=True)
    for name in sys.argv[1:] or PAIRS:
        cases, worst = walk(data_dir, name, 1.0, np.random.default_rng(0))
        print(f"{name:36}{cases:6}{worst:12.1e}", end="", flush=True)
        print(f"{walk_relative(data_dir, name):12.1e}", flush=True)


if __name__ == "__main__":
    main()
