"""The embedded recording of `motorcade demo`: rendered once, then read like any other."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from pathlib import Path

from motorcade.ga.files import read_bounded
from motorcade.ga.progress import track
from motorcade.ga.unfinished import unfinished
from motorcade.replays.demo import write_recording
from motorcade.replays.demo.recording import STANDING
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.stages.view.placed import CAST_SAYS

PLAY = """\
# A visitor comes from behind the board, walks round its end, turns to the camera and waves.
[[characters]]
name = "visitor"
path = [[0.32, 0.04], [0.30, -0.09], [0.20, -0.12], [0.05, -0.03]]
look_at = "camera"
gaits = ["walk", "jog"]
speed_m_s = 1.9
acts = ["wave"]
"""
"""The demo's cast: where it goes is clear of the things on the table."""
MARKER = ".rendered"
MAX_MARKER_BYTES = 1 << 12


def ensure_demo_recording(folder: Path, seed: int) -> Path:
    """Render the synthetic room into `folder` unless this code has done so with this seed.

    The folder appears complete or not at all. Raises `render.RenderUnavailable` without OpenGL,
    and FileExistsError where `folder` holds something else.
    """
    made_from = f"{code_digest(ensure_demo_recording)} seed {seed}\n"
    if _is_made_from(made_from, folder):
        return folder
    if folder.exists() and not (folder / MARKER).is_file():
        raise FileExistsError(
            errno.EEXIST,
            "is not a recording that this demo made; choose another --out",
            str(folder),
        )
    with unfinished(folder.parent) as place:
        recording = place / "recording"
        write_recording(recording, seed=seed, placed="placed.cast=cast.toml", progress=track)
        (recording / "cast.toml").write_text(PLAY, encoding="utf-8")
        (recording / MARKER).write_text(made_from, encoding="utf-8")
        if not _is_made_from(made_from, folder):  # else another run was faster
            if folder.exists():
                folder.rename(place / "earlier")
            recording.rename(folder)
    return folder


def settings_beside(asked: Sequence[str]) -> tuple[str, ...]:
    """Settings of a run of the demo: who asks for another character gets it in place of the play.

    >>> from motorcade.replays.demo.embedded import settings_beside
    >>> settings_beside(["placed.character=knight.glb"])
    ('placed.cast=none', 'placed.position_m=0,0', 'placed.character=knight.glb')
    >>> settings_beside(["fused.gate=0.99"])
    ('fused.gate=0.99',)
    """
    knobs = {one.partition("=")[0].strip() for one in asked}
    instead = knobs & {f"placed.{name}" for name in CAST_SAYS} and "placed.cast" not in knobs
    return (*(("placed.cast=none", STANDING) if instead else ()), *asked)


def _is_made_from(origin: str, folder: Path) -> bool:
    marker = folder / MARKER
    return marker.is_file() and read_bounded(marker, MAX_MARKER_BYTES) == origin.encode()
