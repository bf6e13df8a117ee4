"""Dispatch to the commands; turns expected errors into one line and an exit status.

The parser proposes the nearest option, command or value for one that it does not know.
"""

from __future__ import annotations

import argparse
import logging
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn, TextIO

from motorcade import __version__
from motorcade.replays.cli import (
    cameras,
    evaluation,
    fusion,
    imu,
    inspection,
    runs,
    tools,
    trajectories,
)
from motorcade.replays.cli.arguments import Commands, one_line

COMMANDS = (
    runs.add_demo,
    runs.add_run,
    runs.add_sweep,
    inspection.add_inspect,
    cameras.add_detect,
    cameras.add_print,
    cameras.add_calibrate,
    trajectories.add_smooth,
    trajectories.add_trajectory,
    evaluation.add_evaluate,
    imu.add_simulate_imu,
    imu.add_allan,
    imu.add_orient,
    fusion.add_sync,
    fusion.add_fuse,
    runs.add_graph,
    tools.add_generate,
    tools.add_draw,
    inspection.add_blend,
    inspection.add_author,
    runs.add_live,
    inspection.add_view,
    inspection.add_export,
    evaluation.add_compare,
    evaluation.add_consistency,
    tools.add_doctor,
    tools.add_completion,
)

NAMES = {command.__name__.removeprefix("add_").replace("_", "-"): command for command in COMMANDS}
"""The commands by their names."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    words = _command_first(sys.argv[1:] if argv is None else list(argv))
    named = NAMES.get(words[0]) if words else None
    parser = command_parser(COMMANDS if named is None else (named,))
    if named is None and words and not words[0].startswith("-"):
        # Not at the top: commands such as doctor run where kernels do not load.
        from motorcade.ga.names import did_you_mean

        parser.error(f"no command {words[0]!r}; {did_you_mean(words[0], NAMES)}")
    try:
        _run(parser, words)
    except KeyboardInterrupt as stop:
        reason = str(stop) or "stopped; what was finished is kept"
        print(f"motorcade: {reason}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has gone; what is left to say goes nowhere.
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())
        return 0
    except Exception as error:  # whatever fails, a user is told in one line
        logging.getLogger("motorcade").debug("traceback", exc_info=True)
        print(f"motorcade: {_with_addresses(_error_text(error), words)}", file=sys.stderr)
        return 1
    return 0


def _command_first(words: list[str]) -> list[str]:
    """The words with options that all commands share behind the command, where they may stand.

    >>> _command_first(["-q", "view", "out/run"])
    ['view', '-q', 'out/run']
    """
    before = takewhile(re.compile(r"-[vq]+|--verbose|--quiet").fullmatch, words)
    at = len(list(before))
    return [*words[at : at + 1], *words[:at], *words[at + 1 :]]


def _with_addresses(text: str, words: Iterable[str]) -> str:
    """A message in which addresses stand as they were typed; as paths they lose a slash."""
    for word in words:
        scheme, address, _ = word.partition("://")
        if address and scheme.isalnum():
            text = re.sub(rf"\b{scheme}:/(?!/)", f"{scheme}://", text)
    return text


def _run(parser: argparse.ArgumentParser, values: Sequence[str]) -> None:
    """Run what was given; what is still to be printed goes out while its errors can be told."""
    try:
        arguments = parser.parse_args(values)
        _set_up_logging(arguments.verbose, quiet=arguments.quiet)
        arguments.command(arguments)
    finally:
        print(end="", flush=True)


def _error_text(error: Exception) -> str:
    """One line, but for errors of scripts, which show the line of the script."""
    script = sys.modules.get("motorcade.ga.script")  # not imported here: the kernels may not load
    if script is not None and isinstance(error, script.ScriptError):
        return str(error)
    return one_line(error)


def command_parser(
    added: Iterable[Callable[[Commands], None]] = COMMANDS,
) -> Parser:
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
    commands = Commands(parser.add_subparsers(metavar="COMMAND", required=True), shared)
    for add_command in added:
        add_command(commands)
    parser.set_defaults(every_command=command_parser)  # for commands that tell of all of them
    return parser


def _set_up_logging(verbose: int, *, quiet: bool) -> None:
    logging.getLogger("motorcade.progress").disabled = quiet  # see `ga.progress`
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


class Parser(argparse.ArgumentParser):
    """argparse's parser; those of its commands are of this kind too.

    Fields:
        _given: the words that are being parsed.

    >>> parser = Parser(prog="motorcade")
    >>> _ = parser.add_argument("--out")
    >>> parser.parse_args(["--outt", "x"])
    Traceback (most recent call last):
    SystemExit: 2
    """

    _given: tuple[str, ...] = ()

    def parse_known_args(  # type: ignore[override]  # a command's own parser is asked by this name
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse; what is not known is an error of the command whose options it is not among."""
        self._given = tuple(sys.argv[1:] if args is None else args)
        namespace_read, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._proposed(unknown)}")
        return namespace_read, unknown

    def error(self, message: str) -> NoReturn:
        """Leave with usage and message; of what is missing, also the word that may be meant for it.

        An option with a slip in its name counts as missing, which argparse tells of first.
        """
        if message.startswith("the following arguments are required"):
            options = self._option_string_actions
            slips = [one.partition("=")[0] for one in self._given if one.startswith("--")]
            unknown = [one for one in slips if not any(name.startswith(one) for name in options)]
            message += "".join(f"; no option {one}{self._proposed([one])}" for one in unknown[:1])
        super().error(message)

    def _proposed(self, unknown: Iterable[str]) -> str:
        options = [name for name in self._option_string_actions if name.startswith("--")]
        for word in unknown:
            if word.startswith("-"):
                return f"; {_nearest(word.partition('=')[0], options)}"
        return ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is none of the choices, with the nearest of them."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            if not isinstance(value, str) or action.choices is None:
                raise
            text = f"expected one of {', '.join(map(str, action.choices))}, got {value!r}"
            raise argparse.ArgumentError(
                action, f"{text}; {_nearest(value, [str(one) for one in action.choices])}"
            ) from error


def _nearest(name: str, known: Collection[str]) -> str:
    # Not at the top: commands such as doctor run where kernels do not load.
    from motorcade.ga.names import did_you_mean

    return did_you_mean(name, known)
