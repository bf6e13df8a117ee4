"""A hook of mkdocs: the page of commands, written from the command line's own help as it stands."""

from __future__ import annotations

import argparse
from functools import partial

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

PAGE = "reference/commands.md"
WIDTH = 88


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the page to those of the site."""
    files.append(File.generated(config, PAGE, content=commands_page()))
    return files


def commands_page() -> str:
    """Every command with its help, its example among it, in the order of `motorcade --help`."""
    parts = [
        "# Commands",
        "Every command exits 0 on success, 2 on bad usage, and 1 on a failed job, with one line "
        "that says what, where and what to do. `--json` writes results whose keys carry units.",
    ]
    for name, parser in commands().items():
        parts += [f"## {name}", f"```text\n{parser.format_help().rstrip()}\n```"]
    return "\n\n".join(parts) + "\n"


def commands() -> dict[str, argparse.ArgumentParser]:
    """The parser of every command, by name; its help as wide as a page takes."""
    from motorcade.replays.cli.main import _parser

    (group,) = (a for a in _parser()._actions if isinstance(a, argparse._SubParsersAction))
    for parser in group.choices.values():
        parser.formatter_class = partial(parser.formatter_class, width=WIDTH)
    return dict(group.choices)
