"""Refusals that several smoothers share; naming the parameter, what it may be, what came."""

from __future__ import annotations

import logging
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import checked_positive

_LOG = logging.getLogger("motorcade.smooth")

LARGEST_ORDER = 5
FEWEST_POSES = 16
"""That tell noise from motion."""
# Squares of sizes, and their products with those of the other kind, must not overflow.
_SMALLEST = 1e-30
# Stamps in milliseconds that are read as seconds lie at least so far apart, up to 100 Hz.
_COARSE_S = 10.0


def checked_order(order: int) -> int:
    """The order of a polynomial, 0 to 5, or ValueError."""
    if not isfinite(order) or int(order) != order or not 0 <= order <= LARGEST_ORDER:
        raise ValueError(f"order: expected 0 to {LARGEST_ORDER}, got {order}")
    return int(order)


def checked_length(trajectory: Trajectory, fewest: int, method: str) -> None:
    """Raise ValueError where a trajectory has fewer poses than a method needs."""
    if len(trajectory) < fewest:
        raise ValueError(
            f"trajectory: {method} expected at least {fewest} poses, got {len(trajectory)}"
        )


def checked_cutoff(cutoff_hz: float, trajectory: Trajectory, name: str = "cutoff_hz") -> float:
    """A cut-off below half the sampling rate (of the median interval), or ValueError."""
    cutoff = checked_positive(cutoff_hz, name, "Hz")
    intervals = np.diff(trajectory.time_s)
    nyquist = 0.5 / float(np.median(intervals)) if intervals.size else inf
    if cutoff >= nyquist:
        raise ValueError(
            f"{name}: expected below half the sampling rate, {nyquist:.6g} Hz, got {cutoff_hz}"
        )
    return cutoff


def checked_size(value: float, name: str, unit: str) -> float:
    """A noise or a density from 1e-30 to 1e30 of its unit, or ValueError."""
    if not _SMALLEST <= checked_positive(value, name, unit) <= 1.0 / _SMALLEST:
        raise ValueError(
            f"{name}: expected {_SMALLEST:g} to {1.0 / _SMALLEST:g} of {unit}, got {value}"
        )
    return float(value)


def in_double(trajectory: Trajectory) -> Trajectory:
    """The trajectory in float64, in which all estimates are made; itself where it is."""
    if trajectory.poses.coefficients.dtype == np.float64:
        return trajectory
    return replace(trajectory, poses=trajectory.poses.astype(np.float64))


def warn_of_coarse(interval_s: float) -> None:
    """Where poses lie farther apart than those of any camera, stamps may be in another unit."""
    if interval_s >= _COARSE_S:
        _LOG.warning(
            "stamps lie %.3g s apart. Are they milliseconds? Seconds are expected; divide by 1e3",
            interval_s,
        )
