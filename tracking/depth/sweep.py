"""What of a still scene is nearer than something: views from known places are compared by planes.

Where one view is compared with others, every plane before the camera carries the pixels of each
other to places of its own; the plane that shows all of them the same texture is as far off as what
is seen there (Collins 1996, "plane sweep"; here by normalised correlation of small patches, of the
best half of four views, so that what only some of them see counts too). Pixels without texture, and
of what moves, tell nothing; they go with those around them that look alike (He et al. 2010, "guided
filter").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

MOST_VIEWS = 40
"""Views that are kept of a film."""
_WIDEST_PX, _TALLEST_PX = 960, 112
"""Width of the largest views that are kept, and height of what is compared."""
_COMPARED, _ANGLE_RAD, _LEAST_RAD, _MOST_RAD = 4, 0.1, 0.02, 0.25
"""So many other views, best seen from directions so far apart; fewer pixels move in nearer ones,
and too much hides in farther ones."""
_NEAREST = 0.3
"""Of the distance of what may be hidden: nothing is looked for nearer than this."""
_PATCH, _SPREAD, _MARGIN, _NOISE = 7, 5, 10, 3.0
"""Sides of the patches that are compared and of those over which that is averaged, and how far
beyond the hull, pixels; and the noise of grey values below which a patch has no texture."""
_ALIKE, _UNIQUE = 0.55, 0.05
"""Correlation of what is the same, and how much that of any other plane is less."""
_STEP_PX, _STEPS, _CLEARLY = 1.5, 1.5, 0.08
"""From plane to plane what is farthest moves by so many pixels; nearer is what is so by so many
planes, and by this share of the distance."""
_DOUBT, _EDGE, _LEAST_SHARE = 0.1, 1e-4, 0.01
"""Where so few of the pixels around tell, as much speaks for nothing that is nearer; what is an
edge, in squared grey values of 0 to 1; and the share of the compared pixels that a thing covers."""


class Nearer(NamedTuple):
    """What is nearer than something, in a part of a view of a camera.

    Fields:
        scale: pixels of this part per pixel of the camera's image.
        first_px: column and row of the part's first pixel, in pixels of the part.
        share: ``(h, w)`` -1 where what is seen is surely not nearer, 1 where it surely is.
        depth_m: how far away what is nearer is, in the middle.
        hidden: share of the part, without its margin, before which something is.
    """

    scale: float
    first_px: tuple[int, int]
    share: NDArray[np.float32]
    depth_m: float
    hidden: float


@dataclass(frozen=True, eq=False)
class SceneViews:
    """Images of a still scene from known places.

    Args:
        camera: pinhole that takes the images.
        images: grey, of the camera's size or smaller by one factor.
        world_T_camera: their poses ``(n,)``.
        time_ns: ``(n,)`` their stamps, increasing.
    """

    camera: Camera
    images: list[GrayImage]
    world_T_camera: Motor
    time_ns: IntArray

    @staticmethod
    def scale_of(camera: Camera) -> float:
        """Of the images that are kept, over those of the camera."""
        return min(1.0, _WIDEST_PX / camera.width)

    def nearer(
        self, image: GrayImage, world_T_camera: Motor, hull_m: FloatArray, world_T_ground: Motor
    ) -> Nearer | None:
        """What in a view is nearer than a hull and stands up from the ground.

        Args:
            image: of the size of the others.
            world_T_camera: its pose.
            hull_m: ``(c, 3)`` corners in the world.
            world_T_ground: a plane z = 0, which hides nothing.

        Returns:
            None where the other views are too near to this one to tell, or too far, where the hull
            is not before the camera or out of the image, or nothing is nearer.
        """
        seen_m = world_T_camera.inverse().apply(hull_m)
        distance_m = float(seen_m[:, 2].min())
        if distance_m <= 0.0:
            return None
        others = self._compared(world_T_camera, hull_m.mean(axis=0))
        part = self._part(image, seen_m)
        if not len(others) or part is None:
            return None
        scale, window, shown = part
        other_T_view = self.world_T_camera[others].inverse() @ world_T_camera
        turns, offsets = other_T_view.rotor.as_matrix(), other_T_view.translation_m
        matrix = _scaled(self.camera.matrix, scale * self._own_scale)
        step = _STEP_PX / (matrix[0, 0] * float(np.linalg.norm(offsets, axis=1).max()))
        planes = np.arange(0.0, 1.0 / (_NEAREST * distance_m), step)
        if len(planes) < 4 * _STEPS:
            return None
        images = [_smaller(self.images[k], scale) for k in others]
        first = window[1].start, window[0].start
        inverse_m, sure = _swept(shown, first, matrix, images, turns, offsets, planes)
        least = np.maximum(
            1.0 / distance_m,
            _inverse_ground(matrix, first, shown.shape, world_T_camera.inverse() @ world_T_ground),
        )
        clear = np.maximum(_STEPS * step, _CLEARLY * least)
        near = inverse_m > least + clear
        share = _spread_out(np.where(near, 1.0, -1.0), sure, shown)
        hides = cv2.morphologyEx(
            (share > 0.0).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)
        )
        hidden = float(np.mean(hides[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN]))
        if hidden < _LEAST_SHARE or not np.any(near & sure):
            return None
        depth_m = 1.0 / float(np.median(inverse_m[near & sure]))
        return Nearer(scale * self._own_scale, first, share, depth_m, hidden)

    @property
    def _own_scale(self) -> float:
        return float(self.images[0].shape[1] / self.camera.width)

    def _compared(self, world_T_camera: Motor, middle_m: FloatArray) -> list[int]:
        """The views that see a point from the best directions, apart from each other."""
        eyes, eye = self.world_T_camera.translation_m, world_T_camera.translation_m
        away, own = middle_m - eyes, middle_m - eye
        far, own_m = np.linalg.norm(away, axis=1), float(np.linalg.norm(own))
        angles = np.arccos(np.clip(away @ own / np.maximum(far * own_m, 1e-12), -1.0, 1.0))
        pixels = self.camera.project(self.world_T_camera.inverse().apply(middle_m))
        size = np.array([self.camera.width, self.camera.height])
        with np.errstate(invalid="ignore"):
            able = np.all((pixels > 0.0) & (pixels < size), axis=-1)
        able &= (angles > _LEAST_RAD) & (angles < _MOST_RAD)
        able &= (far > 0.6 * own_m) & (far < 1.6 * own_m)
        chosen: list[int] = []
        for k in sorted(np.flatnonzero(able), key=lambda k: abs(np.log(angles[k] / _ANGLE_RAD))):
            apart = [np.linalg.norm(eyes[k] - eyes[j]) for j in chosen]
            if min(apart, default=np.inf) > _LEAST_RAD * own_m:
                chosen.append(int(k))
        return chosen[:_COMPARED]

    def _part(
        self, image: GrayImage, seen_m: FloatArray
    ) -> tuple[float, tuple[slice, slice], NDArray[np.float32]] | None:
        """The part of an image about a hull, no taller than is compared, its scale and place."""
        pixels = self._own_scale * self.camera.project(seen_m)
        if not np.isfinite(pixels).all():
            return None
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        scale = 1.0
        while scale * (high - low)[1] > _TALLEST_PX:
            scale *= 0.5
        small = _smaller(image, scale)
        size = np.array(small.shape[1::-1])
        first = np.clip(np.floor(scale * low) - _MARGIN, 0, size).astype(int)
        last = np.clip(np.ceil(scale * high) + _MARGIN, 0, size).astype(int)
        if np.any(last - first < 3 * _MARGIN):
            return None
        window = slice(first[1], last[1]), slice(first[0], last[0])
        return scale, window, np.ascontiguousarray(small[window], np.float32)


def _smaller(image: GrayImage, scale: float) -> GrayImage:
    if scale == 1.0:
        return image
    return np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))


def _scaled(matrix: FloatArray, scale: float) -> FloatArray:
    """The matrix of images of another size, whose pixels' centres are at whole numbers."""
    scaled = np.diag([scale, scale, 1.0]) @ matrix
    scaled[:2, 2] += 0.5 * scale - 0.5
    return scaled


def _swept(
    shown: NDArray[np.float32],
    first: tuple[int, int],
    matrix: FloatArray,
    images: list[GrayImage],
    turns: FloatArray,
    offsets_m: FloatArray,
    planes: FloatArray,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Inverse depth ``(h, w)`` of each pixel, and where the views agree on it and on no other."""
    height, width = shown.shape
    from_window = np.linalg.inv(matrix) @ [[1, 0, first[0]], [0, 1, first[1]], [0, 0, 1]]
    own = _Patches(shown[..., None])
    scores = np.empty((len(planes), height, width), np.float32)
    others = np.empty((height, width, len(images)), np.float32)
    for k, inverse_m in enumerate(planes):
        for j, (image, turn, offset_m) in enumerate(zip(images, turns, offsets_m, strict=True)):
            homography = matrix @ (turn + inverse_m * np.outer(offset_m, [0, 0, 1])) @ from_window
            others[..., j] = cv2.warpPerspective(
                image,
                homography,
                (width, height),
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_CONSTANT,
            )
        scores[k] = cv2.blur(_best_half(own.likeness(others)), (_SPREAD, _SPREAD))
    best = scores.argmax(axis=0)
    top = scores.max(axis=0)
    away = np.abs(np.arange(len(planes))[:, None, None] - best) > 2
    second = np.where(away, scores, -1.0).max(axis=0)
    return planes[best].astype(np.float32), (top > _ALIKE) & (top - second > _UNIQUE)


class _Patches:
    """The patches of an image ``(h, w, 1)``, to be compared with those of others."""

    def __init__(self, image: NDArray[np.float32]) -> None:
        self._image, self._mean = image, _mean_of(image)
        self._spread = _spread_of(image, self._mean)

    def likeness(self, others: NDArray[np.float32]) -> NDArray[np.float32]:
        """Normalised correlation ``(h, w, n)`` with others, near 0 where there is no texture."""
        mean = _mean_of(others)
        shared = _mean_of(self._image * others) - self._mean * mean
        return np.asarray(shared / np.sqrt(self._spread * _spread_of(others, mean)), np.float32)


def _mean_of(images: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.blur(images, (_PATCH, _PATCH)), np.float32).reshape(images.shape)


def _spread_of(images: NDArray[np.float32], mean: NDArray[np.float32]) -> NDArray[np.float32]:
    spread = _mean_of(images * images) - mean * mean
    return np.asarray(np.maximum(spread, 0.0) + np.float32(_NOISE**2))


def _best_half(scores: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mean ``(h, w)`` of the better half of up to four scores ``(h, w, n)``."""
    if scores.shape[-1] < 3:
        return np.ascontiguousarray(scores.max(axis=-1))
    if scores.shape[-1] == 3:
        return np.asarray(0.5 * (scores.sum(axis=-1) - scores.min(axis=-1)), np.float32)
    a, b, c, d = np.moveaxis(scores, -1, 0)
    over, under = np.maximum(a, b), np.maximum(c, d)
    return np.asarray(0.5 * np.maximum(np.maximum(over + under, a + b), c + d), np.float32)


def _inverse_ground(
    matrix: FloatArray, first: tuple[int, int], shape: tuple[int, ...], camera_T_ground: Motor
) -> FloatArray:
    """Inverse depth ``(h, w)`` of a plane in each pixel of a part; 0 beyond the horizon, and
    where the camera is beneath it.
    """
    up = camera_T_ground.rotor.apply([0.0, 0.0, 1.0])
    height_m = -float(up @ camera_T_ground.translation_m)
    if height_m <= 0.0:
        return np.zeros(shape)
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    pixels = np.stack([columns + first[0], rows + first[1], np.ones(shape)], axis=-1)
    return np.asarray(np.maximum(pixels @ np.linalg.inv(matrix).T @ -up / height_m, 0.0))


def _spread_out(
    label: FloatArray, sure: NDArray[np.bool_], shown: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Labels of -1 to 1, of pixels that tell, for all that look as those around them do."""
    guide, radius = shown / 255.0, max(4, shown.shape[0] // 12)
    weight = sure.astype(np.float32)
    summed, support = (
        cv2.ximgproc.guidedFilter(guide, values, radius, _EDGE)
        for values in ((label * weight).astype(np.float32), weight)
    )
    return np.asarray((summed - _DOUBT) / (np.maximum(support, 0.0) + _DOUBT), np.float32)
