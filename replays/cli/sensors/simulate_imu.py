"""`motorcade simulate-imu`: the readings of an IMU that is moved along a trajectory."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, add_seed, new_command

if TYPE_CHECKING:
    from motorcade.fusion.imu import ImuFaults, ImuNoise, VibrationSpectrum
    from motorcade.ga import Motor

_THREE = ("X", "Y", "Z")


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        simulate,
        name="simulate-imu",
        summary="simulate an IMU along a trajectory (z up, poses of the IMU), as CSV or .npz",
        example="motorcade simulate-imu truth.tum -o imu.csv --rate-hz 200 --seed 1 "
        "--gyro-bias 0.01 0 -0.02 --dropped 0.01",
    )
    parser.add_argument("trajectory", type=Path, metavar="TRAJECTORY")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help="EuRoC's CSV, or the same arrays as .npz: smaller, and quicker to write and read",
    )
    parser.add_argument("--rate-hz", type=float, default=200.0, help="of the samples (200)")
    parser.add_argument(
        "--times", type=Path, metavar="FILE", help="stamps of a KITTI file's poses, one a row, s"
    )
    add_seed(parser, 0, "the noise")
    parser.add_argument(
        "--noise",
        metavar="FILE",
        nargs="+",
        default=[],
        help="Kalibr or EuRoC YAML, or one for each of x, y and z, or 'none'; else ADIS16448",
    )
    parser.add_argument(
        "--knots-s",
        type=float,
        default=0.1,
        help="spacing of the spline's knots; it follows motion up to 1 / (4 spacing) Hz (0.1)",
    )
    _add_extrinsics(parser)
    _add_faults(parser)
    _add_vibration(parser)


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


_AXES = (
    ("--gyro-scale", "factors of the angular rate"),
    ("--accel-scale", "factors of the specific force"),
    ("--gyro-misalignment", "rad: y towards x, z towards x, z towards y"),
    ("--accel-misalignment", "rad: y towards x, z towards x, z towards y"),
    ("--gyro-turn", "rad, rotation vector from the accelerometer's axes to the gyroscope's"),
    ("--gyro-g-sensitivity", "(rad/s)/(m/s²), rate read for force along each axis"),
    ("--gyro-bias", "rad/s, where the walk starts"),
    ("--accel-bias", "m/s², where the walk starts"),
    ("--gyro-flicker", "rad/s, bias instability"),
    ("--accel-flicker", "m/s², bias instability"),
    ("--gyro-bias-per-k", "rad/s for each kelvin of warming"),
    ("--accel-bias-per-k", "m/s² for each kelvin of warming"),
    ("--gyro-scale-per-k", "growth of the factors for each kelvin"),
    ("--accel-scale-per-k", "growth of the factors for each kelvin"),
)
_NUMBERS = (
    ("--warming-k", 0.0, "kelvins by which the sensor gets warmer in the end"),
    ("--warming-time-s", 600.0, "within which it does 63 %% of that (600)"),
    ("--gyro-lowpass-hz", float("inf"), "its own filter, a Butterworth of second order (none)"),
    ("--accel-lowpass-hz", float("inf"), "its own filter, a Butterworth of second order (none)"),
    ("--gyro-delay-s", 0.0, "how much readings are older than their stamps"),
    ("--accel-delay-s", 0.0, "how much readings are older than their stamps"),
    ("--stamp-jitter-s", 0.0, "deviation of stamps, up to a quarter of the interval"),
    ("--gyro-range-rad-s", float("inf"), "where it saturates (nowhere)"),
    ("--accel-range-m-s2", float("inf"), "where it saturates (nowhere)"),
    ("--gyro-step-rad-s", 0.0, "of the converter"),
    ("--accel-step-m-s2", 0.0, "of the converter"),
    ("--dropped", 0.0, "share of samples that are lost"),
)


def _add_faults(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("faults of the sensor")
    for name, text in _AXES:
        default = [1.0] * 3 if name.endswith("scale") else [0.0] * 3
        group.add_argument(name, type=float, nargs=3, metavar=_THREE, default=default, help=text)
    for name, number, text in _NUMBERS:
        group.add_argument(name, type=float, default=number, help=text)


def _add_vibration(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("vibration of what carries it")
    given = group.add_mutually_exclusive_group()
    given.add_argument(
        "--vibration",
        type=Path,
        metavar="SPECTRUM.csv",
        help="rows of Hz, (rad/s)²/Hz for x, y, z and (m/s²)²/Hz for x, y, z",
    )
    given.add_argument(
        "--vibration-of", type=Path, metavar="IMU", help="a recording in motion to learn it from"
    )
    group.add_argument(
        "--vibration-above-hz",
        type=float,
        default=10.0,
        help="what is slower in that recording is its motion (10)",
    )


def simulate(arguments: argparse.Namespace) -> None:
    """Read the trajectory, simulate, write the stream."""
    import numpy as np

    from motorcade.fusion.imu import simulate_imu_in_chunks
    from motorcade.replays.files.imu import write_imu
    from motorcade.replays.files.trajectories import read_trajectory

    simulated = simulate_imu_in_chunks(
        read_trajectory(arguments.trajectory, times=arguments.times),
        arguments.rate_hz,
        _noise(arguments.noise),
        np.random.default_rng(arguments.seed),
        knot_spacing_s=arguments.knots_s,
        faults=_faults(arguments),
        vibration=_vibration(arguments),
        imu_T_child=_extrinsics(arguments),
        time_offset_s=arguments.time_offset_s,
    )
    write_imu((chunk.stream for chunk in simulated), arguments.output)


def _noise(given: list[str]) -> ImuNoise | tuple[ImuNoise, ...] | None:
    from motorcade.fusion.imu import ADIS16448, ImuNoise

    if given == ["none"]:
        return None
    if len(given) not in (0, 1, 3):
        raise ValueError(f"--noise: expected one file, or one for each axis, got {len(given)}")
    axes = tuple(ImuNoise.load(Path(file)) for file in given)
    return axes if len(axes) == 3 else axes[0] if axes else ADIS16448


def _faults(arguments: argparse.Namespace) -> ImuFaults:
    from motorcade.fusion.imu import ImuFaults

    return ImuFaults(
        gyro_scale=arguments.gyro_scale,
        accel_scale=arguments.accel_scale,
        gyro_misalignment_rad=arguments.gyro_misalignment,
        accel_misalignment_rad=arguments.accel_misalignment,
        gyro_turn_rad=arguments.gyro_turn,
        gyro_g_sensitivity_rad_s_m=arguments.gyro_g_sensitivity,
        gyro_bias_rad_s=arguments.gyro_bias,
        accel_bias_m_s2=arguments.accel_bias,
        gyro_flicker_rad_s=arguments.gyro_flicker,
        accel_flicker_m_s2=arguments.accel_flicker,
        warming_k=arguments.warming_k,
        warming_time_s=arguments.warming_time_s,
        gyro_bias_rad_s_k=arguments.gyro_bias_per_k,
        accel_bias_m_s2_k=arguments.accel_bias_per_k,
        gyro_scale_k=arguments.gyro_scale_per_k,
        accel_scale_k=arguments.accel_scale_per_k,
        gyro_lowpass_hz=arguments.gyro_lowpass_hz,
        accel_lowpass_hz=arguments.accel_lowpass_hz,
        gyro_delay_s=arguments.gyro_delay_s,
        accel_delay_s=arguments.accel_delay_s,
        stamp_jitter_s=arguments.stamp_jitter_s,
        gyro_range_rad_s=arguments.gyro_range_rad_s,
        accel_range_m_s2=arguments.accel_range_m_s2,
        gyro_step_rad_s=arguments.gyro_step_rad_s,
        accel_step_m_s2=arguments.accel_step_m_s2,
        dropped_share=arguments.dropped,
    )


def _vibration(arguments: argparse.Namespace) -> VibrationSpectrum | None:
    from motorcade.fusion.imu import VibrationSpectrum
    from motorcade.replays.files.imu import read_imu
    from motorcade.replays.files.vibration import read_vibration

    if arguments.vibration is not None:
        return read_vibration(arguments.vibration)
    if arguments.vibration_of is None:
        return None
    return VibrationSpectrum.learnt(read_imu(arguments.vibration_of), arguments.vibration_above_hz)


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
