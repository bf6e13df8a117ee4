"""Colours of pictures (sRGB, IEC 61966-2-1) and the linear light that they stand for, 0 to 1."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray


def to_linear(srgb: FloatArray) -> FloatArray:
    """Linear light of sRGB values from 0 to 1.

    >>> import numpy as np
    >>> from motorcade.animation.srgb import to_linear, to_srgb
    >>> to_linear(np.array([0.0, 0.5, 1.0])).round(3)
    array([0.   , 0.214, 1.   ])
    >>> to_srgb(to_linear(np.array([0.25]))).round(6)
    array([0.25])
    """
    return np.where(srgb <= 0.04045, srgb / 12.92, ((np.maximum(srgb, 0.0) + 0.055) / 1.055) ** 2.4)


def to_srgb(linear: FloatArray) -> FloatArray:
    """Values (sRGB) of linear light, both from 0 to 1; what lies outside is clipped."""
    inside = np.clip(linear, 0.0, 1.0)
    encoded = np.where(inside <= 0.0031308, 12.92 * inside, 1.055 * inside ** (1.0 / 2.4) - 0.055)
    return np.clip(encoded, 0.0, 1.0)
