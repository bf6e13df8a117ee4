"""`motorcade graph`: the stage graph as Mermaid text, or as an SVG file."""

from __future__ import annotations

import argparse
import textwrap
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command

WIDTH = 92


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        draw,
        name="graph",
        summary="draw the stage graph",
        example="motorcade graph --svg graph.svg",
    )
    parser.add_argument("--svg", type=Path, metavar="FILE", help="write a picture instead")
    parser.add_argument(
        "--knobs",
        action="store_true",
        help="tell every stage's knobs instead: default, values (units end the name), meaning",
    )


def draw(arguments: argparse.Namespace) -> None:
    """Print or write the drawing."""
    from motorcade.replays.described.opening import description_graph
    from motorcade.replays.engine import drawing
    from motorcade.replays.engine.knobs import described_knobs
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.pipeline import pipeline_graph

    graph = pipeline_graph()
    if arguments.svg is not None:
        write_bytes(arguments.svg, drawing.svg(graph).encode())
    elif arguments.knobs:
        for stage in (*description_graph().stages.values(), *graph.stages.values()):
            for knob in described_knobs(stage):
                print(f"{stage.name}.{knob.name}={knob.default}  ({knob.values})")
                print(textwrap.indent(textwrap.fill(knob.meaning, WIDTH), " " * 4))
    else:
        print(drawing.mermaid(graph), end="")
