"""Stage `report`: its figures as JSON, and one HTML page; what is large lies beside it.

Films lie in the report too where all is small, else beside it; so does a viewer that would make the
report too large, as characters with large images do.
"""

from __future__ import annotations

import base64
import gzip
import json
import platform
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.ga.files import off_record, read_bounded
from motorcade.render.scene import ImageArray
from motorcade.render.video import read_stamps_s
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.frames.views import ZoomedFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.look import LookedAt, look_of
from motorcade.replays.pipeline.packing import packed
from motorcade.replays.pipeline.report.film import (
    FilmView,
    Stills,
    film_of,
    standing_sheet,
    steadiness,
    steps_between,
    stills,
)
from motorcade.replays.pipeline.report.findings import Findings, told_paths
from motorcade.replays.pipeline.report.images import sections
from motorcade.replays.pipeline.report.summary import (
    LEFT_AS_IT_WAS,
    errors_caption,
    heading,
    headline,
    lead,
    next_steps,
    parameters,
    shown_columns,
    shown_value,
    stages_caption,
    summarise,
    tiles,
    to_mend,
)
from motorcade.replays.stages.values.camera_poses import CameraPoses, MarkerPoses
from motorcade.replays.stages.values.errors import Integrity, PathErrors, ReportFiles
from motorcade.replays.stages.values.inertial import Convergence, UsedImu
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.stages.values.view import OverlayVideo, PlacedCharacter
from motorcade.replays.web.film import film_size, write_film
from motorcade.replays.web.page import view_page
from motorcade.replays.web.pages import page_environment


def report(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: UsedImu,
    fused: FusedPath,
    smoothed: SmoothedPaths,
    integrity: Integrity,
    convergence: Convergence,
    errors: PathErrors,
    placed: PlacedCharacter,
    overlay: OverlayVideo | None,
    marker_poses: MarkerPoses | None = None,
) -> ReportFiles:
    """Write the page, with the viewer inside, and the films where they are small."""
    findings = Findings(
        recording=recording,
        camera_poses=camera_poses,
        imu=imu,
        fused=fused,
        smoothed=smoothed,
        integrity=integrity,
        convergence=convergence,
        errors=errors,
        placed=placed,
        overlay=overlay,
    )
    film = film_of(findings)
    summary = summarise(findings, film)
    marker_map = None if marker_poses is None else marker_poses.marker_map
    run = LookedAt(findings, marker_map, headline(findings))
    frames = 0 if overlay is None else overlay.frames
    kept = Kept(max(1, steps_between(frames)))
    viewer = embedded(run, kept)
    shown = stills(overlay, kept.images, run.recording.camera) if overlay and frames > 1 else None
    standing = standing_sheet(findings, kept.images)
    written = ReportFiles(
        new_file("report.html"), new_file("report.json"), viewer.footage, viewer.file
    )
    written.page.write_text(page(findings, viewer, shown, film, standing), encoding="utf-8")
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    written.summary.write_text(text, encoding="utf-8")
    return written


TEMPLATE = Path(__file__).with_name("template.html")
NO_VIDEO = (
    "this machine has no headless OpenGL. Debian and Ubuntu bring it with "
    "apt-get install libegl1 libgl1-mesa-dri; then run the same command again"
)
NO_IMAGES = "the recording holds corners of markers and no images to draw into"


def page(
    findings: Findings,
    viewer: Viewer,
    stills: Stills | None,
    film: FilmView | None,
    standing: bytes = b"",
) -> str:
    """The whole page as HTML text, with what `viewer` has inside and the stills of the film.

    `standing` is the sheet of what there is to stand on, where images were kept.
    """
    template = page_environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    labels = told_paths(findings)
    figures = {name: findings.errors.figures[name] for name in labels}
    keys = shown_columns(figures)
    return template.render(
        name=findings.recording.name,
        lead=lead(findings),
        headline=headline(findings),
        viewer=viewer,
        shape=_shape(findings),
        film_caption=_film_caption(findings),
        tiles=tiles(findings, film),
        mend=to_mend(findings, _why_no_film(findings)),
        steps=next_steps(findings),
        stills=None if stills is None else _stills(stills),
        standing={
            "sheet": standing and _data_address("image/jpeg", standing),
            "places": findings.placed.choices,
        },
        steadiness=steadiness(findings),
        labels=labels,
        errors_caption=errors_caption(findings) + _smoothing(findings),
        columns=[heading(key, figures, metric=findings.camera_poses.metric) for key in keys],
        rows=_rows(figures, keys),
        sections=sections(findings),
        stages=stages_caption(findings),
        has_truth=bool(findings.errors.against_truth),
        provenance=_provenance(),
    )


def _stills(stills: Stills) -> dict[str, str]:
    """Addresses of those that there are."""
    images = {"sheet": stills.sheet, "before": stills.before, "after": stills.after}
    return {
        name: _data_address("image/jpeg", data) if data else "" for name, data in images.items()
    }


def _shape(findings: Findings) -> float:
    """Width over height of the film."""
    camera = findings.camera_poses.camera or findings.recording.camera
    return camera.width / camera.height if camera is not None else 4.0 / 3.0


def _data_address(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _why_no_film(findings: Findings) -> str:
    if findings.overlay is not None:
        return ""
    corners = isinstance(findings.recording.frames, CornerFrames)
    return NO_IMAGES if corners else NO_VIDEO


def _film_caption(findings: Findings) -> str:
    film = findings.overlay
    if film is None:
        return ""
    footage = {"original": "the images as filmed", "undistorted": "straightened images"}
    return (
        f"Drawn into {footage.get(film.footage, f'{film.footage} images')} along the "
        f"{film.along} path, standing on {film.stands_on}, in {film.lit_by}."
    )


def _smoothing(findings: Findings) -> str:
    method = findings.smoothed.method
    if findings.recording.truth is None and method is None:
        return ""
    if method is None:
        return LEFT_AS_IT_WAS
    return f" Smoothed by {method}: {parameters(findings.smoothed.parameters)}."


def _rows(figures: dict[str, dict[str, float | None]], keys: list[str]) -> list[dict[str, Any]]:
    best = {key: _best_shown(key, [row.get(key) for row in figures.values()]) for key in keys}
    tied = {
        key for key in keys if len({shown_value(key, r.get(key)) for r in figures.values()}) < 2
    }
    rows = []
    for name, row in figures.items():
        shown = {key: shown_value(key, row.get(key)) for key in keys}
        cells = [
            {
                "text": shown[key],
                "value": row.get(key),
                "best": key not in tied and shown[key].lstrip("-") == best[key],
            }
            for key in keys
        ]
        rows.append({"name": name, "cells": cells})
    return rows


def _best_shown(key: str, values: list[float | None]) -> str:
    """The smallest size of a column as it is shown, so that equal figures share the honour."""
    return shown_value(key, min(abs(value) for value in values if value is not None))


def _provenance() -> list[tuple[str, str]]:
    return [
        ("motorcade", f"{version('motorcade')}, {kernels.backend} kernels"),
        ("Python, NumPy", f"{platform.python_version()}, {np.__version__}"),
        ("settings", "run.json beside this page holds every knob, key and time"),
    ]


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
    """Images of the footage that are kept by their numbers while it is copied: every n-th."""

    every: int
    images: dict[int, ImageArray] = field(default_factory=dict)


def embedded(run: LookedAt, kept: Kept) -> Viewer:
    """The viewer of a run, and the films that it and the report play.

    A recording without a camera has none: there is the film alone.
    """
    overlay = run.findings.overlay
    paths = {} if overlay is None else {"overlay": overlay.path}
    if run.recording.camera is None:
        return Viewer(_films(paths))
    clips: list[dict[str, Any]] = []
    if run.has_images:
        paths["footage"] = new_file(FOOTAGE)
        clips.append(_copy_footage(run, paths["footage"], kept))
    frames = run.recording.frames
    zooms = isinstance(frames, ZoomedFrames)  # the film then has another focal length
    if overlay is not None and overlay.frames == len(frames.time_ns) and not zooms:
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

    def images() -> Iterator[ImageArray]:
        for number, frame in enumerate(frames):
            image = frame.image()
            if number % kept.every == 0:
                kept.images[number] = image
            yield image

    write_film(path, images(), frames.time_ns, size)
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
