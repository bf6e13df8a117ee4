"""Before and after: footage beside what was drawn into it, and the measured path beside the smooth.

Both are of one moment of the run that shows the difference best.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import off_record
from motorcade.render.plots import plot_series
from motorcade.render.scene import ImageArray
from motorcade.render.video import contact_sheet, read_frames
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.stages.values.view import OverlayVideo
from motorcade.replays.web.film import film_size
from motorcade.replays.web.pages import PagePlot
from motorcade.tracking import Camera

MOST_FRAMES, COLUMNS, WIDTH_PX = 12, 3, 340
MOST_BYTES = 300_000
STILL_PX, STILL_QUALITY = 960, 82
_QUALITIES = (85, 75, 65, 50, 35, 20)
CHANGED = 24
"""A channel that differs by more was drawn on; film and footage differ by less."""
COURSE_FRAMES, COURSE_ORDER = 2.5, 4
"""The course is a polynomial of that order about each frame, fitted to so many frames' deviation:
hands are slower than that (a tremor of 2 Hz at 30 frames/s leaves a two-hundredth of itself)."""
WINDOW_S = 3.0
FEWEST = 10
"""Frames in which the spot is seen, for the plot to say anything."""
NEAREST = 0.1
"""Of the usual distance: nearer than that, pixels leap."""


def steps_between(frames: int) -> int:
    """Every which frame is taken so that there are `MOST_FRAMES` or fewer, even in time."""
    return -(-frames // MOST_FRAMES)


@dataclass(frozen=True)
class Stills:
    """Images of a run as JPEG: a sheet of its film, and one frame before and after."""

    sheet: bytes
    before: bytes = b""
    after: bytes = b""


def stills(film: OverlayVideo, footage: dict[int, ImageArray], camera: Camera | None) -> Stills:
    """Frames of the film, and the one in which it differs most from the footage.

    Args:
        film: of two frames or more.
        footage: its images by their numbers, as far as they were kept.
        camera: what took them.

    Raises:
        OSError: a film that cannot be read.
    """
    every = steps_between(film.frames)
    with off_record():  # it lies in the cache
        chosen = list(read_frames(film.path, every=every))
    sheet = sheet_jpeg(chosen)
    best: tuple[int, ImageArray, ImageArray] | None = None
    for place, (_, after) in enumerate(chosen):
        before = _as_filmed(footage.get(place * every), film, camera)
        if before is None:
            continue
        after = after[: before.shape[0], : before.shape[1]]
        if after.shape != before.shape:
            continue
        drawn = int(np.count_nonzero(np.any(cv2.absdiff(after, before) > CHANGED, axis=-1)))
        if best is None or drawn > best[0]:
            best = drawn, before, after
    if best is None or best[0] == 0:
        return Stills(sheet)
    return Stills(sheet, *(_still(one) for one in best[1:]))


def _as_filmed(
    image: ImageArray | None, film: OverlayVideo, camera: Camera | None
) -> ImageArray | None:
    """An image of the footage as the film has it; None where it was moved about."""
    if image is None or film.footage not in ("original", "undistorted"):
        return None
    if film.footage == "undistorted" and camera is not None:
        image = camera.undistort_image(image)
    return image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)


def _still(image: ImageArray) -> bytes:
    size = film_size(image.shape[1], image.shape[0], STILL_PX)
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return _jpeg(np.asarray(small, np.uint8), STILL_QUALITY)


def _jpeg(image: ImageArray, quality: int) -> bytes:
    done, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise OSError(f"an image of {image.shape} cannot be written as JPEG")
    return bytes(data)


def sheet_jpeg(chosen: list[tuple[int, ImageArray]]) -> bytes:
    """Frames and their stamps in ns on one sheet, with their times, as JPEG of 300 kB at most."""
    labels = [f"{1e-9 * time_ns:.1f} s" for time_ns, _ in chosen]
    sheet = contact_sheet([image for _, image in chosen], COLUMNS, WIDTH_PX, labels)
    for quality in _QUALITIES:
        data = _jpeg(sheet, quality)
        if len(data) <= MOST_BYTES:
            break
    return data


@dataclass(frozen=True, eq=False)
class SpotCourse:
    """Where the character's spot is drawn along two paths, against its slow course.

    Fields:
        time_s: seconds after the first measured pose ``(P,)``.
        measured_px, smoothed_px: pixels from the course ``(P,)``.
        sideways: whether across the image, or up and down in it.
    """

    time_s: FloatArray
    measured_px: FloatArray
    smoothed_px: FloatArray
    sideways: bool


def spot_course(findings: Findings) -> SpotCourse | None:
    """The spot where the character stands, as both paths would draw it.

    The course is that along the smoothed path, less all that is quicker than a few frames. Seconds
    are chosen in which the paths differ most. None without a camera, where the paths are
    one, or where the spot lies behind the camera most of the time.
    """
    camera = findings.camera_poses.camera or findings.recording.camera
    measured = findings.camera_poses.measurements.trajectory
    path = next(iter(findings.smoothed.trajectories.values()))
    inside = (measured.time_ns >= path.time_ns[0]) & (measured.time_ns <= path.time_ns[-1])
    if camera is None or np.count_nonzero(inside) < FEWEST:
        return None
    stamps = measured.time_ns[inside]
    spot = findings.placed.placement.world_T_character.translation_m
    lens = camera.undistorted()
    seen = [_seen_px(one, stamps, spot, lens) for one in (measured, path)]
    known = np.all([np.isfinite(one[:, 0]) for one in seen], axis=0)
    if np.count_nonzero(known) < max(FEWEST, 0.5 * len(known)):
        return None
    before, after = (one[known] for one in seen)
    time_s = (stamps[known] - measured.time_ns[0]) * 1e-9
    off = before - after
    axis = int(np.argmax(np.sum(off**2, axis=0)))
    if not float(np.abs(off[:, axis]).max()) > 0.0:
        return None
    rows = _most_different(off[:, axis], time_s)
    course = _slow(after[:, axis], time_s, time_s[rows])
    return SpotCourse(
        time_s[rows], before[rows, axis] - course, after[rows, axis] - course, axis == 0
    )


def _seen_px(path: Trajectory, stamps: np.ndarray, spot: FloatArray, lens: Camera) -> FloatArray:
    """Pixels of a point of the world ``(P, 2)``; NaN where it is behind the camera or close to."""
    at = path.motors_at(stamps).inverse().apply(spot)
    usual = float(np.median(at[:, 2]))
    far = at[:, 2] > max(NEAREST * usual, 1e-9)
    seen_px = np.full((len(at), 2), np.nan)
    seen_px[far] = lens.project(at[far])
    return seen_px


def _slow(values: FloatArray, time_s: FloatArray, at_s: FloatArray) -> FloatArray:
    """The value at each of some stamps of the polynomial that fits those about it best."""
    reach_s = COURSE_FRAMES * float(np.median(np.diff(time_s)))
    course = np.empty(len(at_s))
    for k, moment_s in enumerate(at_s):
        away = (time_s - moment_s) / reach_s
        near = np.abs(away) <= 4.0
        weights = np.exp(-0.25 * away[near] ** 2)  # the root of those of the squares
        powers = np.vander(away[near], COURSE_ORDER + 1, increasing=True)
        fit, *_ = np.linalg.lstsq(weights[:, None] * powers, weights * values[near], rcond=None)
        course[k] = fit[0]
    return course


def _most_different(off: FloatArray, time_s: FloatArray) -> slice:
    """The segment of `WINDOW_S` in which the paths differ most."""
    ends = np.searchsorted(time_s, time_s + WINDOW_S, side="right")
    summed = np.concatenate([[0.0], np.cumsum(off**2)])
    whole = time_s <= max(float(time_s[-1]) - WINDOW_S, float(time_s[0]))
    start = int(np.argmax(np.where(whole, summed[ends] - summed[:-1], -1.0)))
    return slice(start, int(ends[start]))


def steadiness(findings: Findings) -> PagePlot | None:
    """The measured and the smoothed path as pixels of what is drawn along them."""
    course = spot_course(findings)
    if course is None:
        return None
    first = next(iter(findings.smoothed.trajectories))
    series = {
        "measured": (course.time_s, course.measured_px),
        first: (course.time_s, course.smoothed_px),
    }
    way = "sideways" if course.sideways else "up and down"
    caption = (
        f"How far the spot under the character would be drawn off its even course, {way}, in the "
        "seconds in which both differ most."
    )
    svg = plot_series(series, "where a spot is drawn along both paths", "off its course (px)")
    return PagePlot("The path, measured and smoothed", caption, svg, tuple(series))
