"""The command that tracks while it is filmed: `motorcade live`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import (
    Commands,
    add_file,
    add_flag,
    add_number,
    add_server,
    chosen,
    listening_of,
    print_json,
    shown,
)

if TYPE_CHECKING:
    from motorcade.replays.live.opening import LivePlan

DESCRIPTION = """\
Track a camera while it films, and put a figure where one taps, in a page of the browser.

Without SOURCE the camera is the browser's own: this machine's, or with --lan a phone's, by https.
SOURCE is a device (/dev/video0), an address (rtsp://...), "-" for a video that comes through the
standard input, or a recording, which is played at its own pace.

Without --camera the camera is found from the board within seconds: move round it, and tilt it.
Frames a second, latency and registration are measured while it runs, and shown.
--record keeps the session as a recording that `motorcade run` replays."""


def add_live(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        live,
        "live",
        "track a camera while it films, with a figure on its images, in the browser",
        "motorcade live --board checkerboard_9x6_25mm --lan\n"
        "  motorcade live /dev/video0 --board board.yaml --no-page",
    )
    parser.description = DESCRIPTION
    parser.add_argument("source", nargs="?", metavar="SOURCE", help="else the browser's camera")
    target = parser.add_mutually_exclusive_group()
    target.add_argument("--board", metavar="NAME", help="in view: checkerboard_9x6_25mm, or a file")
    target.add_argument("--markers", metavar="FAMILY", help="the marker that is seen first")
    target.add_argument("--slam", action="store_true", help="neither: map the place (--camera)")
    add_number(parser, "--size-m", "side of --markers, metres", metavar="S")
    add_file(parser, "--camera", "as `motorcade calibrate` writes it")
    add_file(parser, "--manifest", "of a recording as SOURCE")
    parser.add_argument("--character", default="mannequin", metavar="FILE", help="the figure")
    add_number(parser, "--height-m", "of the figure", metavar="H")
    add_file(parser, "--record", "keep the session there", "DIR")
    add_flag(parser, "--no-page", "track SOURCE, and print figures")
    add_flag(parser, "--json", "print them as JSON (--no-page)")
    add_server(parser)


def live(arguments: argparse.Namespace) -> None:
    """Serve the page until it is stopped; or track a source to its end."""
    plan = _plan(arguments)
    if not arguments.no_page:
        _serve(plan, arguments)
        return
    from motorcade.replays.live.opening import track_without_page

    session, frames = plan.open()
    if frames is None:
        raise ValueError("--no-page: expected a SOURCE, since only a page has a browser's camera")
    try:
        figures = track_without_page(session, frames)
    finally:
        session.close()
    if arguments.json:
        print_json(figures)
        return
    for key, value in figures.items():
        text = " ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else value
        print(f"{key:>22}  {shown(text)}")


def _plan(arguments: argparse.Namespace) -> LivePlan:
    """What the options ask for."""
    from motorcade.replays.io.readers.manifest.section import read_board, read_camera
    from motorcade.replays.live.opening import LivePlan
    from motorcade.replays.live.tracker import FirstMarker, Target

    target: Target | None = None
    if arguments.slam:
        target = "slam"
    elif arguments.board is not None:
        target = read_board(arguments.board)
    elif arguments.markers is not None:
        if arguments.size_m is None:
            raise ValueError("--markers: expected --size-m S with it, the side of a marker, metres")
        target = FirstMarker(arguments.markers, arguments.size_m)
    camera = None if arguments.camera is None else read_camera(arguments.camera)
    stated = chosen(arguments, "source", "manifest", "character", "height_m", "record")
    return LivePlan(target=target, camera=camera, **stated)


def _serve(plan: LivePlan, arguments: argparse.Namespace) -> None:
    try:
        from motorcade.replays.live.app import serve_live
    except ModuleNotFoundError as missing:
        raise RuntimeError(
            f"a page needs the Python package {missing.name}, which is not installed; "
            'pip install "motorcade[studio]" brings it, or track without one by --no-page'
        ) from missing
    serve_live(plan, listening_of(arguments), open_browser=not arguments.no_open)
