"""An IMU carried along a scenario's true path, for what fuses images with inertia.

The sensor sits beside the camera, x ahead and z up, and has the noise of EuRoC's ADIS16448.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import even_stamps
from tests.textured_room.scenarios import RATE_HZ, Scenario

__all__ = ["IMU_RATE_HZ", "IMU_T_CAMERA", "simulated_imu", "write_inertial"]

IMU_RATE_HZ = 200.0
# Camera axes (x right, y down, z ahead) in those of the IMU, 5 cm ahead and 2 cm to its left.
_AXES = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
IMU_T_CAMERA = Motor.from_rotor_translation(Rotor.from_matrix(_AXES), np.array([0.05, 0.02, 0.01]))
_KNOTS_S = 0.05
_AFTER_S = 0.05


def simulated_imu(scenario: Scenario) -> ImuStream:
    """What the IMU reads from the first frame until a little after the last one."""
    last_s = (scenario.frames - 1) / RATE_HZ + _AFTER_S
    time_ns = even_stamps(int(2 * IMU_RATE_HZ * last_s) + 1, 2 * IMU_RATE_HZ)
    world_T_imu = Trajectory(time_ns, scenario.path(time_ns * 1e-9) @ IMU_T_CAMERA.inverse())
    rng = np.random.default_rng([scenario.seed, 2])
    return simulate_imu(world_T_imu, IMU_RATE_HZ, ADIS16448, rng, knot_spacing_s=_KNOTS_S).stream


def write_inertial(folder: Path, scenario: Scenario) -> list[str]:
    """Write `imu.csv` (EuRoC's columns) and `imu.yaml`; returns the manifest's lines about them."""
    write_imu(simulated_imu(scenario), folder / "imu.csv")
    (folder / "imu.yaml").write_text(
        f"gyroscope_noise_density: {ADIS16448.gyro_density_rad_s_rthz!r}\n"
        f"gyroscope_random_walk: {ADIS16448.gyro_walk_rad_s2_rthz!r}\n"
        f"accelerometer_noise_density: {ADIS16448.accel_density_m_s2_rthz!r}\n"
        f"accelerometer_random_walk: {ADIS16448.accel_walk_m_s3_rthz!r}\n",
        encoding="utf-8",
    )
    return [
        "",
        "[imu]",
        'file = "imu.csv"',
        'noise_file = "imu.yaml"',
        f"imu_T_camera = {IMU_T_CAMERA.as_matrix().tolist()!r}",
    ]
