"""`motorcade smooth`: a trajectory file in, a smoother one out."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        smooth_file,
        name="smooth",
        summary="smooth a TUM, EuRoC or KITTI trajectory file",
        example="motorcade smooth poses.tum -o smooth.tum --method gaussian --set sigma_s=0.1",
    )
    parser.add_argument("input", type=Path, metavar="IN", help="trajectory file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT")
    parser.add_argument(
        "--representation", metavar="R", help="motor by default; of auto what predicts better"
    )
    parser.add_argument(
        "--method", default="auto", metavar="M", help="auto by default, which says what it picked"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the method, such as sigma_s=0.1; may be repeated",
    )
    parser.add_argument(
        "--list", action=_List, nargs=0, help="list methods, parameters, representations; and exit"
    )
    parser.add_argument(
        "--report", action="store_true", help="say how far poses moved and how jitter fell, as JSON"
    )
    parser.add_argument("--format", choices=("tum", "euroc", "kitti"), help="of both files")
    parser.add_argument("--rate-hz", type=float, help="rate of a KITTI file, which has no stamps")


def smooth_file(arguments: argparse.Namespace) -> None:
    """Read, smooth, write; say what "auto" picked and, where asked, what changed."""
    from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS, smooth, smoothed_automatically
    from motorcade.fusion.smoothing.changes import changes
    from motorcade.fusion.smoothing.methods import parsed_parameters
    from motorcade.replays.cli.arguments import check_known, print_json
    from motorcade.replays.files.trajectories import read_trajectory, write_trajectory

    check_known("--method", [arguments.method], METHODS)
    if arguments.representation is not None:
        check_known("--representation", [arguments.representation], REPRESENTATIONS)
    method = arguments.method
    parameters = parsed_parameters(method, arguments.set, "--set")
    trajectory = read_trajectory(arguments.input, arguments.format, rate_hz=arguments.rate_hz)
    picked = None
    if method == "auto":
        found = smoothed_automatically(trajectory, arguments.representation)
        picked, smoothed = found.choice, found.trajectory
    else:
        smoothed = smooth(trajectory, method, arguments.representation, **parameters)
    write_trajectory(smoothed, arguments.output, arguments.format)
    if arguments.report:
        used = {
            "method": method,
            "representation": arguments.representation or "motor",
        } | parameters
        if picked is not None:
            used["representation"] = picked.representation
            used |= {"noise_m": picked.noise_m, "noise_rad": picked.noise_rad}
            used |= {"outliers": picked.outliers, "even_stamps": picked.even_stamps}
        print_json(used | changes(trajectory, smoothed))
    elif picked is not None:
        print(f"auto: {picked}")


class _List(argparse.Action):
    """Print what there is to choose from, and exit."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS, method_parameters

        print("methods, and their parameters where they are not given:")
        for name in METHODS:
            defaults = " ".join(f"{key}={value}" for key, value in method_parameters(name).items())
            print(f"  {name:26s} {defaults}")
        print(f"representations: {', '.join(REPRESENTATIONS)}")
        parser.exit()
