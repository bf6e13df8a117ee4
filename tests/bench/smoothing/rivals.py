"""The same smoothing jobs on quaternions beside translations, as written in plain NumPy and scipy.

They are what a practitioner writes without this library, pose by pose where the job is sequential;
each does the whole job, no less: filters with speeds, smoothers with covariances.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

__all__ = ["NumpyOneEuro", "ScipyOneEuro", "numpy_gaussian", "numpy_rts", "scipy_gaussian"]


def numpy_rts(
    time_s: FloatArray, q: FloatArray, t: FloatArray, densities: FloatArray
) -> FloatArray:
    """Constant-velocity RTS over error states of rotation and translation, dense 12 x 12 matrices.

    Quaternions ``(N, 4)`` wxyz, translations ``(N, 3)``; returns ``(N, 7)``. Noise 5 mm, 0.01 rad.
    """
    noise = np.diag([1e-4] * 3 + [2.5e-5] * 3)
    power = np.repeat(densities**2, 3)
    pose, rate, p = np.concatenate([q[0], t[0]]), np.zeros(6), np.diag([1e-2] * 6 + [1e2] * 6)
    kept = [(pose, rate, p, pose, p, p)]
    for k in range(1, len(time_s)):
        dt = time_s[k] - time_s[k - 1]
        f = np.eye(12)
        f[:6, 6:] = dt * np.eye(6)
        predicted = _moved(pose, dt * rate)
        pp = f @ p @ f.T + _noise(power, dt)
        measured = np.concatenate([q[k], t[k]])
        gain = np.linalg.solve(pp[:6, :6] + noise, pp[:6]).T
        step = gain @ _difference(measured, predicted)
        pose, rate, p = _moved(predicted, step[:6]), rate + step[6:], pp - gain @ pp[:6]
        kept.append((pose, rate, p, predicted, pp, f))
    made = [pose]
    for k in range(len(time_s) - 2, -1, -1):
        before_pose, before_rate, before_p = kept[k][:3]
        predicted, pp, f = kept[k + 1][3:]
        gain = np.linalg.solve(pp, f @ before_p).T
        residual = np.concatenate([_difference(pose, predicted), rate - before_rate])
        step = gain @ residual
        p = before_p + gain @ (p - pp) @ gain.T
        pose, rate = _moved(before_pose, step[:6]), before_rate + step[6:]
        made.append(pose)
    return np.array(made[::-1])


def _noise(power: FloatArray, dt: float) -> FloatArray:
    made = np.zeros((12, 12))
    made[:6, :6] = np.diag(power * dt**3 / 3)
    made[:6, 6:] = made[6:, :6] = np.diag(power * dt**2 / 2)
    made[6:, 6:] = np.diag(power * dt)
    return made


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.array([
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ])  # fmt: skip


def _moved(pose: FloatArray, step: FloatArray) -> FloatArray:
    angle = np.linalg.norm(step[:3])
    turn = np.concatenate([[np.cos(angle / 2)], 0.5 * np.sinc(angle / (2 * np.pi)) * step[:3]])
    return np.concatenate([_product(pose[:4], turn), pose[4:] + step[3:]])


def _difference(pose: FloatArray, base: FloatArray) -> FloatArray:
    turn = _product(base[:4] * [1.0, -1.0, -1.0, -1.0], pose[:4])
    turn = -turn if turn[0] < 0.0 else turn
    sine = np.linalg.norm(turn[1:])
    factor = 2.0 * np.arctan2(sine, turn[0]) / sine if sine > 0.0 else 2.0
    return np.concatenate([factor * turn[1:], pose[4:] - base[4:]])


def _share(cutoff_hz: float, dt: float) -> float:
    return 1.0 / (1.0 + 1.0 / (2.0 * np.pi * cutoff_hz * dt))


class NumpyOneEuro:
    """The 1€ filter on quaternion and translation, small arrays and all."""

    def __init__(self) -> None:
        self.pose: FloatArray | None = None
        self.rate, self.time_s = np.zeros(6), 0.0

    def update(self, q: FloatArray, t: FloatArray, time_s: float) -> FloatArray:
        """The filtered pose ``(7,)``."""
        if self.pose is None:
            self.pose, self.time_s = np.concatenate([q, t]), time_s
            return self.pose
        dt, self.time_s = time_s - self.time_s, time_s
        step = _difference(np.concatenate([q, t]), self.pose)
        share = _share(1.0, dt)
        self.rate = share * step / dt + (1.0 - share) * self.rate
        turn = _share(1.0 + 100.0 * float(np.linalg.norm(self.rate[:3])), dt)
        push = _share(1.0 + 100.0 * float(np.linalg.norm(self.rate[3:])), dt)
        self.pose = _moved(self.pose, np.concatenate([turn * step[:3], push * step[3:]]))
        return self.pose


class ScipyOneEuro:
    """The same with scipy's rotations."""

    def __init__(self) -> None:
        from scipy.spatial.transform import Rotation

        self._rotation = Rotation
        self.turned: Rotation | None = None
        self.t, self.rate, self.time_s = np.zeros(3), np.zeros(6), 0.0

    def update(self, q: FloatArray, t: FloatArray, time_s: float) -> FloatArray:
        """The filtered pose ``(7,)``, its quaternion xyzw."""
        measured = self._rotation.from_quat(q[[1, 2, 3, 0]])
        if self.turned is None:
            self.turned, self.t, self.time_s = measured, t, time_s
            return np.concatenate([measured.as_quat(), t])
        dt, self.time_s = time_s - self.time_s, time_s
        turn = (self.turned.inv() * measured).as_rotvec()
        share = _share(1.0, dt)
        self.rate = share * np.concatenate([turn, t - self.t]) / dt + (1.0 - share) * self.rate
        opened = _share(1.0 + 100.0 * float(np.linalg.norm(self.rate[:3])), dt)
        self.turned = self.turned * self._rotation.from_rotvec(opened * turn)
        self.t = self.t + _share(1.0 + 100.0 * float(np.linalg.norm(self.rate[3:])), dt) * (
            t - self.t
        )
        return np.concatenate([self.turned.as_quat(), self.t])


def _windowed(
    q: FloatArray, t: FloatArray, filtered: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    flips = np.cumsum(np.sum(q[1:] * q[:-1], axis=1) < 0.0) % 2 == 1
    signs = np.where(np.concatenate([[False], flips]), -1.0, 1.0)
    made = filtered(np.concatenate([signs[:, None] * q, t], axis=1))
    made[:, :4] /= np.linalg.norm(made[:, :4], axis=1, keepdims=True)
    return made


def scipy_gaussian(q: FloatArray, t: FloatArray, sigma: float) -> FloatArray:
    """Components through scipy.ndimage's Gaussian filter, by index; quaternions renormalised."""
    from scipy.ndimage import gaussian_filter1d

    return _windowed(q, t, lambda x: gaussian_filter1d(x, sigma, axis=0, truncate=4.0))


def numpy_gaussian(q: FloatArray, t: FloatArray, sigma: float) -> FloatArray:
    """The same through numpy.convolve."""
    offsets: NDArray[np.int64] = np.arange(-15, 16)
    weights = np.exp(-0.5 * (offsets / sigma) ** 2)
    weights /= weights.sum()
    return _windowed(
        q, t, lambda x: np.stack([np.convolve(column, weights, "same") for column in x.T], axis=1)
    )
