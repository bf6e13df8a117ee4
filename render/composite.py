"""Lays rendered layers over photographs.

Pictures are uint8 sRGB; a layer's colour is premultiplied by its alpha, so that "over" is
`layer + (1 - alpha) * photograph` (Porter and Duff 1984). It is computed on the stored sRGB
values, which is how the renderer averages its own multisampled edges.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import FloatArray
from motorcade.render.scene import DepthArray, ImageArray, Layer


def as_rgb(frame: ImageArray) -> ImageArray:
    """A grey (h, w) or colour (h, w, 3) picture as its own (h, w, 3) array.

    Raises:
        ValueError: another shape or type.
    """
    if frame.dtype != np.uint8 or frame.ndim not in (2, 3) or frame.shape[2:] not in ((), (3,)):
        raise ValueError(
            f"frame: expected uint8 of shape (h, w) or (h, w, 3), got {frame.dtype} {frame.shape}"
        )
    if frame.ndim == 2:
        return np.repeat(frame[..., None], 3, axis=2)
    return frame.copy()


def over(frame: ImageArray, layer: Layer, depth_m: DepthArray | None = None) -> ImageArray:
    """Lay a rendered layer over a photograph.

    Where alpha is 0 the photograph stays as it is, where it is 255 the layer replaces it, exactly.

    Args:
        frame: (h, w, 3) uint8.
        layer: rendered picture of the same size.
        depth_m: (h, w) depth of the photograph along the optical axis, metres; where it is nearer
            than the layer, the layer is hidden. NaN and 0 mean unknown and hide nothing.

    Returns:
        (h, w, 3) uint8, a new array.

    Raises:
        ValueError: sizes that differ.
    """
    if layer.rgba.shape[:2] != frame.shape[:2]:
        raise ValueError(
            f"over(layer): expected the size of the frame {frame.shape[:2]}, got "
            f"{layer.rgba.shape[:2]}"
        )
    color = layer.rgba[..., :3].astype(np.uint16)
    alpha = layer.rgba[..., 3:].astype(np.uint16)
    if depth_m is not None:
        if depth_m.shape != frame.shape[:2]:
            raise ValueError(
                f"over(depth_m): expected the size of the frame {frame.shape[:2]}, got "
                f"{depth_m.shape}"
            )
        known = np.isfinite(depth_m) & (depth_m > 0.0)
        hidden = known & (layer.depth_m > 0.0) & (depth_m < layer.depth_m)
        color[hidden] = 0
        alpha[hidden] = 0
    kept = (frame.astype(np.uint16) * (255 - alpha) + 127) // 255
    return np.asarray(np.minimum(color + kept, 255), dtype=np.uint8)


def darken(frame: ImageArray, shade: FloatArray) -> ImageArray:
    """Take a share of light away from every pixel.

    Args:
        frame: (h, w, 3) uint8.
        shade: (h, w) share of the light that is lost, 0 to 1.

    Returns:
        (h, w, 3) uint8, a new array.
    """
    kept = np.rint((1.0 - shade) * 256.0).astype(np.uint16)[..., None]
    return np.asarray((frame * kept + 128) >> 8, dtype=np.uint8)
