"""`motorcade evaluate`: errors of an estimated trajectory against a reference."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command

_FIRST = frozenset(
    {
        "align",
        "pairs",
        "scale",
        "ape_rmse_m",
        "ape_max_m",
        "rotation_rmse_deg",
        "rotation_max_deg",
        "rpe_trans_rmse_m",
        "rpe_rot_rmse_deg",
        "linear_jitter_m_s2",
        "angular_jitter_rad_s2",
        "lag_ms",
        "angular_rate_lag_ms",
    }
)
"""Figures that are printed, where there are any, if not all are asked for."""


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        evaluate_files,
        name="evaluate",
        summary="absolute and relative pose error, jitter, lag and artifacts against a reference",
        example="motorcade evaluate estimate.tum truth.tum --align se3 --json errors.json",
    )
    parser.add_argument("estimate", type=Path, metavar="EST", help="TUM, EuRoC or KITTI file")
    parser.add_argument("reference", type=Path, metavar="REF", help="the same: the ground truth")
    parser.add_argument(
        "--align",
        choices=("none", "se3", "sim3"),
        default="none",
        help="fit the estimate to the reference first, rigidly or with scale (none)",
    )
    parser.add_argument(
        "--max-difference-s",
        type=float,
        default=0.01,
        help="stamps farther apart are not paired (0.01 s)",
    )
    parser.add_argument(
        "--rpe-length-m",
        type=float,
        default=1.0,
        help="length of path for the relative error by length (1 m)",
    )
    parser.add_argument(
        "--energy-above-hz",
        type=float,
        default=5.0,
        help="cut-off of the spectral energy (5 Hz, or a quarter of a slow rate)",
    )
    parser.add_argument(
        "--all", action="store_true", help="print every figure, not only those that matter most"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all results there")
    parser.add_argument("--rate-hz", type=float, help="rate of KITTI files, which have no stamps")


def evaluate_files(arguments: argparse.Namespace) -> None:
    """Read both, evaluate, print a table."""
    from motorcade.fusion.metrics import evaluate
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.files.trajectories import read_trajectory

    estimate = read_trajectory(arguments.estimate, rate_hz=arguments.rate_hz)
    reference = read_trajectory(arguments.reference, rate_hz=arguments.rate_hz)
    errors = evaluate(
        estimate,
        reference,
        align=arguments.align,
        max_difference_s=arguments.max_difference_s,
        rpe_length_m=arguments.rpe_length_m,
        energy_above_hz=arguments.energy_above_hz,
    ).as_dict()
    for key, value in errors.items():
        if arguments.all or (key in _FIRST and value is not None):
            print(f"{key:>30}  {value:.9g}" if isinstance(value, float) else f"{key:>30}  {value}")
    if arguments.json is not None:
        write_bytes(arguments.json, (json.dumps(errors, indent=2) + "\n").encode())
