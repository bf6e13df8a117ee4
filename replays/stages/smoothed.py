"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.fusion.filter import Fused
from motorcade.fusion.smooth import smooth
from motorcade.ga import Trajectory


@dataclass(frozen=True)
class Smoothed:
    """The smoothed path `world_T_camera`, a trajectory a representation."""

    trajectories: dict[str, Trajectory]


def smoothed(
    fused: Fused,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler"),
    window_s: float = 0.15,
    order: int = 2,
) -> Smoothed:
    """Smooth the fused path by local polynomials of `order` over `window_s` seconds."""
    return Smoothed(
        {
            name: smooth(fused.trajectory, representation=name, window_s=window_s, order=order)
            for name in representations
        }
    )
