"""The overlay's path reaches as far as anything was measured, without a jump."""

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.stages.view.overlay import LED_ON_S, led_on

STEP_NS = 50_000_000


def measured(rng: np.random.Generator) -> Trajectory:
    twists = np.cumsum(0.05 * rng.standard_normal((30, 6)), axis=0)
    return Trajectory(STEP_NS * np.arange(30), Motor.from_twist(twists))


def test_a_path_that_ends_early_goes_on_as_measured(rng: np.random.Generator) -> None:
    """Also where the smoothed path lies elsewhere: only steps are taken, seen from the camera."""
    whole = measured(rng)
    other = Motor.random(rng)
    path = led_on(whole[3:-2].transformed_by(left=other), whole)
    np.testing.assert_array_equal(path.time_ns, whole.time_ns)
    wanted = whole.transformed_by(left=other)
    np.testing.assert_allclose(path.motors.as_matrix(), wanted.motors.as_matrix(), atol=1e-12)


def test_steps_begin_at_the_smoothed_end_and_the_path_itself_stays(
    rng: np.random.Generator,
) -> None:
    whole = measured(rng)
    shifted = Motor.from_twist(0.02 * rng.standard_normal((25, 6))) @ whole.motors[3:-2]
    smooth = Trajectory(whole.time_ns[3:-2], shifted)
    path = led_on(smooth, whole)
    np.testing.assert_array_equal(path.motors[3:-2].coefficients, smooth.motors.coefficients)
    step = path.motors[-3].inverse() @ path.motors[-2]
    own = whole.motors[-3].inverse() @ whole.motors[-2]
    np.testing.assert_allclose(step.as_matrix(), own.as_matrix(), atol=1e-12)


def test_what_was_measured_long_after_the_end_is_left(rng: np.random.Generator) -> None:
    whole = measured(rng)
    path = led_on(whole[:8], whole)
    assert path.time_ns[-1] == whole.time_ns[7] + int(1e9 * LED_ON_S)
    assert len(led_on(whole, whole)) == len(whole)
    later = Trajectory(whole.time_ns + 30 * STEP_NS, whole.motors)
    assert len(led_on(whole, later)) == len(whole)


@pytest.mark.parametrize("ends", [slice(0, 1), slice(29, 30)])
def test_one_pose_is_enough_to_begin_with(ends: slice, rng: np.random.Generator) -> None:
    whole = measured(rng)
    path = led_on(whole[ends], whole)
    assert len(path) == 11
