"""Weighted mean on the group: the versor from which the weighted logarithms to all others cancel.

``Σ w_k log(~m x_k) = 0``: for rotations the Karcher mean (least sum of squared angles), for motions
with translation or growth the exponential barycentre, which moves with the versors whichever side
they are moved from and turns into the inverse's mean when they are inverted (Pennec, Arsigny,
"Exponential barycenters of the canonical Cartan connection and invariant means on Lie groups",
2013). It is unique where all rotations lie within half a turn of one another.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray
from motorcade.ga.versors.blend import checked_weights
from motorcade.ga.versors.versor import Versor

__all__ = ["mean"]

V = TypeVar("V", bound=Versor)

_MAX_STEPS = 100


def mean(versors: V, weights: ArrayLike | None = None, tolerance: float = 1e-12) -> V:
    """Mean of versors ``(*, K)``, with weights ``(*, K)`` or all alike, to versors ``(*)``.

    It is found in float64 and has the versors' precision.

    Args:
        versors: K motions of one type in the last batch dimension.
        weights: not negative, not all zero; only their ratios count.
        tolerance: the last step's largest logarithm coefficient (half radians, half metres),
            relative to the versors' own coefficients where those exceed 1.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, weights that are negative or all zero,
            a tolerance that is not positive, or rotations so far apart that the steps do not
            settle within 100.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Rotor, mean
        >>> turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.1], [0.0, 0.0, 0.5]])
        >>> np.round(mean(turns).as_rotation_vector(), 6) + 0.0
        array([0. , 0. , 0.3])
    """
    if not (np.isfinite(tolerance) and tolerance > 0.0):
        raise ValueError(f"mean(tolerance): expected a positive number, got {tolerance}")
    share = _shares(versors, weights)
    kind = type(versors)
    given = np.asarray(versors.coefficients, dtype=np.float64)
    everyone = kind._trusted(np.broadcast_to(given, (*share.shape, given.shape[-1])))
    heaviest = np.argmax(share, axis=-1)[..., None, None]
    middle = kind._trusted(np.take_along_axis(everyone.coefficients, heaviest, axis=-2)[..., 0, :])
    allowed = tolerance * _rounding_scale(everyone.coefficients)
    largest = np.inf
    for _ in range(_MAX_STEPS):
        logs = (middle.reshape(*middle.shape, 1).inverse() @ everyone).log()
        step = np.einsum("...k,...kc->...c", share, logs)
        middle = middle @ kind.exp(step)
        length = np.max(np.abs(step), axis=-1)
        if np.all(length <= allowed):
            return middle.astype(versors.dtype)
        largest = float(np.max(length / allowed)) * tolerance
    raise ValueError(
        f"mean(versors): expected rotations close enough to have one mean, got steps of "
        f"{largest:.3g} after {_MAX_STEPS} rounds where {tolerance:g} was asked"
    )


def _shares(versors: Versor, weights: ArrayLike | None) -> FloatArray:
    """Weights that sum to one over the last dimension."""
    given = checked_weights("mean", versors, np.ones(versors.shape[-1:]) if weights is None
                            else weights)  # fmt: skip
    if np.any(given < 0.0):
        raise ValueError(
            f"mean(weights): expected weights >= 0, got {float(np.min(given)):g}; "
            "interpolate or blend extrapolates"
        )
    largest = np.max(given, axis=-1, keepdims=True)
    if not np.all(largest > 0.0):
        raise ValueError("mean(weights): expected a positive weight in each set, got all zero")
    scaled = given / largest
    share: FloatArray = scaled / np.sum(scaled, axis=-1, keepdims=True)
    return share


def _rounding_scale(coefficients: FloatArray) -> FloatArray:
    """Size ``(*)`` of products of the versors, hence of the rounding left in their logarithms."""
    rotor = np.max(np.abs(coefficients[..., :4]), axis=(-1, -2), initial=1.0)
    whole = np.max(np.abs(coefficients), axis=(-1, -2), initial=1.0)
    scale: FloatArray = rotor * whole
    return scale
