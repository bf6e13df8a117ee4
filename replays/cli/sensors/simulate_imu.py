"""`motorcade simulate-imu`: the readings of an IMU that is moved along a trajectory."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, add_seed, new_command

if TYPE_CHECKING:
    from motorcade.fusion.imu import ImuFaults, ImuNoise
    from motorcade.ga import Motor

_THREE = ("X", "Y", "Z")


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        simulate,
        name="simulate-imu",
        summary="simulate an EuRoC-format IMU stream along a trajectory (z up, poses of the IMU)",
        example="motorcade simulate-imu truth.tum -o imu.csv --rate-hz 200 --seed 1 "
        "--gyro-bias 0.01 0 -0.02 --dropped 0.01",
    )
    parser.add_argument("trajectory", type=Path, metavar="TRAJECTORY")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.csv")
    parser.add_argument("--rate-hz", type=float, default=200.0, help="of the samples (200)")
    add_seed(parser, 0, "the noise")
    parser.add_argument(
        "--noise",
        metavar="FILE",
        default="",
        help="Kalibr or EuRoC YAML, or 'none'; else ADIS16448",
    )
    parser.add_argument(
        "--knots-s",
        type=float,
        default=0.1,
        help="spacing of the spline's knots; it follows motion up to 1 / (4 spacing) Hz (0.1)",
    )
    _add_extrinsics(parser)
    _add_faults(parser)


def _add_extrinsics(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("where the sensor sits, and its clock")
    group.add_argument(
        "--imu-from-poses",
        type=float,
        nargs=7,
        metavar=("TX", "TY", "TZ", "QX", "QY", "QZ", "QW"),
        help="where the poses are a camera's: that frame in the IMU's axes (imu_T_camera)",
    )
    group.add_argument(
        "--time-offset-s", type=float, default=0.0, help="what the IMU's clock shows too much"
    )


def _add_faults(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("faults of the sensor")
    for name, text in (
        ("--gyro-scale", "factors of the angular rate"),
        ("--accel-scale", "factors of the specific force"),
        ("--gyro-misalignment", "rad: y towards x, z towards x, z towards y"),
        ("--accel-misalignment", "rad: y towards x, z towards x, z towards y"),
        ("--gyro-bias", "rad/s, where the walk starts"),
        ("--accel-bias", "m/s², where the walk starts"),
    ):
        default = [1.0] * 3 if name.endswith("scale") else [0.0] * 3
        group.add_argument(name, type=float, nargs=3, metavar=_THREE, default=default, help=text)
    group.add_argument(
        "--gyro-range-rad-s", type=float, default=float("inf"), help="where it saturates (nowhere)"
    )
    group.add_argument(
        "--accel-range-m-s2", type=float, default=float("inf"), help="where it saturates (nowhere)"
    )
    group.add_argument("--gyro-step-rad-s", type=float, default=0.0, help="of the converter")
    group.add_argument("--accel-step-m-s2", type=float, default=0.0, help="of the converter")
    group.add_argument("--dropped", type=float, default=0.0, help="share of samples that are lost")


def simulate(arguments: argparse.Namespace) -> None:
    """Read the trajectory, simulate, write the stream."""
    import numpy as np

    from motorcade.fusion.imu import simulate_imu
    from motorcade.replays.files.imu import write_imu
    from motorcade.replays.files.trajectories import read_trajectory

    simulated = simulate_imu(
        read_trajectory(arguments.trajectory),
        arguments.rate_hz,
        _noise(arguments.noise),
        np.random.default_rng(arguments.seed),
        knot_spacing_s=arguments.knots_s,
        faults=_faults(arguments),
        imu_T_child=_extrinsics(arguments),
        time_offset_s=arguments.time_offset_s,
    )
    write_imu(simulated.stream, arguments.output)


def _noise(given: str) -> ImuNoise | None:
    from motorcade.fusion.imu import ADIS16448, ImuNoise

    if given == "none":
        return None
    return ImuNoise.load(Path(given)) if given else ADIS16448


def _faults(arguments: argparse.Namespace) -> ImuFaults:
    from motorcade.fusion.imu import ImuFaults

    return ImuFaults(
        gyro_scale=arguments.gyro_scale,
        accel_scale=arguments.accel_scale,
        gyro_misalignment_rad=arguments.gyro_misalignment,
        accel_misalignment_rad=arguments.accel_misalignment,
        gyro_bias_rad_s=arguments.gyro_bias,
        accel_bias_m_s2=arguments.accel_bias,
        gyro_range_rad_s=arguments.gyro_range_rad_s,
        accel_range_m_s2=arguments.accel_range_m_s2,
        gyro_step_rad_s=arguments.gyro_step_rad_s,
        accel_step_m_s2=arguments.accel_step_m_s2,
        dropped_share=arguments.dropped,
    )


def _extrinsics(arguments: argparse.Namespace) -> Motor | None:
    from motorcade.ga import Motor, Rotor

    if arguments.imu_from_poses is None:
        return None
    x, y, z, *turn, w = arguments.imu_from_poses
    size = sum(part**2 for part in (*turn, w)) ** 0.5
    if not abs(size - 1.0) < 1e-3:
        raise ValueError(f"--imu-from-poses: expected a unit quaternion, got one of length {size}")
    wxyz = [part / size for part in (w, *turn)]
    return Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), [x, y, z])
