"""The camera that a depth image was taken by, and whether it lies on the pixels of colour.

A structured-light sensor measures disparities in eighths of a pixel, so that the inverse depths it
can give lie apart by one step, ``1 / (8 f b)`` for focal length f and baseline b. The step shows in
the values that occur in an image, and tells a wrong unit or scale of the depth.

Source: Khoshelham & Elberink 2012 (the first Kinect).

Needs no poses and no features: the last pixels of nearer surfaces are laid over the image's
gradient, shifted this way and that, larger and smaller. They fit best where depth and colour agree.
A rotation of the depth camera shows as a shift, a wrong ratio of focal lengths as a zoom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.audit import DEPTH_ON_COLOUR_PX
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

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


_REACH = 0.05
"""Shifts up to so much of the image's width are tried (32 of 640 pixels)."""
_ZOOMS = np.linspace(0.86, 1.14, 15)
_JUMP = 1.12
"""A surface ends where what lies beside it is farther by an eighth: no slope looks like that."""
_BESIDE_PX = 6
"""Gaps beside an edge, which the depth camera's shadow leaves, are bridged up to here."""
_BLUR_PX = 1.5
_BRIGHTEST = 0.95
_FEWEST_PIXELS = 4000
_STANDS_OUT = 5.0
"""Times the scatter of shifts far from it by which the best one must lead their mean."""
_AHEAD = 1.0
"""Times that scatter by which another place must lead the stated one: less is what coincidence
gives one shift in three, and nothing separates the two."""
_USUAL_WIDTH = 320
"""Wider images are made smaller: what is looked for is pixels, not their fractions."""


@dataclass(frozen=True)
class EdgeOffset:
    """How far depth lies off colour; NaN where the images do not tell.

    Fields:
        right_px, down_px: by which depth has to be moved to lie on colour.
        zoom: by which it has to be made larger, about the image's middle.
        px: what both move a pixel by, root mean square over the image.
        contrast: how far the best fit stands out, in standard deviations of others.
        pixels: at edges of depth that were compared.
    """

    right_px: float
    down_px: float
    zoom: float
    px: float
    contrast: float
    pixels: int


def edge_offset(grays: Sequence[GrayImage], depths_m: Sequence[DepthImage]) -> EdgeOffset:
    """Find shift and zoom of depth that put its edges on those of the images.

    Args:
        grays: images ``(height, width)`` uint8.
        depths_m: their depth, registered, of the same size.

    Raises:
        ValueError: no images, or not as many of the one as of the other.

    Boxes before a wall, whose depth is 6 pixels too far to the left:

    >>> import numpy as np
    >>> from motorcade.tracking.depth.cameras import edge_offset
    >>> gray, depth = np.full((240, 320), 90, np.uint8), np.full((240, 320), 3.0, np.float32)
    >>> for y, x in np.mgrid[30:200:40, 40:280:60].reshape(2, -1).T:
    ...     gray[y : y + 20, x : x + 30] = 160
    ...     depth[y : y + 20, x - 6 : x + 24] = 2.0
    >>> found = edge_offset([gray] * 10, [depth] * 10)
    >>> round(found.right_px), round(found.down_px), round(found.zoom, 2)
    (6, 0, 1.0)
    """
    if not len(grays) or len(grays) != len(depths_m):
        raise ValueError(f"depths_m: expected as many as images, got {len(depths_m)}")
    height, width = grays[0].shape
    shrunk = max(width // _USUAL_WIDTH, 1)
    reach = round(_REACH * width / shrunk)
    score, counts = np.zeros((len(_ZOOMS), 2 * reach + 1, 2 * reach + 1)), np.zeros(len(_ZOOMS))
    pixels = 0
    both = zip(grays, depths_m, strict=True)
    for gray, depth_m in track(both, "comparing depth with colour", len(grays)):
        slope = np.fft.rfft2(_slope(gray, shrunk))
        rows, columns = np.nonzero(_edges(depth_m))
        pixels += len(rows)
        for index, zoom in enumerate(_ZOOMS):
            edges = _raster(columns, rows, zoom, (height, width), shrunk, reach)
            counts[index] += edges.sum()
            score[index] += _correlated(slope, edges, reach)
    if pixels < _FEWEST_PIXELS or not np.all(counts > 0.0):
        return EdgeOffset(np.nan, np.nan, np.nan, np.nan, 0.0, pixels)
    return _best(score / counts[:, None, None], reach, shrunk, (height, width), pixels)


def _best(
    score: FloatArray, reach: int, shrunk: int, shape: tuple[int, int], pixels: int
) -> EdgeOffset:
    rows, columns = np.indices(score.shape[1:])
    about_stated = np.zeros(score.shape, bool)
    middle = len(_ZOOMS) // 2
    about_stated[middle - 1 : middle + 2] = (
        shrunk * np.hypot(rows - reach, columns - reach) <= DEPTH_ON_COLOUR_PX
    )
    best, mode = (
        np.unravel_index(int(np.argmax(scores)), score.shape)
        for scores in (score, np.where(about_stated, score, -np.inf))
    )
    far = score[:, np.hypot(rows - best[1], columns - best[2]) > reach / 2]
    if score[best] - score[mode] < _AHEAD * far.std():
        best = mode
    z, down, right = (int(index) for index in best)
    contrast = float((score[z, down, right] - far.mean()) / max(far.std(), 1e-12))
    inside = all(0 < index < size - 1 for index, size in zip(best, score.shape, strict=True))
    if not inside or contrast < _STANDS_OUT:
        return EdgeOffset(np.nan, np.nan, np.nan, np.nan, contrast, pixels)
    right_px = shrunk * (right - reach + _vertex(score[z, down, right - 1 : right + 2]))
    down_px = shrunk * (down - reach + _vertex(score[z, down - 1 : down + 2, right]))
    step = float(_ZOOMS[1] - _ZOOMS[0])
    zoom = float(_ZOOMS[z]) + step * _vertex(score[z - 1 : z + 2, down, right])
    spread = (zoom - 1.0) ** 2 * (shape[0] ** 2 + shape[1] ** 2) / 12.0
    px = float(np.sqrt(right_px**2 + down_px**2 + spread))
    return EdgeOffset(float(right_px), float(down_px), zoom, px, contrast, pixels)


def _vertex(values: FloatArray) -> float:
    """Where the parabola through three values has its peak, from the middle one."""
    bend = values[0] - 2.0 * values[1] + values[2]
    return float(0.5 * (values[0] - values[2]) / bend) if bend < 0.0 else 0.0


def _slope(gray: GrayImage, shrunk: int) -> FloatArray:
    """Length of the image's gradient; the steepest twentieth counts alike."""
    smooth = cv2.GaussianBlur(gray.astype(np.float64), (0, 0), _BLUR_PX)
    slope = np.hypot(cv2.Sobel(smooth, cv2.CV_64F, 1, 0), cv2.Sobel(smooth, cv2.CV_64F, 0, 1))
    top = max(float(np.quantile(slope, _BRIGHTEST)), 1e-9)
    height, width = slope.shape[0] // shrunk, slope.shape[1] // shrunk
    cut = np.minimum(slope / top, 1.0)[: height * shrunk, : width * shrunk]
    slopes: FloatArray = cut.reshape(height, shrunk, width, shrunk).mean(axis=(1, 3))
    return slopes


def _edges(depth_m: DepthImage) -> NDArray[np.bool_]:
    """The last pixels of a nearer surface, where a farther one follows, at once or after a gap."""
    known = np.where(np.isfinite(depth_m) & (depth_m > 0.0), depth_m, np.nan)
    # A rim of unknown depth, so that nothing is compared with the opposite side of the image.
    known = np.pad(known, _BESIDE_PX, constant_values=np.nan)
    edges = np.zeros(known.shape, dtype=np.bool_)
    for axis in (0, 1):
        for sign in (-1, 1):
            ends = ~(np.roll(known, sign, axis) < _JUMP * known)
            for far in range(1, _BESIDE_PX + 1):
                edges |= ends & (np.roll(known, sign * far, axis) > _JUMP * known)
    return edges[_BESIDE_PX:-_BESIDE_PX, _BESIDE_PX:-_BESIDE_PX]


def _raster(
    columns: IntArray,
    rows: IntArray,
    zoom: float,
    shape: tuple[int, int],
    shrunk: int,
    reach: int,
) -> FloatArray:
    """How many edge pixels fall on each pixel of the smaller image; none near its rim."""
    height, width = shape[0] // shrunk, shape[1] // shrunk
    middle = 0.5 * (np.array(shape) - 1.0)
    y = np.rint((middle[0] + zoom * (rows - middle[0]) + 0.5) / shrunk - 0.5).astype(np.int64)
    x = np.rint((middle[1] + zoom * (columns - middle[1]) + 0.5) / shrunk - 0.5).astype(np.int64)
    inside = (y >= reach) & (y < height - reach) & (x >= reach) & (x < width - reach)
    counted = np.bincount(y[inside] * width + x[inside], minlength=height * width)
    return counted.reshape(height, width).astype(np.float64)


def _correlated(slope: np.ndarray, edges: FloatArray, reach: int) -> FloatArray:
    """Sums of the slope at the edges, moved by ``(a, b) - reach``."""
    whole = np.fft.irfft2(slope * np.conj(np.fft.rfft2(edges)), s=edges.shape)
    around = np.arange(-reach, reach + 1)
    sums: FloatArray = whole[around[:, None], around]
    return sums
