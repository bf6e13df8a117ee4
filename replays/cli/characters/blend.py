"""`motorcade blend`: two clips of a character made one, and the methods compared on them."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, add_axes, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        blend,
        name="blend",
        summary="blend two clips of a character, as glTF or video, by any method",
        example="motorcade blend knight.glb --clips Walking_A,Running_A --weight 0.4 --out b.mp4",
    )
    parser.add_argument("character", type=Path, metavar="CHARACTER", help="glb, gltf, dae, …")
    parser.add_argument("--clips", required=True, metavar="A,B", help="names of two clips")
    parser.add_argument("--weight", type=float, default=0.5, metavar="W", help="of B (0.5)")
    parser.add_argument(
        "--method",
        default="motor",
        metavar="M",
        help="motor, similarity, rotor, dual_quaternion or quaternion, each also with _linear; or "
        "euler (motor)",
    )
    parser.add_argument(
        "--motion",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="take clips from this file as well, retargeted by what joints are; may be repeated",
    )
    add_axes(parser)
    parser.add_argument("--rate-hz", type=float, default=60.0, help="keys a second (60)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write .glb or .mp4")
    parser.add_argument("--json", action="store_true", help="print figures as JSON")


def blend(arguments: argparse.Namespace) -> None:
    """Read, blend, write; print how far the methods lie apart."""
    from motorcade.replays.characters.blending import blend_character, character_with, write_blend
    from motorcade.replays.cli.arguments import print_json

    names = tuple(name.strip() for name in arguments.clips.split(","))
    if len(names) != 2:
        raise ValueError(f"--clips {arguments.clips}: expected two names with a comma between")
    character = character_with(
        arguments.character, arguments.motion, up=arguments.up, front=arguments.front
    )
    made = blend_character(
        character,
        (names[0], names[1]),
        arguments.weight,
        arguments.method,
        rate_hz=arguments.rate_hz,
    )
    if arguments.out is not None:
        write_blend(made, arguments.out)
    if arguments.json:
        print_json(made.as_json())
        return
    way = f"in phase, offset {made.offset:.3f}" if made.in_phase else "by the clock"
    print(f"{made.clip.name}: {made.clip.duration_s:.3f} s, {len(made.clip.time_s)} keys, {way}")
    print("largest distance of a joint that carries vertices under two methods, mm")
    for (a, b), apart_m in made.differences_m.items():
        print(f"  {a + ' - ' + b:<48}{1e3 * apart_m:>10.3f}")
