"""Degradations: what measuring does to true poses and stamps, in physical units and seeded."""

from __future__ import annotations

from motorcade.fusion.motions.degradations.poses import (
    Degradation,
    Gaussian,
    InTurn,
    Outliers,
    PlanarFlips,
    Quantised,
    wrong_planar_pose,
)
from motorcade.fusion.motions.degradations.stamps import (
    Blackouts,
    DroppedFrames,
    Latency,
    StampJitter,
)

__all__ = [
    "Blackouts",
    "Degradation",
    "DroppedFrames",
    "Gaussian",
    "InTurn",
    "Latency",
    "Outliers",
    "PlanarFlips",
    "Quantised",
    "StampJitter",
    "wrong_planar_pose",
]
