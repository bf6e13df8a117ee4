"""The viewer inside a report: the page of `motorcade view`, compressed until it is asked for.

Films lie in the report too where all is small, else beside it; so does a viewer that would make the
report too large, as characters with large pictures do.
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from motorcade.ga.files import off_record, read_bounded
from motorcade.render.scene import ImageArray
from motorcade.render.video import read_stamps_s
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.pipeline.look.document import LookedAt, look_of
from motorcade.replays.pipeline.look.packing import packed
from motorcade.replays.web.film import film_size, write_film
from motorcade.replays.web.page import view_page

FILMS_INSIDE_BYTES = 8 * 2**20
"""All films of a report that are larger together lie beside it."""
VIEWER_INSIDE_BYTES = 3 * 2**20
"""As base64; a larger viewer lies beside the report, uncompressed."""
LONGEST_PX = 960
"""Of the footage's copy: the report is not wider on most screens."""
OVERLAY, FOOTAGE, VIEWER = "overlay.mp4", "footage.mp4", "viewer.html"


@dataclass(frozen=True)
class PageFilm:
    """A film of the page: `data` in base64 where it is inside, else the name of the file beside."""

    id: str
    data: str = ""
    beside: str = ""


@dataclass(frozen=True)
class Viewer:
    """What a report plays and unpacks, and the files that belong beside it.

    Fields:
        films: those of the page, by name: overlay, footage.
        page: the viewer's page, gzip in base64; "" where it lies beside or cannot be made.
        footage, file: the film and the viewer that lie beside, or None.
    """

    films: dict[str, PageFilm]
    page: str = ""
    footage: Path | None = None
    file: Path | None = None


@dataclass
class Kept:
    """Pictures of the footage that are kept by their numbers while it is copied: every n-th."""

    every: int
    pictures: dict[int, ImageArray] = field(default_factory=dict)


def embedded(run: LookedAt, kept: Kept) -> Viewer:
    """The viewer of a run, and the films that it and the report play.

    A recording without a camera has none: there is the film alone.
    """
    overlay = run.findings.overlay
    paths = {} if overlay is None else {"overlay": overlay.path}
    if run.recording.camera is None:
        return Viewer(_films(paths))
    clips: list[dict[str, Any]] = []
    if run.has_pictures:
        paths["footage"] = new_file(FOOTAGE)
        clips.append(_copy_footage(run, paths["footage"], kept))
    if overlay is not None and overlay.frames == len(run.recording.frames.time_ns):
        with off_record():  # it lies in the cache
            stamps_s = read_stamps_s(overlay.path)
        clips.append({"name": "overlay", "src": "#film-overlay", "time_s": packed(stamps_s, "f64")})
    look = look_of(run, clips)
    with off_record():  # modules of ours
        text = view_page([look], [])
    data = base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode("ascii")
    if len(data) <= VIEWER_INSIDE_BYTES:
        films = _films(paths)
        beside = any(one.beside for one in films.values())
        return Viewer(films, data, paths.get("footage") if beside else None)
    films = {name: PageFilm(f"film-{name}", beside=f"{name}.mp4") for name in paths}
    for film in films.values():
        text = text.replace(f'"#{film.id}"', f'"{film.beside}"')
    file = new_file(VIEWER)
    file.write_text(text, encoding="utf-8")
    return Viewer(films, "", paths.get("footage"), file)


def _copy_footage(run: LookedAt, path: Path, kept: Kept) -> dict[str, Any]:
    """Write the footage's copy; returns what a look says of it."""
    camera, frames = run.recording.camera, run.recording.frames
    assert camera is not None  # asked for before
    size = film_size(camera.width, camera.height, LONGEST_PX)

    def pictures() -> Iterator[ImageArray]:
        for number, frame in enumerate(frames):
            picture = frame.image()
            if number % kept.every == 0:
                kept.pictures[number] = picture
            yield picture

    write_film(path, pictures(), frames.time_ns, size)
    return {"name": "footage", "src": "#film-footage", "size": list(size)}


@off_record()  # they lie in the cache, or were written here
def _films(paths: dict[str, Path]) -> dict[str, PageFilm]:
    """Films inside the page where they are small together, else beside it."""
    small = sum(path.stat().st_size for path in paths.values()) <= FILMS_INSIDE_BYTES
    films = {}
    for name, path in paths.items():
        data = read_bounded(path, FILMS_INSIDE_BYTES) if small else b""
        text = base64.b64encode(data).decode("ascii")
        films[name] = PageFilm(f"film-{name}", text, "" if small else f"{name}.mp4")
    return films
