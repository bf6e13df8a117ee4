"""One stretch of frames resolved: cameras, how markers hang, which candidate is true."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.chains import (
    chain_cost,
    chain_probabilities,
    forward_messages,
    most_probable,
)
from motorcade.tracking.markers.disambiguate.orientations import (
    Orientations,
    seeded,
    settle,
    updated,
    weighed,
)
from motorcade.tracking.markers.disambiguate.states import Chains, chains_of
from motorcade.tracking.markers.disambiguate.votes import vote
from motorcade.tracking.markers.disambiguate.window import Memory, Window

__all__ = ["Recent", "Solution", "remembered", "solve"]


@dataclass(frozen=True, eq=False)
class Solution:
    """What a window says, given the memory.

    Args:
        window, before: what it was made from; `before` holds the orientations as remembered.
        orientations: of cameras and markers.
        chains: the costs that were weighed.
        choice: ``(N,)`` candidate of each sighting in the most probable sequence.
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
        """Take in one frame's sightings, with what speaks against their candidates ``(n, 2)``."""
        turned = (world_R_camera.reshape(1, 1) @ window.camera_R_marker).coefficients
        for marker, rotors, nats in zip(
            window.sightings.marker_ids.tolist(), turned, against, strict=True
        ):
            self._seen[marker] = (rotors, nats)

    def vote(self, window: Window, last: Rotor, elapsed_s: float) -> Rotor:
        """The camera's orientation in a new frame; the last one where no marker is known."""
        ids = window.sightings.marker_ids.tolist()
        known = [row for row, marker in enumerate(ids) if marker in self._seen]
        if not known:
            return last
        found = [self._seen[ids[row]] for row in known]
        before = Rotor(np.stack([rotors for rotors, _ in found]))
        against = np.stack([nats for _, nats in found])
        now = window.camera_R_marker[known]
        return vote(before, against, now, window.evidence[known], last, elapsed_s)


def remembered(solution: Solution, memory: Memory) -> Memory:
    """The memory with the first frame of the solution's window taken in."""
    window, chains = solution.window, solution.chains
    rows = window.sightings.of_frame(0)
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
        np.full(len(rows), window.sightings.time_ns[0]),
        camera[:, None] @ window.camera_R_marker[rows],
        axes @ window.covariance[rows] @ axes.swapaxes(-1, -2),
    )
    return _merged(memory, fresh)


def _marker_of_first_frame(solution: Solution, rows: IntArray) -> tuple[Rotor, FloatArray]:
    """Orientations and information as they were remembered, with one frame's sightings added."""
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
