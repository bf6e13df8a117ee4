"""`motorcade draw`: a picture of what a CLUScript marks with ``:``."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        draw_file,
        name="draw",
        summary="draw what a CLUScript marks with ':', as SVG or as a page that turns",
        example="motorcade draw reach.clu x=1 y=0.5 t=0,0.25,0.5 -o reach.svg",
    )
    parser.add_argument("script", type=Path, metavar="SCRIPT", help="with marks such as :a;")
    parser.add_argument(
        "values",
        nargs="*",
        type=_value,
        metavar="NAME=VALUE",
        help="of free variables; several values with commas draw as many objects, or a path",
    )
    parser.add_argument(
        "--algebra",
        metavar="NAME",
        help="of a script that does not name it: cga3, pga3, … or a definition, FILE.toml (cga3)",
    )
    parser.add_argument(
        "--view",
        nargs=2,
        type=float,
        default=(-52.0, 22.0),
        metavar=("AZIMUTH", "ELEVATION"),
        help="the direction to the viewer in degrees, from x about z and up (-52 22)",
    )
    parser.add_argument(
        "--size",
        nargs=2,
        type=int,
        default=(640, 480),
        metavar=("WIDTH", "HEIGHT"),
        help="in pixels (640 480)",
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", required=True, help="to write: .svg or .html"
    )


def _value(text: str) -> tuple[str, list[float]]:
    name, _, given = text.partition("=")
    try:
        values = [float(part) for part in given.split(",")]
    except ValueError:
        values = []
    if not name or not values or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE or NAME=VALUE,…, got {text[:40]!a}")
    return name, values


def draw_file(arguments: argparse.Namespace) -> None:
    """Read, draw, and write the picture."""
    import numpy as np

    from motorcade.ga.codegen.generate import read_script
    from motorcade.ga.drawing import draw_script
    from motorcade.ga.drawing.view import View
    from motorcade.ga.script.meaning import with_algebra
    from motorcade.replays.files.atomic import write_bytes

    given = dict(arguments.values)
    if len(given) < len(arguments.values):
        raise ValueError("NAME=VALUE: expected each variable once")
    view = View(*arguments.view, *arguments.size)
    script = read_script(arguments.script)
    if arguments.algebra is not None:
        script = with_algebra(script, arguments.algebra)
    values: dict[str, Any] = {n: np.array(v) if len(v) > 1 else v[0] for n, v in given.items()}
    picture = draw_script(
        script,
        title=arguments.script.stem,
        view=view,
        **values,
    )
    texts = {".svg": picture.svg, ".html": picture.html}
    if arguments.output.suffix not in texts:
        raise ValueError(f"-o {arguments.output}: expected a name that ends in .svg or .html")
    write_bytes(arguments.output, texts[arguments.output.suffix]().encode())
    for note in picture.left_out:
        sys.stderr.write(f"{note}\n")
