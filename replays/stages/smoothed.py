"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter import Fused
from motorcade.fusion.smooth import smooth
from motorcade.ga import Trajectory

FEWEST, MOST = 2, 10
"""Neighbours on either side of a pose that an automatic window may hold."""


@dataclass(frozen=True)
class Smoothed:
    """The smoothed path `world_T_camera`, a trajectory a representation.

    `window_s` is the width of the window used; None where the path was left as it was, because
    any smoothing would have moved it by more than it is uncertain.
    """

    trajectories: dict[str, Trajectory]
    window_s: float | None


def smoothed(
    fused: Fused,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler_unwrapped", "euler"),
    window_s: float | None = None,
    order: int = 2,
) -> Smoothed:
    """Smooth the fused path by local polynomials of `order` over `window_s` seconds.

    Without `window_s` the widest window is taken that moves the path, as motors, by no more than
    its own uncertainty (Morozov's discrepancy principle: what is removed must be noise).
    """
    if not representations:
        raise ValueError("representations: expected at least one, came none")
    path = fused.trajectory
    chosen = widest_window_s(fused, order) if window_s is None else window_s
    if chosen is None:
        return Smoothed(dict.fromkeys(representations, path), None)
    return Smoothed(
        {
            name: smooth(path, representation=name, window_s=chosen, order=order)
            for name in representations
        },
        chosen,
    )


def widest_window_s(fused: Fused, order: int) -> float | None:
    """The widest window whose result stays within the path's uncertainty; None if none does."""
    path = fused.trajectory
    if len(path) < 2 * FEWEST + 1:
        return None
    interval_s = float(np.median(np.diff(path.time_s)))
    widest = None
    for neighbours in range(FEWEST, MOST + 1):
        window_s = (2 * neighbours + 1) * interval_s
        moved = (path.poses.inverse() @ smooth(path, "motor", window_s, order).poses).as_twist()
        size = np.linalg.solve(fused.covariance, moved[..., None])[..., 0]
        if float(np.mean(np.sum(moved * size, axis=-1))) > moved.shape[-1]:
            break
        widest = window_s
    return widest
