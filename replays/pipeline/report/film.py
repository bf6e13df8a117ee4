"""What the film shows: in how many frames the figure is in view, how large, and on what it stands.

That is what was counted on the layers that were drawn, after what hides the figure. What there is
to stand on is outlined in a frame, by the numbers that `--floor` takes. Before and after (footage
beside what was drawn into it, the measured path beside the smooth) are of one moment of the run
that shows the difference best.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import off_record
from motorcade.render.plots import plot_series
from motorcade.render.scene import ImageArray
from motorcade.render.video import contact_sheet, read_frames
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.stages.values.view import OverlayVideo, StandingPlace
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


_SHARES = {2: "half", 3: "a third", 4: "a quarter", 5: "a fifth"}
_WHOLE = 0.8


@dataclass(frozen=True)
class FilmView:
    """The film in figures.

    Fields:
        frames: how many the film has.
        in_view: how many of them show something of the figure.
        height_px: how high it is in the image, as far as the image shows it, in the median over
            these; None of several figures.
        height_share: the same as a share of the image's height.
        stands_on: what it stands on, in words.
    """

    frames: int
    in_view: int
    height_px: float | None
    height_share: float | None
    stands_on: str

    @property
    def sentence(self) -> str:
        """What somebody who opens the film will see.

        >>> from motorcade.replays.pipeline.report.film import FilmView
        >>> FilmView(180, 172, 216.0, 0.2, "the board").sentence
        'the figure stands on the board, in view in 172 of 180 frames, a fifth of the image high'
        """
        text = f"the figure stands on {self.stands_on}, in view in {self._counted}"
        if self.height_share is None or not self.in_view:
            return text
        return f"{text}, {self._size} high"

    @property
    def _counted(self) -> str:
        if self.in_view in (0, self.frames):
            return f"{'none' if not self.in_view else 'all'} of {self.frames} frames"
        return f"{self.in_view} of {self.frames} frames"

    @property
    def _size(self) -> str:
        share = float(self.height_share or 0.0)
        if share > _WHOLE:
            return "as the image is" if share <= 1.0 else "more than the image is"
        near = round(1.0 / max(share, 1e-6))
        name = _SHARES.get(near)
        return f"{name} of the image" if name else f"{100.0 * share:.0f} % of the image"


def film_of(findings: Findings) -> FilmView | None:
    """What the film of a run shows; None where there is none."""
    film = findings.overlay
    if film is None:
        return None
    if not film.checks:
        return FilmView(film.frames, film.frames_with_character, None, None, film.stands_on)
    seen = np.array([check.visible_px >= 1.0 for check in film.checks])
    in_view = int(np.count_nonzero(seen.any(axis=0)))
    if len(film.checks) > 1 or not in_view:
        return FilmView(film.frames, in_view, None, None, film.stands_on)
    height_px = float(np.median(film.checks[0].height_px[seen[0]]))
    return FilmView(film.frames, in_view, height_px, height_px / film.height_px, film.stands_on)


_OUTLINE_STEPS = 24
_NEAREST = 1e-3
_TAKEN, _OTHER = (255, 170, 0), (0, 200, 255)


def standing_sheet(findings: Findings, footage: dict[int, ImageArray]) -> bytes:
    """A JPEG with an image for each candidate, its outline and number in it, in another
    colour where the figure stands; empty without any.

    Args:
        findings: of the run.
        footage: images by their numbers; the one in the middle is drawn on.
    """
    recording, places = findings.recording, findings.placed.choices
    camera, path = findings.camera_poses.camera or recording.camera, findings.integrity.drawn
    stamps = recording.frames.time_ns
    posed = [k for k in footage if path.time_ns[0] <= stamps[k] <= path.time_ns[-1]]
    if camera is None or not places or not posed:
        return b""
    number = posed[len(posed) // 2]
    stands_on = findings.placed.stands_on
    colours = [_TAKEN if place.name == stands_on else _OTHER for place in places]
    camera_T_world = path.motors_at(np.int64(stamps[number])).inverse()
    drawn = [
        outlined(footage[number], camera, camera_T_world, place, str(k), colour)
        for k, (place, colour) in enumerate(zip(places, colours, strict=True), 1)
    ]
    return sheet_jpeg([(int(stamps[number]), image) for image in drawn])


def outlined(
    image: ImageArray,
    camera: Camera,
    camera_T_world: Motor,
    place: StandingPlace,
    label: str,
    colour: tuple[int, int, int],
) -> ImageArray:
    """A copy of an image with a place's outline, as far as it is ahead, and a label."""
    canvas = np.ascontiguousarray(
        image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
    ).copy()
    width = max(2, camera.width // 240)
    ahead = _round(camera_T_world.apply(place.corners_m))
    shown = ahead[:, 2] > _NEAREST * np.linalg.norm(ahead, axis=1).max()
    px = camera.project(np.where(shown[:, None], ahead, [0.0, 0.0, 1.0]))
    shown &= np.all(np.abs(px) < 4.0 * max(camera.width, camera.height), axis=1)
    for start, end, seen in zip(px, np.roll(px, -1, 0), shown & np.roll(shown, -1), strict=True):
        if seen:
            cv2.line(canvas, start.astype(int), end.astype(int), colour, width)
    size = camera.height / 240.0
    at = (int(0.02 * camera.width), int(0.14 * camera.height))
    cv2.putText(canvas, label, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 2 * width)
    return canvas


def _round(corners: FloatArray) -> FloatArray:
    """Points ``(k * 24, 3)`` along the sides of a polygon ``(k, 3)``."""
    along = np.linspace(0.0, 1.0, _OUTLINE_STEPS, endpoint=False)[:, None, None]
    sides = corners + along * (np.roll(corners, -1, axis=0) - corners)
    return np.asarray(np.swapaxes(sides, 0, 1).reshape(-1, 3))
