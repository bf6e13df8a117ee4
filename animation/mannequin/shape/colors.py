"""What the mannequin wears: a racing suit, dark at the joints, with bright bands."""

from __future__ import annotations

import numpy as np

from motorcade.animation.easing import smoothstep
from motorcade.animation.mannequin.proportions import (
    ANKLE_HEIGHT_M,
    FOREARM_M,
    SHIN_M,
    UPPER_ARM_M,
)
from motorcade.animation.mannequin.shape.arm import SHOULDER_M, arm_axes
from motorcade.ga.arrays import FloatArray

__all__ = ["colors"]

SKIN, SUIT = (0.80, 0.62, 0.48), (0.24, 0.37, 0.49)
DARK, BRIGHT = (0.12, 0.14, 0.18), (0.90, 0.45, 0.15)
WRIST_M, KNEE_Z = UPPER_ARM_M + FOREARM_M, ANKLE_HEIGHT_M + SHIN_M
# Farther aside than this, above the knees, there are arms only.
ARM_ASIDE_M = 0.195


def colors(vertices: FloatArray, edge_m: float) -> FloatArray:
    """Colours (V, 3), sRGB, of vertices (V, 3) m at rest; borders as soft as an edge is long."""
    x, y, z = vertices[:, 0], np.abs(vertices[:, 1]), vertices[:, 2]
    soft = max(0.55 * edge_m, 0.003)
    along = (np.stack([x, y, z], axis=1) - SHOULDER_M) @ arm_axes()[2]
    arm = _above(y, ARM_ASIDE_M, 1e-4)
    trunk = 1.0 - arm
    layers = [
        (DARK, trunk * _between(z, 0.985, 1.025, soft)),  # belt
        (DARK, trunk * _flank(y, z, soft)),
        (DARK, trunk * _between(z, KNEE_Z - 0.050, KNEE_Z + 0.055, soft)),
        (DARK, trunk * (1.0 - _above(z + 0.25 * x, 0.105, soft))),  # shoes
        (BRIGHT, trunk * _between(z + 0.25 * x, 0.105, 0.125, soft)),
        (BRIGHT, trunk * _between(z + 0.55 * x, 1.452, 1.470, soft) * _above(0.095, y, soft)),
        (SKIN, trunk * _above(z + 0.55 * x, 1.470, soft) * _above(0.10, y, soft)),
        (DARK, arm * _between(along, UPPER_ARM_M - 0.045, UPPER_ARM_M + 0.040, soft)),
        (BRIGHT, arm * _between(along, 0.125, 0.150, soft)),
        (BRIGHT, arm * _between(along, WRIST_M - 0.036, WRIST_M - 0.016, 0.5 * soft)),
        (SKIN, arm * _above(along, WRIST_M - 0.016, 0.5 * soft)),
    ]
    made = np.tile(np.array(SUIT), (len(vertices), 1))
    for tone, share in layers:
        made += share[:, None] * (np.array(tone) - made)
    return np.asarray(np.clip(made, 0.0, 1.0))


def _flank(y: FloatArray, z: FloatArray, soft: float) -> FloatArray:
    """A panel down the side, from the armpit to the belt."""
    return np.asarray(_above(y, 0.118, soft) * _between(z, 1.025, 1.345, soft))


def _above(value: FloatArray | float, limit: FloatArray | float, soft: float) -> FloatArray:
    """0 below, 1 above a limit, a smooth step between."""
    return smoothstep(0.5 + 0.5 * (np.asarray(value) - limit) / soft)


def _between(value: FloatArray, low: float, high: float, soft: float) -> FloatArray:
    return np.asarray(_above(value, low, soft) - _above(value, high, soft))
