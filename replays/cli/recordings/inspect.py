"""`motorcade inspect`: what a recording, a character or a motion file holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from motorcade.replays.cli.arguments import Subparsers, add_axes, new_command, print_json, shown


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        inspect,
        name="inspect",
        summary="say what a recording holds (frames, rates, streams, gaps, calibration), "
        "a bag (topics), a file of poses or readings, or a character (joints, triangles, clips)",
        example="motorcade inspect images/ --manifest camera.toml --json\n"
        "  motorcade inspect knight.glb --pose Walking_A@0.5",
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING|BAG|FILE|CHARACTER")
    parser.add_argument(
        "--manifest", type=Path, metavar="FILE", help="TOML description of the recording"
    )
    parser.add_argument(
        "--pose", metavar="CLIP@SECONDS", help="also tell where a character's joints then are"
    )
    add_axes(parser)
    parser.add_argument("--json", action="store_true", help="machine-readable")


def inspect(arguments: argparse.Namespace) -> None:
    """Open the recording or character and print its contents."""
    from motorcade.animation.formats import SUFFIXES
    from motorcade.replays.inspection import describe_character

    is_character = arguments.recording.suffix.lower() in SUFFIXES
    if is_character:
        description = describe_character(
            arguments.recording, arguments.pose, up=arguments.up, front=arguments.front
        )
    elif given := [one for one in ("pose", "up", "front") if getattr(arguments, one) is not None]:
        raise ValueError(f"--{given[0]}: expected a character, got {arguments.recording}")
    else:
        description = _describe(arguments.recording, arguments.manifest)
    if arguments.json:
        print_json(description)
        return
    for key, value in description.items():
        _print(key, value)


def _describe(path: Path, manifest: Path | None) -> dict[str, Any]:
    """What a recording, a bag or a file of poses or readings holds."""
    from motorcade.replays.inspection import describe, describe_whole
    from motorcade.replays.listing import TEXT_SUFFIXES, describe_bag, describe_text
    from motorcade.replays.readers.opening import open_recording
    from motorcade.replays.readers.ros.naming import is_bag
    from motorcade.replays.readers.ros.recording import holds_pictures

    if manifest is None and path.is_file() and path.suffix.lower() in TEXT_SUFFIXES:
        return describe_text(path)
    if manifest is None and is_bag(path) and path.exists():
        held = describe_bag(path)
        return (describe(open_recording(path)) if holds_pictures(path) else {}) | held
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
