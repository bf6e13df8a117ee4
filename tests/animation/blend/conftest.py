"""A small skeleton and cycles of different lengths for it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.ga import Motor

NAMES = ("hips", "left_foot", "right_foot", "head")


@pytest.fixture
def skeleton() -> Skeleton:
    """Hips one metre up with two feet below and a head above."""
    shifts = [[0, 0, 1.0], [0, 0.1, -0.9], [0, -0.1, -0.9], [0, 0, 0.6]]
    rest = Motor.from_twist(np.concatenate([np.zeros((4, 3)), shifts], axis=1))
    return Skeleton(NAMES, np.array([-1, 0, 0, 0]), rest)


@pytest.fixture
def cycle() -> Callable[..., Clip]:
    """A maker of loops, by name and duration."""
    return _cycle


def _cycle(name: str, duration_s: float, phase: float = 0.0, stride: float = 0.3) -> Clip:
    """A loop in which the feet swing to and fro half a cycle apart and rise going forward."""
    time_s = np.linspace(0.0, duration_s, 61)
    angle = 2.0 * np.pi * (time_s / duration_s + phase)
    twists = np.zeros((61, 4, 6))
    twists[:, 0, 5] = 1.0 + 0.02 * np.cos(2 * angle)
    for joint, side in ((1, 0.0), (2, np.pi)):
        twists[:, joint, 3] = stride * np.sin(angle + side)
        twists[:, joint, 4] = 0.1 if joint == 1 else -0.1
        twists[:, joint, 5] = -0.9 + 0.1 * np.maximum(0.0, np.cos(angle + side))
    twists[:, 3, :3] = 0.2 * np.sin(angle)[:, None] * [1.0, 0.0, 0.0]
    twists[:, 3, 5] = 0.6
    twists[-1] = twists[0]
    return Clip(name, time_s, Motor.from_twist(twists), looped=True)
