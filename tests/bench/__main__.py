"""Measures performance on this machine, beside GLM and other libraries in the same run.

    make bench                                    all, into docs/benchmarks.md and the README
    make bench SUITE=blend [JSON=blend.json]      one, at its full size, into the terminal
    python -m tests.bench blend accuracy --json figures.json

All together end within `--minutes`; each runs in a process of its own, so that one that fails costs
itself alone. The exit status is then 1, and the page names it.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motorcade.render.plots import standing_alone
from motorcade.replays.io.files import write_bytes
from tests.bench.images import animation_image
from tests.bench.page import IMAGES, MACHINE, RUNS, machine, page
from tests.bench.stages import stages_image
from tests.bench.tables import SUITES, run_suite
from tests.bench.whole.jobs import JOBS, MINUTES
from tests.bench.whole.quoted import with_figures_of
from tests.bench.whole.running import run_whole

REPOSITORY = Path(__file__).resolve().parents[2]


def main(given: Sequence[str] | None = None) -> None:
    """Run the suites asked for and print their tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"{', '.join(SUITES)} (all)")
    parser.add_argument("--minutes", type=float, default=MINUTES, help=f"for all ({MINUTES:g})")
    parser.add_argument(
        "--into",
        type=Path,
        default=REPOSITORY,
        metavar="DIR",
        help="whose page and README to write",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    parser.add_argument(
        "--svg", type=Path, metavar="FILE", help="draw those of animation there, beside ozz's"
    )
    arguments = parser.parse_args(given)
    if not arguments.suites:
        if arguments.svg is not None:
            parser.error("--svg: expected the suite animation, which it draws, among those")
        raise SystemExit(_whole(arguments))
    chosen = arguments.suites
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
        image = animation_image(figures["animation"])
        write_bytes(arguments.svg, standing_alone(image).encode())
    if arguments.json is not None:
        figures[MACHINE] = machine()
        write_bytes(arguments.json, (json.dumps(figures, indent=2) + "\n").encode())


def _whole(arguments: argparse.Namespace) -> int:
    """Measure all, write page and README; 0 where every job found what it looked for."""
    figures = run_whole(JOBS, arguments.minutes)
    kept = arguments.json or arguments.into / "build" / "bench.json"
    write_bytes(kept, (json.dumps(figures, indent=2) + "\n").encode())
    text = page(figures)
    write_bytes(arguments.into / "docs" / "benchmarks.md", text.encode())
    if "stages" in figures:
        image = standing_alone(stages_image(figures["stages"]))
        write_bytes(arguments.into / "docs" / IMAGES["stages"][0], image.encode())
    readme = arguments.into / "README.md"
    write_bytes(readme, with_figures_of(readme.read_text(encoding="utf-8"), text).encode())
    left_out = [name for name, run in figures[RUNS].items() if "left_out" in run]
    told = f"left out: {', '.join(left_out)}" if left_out else "nothing left out"
    print(f"wrote docs/benchmarks.md and the README's figures from {kept}; {told}")
    return int(bool(left_out))


if __name__ == "__main__":
    main()
