"""`motorcade completion`: what makes a shell complete commands, options, choices and file names."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command

SHELLS = ("bash", "zsh", "fish", "tcsh")


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        completion,
        name="completion",
        summary="print the script by which a shell completes commands and options, for its folder "
        "of completions or its start-up file",
        example="motorcade completion bash",
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def completion(arguments: argparse.Namespace) -> None:
    """Print the script."""
    import shtab

    print(shtab.complete(_completing_files(arguments.every_command()), arguments.shell))


def _completing_files(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """The parser, in which shtab finds that names of files are completed as such."""
    import shtab

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _completing_files(command)
        elif action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]  # shtab's way to say it
    return parser
