"""Kernels against fifty digits: what an error may be over the hard samples."""

import pytest

from tests.ga.kernels.accuracy_motors import largest_errors
from tests.ga.kernels.accuracy_similarities import similarity_errors

pytest.importorskip("mpmath", reason="mpmath is not installed")


@pytest.mark.parametrize(("dtype", "bound"), [("float32", 5e-7), ("float64", 1e-14)])
@pytest.mark.parametrize("seed", range(5))
def test_normwise_errors_stay_small_over_hard_samples(dtype: str, bound: float, seed: int) -> None:
    errors = largest_errors(dtype, seed)
    assert max(errors.values()) <= bound, errors


# Scales of a quarter and four between two similarities take two bits and more.
@pytest.mark.parametrize(("dtype", "bound"), [("float32", 2e-6), ("float64", 4e-15)])
@pytest.mark.parametrize("seed", range(3))
def test_errors_of_similarities_stay_small_too(dtype: str, bound: float, seed: int) -> None:
    errors = similarity_errors(dtype, seed)
    assert len(errors) == 8
    assert max(errors.values()) <= bound, errors
