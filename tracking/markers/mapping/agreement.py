"""Of many guesses at one motion, the one that most of the others agree with."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

__all__ = ["agreed"]

_AGREE_RAD = np.radians(10.0)
_MOST = 200


def agreed(motions: Motor, weight: FloatArray, reach_m: FloatArray) -> tuple[Motor, float]:
    """The guess with the most weight near it, and that weight.

    A choice, not a mean: guesses that are quite wrong, such as flipped poses, do not move it.

    Args:
        motions: Motor ``(n,)``; of more than 200, so many spread evenly are looked at.
        weight: ``(n,)``.
        reach_m: ``(n,)`` how far another may be from each guess to agree with it, beside 10° of
            turn.
    """
    chosen = np.linspace(0, len(weight) - 1, min(len(weight), _MOST)).astype(np.int64)
    motions = motions[chosen]
    apart = motions[:, None].inverse() @ motions[None, :]
    near = apart.rotor.angle() < _AGREE_RAD
    near &= np.linalg.norm(apart.translation_m, axis=-1) < reach_m[chosen][:, None]
    support = near @ weight[chosen]
    best = int(np.argmax(support))
    return motions[best], float(support[best])
