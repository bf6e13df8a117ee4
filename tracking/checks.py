"""The checks that every board makes of its numbers and of the images it is given."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

GrayImage = NDArray[np.uint8]


def check_count(value: object, field: str, least: int) -> None:
    """Refuse anything but a whole number of at least `least`.

    Raises:
        ValueError: naming the field.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{field}: expected a whole number of at least {least}, got {value!r}")


def check_length(value: Any, field: str) -> None:
    """Refuse anything but a finite length above zero.

    Raises:
        ValueError: naming the field.
    """
    number = isinstance(value, (int, float, np.integer, np.floating))
    length = float(value) if number and not isinstance(value, bool) else math.nan
    if not math.isfinite(length) or length <= 0.0:
        raise ValueError(f"{field}: expected metres above 0, got {value!r}")


def checked_gray(image: object) -> GrayImage:
    """Refuse anything but an image ``(height, width)`` of uint8.

    Raises:
        ValueError: another type or shape, or no pixels.
    """
    if not isinstance(image, np.ndarray):
        raise ValueError(f"image: expected a grey uint8 image, got {type(image).__name__}")
    if image.dtype != np.uint8 or image.ndim != 2 or image.size == 0:
        raise ValueError(
            f"image: expected a grey uint8 image (height, width), "
            f"got {image.dtype} of shape {image.shape}"
        )
    return image
