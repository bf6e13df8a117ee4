"""Measures performance on this machine, beside GLM and other libraries in the same run.

    make bench [SUITE=blend] [JSON=blend.json]
    python -m tests.bench blend accuracy --json figures.json

Without a suite all of them run, one after another; that takes hours.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motorcade.render.plots import standing_alone
from motorcade.replays.files.atomic import write_bytes
from tests.bench.page import MACHINE, machine
from tests.bench.pictures import animation_picture
from tests.bench.tables import SUITES, run_suite


def main(given: Sequence[str] | None = None) -> None:
    """Run the suites asked for and print their tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"{', '.join(SUITES)} (all)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    parser.add_argument(
        "--svg", type=Path, metavar="FILE", help="draw those of animation there, beside ozz's"
    )
    arguments = parser.parse_args(given)
    chosen = arguments.suites or list(SUITES)
    unknown = [name for name in chosen if name not in SUITES]
    if unknown:
        parser.error(f"expected suites of {', '.join(SUITES)}, got {unknown[0]!r}")
    if arguments.svg is not None and "animation" not in chosen:
        parser.error("--svg: expected the suite animation, which it draws, among those")
    figures: dict[str, Any] = {}
    for name in chosen:
        figures[name], table = run_suite(name)
        print(table)
    if arguments.svg is not None:
        picture = animation_picture(figures["animation"])
        write_bytes(arguments.svg, standing_alone(picture).encode())
    if arguments.json is not None:
        figures[MACHINE] = machine()
        write_bytes(arguments.json, (json.dumps(figures, indent=2) + "\n").encode())


if __name__ == "__main__":
    main()
