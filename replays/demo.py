"""The embedded recording of `motorcade demo`: rendered once, then read like any other."""

from __future__ import annotations

import errno
from pathlib import Path

from motorcade.ga.files import read_bounded
from motorcade.ga.unfinished import unfinished
from motorcade.replays.engine.progress import track
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.synthetic_room import write_recording

MARKER = ".rendered"
MAX_MARKER_BYTES = 1 << 12


def ensure_demo_recording(folder: Path, seed: int) -> Path:
    """Render the synthetic room into `folder` unless this code has done so with this seed.

    The folder appears complete or not at all. Raises `render.RenderUnavailable` without OpenGL,
    and FileExistsError where `folder` holds something else.
    """
    made_from = f"{code_digest(write_recording)} seed {seed}\n"
    if _is_made_from(made_from, folder):
        return folder
    if folder.exists() and not (folder / MARKER).is_file():
        raise FileExistsError(
            errno.EEXIST,
            "is not a recording that this demo made; choose another --out",
            str(folder),
        )
    with unfinished(folder.parent) as place:
        write_recording(place / "recording", seed=seed, progress=track)
        (place / "recording" / MARKER).write_text(made_from, encoding="utf-8")
        if not _is_made_from(made_from, folder):  # else another run was faster
            if folder.exists():
                folder.rename(place / "earlier")
            (place / "recording").rename(folder)
    return folder


def _is_made_from(origin: str, folder: Path) -> bool:
    marker = folder / MARKER
    return marker.is_file() and read_bounded(marker, MAX_MARKER_BYTES) == origin.encode()
