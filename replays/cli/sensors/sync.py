"""`motorcade sync`: time offset and extrinsics between a camera's trajectory and an IMU."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, add_stamps, new_command, shown

if TYPE_CHECKING:
    from motorcade.fusion.sync import Synchronised


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        sync,
        name="sync",
        summary="time offset and extrinsics between a camera's trajectory (metres) and an IMU",
        example="motorcade sync camera.tum imu0/data.csv --json sync.json",
    )
    parser.add_argument("camera", type=Path, metavar="CAMERA_TRAJECTORY")
    parser.add_argument(
        "imu",
        type=Path,
        metavar="IMU",
        help="EuRoC's CSV, a video with a GoPro's telemetry, or a recording with an IMU",
    )
    parser.add_argument(
        "--noise", type=Path, metavar="FILE", help="Kalibr or EuRoC YAML; without it: ADIS16448"
    )
    parser.add_argument(
        "--search-s", type=float, default=2.0, help="largest offset that is looked for (2 s)"
    )
    add_stamps(parser)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the results there")


def sync(arguments: argparse.Namespace) -> None:
    """Read both, estimate, print a table."""
    from motorcade.fusion.imu import ADIS16448, ImuNoise
    from motorcade.fusion.sync import synchronise
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.files.trajectories import read_trajectory
    from motorcade.replays.readers.opening import read_imu_of

    noise = ADIS16448 if arguments.noise is None else ImuNoise.load(arguments.noise)
    camera = read_trajectory(arguments.camera, rate_hz=arguments.rate_hz, times=arguments.times)
    imu = read_imu_of(arguments.imu)
    found = synchronise(camera, imu, noise, search_s=arguments.search_s)
    results = _as_dict(found)
    for line in (*(one.summary for one in found.health.findings), *found.health.unknown):
        print(f"{'health':>34}  {line}")
    for key, value in results.items():
        print(f"{key:>34}  {shown(value)}")
    if arguments.json is not None:
        about = results | {"health": found.health.as_dict()}
        write_bytes(arguments.json, (json.dumps(about, indent=2) + "\n").encode())


def _as_dict(found: Synchronised) -> dict[str, float | list[float]]:
    import numpy as np

    noise = found.imu_noise
    return {
        "offset_ms": 1e3 * found.offset_s,
        "offset_sigma_ms": 1e3 * found.offset_sigma_s,
        "imu_T_camera_wxyz": found.imu_T_camera.rotor.as_quaternion().tolist(),
        "rotation_sigma_deg": np.rad2deg(found.rotation_sigma_rad).tolist(),
        "imu_T_camera_translation_m": found.imu_T_camera.translation_m.tolist(),
        "translation_sigma_m": found.lever_arm_sigma_m.tolist(),
        "gravity_m_s2": found.gravity_m_s2.tolist(),
        "gyro_bias_rad_s": found.gyro_bias_rad_s.mean(axis=0).tolist(),
        "accel_bias_m_s2": found.accel_bias_m_s2.mean(axis=0).tolist(),
        "rate_correlation": found.correlation,
        "poses_used": len(found.time_ns),
        "camera_sigma_deg": float(np.rad2deg(found.camera_sigma_rad)),
        "camera_sigma_m": found.camera_sigma_m,
        "gyro_density_rad_s_rthz": noise.gyro_density_rad_s_rthz,
        "gyro_walk_rad_s2_rthz": noise.gyro_walk_rad_s2_rthz,
        "accel_density_m_s2_rthz": noise.accel_density_m_s2_rthz,
        "accel_walk_m_s3_rthz": noise.accel_walk_m_s3_rthz,
    }
