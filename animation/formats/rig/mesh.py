"""Meshes made ready for skinning: influences cut to four, normals, all surfaces in one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.errors import expected
from motorcade.animation.formats.rig.values import RigSurface
from motorcade.animation.vectors import UP, unit
from motorcade.ga.arrays import FloatArray, IntArray

__all__ = ["Influences", "normals_of", "strongest_four"]

# A dropped share or a sum off by this much is worth telling.
TOLD_SHARE = 0.01


@dataclass(frozen=True, eq=False)
class Influences:
    """Up to four joints a vertex.

    Args:
        numbers: (V, 4) joints of the skin.
        weights: (V, 4) shares that sum to 1.
        notices: what was dropped or mended.
    """

    numbers: IntArray
    weights: FloatArray
    notices: tuple[str, ...]


def strongest_four(surface: RigSurface) -> Influences:
    """The four largest influences of each vertex, brought to a sum of 1.

    A vertex without any weight is given to the first joint of its skin, which a notice says.

    Raises:
        FormatError: weights that are negative, NaN or infinite.
    """
    numbers, weights = surface.influences, surface.weights
    if not np.isfinite(weights).all() or weights.min(initial=0.0) < 0.0:
        raise expected(f"weights of '{surface.name}'", "finite shares of 0 or more", "others")
    notices = []
    if weights.shape[1] > 4:
        order = np.argsort(-weights, axis=1, kind="stable")[:, :4]
        kept = np.take_along_axis(weights, order, axis=1)
        total = np.maximum(weights.sum(axis=1), 1e-30)
        lost = 1.0 - kept.sum(axis=1) / total
        if (total > 1e-20).any() and lost[total > 1e-20].max() > TOLD_SHARE:
            count = int(np.count_nonzero((lost > TOLD_SHARE) & (total > 1e-20)))
            notices.append(
                f"'{surface.name}': {count} vertices have more than four influences; up to "
                f"{100 * lost[total > 1e-20].max():.0f} % of their weight was left out"
            )
        numbers, weights = np.take_along_axis(numbers, order, axis=1), kept
    elif weights.shape[1] < 4:
        wanted = ((0, 0), (0, 4 - weights.shape[1]))
        numbers, weights = np.pad(numbers, wanted), np.pad(weights, wanted)
    total = weights.sum(axis=1, keepdims=True)
    bare = total[:, 0] <= 1e-12
    if bare.any():
        weights, numbers = weights.copy(), numbers.copy()
        weights[bare], numbers[bare] = (1.0, 0.0, 0.0, 0.0), 0
        total = weights.sum(axis=1, keepdims=True)
        notices.append(
            f"'{surface.name}': {np.count_nonzero(bare)} vertices without weights follow the "
            "first joint of their skin"
        )
    elif np.abs(total - 1.0).max() > TOLD_SHARE and surface.weights.shape[1] <= 4:
        notices.append(
            f"'{surface.name}': weights sum to {total.min():.3g} to {total.max():.3g}: divided "
            "by their sums"
        )
    shares = weights / total
    return Influences(np.where(shares > 0.0, numbers, 0), shares, tuple(notices))


def normals_of(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Smooth unit normals (V, 3): of all triangles around a place, by their areas.

    Vertices at the same place share a normal, so that seams of textures do not show. A vertex in
    no triangle, or in flat ones alone, gets +z.
    """
    _, places = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    places = places.reshape(-1)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    faces = np.cross(b - a, c - a)
    sums = np.zeros((int(places.max(initial=0)) + 1, 3))
    for corner in range(3):
        for axis in range(3):
            sums[:, axis] += np.bincount(
                places[triangles[:, corner]], faces[:, axis], minlength=len(sums)
            )
    return unit(sums[places], UP)
