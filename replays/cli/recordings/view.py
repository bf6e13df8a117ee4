"""`motorcade view`: a run as a page to look into."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        view,
        name="view",
        summary="look into a run in the browser: film, world and plots over one timeline",
        example="motorcade view out/run",
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that `motorcade run` wrote")
    parser.add_argument(
        "other", type=Path, nargs="?", metavar="OTHER", help="another run, set beside it"
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="the page, ending in .html (default RUN/view.html)"
    )
    parser.add_argument(
        "--no-open", action="store_true", help="write the page, and open no browser"
    )


def view(arguments: argparse.Namespace) -> None:
    """Write the page, and open it."""
    import webbrowser

    from motorcade.replays.engine.progress import log_stages
    from motorcade.replays.studio.view import write_view

    runs = [arguments.run] if arguments.other is None else [arguments.run, arguments.other]
    out = arguments.run / "view.html" if arguments.out is None else arguments.out
    with log_stages():
        written = write_view(runs, out)
    for path in written:
        print(f"wrote {path}")
    if not arguments.no_open:
        webbrowser.open(out.resolve().as_uri())
