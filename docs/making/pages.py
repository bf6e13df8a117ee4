"""A hook of mkdocs: pages that are made of something else than Markdown in this folder.

The page of commands is the command line's own help as it stands, that of stages is read off their
functions; changelog, contributing and
security are files at the top of the repository, where their readers look for them first.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

TOP = Path(__file__).resolve().parents[2]
FROM_THE_TOP = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
MADE = {
    f"{up}../{name}": f"{up}{page}"
    for name, page in [
        *((name, name.lower()) for name in FROM_THE_TOP),
        ("replays/stages", "reference/stages.md"),
    ]
    for up in ("", "../")
}
"""Links to what is there when a page is read as a file, and to the page made of it."""
WIDTH = 88


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pages to those of the site."""
    made = {name.lower(): page_from_the_top(name) for name in FROM_THE_TOP}
    made["reference/commands.md"] = commands_page()
    made["reference/stages.md"] = stages_page()
    for name, content in made.items():
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Lead links out of this folder to the pages that are made of what they name."""
    for written, made in MADE.items():
        for end in ")#":
            markdown = markdown.replace(f"]({written}{end}", f"]({made}{end}")
    return markdown


def page_from_the_top(name: str) -> str:
    """A file at the top, with its links as they are from this folder."""
    text = (TOP / name).read_text(encoding="utf-8").replace("](docs/", "](")
    for other in FROM_THE_TOP:
        text = text.replace(f"]({other})", f"]({other.lower()})")
    return text


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
    from motorcade.replays.cli.main import command_parser

    (group,) = (a for a in command_parser()._actions if isinstance(a, argparse._SubParsersAction))
    for parser in group.choices.values():
        parser.formatter_class = partial(parser.formatter_class, width=WIDTH)
    return dict(group.choices)


def stages_page() -> str:
    """Every stage of the pipeline: what it does, takes and gives, and its knobs."""
    from motorcade.replays.engine.graph import described_knobs
    from motorcade.replays.pipeline.job import pipeline_graph

    parts = [
        "# Stages",
        "The stages of `motorcade run`, in an order in which they can run, as their functions in "
        "`replays/stages` tell. A knob is set by `--set stage.knob=value`, or by `settings` in a "
        "manifest; units end its name.",
    ]
    for stage in (pipeline_graph().stages[name] for name in pipeline_graph().order):
        takes = ", ".join(
            f"`{name}`{' (optional)' if name in stage.optional else ''}" for name in stage.inputs
        )
        parts += [
            f"## {stage.name}",
            stage.doc,
            f"Takes {takes}; gives `{stage.output.__name__}`.",
        ]
        if stage.knobs:
            rows = [
                f"| `{knob.name}` | {knob.values} | {f'`{knob.default}`' if knob.default else ''} |"
                for knob in described_knobs(stage)
            ]
            parts.append("\n".join(["| knob | values | default |", "|---|---|---|", *rows]))
    return "\n\n".join(parts) + "\n"
