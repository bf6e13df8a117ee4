"""Gimbal index: how much more, how much faster and how often an estimate turns than the truth.

What smoothing or interpolating Euler angles does near gimbal lock shows here: detours, bursts of
speed, and full revolutions that never happened. All three are 1, 1 and 0 for a perfect estimate,
and do not depend on the frames.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = [
    "GimbalIndex",
    "gimbal_index",
    "path_over_geodesic",
    "rotation_path_rad",
    "winding_count",
]

# Within this angle (a quarter of a turn) of the truth an estimate is at home again.
_HOME_COSINE = float(np.cos(0.25 * np.pi))
_STILL_RAD = 1e-9


@dataclass(frozen=True)
class GimbalIndex:
    """An estimate's rotation beside the truth's, at the estimate's stamps.

    Fields:
        path_ratio: length of the path of orientations (sum of the angles between neighbours) over
            the truth's; noise lengthens it too.
        peak_rate_ratio: largest angular rate from stamp to stamp over the truth's largest.
        spurious_turns: full revolutions that the estimate makes and the truth does not: how often
            the error, followed continuously, left the truth and came back to within 90° of it after
            going all the way round. Noise of less than half a turn makes none.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import gimbal_index
        >>> from motorcade.fusion.motions import tumble
        >>> true = tumble().sampled(100.0, 4.0)
        >>> blurred = smooth(true, "gaussian", "euler", sigma_s=0.2)  # angles leap at ±180°
        >>> found = gimbal_index(blurred, true)
        >>> found.peak_rate_ratio > 2.0, found.spurious_turns > 0
        (True, True)
    """

    path_ratio: float
    peak_rate_ratio: float
    spurious_turns: int


def gimbal_index(estimate: Trajectory, truth: Trajectory) -> GimbalIndex:
    """Compare the turning of two trajectories; steps must turn by less than half a turn.

    Stamps that the truth does not cover are left out.

    Raises:
        NotObservableError: fewer than two stamps within the truth, or a truth that does not turn.

    Examples:
        >>> from motorcade.fusion.metrics import gimbal_index
        >>> from motorcade.fusion.motions import tumble
        >>> true = tumble().sampled(100.0, 4.0)
        >>> found = gimbal_index(true, true)
        >>> round(found.path_ratio, 3), round(found.peak_rate_ratio, 3), found.spurious_turns
        (1.0, 1.0, 0)
    """
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    kept = np.flatnonzero(path.covers(time_s))
    if kept.size < 2:
        raise NotObservableError(
            f"gimbal index: expected 2 or more stamps within the truth, got {kept.size}"
        )
    ours, true = estimate.motors[kept].rotor, path.poses(time_s[kept]).rotor
    steps_s = np.diff(time_s[kept])
    turned, true_turned = _steps_rad(ours), _steps_rad(true)
    length = float(np.sum(true_turned))
    if length <= _STILL_RAD:
        raise NotObservableError("gimbal index: expected a truth that turns, got one that does not")
    return GimbalIndex(
        path_ratio=float(np.sum(turned)) / length,
        peak_rate_ratio=float(np.max(turned / steps_s) / np.max(true_turned / steps_s)),
        spurious_turns=winding_count(true.inverse() @ ours),
    )


def rotation_path_rad(rotors: Rotor) -> float:
    """Length of a path of orientations ``(N,)``: the sum of the angles between neighbours.

    Examples:
        >>> from motorcade.fusion.metrics import rotation_path_rad
        >>> from motorcade.ga import Rotor
        >>> rotors = Rotor.from_euler([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 0.6]])
        >>> round(rotation_path_rad(rotors), 6)
        1.2
    """
    return float(np.sum(_steps_rad(rotors)))


def path_over_geodesic(rotors: Rotor) -> float:
    """Length of a path of orientations ``(N,)`` over the angle between its ends; 1 is shortest.

    Raises:
        NotObservableError: ends of the same orientation.

    Examples:
        >>> from motorcade.fusion.metrics import path_over_geodesic
        >>> from motorcade.ga import Rotor
        >>> rotors = Rotor.from_euler([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 0.6]])
        >>> round(path_over_geodesic(rotors), 6)
        2.0
    """
    geodesic = float((rotors[0].inverse() @ rotors[-1]).angle())
    if geodesic <= _STILL_RAD:
        raise NotObservableError("path over geodesic: expected ends that differ, got equal ones")
    return rotation_path_rad(rotors) / geodesic


def _steps_rad(rotors: Rotor) -> FloatArray:
    return (rotors[:-1].inverse() @ rotors[1:]).angle()


def winding_count(error: Rotor) -> int:
    """How often the error's rotor, followed continuously, goes from near 1 to near -1 or back."""
    together = np.sum(error.coefficients[1:] * error.coefficients[:-1], axis=-1)
    signs = np.cumprod(np.concatenate([[1.0], np.where(together < 0.0, -1.0, 1.0)]))
    real = signs * error.coefficients[:, 0]
    home = np.sign(real[np.abs(real) > _HOME_COSINE])
    return int(np.count_nonzero(home[1:] != home[:-1]))
