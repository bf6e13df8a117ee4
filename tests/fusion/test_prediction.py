"""Held-out prediction tells what chance explains from what it does not, and judges no gaps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.prediction import (
    held_out,
    judged_stamps,
    standard_errors,
    surely_above_zero,
    surely_grown,
)


@pytest.mark.parametrize("seed", range(4))
def test_pairs_are_judged_as_by_students_test(seed: int) -> None:
    rng = np.random.default_rng([817, seed])
    for count in (2, 5, 30):
        differences = rng.normal(rng.uniform(0.0, 1.5), 1.0, count)
        witness = ttest_1samp(differences, 0.0, alternative="greater").pvalue
        for chance in (0.01, 0.05, 0.2):
            assert surely_above_zero(differences, chance) == (witness < chance)


def test_one_pair_and_pairs_that_do_not_differ_tell_nothing() -> None:
    assert not surely_above_zero(np.ones(1))
    assert not surely_above_zero(np.zeros(9))
    np.testing.assert_array_equal(standard_errors(np.zeros((2, 9))), 0.0)


def test_a_segment_where_a_path_is_lost_does_not_hide_that_it_is_worse_everywhere() -> None:
    rng = np.random.default_rng(7)
    before, after = np.abs(rng.normal(0.0, 0.01, (2, 60)))
    assert not surely_grown(before, after, 0.025)
    worse = 3.0 * after
    assert surely_grown(before, worse, 0.025)
    worse[30:34] = 8.0
    assert surely_grown(before, worse, 0.025)
    after[30:34] = 8.0
    assert not surely_grown(before, after, 0.025)
    assert not surely_grown(np.zeros(60), np.zeros(60), 0.025)


def test_equal_paths_are_called_worse_as_often_as_chance_is_allowed() -> None:
    rng = np.random.default_rng(4711)
    trials = 2000
    errors = np.abs(rng.normal(0.0, 1.0, (trials, 2, 100)))
    share = np.mean([surely_grown(before, after, 0.05) for before, after in errors])
    assert abs(share - 0.05) < 4.0 * np.sqrt(0.05 * 0.95 / trials)


def test_held_out_poses_beside_a_gap_are_not_judged() -> None:
    path = MOTIONS["handheld"].sampled(20.0, 12.0)
    whole = judged_stamps(path)
    seconds = path.time_s - path.time_s[0]
    gap = judged_stamps(path[(seconds < 4.0) | (seconds > 6.0)])
    assert len(whole) >= 46
    assert not np.any((gap >= path.time_ns[0] + 4e9) & (gap <= path.time_ns[0] + 6e9))
    assert not held_out(39).any()
