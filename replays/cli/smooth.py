"""`motorcade smooth`: a trajectory file in, a smoother one out."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        smooth_file,
        name="smooth",
        summary="smooth a TUM, EuRoC or KITTI trajectory file without lag",
        example="motorcade smooth poses.tum -o smooth.tum --representation motor --window-s 0.3",
    )
    parser.add_argument("input", type=Path, metavar="IN", help="trajectory file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT")
    parser.add_argument(
        "--representation",
        choices=("motor", "quaternion", "euler_unwrapped", "euler"),
        default="motor",
    )
    parser.add_argument("--window-s", type=float, default=0.3, help="width of the window (0.3 s)")
    parser.add_argument("--order", type=int, default=2, help="order of the local polynomial (2)")
    parser.add_argument("--format", choices=("tum", "euroc", "kitti"), help="of both files")
    parser.add_argument("--rate-hz", type=float, help="rate of a KITTI file, which has no stamps")


def smooth_file(arguments: argparse.Namespace) -> None:
    """Read, smooth, write."""
    from motorcade.fusion.smooth import smooth
    from motorcade.replays.trajectory_files import read_trajectory, write_trajectory

    trajectory = read_trajectory(arguments.input, arguments.format, rate_hz=arguments.rate_hz)
    smoothed = smooth(
        trajectory,
        "local_polynomial",
        representation=arguments.representation,
        window_s=arguments.window_s,
        order=arguments.order,
    )
    write_trajectory(smoothed, arguments.output, arguments.format)
