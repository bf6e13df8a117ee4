"""`motorcade inspect`: what a recording holds."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command, print_json


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        inspect_recording,
        name="inspect",
        summary="say what a recording holds: frames, rates, streams, gaps, calibration",
        example="motorcade inspect images/ --manifest camera.toml --json",
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING")
    parser.add_argument("--manifest", type=Path, metavar="FILE")
    parser.add_argument("--json", action="store_true", help="machine-readable")


def inspect_recording(arguments: argparse.Namespace) -> None:
    """Open the recording and print its contents."""
    from motorcade.replays.inspection import describe
    from motorcade.replays.recording import open_recording

    description = describe(open_recording(arguments.recording, arguments.manifest))
    if arguments.json:
        print_json(description)
        return
    for key, value in description.items():
        print(f"{key:>28}  {value}")
