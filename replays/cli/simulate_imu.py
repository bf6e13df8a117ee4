"""`motorcade simulate-imu`: the IMU stream that a trajectory's carrier would have measured."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        simulate,
        name="simulate-imu",
        summary="simulate an EuRoC-format IMU stream along a trajectory (z up, poses of the IMU)",
        example="motorcade simulate-imu truth.tum -o imu.csv --rate-hz 200 --seed 1",
    )
    parser.add_argument("trajectory", type=Path, metavar="TRAJECTORY")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.csv")
    parser.add_argument("--rate-hz", type=float, default=200.0)
    parser.add_argument(
        "--noise", type=Path, metavar="FILE", help="Kalibr or EuRoC YAML; without it: ADIS16448"
    )
    parser.add_argument("--seed", type=int, default=0)


def simulate(arguments: argparse.Namespace) -> None:
    """Read the trajectory, simulate, write the stream."""
    import numpy as np

    from motorcade.fusion.imu import ADIS16448, ImuNoise, simulate_imu
    from motorcade.replays.imu_files import write_imu
    from motorcade.replays.trajectory_files import read_trajectory

    noise = ADIS16448 if arguments.noise is None else ImuNoise.load(arguments.noise)
    trajectory = read_trajectory(arguments.trajectory)
    simulated = simulate_imu(
        trajectory, arguments.rate_hz, noise, np.random.default_rng(arguments.seed)
    )
    write_imu(simulated.stream, arguments.output)
