"""Lays rendered layers over photographs.

Images are uint8 sRGB; a layer's colour is premultiplied by its alpha, so that "over" is
`layer + (1 - alpha) * photograph` (Porter and Duff 1984). It is computed in linear light, as lenses
mix it and as the renderer averages its own edges.

Before that a layer is made to look taken by the footage's camera: exposure, motion blur, noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.render.scene import BRIGHTEST, DepthArray, ImageArray, Layer

BLUR_SAMPLES = 7
SHADES = 4097
"""Shares of light that are told apart: less than a byte each."""
OVER_STEPS = 32
"""Steps of how much brighter than an image can show something is, to one."""
REACHED, PILED, END_BYTES, FARTHEST = 1e-3, 4.0, 12, 64
"""A camera's darkest and brightest bytes hold that share of its pixels or more, each of three so
many times as many as those next to them, of which so many are asked; they lie nearer than the last
to 0 and 255."""
LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True)
class Matching:
    """How drawn layers are fitted to footage; the default changes nothing.

    Attributes:
        gain: of the drawn light, linear; above 1 brightens.
        exposure_s: how long the shutter is open about each stamp; the camera's and the character's
            motion in that time blurs what is drawn. 0 for none.
        noise: standard deviation of grey noise added, in bytes; None measures each frame's own.
        ends: the darkest and the brightest byte that the camera stores (`stored_ends`).

    Raises:
        ValueError: a gain that is not positive, a time or noise below zero, or ends out of order.

    >>> from motorcade.render import Matching
    >>> Matching().moments_ns(1_000)
    array([1000])
    >>> len(Matching(exposure_s=0.01).moments_ns(1_000))  # drawn so often, then averaged
    7
    """

    gain: float = 1.0
    exposure_s: float = 0.0
    noise: float | None = 0.0
    ends: tuple[int, int] = (0, 255)

    def __post_init__(self) -> None:
        checked_positive(self.gain, "Matching.gain")
        for name in ("exposure_s", "noise"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"Matching.{name}: expected 0 or more, got {value}")
        if not 0 <= self.ends[0] < self.ends[1] <= 255:
            raise ValueError(f"Matching.ends: expected two bytes in order, got {self.ends}")

    def moments_ns(self, time_ns: int) -> IntArray:
        """Stamps (K,) at which a frame is drawn, to be averaged; the frame's own without blur."""
        if self.exposure_s == 0.0:
            return np.array([time_ns], dtype=np.int64)
        k = (np.arange(BLUR_SAMPLES) + 0.5) / BLUR_SAMPLES - 0.5
        return np.asarray(time_ns + np.rint(1e9 * self.exposure_s * k), dtype=np.int64)


def blended(layers: list[Layer]) -> Layer:
    """The mean of layers drawn within one exposure; depth is the middle one's, else the nearest."""
    if len(layers) == 1:
        return layers[0]
    rgba = np.mean([layer.rgba.astype(np.float32) for layer in layers], axis=0)
    middle = layers[len(layers) // 2].depth_m
    depths = np.stack([layer.depth_m for layer in layers])
    nearest = np.min(np.where(depths > 0.0, depths, np.inf), axis=0)
    depth = np.where(middle > 0.0, middle, np.where(np.isfinite(nearest), nearest, 0.0))
    return Layer(np.rint(rgba).astype(np.uint8), depth.astype(np.float32))


def greyed(layer: Layer) -> Layer:
    """A layer as a camera without colour takes it (luma of Rec. 709, on the stored values)."""
    rgba = layer.rgba.copy()
    part = _extent(rgba[..., 3] > 0)
    rgba[part][..., :3] = (rgba[part][..., :3] @ LUMA)[..., None]
    return Layer(rgba, layer.depth_m)


def is_grey(frame: ImageArray) -> bool:
    """Whether an image (h, w) or (h, w, 3) has no colour; told by every fourth row and column."""
    if frame.ndim == 2:
        return True
    some = frame[::4, ::4]
    return bool(np.array_equal(some[..., 0], some[..., 1]) and np.array_equal(*some.T[1:]))


def stored_ends(images: Sequence[ImageArray]) -> tuple[int, int]:
    """The darkest and the brightest byte that the camera of some images (h, w) or (h, w, 3) stores.

    0 and 255, but where pixels pile up at another one: what is darker, or brighter, is stored so.

    >>> import numpy as np
    >>> from motorcade.render.composite import stored_ends
    >>> ramp = np.linspace(0, 300, 90_000).reshape(300, 300)
    >>> stored_ends([np.clip(ramp, 16, 235).astype(np.uint8)])
    (16, 235)
    """
    count = np.bincount(np.concatenate([one[::2, ::2].ravel() for one in images]), minlength=256)
    ends = []
    for share in (count / count.sum(), count[::-1] / count.sum()):
        end = int(np.argmax(np.cumsum(share) >= REACHED))
        pile, beside = share[: end + 3].sum() / 3.0, share[end + 3 : end + 3 + END_BYTES]
        ends.append(end if pile > PILED * np.median(beside) and end < FARTHEST else 0)
    return ends[0], 255 - ends[1]


def exposed(layer: Layer, gain: float, ends: tuple[int, int] = (0, 255)) -> Layer:
    """A layer whose light is `gain` times as strong, stored between two bytes."""
    if gain == 1.0 and ends == (0, 255):
        return layer
    rgba = layer.rgba.copy()
    part = rgba[_extent(rgba[..., 3] > 0)]
    # Most of a figure covers its pixels whole: there a byte goes to a byte.
    whole = np.clip(np.rint(255.0 * to_srgb(gain * _linear())), *ends).astype(np.uint8)
    colors = whole[part[..., :3]]
    rim = (part[..., 3] > 0) & (part[..., 3] < 255)
    alpha = part[rim][:, 3:] / 255.0
    own = to_linear(np.minimum(part[rim][:, :3] / 255.0 / alpha, 1.0))
    colors[rim] = np.rint(np.clip(255.0 * to_srgb(gain * own), *ends) * alpha)
    part[..., :3] = colors
    return Layer(rgba, layer.depth_m)


def frame_noise(frame: ImageArray) -> float:
    """Standard deviation of a frame's noise, bytes.

    The median of what a mask that cancels planes and edges leaves (Immerkær, "Fast noise variance
    estimation", 1996, with the median in place of the mean). Fine texture everywhere passes for
    noise.
    """
    # Whole numbers hold the sum of three bytes and what the mask leaves of it.
    grey: NDArray[Any] = frame
    if frame.ndim == 3:
        grey = sum(
            (frame[..., k] for k in range(1, frame.shape[2])), frame[..., 0].astype(np.int16)
        )
    if min(grey.shape) < 3:
        return 0.0
    mask = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32)
    left = np.abs(cv2.filter2D(grey, cv2.CV_16S, mask)[1:-1:2, 1:-1:2])
    middle = _median(left)
    return float(1.4826 * middle / (6.0 * (1 if frame.ndim == 2 else frame.shape[2])))


def _median(counts: NDArray[np.int16]) -> float:
    """The median of numbers from 0 on, by counting them: several times as fast as sorting."""
    below = np.cumsum(np.bincount(counts.ravel()))
    low, high = np.searchsorted(below, [(counts.size - 1) // 2, counts.size // 2], side="right")
    return 0.5 * float(low + high)


def noisy(
    image: ImageArray, alpha: FloatArray, sigma: float, rng: np.random.Generator
) -> ImageArray:
    """Noise on what was drawn, as strong as its alpha (h, w) from 0 to 1; a new image."""
    if sigma == 0.0:
        return image
    result = image.copy()
    part = _extent(alpha > 0.0)
    covered = alpha[part].astype(np.float32)
    grain = rng.standard_normal(covered.shape, dtype=np.float32) * (sigma * covered)
    result[part] = np.clip(np.rint(image[part] + grain[..., None]), 0, 255)
    return result


def as_rgb(frame: ImageArray) -> ImageArray:
    """A grey (h, w) or colour (h, w, 3) image as its own (h, w, 3) array.

    Raises ValueError: another shape or type.
    """
    if frame.dtype != np.uint8 or frame.ndim not in (2, 3) or frame.shape[2:] not in ((), (3,)):
        raise ValueError(
            f"frame: expected uint8 of shape (h, w) or (h, w, 3), got {frame.dtype} {frame.shape}"
        )
    if frame.ndim == 2:
        return np.asarray(cv2.cvtColor(frame, cv2.COLOR_GRAY2RGB), np.uint8)
    return frame.copy()


def over(
    frame: ImageArray,
    layer: Layer,
    depth_m: DepthArray | None = None,
    visible: NDArray[np.floating[Any]] | None = None,
) -> ImageArray:
    """Lay a rendered layer over a photograph.

    Where alpha is 0 the photograph stays as it is, where it is 255 the layer replaces it, exactly.

    Args:
        frame: (h, w, 3) uint8.
        layer: rendered image of the same size.
        depth_m: (h, w) depth of the photograph along the optical axis, metres; where it is nearer
            than the layer by more than a sensor's noise, the layer is hidden, with an edge as soft
            as a pixel. NaN and 0 mean unknown and hide nothing.
        visible: (h, w) share of the layer, 0 to 1, that nothing else hides; None for all of it.

    Returns:
        (h, w, 3) uint8, a new array.

    Raises:
        ValueError: sizes that differ.

    >>> import numpy as np
    >>> from motorcade.render import Layer, over
    >>> drawn = Layer(np.full((1, 1, 4), 255, np.uint8), np.full((1, 1), 2.0, np.float32))
    >>> photograph = np.zeros((1, 1, 3), np.uint8)
    >>> [int(over(photograph, drawn, np.full((1, 1), m, np.float32))[0, 0, 0]) for m in (3.0, 1.0)]
    [255, 0]
    """
    if layer.rgba.shape[:2] != frame.shape[:2]:
        raise ValueError(
            f"over(layer): expected the size of the frame {frame.shape[:2]}, got "
            f"{layer.rgba.shape[:2]}"
        )
    if depth_m is not None and depth_m.shape != frame.shape[:2]:
        raise ValueError(
            f"over(depth_m): expected the size of the frame {frame.shape[:2]}, got {depth_m.shape}"
        )
    result = frame.copy()
    part = _extent(layer.rgba[..., 3] > 0)
    rgba = layer.rgba[part]
    alpha = rgba[..., 3] / 255.0
    if depth_m is not None and rgba.size:
        alpha = alpha * seen_share(layer.depth_m[part], depth_m[part]) / 256.0
    alpha = alpha if visible is None else alpha * visible[part]
    whole, rim = alpha == 1.0, (alpha > 0.0) & (alpha < 1.0)
    np.copyto(result[part], rgba[..., :3], where=whole[..., None])
    own = rgba[rim][:, :3] / np.maximum(rgba[rim][:, 3:], 1.0)
    share, below = alpha[rim][:, None], _linear()[frame[part][rim]]
    mixed = share * to_linear(np.minimum(own, 1.0)) + (1.0 - share) * below
    result[part][rim] = np.rint(255.0 * to_srgb(mixed))
    return result


def seen_share(drawn_m: DepthArray, real_m: DepthArray) -> NDArray[np.uint16]:
    """Share (of 256) of a layer that nothing real hides, soft over a pixel at its edges.

    Depth counts as nearer beyond twice the noise of a structured-light sensor, 1.4 mm a square
    metre of distance (Khoshelham and Elberink, 2012), so that feet do not sink into what they
    stand on.
    """
    with np.errstate(invalid="ignore"):
        known = np.isfinite(real_m) & (real_m > 0.0) & (drawn_m > 0.0)
        hidden = known & (real_m < drawn_m - 0.0028 * drawn_m**2)
    if not hidden.any():
        return np.full(hidden.shape, 256, dtype=np.uint16)
    # Beyond the layer's rim the mask goes on as it is at the rim, so that the rim is no edge of it.
    inside = drawn_m > 0.0
    around = cv2.dilate(hidden.astype(np.uint8), np.ones((3, 3), dtype=np.uint8))
    mask = np.where(inside, hidden, around).astype(np.uint8)
    # Holes and lone pixels are the sensor's, not the world's.
    steady = cv2.medianBlur(mask, 3).astype(np.float32) * inside
    whole = inside.astype(np.float32)
    spread = cv2.GaussianBlur(steady, (0, 0), 0.8) / np.maximum(
        cv2.GaussianBlur(whole, (0, 0), 0.8), 1e-3
    )
    return np.asarray(np.rint(256.0 * (1.0 - np.minimum(spread, 1.0))), dtype=np.uint16)


def darken(frame: ImageArray, shade: NDArray[np.floating[Any]], white: float = 1.0) -> ImageArray:
    """Take a share of light away from every pixel.

    Args:
        frame: (h, w, 3) uint8.
        shade: (h, w) share of the light that is lost, 0 to 1.
        white: the light of what is overexposed, 1 or more; the image shows 1, and that is what it
            shows until as much is lost.

    Returns:
        (h, w, 3) uint8, a new array.
    """
    result = frame.copy()
    part = _extent(shade * (SHADES - 1.0) >= 0.5)
    lost = np.rint((SHADES - 1.0) * np.clip(shade[part], 0.0, 1.0)).astype(np.intp)
    first, table = 256 * lost, _darkened(max(round(OVER_STEPS * (white - 1.0)), 0)).ravel()
    for k in range(3):  # a channel at once is half of what all three at once take
        result[part][..., k] = np.take(table, first + frame[part][..., k])
    return result


@cache
def _linear() -> FloatArray:
    """The light that each byte stands for."""
    return to_linear(np.arange(256) / 255.0)


@lru_cache(maxsize=64)
def _darkened(over: int) -> ImageArray:
    """Each byte (column) when a share of its light is lost (row, of SHADES), where what is
    overexposed is so many of `OVER_STEPS` brighter than it shows.
    """
    kept = 1.0 - np.arange(SHADES)[:, None] / (SHADES - 1.0)
    full = np.clip((np.arange(256) - BRIGHTEST) / (255.0 - BRIGHTEST), 0.0, 1.0)
    light = _linear() * (1.0 + over / OVER_STEPS * full)
    shown = np.rint(255.0 * to_srgb(np.minimum(kept * light, 1.0)))
    return np.minimum(shown, np.arange(256)).astype(np.uint8)


def _extent(touched: NDArray[np.bool_]) -> tuple[slice, slice]:
    """The smallest rectangle, rows and columns, that holds every touched pixel."""
    rows = np.flatnonzero(touched.any(axis=1))
    columns = np.flatnonzero(touched.any(axis=0))
    if not rows.size:
        return slice(0, 0), slice(0, 0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
