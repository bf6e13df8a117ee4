"""Differences of poses with their derivatives, for estimators that linearise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga.arrays import FloatArray

__all__ = ["Between", "between", "component_sizes"]


class Between(NamedTuple):
    """Vectors ``(N, d)`` from bases to targets, derivatives ``(N, d, d)`` by small moves of each.

    The derivatives of plain components are ``(1, d, d)``, the same for all.
    """

    vector: FloatArray
    by_base: FloatArray
    by_target: FloatArray


def between(representation: Representation, base: FloatArray, target: FloatArray) -> Between:
    """Vectors from bases ``(N, D)`` to targets ``(N, D)``, with their derivatives."""
    vector = representation.local(target, base)
    return Between(vector, *representation.local_jacobians(vector))


def component_sizes(
    representation: Representation, count: int, rotation: float, translation: float, scale: float
) -> FloatArray:
    """Sizes ``(d,)`` of the components of a difference for sizes in rad, m and log scale.

    A small turn changes quaternion components by half of it, and so does a small shift the dual
    part of a dual quaternion near the origin (further off, components are larger than that).
    """
    (turning, shifting), (a_radian, a_metre) = representation.ends, representation.units
    sizes = np.full(count, scale)
    sizes[:turning], sizes[turning:shifting] = a_radian * rotation, a_metre * translation
    return sizes
