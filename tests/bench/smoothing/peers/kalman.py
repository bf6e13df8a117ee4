"""filterpy's Kalman filter of constant velocity and its RTS smoother, over columns of numbers."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

__all__ = ["filterpy_rts"]

# Of the measured columns; only its ratio to the process noise counts, and that is tuned.
_NOISE = 0.01


def filterpy_rts(time_s: FloatArray, rows: FloatArray, density: float) -> FloatArray:
    """Columns ``(N, k)`` under white noise of acceleration of that density, a second."""
    from filterpy.kalman import KalmanFilter

    width = rows.shape[1]
    kf = KalmanFilter(dim_x=2 * width, dim_z=width)
    kf.H = np.kron(np.eye(width), [[1.0, 0.0]])
    kf.R *= _NOISE**2
    kf.x = np.kron(rows[0], [1.0, 0.0])[:, None]
    step_s = np.diff(time_s)
    # Speeds are not known before: as wide as the fastest step says.
    fastest = max(1.0, float(np.max(np.abs(np.diff(rows, axis=0)) / step_s[:, None])))
    kf.P = np.kron(np.eye(width), np.diag([_NOISE**2, (10.0 * fastest) ** 2]))
    transitions, noises = [np.eye(2 * width)], [np.zeros((2 * width, 2 * width))]
    means, covariances = [kf.x], [kf.P]
    for measured, dt in zip(rows[1:], step_s, strict=True):
        transitions.append(np.kron(np.eye(width), [[1.0, dt], [0.0, 1.0]]))
        process = density**2 * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        noises.append(np.kron(np.eye(width), process))
        kf.predict(F=transitions[-1], Q=noises[-1])
        kf.update(measured)
        means.append(kf.x)
        covariances.append(kf.P)
    smoothed = kf.rts_smoother(np.array(means), np.array(covariances), transitions, noises)[0]
    return np.asarray(smoothed[:, ::2, 0], dtype=np.float64)
