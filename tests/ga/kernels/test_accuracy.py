"""Kernels against fifty digits: what an error may be over the hard samples."""

import numpy as np
import pytest

from motorcade.ga.kernels.generated.python import KERNELS
from tests.ga.kernels.accuracy_conversions import conversion_errors
from tests.ga.kernels.accuracy_fresh import LIMITS, fresh_errors
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


@pytest.mark.parametrize(("dtype", "bound"), [("float32", 6e-7), ("float64", 2e-15)])
@pytest.mark.parametrize("seed", range(3))
def test_errors_of_conversions_and_averages_stay_small(dtype: str, bound: float, seed: int) -> None:
    errors = conversion_errors(dtype, seed)
    assert max(errors.values()) <= bound, errors


def test_kernels_that_convert_move_or_average_are_all_compared() -> None:
    groups = {
        "averages", "conversions", "euler_angles", "motor_conversions", "rotor_averages",
        "rotor_conversions", "rotor_twists", "similarity_averages", "similarity_parts",
        "similarity_twists", "twists",
    }  # fmt: skip
    of_groups = {name for name, (group, _, _) in KERNELS.items() if group in groups}
    exact = {name for name in KERNELS if name.endswith(("of_coefficients", "of_translation"))}
    assert of_groups - exact <= conversion_errors("float64").keys()


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="no 80-bit numbers here")
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("seed", range(2))
def test_errors_on_fresh_motors_stay_within_roundings_of_their_condition(
    dtype: str, seed: int
) -> None:
    errors = fresh_errors(dtype, 5_000, seed)
    assert all(worst <= LIMITS[kernel] for kernel, (_, worst) in errors.items()), errors
    # Where translations cancel, the condition is what explains the error.
    assert errors["interpolate"][0] > 100 * np.finfo(dtype).eps
