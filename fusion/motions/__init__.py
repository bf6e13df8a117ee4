"""Motions: analytic trajectories with exact derivatives, and what measuring does to them.

A motion is ``world_T_camera`` over time in seconds, worlds with z up, cameras looking along z;
twists stand in the moving frame, angular rate (rad/s) before velocity (m/s). `MOTIONS` names those
of the comparison; `motorcade.fusion.motions.degradations` adds noise, outliers and gaps.
"""

from __future__ import annotations

from motorcade.fusion.motions.motion import Factor, Motion
from motorcade.fusion.motions.standard import (
    MOTIONS,
    gimbal_crossing,
    handheld,
    screw,
    stop_and_go,
    tumble,
    zoom,
)

__all__ = [
    "MOTIONS",
    "Factor",
    "Motion",
    "gimbal_crossing",
    "handheld",
    "screw",
    "stop_and_go",
    "tumble",
    "zoom",
]
