"""Dispatch to the commands; turns expected errors into one line and an exit status."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import TextIO

from motorcade import __version__
from motorcade.replays.cli.arguments import one_line
from motorcade.replays.cli.characters import author, blend
from motorcade.replays.cli.parser import Parser
from motorcade.replays.cli.recordings import demo, export, graph, inspect, run, sweep, view
from motorcade.replays.cli.sensors import (
    allan,
    calibrate,
    detect,
    fuse,
    orient,
    simulate_imu,
    sync,
)
from motorcade.replays.cli.tools import completion, doctor, draw, generate
from motorcade.replays.cli.tools import print as print_
from motorcade.replays.cli.trajectories import compare, consistency, evaluate, smooth, trajectory
from motorcade.replays.engine.progress import show_progress

COMMANDS = (
    demo,
    run,
    sweep,
    inspect,
    detect,
    print_,
    calibrate,
    smooth,
    trajectory,
    evaluate,
    simulate_imu,
    allan,
    orient,
    sync,
    fuse,
    graph,
    generate,
    draw,
    blend,
    author,
    view,
    export,
    compare,
    consistency,
    doctor,
    completion,
)

NAMES = {command.__name__.rpartition(".")[2].replace("_", "-"): command for command in COMMANDS}
"""The commands by their names, which are their modules' names."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    given = sys.argv[1:] if argv is None else list(argv)
    named = NAMES.get(given[0]) if given else None
    parser = command_parser(COMMANDS if named is None else (named,))
    if named is None and given and not given[0].startswith("-"):
        # Not at the top: commands such as doctor run where kernels do not load.
        from motorcade.ga.names import did_you_mean

        parser.error(f"no command {given[0]!r}; {did_you_mean(given[0], NAMES)}")
    try:
        _run(parser, given)
    except KeyboardInterrupt as stop:
        told = str(stop) or "stopped; what was finished is kept"
        print(f"motorcade: {told}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has gone; what is left to say goes nowhere.
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())
        return 0
    except Exception as error:  # whatever fails, a user is told in one line
        logging.getLogger("motorcade").debug("traceback", exc_info=True)
        print(f"motorcade: {_told(error)}", file=sys.stderr)
        return 1
    return 0


def _run(parser: argparse.ArgumentParser, given: Sequence[str]) -> None:
    """Run what was given; what is still to be printed goes out while its errors can be told."""
    try:
        arguments = parser.parse_args(given)
        _set_up_logging(arguments.verbose, quiet=arguments.quiet)
        arguments.command(arguments)
    finally:
        print(end="", flush=True)


def _told(error: Exception) -> str:
    """One line, but for errors of scripts, which show the line of the script."""
    script = sys.modules.get("motorcade.ga.script")  # not imported here: the kernels may not load
    if script is not None and isinstance(error, script.ScriptError):
        return str(error)
    return one_line(error)


def command_parser(modules: Iterable[ModuleType] = COMMANDS) -> Parser:
    """The parser of these commands; one that is named needs no other's arguments."""
    parser = Parser(
        prog="motorcade",
        description="From recorded camera and IMU sequences to smooth poses, augmented video "
        "and an error report.",
    )
    parser.add_argument("--version", action="version", version=f"motorcade {__version__}")
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument(
        "-v", "--verbose", action="count", default=0, help="say more; twice for tracebacks"
    )
    shared.add_argument(
        "-q", "--quiet", action="store_true", help="no progress: results, warnings and errors only"
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in modules:
        command.add_to(commands, shared)
    parser.set_defaults(every_command=command_parser)  # for commands that tell of all of them
    return parser


def _set_up_logging(verbose: int, *, quiet: bool) -> None:
    show_progress(not quiet)
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    handler = _Lines()
    handler.addFilter(_Once())
    logging.basicConfig(level=logging.WARNING, format="%(message)s", handlers=[handler])
    logging.getLogger("motorcade").setLevel(level)


class _Once(logging.Filter):
    """A warning that was told is not told again."""

    def __init__(self) -> None:
        super().__init__()
        self._told: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is news."""
        message = record.getMessage()
        if record.levelno != logging.WARNING or message not in self._told:
            self._told.add(message)
            return True
        return False


class _Lines(logging.StreamHandler[TextIO]):
    """Lines on standard error, above the bar of progress where there is one."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write the record."""
        bars = sys.modules.get("tqdm")  # imported by the first bar that is shown
        if bars is None or not sys.stderr.isatty():
            super().emit(record)
            return
        bars.tqdm.write(self.format(record), file=sys.stderr)
