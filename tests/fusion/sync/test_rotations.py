"""The offset by orientations alone: found, with an uncertainty that errors agree with."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.sync.rotations import RotationOffset, offset_by_rotations
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

MOUNT = Motor.from_euler_translation(np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07]))
BIAS = np.array([0.02, -0.01, 0.08])
OFFSET_S = 0.0123


@pytest.fixture(scope="module")
def flown() -> tuple[Trajectory, ImuStream]:
    """``world_T_camera`` on its own clock and the stream, whose gyroscope has a bias."""
    path = ContinuousPath.along(MOTIONS["handheld"], 30.0, start_ns=10**18)
    sensor = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(0))
    stream = sensor.stream
    imu = ImuStream(stream.time_ns, stream.angular_rate_rad_s + BIAS, stream.specific_force_m_s2)
    return sensor.path.transformed_by(right=MOUNT), imu


def found(
    flown: tuple[Trajectory, ImuStream], seed: int, wander: FloatArray | None = None
) -> RotationOffset:
    camera, imu = flown
    rng = np.random.default_rng(seed)
    path = simulate_camera_poses(camera, 20.0, 0.01, float(np.deg2rad(0.5)), rng).trajectory[8:-8]
    if wander is not None:  # errors that last, as those of a smoothed path do
        steps = rng.standard_normal((len(path), 3))
        for row in range(1, len(steps)):
            steps[row] = wander[0] * steps[row - 1] + np.sqrt(1.0 - wander[0] ** 2) * steps[row]
        turns = Motor.from_twist(np.concatenate([wander[1] * steps, 0.0 * steps], axis=-1))
        path = path.transformed_by(right=turns)
    late = Trajectory(path.time_ns - round(OFFSET_S * 1e9), path.motors)
    told = offset_by_rotations(late, imu, 0.0, MOUNT.rotor, np.zeros(3) + 0.8 * BIAS)
    assert told is not None
    return told


def squares(told: list[RotationOffset], white: bool = False) -> float:
    """Of errors in stated deviations, summed up."""
    return sum(
        ((one.offset_s - OFFSET_S) / (one.white_s if white else one.sigma_s)) ** 2 for one in told
    )


def test_errors_are_as_large_as_stated(flown):
    low, high = chi2.ppf([1e-3, 0.999], 8)
    assert low < squares([found(flown, seed) for seed in range(8)]) < high


@pytest.mark.slow
def test_errors_that_last_are_noticed(flown):
    """Errors of poses that last for a second: the residuals' size alone would not tell."""
    told = [found(flown, seed, np.array([0.97, 0.03])) for seed in range(16)]
    low, high = chi2.ppf([1e-3, 0.999], 16)
    assert low < squares(told) < high < squares(told, white=True)


def test_a_perfect_camera_tells_a_perfect_offset(flown):
    camera, imu = flown
    late = Trajectory(camera.time_ns - round(OFFSET_S * 1e9), camera.motors)[40:-40:10]
    wrong = Rotor.from_rotation_vector(np.array([0.05, -0.03, 0.02])) @ MOUNT.rotor
    told = offset_by_rotations(late, imu, 0.0, wrong, BIAS)
    assert told is not None
    assert told.sigma_s < 1e-4
    assert told.offset_s == pytest.approx(OFFSET_S, abs=3.0 * told.sigma_s)


def test_positions_have_no_say(flown):
    camera, imu = flown
    late = Trajectory(camera.time_ns - round(OFFSET_S * 1e9), camera.motors)[40:-40:10]
    shifted = Motor.from_rotor_translation(late.motors.rotor, np.zeros(3))
    one, other = (
        offset_by_rotations(Trajectory(late.time_ns, motors), imu, 0.0, MOUNT.rotor, BIAS)
        for motors in (late.motors, shifted)
    )
    assert one is not None
    assert other is not None
    assert one.offset_s == other.offset_s


def test_too_few_poses_tell_nothing(flown):
    camera, imu = flown
    assert offset_by_rotations(camera[40:100:10], imu, 0.0, MOUNT.rotor, BIAS) is None
