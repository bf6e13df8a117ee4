"""Swinging feet lifted over the ground, smoothly, where they would graze it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.easing import smootherstep
from motorcade.ga.arrays import FloatArray

__all__ = ["stretches", "swing_lift_m"]

# The clearance of a swinging foot as a share of the leg's length, as toes of walkers have it at the
# least (13 mm, Winter 1992), and at most so much of the way that the foot goes in the swing.
CLEAR, CLEAR_OF_WAY = 0.014, 0.05
# Toe-off and landing: how long a swing takes to come to its clearance, and to give it up; and how
# far a lift reaches before and after where it is needed.
ROLL_S, SPREAD_S = 0.1, 0.1


def swing_lift_m(
    at: FloatArray,
    low_m: FloatArray,
    time_s: FloatArray,
    standing: NDArray[np.bool_],
    leg_m: float,
) -> FloatArray:
    """Smooth lifts ``(F,)`` by which swings clear the ground; 0 in stances.

    A swing is lifted by a smooth curve over what its clearance lacks: the most lacking within
    `SPREAD_S` of each moment, averaged over as much by a kernel that falls to 0. Within `ROLL_S`
    of a stance the lift fades, so that toes leave the ground and heels meet it as they did.

    Args:
        at: ``(F, 3)`` of the foot in the world.
        low_m: ``(F,)`` clearance of its lowest part as it goes; below 0 where it is sunk.
        time_s: ``(F,)`` rising.
        standing: ``(F,)``.
        leg_m: length of the leg, to which the clearance is in proportion.
    """
    lift = np.zeros(len(at))
    for start, end in stretches(~standing):
        rows = slice(max(start - 1, 0), min(end + 1, len(at)))
        when = time_s[rows]
        way = float(np.linalg.norm(np.ptp(at[rows, :2], axis=0)))
        share = np.ones(len(when))
        roll = max(min(ROLL_S, 0.4 * (when[-1] - when[0])), 1e-9)
        if start > 0:
            share *= smootherstep((when - when[0]) / roll)
        if end < len(at):
            share *= smootherstep((when[-1] - when) / roll)
        lacking = np.maximum(min(CLEAR * leg_m, CLEAR_OF_WAY * way) - low_m[rows], 0.0)
        lift[rows] = share * _smooth_over(lacking, when)
    return lift


def _smooth_over(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """A smooth curve ``(F,)`` nowhere below the values."""
    first = np.searchsorted(time_s, time_s - SPREAD_S, side="left")
    last = np.searchsorted(time_s, time_s + SPREAD_S, side="right")
    near = [slice(a, b) for a, b in zip(first, last, strict=True)]
    most = np.array([values[rows].max() for rows in near])
    made = np.empty_like(most)
    for k, rows in enumerate(near):
        weight = np.maximum(1.0 - ((time_s[rows] - time_s[k]) / SPREAD_S) ** 2, 0.0) ** 3
        made[k] = weight @ most[rows] / weight.sum()
    return made


def stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Starts and ends of stretches that are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
