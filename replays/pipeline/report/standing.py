"""What there is to stand on, each outlined in a frame, by the numbers that `--floor` takes."""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.scene import ImageArray
from motorcade.replays.pipeline.report.before_after import sheet_jpeg
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.stages.values.view import StandingPlace
from motorcade.tracking import Camera

_STEPS = 24
_NEAREST = 1e-3
_TAKEN, _OTHER = (255, 170, 0), (0, 200, 255)


def standing_sheet(findings: Findings, footage: dict[int, ImageArray]) -> bytes:
    """A JPEG with a picture for each candidate, its outline and number in it, in another
    colour where the figure stands; empty without any.

    Args:
        findings: of the run.
        footage: pictures by their numbers; the one in the middle is drawn on.
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
    return sheet_jpeg([(int(stamps[number]), picture) for picture in drawn])


def outlined(
    picture: ImageArray,
    camera: Camera,
    camera_T_world: Motor,
    place: StandingPlace,
    label: str,
    colour: tuple[int, int, int],
) -> ImageArray:
    """A copy of a picture with a place's outline, as far as it is ahead, and a label."""
    image = np.ascontiguousarray(
        picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
    ).copy()
    width = max(2, camera.width // 240)
    ahead = _round(camera_T_world.apply(place.corners_m))
    shown = ahead[:, 2] > _NEAREST * np.linalg.norm(ahead, axis=1).max()
    px = camera.project(np.where(shown[:, None], ahead, [0.0, 0.0, 1.0]))
    shown &= np.all(np.abs(px) < 4.0 * max(camera.width, camera.height), axis=1)
    for start, end, seen in zip(px, np.roll(px, -1, 0), shown & np.roll(shown, -1), strict=True):
        if seen:
            cv2.line(image, start.astype(int), end.astype(int), colour, width)
    size = camera.height / 240.0
    at = (int(0.02 * camera.width), int(0.14 * camera.height))
    cv2.putText(image, label, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 2 * width)
    return image


def _round(corners: FloatArray) -> FloatArray:
    """Points ``(k * 24, 3)`` along the sides of a polygon ``(k, 3)``."""
    along = np.linspace(0.0, 1.0, _STEPS, endpoint=False)[:, None, None]
    sides = corners + along * (np.roll(corners, -1, axis=0) - corners)
    return np.asarray(np.swapaxes(sides, 0, 1).reshape(-1, 3))
