"""`motorcade bench`: the performance figures, measured on this machine."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from motorcade.replays.bench.tables import SUITES, run_suite
from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        bench,
        name="bench",
        summary="measure performance beside GLM and other libraries, in one run",
        example="motorcade bench blend --json blend.json",
    )
    parser.add_argument(
        "suites",
        nargs="*",
        metavar="SUITE",
        help=f"{', '.join(SUITES)} (all)",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    parser.add_argument(
        "--svg", type=Path, metavar="FILE", help="draw those of animation there, beside ozz's"
    )


def bench(arguments: argparse.Namespace) -> None:
    """Run the suites asked for and print their tables."""
    from motorcade.replays.bench.page import MACHINE, machine
    from motorcade.replays.files.atomic import write_bytes

    chosen = arguments.suites or list(SUITES)
    unknown = [name for name in chosen if name not in SUITES]
    if unknown:
        raise ValueError(f"bench: expected suites of {', '.join(SUITES)}, came {unknown[0]!r}")
    if arguments.svg is not None and "animation" not in chosen:
        raise ValueError("bench --svg: expected the suite animation, which it draws, among those")
    figures: dict[str, Any] = {}
    for name in chosen:
        figures[name], table = run_suite(name)
        print(table)
    if arguments.svg is not None:
        from motorcade.render.plots import standing_alone
        from motorcade.replays.bench.pictures import animation_picture

        picture = animation_picture(figures["animation"])
        write_bytes(arguments.svg, standing_alone(picture).encode())
    if arguments.json is not None:
        figures[MACHINE] = machine()
        write_bytes(arguments.json, (json.dumps(figures, indent=2) + "\n").encode())
