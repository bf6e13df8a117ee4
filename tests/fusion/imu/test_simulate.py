"""The simulated sensor against finite differences, integration, and rigid bodies by other means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuFaults, ImuNoise, simulate_imu
from motorcade.fusion.imu.simulate import SimulatedImu
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

UP = np.array([0.0, 0.0, 9.81])
# Central differences of the eighth order.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
NAMES = ["handheld", "gimbal_crossing", "walk_and_look", "tumble"]


def differenced(path: ContinuousPath, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angular rate and specific force by differences of the poses alone, by scipy's rotations."""
    step_s = 2e-3
    around = time_s[:, None] + step_s * np.arange(-4, 5)
    poses = path.twists(around.ravel()).pose
    turn = Rotation.from_matrix(poses.rotor.as_matrix().reshape(-1, 3, 3))
    middle = Rotation.from_matrix(path.twists(time_s).pose.rotor.as_matrix())
    back = middle.inv().as_matrix()
    relative = back[:, None] @ turn.as_matrix().reshape(-1, 9, 3, 3)
    vectors = Rotation.from_matrix(relative.reshape(-1, 3, 3)).as_rotvec().reshape(-1, 9, 3)
    rate = np.einsum("k,nki->ni", FIRST, vectors) / step_s
    places = poses.translation_m.reshape(-1, 9, 3)
    places = places - places[:, 4:5]
    acceleration = np.einsum("k,nki->ni", SECOND, places) / step_s**2
    return rate, np.einsum("nij,nj->ni", back, acceleration + UP)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["spline", "motion"])
def test_without_noise_it_reads_what_differences_give(name, kind, rng):
    if kind == "spline":
        path = ContinuousPath.through(MOTIONS[name].sampled(30.0, 8.0), 0.1)
    else:
        path = ContinuousPath.along(MOTIONS[name], 8.0)
    stream = simulate_imu(path, 200.0, None, rng).stream
    inner = slice(20, -20)
    time_s = (stream.time_ns[inner] - path.start_ns) * 1e-9
    rate, force = differenced(path, time_s)
    np.testing.assert_allclose(stream.angular_rate_rad_s[inner], rate, atol=1e-6)
    np.testing.assert_allclose(stream.specific_force_m_s2[inner], force, atol=1e-6)


def integrated(simulated: SimulatedImu) -> tuple[FloatArray, FloatArray]:
    """Errors of the last pose (rad, m) after integrating readings by the midpoint of neighbours."""
    stream = simulated.stream
    step_s = np.diff(stream.time_ns) * 1e-9
    rate = 0.5 * (stream.angular_rate_rad_s[1:] + stream.angular_rate_rad_s[:-1])
    turn = Rotation.from_matrix(simulated.path.poses[0].rotor.as_matrix())
    velocity, place = simulated.velocity_m_s[0], simulated.path.poses[0].translation_m
    for k, dt in enumerate(step_s):
        after = turn * Rotation.from_rotvec(rate[k] * dt)
        first, last = stream.specific_force_m_s2[k : k + 2]
        acceleration = 0.5 * (turn.apply(first.copy()) + after.apply(last.copy())) - UP
        place = place + dt * velocity + 0.5 * dt**2 * acceleration
        velocity, turn = velocity + dt * acceleration, after
    truth = simulated.path.poses[-1]
    missed = Rotation.from_matrix(truth.rotor.as_matrix()).inv() * turn
    return np.linalg.norm(missed.as_rotvec()), np.linalg.norm(place - truth.translation_m)


@pytest.mark.parametrize("name", ["handheld", "gimbal_crossing", "walk_and_look"])
def test_integrating_the_samples_errs_by_the_square_of_the_step(name, rng):
    """Halving the step must take at least 3.5-fold off the error, of both turn and place."""
    path = ContinuousPath.through(MOTIONS[name].sampled(50.0, 4.0), 0.1)
    errors = np.array(
        [
            integrated(simulate_imu(path, rate_hz, None, rng))
            for rate_hz in (50.0, 100.0, 200.0, 400.0)
        ]
    )
    assert np.all(errors[:-1] / errors[1:] >= 3.5)
    assert np.all(errors[-1] < 3e-4)


def test_a_lever_arm_adds_what_rigid_bodies_feel(rng):
    """f_imu = R (f_body + α × r + ω × (ω × r)), by hand, and the extrinsics turn both readings."""
    path = ContinuousPath.along(MOTIONS["handheld"], 3.0)
    imu_T_camera = Motor.from_euler_translation([0.4, -1.1, 2.0], [0.05, -0.3, 0.12])
    bolted = simulate_imu(path, 100.0, None, rng, imu_T_child=imu_T_camera)
    own = simulate_imu(path, 100.0, None, rng)
    turn = imu_T_camera.rotor.as_matrix()
    arm = imu_T_camera.inverse().translation_m  # of the IMU, in the camera's axes
    sample = path.twists(own.path.time_s - own.path.time_s[0])
    rate, rate_rate = sample.body_twist[:, :3], sample.body_twist_rate[:, :3]
    felt = own.stream.specific_force_m_s2 + np.cross(rate_rate, arm)
    felt = felt + np.cross(rate, np.cross(rate, arm))
    np.testing.assert_allclose(bolted.stream.angular_rate_rad_s, rate @ turn.T, atol=1e-12)
    np.testing.assert_allclose(bolted.stream.specific_force_m_s2, felt @ turn.T, atol=1e-10)
    camera = bolted.path.transformed_by(right=imu_T_camera)
    np.testing.assert_allclose(camera.poses.translation_m, own.path.poses.translation_m, atol=1e-12)


def test_a_late_clock_stamps_the_same_samples_later(rng):
    path = ContinuousPath.along(MOTIONS["handheld"], 2.0, start_ns=10**18)
    late = simulate_imu(path, 200.0, None, rng, time_offset_s=0.0123)
    right = simulate_imu(path, 200.0, None, rng)
    assert np.array_equal(late.stream.time_ns, right.stream.time_ns + 12_300_000)
    assert np.array_equal(late.path.time_ns, right.stream.time_ns)
    assert np.array_equal(late.stream.angular_rate_rad_s, right.stream.angular_rate_rad_s)


def test_scale_misalignment_and_bias_are_kalibrs_matrix(rng):
    faults = ImuFaults(
        gyro_scale=[1.01, 0.99, 1.02],
        gyro_misalignment_rad=[0.01, -0.02, 0.03],
        accel_scale=0.98,
        gyro_bias_rad_s=[0.1, 0.2, 0.3],
        accel_bias_m_s2=-0.5,
    )
    path = ContinuousPath.along(MOTIONS["tumble"], 2.0)
    right = simulate_imu(path, 100.0, None, rng).stream
    wrong = simulate_imu(path, 100.0, None, rng, faults=faults)
    x, y, z = right.angular_rate_rad_s.T
    expected = np.stack([1.01 * x, 0.01 * x + 0.99 * y, -0.02 * x + 0.03 * y + 1.02 * z], axis=-1)
    found = wrong.stream
    np.testing.assert_allclose(
        found.angular_rate_rad_s, expected + np.array([0.1, 0.2, 0.3]), rtol=1e-12
    )
    np.testing.assert_allclose(
        found.specific_force_m_s2, 0.98 * right.specific_force_m_s2 - 0.5, rtol=1e-12
    )
    assert np.array_equal(wrong.gyro_bias_rad_s[7], [0.1, 0.2, 0.3])


def test_readings_end_at_the_range_and_stand_on_steps(rng):
    path = ContinuousPath.along(MOTIONS["gimbal_crossing"], 6.0)
    faults = ImuFaults(gyro_range_rad_s=1.5, gyro_step_rad_s=0.004, accel_step_m_s2=0.01)
    rough = simulate_imu(path, 200.0, None, rng, faults=faults).stream
    exact = simulate_imu(path, 200.0, None, rng).stream
    assert np.max(np.abs(rough.angular_rate_rad_s)) == pytest.approx(1.5, abs=0.004)
    assert np.max(np.abs(rough.angular_rate_rad_s)) <= 1.5
    inside = np.abs(exact.angular_rate_rad_s) < 1.49
    for values, truth, step in [
        (rough.angular_rate_rad_s[inside], exact.angular_rate_rad_s[inside], 0.004),
        (rough.specific_force_m_s2, exact.specific_force_m_s2, 0.01),
    ]:
        assert np.max(np.abs(values - truth)) <= 0.5 * step * (1 + 1e-9)
        assert np.max(np.abs(values / step - np.round(values / step))) < 1e-6


def test_lost_samples_leave_the_others_as_they_were(rng):
    path = ContinuousPath.along(MOTIONS["handheld"], 20.0)
    whole, with_gap = (
        simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(5), faults=faults)
        for faults in (ImuFaults(), ImuFaults(dropped_share=0.1))
    )
    assert 1 - len(with_gap.stream) / len(whole.stream) == pytest.approx(0.1, abs=0.02)
    at = np.searchsorted(whole.stream.time_ns, with_gap.stream.time_ns)
    assert np.array_equal(whole.stream.specific_force_m_s2[at], with_gap.stream.specific_force_m_s2)
    assert np.array_equal(with_gap.path.time_ns, with_gap.stream.time_ns)
    assert np.array_equal(whole.gyro_bias_rad_s[at], with_gap.gyro_bias_rad_s)


def test_simulators_of_one_seed_agree_whatever_the_path_is_made_of(rng):
    """Noise depends on the seed and the rate alone."""
    noise = ImuNoise(1e-3, 1e-4, 1e-2, 1e-3)
    motion = MOTIONS["handheld"]
    streams = [
        simulate_imu(path, 100.0, noise, np.random.default_rng(1)).stream.angular_rate_rad_s
        - simulate_imu(path, 100.0, None, rng).stream.angular_rate_rad_s
        for path in (motion.sampled(50.0, 3.0), ContinuousPath.along(motion, 3.0))
    ]
    np.testing.assert_allclose(streams[0], streams[1], atol=1e-14)


def test_impossible_sensors_are_refused(rng):
    for fault, message in [
        ({"gyro_scale": 0.0}, "gyro_scale: expected numbers above 0"),
        ({"accel_scale": [1.0, -1.0, 1.0]}, "accel_scale: expected numbers above 0"),
        ({"gyro_bias_rad_s": [1.0, 2.0]}, r"gyro_bias_rad_s: expected one number or three, got"),
        ({"gyro_bias_rad_s": np.nan}, "gyro_bias_rad_s: expected finite"),
        ({"gyro_range_rad_s": 0.0}, "gyro_range_rad_s: expected a number above 0, got 0.0"),
        ({"accel_step_m_s2": -1.0}, "accel_step_m_s2: expected a number of at least 0, got -1.0"),
        ({"dropped_share": 1.0}, r"dropped_share: expected a share in \[0, 1\), got 1.0"),
    ]:
        with pytest.raises(ValueError, match=message):
            ImuFaults(**fault)
    path = ContinuousPath.along(MOTIONS["handheld"], 0.1)
    with pytest.raises(ValueError, match="dropped_share: expected two samples or more to be left"):
        simulate_imu(path, 20.0, None, rng, faults=ImuFaults(dropped_share=0.9999))
    with pytest.raises(ValueError, match=r"time_offset_s: expected seconds up to .*, got nan"):
        simulate_imu(path, 20.0, None, rng, time_offset_s=float("nan"))
    with pytest.raises(ValueError, match=r"imu_T_child: expected a single pose, got shape \(2,\)"):
        simulate_imu(path, 20.0, None, rng, imu_T_child=Motor.identity((2,)))
    with pytest.raises(ValueError, match=r"duration_s: expected a number above 0, got 0.0"):
        ContinuousPath.along(MOTIONS["handheld"], 0.0)
    with pytest.raises(ValueError, match="expected two poses or more, got 1"):
        simulate_imu(Trajectory(np.array([0]), Motor.identity((1,))), 20.0, None, rng)
