"""Commands on what is there: `motorcade inspect`, `view`, `export`, `author`, `blend`."""

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
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_server,
    listening_of,
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
