"""Where a camera looks, by vote: candidates of all markers against where these stood before.

A marker seen before and now offers four rotations of the camera, of which at most one is true. The
true ones of all markers agree; the false ones scatter.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["vote"]

# How far two true candidates of one marker disagree, whatever their noise.
_AGREEMENT_RAD = np.radians(5.0)
# A camera in the hand turns so fast; decides only where the votes are split.
_TURN_RAD_S = np.radians(60.0)
_WORST_TURN = 8.0
_LONE = 12.0  # what a marker that agrees with nobody costs, nats
_MOST_VOTERS = 40
_ROUNDS = 5


def vote(
    before: Rotor,
    evidence_before: FloatArray,
    now: Rotor,
    evidence_now: FloatArray,
    last: Rotor,
    elapsed_s: float,
) -> Rotor:
    """The camera's orientation in the world, by K markers.

    Args:
        before: Rotor ``(K, 2)``, world orientation of each marker by either earlier candidate.
        evidence_before: ``(K, 2)`` against those candidates, nats.
        now: Rotor ``(K, 2)``, orientation before the camera by either candidate.
        evidence_now: ``(K, 2)`` against those.
        last: one Rotor, the camera's orientation `elapsed_s` ago.
        elapsed_s: seconds, above zero.
    """
    against = evidence_before[:, :, None] + evidence_now[:, None, :]
    voters = np.argsort(-np.abs(evidence_now[:, 0] - evidence_now[:, 1]), kind="stable")
    voters = np.sort(voters[:_MOST_VOTERS])
    before, now, against = before[voters], now[voters], against[voters]
    proposed = (before[:, :, None] @ now[:, None, :].inverse()).reshape(-1)
    vector = _disagreement(proposed, before, now)
    half = 0.5 * np.sum(vector**2, axis=-1) / _AGREEMENT_RAD**2
    votes = np.minimum(half, _LONE) + against
    turned = (last.inverse() @ proposed).angle() / (_TURN_RAD_S * elapsed_s)
    cost = votes.min(axis=(-1, -2)).sum(axis=-1) + np.minimum(0.5 * turned**2, _WORST_TURN)
    best = proposed[int(np.argmin(cost))]
    for _ in range(_ROUNDS):
        vector = _disagreement(best.reshape(1), before, now)[0]
        half = 0.5 * np.sum(vector**2, axis=-1) / _AGREEMENT_RAD**2
        weight = np.exp(-(half + against))
        weight = weight / (weight.sum(axis=(-1, -2), keepdims=True) + np.exp(-_LONE))
        step = np.einsum("kac,kaci->i", weight, vector) / max(weight.sum(), np.exp(-_LONE))
        best = best @ Rotor.from_rotation_vector(step)
    return best


def _disagreement(world_R_camera: Rotor, before: Rotor, now: Rotor) -> FloatArray:
    """Rotation vectors ``(P, K, 2, 2, 3)``, camera axes: from each candidate to where it stood."""
    expected = world_R_camera.inverse()[:, None, None] @ before[None]
    turn = expected[..., None] @ now[None, :, None, :].inverse()
    return turn.as_rotation_vector()
