"""What smoothing did to a path, in figures that need no ground truth."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.metrics import NotObservableError, jitter_above
from motorcade.ga import Trajectory

# Motion of cameras and hands lies below; above it most acceleration is noise.
_ABOVE_HZ = 5.0


def changes(raw: Trajectory, smoothed: Trajectory) -> dict[str, float | None]:
    """How far poses were moved and how much jitter is left; None where it cannot be told.

    Jitter is the RMS acceleration above 5 Hz, or above a quarter of the rate where that is less;
    see `fusion.metrics.jitter_above`.

    Args:
        raw: the measured path.
        smoothed: the same stamps.

    Raises:
        ValueError: other stamps.
    """
    if not np.array_equal(raw.time_ns, smoothed.time_ns):
        raise ValueError("smoothed: expected the stamps of the raw trajectory, got others")
    before, after = raw.poses.rigid, smoothed.poses.rigid
    shift_m = np.linalg.norm(after.translation_m - before.translation_m, axis=-1)
    turn = (before.rotor.inverse() @ after.rotor).as_rotation_vector()
    turn_deg = np.rad2deg(np.linalg.norm(turn, axis=-1))
    figures: dict[str, float | None] = {
        "shift_rms_m": float(np.sqrt(np.mean(shift_m**2))),
        "shift_max_m": float(np.max(shift_m)),
        "turned_rms_deg": float(np.sqrt(np.mean(turn_deg**2))),
        "turned_max_deg": float(np.max(turn_deg)),
    }
    for name, trajectory in (("raw", raw), ("smoothed", smoothed)):
        linear, angular = _jitter(trajectory)
        figures[f"{name}_linear_jitter_m_s2"] = linear
        figures[f"{name}_angular_jitter_rad_s2"] = angular
    return figures


def _jitter(trajectory: Trajectory) -> tuple[float | None, float | None]:
    if len(trajectory) < 3:
        return None, None
    rate_hz = 1.0 / float(np.median(np.diff(trajectory.time_s)))
    rigid = Trajectory(trajectory.time_ns, trajectory.poses.rigid)
    try:
        jitter = jitter_above(rigid, min(_ABOVE_HZ, 0.25 * rate_hz))
    except NotObservableError:
        return None, None
    return jitter.linear_m_s2, jitter.angular_rad_s2
