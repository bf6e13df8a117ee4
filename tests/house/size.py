"""Counts the lines of the product: Python and C++ of the rooms, without what is generated.

    python -m tests.house.size                 the working tree
    python -m tests.house.size v0.1 HEAD       revisions of git, side by side

Examples in docstrings are not counted: they are documentation, and tests run them.
"""

from __future__ import annotations

import ast
import doctest
import subprocess
import sys
from pathlib import Path, PurePosixPath

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
PYTHON, NATIVE = {".py", ".pyi"}, {".c", ".cpp", ".h"}


def git(*arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=REPOSITORY, check=True, capture_output=True, text=True
    ).stdout


def product_files(names: list[str]) -> list[str]:
    """Those of `names` that are code of a room and written by hand."""
    kept = [PurePosixPath(name) for name in names]
    return [
        str(path)
        for path in kept
        if path.parts[0] in ROOMS
        and path.suffix in PYTHON | NATIVE
        and "generated" not in path.parts
    ]


def example_lines(text: str) -> int:
    """Lines of docstrings' examples, what they print included."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = [
        ast.get_docstring(node) or ""
        for node in ast.walk(ast.parse(text))
        if isinstance(node, documented)
    ]
    examples = [one for text in docstrings for one in doctest.DocTestParser().get_examples(text)]
    return sum(one.source.count("\n") + one.want.count("\n") for one in examples)


def counted(texts: dict[str, str]) -> dict[str, int]:
    """Lines by room, and of C++ and Python over all."""
    lines = dict.fromkeys((*ROOMS, "C and C++", "Python", "all"), 0)
    for name, text in texts.items():
        path = PurePosixPath(name)
        size = text.count("\n") - (example_lines(text) if path.suffix == ".py" else 0)
        for key in (path.parts[0], "Python" if path.suffix in PYTHON else "C and C++", "all"):
            lines[key] += size
    return lines


def at(revision: str | None) -> dict[str, int]:
    """Lines of a revision, or of the working tree."""
    if revision is None:
        names = product_files(git("ls-files", "-co", "--exclude-standard").splitlines())
        present = [name for name in names if (REPOSITORY / name).exists()]
        return counted({name: (REPOSITORY / name).read_text() for name in present})
    names = product_files(git("ls-tree", "-r", "--name-only", revision).splitlines())
    return counted({name: git("show", f"{revision}:{name}") for name in names})


def main() -> None:
    revisions: list[str | None] = [*sys.argv[1:]] or [None]
    columns = [at(revision) for revision in revisions]
    print(f"{'lines':<12}" + "".join(f"{one or 'here':>14}" for one in revisions))
    for key in columns[0]:
        print(f"{key:<12}" + "".join(f"{column[key]:>14,}" for column in columns))


if __name__ == "__main__":
    main()
