"""scipy's smoothers on columns: of quaternions with continuous signs, and of positions."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

__all__ = ["gcv_spline", "savitzky_golay"]


def gcv_spline(time_s: FloatArray, rows: FloatArray) -> FloatArray:
    """The cubic smoothing spline of each column, its strength by generalised cross-validation."""
    from scipy.interpolate import make_smoothing_spline

    made = [make_smoothing_spline(time_s, column)(time_s) for column in rows.T]
    return np.stack(made, axis=-1)


def savitzky_golay(rows: FloatArray, window: int, order: int) -> FloatArray:
    """By index: it knows no stamps."""
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(rows, window, order, axis=0), dtype=np.float64)
