"""Robust losses of a residual's size, each with the weight that it gives a squared residual.

Sources: Huber 1964; Triggs et al. 2000.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

__all__ = ["huber", "huber_cauchy"]


def huber(size: FloatArray, limit: float) -> tuple[FloatArray, FloatArray]:
    """Huber's loss and weight of sizes ``(*,)``: squares up to `limit`, beyond it straight.

    >>> from motorcade.tracking.optimise import huber
    >>> huber([1.0, 4.0], limit=2.0)
    (array([0.5, 6. ]), array([1. , 0.5]))
    """
    inside = np.minimum(size, limit)
    weight: FloatArray = limit / np.maximum(size, limit)
    return inside * (size - 0.5 * inside), weight


def huber_cauchy(size: FloatArray, limit: float, outlier: float) -> tuple[FloatArray, FloatArray]:
    """Huber's loss up to `outlier`, Cauchy's bounded pull beyond it: far residuals hardly count."""
    loss, _ = huber(np.minimum(size, outlier), limit)
    weight = limit / np.maximum(size, limit)
    beyond = np.maximum(size - outlier, 0.0) / outlier
    return loss + limit * outlier * np.arctan(beyond), weight / (1.0 + beyond**2)
