"""Metres and up for a camera path of unknown scale: right, and as sure as stated."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import SimulatedImu, simulate_camera_poses
from motorcade.fusion.imu.stream import upright
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.sync import alignment, synchronise
from motorcade.fusion.visual_inertial import start_inertial
from motorcade.fusion.visual_inertial.start import InertialStart, linear_start
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
UNIT_M = 3.7
# From the world to the camera's own: another scale, leaning, elsewhere.
VISUAL_T_WORLD = Similarity.from_motor_scale(
    Motor.from_euler_translation(np.array([0.5, -0.8, 2.0]), np.array([1.0, 2.0, 3.0])),
    1.0 / UNIT_M,
)


def in_units(path: Trajectory) -> Trajectory:
    turned = VISUAL_T_WORLD.rotor @ path.motors.rotor
    places = VISUAL_T_WORLD.apply(path.motors.translation_m)
    return Trajectory(path.time_ns, Motor.from_rotor_translation(turned, places), "visual")


def measured_in_units(given: PoseMeasurements) -> PoseMeasurements:
    units = np.repeat([1.0, 1.0 / UNIT_M], 3)
    return PoseMeasurements(in_units(given.trajectory), units[:, None] * given.covariance * units)


def recorded(
    rng: np.random.Generator, name: str = "handheld", duration_s: float = 10.0
) -> tuple[Trajectory, SimulatedImu]:
    """The camera's true path, and what the IMU read."""
    path = MOTIONS[name].sampled(100.0, duration_s, child="imu")
    simulated = simulate_imu(path, 100.0, ADIS16448, rng)
    return simulated.path.transformed_by(right=IMU_T_CAMERA), simulated


@pytest.mark.parametrize("at_rest", [False, True])
def test_poses_in_metres_keep_them_and_need_no_motion_to_stand_upright(rng, at_rest):
    """Of a pair, say: its scale is not to be found, nor lost where nothing accelerates."""
    truth, simulated = recorded(rng)
    stream = simulated.stream
    if at_rest:
        still = Motor.stack([truth.motors[0]] * len(truth))
        truth = Trajectory(truth.time_ns, still)
        world_T_imu = truth.transformed_by(right=IMU_T_CAMERA.inverse(), child="imu")
        stream = simulate_imu(world_T_imu, 100.0, ADIS16448, rng).stream
    world_T_level = Motor.from_euler_translation([0.5, -0.8, 2.0], [1.0, 2.0, 3.0])
    leaning = truth.transformed_by(left=world_T_level)
    noisy = simulate_camera_poses(leaning, 20.0, 0.005, np.deg2rad(0.2), rng)
    start = start_inertial(noisy, stream, ADIS16448, IMU_T_CAMERA, metric=True)
    assert float(start.world_T_visual.scale) == pytest.approx(1.0, abs=1e-12)
    assert start.log_scale_sigma == 0.0
    up = (start.world_T_visual.rotor @ world_T_level.rotor).apply([0.0, 0.0, 1.0])
    assert np.arccos(up[2]) < 3.0 * start.tilt_sigma_rad
    # At rest a lean and a bias of the accelerometer look alike.
    assert start.tilt_sigma_rad < np.deg2rad(3.5 if at_rest else 0.2)


def scale_error(start: InertialStart) -> float:
    return float(np.log(start.world_T_visual.scale / UNIT_M))


@pytest.mark.parametrize("name", ["handheld", "gimbal_crossing"])
def test_the_scale_is_found_to_one_per_cent_from_noisy_poses(rng, name):
    truth, simulated = recorded(rng, name, 15.0)
    noisy = simulate_camera_poses(truth, 20.0, 0.005, np.deg2rad(0.2), rng)
    start = start_inertial(measured_in_units(noisy), simulated.stream, ADIS16448, IMU_T_CAMERA)
    assert abs(scale_error(start)) < 0.01
    assert abs(scale_error(start)) < 3.0 * start.log_scale_sigma
    assert start.log_scale_sigma < 0.01
    up = (start.world_T_visual.rotor @ VISUAL_T_WORLD.rotor).apply([0.0, 0.0, 1.0])
    assert np.arccos(up[2]) < 4.0 * start.tilt_sigma_rad
    assert start.tilt_sigma_rad < np.deg2rad(0.15)
    # Speed does not depend on how the new world is turned about up.
    rows = np.searchsorted(simulated.path.time_ns, start.time_ns)
    speed = np.linalg.norm(simulated.velocity_m_s[rows], axis=-1)
    assert np.max(np.abs(np.linalg.norm(start.velocity_m_s, axis=-1) - speed)) < 0.05
    metric = start.in_metres(in_units(truth))
    lengths = [
        np.linalg.norm(np.diff(p.motors.translation_m, axis=0), axis=-1).sum()
        for p in (metric, truth)
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=0.01)
    apart = metric.motors[0].inverse() @ metric.motors[-1]
    np.testing.assert_allclose(
        apart.rotor.as_matrix(),
        (truth.motors[0].inverse() @ truth.motors[-1]).rotor.as_matrix(),
        atol=1e-9,
    )


@pytest.mark.slow
def test_over_many_runs_the_scale_errs_as_stated():
    """Neither small on the whole (noise does not shrink it) nor less sure than it says."""
    errors = []
    for seed in range(24):
        rng = np.random.default_rng(seed)
        truth, simulated = recorded(rng, "handheld", 6.0)
        noisy = simulate_camera_poses(truth, 20.0, 0.01, np.deg2rad(0.3), rng)
        start = start_inertial(measured_in_units(noisy), simulated.stream, ADIS16448, IMU_T_CAMERA)
        errors.append(scale_error(start) / start.log_scale_sigma)
    assert abs(np.mean(errors)) < 3.0 / np.sqrt(len(errors))
    assert 0.6 < np.std(errors) < 1.5


def test_the_linear_start_is_exact_where_nothing_is_noisy(rng):
    path = MOTIONS["handheld"].sampled(100.0, 8.0, child="imu")
    simulated = simulate_imu(path, 400.0, None, rng)
    bias = np.array([0.02, -0.03, 0.01])
    stream = simulated.stream
    imu = ImuStream(stream.time_ns, stream.angular_rate_rad_s + bias, stream.specific_force_m_s2)
    camera = simulated.path.transformed_by(right=IMU_T_CAMERA).at_rate(4.0)
    scale, gravity = linear_start(in_units(camera), imu, ADIS16448, IMU_T_CAMERA)
    assert scale == pytest.approx(UNIT_M, rel=1e-3)
    expected = VISUAL_T_WORLD.rotor.apply([0.0, 0.0, -9.81])
    np.testing.assert_allclose(gravity, expected, atol=5e-3)


@pytest.mark.parametrize("seed", [1, 20240229])
def test_an_even_pace_tells_no_scale_and_that_is_said(seed):
    """A straight walk without acceleration: refused, or unsure beyond any use."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(801) * 0.01
    places = time_s[:, None] * [0.8, 0.1, 0.0]
    turns = Rotor.from_rotation_vector(np.sin(time_s)[:, None] * [0.0, 0.0, 0.3])
    poses = Motor.from_rotor_translation(turns, places)
    path = Trajectory(np.round(time_s * 1e9).astype(np.int64), poses, "world", "imu")
    imu = simulate_imu(path, 100.0, ADIS16448, rng).stream
    extrinsics = Motor.from_rotor_translation(IMU_T_CAMERA.rotor, np.zeros(3))
    noisy = simulate_camera_poses(
        path.transformed_by(right=extrinsics), 20.0, 0.005, np.deg2rad(0.2), rng
    )
    try:
        found = start_inertial(measured_in_units(noisy), imu, ADIS16448, extrinsics)
        unsure, said = found.log_scale_sigma > 1.0, ""
    except ValueError as refused:
        unsure, said = False, str(refused)
    assert unsure or "expected motion that" in said


def test_where_nothing_settles_the_extrinsics_that_were_given_are_doubted(rng, monkeypatch):
    """Not where they are estimated as well, as `synchronise` does."""
    truth, simulated = recorded(rng, duration_s=6.0)
    noisy = simulate_camera_poses(truth, 20.0, 0.005, np.deg2rad(0.2), rng)
    monkeypatch.setattr(alignment, "_ITERATIONS", 1)
    with pytest.raises(
        ValueError, match=r"settles, got none in 1 steps; is imu_T_camera the right one"
    ):
        start_inertial(measured_in_units(noisy), simulated.stream, ADIS16448, IMU_T_CAMERA)
    with pytest.raises(ValueError, match=r"settles, got none in 1 steps$"):
        synchronise(noisy.trajectory, simulated.stream, ADIS16448, search_s=0.1)


@pytest.mark.parametrize("down", [[0.0, 0.0, -9.8], [0.0, 0.0, 9.8], [3.0, -4.0, 8.0], [0, 1, 0]])
def test_gravity_is_turned_down_by_the_shortest_way(down):
    """Also where it points straight up, and every way is as short."""
    up = upright(np.array(down))
    size = np.linalg.norm(down)
    np.testing.assert_allclose(up.apply(down), [0.0, 0.0, -size], atol=1e-9)
    assert up.angle() == pytest.approx(np.arccos(-down[2] / size), abs=1e-9)


def test_bad_input_is_refused(rng):
    truth, simulated = recorded(rng, duration_s=3.0)
    camera = in_units(truth.at_rate(20.0))
    with pytest.raises(ValueError, match="four poses"):
        linear_start(camera[:3], simulated.stream, ADIS16448, IMU_T_CAMERA)
    later = Trajectory(camera.time_ns + 10**12, camera.poses)
    given = PoseMeasurements(later, np.tile(np.eye(6), (len(later), 1, 1)))
    with pytest.raises(ValueError, match="covers"):
        start_inertial(given, simulated.stream, ADIS16448, IMU_T_CAMERA)
