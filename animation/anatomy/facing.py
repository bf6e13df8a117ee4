"""Which way a body faces, and so which of its sides is the left one.

Knees bend forward, feet point forward, elbows bend backward, whatever the pose; a walker walks
forward. Where feet have no toes their mesh tells. Names of sides and what the format says count
as hints: exporters see some figures as a viewer does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.vectors import unit
from motorcade.ga.arrays import FloatArray, IntArray

# What each kind of evidence counts, from -1 to 1 times this.
TOES, SKIN, KNEES, ELBOWS, NAMES, HABIT, WAY = 3.0, 3.0, 2.0, 0.7, 1.5, 0.5, 0.7
# Bends, as shares of a limb, from which on evidence counts in full.
CLEAR_BEND = 0.05
# Feet that point less forward, as a cosine, tell nothing.
CLEAR_FOOT = 0.2
# So much evidence is needed.
ENOUGH = 0.45


@dataclass(frozen=True, eq=False)
class Evidence:
    """Limbs of a body in some poses, one side a column.

    Fields:
        legs: hip, knee, ankle ``(3, 2)``, or None.
        arms: shoulder, elbow, wrist ``(3, 2)``, or None.
        toes: joints ``(2,)`` that feet point to, or None.
        trunk: joints whose means its line goes from and to.
    """

    legs: IntArray | None
    arms: IntArray | None
    toes: IntArray | None
    trunk: tuple[list[int], list[int]]

    def axes(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vectors ``(F, 3)``: from the second side to the first, and along the trunk."""
        across = np.zeros((len(at), 3))
        for limb in (self.legs, self.arms):
            if limb is not None:
                across += unit(at[:, limb[0, 0]] - at[:, limb[0, 1]])
        below, above = (at[:, joints].mean(axis=1) for joints in self.trunk)
        return unit(across), unit(above - below)

    def forward(self, at: FloatArray) -> dict[str, float]:
        """Evidence that the first side is the left one, by kind; against it where negative."""
        across, trunk = self.axes(at)
        found: dict[str, float] = {}
        if self.legs is not None:
            hip, knee, ankle = (at[:, joints] for joints in self.legs)
            ahead = unit(np.cross(across[:, None], hip - ankle))
            found["knees"] = KNEES * _bent(hip, knee, ankle, ahead)
            if self.toes is not None:
                step = unit(at[:, self.toes] - ankle)
                shin = unit(np.cross(across[:, None], knee - ankle))
                share = float(np.mean(np.sum(step * shin, axis=-1)))
                found["toes"] = TOES * float(np.clip(share / 0.5, -1.0, 1.0))
                if abs(share) < CLEAR_FOOT:
                    found["toes"] = 0.0
        if self.arms is not None:
            shoulder, elbow, wrist = (at[:, joints] for joints in self.arms)
            ahead = np.repeat(unit(np.cross(across, trunk))[:, None], 2, axis=1)
            found["elbows"] = -ELBOWS * _bent(shoulder, elbow, wrist, ahead)
        return found


def _bent(start: FloatArray, middle: FloatArray, end: FloatArray, ahead: FloatArray) -> float:
    """How far, from -1 to 1, limbs ``(F, 2, 3)`` are bent ahead on average."""
    line = end - start
    along = np.sum((middle - start) * line, axis=-1) / np.maximum(np.sum(line**2, axis=-1), 1e-18)
    off = middle - start - along[..., None] * line
    size = np.linalg.norm(middle - start, axis=-1) + np.linalg.norm(end - middle, axis=-1)
    share = np.sum(off * ahead, axis=-1) / np.maximum(size, 1e-12)
    return float(np.clip(np.mean(share) / CLEAR_BEND, -1.0, 1.0))
