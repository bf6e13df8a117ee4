"""`motorcade export`: a run for other viewers."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, new_command

if TYPE_CHECKING:
    from motorcade.replays.export import Shown


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        export,
        name="export",
        summary="write a run's camera path, characters and map for other programs: glTF, USD, "
        "Rerun, COLMAP, nerfstudio",
        example="motorcade export out/run --gltf run.glb --rrd run.rrd",
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that `motorcade run` wrote")
    parser.add_argument("--gltf", type=Path, metavar="FILE", help="binary glTF, ending in .glb")
    parser.add_argument("--rrd", type=Path, metavar="FILE", help="recording of Rerun")
    parser.add_argument("--usd", type=Path, metavar="FILE", help="USD, ending in .usda or .usdc")
    parser.add_argument(
        "--colmap", type=Path, metavar="DIR", help="pictures and COLMAP's text model"
    )
    parser.add_argument(
        "--nerfstudio", type=Path, metavar="DIR", help="pictures and transforms.json"
    )
    parser.add_argument(
        "--every", type=int, default=1, metavar="N", help="of the pictures written (1)"
    )


def export(arguments: argparse.Namespace) -> None:
    """Read the run and write what was asked for."""
    from motorcade.replays.export import open_run, write_rrd, write_run_gltf
    from motorcade.replays.exporting.colmap import write_colmap
    from motorcade.replays.exporting.nerfstudio import write_nerfstudio
    from motorcade.replays.exporting.usd import write_usd

    writers: dict[str, Callable[[Shown, Path], None]] = {
        "gltf": write_run_gltf,
        "rrd": write_rrd,
        "usd": write_usd,
        "colmap": partial(write_colmap, every=arguments.every),
        "nerfstudio": partial(write_nerfstudio, every=arguments.every),
    }
    asked = {name: place for name in writers if (place := getattr(arguments, name)) is not None}
    if not asked:
        raise ValueError(f"export: expected one of --{', --'.join(writers)}, got none")
    shown = open_run(arguments.run)
    for name, place in asked.items():
        writers[name](shown, place)
        print(f"wrote {place}")
