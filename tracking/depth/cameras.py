"""The camera that a depth image was taken by, and depth seen from another camera.

A structured-light sensor measures disparities in eighths of a pixel, so that the inverse depths it
can give lie apart by one step, ``1 / (8 f b)`` for focal length f and baseline b. The step shows in
the values that occur in an image, and tells a wrong unit or scale of the depth.

Source: Khoshelham & Elberink 2012 (the first Kinect).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.tracking.cameras.camera import Camera

DepthImage = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class DepthCamera:
    """Where a depth sensor looks from, and how.

    Fields:
        camera: its intrinsics; depth is measured along its optical axis.
        colour_T_depth: where it sits on the colour camera (depth camera's coordinates to the
            colour camera's).

    Raises:
        ValueError: not a single pose.

    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.depth import DepthCamera
    >>> camera = Camera(640, 480, 585.0, 585.0, 319.5, 239.5)
    >>> beside = DepthCamera(camera, Motor.from_translation([-0.025, 0.0, 0.0]))
    >>> beside.colour_T_depth.apply([0.0, 0.0, 2.0])
    array([-0.025,  0.   ,  2.   ])
    """

    camera: Camera
    colour_T_depth: Motor = field(default_factory=Motor.identity)

    def __post_init__(self) -> None:
        if self.colour_T_depth.shape != ():
            raise ValueError(
                f"DepthCamera.colour_T_depth: expected one motor, got {self.colour_T_depth.shape}"
            )

    def __repr__(self) -> str:
        coefficients = ", ".join(f"{value!r}" for value in self.colour_T_depth.coefficients)
        return f"DepthCamera({self.camera!r}, ({coefficients}))"


def register_depth(depth_m: DepthImage, taken_by: DepthCamera, colour: Camera) -> DepthImage:
    """Depth as the colour camera would have measured it, on that camera's pixels.

    Every measured pixel is a small square of surface; where several fall on one pixel of the colour
    camera, the nearest is what that camera sees. Pixels that no square covers are NaN: what the
    depth camera did not see, or hidden from it.

    Args:
        depth_m: ``(height, width)`` of the depth camera, NaN, zero and below where unknown.
        taken_by: the depth camera.
        colour: the camera to register it to.

    Raises:
        ValueError: not of the depth camera's size, or colour more than 64 times as fine.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.depth import DepthCamera, register_depth
    >>> camera = Camera(8, 6, 8.0, 8.0, 3.5, 2.5)
    >>> half_a_metre_right = DepthCamera(camera, Motor.from_translation([0.5, 0.0, 0.0]))
    >>> wall = np.full((6, 8), 2.0, np.float32)
    >>> register_depth(wall, half_a_metre_right, camera)[3]  # moves to the right by 8 * 0.5 / 2 px
    array([nan, nan,  2.,  2.,  2.,  2.,  2.,  2.], dtype=float32)
    """
    camera = taken_by.camera
    if depth_m.shape != (camera.height, camera.width):
        raise ValueError(
            f"depth_m: expected shape {(camera.height, camera.width)}, got {depth_m.shape}"
        )
    finer = np.array([colour.fx / camera.fx, colour.fy / camera.fy])
    if np.any(finer > FINEST):
        raise ValueError(
            f"colour: expected at most {FINEST} times the depth camera's focal length in pixels, "
            f"got {finer.max():.0f} times"
        )
    known = np.isfinite(depth_m) & (depth_m > 0.0)
    rays = _rays(camera)[known]
    points = rays * depth_m[known, None].astype(np.float64)
    pose = taken_by.colour_T_depth.as_matrix()
    seen = points @ pose[:3, :3].T + pose[:3, 3]
    px = colour.project(seen)
    # Half the sides of the rectangle that a pixel of the depth camera makes in the other image.
    half = np.maximum(0.5 * finer * (points[:, 2] / np.abs(seen[:, 2]))[:, None], 0.5)
    nearest = np.full(colour.height * colour.width, np.inf, dtype=np.float32)
    usable = np.isfinite(px[:, 0])
    px, half, ahead = px[usable], half[usable], seen[usable, 2].astype(np.float32)
    first = np.ceil(px - half).astype(np.int64)
    last = np.ceil(px + half).astype(np.int64) - 1
    most = np.maximum(_WIDEST, np.ceil(finer)).astype(np.int64)
    wide, high = np.minimum(np.max(last - first, axis=0, initial=0), most).tolist()
    for right in range(wide + 1):
        for down in range(high + 1):
            column, row = first[:, 0] + right, first[:, 1] + down
            inside = (column <= last[:, 0]) & (row <= last[:, 1])
            inside &= (column >= 0) & (row >= 0) & (column < colour.width) & (row < colour.height)
            np.minimum.at(nearest, (row * colour.width + column)[inside], ahead[inside])
    nearest[np.isinf(nearest)] = np.nan
    return nearest.reshape(colour.height, colour.width)


_WIDEST = 3
"""Pixels that one square covers at most, less one, where colour is hardly finer than depth; else
as many as it is finer by."""
FINEST = 64
"""Times by which colour may be finer: each pixel is drawn that often squared, and time-of-flight
sensors of 8 by 8 zones are 55 times as coarse as VGA."""


def _rays(camera: Camera) -> NDArray[np.float64]:
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return camera.unproject(np.stack([columns, rows], axis=-1))


_NEAREST_M, _FARTHEST_M = 0.3, 12.0
_FEWEST = 40
_REGULAR, _SHARE = 0.2, 0.6
_COARSE = 4.0
"""Steps have to be so many times as wide as the file's own unit, else rounding hides them."""


def inverse_depth_step(depth_m: DepthImage, unit_m: float) -> float | None:
    """The step between inverse depths, 1/m; None where the values do not stand on such a lattice.

    Args:
        depth_m: as stored, not resampled, NaN where unknown.
        unit_m: the smallest difference that the file can hold.

    >>> import numpy as np
    >>> from motorcade.tracking.depth.cameras import inverse_depth_step
    >>> disparities = np.arange(120, 400)
    >>> depth_m = np.round(1.0 / (0.0029 * disparities), 3).astype(np.float32)
    >>> round(inverse_depth_step(depth_m[None], 0.001), 4)
    0.0029
    """
    values = np.unique(depth_m[np.isfinite(depth_m)]).astype(np.float64)
    values = values[(values > _NEAREST_M) & (values < _FARTHEST_M)]
    apart, middle = np.diff(values), 0.5 * (values[1:] + values[:-1])
    wide = apart > _COARSE * unit_m
    if np.count_nonzero(wide) < _FEWEST:
        return None
    steps = (apart / middle**2)[wide]
    step = float(np.median(steps))
    regular = np.abs(steps - step) < _REGULAR * step
    if np.mean(regular) < _SHARE:
        return None
    return float(np.mean(steps[regular]))
