"""`motorcade author`: a scene edited by recorded gestures."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command

DESCRIPTION = """\
Replay recorded gestures on a scene, on rotors or on Euler angles.

A scene names objects, parents before children. Rotations are wxyz, or euler_deg (intrinsic
x-y'-z''):

  {"objects": [{"name": "table", "position_m": [0, 0, 0.7]},
               {"name": "cup", "parent": "table", "wxyz": [1, 0, 0, 0], "scale": 0.5}]}

A line of the gestures does one thing; the frame of a drag is local, parent or global:

  {"object": "cup", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1, 0.3]}
  {"object": "cup", "do": "translate", "axis": [1, 0, 0], "frame": "global", "amounts_m": [0.2]}
  {"object": "cup", "do": "scale", "factors": [1.1, 1.3]}
  {"do": "copy", "object": "cup", "name": "mug"}
  {"do": "undo"}                      (or "redo")

docs/tutorials/gestures.md lists all that can be done."""


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        author_scene,
        name="author",
        summary="replay recorded gestures on a scene, on rotors or on Euler angles",
        example="motorcade author scene.json --gestures drags.jsonl -o edited.json",
    )
    parser.description = DESCRIPTION
    parser.add_argument("scene", type=Path, metavar="SCENE", help="JSON: objects with poses")
    parser.add_argument(
        "--gestures", type=Path, required=True, metavar="FILE", help="JSON lines of drags and edits"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the scene there")
    parser.add_argument(
        "--rotations",
        choices=("rotor", "euler"),
        default="rotor",
        help="how rotations are held (rotor)",
    )
    for name, unit in (("deg", "degrees"), ("m", "metres"), ("scale", "factors from 1")):
        parser.add_argument(
            f"--snap-{name}",
            type=float,
            default=0.0,
            metavar="STEP",
            help=f"round drags to steps, {unit} (none)",
        )
    parser.add_argument("--json", action="store_true", help="print figures as JSON")


def author_scene(arguments: argparse.Namespace) -> None:
    """Replay, write, and say where the two writings of rotations part."""
    import numpy as np

    from motorcade.animation.authoring import Snapping, scene_text
    from motorcade.replays.characters.authoring import author
    from motorcade.replays.cli.arguments import print_json
    from motorcade.replays.files.atomic import write_bytes

    snapping = Snapping(
        float(np.radians(arguments.snap_deg)), arguments.snap_m, arguments.snap_scale
    )
    made = author(arguments.scene, arguments.gestures, arguments.rotations, snapping)
    if arguments.output is not None:
        write_bytes(arguments.output, scene_text(made.scene).encode())
    if arguments.json:
        print_json(made.as_json())
        return
    print(f"{made.gestures} gestures; each object, and how far Euler angles end from rotors")
    for name, (degrees, metres) in made.apart.items():
        at = made.scene.world_T_object(name).translation_m
        print(
            f"  {name}: at {at[0]:z.3f} {at[1]:z.3f} {at[2]:z.3f} m; {degrees:.3f}°, {metres:.4f} m"
        )
