"""Errors are evo's to 1e-6, over the product of the options that both have, on real trajectories.

KITTI's matrices are rotations to their own rounding (1e-6), which evo keeps and we take off: there
the product is of poses that are rigid, and of the files as they are to that rounding.
"""

from __future__ import annotations

import itertools
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
from motorcade.replays.files.trajectories import read_trajectory

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
ALIGNMENTS = [
    {"align": how, "n_to_align": first}
    for how in ("none", "se3", "sim3", "scale", "origin", "scaled_origin")
    for first in (None, 12)
    if first is None or how not in ("none", "origin")
]
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


def matchings(estimate: Trajectory, with_stamps: bool) -> list[dict[str, Any]]:
    """The product of what both can do before errors are formed."""
    start_s, end_s = (estimate.time_ns[i] * 1e-9 for i in (0, -1))
    windows = [
        {
            key: None if share is None else start_s + share * (end_s - start_s)
            for key, share in zip(("start_s", "end_s"), shares, strict=True)
        }
        for shares in WINDOWS
    ]
    in_time = itertools.product(ASSOCIATIONS, windows) if with_stamps else [({}, {})]
    return [
        alignment | plane | association | window
        for (association, window), alignment, plane in itertools.product(
            in_time, ALIGNMENTS, PLANES
        )
    ]


def check_absolute(found: Matched, theirs: tuple[PosePath3D, PosePath3D], case: object) -> None:
    for relation in evos.RELATIONS:
        if relation != "point_distance_error_ratio":
            ours = absolute_errors(found.pairs.estimate, found.pairs.reference, relation)
            expected = evos.absolute(theirs, relation)
            np.testing.assert_allclose(ours, expected, 0, 1e-6, err_msg=f"{case} {relation}")


def check_relative(
    found: Matched, theirs: tuple[PosePath3D, PosePath3D], delta: dict[str, Any], case: object
) -> None:
    try:
        ours = relative_errors(
            found.pairs.estimate, found.pairs.reference, Delta(**delta), tuple(evos.RELATIONS)
        )
    except NotObservableError:
        with pytest.raises(FilterException, match="empty index list"):
            evos.relative(theirs, "full", delta)
        return
    for relation, errors in zip(evos.RELATIONS, ours, strict=True):
        expected = evos.relative(theirs, relation, delta)
        message = f"{case} {delta} {relation}"
        np.testing.assert_allclose(errors, expected, 1e-6, 1e-6, err_msg=message)


def walk(data_dir: Path, name: str, share: float, rng: np.random.Generator) -> int:
    """Compare a random share of the product; how many cases that were."""
    (estimate, reference), paths = read(files(data_dir, name))
    cases = 0
    for options in matchings(estimate, not name.startswith("KITTI")):
        if rng.random() > share:
            continue
        theirs = evos.matched(*paths, options)
        found = match(estimate, reference, **options)
        check_absolute(found, theirs, options)
        cases += 1
    return cases


@pytest.mark.parametrize(
    ("name", "share"),
    [("freiburg1_xyz-ORB_kf_mono", 0.1), ("freiburg1_xyz-rgbdslam_drift_short", 0.1)],
)
def test_absolute_errors_are_evos_on_a_share_of_the_product(data_dir, rng, name, share):
    assert walk(data_dir, name, share, rng) > 30


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_absolute_errors_are_evos_over_the_whole_product(data_dir, rng, name):
    assert walk(data_dir, name, 1.0, rng) == (40 if name.startswith("KITTI") else 640)


@pytest.mark.parametrize("delta", DELTAS, ids=str)
def test_relative_errors_are_evos_for_every_delta(data_dir, delta):
    (estimate, reference), paths = read(files(data_dir, "freiburg1_xyz-rgbdslam_drift_short"))
    for options in ({"align": "sim3", "plane": "xy"}, {"align": "none", "interpolate": True}):
        theirs = evos.matched(*paths, options)
        check_relative(match(estimate, reference, **options), theirs, delta, options)


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_relative_errors_are_evos_on_every_trajectory(data_dir, name):
    """All pairs by angle on their starts alone: evo takes minutes to search long trajectories."""
    (estimate, reference), paths = read(files(data_dir, name))
    for options in ({"align": "sim3", "plane": "yz"}, {"align": "scaled_origin"}):
        theirs = evos.matched(*paths, options)
        found = match(estimate, reference, **options)
        for delta in DELTAS:
            if delta["all_pairs"] and delta["unit"] in ("deg", "rad"):
                continue
            check_relative(found, theirs, delta, options)
        for path in theirs:
            path.reduce_to_ids(range(min(path.num_poses, 400)))
        start = Matched(**{**vars(found), "pairs": found.pairs.first(400)})
        for delta in DELTAS:
            check_relative(start, theirs, delta, options)


@pytest.mark.parametrize("relation", ["full", "trans_part", "rot_part", "angle_rad"])
def test_kittis_files_give_evos_errors_to_their_own_rounding(data_dir, relation):
    """Seven digits a number: 1e-6 of 500 m in positions, 1e-5 in turns."""
    paths = files(data_dir, "KITTI_00_ORB")
    options = {"align": "se3"}
    theirs = evos.matched(*(evos.read(path) for path in paths), options)
    found = match(*(read_trajectory(path, rate_hz=10.0) for path in paths), **options)
    ours = absolute_errors(found.pairs.estimate, found.pairs.reference, relation)
    np.testing.assert_allclose(ours, evos.absolute(theirs, relation), atol=2e-4)
