"""What a camera does in a shot: it stands, only turns, zooms, or moves through the scene.

Corners are tracked over segments of a shot. Where most rest, all over the image, the camera
stands, whatever else moves. Where a rotation about the lens explains them, it turns; the focal
length with which it explains them best is then that of the lens. With two focal lengths it zooms.
Whatever neither explains is parallax.

Source: Hartley & Zisserman 2003, section 8.4 (rotating and zooming cameras, no structure).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

MotionKind = Literal["stands", "turns", "zooms", "moves", "unknown"]

REST_PX, _SLIP_PX = 3.0, 0.4
"""Of an image 320 px long: what a held camera moves, and what a rotation may leave over."""
_SLIP_SHARE = 0.02
_AT_REST, _FEWEST_AT_REST, _FAST, _BORDER_AT_REST = 0.6, 8, 4.0, 0.3
_EXPLAINED = 0.6
_FLOW_SHARE = 0.03
_ZOOM = 0.04
_FEWEST_CORNERS, _FEWEST_FRAMES = 12, 5
_FOCALS = np.geomspace(0.4, 1.7, 16)
_USUAL_FOCAL = 0.8


@dataclass(frozen=True)
class CameraMotion:
    """What the camera does.

    Fields:
        kind: "unknown" where the images are too plain or too blurred to tell.
        moving: share of the corners that go another way than a standing or turning camera says.
        focal: focal length in longer sides of the image, where a turning camera tells it.
        focal_sigma: relative standard deviation of it; infinite where nothing is told.
    """

    kind: MotionKind
    moving: float = 0.0
    focal: float = _USUAL_FOCAL
    focal_sigma: float = math.inf

    def __str__(self) -> str:
        said = {
            "stands": "the camera stands",
            "turns": "the camera only turns",
            "zooms": "the lens zooms",
            "moves": "the camera moves",
            "unknown": "hardly anything can be tracked",
        }[self.kind]
        alone = self.kind in ("stands", "turns") and self.moving > 0.05
        return f"{said}, and things move before it" if alone else said


@dataclass(frozen=True)
class Rest:
    """Places of an image that are found again in a later one.

    Fields:
        still: where they were, to a pixel of an image 320 px long: a camera on a stand.
        rest: to 3 px: one that a hand holds.
        elsewhere: at another place.
        quarters: of the image, in so many some are at rest.
        border: share of all places near the image's edge that are at rest: where a camera moves,
            everything comes and goes there.
    """

    still: int = 0
    rest: int = 0
    elsewhere: int = 0
    quarters: int = 0
    border: float = 0.0


@dataclass(frozen=True, eq=False)
class TrackedCorners:
    """Corners ``(n, 2)`` of one frame and where they are some frames later, preview pixels.

    `rest` tells how much of the scene is where it was when the shot began.
    """

    first: int
    last: int
    first_px: FloatArray
    px: FloatArray
    rest: Rest = field(default_factory=Rest)

    @property
    def flow_px(self) -> FloatArray:
        """How far each corner moved ``(n,)``."""
        return np.asarray(np.linalg.norm(self.px - self.first_px, axis=-1))


def motion_of(segments: Sequence[TrackedCorners], size: tuple[int, int]) -> CameraMotion:
    """What the camera does over segments of a shot in previews of this width and height.

    Of segments that begin at the same frame, each is as the one before, and goes on.
    """
    unit = max(size) / 320.0
    longest = list({each.first: each for each in segments}.values())
    usable = [
        each
        for each in longest
        if len(each.px) >= _FEWEST_CORNERS
        and (
            each.last - each.first >= _FEWEST_FRAMES
            or np.median(each.flow_px) > _FLOW_SHARE * max(size)
        )
    ]
    if _stands([each for each in segments if each.last - each.first >= _FEWEST_FRAMES], unit):
        flow = np.concatenate([each.flow_px for each in segments])
        return CameraMotion("stands", float(np.mean(flow > REST_PX * unit)) if len(flow) else 0.0)
    if not usable:
        return CameraMotion("unknown")
    return _by_rotation(usable, size, unit)


def _stands(segments: Sequence[TrackedCorners], unit: float) -> bool:
    """Whether most of what is found again lies where it did, all over the image, to the end.

    On a stand that is so to a pixel. A hand moves the camera a little, as a slow travel does; but
    where the camera travels, what moves fast and what rests are not apart.
    """
    if not segments:
        return False
    later = [each.rest for each in segments[len(segments) // 2 :]]  # a slow travel shows by then
    still, rest, elsewhere, quarters = (
        np.array([getattr(each, name) for each in later])
        for name in ("still", "rest", "elsewhere", "quarters")
    )
    if rest.sum() < _FEWEST_AT_REST or quarters.max() < 2:
        return False
    if np.median(still / np.maximum(rest + elsewhere, 1)) > _AT_REST:
        return True
    longest = {each.first: each for each in segments}.values()
    fast = [np.median(each.flow_px) > _FAST * REST_PX * unit for each in longest if len(each.px)]
    return bool(
        np.mean(fast) > 0.5
        and rest.sum() > _AT_REST * (rest + elsewhere).sum()
        and np.mean([each.border for each in later]) > _BORDER_AT_REST
    )


def _by_rotation(
    segments: Sequence[TrackedCorners], size: tuple[int, int], unit: float
) -> CameraMotion:
    """Whether one focal length, or two of a zoom, and a rotation explain every segment."""
    allowed = [
        max(_SLIP_PX * unit, _SLIP_SHARE * float(np.median(each.flow_px))) for each in segments
    ]
    # (segments, focal lengths) median slip, in what is allowed.
    slips = np.array(
        [
            [np.quantile(slip_px(each, size, focal), _EXPLAINED) / limit for focal in _FOCALS]
            for each, limit in zip(segments, allowed, strict=True)
        ]
    )
    total = np.sqrt(np.mean(slips**2, axis=0))
    best = int(np.argmin(total))
    if np.mean(slips[:, best] < 1.0) > 0.9:
        within = np.log(_FOCALS[total <= total[best] + 0.25])
        sigma = max(float(np.ptp(within)) / 2.0, math.log(_FOCALS[1] / _FOCALS[0]) / 2.0)
        edge = best in (0, len(_FOCALS) - 1) or len(within) > len(_FOCALS) // 2
        moving = np.mean(
            [
                np.mean(slip_px(each, size, _FOCALS[best]) > 3.0 * limit)
                for each, limit in zip(segments, allowed, strict=True)
            ]
        )
        focal, sigma = (_USUAL_FOCAL, math.inf) if edge else (float(_FOCALS[best]), sigma)
        return CameraMotion("turns", float(moving), focal, sigma)
    zooms = np.array([_zoom(each) for each in segments])
    slip = [
        np.quantile(slip_px(each, size, _USUAL_FOCAL, zoom), _EXPLAINED) / (2.0 * limit)
        for each, zoom, limit in zip(segments, zooms, allowed, strict=True)
    ]
    if np.max(np.abs(np.log(zooms))) > _ZOOM and np.mean(np.array(slip) < 1.0) > 0.9:
        return CameraMotion("zooms")
    return CameraMotion("moves")


def slip_px(
    segment: TrackedCorners, size: tuple[int, int], focal: float, zoom: float = 1.0
) -> FloatArray:
    """How far corners lie ``(n,)`` from where the best rotation puts them.

    Kabsch's rotation between rays, reweighted so that a minority cannot turn it. `focal` is in
    longer sides; `zoom` multiplies it until the later frame.
    """
    middle = 0.5 * (np.array(size) - 1.0)
    length = focal * max(size)
    rays = [
        _unit((px - middle) / part)
        for px, part in ((segment.first_px, length), (segment.px, zoom * length))
    ]
    weight, left = np.ones(len(segment.px)), np.zeros(len(segment.px))
    for _ in range(5):
        u, _, vt = np.linalg.svd((rays[1] * weight[:, None]).T @ rays[0])
        turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        ahead = rays[0] @ turn.T
        ahead /= np.where(ahead[:, 2:] > 0.05, ahead[:, 2:], 0.05)
        left = np.linalg.norm(zoom * length * ahead[:, :2] + middle - segment.px, axis=-1)
        weight = 1.0 / (1.0 + left**2)
    return np.asarray(left)


def _unit(plane: FloatArray) -> FloatArray:
    rays = np.concatenate([plane, np.ones((len(plane), 1))], axis=-1)
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))


def _zoom(segment: TrackedCorners) -> float:
    """By how much distances between corners grow, in the middle."""
    rows = np.arange(len(segment.px))
    other = np.roll(rows, len(rows) // 2)
    before, after = (
        np.linalg.norm(px - px[other], axis=-1) for px in (segment.first_px, segment.px)
    )
    apart: NDArray[np.bool_] = before > 1.0
    return float(np.median(after[apart] / before[apart])) if apart.any() else 1.0
