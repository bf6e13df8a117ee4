"""`motorcade view`: a run's cache read back, its films copied, and the page written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from motorcade.ga.unfinished import unfinished
from motorcade.render.scene import ImageArray
from motorcade.render.video import read_frames
from motorcade.replays.engine.progress import track
from motorcade.replays.export import read_run
from motorcade.replays.files.atomic import copy_file, write_bytes
from motorcade.replays.report.findings import Findings
from motorcade.replays.report.page import headline
from motorcade.replays.studio.film import write_film
from motorcade.replays.studio.look.document import LookedAt, look_of
from motorcade.replays.studio.page import InnerFilm, inner_film, view_page

INSIDE_BYTES = 24 * 2**20
"""Films of a page that are larger than this together lie beside it."""


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
    found = None if markers is None else markers.marker_map
    return LookedAt(findings, found, headline(findings))


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
    out.parent.mkdir(parents=True, exist_ok=True)
    with unfinished(out.parent) as place:
        films = [_films(run, number, place) for number, run in enumerate(runs, 1)]
        total = sum(path.stat().st_size for one in films for path in one.values())
        beside = total > INSIDE_BYTES
        inner: list[InnerFilm] = []
        written: list[Path] = []
        looks: list[dict[str, Any]] = []
        for run, clips in zip(runs, films, strict=True):
            named = []
            for name, path in clips.items():
                address = f"#{path.stem}"
                if beside:
                    address = f"{out.stem}-{path.name}"
                    copy_file(path, out.with_name(address))
                    written.append(out.with_name(address))
                else:
                    inner.append(inner_film(path.stem, path))
                named.append({"name": name, "src": address})
            looks.append(look_of(run, named))
        write_bytes(out, view_page(looks, inner).encode())
    return [out, *written]


def _films(run: LookedAt, number: int, place: Path) -> dict[str, Path]:
    """Copies of a run's footage, and of its film where it has one, that can be sought quickly."""
    if not run.has_pictures:
        return {}
    stamps = run.recording.frames.time_ns
    made = {"footage": _footage(run)}
    if run.findings.overlay is not None:
        made["overlay"] = _overlay(run)
    paths = {}
    for name, pictures in made.items():
        paths[name] = place / f"{name}-{number}.mp4"
        write_film(paths[name], track(pictures, f"copying {name}", len(stamps)), stamps)
    return paths


def _footage(run: LookedAt) -> Iterator[ImageArray]:
    for frame in run.recording.frames:
        yield frame.image()


def _overlay(run: LookedAt) -> Iterator[ImageArray]:
    """The run's film, less the column or row that H.264 had to add."""
    film, camera = run.findings.overlay, run.recording.camera
    assert film is not None  # asked for by `_films` alone
    assert camera is not None  # `look_of` refuses that before
    for _, picture in read_frames(film.path):
        yield picture[: camera.height, : camera.width]
