"""Makes a drawn layer look taken by the footage's camera: exposure, motion blur, noise."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.scene import ImageArray, Layer

__all__ = ["Matching", "blended", "exposed", "frame_noise", "noisy"]

BLUR_SAMPLES = 7


@dataclass(frozen=True)
class Matching:
    """How drawn layers are fitted to footage; the default changes nothing.

    Attributes:
        gain: of the drawn light, linear; above 1 brightens.
        exposure_s: how long the shutter is open about each stamp; the camera's and the character's
            motion in that time blurs what is drawn. 0 for none.
        noise: standard deviation of grey noise added, in bytes; None measures each frame's own.

    Raises:
        ValueError: a gain that is not positive, or a time or noise below zero.

    >>> from motorcade.render import Matching
    >>> Matching().moments_ns(1_000)
    array([1000])
    >>> len(Matching(exposure_s=0.01).moments_ns(1_000))  # drawn so often, then averaged
    7
    """

    gain: float = 1.0
    exposure_s: float = 0.0
    noise: float | None = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.gain) and self.gain > 0.0):
            raise ValueError(f"Matching.gain: expected a number above 0, got {self.gain}")
        for name in ("exposure_s", "noise"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"Matching.{name}: expected 0 or more, got {value}")

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


def exposed(layer: Layer, gain: float) -> Layer:
    """A layer whose light is `gain` times as strong, on the renderer's curve (power 1 / 2.2)."""
    if gain == 1.0:
        return layer
    rgba = layer.rgba.astype(np.float32)
    rgba[..., :3] = np.minimum(rgba[..., :3] * gain ** (1.0 / 2.2), rgba[..., 3:])
    return Layer(np.rint(rgba).astype(np.uint8), layer.depth_m)


def frame_noise(frame: ImageArray) -> float:
    """Standard deviation of a frame's noise, bytes.

    The median of what a mask that cancels planes and edges leaves (Immerkær, "Fast noise variance
    estimation", 1996, with the median in place of the mean). Fine texture everywhere passes for
    noise.
    """
    grey = frame.astype(np.float32)
    grey = grey.mean(axis=2) if grey.ndim == 3 else grey
    if min(grey.shape) < 3:
        return 0.0
    mask = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32)
    left = cv2.filter2D(grey, -1, mask)[1:-1, 1:-1]
    return float(1.4826 * np.median(np.abs(left)) / 6.0)


def noisy(
    picture: ImageArray, alpha: FloatArray, sigma: float, rng: np.random.Generator
) -> ImageArray:
    """Noise on what was drawn, as strong as its alpha (h, w) from 0 to 1; a new picture."""
    if sigma == 0.0:
        return picture
    grain = rng.standard_normal(alpha.shape, dtype=np.float32) * (sigma * alpha)
    seen = picture + grain[..., None]
    return np.asarray(np.clip(np.rint(seen), 0, 255), dtype=np.uint8)
