"""`motorcade view`: a run's cache read back, its films copied, and the page written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from motorcade.ga.progress import track
from motorcade.ga.unfinished import unfinished
from motorcade.render.scene import ImageArray
from motorcade.render.video import read_frames
from motorcade.replays.io.files import copy_file, write_bytes
from motorcade.replays.io.readers.frames.views import ZoomedFrames
from motorcade.replays.pipeline.look.document import LookedAt, look_of
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.pipeline.report.summary import headline
from motorcade.replays.pipeline.runs import read_run
from motorcade.replays.web.film import film_size, write_film
from motorcade.replays.web.page import InnerFilm, inner_film, view_page

INSIDE_BYTES = 24 * 2**20
"""Films of a page that are larger than this together lie beside it."""
SMALL_PX = 256
"""The longer side of the copy that is then still inside it."""


def open_look(folder: Path) -> LookedAt:
    """Read a run back for a page; stages that its cache lost are computed again.

    Raises:
        ValueError: a folder that holds no run, one whose recording has changed since, or a
            recording without a camera.
        OSError: its recording is gone.
    """
    recording, run = read_run(folder, "report")
    outputs = run.outputs
    named: dict[str, Any] = {one.name: outputs.get(one.name) for one in fields(Findings)}
    findings = Findings(**named | {"recording": recording})
    markers = outputs.get("marker_poses")
    marker_map = None if markers is None else markers.marker_map
    return LookedAt(findings, marker_map, headline(findings))


def write_view(folders: list[Path], out: Path) -> list[Path]:
    """Write the page of a run, or of two beside each other.

    Films that are long lie beside the page, named after it; whatever it asks for is there.

    Args:
        folders: one or two that `motorcade run` wrote.
        out: the page's name, which ends in `.html`.

    Returns:
        the page and the films beside it.

    Raises:
        ValueError: another ending or count, or what `open_look` refuses.
        OSError: a file cannot be read or written.
    """
    if out.suffix != ".html" or not 1 <= len(folders) <= 2:
        raise ValueError(
            f"write_view: expected one or two runs and a name that ends in .html, got "
            f"{len(folders)} and '{out.name}'"
        )
    runs = [open_look(folder) for folder in folders]
    names = [run.recording.name for run in runs]
    if len(set(names)) < len(names):  # told apart by where they lie
        names = [f"{name}, {one.resolve().name}" for name, one in zip(names, folders, strict=True)]
    out.parent.mkdir(parents=True, exist_ok=True)
    with unfinished(out.parent) as place:
        films = [_films(run, number, place) for number, run in enumerate(runs, 1)]
        beside = sum(path.stat().st_size for one in films for path in one.values()) > INSIDE_BYTES
        inner: list[InnerFilm] = []
        written: list[Path] = []
        looks: list[dict[str, Any]] = []
        for run, shown_as, clips in zip(runs, names, films, strict=True):
            named: list[dict[str, Any]] = []
            for name, path in clips.items() if beside else ():
                kept = out.with_name(f"{out.stem}-{path.name}")
                copy_file(path, kept)
                written.append(kept)
                named.append({"name": name, "src": kept.name})
            for name, path in (_small(run, clips) if beside else clips).items():
                inner.append(inner_film(path.stem, path))
                named.append({"name": name, "src": f"#{path.stem}"} | _size_of(run, name))
            looks.append(look_of(run, named) | {"name": shown_as})
        write_bytes(out, view_page(looks, inner).encode())
    return [out, *written]


def _small(run: LookedAt, clips: dict[str, Path]) -> dict[str, Path]:
    """A small copy of the footage for inside the page: browsers let no film that lies beside it
    into their graphics, where the camera's sign has its image. None where that is too large too.
    """
    if not clips:
        return {}
    path = clips["footage"].with_name(clips["footage"].name.replace("footage", "small"))
    stamps, (width, height) = run.recording.frames.time_ns, _size_of(run, "small")["size"]
    images = (image for _, image in read_frames(clips["footage"]))
    tracked = track(images, "small images copied", len(stamps))
    write_film(path, tracked, stamps, (width, height))
    return {"small": path} if path.stat().st_size <= INSIDE_BYTES else {}


def _size_of(run: LookedAt, name: str) -> dict[str, Any]:
    """Pixels of the small copy; others are as large as the footage."""
    camera = run.recording.camera
    assert camera is not None  # `look_of` refuses that before
    return {"size": film_size(camera.width, camera.height, SMALL_PX)} if name == "small" else {}


def _films(run: LookedAt, number: int, place: Path) -> dict[str, Path]:
    """Copies of a run's footage, and of its film where it has one, that can be sought quickly."""
    if not run.has_images:
        return {}
    stamps = run.recording.frames.time_ns
    films = {"footage": _footage(run)}
    zooms = isinstance(run.recording.frames, ZoomedFrames)  # the film has another focal length
    if run.findings.overlay is not None and not zooms:
        films["overlay"] = _overlay(run)
    paths = {}
    for name, images in films.items():
        paths[name] = place / f"{name}-{number}.mp4"
        copied = track(images, f"images of the {name} copied", len(stamps))
        write_film(paths[name], copied, stamps)
    return paths


def _footage(run: LookedAt) -> Iterator[ImageArray]:
    for frame in run.recording.frames:
        yield frame.image()


def _overlay(run: LookedAt) -> Iterator[ImageArray]:
    """The run's film, less the column or row that H.264 had to add."""
    film, camera = run.findings.overlay, run.recording.camera
    assert film is not None  # asked for by `_films` alone
    assert camera is not None  # `look_of` refuses that before
    for _, image in read_frames(film.path):
        yield image[: camera.height, : camera.width]
