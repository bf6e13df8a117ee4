"""From the world to a pinhole camera's image, and from that to the image through a lens.

The scene is drawn by a pinhole camera wide enough for the whole distorted image, and what was
drawn is resampled as the lens distorts it: alpha is premultiplied, so edges stay clean.
Undistorting the footage instead would blur all of it and cut its border off.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import replace
from functools import lru_cache
from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.scene import DepthArray, ImageArray, Layer
from motorcade.tracking.cameras.camera import Camera

Pixels = TypeVar("Pixels", ImageArray, DepthArray)


def plane_homography(camera: Camera, camera_T_plane: Motor) -> FloatArray:
    """(3, 3) from (x, y, 1) of a plane z = 0 to depth times (column, row, 1).

    >>> from motorcade.ga import Motor
    >>> from motorcade.render.lens import plane_homography
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    >>> plane_homography(camera, Motor.from_translation([0, 0, 2.0])) @ [1.0, 0.0, 1.0]
    array([113.,  47.,   2.])
    """
    return np.asarray(camera.matrix @ camera_T_plane.as_matrix()[:3][:, [0, 1, 3]])


def seen_extent(
    camera: Camera, points_m: FloatArray, nearest_m: float, margin_px: float = 0.0
) -> tuple[IntArray, IntArray]:
    """First and last (column, row) that may show the hull of points.

    Args:
        camera: pinhole.
        points_m: (N, 3) in the camera's frame.
        nearest_m: where a point is nearer than this, or behind, the whole image may show it.
        margin_px: by so much the hull is drawn larger.
    """
    last = np.array([camera.width, camera.height]) - 1
    if np.min(points_m[:, 2]) < nearest_m:
        return np.zeros(2, dtype=np.int64), last
    pixels = camera.project(points_m)
    low = np.clip(np.floor(pixels.min(axis=0) - margin_px), 0, last)
    high = np.clip(np.ceil(pixels.max(axis=0) + margin_px), 0, last)
    return low.astype(np.int64), high.astype(np.int64)


def warped(image: Pixels, homography: FloatArray) -> Pixels:
    """An image moved by a homography (3, 3), its edge repeated; depths are never mixed."""
    how = cv2.INTER_CUBIC if image.dtype == np.uint8 else cv2.INTER_NEAREST
    size = image.shape[1], image.shape[0]
    edge = cv2.BORDER_REPLICATE
    moved = cv2.warpPerspective(image, homography, size, flags=how, borderMode=edge)
    return np.asarray(moved, image.dtype)


WHOLE = slice(None), slice(None)
Extent = tuple[IntArray, IntArray]
"""First and last (column, row) of a part of an image."""
Window = tuple[slice, slice]
"""The same as the rows and the columns that it takes of an array."""


def window_of(extent: Extent) -> Window:
    """Rows and columns of a part of an image."""
    (left, top), (right, bottom) = extent
    return slice(int(top), int(bottom) + 1), slice(int(left), int(right) + 1)


WIDEST = 3.0
"""The pinhole image is at most this many times as wide or tall as the distorted one."""
STEP = 8
"""Every so many pixels a lens is asked which part of one image shows in the other."""
ROWS = 16
"""Pixels of so many rows are undistorted at once: their numbers stay in the processor's cache."""
_NOWHERE = -1e4  # pixels outside of any image: what is looked for there is empty


class LensWarp:
    """From images of `pinhole` to those of `camera`; a camera without distortion changes nothing.

    Nothing is drawn into pixels that the lens gives no ray, or one so far from the axis that a
    pinhole image would be more than `WIDEST` times as large: there footage stays as it is.

    Attributes:
        camera: whose images are wanted.
        pinhole: that draws; same focal lengths, of a size of its own.
        drawable: share of the camera's pixels into which can be drawn.

    >>> from motorcade.render import LensWarp
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    >>> LensWarp(camera).pinhole is camera
    True
    """

    def __init__(self, camera: Camera) -> None:
        self.camera, self.pinhole, self.drawable = camera, camera, 1.0
        if camera.model == "pinhole":
            return
        source = _sources(camera)
        far = np.abs(source - (camera.cx, camera.cy)) / (camera.width, camera.height)
        within = np.all(far < 0.5 * WIDEST, axis=-1)
        self.drawable = float(np.mean(within))
        near = source[within] if within.any() else np.array([[camera.cx, camera.cy]])
        low, high = near.min(axis=0), near.max(axis=0)
        # A border of one pixel on each side, for the bilinear filter.
        left, top = math.floor(low[0]) - 1, math.floor(low[1]) - 1
        self.pinhole = Camera(
            math.ceil(high[0]) - left + 2,
            math.ceil(high[1]) - top + 2,
            camera.fx,
            camera.fy,
            camera.cx - left,
            camera.cy - top,
        )
        source = np.where(within[..., None], source - (left, top), np.nan).astype(np.float32)
        self._some = source[::STEP, ::STEP]
        steps = [np.abs(np.diff(self._some, axis=k)) for k in (0, 1)]
        self._reach = 2.0 * max(np.nanmax(step, initial=STEP) for step in steps) + 1.0
        self._source = np.nan_to_num(source, nan=_NOWHERE)
        self._whole, self._fraction = cv2.convertMaps(self._source, None, cv2.CV_16SC2)

    def zoomed(self, ratio: float) -> LensWarp:
        """The same of a focal length so many times as long, for a pinhole of the same size.

        Zooming out, what the pinhole does not reach stays undrawn.
        """
        if ratio == 1.0:
            return self
        longer = copy(self)
        longer.camera, pinhole = (
            replace(camera, fx=ratio * camera.fx, fy=ratio * camera.fy)
            for camera in (self.camera, self.pinhole)
        )
        longer.pinhole = longer.camera if self.camera is self.pinhole else pinhole
        if self.camera is self.pinhole:
            return longer
        shift = (1.0 - 1.0 / ratio) * np.array([self.camera.cx, self.camera.cy])
        back = np.column_stack([np.eye(2) / ratio, shift])
        size, centre = self._source.shape[1::-1], np.array([pinhole.cx, pinhole.cy], np.float32)
        how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        source = cv2.warpAffine(self._source, back, size, flags=how, borderValue=(_NOWHERE,) * 4)
        near = source.min(axis=-1, keepdims=True) > 0.0
        source = np.where(near, centre + np.float32(ratio) * (source - centre), _NOWHERE)
        longer._source = source.astype(np.float32)
        longer._some = np.where(source > _NOWHERE, source, np.nan)[::STEP, ::STEP]
        longer._reach = ratio * self._reach
        longer._whole, longer._fraction = cv2.convertMaps(longer._source, None, cv2.CV_16SC2)
        return longer

    def shown(self, drawn: Extent) -> Window:
        """Where `camera`'s image can show a part of `pinhole`'s, and a little around it.

        One pixel where none can.
        """
        if self.camera is self.pinhole:
            return window_of(drawn)
        first, last = drawn
        near = (self._some >= first - self._reach) & (self._some <= last + self._reach)
        rows, columns = np.nonzero(near.all(axis=-1))
        if not rows.size:
            return slice(0, 1), slice(0, 1)
        pixels, size = np.array([columns, rows]), np.array([self.camera.width, self.camera.height])
        low = np.maximum(STEP * (pixels.min(axis=1) - 1), 0)
        return window_of((low, np.minimum(STEP * (pixels.max(axis=1) + 1), size - 1)))

    def drawn(self, shown: Window) -> Extent:
        """The part of `pinhole`'s image that shows in a window of `camera`'s, and a little around
        it.
        """
        rows, columns = shown
        if self.camera is self.pinhole:
            first = np.array([columns.start, rows.start])
            return first, np.array([columns.stop, rows.stop]) - 1
        seen = self._source[shown][::STEP, ::STEP].reshape(-1, 2)
        seen = seen[seen[:, 0] > _NOWHERE]
        if not len(seen):
            return np.zeros(2, np.int64), np.zeros(2, np.int64)
        high = np.array([self.pinhole.width, self.pinhole.height]) - 1
        low = np.clip(np.floor(seen.min(axis=0) - self._reach), 0, high)
        last = np.clip(np.ceil(seen.max(axis=0) + self._reach), 0, high)
        return low.astype(np.int64), last.astype(np.int64)

    def layer(self, drawn: Layer, window: Window = WHOLE) -> Layer:
        """A layer of `pinhole` as `camera` sees it in a window of its image; depth is taken from
        the nearest pixel.
        """
        if self.camera is self.pinhole:
            return drawn if window == WHOLE else Layer(drawn.rgba[window], drawn.depth_m[window])
        return Layer(self._mixed(drawn.rgba, window), self.depth(drawn.depth_m, window))

    def depth(self, depth_m: DepthArray, window: Window = WHOLE) -> DepthArray:
        """A depth image likewise, depths of different surfaces never mixed."""
        if self.camera is self.pinhole:
            return depth_m[window]
        return np.asarray(cv2.remap(depth_m, self._source[window], None, cv2.INTER_NEAREST))

    def sources(self, window: Window) -> NDArray[np.float32]:
        """Where in `pinhole`'s image each pixel of a window of `camera`'s lies, ``(h, w, 2)``."""
        if self.camera is not self.pinhole:
            return np.asarray(self._source[window], np.float32)
        rows, columns = np.mgrid[window]
        return np.stack([columns, rows], axis=-1).astype(np.float32)

    def smooth(self, values: NDArray[np.float32], window: Window = WHOLE) -> NDArray[np.float32]:
        """An image (h, w) of numbers that may be mixed, such as shade, likewise."""
        return values[window] if self.camera is self.pinhole else self._mixed(values, window)

    def _mixed(self, image: NDArray[Any], window: Window) -> NDArray[Any]:
        maps = self._whole[window], self._fraction[window]
        return np.asarray(cv2.remap(image, *maps, cv2.INTER_LINEAR))


def as_pinhole(image: ImageArray, camera: Camera, pinhole: Camera, scale: float) -> ImageArray:
    """A grey image of a camera as a pinhole in its place has it, smaller by a factor; black beyond.

    Pixels' centres are at whole numbers in both.
    """
    width, height = (round(scale * side) for side in (pinhole.width, pinhole.height))
    shrunk = image if scale == 1.0 else cv2.GaussianBlur(image, (0, 0), 0.5 / scale)
    seen_at = _seen_at(camera, pinhole, width, height)
    return np.asarray(cv2.remap(shrunk, seen_at, None, cv2.INTER_LINEAR))


@lru_cache(maxsize=4)
def _seen_at(camera: Camera, pinhole: Camera, width: int, height: int) -> NDArray[np.float32]:
    """Where a camera sees what each pixel of a pinhole's image, made smaller, shows."""
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    larger = np.array([pinhole.width / width, pinhole.height / height])
    pixels = (np.stack([columns, rows], axis=-1) + 0.5) * larger - 0.5
    seen = camera.project(pinhole.unproject(pixels))
    return np.nan_to_num(seen, nan=_NOWHERE).astype(np.float32)


@lru_cache(maxsize=4)
def _sources(camera: Camera) -> FloatArray:
    """Where in the undistorted image each pixel of a camera lies, (height, width, 2)."""
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    pixels = np.stack([columns, rows], axis=-1).astype(np.float64)
    some = (pixels[first : first + ROWS] for first in range(0, camera.height, ROWS))
    sources = np.concatenate([camera.undistort(part) for part in some])
    sources.setflags(write=False)
    return sources
