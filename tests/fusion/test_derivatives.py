"""Derivatives of sampled paths, against motions whose derivatives are known in closed form."""

import numpy as np
import pytest

from motorcade.fusion.derivatives import differentiated
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import DroppedFrames
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray


def worst(found: FloatArray, exact: FloatArray, inner: slice = slice(20, -20)) -> float:
    return float(np.abs(found - exact)[inner].max() / max(1.0, np.abs(exact).max()))


@pytest.mark.parametrize("name", MOTIONS)
def test_twist_its_rate_and_jerk_are_those_of_the_motion(
    name: str, rng: np.random.Generator
) -> None:
    motion = MOTIONS[name]
    path = DroppedFrames(0.1).apply(motion.sampled(200.0, 4.0), rng)
    found = differentiated(path, window_s=0.06, order=6)
    exact = motion.at(path.time_ns * 1e-9)
    # The fourth derivatives of motions that stop and start leap.
    kinks = 100.0 if name in ("walk_and_look", "stop_and_go") else 1.0
    assert worst(found.body_twist, exact.body_twist) < kinks * 1e-7
    assert worst(found.body_twist_rate, exact.body_twist_rate) < kinks * 1e-4
    exact_jerk = motion.twist_jerk(path.time_ns * 1e-9)
    assert worst(found.body_twist_jerk, exact_jerk) < kinks * 1e-2
    apart = (path.poses.inverse() @ found.trajectory.poses).as_twist()
    assert np.abs(apart).max() < 1e-7


@pytest.mark.parametrize("name", ["handheld", "zoom", "tumble"])
def test_velocity_acceleration_and_jerk_are_those_of_the_origin(name: str) -> None:
    """Against central differences of the closed form's own positions."""
    motion = MOTIONS[name]
    path = motion.sampled(200.0, 3.0)
    found = differentiated(path, window_s=0.06, order=6)
    seconds, step = path.time_ns * 1e-9, 1e-3

    def at(k: int) -> FloatArray:
        return motion.at(seconds + k * step).pose.translation_m

    velocity = (at(1) - at(-1)) / (2 * step)
    acceleration = (at(1) - 2 * at(0) + at(-1)) / step**2
    jerk = (at(2) - 2 * at(1) + 2 * at(-1) - at(-2)) / (2 * step**3)
    assert worst(found.world_velocity_m_s, velocity) < 1e-4
    assert worst(found.world_acceleration_m_s2, acceleration) < 1e-3
    assert worst(found.world_jerk_m_s3, jerk) < 1e-2


@pytest.mark.parametrize("name", ["tumble", "zoom"])
def test_the_world_twist_drives_the_pose_from_the_left(name: str) -> None:
    motion = MOTIONS[name]
    path = motion.sampled(200.0, 2.0)
    found = differentiated(path, window_s=0.06, order=6)
    poses = found.trajectory.poses
    ahead = motion.at(path.time_ns * 1e-9 + 1e-5).pose
    driven = type(poses).from_twist(1e-5 * found.world_twist) @ poses
    assert np.abs((driven.inverse() @ ahead).as_twist())[20:-20].max() < 1e-8


def test_noise_is_averaged_by_wide_windows(rng: np.random.Generator) -> None:
    motion = MOTIONS["screw"]
    path = motion.sampled(100.0, 6.0)
    noisy = path.transformed_by(right=Motor.from_twist(1e-3 * rng.standard_normal((len(path), 6))))
    exact = motion.at(path.time_ns * 1e-9).body_twist
    errors = [
        np.std(differentiated(noisy, window_s=width).body_twist - exact)
        for width in (0.1, 0.3, 1.0)
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_windows_that_hold_few_poses_give_what_they_determine() -> None:
    path = Trajectory(
        np.arange(8) * 1_000_000_000, Motor.from_twist(np.outer(np.arange(8), [0, 0, 0.1, 1, 0, 0]))
    )
    found = differentiated(path, window_s=0.5)
    np.testing.assert_array_equal(found.body_twist, 0.0)
    np.testing.assert_allclose(
        differentiated(path, window_s=6.0).body_twist,
        np.tile([0, 0, 0.1, 1, 0, 0], (8, 1)),
        atol=1e-12,
    )


def test_bad_settings_are_refused() -> None:
    path = MOTIONS["screw"].sampled(30.0, 1.0)
    for settings, message in (
        ({"window_s": 0.0}, "window_s: expected a positive number of seconds"),
        ({"order": 2}, "order: expected 3 to 8, got 2"),
    ):
        with pytest.raises(ValueError, match=message):
            differentiated(path, **settings)
    with pytest.raises(ValueError, match="at least 5 poses, got 4"):
        differentiated(path[:4])


def test_resampling_at_a_rate_starts_at_the_first_stamp_and_stays_inside() -> None:
    path = MOTIONS["zoom"].sampled(30.0, 2.0, start_ns=123_456_789)
    even = path.at_rate(100.0)
    assert even.time_ns[0] == path.time_ns[0]
    assert even.time_ns[-1] <= path.time_ns[-1] < even.time_ns[-1] + 10_000_001
    assert np.all(np.abs(np.diff(even.time_ns) - 10_000_000) <= 1)
    assert isinstance(even.poses, Similarity)
    apart = (even.poses.inverse() @ path.at(even.time_ns)).as_twist()
    assert np.abs(apart).max() < 1e-14
    for rate_hz in (0.0, float("nan"), -3.0):
        with pytest.raises(ValueError, match="rate_hz: expected a positive"):
            path.at_rate(rate_hz)
