"""Commands that look at what is there: `motorcade inspect`, `view`, `export`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_axes,
    add_file,
    add_flag,
    add_number,
    print_json,
    shown,
)

if TYPE_CHECKING:
    from motorcade.replays.pipeline.runs import Shown


def add_inspect(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        inspect,
        "inspect",
        "say what a recording holds (frames, rates, streams, gaps, calibration), "
        "a bag (topics), poses, readings or positions, or a character (joints, triangles, clips)",
        "motorcade inspect images/ --manifest camera.toml --json\n"
        "  motorcade inspect knight.glb --pose Walking_A@0.5",
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING|BAG|FILE|CHARACTER")
    add_file(parser, "--manifest", "TOML description of the recording")
    parser.add_argument(
        "--pose", metavar="CLIP@SECONDS", help="also tell where a character's joints then are"
    )
    add_axes(parser)
    add_flag(parser, "--json", "machine-readable")


def inspect(arguments: argparse.Namespace) -> None:
    """Open the recording or character and print its contents."""
    from motorcade.animation.formats import SUFFIXES
    from motorcade.replays.tasks.inspection import describe_character

    is_character = arguments.recording.suffix.lower() in SUFFIXES
    if is_character:
        description = describe_character(
            arguments.recording, arguments.pose, up=arguments.up, front=arguments.front
        )
    elif unused := [one for one in ("pose", "up", "front") if getattr(arguments, one) is not None]:
        raise ValueError(f"--{unused[0]}: expected a character, got {arguments.recording}")
    else:
        description = _describe(arguments.recording, arguments.manifest)
    if arguments.json:
        print_json(description)
        return
    for key, value in description.items():
        _print(key, value)


def _describe(path: Path, manifest: Path | None) -> dict[str, Any]:
    """What a recording, a bag or a file of poses or readings holds."""
    from motorcade.replays.io.readers.opening import open_recording
    from motorcade.replays.io.readers.ros.recording import holds_images
    from motorcade.replays.io.trajectories import TEXT_SUFFIXES, is_bag
    from motorcade.replays.tasks.inspection import (
        describe,
        describe_bag,
        describe_log,
        describe_text,
        describe_whole,
        is_log,
    )

    if manifest is None and is_log(path):
        return describe_log(path)
    if manifest is None and path.is_file() and path.suffix.lower() in TEXT_SUFFIXES:
        return describe_text(path)
    if manifest is None and is_bag(path) and path.exists():
        held = describe_bag(path)
        return (describe(open_recording(path)) if holds_images(path) else {}) | held
    return describe_whole(path, manifest)


def _print(key: str, value: Any) -> None:
    """A line a value; a line an entry of lists, and what is inside an entry beside it.

    Of an empty list there is nothing to say.
    """
    if isinstance(value, dict):
        for inner, entry in value.items():
            _print(f"{key} {inner}" if inner != "joints" else key, entry)
        return
    if value == []:
        return
    if not (isinstance(value, list) and isinstance(value[0], dict | str)):
        print(f"{key:>28}  {shown(value)}")
        return
    for entry in value:
        print(f"{key:>28}  {_entry(entry)}")


def _entry(entry: Any) -> str:
    if not isinstance(entry, dict):
        return str(entry)
    parts = []
    for key, value in entry.items():
        if isinstance(value, list):
            value = "(" + ", ".join(f"{number:.4f}" for number in value) + ")"
        parts.append(str(value) if key == "name" else f"{key} {shown(value)}")
    return "  ".join(parts)


def add_view(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        view,
        "view",
        "look into a run in the browser: film, world and plots over one timeline",
        "motorcade view out/run",
    )
    add_file(parser, "run", "folder that `motorcade run` wrote", "RUN")
    add_file(parser, "other", "another run, set beside it", "OTHER", nargs="?")
    add_file(parser, "--out", "the page, ending in .html (default RUN/view.html)")
    add_flag(parser, "--no-open", "write the page, and open no browser")


def view(arguments: argparse.Namespace) -> None:
    """Write the page, and open it."""
    import webbrowser

    from motorcade.ga.progress import log_stages
    from motorcade.replays.pipeline.runs import write_view

    runs = [arguments.run] if arguments.other is None else [arguments.run, arguments.other]
    out = arguments.run / "view.html" if arguments.out is None else arguments.out
    with log_stages():
        written = write_view(runs, out)
    for path in written:
        print(f"wrote {path}")
    if not arguments.no_open:
        webbrowser.open(out.resolve().as_uri())


def add_export(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        export,
        "export",
        "write a run's camera path, characters and map for other programs: glTF, USD, "
        "Rerun, COLMAP, nerfstudio",
        "motorcade export out/run --gltf run.glb --rrd run.rrd",
    )
    add_file(parser, "run", "folder that `motorcade run` wrote", "RUN")
    add_file(parser, "--gltf", "binary glTF, ending in .glb")
    add_file(parser, "--rrd", "recording of Rerun")
    add_file(parser, "--usd", "USD, ending in .usda or .usdc")
    add_file(parser, "--colmap", "images and COLMAP's text model", "DIR")
    add_file(parser, "--nerfstudio", "images and transforms.json", "DIR")
    parser.add_argument(
        "--every", type=int, default=1, metavar="N", help="of the images written (1)"
    )
    add_number(
        parser,
        "--max-gap-s",
        "leave out frames between poses that are farther apart (glTF holds the path's own "
        "poses alone)",
        metavar="S",
    )


def export(arguments: argparse.Namespace) -> None:
    """Read the run and write what was asked for."""
    from motorcade.replays.pipeline.export import write_colmap, write_nerfstudio, write_usd
    from motorcade.replays.pipeline.runs import open_run, write_rrd, write_run_gltf

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
    shown = replace(open_run(arguments.run), max_gap_s=arguments.max_gap_s)
    for name, place in asked.items():
        writers[name](shown, place)
        print(f"wrote {place}")
