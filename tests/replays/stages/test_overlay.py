"""The overlay's path reaches as far as anything was measured nearby, without a jump."""

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.replays.stages.view.overlay import extrapolated

STEP_NS = 40_000_000


def steady(rng: np.random.Generator, count: int = 30) -> Trajectory:
    """A screw at even velocity."""
    stamps = STEP_NS * np.arange(count)
    twist = np.array([0.3, -0.2, 0.4, 0.5, 0.1, -0.3])
    return Trajectory(stamps, Motor.random(rng) @ Motor.from_twist(1e-9 * stamps[:, None] * twist))


def jittered(path: Trajectory, rng: np.random.Generator) -> Trajectory:
    noise = Motor.from_twist(0.05 * rng.standard_normal((len(path), 6)))
    return Trajectory(path.time_ns, path.motors @ noise)


def test_a_path_that_ends_early_goes_on_as_it_went(rng: np.random.Generator) -> None:
    """Whatever noise there is in what was measured there."""
    whole = steady(rng)
    path = extrapolated(whole[1:-2], jittered(whole, rng))
    np.testing.assert_array_equal(path.time_ns, whole.time_ns)
    np.testing.assert_allclose(path.motors.as_matrix(), whole.motors.as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(path.motors[1:-2].coefficients, whole.motors[1:-2].coefficients)


def test_only_what_was_measured_near_its_ends_leads_it_on(rng: np.random.Generator) -> None:
    whole = steady(rng)
    for kept in (slice(0, 20), slice(10, 30)):
        assert len(extrapolated(whole[kept], whole)) == 22  # 0.1 s, at 0.04 s from one to the next
    assert len(extrapolated(whole, whole)) == len(whole)
    assert len(extrapolated(whole[:20], whole[:20])) == 20
    later = Trajectory(whole.time_ns + 60 * STEP_NS, whole.motors)
    assert len(extrapolated(whole, later)) == len(whole)


def test_a_lone_pose_has_no_velocity_to_go_on_at(rng: np.random.Generator) -> None:
    whole = steady(rng)
    assert len(extrapolated(whole[:1], whole)) == 1
    two = extrapolated(whole[:2], whole)
    np.testing.assert_allclose(two.motors.as_matrix(), whole.motors[:4].as_matrix(), atol=1e-12)
