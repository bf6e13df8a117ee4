"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.fusion.smoothing import automatic_window_s, smooth
from motorcade.ga import Trajectory
from motorcade.replays.stages.inertial.fused import FusedPath


@dataclass(frozen=True)
class Smoothed:
    """The smoothed path `world_T_camera`, a trajectory a representation.

    `window_s` is the width of the window used; None where the path was left as it was, because
    any smoothing would have taken away motion.
    """

    trajectories: dict[str, Trajectory]
    window_s: float | None


def smoothed(
    fused: FusedPath,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler_unwrapped", "euler"),
    window_s: float | None = None,
    order: int = 2,
) -> Smoothed:
    """Smooth the fused path by local polynomials of `order` over `window_s` seconds.

    `representations` names those to compare, of motor, similarity, rotor, dual_quaternion,
    quaternion, euler_unwrapped and euler; the first is what `overlay` draws along.
    Without `window_s` the widest window is taken that removes noise alone, judged by the path's
    own uncertainty (see `fusion.smoothing.automatic_window_s`).
    """
    if not representations:
        raise ValueError("representations: expected at least one, came none")
    path = fused.trajectory
    chosen = window_s
    if window_s is None:
        chosen = automatic_window_s(path, fused.covariance, order)
    if chosen is None:
        return Smoothed(dict.fromkeys(representations, path), None)
    return Smoothed(
        {
            name: smooth(path, "local_polynomial", name, window_s=chosen, order=order)
            for name in representations
        },
        chosen,
    )
