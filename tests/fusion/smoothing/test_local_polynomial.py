"""Laws of zero-lag smoothing by local polynomials, on every representation where they hold."""

from typing import Any

import numpy as np
import pytest

from motorcade import fusion
from motorcade.fusion.smoothing import REPRESENTATIONS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray


def smooth(
    path: Trajectory, representation: str = "motor", window_s: float = 0.3, order: int = 2
) -> Trajectory:
    return fusion.smooth(path, "local_polynomial", representation, window_s=window_s, order=order)


SCREW = np.array([0.3, 1.0, 0.5, 0.1, 0.2, -0.4])


def uneven_stamps(rng: np.random.Generator, count: int) -> IntArray:
    return np.cumsum(rng.integers(20_000_000, 46_000_000, count)).astype(np.int64)


def screw_motion(time_ns: IntArray) -> Motor:
    return Motor.from_twist(SCREW * (time_ns * 1e-9)[:, None])


def distance(a: Motor, b: Motor) -> FloatArray:
    return np.linalg.norm((a.inverse() @ b).as_twist(), axis=-1)


def jittered(poses: Motor, rng: np.random.Generator, size: float) -> Motor:
    return poses @ Motor.from_twist(size * rng.standard_normal((len(poses), 6)))


def test_a_constant_screw_is_left_as_it_is(rng: np.random.Generator) -> None:
    time_ns = uneven_stamps(rng, 200)
    path = Trajectory(time_ns, screw_motion(time_ns))
    for order in range(1, 6):
        assert distance(smooth(path, "motor", 0.3, order).poses, path.poses).max() < 1e-12


@pytest.mark.parametrize("representation", ["motor", "quaternion", "euler_unwrapped"])
def test_noise_shrinks_and_nothing_lags(representation: str, rng: np.random.Generator) -> None:
    time_ns = np.arange(600, dtype=np.int64) * 10_000_000
    seconds = time_ns * 1e-9
    twist = np.zeros((600, 6))
    twist[:, 1], twist[:, 5] = np.sin(2 * np.pi * 0.5 * seconds), 0.3 * np.cos(2.0 * seconds)
    truth = Motor.from_twist(twist)
    path = Trajectory(time_ns, jittered(truth, rng, 0.01))
    found = smooth(path, representation, 0.3)
    assert distance(found.poses, truth)[30:-30].mean() < 0.4 * distance(path.poses, truth).mean()
    true_turn = 2 * np.pi * 0.5 * np.cos(2 * np.pi * 0.5 * seconds)
    error = (truth.inverse() @ found.poses).as_twist()[:, 1]
    lag_s = -np.dot(error[30:-30], true_turn[30:-30]) / np.dot(true_turn, true_turn)
    assert abs(lag_s) < 5e-4


def test_motors_do_not_care_where_world_and_sensor_frame_lie(rng: np.random.Generator) -> None:
    time_ns = uneven_stamps(rng, 80)
    path = Trajectory(time_ns, jittered(screw_motion(time_ns), rng, 0.05))
    left, right = Motor.random(rng), Motor.random(rng)
    moved = smooth(path.transformed_by(left, right))
    assert distance(moved.poses, smooth(path).transformed_by(left, right).poses).max() < 1e-12


def test_quaternions_do_not_care_about_signs(rng: np.random.Generator) -> None:
    time_ns = uneven_stamps(rng, 80)
    poses = screw_motion(time_ns)
    signs = rng.choice([-1.0, 1.0], (80, 1))
    flipped = Motor(signs * poses.coefficients)
    found = smooth(Trajectory(time_ns, flipped), "quaternion")
    assert (
        distance(found.poses, smooth(Trajectory(time_ns, poses), "quaternion").poses).max() < 1e-12
    )


def test_only_naive_euler_angles_break_where_the_yaw_leaps(rng: np.random.Generator) -> None:
    """On the flat, unwrapped yaw is smoothed like any number: as well as a motor."""
    time_ns = np.arange(200, dtype=np.int64) * 33_333_333
    yaw = np.pi + np.sin(np.linspace(0, 12, 200))
    angles = np.stack([np.zeros(200), np.zeros(200), yaw], axis=-1)
    truth = Motor.from_rotor_translation(Rotor.from_euler(angles), np.zeros(3))
    path = Trajectory(time_ns, jittered(truth, rng, 0.01))
    worst = {name: distance(smooth(path, name, 0.3).poses, truth).max() for name in REPRESENTATIONS}
    assert worst["euler"] > 1.0
    assert worst["euler_unwrapped"] < 1.1 * worst["motor"] < 0.05


@pytest.mark.parametrize(("representation", "worse"), [("euler", 30.0), ("euler_unwrapped", 2.0)])
def test_euler_angles_break_at_gimbal_lock_where_motors_do_not(
    representation: str, worse: float, rng: np.random.Generator
) -> None:
    """Loops at 4 rad/s, exactly through ±90° of pitch: unwrapping helps, but does not cure."""
    time_ns = np.arange(150, dtype=np.int64) * 33_333_333
    pitch = 4.0 * time_ns[:, None] * 1e-9 * np.array([0.0, 1.0, 0.0])
    loops = Rotor.from_rotation_vector(pitch) @ Rotor.from_euler(np.array([0.0, 0.0, 0.4]))
    truth = Motor.from_rotor_translation(loops, np.zeros(3))
    path = Trajectory(time_ns, jittered(truth, rng, 0.01))
    ours = distance(smooth(path, "motor", 0.3).poses, truth)
    theirs = distance(smooth(path, representation, 0.3).poses, truth)
    assert ours.max() < 0.05
    assert theirs.max() > worse * ours.max()
    assert theirs.mean() > 1.5 * ours.mean()


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_positions_are_numpys_weighted_polynomial(
    representation: str, rng: np.random.Generator
) -> None:
    time_ns = uneven_stamps(rng, 60)
    positions = rng.standard_normal((60, 3))
    path = Trajectory(time_ns, Motor.from_rotor_translation(Rotor.identity((60,)), positions))
    found = smooth(path, representation, 0.5, 2).poses.translation_m
    for i in (0, 1, 30, 59):
        u = (time_ns - time_ns[i]) / 0.25e9
        near = np.abs(u) < 1
        weight = (1 - np.abs(u[near]) ** 3) ** 1.5  # polyfit squares its weights
        for axis in range(3):
            fitted = np.polyfit(u[near], positions[near, axis], 2, w=weight)
            assert found[i, axis] == pytest.approx(fitted[-1], abs=1e-10)


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_gaps_are_gaps_in_time(representation: str, rng: np.random.Generator) -> None:
    time_ns = np.array([0, 1, 2, 3, 50, 51, 200], dtype=np.int64) * 33_000_000
    path = Trajectory(time_ns, Motor.random(rng, (7,)))
    found = smooth(path, representation, 0.2, 3)
    assert distance(found.poses[6], path.poses[6]) < 1e-9, "a pose alone in its window stays"
    assert distance(found.poses[4:6], path.poses[4:6]).max() < 1e-9, "two poses make one line"


def test_the_input_is_left_as_it_was(rng: np.random.Generator) -> None:
    path = Trajectory(uneven_stamps(rng, 20), Motor.random(rng, (20,)))
    before = path.poses.coefficients.copy()
    smooth(path)
    np.testing.assert_array_equal(path.poses.coefficients, before)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"representation": "matrix"}, r"representation: expected one of motor.*'matrix'"),
        ({"window_s": 0.0}, r"window_s: expected a positive number of seconds, got 0"),
        ({"window_s": float("nan")}, "window_s"),
        ({"window_s": 4e-10}, "window_s: expected at least 1e-9 seconds, got 4e-10"),
        ({"order": 6}, "order: expected 0 to 5, got 6"),
    ],
)
def test_bad_settings_are_refused(
    arguments: dict[str, Any], message: str, rng: np.random.Generator
) -> None:
    path = Trajectory(uneven_stamps(rng, 20), Motor.random(rng, (20,)))
    with pytest.raises(ValueError, match=message):
        smooth(path, **arguments)
