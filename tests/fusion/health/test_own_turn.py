"""What a ground truth shows of the sensors: it has little noise, and faults of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.health import check_health
from motorcade.fusion.health.gyroscope import TurnedAngle, steady
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import read_trajectory
from tests.fusion.health.cases import FLIGHTS


def test_a_gyroscopes_bias_calls_no_pose_unsteady() -> None:
    """EuRoC's gyroscope is off by 0.08 rad/s, which poses without noise show at every step."""
    path = ContinuousPath.along(MOTIONS["handheld"], 20.0)
    sensor = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(0))
    bias = np.array([-0.002, 0.02, 0.077])
    stream = sensor.stream
    shown = ImuStream(stream.time_ns, stream.angular_rate_rad_s + bias, stream.specific_force_m_s2)
    camera = sensor.path[5:-5:4]
    kept = steady(camera, TurnedAngle(shown), 0.0, np.eye(3), bias, 0.01)
    assert np.all(kept)
    assert check_health(camera, shown, Motor.identity(), up=False).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", FLIGHTS)
def test_an_accelerometer_is_blamed_for_turns_that_no_ground_truth_makes(
    name: str, data_dir: Path
) -> None:
    """As recorded none is; turned by 20° about any axis, each is."""
    stream, states = (data_dir / one for one in FLIGHTS[name])
    imu, truth = read_imu(stream), read_trajectory(states, child="imu")
    truth = truth[(truth.time_ns >= imu.time_ns[0]) & (truth.time_ns <= imu.time_ns[-1])]
    assert check_health(truth, imu, Motor.identity(), up=False).findings == ()
    for axis in np.eye(3):
        turn = Rotor.from_rotation_vector(np.deg2rad(20.0) * axis)
        own = ImuStream(imu.time_ns, imu.angular_rate_rad_s, turn.apply(imu.specific_force_m_s2))
        found = check_health(truth, own, Motor.identity(), up=False)
        assert any("accelerometer" in one.summary for one in found.findings), axis
