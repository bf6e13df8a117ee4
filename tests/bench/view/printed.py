"""An image lying in the world like a print on paper, to be drawn into footage."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.render.scene import ImageArray, Surface

__all__ = ["printed_surface"]


def printed_surface(
    image: ImageArray,
    pixels_per_m: float,
    origin_px: tuple[float, float],
    world_T_print: Motor,
) -> Surface:
    """The rectangle that shows an image.

    Args:
        image: (h, w) or (h, w, 3) uint8 sRGB.
        pixels_per_m: its scale.
        origin_px: pixel (column, row) that lies at the print's origin; (0, 0) is the centre of the
            top-left pixel.
        world_T_print: pose of the print: x to its right, y up, z out of its face.

    Raises:
        ValueError: an image without pixels, or a scale that is not positive.
    """
    if image.ndim not in (2, 3) or 0 in image.shape:
        raise ValueError(
            f"printed_surface(image): expected (h, w) or (h, w, 3) pixels, got {image.shape}"
        )
    if not (np.isfinite(pixels_per_m) and pixels_per_m > 0.0):
        raise ValueError(
            f"printed_surface(pixels_per_m): expected a number above 0, got {pixels_per_m}"
        )
    height, width = image.shape[:2]
    x = (np.array([0.0, width]) - 0.5 - origin_px[0]) / pixels_per_m
    y = -(np.array([0.0, height]) - 0.5 - origin_px[1]) / pixels_per_m
    corners = np.array([[x[0], y[1], 0.0], [x[1], y[1], 0.0], [x[1], y[0], 0.0], [x[0], y[0], 0.0]])
    color = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
    return Surface(
        world_T_print.apply(corners),
        np.tile(world_T_print.rotor.apply(np.array([0.0, 0.0, 1.0])), (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        texture=color,
        texture_coordinates=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    )
