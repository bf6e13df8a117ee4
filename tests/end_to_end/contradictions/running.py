"""Runs a drawn recording as a user would, and does what the closing line says."""

from __future__ import annotations

import contextlib
import io
import logging
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from motorcade.replays.cli.main import main
from motorcade.replays.io.readers.manifest.reading import FRAMES_KEYS, STEREO_KEYS
from motorcade.replays.io.readers.manifest.section import BOARD_KEYS, CAMERA_KEYS
from motorcade.replays.io.readers.manifest.sensors import IMU_KEYS
from tests.end_to_end.contradictions.drawing import Drawn

_TABLES = {
    "board": {"type", *(key for keys in BOARD_KEYS.values() for key in keys)},
    "camera": set(CAMERA_KEYS),
    "frames": set(FRAMES_KEYS),
    "stereo": set(STEREO_KEYS),
    "imu": set(IMU_KEYS),
}
_SAID = re.compile(r'(\w+) = ("[^"]*"|\[[^\]]*\]|[\w.+-]*\w)')


@dataclass(frozen=True)
class Answer:
    """How a run ended: its exit code, and the line that it closed with."""

    code: int
    closing: str


def run(drawn: Drawn) -> Answer:
    """`motorcade run … --until integrity --strict`."""
    caught, errors = _Caught(), io.StringIO()
    logger = logging.getLogger("motorcade")
    logger.addHandler(caught)
    with tempfile.TemporaryDirectory() as scratch:
        manifest = Path(scratch, "manifest.toml")
        manifest.write_text(drawn.manifest)
        out = Path(scratch, "out")
        words = ["run", drawn.folder, "--manifest", manifest, "--out", out]
        asked = [*map(str, words), "--until", "integrity", "--strict"]
        try:
            with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
                code = main(asked)
        finally:
            logger.removeHandler(caught)
    lines = [line for line in errors.getvalue().splitlines() if line.startswith("motorcade: ")]
    refused = [line for line in lines if "the result is doubtful" not in line]
    closing = refused[-1] if refused else next(iter(caught.lines[::-1]), "")
    return Answer(code, closing)


class _Caught(logging.Handler):
    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


def said(closing: str) -> dict[str, str]:
    """Keys and values that a closing line says to write.

    >>> said('… not downwards; say order = "up", rows = 3; look into out')
    {'order': '"up"', 'rows': '3'}
    """
    keys: dict[str, str] = {}
    for clause in re.findall(
        r"say ((?:\w+ = (?:\"[^\"]*\"|\[[^\]]*\]|[^,;\s]+)(?:, | and )?)+)", closing
    ):
        keys.update(_SAID.findall(clause))
    return keys


def followed(drawn: Drawn, closing: str, known: Mapping[str, str]) -> Drawn:
    """The recording, its manifest as the closing line says it.

    Args:
        drawn: as it was stated.
        closing: what the run closed with.
        known: lengths that only the user can measure, where the line asks for them.

    Raises:
        ValueError: the line says no key.
    """
    keys = said(closing)
    if not keys:
        raise ValueError(f"closing: expected one that says a key, got {closing}")
    keys |= {key: value for key, value in known.items() if f"{key} " in closing}
    text = drawn.manifest
    for key, value in keys.items():
        table = next(name for name in _TABLES if key in _TABLES[name])
        if key == "family" and "[markers]" in text:
            table = "markers"
        text = _with(text, table, key, value)
    if "type" in keys:
        kept = {"type", *BOARD_KEYS[keys["type"].strip('"')]}
        for key in _TABLES["board"] - kept:
            text = re.sub(rf"^{key} = .*\n", "", text, flags=re.MULTILINE)
    return replace(drawn, manifest=text)


def _with(text: str, table: str, key: str, value: str) -> str:
    before, header, rest = text.partition(f"[{table}]\n")
    if not header:
        return f"{text}[{table}]\n{key} = {value}\n"
    own, bracket, after = re.match(r"((?:(?!\[).*\n)*)(\[|$)([\s\S]*)", rest).groups()  # type: ignore[union-attr]
    line = re.compile(rf"^{key} ?=.*\n", re.MULTILINE)
    own = line.sub("", own) + f"{key} = {value}\n"
    return before + header + own + bracket + after
