"""Degradations: what measuring does to true poses and stamps, in physical units and seeded."""

from __future__ import annotations

from motorcade.fusion.motions.degradations.kinds import (
    Degradation,
    DroppedFrames,
    Gaussian,
    InTurn,
    Latency,
    Outliers,
    PlanarFlips,
    Quantised,
    StampJitter,
    wrong_planar_pose,
)

__all__ = [
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
