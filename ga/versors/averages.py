"""Weighted averages of versors: `blend`, which is fast, and `mean`, the mean on the group.

The blend is the sum of coefficients, projected back to a versor. Of each versor's two signs the
one nearer to the first versor is taken, so every one is blended the short way from it. For rigid
motors this is dual quaternion linear blending (Kavan, Collins, Zara, O'Sullivan,
"Skinning with dual quaternions", 2007): between two, the screw's own path at a speed
that is only nearly even. Moving all versors from the left or from the right moves the blend with
them; the order of the versors matters only through which comes first.

The mean is the versor from which the weighted logarithms to all others cancel,
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

from motorcade.ga.arrays import FloatArray, broadcast_batch, checked_floats, checked_positive
from motorcade.ga.versors.versor import Versor

V = TypeVar("V", bound=Versor)

# A sum this much shorter than its terms has lost its direction to rounding.
_CANCELLED = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-5}
_MAX_STEPS = 100


def _checked_weights(what: str, versors: Versor, weights: ArrayLike) -> FloatArray:
    """Weights ``(*, K)`` for versors ``(*, K)``, broadcast over the batch in front.

    Raises ValueError: no last dimension to blend over, none to blend, another number of weights,
    NaN or infinity, batches that do not broadcast.
    """
    if not versors.shape or versors.shape[-1] == 0:
        raise ValueError(
            f"{what}(versors): expected shape (*, K) with K >= 1 versors to combine, "
            f"got {versors.shape}"
        )
    values = checked_floats(weights, f"{what}(weights)", ())
    if values.ndim == 0 or values.shape[-1] != versors.shape[-1]:
        raise ValueError(
            f"{what}(weights): expected shape (*, {versors.shape[-1]}), one for each versor, "
            f"got {values.shape}"
        )
    shape = broadcast_batch(f"{what}(versors, weights)", versors.shape, values.shape)
    return np.broadcast_to(values, shape)


def blend(versors: V, weights: ArrayLike) -> V:
    """Blend versors ``(*, K)`` with weights ``(*, K)`` to versors ``(*)``.

    Weights need not sum to one: only their ratios count. Negative ones extrapolate. Sums are
    taken in float64, the blend has the versors' precision.

    Raises:
        ValueError: as `_checked_weights`, or versors that cancel: all weights zero, or motions so
            far apart that nothing lies between them.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, blend
        >>> poses = Motor.from_translation([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
        >>> np.round(blend(poses, [0.75, 0.25]).translation_m, 6) + 0.0
        array([1., 0., 0.])
    """
    share = _checked_weights("blend", versors, weights)
    values = np.asarray(versors.coefficients, dtype=np.float64)
    summed = type(versors)._kernels.weighted_sum(values, share)
    total, bulk = summed[..., :-1], summed[..., -1]
    left = np.max(np.abs(total[..., :4]), axis=-1)
    lost = int(np.count_nonzero(left <= _CANCELLED[versors.dtype] * bulk))
    if lost:
        raise ValueError(
            "blend(versors, weights): expected a sum with a direction, got "
            f"{lost} in which the versors cancel"
        )
    return type(versors).normalize(total).astype(versors.dtype)


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
    checked_positive(tolerance, "mean(tolerance)")
    share = _shares(versors, weights)
    kind = type(versors)
    values = np.asarray(versors.coefficients, dtype=np.float64)
    everyone = np.broadcast_to(values, (*share.shape, values.shape[-1]))
    heaviest = np.argmax(share, axis=-1)[..., None, None]
    middle = kind._trusted(np.take_along_axis(everyone, heaviest, axis=-2)[..., 0, :])
    allowed = tolerance * _rounding_scale(everyone)
    largest = np.inf
    for _ in range(_MAX_STEPS):
        step = kind._kernels.weighted_local(middle.coefficients, everyone, share)
        middle = middle.retract(step)
        length = 0.5 * np.max(np.abs(step), axis=-1)  # a twist is twice its logarithm
        if np.all(length <= allowed):
            return middle.astype(versors.dtype)
        largest = float(np.max(length / allowed)) * tolerance
    raise ValueError(
        f"mean(versors): expected rotations close enough to have one mean, got steps of "
        f"{largest:.3g} after {_MAX_STEPS} rounds where {tolerance:g} was asked"
    )


def _shares(versors: Versor, weights: ArrayLike | None) -> FloatArray:
    """Weights that sum to one over the last dimension."""
    values = _checked_weights("mean", versors, np.ones(versors.shape[-1:]) if weights is None
                             else weights)  # fmt: skip
    if np.any(values < 0.0):
        raise ValueError(
            f"mean(weights): expected weights >= 0, got {float(np.min(values)):g}; "
            "interpolate or blend extrapolates"
        )
    largest = np.max(values, axis=-1, keepdims=True)
    if not np.all(largest > 0.0):
        raise ValueError("mean(weights): expected a positive weight in each set, got all zero")
    scaled = values / largest
    share: FloatArray = scaled / np.sum(scaled, axis=-1, keepdims=True)
    return share


def _rounding_scale(coefficients: FloatArray) -> FloatArray:
    """Size ``(*)`` of products of the versors, hence of the rounding left in their logarithms."""
    rotor = np.max(np.abs(coefficients[..., :4]), axis=(-1, -2), initial=1.0)
    whole = np.max(np.abs(coefficients), axis=(-1, -2), initial=1.0)
    scale: FloatArray = rotor * whole
    return scale
