"""Fast weighted blend of versors: the sum of their coefficients, projected back to a versor.

Of each versor's two signs the one nearer to the first versor is taken, so every one is blended the
short way from it. For rigid motors this is dual quaternion linear blending (Kavan, Collins, Zara,
O'Sullivan, "Skinning with dual quaternions", 2007): between two, the screw's own path at a speed
that is only nearly even. Moving all versors from the left or from the right moves the blend with
them; the order of the versors matters only through which comes first.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.versors.batch import broadcast_batch
from motorcade.ga.versors.versor import Versor

__all__ = ["blend", "checked_weights"]

V = TypeVar("V", bound=Versor)

# A sum this much shorter than its terms has lost its direction to rounding.
_CANCELLED = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-5}


def checked_weights(what: str, versors: Versor, weights: ArrayLike) -> FloatArray:
    """Weights ``(*, K)`` for versors ``(*, K)``, broadcast over the batch in front.

    Raises:
        ValueError: no last dimension to blend over, none to blend, another number of weights, NaN
            or infinity, batches that do not broadcast.
    """
    if not versors.shape or versors.shape[-1] == 0:
        raise ValueError(
            f"{what}(versors): expected shape (*, K) with K >= 1 versors to combine, "
            f"got {versors.shape}"
        )
    given = checked_floats(weights, f"{what}(weights)", ())
    if given.ndim == 0 or given.shape[-1] != versors.shape[-1]:
        raise ValueError(
            f"{what}(weights): expected shape (*, {versors.shape[-1]}), one for each versor, "
            f"got {given.shape}"
        )
    shape = broadcast_batch(f"{what}(versors, weights)", versors.shape, given.shape)
    return np.broadcast_to(given, shape)


def blend(versors: V, weights: ArrayLike) -> V:
    """Blend versors ``(*, K)`` with weights ``(*, K)`` to versors ``(*)``.

    Weights need not sum to one: only their ratios count. Negative ones extrapolate. Sums are
    taken in float64, the blend has the versors' precision.

    Raises:
        ValueError: as `checked_weights`, or versors that cancel: all weights zero, or motions so
            far apart that nothing lies between them.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, blend
        >>> poses = Motor.from_translation([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
        >>> np.round(blend(poses, [0.75, 0.25]).translation_m, 6) + 0.0
        array([1., 0., 0.])
    """
    share = checked_weights("blend", versors, weights)
    given = np.asarray(versors.coefficients, dtype=np.float64)
    against = np.sum(given[..., :1, :4] * given[..., :4], axis=-1) < 0.0
    signed = np.where(against, -1.0, 1.0) * share
    total: FloatArray = np.einsum("...k,...kc->...c", signed, given)
    bulk = np.einsum("...k,...k->...", np.abs(share), np.max(np.abs(given[..., :4]), axis=-1))
    left = np.max(np.abs(total[..., :4]), axis=-1)
    lost = int(np.count_nonzero(left <= _CANCELLED[versors.dtype] * bulk))
    if lost:
        raise ValueError(
            "blend(versors, weights): expected a sum with a direction, got "
            f"{lost} in which the versors cancel"
        )
    return type(versors).normalize(total).astype(versors.dtype)
