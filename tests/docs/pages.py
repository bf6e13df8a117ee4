"""Runs the code of a page as a reader would: block after block, in one folder.

    python -m tests.docs.pages docs/tutorials/smooth_my_file.md

prints what each block answers. A block of `sh` or `python` is run, in order, Python in one
namespace a page; `text` directly below it is what it must answer on standard output. A block of any
language that has a title is a file of that name. Numbers may differ in their last digit as shown;
`…` stands for anything in a line, and on a line of its own for any number of lines.
"""

from __future__ import annotations

import contextlib
import fnmatch
import io
import math
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FENCE = re.compile(
    r'^```(?P<language>[a-z]+)?(?: title="(?P<title>[^"]+)")?\n(?P<text>.*?)^```$', re.M | re.S
)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Block:
    """One block of a page: what it is written in, its text, the line on which it begins.

    Fields:
        title: the file that it is, where it is one.
        answer: what standard output must hold, where the page shows it.
    """

    line: int
    language: str
    text: str
    title: str | None
    answer: str | None

    @property
    def runs(self) -> bool:
        """Whether it is run; all others are read."""
        return self.title is None and self.language in ("sh", "python")


def blocks(page: Path) -> list[Block]:
    """The blocks of a page, in order; those that are another's answer stand with it."""
    text = page.read_text(encoding="utf-8")
    found = list(FENCE.finditer(text))
    made: list[Block] = []
    for i, match in enumerate(found):
        below = found[i + 1] if i + 1 < len(found) else None
        near = below is not None and not text[match.end() : below.start()].strip()
        answer = below["text"] if near and below and below["language"] == "text" else None
        line = text.count("\n", 0, match.start()) + 1
        block = Block(line, match["language"] or "text", match["text"], match["title"], answer)
        made.append(block)
    return made


def run(page: Path) -> Iterator[tuple[Block, str]]:
    """Run a page in the working folder: every block that ran, and what it answered."""
    names: dict[str, Any] = {"__name__": "__page__"}
    for block in blocks(page):
        if block.title is not None:
            Path(block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            code = compile("\n" * block.line + block.text, str(page), "exec")
            with contextlib.redirect_stdout(io.StringIO()) as said:
                exec(code, names)
            yield block, said.getvalue()
        elif block.language == "sh":
            yield block, "".join(answer(line) for line in commands(block.text))


def commands(text: str) -> list[str]:
    """Command lines, comments and continuations taken out."""
    joined = text.replace("\\\n", " ")
    bare = [re.sub(r"(^|\s)#.*", "", line).strip() for line in joined.splitlines()]
    return [line for line in bare if line]


def answer(line: str) -> str:
    """Standard output of one command line; those of ours run in this process.

    Raises:
        RuntimeError: it exits other than 0.
    """
    ours, bar, rest = line.partition("|")
    said = io.StringIO()
    if ours.startswith("motorcade ") and not re.search("[>*]", ours):
        with contextlib.redirect_stdout(said):
            status = status_of(shlex.split(ours)[1:])
        if status != 0:
            raise RuntimeError(f"{ours}: exit status {status}")
        if not bar:
            return said.getvalue()
        line = rest
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-ec", line],
        env={**os.environ, "PATH": path},
        input=said.getvalue(),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{line}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def status_of(words: list[str]) -> object:
    """Exit status of one of our commands; `--list` and `--help` leave by an exit of their own."""
    from motorcade.replays.cli import main

    try:
        return main(words)
    except SystemExit as left:
        return left.code


def agrees(shown: str, said: str) -> bool:
    """Whether an answer is what the page shows, line by line."""
    expected = [line.rstrip() for line in shown.splitlines()]
    came = [line.rstrip() for line in said.splitlines()]
    return _lines_agree(expected, came)


def _lines_agree(expected: list[str], came: list[str]) -> bool:
    if not expected:
        return not came
    if expected[0].strip() == "…":
        return any(_lines_agree(expected[1:], came[i:]) for i in range(len(came) + 1))
    return bool(came) and line_agrees(expected[0], came[0]) and _lines_agree(expected[1:], came[1:])


def line_agrees(expected: str, came: str) -> bool:
    """Words alike, numbers to the digits shown, `…` for anything."""
    if fnmatch.fnmatchcase(_words(came), re.sub(r"\s*…\s*", "*", _escaped(_words(expected)))):
        shown, found = NUMBER.findall(expected), NUMBER.findall(came)
        return "…" in expected or all(
            _number_agrees(one, other) for one, other in zip(shown, found, strict=True)
        )
    return False


def _escaped(line: str) -> str:
    return re.sub(r"([\[?*])", r"[\1]", line)


def _words(line: str) -> str:
    """The line with one space between words and every number a 0, whatever it is."""
    return re.sub(r"([\[(]) ", r"\1", " ".join(NUMBER.sub("0", line).split()))


def _number_agrees(shown: str, found: str) -> bool:
    """Whole numbers alike, others to the last digit shown."""
    if not re.search("[.e]", shown + found):
        return int(shown) == int(found)
    digits = shown.partition("e")[0].partition(".")[2]
    last = 10.0 ** (int(shown.partition("e")[2] or 0) - len(digits))
    return math.isclose(float(shown), float(found), abs_tol=1.01 * last, rel_tol=1e-9)


def main() -> None:
    """Print what the blocks of a page answer."""
    page = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        sys.path.insert(0, folder)
        for block, said in run(page):
            fits = block.answer is None or agrees(block.answer, said)
            print(f"--- line {block.line} {'' if fits else 'DIFFERS'}\n{said}", end="")


if __name__ == "__main__":
    main()
