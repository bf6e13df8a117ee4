"""gtsam's factor graph under a prior of white noise on acceleration, rotation and position apart.

Each pose has a measurement and each step a factor: over dt the rate changes by white noise of a
density, and the pose moves by the mean of the rates before and after, but for white noise of
deviation density · sqrt(dt³ / 12) (T. D. Barfoot, State Estimation for Robotics, 2017, section 3.4,
with its noise written as two that are independent). Positions are linear. Rotations, with rates in
the moving frame, are linearised here and solved by gtsam until steps are small: a factor in Python
for gtsam's own optimiser takes ten times as long and ends at the same place, to which a test holds
this. With a loss of Cauchy, measurements are weighted anew before each step.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["gtsam_positions", "gtsam_rotations"]

# Steps below a hundredth of the noise change no figure.
_STEPS, _CLOSE = 15, 1e-2


def gtsam_positions(
    time_s: FloatArray, rows: FloatArray, density: float, noise: float, robust: bool = False
) -> FloatArray:
    """Positions ``(N, 3)``, measured with a deviation of `noise` an axis."""
    made = rows
    for _ in range(_STEPS if robust else 1):
        weights = _weights(made - rows, noise, robust)
        before, made = made, _solved(time_s, rows, None, density, noise / np.sqrt(weights))
        if _is_close(made - before, noise):
            break
    return made


def gtsam_rotations(
    time_s: FloatArray, wxyz: FloatArray, density: float, noise: float, robust: bool = False
) -> FloatArray:
    """Quaternions ``(N, 4)``, measured with a deviation of `noise` rad about an axis."""
    measured = Rotor.from_quaternion(wxyz)
    made = measured
    for _ in range(_STEPS):
        off = (made.inverse() @ measured).as_rotation_vector()
        weights = _weights(off, noise, robust)
        steps = (made[:-1].inverse() @ made[1:]).as_rotation_vector()
        turned = _solved(time_s, off, steps, density, noise / np.sqrt(weights))
        made = made @ Rotor.from_rotation_vector(turned)
        if _is_close(turned, noise):
            break
    return made.as_quaternion()


def _weights(off: FloatArray, noise: float, robust: bool) -> FloatArray:
    if not robust:
        return np.ones(len(off))
    return np.asarray(1.0 / (1.0 + np.sum(off**2, axis=1) / noise**2), dtype=np.float64)


def _is_close(step: FloatArray, noise: float) -> bool:
    return bool(np.max(np.abs(step)) < _CLOSE * noise)


def _solved(
    time_s: FloatArray,
    rows: FloatArray,
    steps: FloatArray | None,
    density: float,
    noises: FloatArray,
) -> FloatArray:
    """Where rows were measured; with `steps`, the turns that take rotations to the optimum."""
    import gtsam

    graph = gtsam.GaussianFactorGraph()
    measured = np.eye(3, 6)
    for k, (row, noise) in enumerate(zip(rows, noises.tolist(), strict=True)):
        graph.add(
            gtsam.JacobianFactor(k, measured, row, gtsam.noiseModel.Isotropic.Sigma(3, noise))
        )
    for k, dt in enumerate(np.diff(time_s).tolist()):
        before, after, off = np.eye(6), np.eye(6), np.zeros(6)
        before[:3, 3:], after[:3, 3:] = 0.5 * dt * np.eye(3), -0.5 * dt * np.eye(3)
        if steps is not None:
            # The step's logarithm, turned at either end: its derivatives to first order.
            x, y, z = (0.5 * steps[k]).tolist()
            across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            before[:3, :3] -= across
            after[:3, :3] += across
            off[:3] = -steps[k]
        sizes = density * np.sqrt(np.repeat([dt**3 / 12.0, dt], 3))
        noise_model = gtsam.noiseModel.Diagonal.Sigmas(sizes)
        graph.add(gtsam.JacobianFactor(k, -before, k + 1, after, off, noise_model))
    found = graph.optimize()
    return np.array([found.at(k)[:3] for k in range(len(rows))])
