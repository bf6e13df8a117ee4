"""Overshoot, gimbal index and frame-change defect against cases whose answer is known."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy import signal

from motorcade.fusion.metrics import (
    NotObservableError,
    frame_change_defect,
    gimbal_index,
    position_overshoot_m,
    rotation_overshoot_rad,
    seconds_per_pose,
)
from motorcade.fusion.metrics.artifacts import path_over_geodesic, rotation_path_rad
from motorcade.fusion.motions import MOTIONS, Factor, Motion
from motorcade.fusion.motions.degradations import Gaussian, Latency
from motorcade.fusion.motions.motion import Stops
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Rotor, Trajectory

PARTS = pytest.mark.parametrize(
    ("axis", "measure"), [(4, position_overshoot_m), (1, rotation_overshoot_rad)]
)


def stepping(axis, rate_hz=100.0):
    """Steps of 1 (m or rad) along one axis of the twist and back, 0.05 s each, 5 s apart."""
    return Motion((Factor(np.eye(6)[axis], Stops((0.0, 1.0), 0.05, 5.0)),), Motor).sampled(
        rate_hz, 15.0
    )


def filtered(trajectory, axis, system):
    """What a linear filter makes of the one coordinate that moves."""
    way = trajectory.motors.as_twist()[:, axis]
    _, answer, _ = signal.lsim(system, way, trajectory.time_s)
    return Trajectory(trajectory.time_ns, Motor.from_twist(answer[:, None] * np.eye(6)[axis]))


@pytest.mark.parametrize("damping", [0.3, 0.5, 0.8])
@PARTS
def test_overshoot_of_a_second_order_system_is_the_textbooks(damping, axis, measure):
    omega = 2.0 * np.pi * 1.0
    system = ([omega**2], [1.0, 2.0 * damping * omega, omega**2])
    truth = stepping(axis)
    expected = np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2))
    found = measure(filtered(truth, axis, system), truth)
    assert found == pytest.approx(expected, rel=0.02)


@PARTS
def test_what_creeps_or_comes_late_does_not_overshoot(axis, measure, rng):
    truth = stepping(axis)
    creeping = filtered(truth, axis, ([1.0], [0.3, 1.0]))
    assert measure(creeping, truth) < 1e-3
    late = Latency(0.1).apply(truth, rng)
    assert measure(late, truth) < 1e-9
    assert measure(truth, truth) < 1e-12


def test_overshoot_is_measured_along_the_way_and_counts_the_largest():
    truth = stepping(3)
    shifts = np.zeros((len(truth), 3))
    shifts[:, 1] = 0.5  # across the way
    shifts[200, 0] = 0.07
    shifts[700, 0] = -0.09  # the second stop lies in the other direction
    moved = truth.motors.translation_m + shifts
    estimate = Trajectory(truth.time_ns, Motor.from_rotor_translation(truth.motors.rotor, moved))
    assert position_overshoot_m(estimate, truth) == pytest.approx(0.09, abs=1e-9)


def test_a_final_stop_counts_and_even_motion_has_none():
    whole = stepping(3)
    once = whole[:200]
    moved = once.motors.translation_m + np.eye(200)[150][:, None] * [0.02, 0.0, 0.0]
    estimate = Trajectory(once.time_ns, Motor.from_rotor_translation(once.motors.rotor, moved))
    assert position_overshoot_m(estimate, once) == pytest.approx(0.02, abs=1e-9)
    even = MOTIONS["screw"].sampled(30.0, 10.0)
    with pytest.raises(NotObservableError, match="stops or turns back"):
        position_overshoot_m(even, even)
    with pytest.raises(NotObservableError, match="5 or more stamps within the ground truth, got 2"):
        rotation_overshoot_rad(even[:2], even)


def spun(truth, turns, start, stop):
    """The ground truth with `turns` whole turns about its x axis added between two stamps."""
    added = 2.0 * np.pi * turns * np.clip((truth.time_s - start) / (stop - start), 0.0, 1.0)
    extra = Motor.from_twist(added[:, None] * np.eye(6)[0])
    return truth.transformed_by(right=extra)


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
def test_whole_turns_are_counted_through_noise(turns, rng):
    truth = MOTIONS["stop_and_go"].sampled(30.0, 20.0)
    noisy = Gaussian(0.0, 0.05).apply(spun(truth, turns, 5.0, 9.0), rng)
    assert gimbal_index(noisy, truth).spurious_turns == abs(turns)


def test_a_swing_that_comes_back_is_no_turn():
    truth = MOTIONS["handheld"].sampled(30.0, 10.0)
    angle = 3.0 * np.sin(np.pi * truth.time_s / 10.0) ** 2
    swung = truth.transformed_by(right=Motor.from_twist(angle[:, None] * np.eye(6)[2]))
    assert gimbal_index(swung, truth).spurious_turns == 0


def test_ratios_are_those_of_a_turn_twice_as_far():
    seconds = np.arange(0.0, 5.0, 0.02)
    stamps = np.round(1e9 * seconds).astype(np.int64)
    once, twice = (
        Trajectory(stamps, Motor.from_twist((k * np.sin(seconds))[:, None] * np.eye(6)[1]))
        for k in (1.0, 2.0)
    )
    found = gimbal_index(twice, once)
    assert found.path_ratio == pytest.approx(2.0, rel=1e-9)
    assert found.peak_rate_ratio == pytest.approx(2.0, rel=1e-9)


def test_paths_of_rotation(rng):
    start, end = Rotor.random(rng), Rotor.random(rng)
    straight = start.interpolate(end, np.linspace(0.0, 1.0, 50))
    angle = float((start.inverse() @ end).angle())
    assert rotation_path_rad(straight) == pytest.approx(angle, rel=1e-12)
    assert path_over_geodesic(straight) == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(NotObservableError, match="expected ends that differ"):
        path_over_geodesic(Rotor.identity((3,)))
    still = Trajectory(np.arange(3), Motor.identity((3,)))
    with pytest.raises(NotObservableError, match="a ground truth that turns"):
        gimbal_index(still, still)


def test_a_shift_in_the_world_is_a_defect_on_the_left_alone(rng):
    trajectory = MOTIONS["handheld"].sampled(30.0, 2.0)
    left, right = Motor.random(rng, (2,))
    shift = np.array([0.1, -0.2, 0.3])

    def world_shift(path):
        return path.transformed_by(Motor.from_translation(shift))

    def sensor_turn(path):
        return path.transformed_by(right=Motor.from_twist([0.2, 0.0, 0.0, 0.0, 0.0, 0.0]))

    found = frame_change_defect(world_shift, trajectory, left, right)
    assert found.left_m == pytest.approx(np.linalg.norm(left.rotor.apply(shift) - shift))
    assert max(found.left_rad, found.right_m, found.right_rad) < 1e-12
    turned = frame_change_defect(sensor_turn, trajectory, left, right)
    assert max(turned.left_m, turned.left_rad) < 1e-12
    axis = np.array([1.0, 0.0, 0.0])
    either = [
        Rotor.from_rotation_vector(0.2 * v) for v in (axis, right.rotor.inverse().apply(axis))
    ]
    expected = float((either[0].inverse() @ either[1]).angle())
    assert turned.right_rad == pytest.approx(expected)
    same = frame_change_defect(lambda path: path, trajectory, left, right)
    assert max(same.left_m, same.left_rad, same.right_m, same.right_rad) < 1e-15


def test_a_smoother_whose_stamps_depend_on_the_frame_is_refused(rng):
    trajectory = MOTIONS["handheld"].sampled(30.0, 2.0)
    ahead = trajectory.motors.translation_m[0, 0]

    def fickle(path):
        return path[: 10 if path.motors.translation_m[0, 0] == ahead else 20]

    with pytest.raises(ValueError, match="expected the same stamps in every frame"):
        frame_change_defect(fickle, trajectory, Motor.random(rng), Motor.random(rng))


def test_the_cost_is_that_of_the_fastest_run():
    trajectory = MOTIONS["handheld"].sampled(30.0, 1.0)
    seen = []
    cost = seconds_per_pose(lambda path: seen.append(path) or path, trajectory, repeats=4)
    assert cost > 0.0
    assert seen == [trajectory] * 4
    with pytest.raises(ValueError, match="repeats: expected 1 or more, got 0"):
        seconds_per_pose(lambda path: path, trajectory, repeats=0)


@pytest.mark.parametrize("method", ["exponential", "gaussian", "savitzky_golay"])
def test_smoothing_motors_commutes_with_every_frame_change(method, rng):
    truth = MOTIONS["gimbal_crossing"].sampled(30.0, 5.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, rng)
    left, right = Motor.random(rng, (2,))
    found = {
        name: frame_change_defect(
            partial(smooth, method=method, representation=name), noisy, left, right
        )
        for name in ("motor", "quaternion", "euler")
    }
    motor, quaternion, euler = (found[name] for name in ("motor", "quaternion", "euler"))
    assert max(motor.left_m, motor.left_rad, motor.right_m, motor.right_rad) < 1e-10
    assert max(quaternion.left_m, quaternion.left_rad, quaternion.right_rad) < 1e-10
    assert quaternion.right_m > 1e-4  # the lever between the origins is cut off
    assert min(euler.left_rad, euler.right_rad) > 0.1
