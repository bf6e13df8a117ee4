"""One segment of frames resolved: cameras, how markers hang, which candidate is true.

Where a camera looks is put to the vote: a marker seen before and now offers four rotations of the
camera, of which at most one is true. The true ones of all markers agree; the false ones scatter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.orientations import (
    Orientations,
    seeded,
    settle,
    updated,
    weighed,
)
from motorcade.tracking.markers.disambiguate.states import (
    Chains,
    chain_cost,
    chain_probabilities,
    chains_of,
    forward_messages,
    most_probable,
)
from motorcade.tracking.markers.disambiguate.window import Memory, Window

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


@dataclass(frozen=True, eq=False)
class Solution:
    """What a window says, given the memory.

    Args:
        window, before: what it was made from; `before` holds the orientations as remembered.
        orientations: of cameras and markers.
        chains: the costs that were weighed.
        choice: ``(N,)`` candidate of each observation in the most probable sequence.
        candidates: ``(N, 2)`` probability of either candidate.
    """

    window: Window
    before: Orientations
    orientations: Orientations
    chains: Chains
    choice: IntArray
    candidates: FloatArray

    @property
    def cost(self) -> float:
        """What all evidence says against these orientations, nats."""
        return float(chain_cost(self.chains.first, self.chains.unary, self.chains.steps).sum())


def solve(window: Window, cameras: Rotor, memory: Memory, rounds: int) -> Solution:
    """Settle the orientations, then find the most probable states of every marker."""
    before = seeded(window, cameras, memory)
    orientations = settle(window, before, memory, rounds)
    chains = chains_of(window, orientations, memory)
    path = most_probable(chains.first, chains.unary, chains.steps)
    states = chain_probabilities(chains.first, chains.unary, chains.steps)
    own = (window.marker, chains.row)
    both = states[own].reshape(len(chains.row), -1, 2).sum(axis=1)
    return Solution(window, before, orientations, chains, path[own] % 2, both)


class Recent:
    """Where each marker stood when it was last seen, for the vote on the next frame."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[FloatArray, FloatArray]] = {}

    def see(self, window: Window, world_R_camera: Rotor, against: FloatArray) -> None:
        """Take in a frame's observations, with what speaks against their candidates ``(n, 2)``."""
        turned = (world_R_camera.reshape(1, 1) @ window.camera_R_marker).coefficients
        for marker, rotors, nats in zip(
            window.observations.marker_ids.tolist(), turned, against, strict=True
        ):
            self._seen[marker] = (rotors, nats)

    def vote(self, window: Window, last: Rotor, elapsed_s: float) -> Rotor:
        """The camera's orientation in a new frame; the last one where no marker is known."""
        ids = window.observations.marker_ids.tolist()
        known = [row for row, marker in enumerate(ids) if marker in self._seen]
        if not known:
            return last
        last_seen = [self._seen[ids[row]] for row in known]
        before = Rotor(np.stack([rotors for rotors, _ in last_seen]))
        against = np.stack([nats for _, nats in last_seen])
        now = window.camera_R_marker[known]
        return vote(before, against, now, window.evidence[known], last, elapsed_s)


def remembered(solution: Solution, memory: Memory) -> Memory:
    """The memory with the first frame of the solution's window taken in."""
    window, chains = solution.window, solution.chains
    rows = window.observations.of_frame(0)
    if len(rows) == 0:
        return memory
    marker = window.marker[rows]
    markers, information = _marker_of_first_frame(solution, rows)
    message = forward_messages(chains.first, chains.unary, chains.steps)[marker, 0]
    camera = solution.orientations.world_R_camera[:1]
    axes = camera.as_matrix()[:, None]
    fresh = Memory(
        window.marker_ids[marker],
        markers,
        information,
        message,
        np.full(len(rows), window.observations.time_ns[0]),
        camera[:, None] @ window.camera_R_marker[rows],
        axes @ window.covariance[rows] @ axes.swapaxes(-1, -2),
    )
    return _merged(memory, fresh)


def _marker_of_first_frame(solution: Solution, rows: IntArray) -> tuple[Rotor, FloatArray]:
    """Orientations and information as they were remembered, with one frame's observations added."""
    window, orientations = solution.window, solution.orientations
    marker = window.marker[rows]
    settled = orientations.world_R_marker[marker]
    known = solution.before.world_R_marker[marker]
    prior = solution.before.information[marker]
    vector, half = window.excess(orientations.world_R_camera, orientations.world_R_marker)
    vector, half = vector[rows], half[rows]
    axes = orientations.world_R_camera[:1].as_matrix()[0]
    seen = axes @ window.information[rows] @ axes.T
    weight, _ = weighed(half, window.evidence[rows])
    each = np.arange(len(rows))
    return updated(settled, known, prior, each, weight, seen, vector @ axes.T)


def _merged(old: Memory, fresh: Memory) -> Memory:
    """The fresh rows, and the old ones of other markers."""
    stay = ~np.isin(old.marker_ids, fresh.marker_ids)
    ids = np.concatenate([old.marker_ids[stay], fresh.marker_ids])
    order = np.argsort(ids)

    def joined(a: FloatArray, b: FloatArray) -> FloatArray:
        both: FloatArray = np.concatenate([a[stay], b])[order]
        return both

    return Memory(
        ids[order],
        Rotor(joined(old.world_R_marker.coefficients, fresh.world_R_marker.coefficients)),
        joined(old.information, fresh.information),
        joined(old.message, fresh.message),
        np.concatenate([old.last_ns[stay], fresh.last_ns])[order],
        Rotor(joined(old.last_R.coefficients, fresh.last_R.coefficients)),
        joined(old.last_covariance, fresh.last_covariance),
    )
