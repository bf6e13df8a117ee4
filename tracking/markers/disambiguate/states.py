"""A marker's states over time: still in one of its orientations, or being moved.

State ``2 h + c`` is "still, orientation h, candidate c is the true one"; the last two are "moved,
candidate c". For a still marker the cost is the rotation from its candidate to the orientation; for
a moved one it is the rotation from one observation to the next. Both are densities of the same
noise, so that neither is cheaper for being vaguer.

Sequences of states in chains are found by dynamic programming. Costs are negative log likelihoods.
``first`` ``(*, S)`` is what it costs to begin in a state, ``unary`` ``(*, T, S)`` what the evidence
at each step says against it, ``steps`` ``(*, T - 1, S, S)`` what going from one state (second to
last axis) to the next (last) costs; infinity forbids. Sources: Viterbi 1967; Rabiner 1989 (forward
and backward messages).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.orientations import Orientations
from motorcade.tracking.markers.disambiguate.window import MODES, Memory, Window, misfit

STATES = 2 * MODES + 2
_STILL = 2 * MODES
# One in a hundred thousand observations begins or ends a move, in nats; so fast a hand turns them.
_CHANGE = 12.0
_TURN_RAD_S = 1.0
# Markers on one board or wall are parallel to this much.
_PARALLEL_RAD = np.radians(3.0)
_NORMAL = np.array([0.0, 0.0, 1.0])


def most_probable(first: FloatArray, unary: FloatArray, steps: FloatArray) -> IntArray:
    """The sequence ``(*, T)`` of least total cost; of equal ones that of lower state numbers.

    Raises:
        ValueError: shapes that do not agree.

    >>> import numpy as np
    >>> from motorcade.tracking.markers.disambiguate.states import most_probable
    >>> against = np.array([[0.0, 3.0], [1.0, 0.5], [0.0, 3.0]])  # three steps, two states
    >>> change = np.array([[0.0, 2.0], [2.0, 0.0]])
    >>> most_probable(np.zeros(2), against, np.stack([change, change]))
    array([0, 0, 0])
    """
    count = _checked(first, unary, steps)
    cost = first + unary[..., 0, :]
    came_from = []
    for step in range(1, count):
        reached = cost[..., :, None] + steps[..., step - 1, :, :]
        came_from.append(np.argmin(reached, axis=-2))
        cost = np.min(reached, axis=-2) + unary[..., step, :]
    state = np.argmin(cost, axis=-1)
    path = [state]
    for back in reversed(came_from):
        state = np.take_along_axis(back, state[..., None], axis=-1)[..., 0]
        path.append(state)
    return np.stack(path[::-1], axis=-1)


def forward_messages(first: FloatArray, unary: FloatArray, steps: FloatArray) -> FloatArray:
    """Cost ``(*, T, S)`` of each state given the evidence up to its own step; least cost 0.

    Raises:
        ValueError: shapes that do not agree.
    """
    count = _checked(first, unary, steps)
    messages = [_from_zero(first + unary[..., 0, :])]
    for step in range(1, count):
        reached = messages[-1][..., :, None] + steps[..., step - 1, :, :]
        messages.append(_from_zero(_soft_minimum(reached, -2) + unary[..., step, :]))
    return np.stack(messages, axis=-2)


def chain_cost(first: FloatArray, unary: FloatArray, steps: FloatArray) -> FloatArray:
    """What all evidence says against the chain ``(*)``: ``-log`` of the sum over all sequences.

    Raises:
        ValueError: shapes that do not agree.
    """
    count = _checked(first, unary, steps)
    cost = first + unary[..., 0, :]
    for step in range(1, count):
        reached = cost[..., :, None] + steps[..., step - 1, :, :]
        cost = _soft_minimum(reached, -2) + unary[..., step, :]
    return _soft_minimum(cost, -1)


def chain_probabilities(first: FloatArray, unary: FloatArray, steps: FloatArray) -> FloatArray:
    """Probability ``(*, T, S)`` of each state given the evidence at all steps.

    Raises:
        ValueError: shapes that do not agree.
    """
    count = _checked(first, unary, steps)
    forward = forward_messages(first, unary, steps)
    backward = np.zeros_like(forward[..., 0, :])
    marginals = [forward[..., -1, :]]
    for step in range(count - 1, 0, -1):
        ahead = (backward + unary[..., step, :])[..., None, :] + steps[..., step - 1, :, :]
        backward = _from_zero(_soft_minimum(ahead, -1))
        marginals.append(forward[..., step - 1, :] + backward)
    costs = _from_zero(np.stack(marginals[::-1], axis=-2))
    likelihood: FloatArray = np.exp(-costs)
    likelihood /= likelihood.sum(axis=-1, keepdims=True)
    return likelihood


def _soft_minimum(costs: FloatArray, axis: int) -> FloatArray:
    """``-log Σ exp(-cost)``; all of it forbidden stays infinite."""
    least = np.min(costs, axis=axis, keepdims=True)
    least = np.where(np.isfinite(least), least, 0.0)
    with np.errstate(divide="ignore"):
        soft = least - np.log(np.sum(np.exp(least - costs), axis=axis, keepdims=True))
    squeezed: FloatArray = np.squeeze(soft, axis=axis)
    return squeezed


def _from_zero(costs: FloatArray) -> FloatArray:
    """The same costs less the least one, so that long chains neither over- nor underflow."""
    reduced: FloatArray = costs - np.min(costs, axis=-1, keepdims=True)
    return reduced


def _checked(first: FloatArray, unary: FloatArray, steps: FloatArray) -> int:
    """The number of steps.

    Raises:
        ValueError: shapes that do not agree.
    """
    *batch, count, states = unary.shape
    expected = ((*batch, states), (*batch, count - 1, states, states))
    if count == 0 or (first.shape, steps.shape) != expected:
        raise ValueError(
            f"first, steps: expected {expected[0]} and {expected[1]} for unary {unary.shape}, "
            f"got {first.shape} and {steps.shape}"
        )
    return int(count)


@dataclass(frozen=True, eq=False)
class Chains:
    """Costs of the states of K markers at up to T observations each, ready for `most_probable`.

    Steps past a marker's last observation cost nothing and change nothing.

    Args:
        row: ``(N,)`` place of each observation in its marker's chain.
        first, unary, steps: see the top.
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
    """Place of each observation among those of its marker."""
    order = np.argsort(window.marker, kind="stable")
    starts = np.searchsorted(window.marker[order], window.marker[order])
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order)) - starts
    return places


def _costs(
    window: Window, orientations: Orientations, memory: Memory, row: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States ``(N, S)``, steps into each observation ``(N, S, S)``, first states ``(K, S)``."""
    _, half = window.excess(orientations.world_R_camera, orientations.world_R_marker)
    known = memory.rows_of(window.marker_ids)[window.marker]
    fresh = (row == 0) & (known < 0)
    against = window.evidence.copy()
    against[fresh] += _against_company(window, orientations, memory)[fresh]
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
    again = (row == 0) & (known >= 0)
    before = memory.message[known[again], :, None] + arrivals[again]
    first[window.marker[again]] = -np.logaddexp.reduce(-before, axis=-2)
    return costs, arrivals, first


def _against_company(window: Window, orientations: Orientations, memory: Memory) -> FloatArray:
    """What speaks against each candidate ``(N, 2)`` of a marker never seen before, nats.

    Markers hang on boards, walls and boxes, so that many share a normal. The share of those in
    memory that share theirs with another one is how probably a new marker does so too; its normal
    is then one of theirs, and any direction otherwise.
    """
    normals = memory.normals(_STILL)
    if len(normals) < 2:
        return np.zeros((len(window.marker), 2))
    apart = np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)) + 4.0 * np.eye(len(normals))
    share = np.count_nonzero(apart.min(axis=1) < 2.0 * _PARALLEL_RAD) / (len(normals) + 1.0)
    cameras = orientations.world_R_camera[window.frame]
    seen = (cameras[:, None] @ window.camera_R_marker).apply(_NORMAL)
    apart = np.arccos(np.clip(seen @ normals.T, -1.0, 1.0))
    variance = _PARALLEL_RAD**2 + np.trace(window.covariance, axis1=-2, axis2=-1) / 3.0
    near = np.exp(-0.5 * apart**2 / variance[..., None]).mean(axis=-1) / variance
    cost: FloatArray = -np.log(1.0 - share + share * near)
    return cost


def _turning_costs(
    window: Window, orientations: Orientations, memory: Memory, row: IntArray
) -> FloatArray:
    """What turning from the observation before costs a marker that is moved, ``(N, 2, 2)``."""
    rotor, covariance, stamp = _previous(window, orientations, memory, row)
    cameras = orientations.world_R_camera[window.frame]
    axes = cameras.as_matrix()[:, None]
    turn = (cameras.inverse()[:, None] @ rotor)[:, :, None] @ window.camera_R_marker[
        :, None
    ].inverse()
    vector = turn.as_rotation_vector()
    elapsed_s = (window.observations.time_ns[window.frame] - stamp) * 1e-9
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
    """World orientation, its covariance and the stamp of the observation before each one.

    In the window or in memory; where there is none, the observation's own.
    """
    cameras = orientations.world_R_camera[window.frame]
    axes = cameras.as_matrix()[:, None]
    rotor = np.array((cameras[:, None] @ window.camera_R_marker).coefficients)
    covariance = axes @ window.covariance @ axes.swapaxes(-1, -2)
    stamp = window.observations.time_ns[window.frame]
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
