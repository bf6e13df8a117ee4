"""Most probable sequences and probabilities of states in chains, by dynamic programming.

Costs are negative log likelihoods. ``first`` ``(*, S)`` is what it costs to begin in a state,
``unary`` ``(*, T, S)`` what the evidence at each step says against it, ``steps`` ``(*, T - 1, S,
S)`` what going from one state (second to last axis) to the next (last) costs; infinity forbids.
Sources: Viterbi 1967; Rabiner 1989 (forward and backward messages).
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

__all__ = ["chain_cost", "chain_probabilities", "forward_messages", "most_probable"]


def most_probable(first: FloatArray, unary: FloatArray, steps: FloatArray) -> IntArray:
    """The sequence ``(*, T)`` of least total cost; of equal ones that of lower state numbers.

    Raises:
        ValueError: shapes that do not agree.

    >>> import numpy as np
    >>> from motorcade.tracking.markers.disambiguate import most_probable
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
    found = [forward[..., -1, :]]
    for step in range(count - 1, 0, -1):
        ahead = (backward + unary[..., step, :])[..., None, :] + steps[..., step - 1, :, :]
        backward = _from_zero(_soft_minimum(ahead, -1))
        found.append(forward[..., step - 1, :] + backward)
    costs = _from_zero(np.stack(found[::-1], axis=-2))
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
