"""The twelve orders of Euler angles as representations, and the one that suits a path best."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import ConstantVelocityFilter, smooth, smoothed_automatically
from motorcade.fusion.smoothing.batch.robust_map import estimate_path
from motorcade.fusion.smoothing.causal import Exponential, smoothed_states
from motorcade.fusion.smoothing.native import _scans
from motorcade.fusion.smoothing.representations import (
    EULER_ORDERS,
    best_euler_order,
    representation_named,
)
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.versors.euler_angles import SEQUENCES, lock_levers

EVERY_ORDER = pytest.mark.parametrize("order", EULER_ORDERS)


def wandering(rng: np.random.Generator, count: int = 120) -> Trajectory:
    """Through all orientations, half turns and the neighbourhood of locks among them."""
    poses = [Motor.random(rng)]
    for step in 0.2 * rng.standard_normal((count - 1, 6)):
        poses.append(poses[-1] @ Motor.from_twist(step))
    return Trajectory(np.arange(count, dtype=np.int64) * 33_333_333, Motor.stack(poses))


def rotation_errors(found: Trajectory, true: Trajectory) -> FloatArray:
    apart = found.motors.rotor.inverse() @ true.motors.rotor
    return np.linalg.norm(apart.as_rotation_vector(), axis=-1)


@EVERY_ORDER
@pytest.mark.parametrize("scaled", [False, True])
def test_the_compiled_twin_sees_the_same_steps(
    order: str, scaled: bool, rng: np.random.Generator
) -> None:
    poses: Motor | Similarity = wandering(rng).motors
    if scaled:
        poses = Similarity.from_motor_scale(poses, np.exp(0.1 * rng.standard_normal(len(poses))))
    one = EULER_ORDERS[order]
    own = one.coordinates(poses)
    theirs = _scans.coordinates(one.compiled, scaled, one.to_compiled(poses).coefficients)
    steps = one.vectors_from_compiled(np.diff(theirs, axis=0))
    assert np.abs(np.diff(own, axis=0) - steps).max() < 1e-11
    back = one.from_compiled(type(poses)(_scans.poses(one.compiled, scaled, theirs)))
    assert np.abs(back.as_matrix() - poses.as_matrix()).max() < 1e-12
    assert np.abs(one.poses(own).as_matrix() - poses.as_matrix()).max() < 1e-12


@EVERY_ORDER
def test_poses_one_after_another_are_written_as_the_path_is(
    order: str, rng: np.random.Generator
) -> None:
    poses, one = wandering(rng).motors, EULER_ORDERS[order]
    whole = one.coordinates(poses)
    for k in range(1, len(poses)):
        alone = one.coordinates(poses[k : k + 1])[0]
        np.testing.assert_array_equal(one.continued(alone, whole[k - 1]), whole[k])


@pytest.mark.parametrize("order", ["euler_zyx", "euler_xzy", "euler_zxz"])
def test_streams_take_every_order(order: str, rng: np.random.Generator) -> None:
    path = wandering(rng, 40)
    live = Exponential(cutoff_hz=3.0, representation=order)
    given = zip(path.motors, path.time_ns, strict=True)
    streamed = Motor.stack([live.update(pose, time_ns) for pose, time_ns in given])
    whole = smooth(path, "exponential", order, cutoff_hz=3.0)
    assert np.abs(streamed.as_matrix() - whole.motors.as_matrix()).max() < 1e-13


@pytest.mark.parametrize("order", EULER_ORDERS)
def test_rates_are_those_of_the_orders_own_angles(order: str) -> None:
    rates = np.array([0.1, -0.2, 0.15])
    time_ns = np.arange(100, dtype=np.int64) * 33_333_333
    time_s = time_ns * 1e-9
    angles = np.array([0.3, 0.8, -0.4]) + rates * time_s[:, None]
    position_m = np.stack([0.5 * time_s, -0.2 * time_s, 0.1 * time_s], axis=-1)
    poses = Motor.from_euler_translation(angles, position_m, order.removeprefix("euler_"))
    path = Trajectory(time_ns, poses)
    model = ConstantVelocityFilter(noise_m=0.01, noise_rad=0.01, representation=order)
    found = smoothed_states(path, model)
    expected = [*rates, 0.5, -0.2, 0.1]
    np.testing.assert_allclose(found.rates[50, 0], expected, rtol=0, atol=1e-6)


def test_the_best_order_stays_farthest_from_its_lock(rng: np.random.Generator) -> None:
    for sequence in SEQUENCES[:9]:  # the last two are others' twins
        angles = np.column_stack([rng.uniform(-3, 3, (200, 1)), np.zeros(200), np.zeros(200)])
        angles[:, 1] = 0.5 * np.pi if sequence[0] == sequence[2] else 0.0
        angles[:, 1:] += rng.uniform(-0.4, 0.4, (200, 2))
        poses = Motor.from_euler_translation(angles, np.zeros(3), sequence)
        found = best_euler_order(poses)
        levers = lock_levers(poses.rotor.as_matrix(), found.sequence)
        assert levers.min() > 0.7
        given = lock_levers(poses.rotor.as_matrix(), sequence)
        assert np.mean(np.log(levers)) >= np.mean(np.log(given))


def test_one_wrong_pose_does_not_decide_the_order(rng: np.random.Generator) -> None:
    path = MOTIONS["gimbal_crossing"].sampled(rate_hz=30.0, duration_s=5.0)
    best = best_euler_order(path.poses)
    wrong = path.motors.coefficients.copy()
    upright = np.zeros(3)
    upright[1] = 0.5 * np.pi
    wrong[70] = Motor.from_euler_translation(upright, np.zeros(3), best.sequence).coefficients
    rotations = path.motors.rotor.as_matrix()
    kept, taken = (
        np.mean(np.log(lock_levers(rotations, one.sequence)))
        for one in (best, best_euler_order(Motor(wrong)))
    )
    assert taken > kept - 0.05, "as good an order as without it"


@pytest.mark.parametrize("motion", ["gimbal_crossing", "gimbal_crossing_fast", "walk_and_look"])
def test_the_best_order_ties_with_quaternions_where_plain_angles_lose(motion: str) -> None:
    """In an order whose lock the camera keeps away from there is no gimbal lock to be seen."""
    true = MOTIONS[motion].sampled(rate_hz=30.0, duration_s=20.0)
    noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, np.random.default_rng(0))
    size = {
        name: float(np.sqrt(np.mean(rotation_errors(smooth(noisy, "gaussian", name), true) ** 2)))
        for name in ("quaternion", "euler_best", "euler_xyz", "euler_unwrapped")
    }
    assert size["euler_best"] < 1.02 * size["quaternion"]
    assert size["euler_unwrapped"] > 1.05 * size["euler_best"]
    assert size["euler_xyz"] <= 1.001 * size["euler_unwrapped"]


def test_every_door_takes_the_best_order(rng: np.random.Generator) -> None:
    true = MOTIONS["gimbal_crossing"].sampled(rate_hz=30.0, duration_s=2.0)
    noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
    best = best_euler_order(noisy.poses).name
    assert representation_named("euler_best", noisy.poses).name == best
    for found, expected in (
        (smooth(noisy, "gaussian", "euler_best"), smooth(noisy, "gaussian", best)),
        (
            estimate_path(noisy, representation="euler_best").trajectory,
            estimate_path(noisy, representation=best).trajectory,
        ),
    ):
        np.testing.assert_array_equal(found.poses.coefficients, expected.poses.coefficients)
    assert smoothed_automatically(noisy, "euler_best").choice.representation == best


def test_a_stream_cannot_know_the_best_order() -> None:
    with pytest.raises(ValueError, match=r"euler_best is decided by a whole path"):
        Exponential(representation="euler_best")


def test_similarities_keep_their_scale_in_every_order(rng: np.random.Generator) -> None:
    path = wandering(rng, 60)
    scaled = Similarity.from_motor_scale(path.motors, np.full(60, 2.0))
    given = Trajectory(path.time_ns, scaled)
    for order in ("euler_zyx", "euler_yxy"):
        found = smooth(given, "rts_constant_velocity", order)
        assert isinstance(found.poses, Similarity)
        np.testing.assert_allclose(found.poses.as_motor_scale()[1], 2.0, rtol=0, atol=1e-12)
        rigid = smooth(path, "rts_constant_velocity", order)
        apart = found.poses.rigid.rotor.inverse() @ rigid.motors.rotor
        assert np.abs(apart.as_rotation_vector()).max() < 1e-9


def test_rotors_of_frames_are_right_handed() -> None:
    for one in EULER_ORDERS.values():
        turned = one.to_compiled(Motor.from_rotor_translation(Rotor.identity(), [1.0, 2.0, 3.0]))
        assert isinstance(turned, Motor)
        np.testing.assert_allclose(turned.translation_m, [1.0, 2.0, 3.0], rtol=0, atol=1e-14)
        assert np.linalg.det(turned.rotor.as_matrix()) == pytest.approx(1.0)
