"""Whether a clip's camera only turns: then there is a focal length, and no path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.pictures import track_corners
from motorcade.tracking.self_calibration.lens import KINDS, start_numbers
from motorcade.tracking.self_calibration.result import OnlyTurnsError, SelfCalibrationError
from motorcade.tracking.slam.features import find_corners
from motorcade.tracking.slam.initialise import flow_beyond_rotation_px

_TURN_PX, _TURN_SHARE = 1.0, 0.06
FEWEST_CORNERS = 80


def middle_camera(size: tuple[int, int], share: float) -> Camera:
    """A lens without distortion in the middle, its focal length in longer sides."""
    return KINDS[0].camera(start_numbers(share * max(size), size), size)


def refuse_turning(pictures: Sequence[GrayImage], size: tuple[int, int]) -> None:
    """Refuse a clip in which every motion of the corners is a turn about the lens.

    Args:
        pictures: as they are tracked.
        size: width and height of the pictures as given, for the message.

    Raises:
        OnlyTurnsError: such a clip.
        SelfCalibrationError: corners that cannot be followed.
    """
    small = pictures[0].shape[1], pictures[0].shape[0]
    least: list[tuple[float, float, float]] = []
    for first_px, px in _followed(pictures):
        flow = float(np.median(np.linalg.norm(px - first_px, axis=-1)))
        shares = np.geomspace(0.35, 2.5, 24)
        left = [
            flow_beyond_rotation_px(first_px, px, middle_camera(small, share)) for share in shares
        ]
        best = int(np.argmin(left))
        least.append((left[best], flow, shares[best]))
    if not least:
        raise SelfCalibrationError(
            "pictures: expected corners that move through the picture, got none: the camera "
            "stands still, or moves too fast to be followed"
        )
    beyond, moved, focals = np.array(least).T
    if np.all(beyond < np.maximum(_TURN_PX, _TURN_SHARE * moved)):
        focal = float(np.median(focals)) * max(size)
        raise OnlyTurnsError(
            "pictures: expected a camera that changes its place, got one that only turns (a focal "
            f"length of about {focal:.0f} pixels explains all motion); no path and no depth "
            "follow from that: move sideways past things at different depths",
            float(np.median(focals)),
        )


def _followed(pictures: Sequence[GrayImage]) -> list[tuple[FloatArray, FloatArray]]:
    """Corners of some frames, and where they are when they have moved far."""
    far = 0.12 * max(pictures[0].shape)
    flows = []
    for first in np.linspace(0, len(pictures) - 2, 6).astype(int):
        start = find_corners(pictures[first], 300).px
        rows, px = np.arange(len(start)), start
        motion, before = np.zeros_like(px), Pyramid(pictures[first])
        for picture in pictures[first + 1 :]:
            after = Pyramid(picture)
            there, good = track_corners(before, after, px, px + motion)
            motion, before = (there - px)[good], after
            rows, px = rows[good], there[good]
            if len(px) < FEWEST_CORNERS:
                break
            if np.median(np.linalg.norm(px - start[rows], axis=-1)) > far:
                break
        if len(px) >= FEWEST_CORNERS // 2:
            moved = float(np.median(np.linalg.norm(px - start[rows], axis=-1)))
            if moved > 0.25 * far:
                flows.append((start[rows], px))
    return flows
