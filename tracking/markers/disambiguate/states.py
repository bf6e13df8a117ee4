"""A marker's states over time: hanging still in one of its orientations, or being moved.

State ``2 h + c`` is "still, orientation h, candidate c is the true one"; the last two are "moved,
candidate c". A marker that hangs still pays for what its candidate has to turn to fit the
orientation; one that is moved pays for what it turns from one sighting to the next. Both are
densities of the same noise, so that neither is the cheaper for being vaguer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.orientations import Orientations
from motorcade.tracking.markers.disambiguate.window import MODES, Memory, Window, misfit

__all__ = ["STATES", "Chains", "chains_of", "empty_memory"]

STATES = 2 * MODES + 2
_STILL = 2 * MODES
# One sighting in a hundred thousand begins or ends a move, in nats; a hand turns markers so fast.
_CHANGE = 12.0
_TURN_RAD_S = 1.0


@dataclass(frozen=True, eq=False)
class Chains:
    """Costs of the states of K markers at up to T sightings each, ready for `chains`.

    Steps past a marker's last sighting cost nothing and change nothing.

    Args:
        row: ``(N,)`` place of each sighting in its marker's chain.
        first, unary, steps: see `chains`.
    """

    row: IntArray
    first: FloatArray
    unary: FloatArray
    steps: FloatArray


def chains_of(window: Window, orientations: Orientations, memory: Memory) -> Chains:
    """The costs of all states."""
    count = len(window.marker_ids)
    row = _places(window)
    length = int(row.max()) + 1
    costs, arrivals, first = _costs(window, orientations, memory, row)
    unary = np.zeros((count, length, STATES))
    stay = np.where(np.eye(STATES, dtype=bool), 0.0, np.inf)
    steps = np.tile(stay, (count, length - 1, 1, 1))
    unary[window.marker, row] = costs
    later = row > 0
    steps[window.marker[later], row[later] - 1] = arrivals[later]
    return Chains(row, first, unary, steps)


def empty_memory() -> Memory:
    """Nothing seen so far."""
    none = np.zeros(0, np.int64)
    known = Rotor.identity((0, MODES)), np.zeros((0, MODES, 3, 3)), np.zeros((0, STATES))
    return Memory(none, *known, none, Rotor.identity((0, 2)), np.zeros((0, 2, 3, 3)))


def _places(window: Window) -> IntArray:
    """Place of each sighting among those of its marker."""
    order = np.argsort(window.marker, kind="stable")
    starts = np.searchsorted(window.marker[order], window.marker[order])
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order)) - starts
    return places


def _costs(
    window: Window, orientations: Orientations, memory: Memory, row: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States ``(N, S)``, steps into each sighting ``(N, S, S)``, first states ``(K, S)``."""
    _, half = window.excess(orientations.world_R_camera, orientations.world_R_marker)
    against = window.evidence
    still = against[:, None, :] + misfit(half)
    costs = np.concatenate([still.reshape(-1, _STILL), against], axis=-1)
    arrivals = np.full((len(costs), STATES, STATES), 2.0 * _CHANGE)
    for mode in range(MODES):
        own = slice(2 * mode, 2 * mode + 2)
        arrivals[:, own, own] = 0.0
    arrivals[:, :_STILL, _STILL:] = arrivals[:, _STILL:, :_STILL] = _CHANGE
    arrivals[:, _STILL:, _STILL:] = _turning_costs(window, orientations, memory, row)
    first = np.zeros((len(window.marker_ids), STATES))
    first[:, _STILL:] = _CHANGE
    known = memory.rows_of(window.marker_ids)[window.marker]
    again = (row == 0) & (known >= 0)
    before = memory.message[known[again], :, None] + arrivals[again]
    first[window.marker[again]] = -np.logaddexp.reduce(-before, axis=-2)
    return costs, arrivals, first


def _turning_costs(
    window: Window, orientations: Orientations, memory: Memory, row: IntArray
) -> FloatArray:
    """What turning from the sighting before costs a marker that is moved, ``(N, 2, 2)``."""
    rotor, covariance, stamp = _previous(window, orientations, memory, row)
    cameras = orientations.world_R_camera[window.frame]
    axes = cameras.as_matrix()[:, None]
    turn = (cameras.inverse()[:, None] @ rotor)[:, :, None] @ window.camera_R_marker[
        :, None
    ].inverse()
    vector = turn.as_rotation_vector()
    elapsed_s = (window.sightings.time_ns[window.frame] - stamp) * 1e-9
    seen = axes.swapaxes(-1, -2) @ covariance @ axes
    noise = seen[:, :, None] + window.covariance[:, None]
    noise = noise + ((_TURN_RAD_S * elapsed_s) ** 2)[:, None, None, None, None] * np.eye(3)
    half = 0.5 * np.einsum("naci,nacij,nacj->nac", vector, np.linalg.inv(noise), vector)
    vague = np.linalg.slogdet(noise)[1] - np.linalg.slogdet(window.covariance)[1][:, None]
    cost: FloatArray = misfit(half) + 0.5 * vague
    return cost


def _previous(
    window: Window, orientations: Orientations, memory: Memory, row: IntArray
) -> tuple[Rotor, FloatArray, IntArray]:
    """World orientation, its covariance and the stamp of the sighting before each one.

    In the window or in memory; where there is none, the sighting's own.
    """
    cameras = orientations.world_R_camera[window.frame]
    axes = cameras.as_matrix()[:, None]
    rotor = np.array((cameras[:, None] @ window.camera_R_marker).coefficients)
    covariance = axes @ window.covariance @ axes.swapaxes(-1, -2)
    stamp = window.sightings.time_ns[window.frame]
    order = np.argsort(window.marker, kind="stable")
    earlier = np.arange(len(order))
    later = row[order] > 0
    earlier[order[later]] = order[np.flatnonzero(later) - 1]
    rotor, covariance, stamp = rotor[earlier], covariance[earlier], stamp[earlier]
    known = memory.rows_of(window.marker_ids)[window.marker]
    again = (row == 0) & (known >= 0)
    rotor[again] = memory.last_R.coefficients[known[again]]
    covariance[again] = memory.last_covariance[known[again]]
    stamp[again] = memory.last_ns[known[again]]
    return Rotor(rotor), covariance, stamp
