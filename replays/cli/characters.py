"""Commands on characters and scenes: `motorcade author`, `blend`."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import (
    Commands,
    add_axes,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_server,
    listening_of,
)

DESCRIPTION = """\
Edit a scene by hand in the browser: characters and things put into the footage of a run, moved by
touch or mouse. It listens on this machine alone; --lan lets others of the network in who have the
link. What is done is kept as it is done, in RUN/scene.json and, to be replayed, beside it in
RUN/scene.session; `motorcade run RECORDING --scene RUN/scene.json` draws it.

With --gestures, replay recorded gestures on a scene, on rotors or on Euler angles.

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


def add_author(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        author_scene,
        "author",
        "edit a scene in the browser, or replay recorded gestures on it",
        "motorcade author out/demo",
    )
    parser.description = DESCRIPTION
    add_file(parser, "scene", "a run's folder, a folder of runs, or a scene (JSON)", "RUN|SCENE")
    add_file(parser, "--run", "of a SCENE that lies elsewhere", "RUN")
    add_server(parser)
    add_file(parser, "--gestures", "replay these drags and edits on SCENE")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the scene there")
    add_choice(parser, "--rotations", ("rotor", "euler"), "how rotations are held (rotor)", "rotor")
    for name, unit in (("deg", "degrees"), ("m", "metres"), ("scale", "factors from 1")):
        add_number(
            parser, f"--snap-{name}", f"round drags to steps, {unit} (none)", 0.0, metavar="STEP"
        )
    add_flag(parser, "--json", "print figures as JSON")


def _serve(arguments: argparse.Namespace) -> None:
    """Serve the editor until it is stopped."""
    try:
        from motorcade.ga.progress import log_stages
        from motorcade.replays.studio.app import studio_app
        from motorcade.replays.studio.desk import offered, ready
        from motorcade.replays.studio.serving import serve
    except ModuleNotFoundError as missing:
        raise RuntimeError(
            f"editing in the browser needs the Python package {missing.name}, which is not "
            'installed; pip install "motorcade[studio]" brings it, or replay with --gestures'
        ) from missing
    listening = listening_of(arguments)
    opens = not arguments.no_open
    with log_stages() as lines:
        offers = offered(arguments.scene, arguments.run)
        if len(offers) == 1:
            offers = [ready(offers[0], lines.info)]
        serve(lambda access: studio_app(offers, access), listening, open_browser=opens)


def author_scene(arguments: argparse.Namespace) -> None:
    """Serve the editor; or replay, write, and say where the two writings of rotations part."""
    if arguments.gestures is None:
        _serve(arguments)
        return
    import numpy as np

    from motorcade.animation.authoring import Snapping, scene_text
    from motorcade.replays.cli.arguments import print_json
    from motorcade.replays.io.files import write_bytes
    from motorcade.replays.tasks.blending import author

    snapping = Snapping(
        float(np.radians(arguments.snap_deg)), arguments.snap_m, arguments.snap_scale
    )
    authored = author(arguments.scene, arguments.gestures, arguments.rotations, snapping)
    if arguments.output is not None:
        write_bytes(arguments.output, scene_text(authored.scene).encode())
    if arguments.json:
        print_json(authored.as_json())
        return
    print(f"{authored.gestures} gestures; each object, and how far Euler angles end from rotors")
    for name, (degrees, metres) in authored.apart.items():
        at = authored.scene.world_T_object(name).translation_m
        print(
            f"  {name}: at {at[0]:z.3f} {at[1]:z.3f} {at[2]:z.3f} m; {degrees:.3f}°, {metres:.4f} m"
        )


def add_blend(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        blend,
        "blend",
        "blend two clips of a character, as glTF or video, by any method",
        "motorcade blend knight.glb --clips Walking_A,Running_A --weight 0.4 --out b.mp4",
    )
    add_file(parser, "character", "glb, gltf, dae, …", "CHARACTER")
    parser.add_argument("--clips", required=True, metavar="A,B", help="names of two clips")
    add_number(parser, "--weight", "of B (0.5)", 0.5, metavar="W")
    parser.add_argument(
        "--method",
        default="motor",
        metavar="M",
        help="motor, similarity, rotor, dual_quaternion or quaternion, each also with _linear; or "
        "euler (motor)",
    )
    add_file(
        parser,
        "--motion",
        "take clips from this file as well, retargeted by what joints are; may be repeated",
        action="append",
        default=[],
    )
    add_axes(parser)
    add_number(parser, "--rate-hz", "keys a second (60)", 60.0)
    add_file(parser, "--out", "write .glb or .mp4")
    add_flag(parser, "--json", "print figures as JSON")


def blend(arguments: argparse.Namespace) -> None:
    """Read, blend, write; print how far the methods lie apart."""
    from motorcade.replays.cli.arguments import print_json
    from motorcade.replays.tasks.blending import blend_character, character_with, write_blend

    names = tuple(name.strip() for name in arguments.clips.split(","))
    if len(names) != 2:
        raise ValueError(f"--clips {arguments.clips}: expected two names with a comma between")
    character = character_with(
        arguments.character, arguments.motion, up=arguments.up, front=arguments.front
    )
    blended = blend_character(
        character,
        (names[0], names[1]),
        arguments.weight,
        arguments.method,
        rate_hz=arguments.rate_hz,
    )
    if arguments.out is not None:
        write_blend(blended, arguments.out)
    if arguments.json:
        print_json(blended.as_json())
        return
    clip = blended.clip
    timing = f"in phase, offset {blended.offset:.3f}" if blended.in_phase else "by the clock"
    print(f"{clip.name}: {clip.duration_s:.3f} s, {len(clip.time_s)} keys, {timing}")
    print(f"feet planted on a way of {blended.way.speed_m_s:.2f} m/s")
    for notice in blended.notices:
        print(f"notice: {notice}")
    print("largest distance of a joint that carries vertices under two methods, mm")
    for (a, b), apart_m in blended.differences_m.items():
        print(f"  {a + ' - ' + b:<48}{1e3 * apart_m:>10.3f}")
