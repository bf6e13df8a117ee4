"""`motorcade export`: a run for other viewers."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        export,
        name="export",
        summary="write a run's camera path, character and map as glTF, or for the Rerun viewer",
        example="motorcade export out/run --gltf run.glb --rrd run.rrd",
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that `motorcade run` wrote")
    parser.add_argument("--gltf", type=Path, metavar="FILE", help="binary glTF, ending in .glb")
    parser.add_argument("--rrd", type=Path, metavar="FILE", help="recording of Rerun")


def export(arguments: argparse.Namespace) -> None:
    """Read the run and write what was asked for."""
    from motorcade.replays.export import open_run, write_rrd, write_run_gltf

    if arguments.gltf is None and arguments.rrd is None:
        raise ValueError("export: expected --gltf FILE or --rrd FILE, got neither")
    shown = open_run(arguments.run)
    if arguments.gltf is not None:
        write_run_gltf(shown, arguments.gltf)
        print(f"wrote {arguments.gltf}")
    if arguments.rrd is not None:
        write_rrd(shown, arguments.rrd)
        print(f"wrote {arguments.rrd}")
