"""Intervals against scipy's, verdicts and rankings against cases with a known answer."""

import numpy as np
import pytest
from scipy import stats

from motorcade.replays.comparison.evaluator import METRICS
from motorcade.replays.comparison.plan import RAW
from motorcade.replays.comparison.statistics import (
    Group,
    bootstrap,
    cost,
    rankings,
    ratios_to_motor,
    resampling,
    verdicts,
)

APE = METRICS.index("ape_rmse_m")
LAG = METRICS.index("lag_ms")


def test_intervals_agree_with_scipy(rng: np.random.Generator) -> None:
    values = rng.gamma(2.0, 1.0, (20, 6))
    found = bootstrap(values, resampling(20, resamples=20_000))
    for k in range(6):
        theirs = stats.bootstrap(
            (values[:, k],), np.mean, n_resamples=20_000, method="percentile", rng=rng
        ).confidence_interval
        # Two ends from 20,000 resamples each differ by a few hundredths of the width.
        width = theirs.high - theirs.low
        assert found.low[k] == pytest.approx(theirs.low, abs=0.03 * width)
        assert found.high[k] == pytest.approx(theirs.high, abs=0.03 * width)
    np.testing.assert_allclose(found.mean, values.mean(axis=0), rtol=1e-14)


def test_intervals_of_a_normal_mean_have_its_width(rng: np.random.Generator) -> None:
    values = rng.standard_normal((400, 3))
    found = bootstrap(values, resampling(400))
    expected = 2.0 * 1.96 * values.std(axis=0) / np.sqrt(400.0)
    np.testing.assert_allclose(found.high - found.low, expected, rtol=0.08)


def test_seeds_without_a_value_are_left_out(rng: np.random.Generator) -> None:
    values = rng.standard_normal((12, 4))
    values[3, 1] = np.nan
    values[:, 2] = np.nan
    values[1:, 3] = np.nan
    found = bootstrap(values, resampling(12))
    assert found.mean[1] == pytest.approx(np.nanmean(values[:, 1]))
    assert found.low[1] < found.mean[1] < found.high[1]
    assert np.isnan(found.mean[2])
    assert np.isnan(found.low[3])
    assert found.mean[3] == values[0, 3]


def test_resampling_is_the_same_each_time_and_draws_as_many_as_there_are() -> None:
    counts = resampling(20)
    np.testing.assert_array_equal(counts, resampling(20))
    np.testing.assert_array_equal(counts.sum(axis=1), 20.0)
    assert counts.mean() == 1.0


def test_resampling_draws_motions_and_then_their_seeds() -> None:
    counts = resampling(4, 3).reshape(-1, 3, 4)
    of_motion = counts.sum(axis=2)
    np.testing.assert_array_equal(of_motion % 4, 0)
    np.testing.assert_array_equal(of_motion.sum(axis=1), 12.0)
    assert np.any(of_motion == 0)
    assert np.any(np.ptp(counts, axis=2)[of_motion > 0] > 0)


def test_intervals_over_motions_cover_the_choice_of_motions(rng: np.random.Generator) -> None:
    motions, seeds = 200, 5
    values = rng.standard_normal((motions, 1)) + 0.1 * rng.standard_normal((motions, seeds))
    found = bootstrap(values.reshape(-1, 1), resampling(seeds, motions))
    # The variance of a mean over motions, each of which is a mean over seeds.
    spread = values.mean(axis=1).std(ddof=1) / np.sqrt(motions)
    assert found.high[0] - found.low[0] == pytest.approx(2.0 * 1.96 * spread, rel=0.1)


def test_costs_count_from_the_best_value() -> None:
    values = np.full(len(METRICS), -3.0)
    values[METRICS.index("peak_rate_ratio")] = 0.75
    made = cost(values)
    assert made[LAG] == 3.0
    assert made[METRICS.index("peak_rate_ratio")] == 0.25


@pytest.mark.parametrize(
    ("difference", "verdict"),
    [
        (np.zeros(20), "equal"),
        (np.full(20, 1e-12), "equal"),
        (np.linspace(-1e-3, 1.1e-3, 20), "tie"),  # the interval contains 0
        (np.full(20, 9e-5), "tie"),  # below 1 % of 10 mm
        (np.full(20, 1.1e-4), "worse"),
        (np.full(20, -1.1e-4), "better"),
    ],
)
def test_verdicts(difference: np.ndarray, verdict: str) -> None:
    base = np.full((20, len(METRICS)), 0.01)
    differences = np.zeros((20, len(METRICS)))
    differences[:, APE] = difference
    found = bootstrap(differences, resampling(20))
    assert verdicts(differences, found, base)[APE] == verdict


def test_differences_below_a_metric_s_floor_are_ties() -> None:
    base = np.full((20, len(METRICS)), 0.01)
    found = bootstrap(base, resampling(20))
    said = verdicts(base, found, base)
    assert said[LAG] == "tie"  # 0.01 ms more of 0.01 ms
    assert said[METRICS.index("linear_jitter_m_s2")] == "worse"


def group(factors: dict[tuple[str, str], float], rng: np.random.Generator) -> Group:
    """Errors that are the raw ones, which differ from seed to seed, times a factor."""
    names = (RAW, *factors)
    raw = rng.uniform(1.0, 2.0, (20, 1, len(METRICS)))
    share = np.array([1.0, *factors.values()])[None, :, None]
    noise = np.exp(0.01 * rng.standard_normal((20, len(names), len(METRICS))))
    noise[:, 0] = 1.0
    failures = tuple((0, "") for _ in names)
    return Group("m", "d", names, tuple(range(20)), raw * share * noise, failures)


def test_rankings_find_the_order_and_say_what_ties(rng: np.random.Generator) -> None:
    factors = {("a", "motor"): 0.5, ("a", "euler"): 0.502, ("b", "motor"): 0.8}
    ranked = {one["metric"]: one for one in rankings([group(factors, rng)])}
    rows = ranked["ape_rmse_m"]["rows"]
    assert [row["method"] for row in rows] == ["a", "a", "b", "raw"]
    assert [row["ties_with_best"] for row in rows] == [True, True, False, False]
    assert rows[2]["ratio_to_raw"] == pytest.approx(0.8, rel=0.01)
    assert (rows[2]["rank_low"], rows[2]["rank_high"]) == (3, 3)
    assert rows[3]["ratio_to_raw"] == 1.0


def test_what_is_not_complete_is_not_ranked(rng: np.random.Generator) -> None:
    first = group({("a", "motor"): 0.5, ("b", "motor"): 0.4}, rng)
    first.values[4, 2] = np.nan
    for one in rankings([first, group({("a", "motor"): 0.5}, rng)]):
        assert ["b", "motor"] in one["unranked"]
        assert all(row["method"] != "b" for row in one["rows"])


def test_ratios_to_motor_are_paired_and_averaged_over_methods(rng: np.random.Generator) -> None:
    factors = {
        ("a", "motor"): 0.5,
        ("a", "euler"): 1.0,
        ("b", "motor"): 0.2,
        ("b", "euler"): 0.1,
    }
    found = {
        (one["method"], one["representation"]): one
        for one in ratios_to_motor([group(factors, rng)])
        if one["metric"] == "rotation_rmse_deg" and one["scope"] == "all"
    }
    assert found["a", "euler"]["ratio_to_motor"] == pytest.approx(2.0, rel=0.01)
    assert found["b", "euler"]["ratio_to_motor"] == pytest.approx(0.5, rel=0.01)
    assert found["all", "euler"]["ratio_to_motor"] == pytest.approx(1.0, rel=0.01)
    assert found["all", "motor"]["ratio_to_motor"] == 1.0
    row = found["a", "euler"]
    assert row["ratio_low"] < row["ratio_to_motor"] < row["ratio_high"]


def test_ratios_over_all_methods_are_over_the_same_ones(rng: np.random.Generator) -> None:
    factors = {
        ("a", "motor"): 0.5,
        ("a", "euler"): 1.0,
        ("b", "motor"): 0.2,
        ("b", "euler"): 0.1,
    }
    one = group(factors, rng)
    one.values[7, one.names.index(("b", "motor"))] = np.nan
    found = [row for row in ratios_to_motor([one]) if row["method"] == "all"]
    of_a = [row for row in ratios_to_motor([one]) if row["method"] == "a"]
    assert [row | {"method": "a"} for row in found] == of_a
