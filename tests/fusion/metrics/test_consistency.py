"""χ² bounds are scipy's, and samples of a known law keep them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from motorcade.fusion.metrics.consistency import Consistency, chi2_bounds, normalised_squared


@pytest.mark.parametrize(("freedom", "runs"), [(1, 1), (3, 100), (6, 100), (15, 1000)])
def test_bounds_are_scipys(freedom, runs):
    for probability in (0.5, 0.95, 0.999):
        expected = stats.chi2.interval(probability, freedom * runs)
        found = chi2_bounds(freedom, runs, probability)
        np.testing.assert_allclose(found, np.array(expected) / runs, rtol=1e-10)


def test_bounds_keep_95_of_100_averages_unless_said_otherwise():
    expected = np.array(stats.chi2.interval(0.95, 600)) / 100
    np.testing.assert_allclose(chi2_bounds(6, 100), expected, rtol=1e-10)
    found = Consistency.of(np.ones((100, 2)), 6)
    np.testing.assert_allclose((found.low, found.high), expected, rtol=1e-10)
    wide = Consistency.of(np.ones((100, 2)), 6, 0.999)
    assert wide.low < found.low < found.high < wide.high


def test_an_average_at_a_bound_is_within_it():
    found = Consistency(6, 10, np.array([3.9, 4.0, 6.0, 8.0, 8.1]), 4.0, 8.0)
    assert found.share_within == 0.6
    assert found.ratio == pytest.approx(1.0)
    assert Consistency.of(np.array([[2.0]]), 4).ratio == 0.5  # one run of one step


def test_errors_of_the_stated_covariance_keep_the_bounds_and_others_do_not(rng):
    factor = rng.standard_normal((40, 200, 6, 6))
    covariance = factor @ factor.swapaxes(-1, -2)
    errors = (factor @ rng.standard_normal((40, 200, 6, 1)))[..., 0]
    squares = normalised_squared(errors, covariance)
    assert stats.kstest(squares.ravel(), stats.chi2(6).cdf).pvalue > 1e-3
    right = Consistency.of(squares, 6)
    assert (right.runs, right.average.shape) == (40, (200,))
    assert right.share_within == pytest.approx(0.95, abs=5 * np.sqrt(0.95 * 0.05 / 200))
    assert right.ratio == pytest.approx(1.0, abs=5 * np.sqrt(2 / (6 * 8000)))
    for factor_of_covariance in (0.7, 1.4):
        wrong = Consistency.of(normalised_squared(errors, factor_of_covariance * covariance), 6)
        assert wrong.share_within < 0.3
        assert wrong.ratio == pytest.approx(right.ratio / factor_of_covariance)


def test_correlations_count():
    covariance = np.array([[1.0, 0.9], [0.9, 1.0]])
    both, against = normalised_squared(
        np.array([[1.0, 1.0], [1.0, -1.0]]), np.stack([covariance] * 2)
    )
    assert both == pytest.approx(2.0 / 1.9)
    assert against == pytest.approx(2.0 / 0.1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: chi2_bounds(0, 5), "freedom: expected 1 or more"),
        (lambda: chi2_bounds(5, 0), "runs: expected 1 or more"),
        (lambda: chi2_bounds(5, 5, 1.0), "probability: expected above 0 and below 1, got 1.0"),
        (lambda: chi2_bounds(5, 5, 0.0), "probability: expected above 0 and below 1, got 0.0"),
        (lambda: Consistency.of(np.ones((0, 5)), 6), r"values: expected \(runs, steps\)"),
        (lambda: Consistency.of(np.ones((2, 0)), 6), r"values: expected \(runs, steps\)"),
        (lambda: Consistency.of(np.ones((2, 5, 1)), 6), r"values: expected \(runs, steps\)"),
        (lambda: Consistency.of(np.ones(5), 6), r"values: expected \(runs, steps\)"),
        (lambda: Consistency.of(np.full((2, 5), np.nan), 6), "values"),
        (
            lambda: normalised_squared(np.ones((4, 3)), np.ones((3, 3))),
            "covariances: expected shape",
        ),
        (lambda: normalised_squared(np.ones(3), np.ones((3, 3))), "a singular one"),
    ],
)
def test_bad_input_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
