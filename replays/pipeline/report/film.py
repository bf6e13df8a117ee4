"""What the film shows: in how many frames the figure is in view, how large, and on what it stands.

That is what was counted on the layers that were drawn, after what hides the figure.

What there is to stand on, each outlined in a frame, by the numbers that `--floor` takes.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.scene import ImageArray
from motorcade.replays.pipeline.report.before_after import sheet_jpeg
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.stages.values.view import StandingPlace
from motorcade.tracking import Camera

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
