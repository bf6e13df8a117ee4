"""From the world to a pinhole camera's picture, and from that to the picture through a lens.

Drawn pictures are distorted as a lens does it, so that footage can stay as it was taken.

The scene is drawn by a pinhole camera wide enough for the whole distorted picture, and what was
drawn is resampled: alpha is premultiplied, so edges stay clean. Undistorting the footage instead
would blur all of it and cut its border off.
"""

from __future__ import annotations

import math
from typing import TypeVar

import cv2
import numpy as np

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
        nearest_m: where a point is nearer than this, or behind, the whole picture may show it.
        margin_px: by so much the hull is drawn larger.
    """
    last = np.array([camera.width, camera.height]) - 1
    if np.min(points_m[:, 2]) < nearest_m:
        return np.zeros(2, dtype=np.int64), last
    pixels = camera.project(points_m)
    low = np.clip(np.floor(pixels.min(axis=0) - margin_px), 0, last)
    high = np.clip(np.ceil(pixels.max(axis=0) + margin_px), 0, last)
    return low.astype(np.int64), high.astype(np.int64)


def warped(picture: Pixels, homography: FloatArray) -> Pixels:
    """A picture moved by a homography (3, 3), its edge repeated; depths are never mixed."""
    how = cv2.INTER_CUBIC if picture.dtype == np.uint8 else cv2.INTER_NEAREST
    size = picture.shape[1], picture.shape[0]
    edge = cv2.BORDER_REPLICATE
    moved = cv2.warpPerspective(picture, homography, size, flags=how, borderMode=edge)
    return np.asarray(moved, picture.dtype)


WIDEST = 3.0
"""The pinhole picture may be this many times as wide or tall as the distorted one."""


def can_be_drawn_for(camera: Camera | None) -> bool:
    """Whether `LensWarp` can distort pictures as the lens of a camera does."""
    if camera is None:
        return False
    try:
        LensWarp(camera)
    except ValueError:
        return False
    return True


class LensWarp:
    """From pictures of `pinhole` to those of `camera`; a camera without distortion changes nothing.

    Attributes:
        camera: whose pictures are wanted.
        pinhole: that draws; same focal lengths, of a size of its own.

    Raises:
        ValueError: a lens so wide that a pinhole picture would be more than `WIDEST` times as
            large, or that gives some pixels no ray.

    >>> from motorcade.render import LensWarp
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    >>> LensWarp(camera).pinhole is camera
    True
    """

    def __init__(self, camera: Camera) -> None:
        self.camera, self.pinhole = camera, camera
        if camera.model == "pinhole":
            return
        columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        source = camera.undistort(np.stack([columns, rows], axis=-1).astype(np.float64))
        low, high = source.reshape(-1, 2).min(axis=0), source.reshape(-1, 2).max(axis=0)
        size = high - low + 3.0
        if not np.all(size < WIDEST * np.array([camera.width, camera.height])):
            raise ValueError(
                f"LensWarp(camera): expected a lens whose undistorted picture is at most "
                f"{WIDEST:g} times as large as {camera.width} x {camera.height}, got "
                f"{size[0]:.0f} x {size[1]:.0f}; undistort the footage instead"
            )
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
        self._source = (source - (left, top)).astype(np.float32)
        self._whole, self._fraction = cv2.convertMaps(self._source, None, cv2.CV_16SC2)

    def layer(self, drawn: Layer) -> Layer:
        """A layer of `pinhole` as `camera` sees it; depth is taken from the nearest pixel."""
        if self.camera is self.pinhole:
            return drawn
        rgba = cv2.remap(drawn.rgba, self._whole, self._fraction, cv2.INTER_LINEAR)
        return Layer(rgba, self.depth(drawn.depth_m))

    def depth(self, depth_m: DepthArray) -> DepthArray:
        """A depth picture likewise, depths of different surfaces never mixed."""
        if self.camera is self.pinhole:
            return depth_m
        return np.asarray(cv2.remap(depth_m, self._source, None, cv2.INTER_NEAREST))

    def smooth(self, values: FloatArray) -> FloatArray:
        """A picture (h, w) of numbers that may be mixed, such as shade."""
        if self.camera is self.pinhole:
            return values
        distorted = cv2.remap(
            values.astype(np.float32), self._whole, self._fraction, cv2.INTER_LINEAR
        )
        return np.asarray(distorted, dtype=np.float64)
