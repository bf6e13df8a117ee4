"""Morph targets: other places for some vertices of a mesh, mixed in by weights.

A face smiles by adding a share of what lies between its rest and a smile. Weights act on the rest
pose, before joints carry the vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.vectors import UP, unit
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen


@dataclass(frozen=True, eq=False)
class MorphTarget:
    """What one weight adds to a mesh in its rest pose.

    Attributes:
        name: what it is called; names may repeat.
        rows: (R,) different vertex numbers.
        positions: (R, 3) m, added in full at weight 1.
        normals: (R, 3), added to unit normals before these are made unit again.
        weight: at rest.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity.

    >>> import numpy as np
    >>> from motorcade.animation.morphs import MorphTarget
    >>> MorphTarget("smile", np.array([3, 8]), np.ones((2, 3)), np.zeros((2, 3))).weight
    0.0
    """

    name: str
    rows: IntArray
    positions: FloatArray
    normals: FloatArray
    weight: float = 0.0

    def __post_init__(self) -> None:
        for name in ("positions", "normals"):
            values = checked_floats(getattr(self, name), f"MorphTarget.{name}", (3,))
            if values.shape != (len(self.rows), 3):
                raise ValueError(
                    f"MorphTarget.{name}: expected shape ({len(self.rows)}, 3), got {values.shape}"
                )
            object.__setattr__(self, name, frozen(values))


@dataclass(frozen=True, eq=False)
class MorphTrack:
    """Weights of W targets over time, on straight lines between its times.

    Attributes:
        time_s: (K,) strictly increasing, on the clock of its clip.
        weights: (K, W).

    Raises:
        ValueError: times that do not increase, another number of rows, NaN or infinity.

    >>> import numpy as np
    >>> from motorcade.animation.morphs import MorphTrack
    >>> track = MorphTrack(np.array([0.0, 1.0]), np.array([[0.0], [0.8]]))
    >>> track.at([0.5, 7.0])
    array([[0.4],
           [0.8]])
    """

    time_s: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        times = checked_floats(self.time_s, "MorphTrack.time_s", ())
        weights = np.asarray(self.weights, dtype=np.float64)
        if times.ndim != 1 or not times.size or np.any(np.diff(times) <= 0.0):
            raise ValueError(
                f"MorphTrack.time_s: expected (K,) strictly increasing seconds, got {times.shape}"
            )
        if weights.ndim != 2 or len(weights) != len(times) or not np.all(np.isfinite(weights)):
            raise ValueError(
                f"MorphTrack.weights: expected finite numbers ({len(times)}, W), got "
                f"{weights.shape}"
            )
        object.__setattr__(self, "time_s", frozen(times))
        object.__setattr__(self, "weights", frozen(weights))

    def at(self, time_s: ArrayLike) -> FloatArray:
        """Weights (*, W) at times (*); the first and last are held outside of the track."""
        wanted = checked_floats(time_s, "MorphTrack.at(time_s)", ())
        columns = [np.interp(wanted, self.time_s, one) for one in self.weights.T]
        return np.stack(columns, axis=-1) if columns else np.zeros((*wanted.shape, 0))


def morphed(
    vertices: FloatArray,
    normals: FloatArray,
    targets: tuple[MorphTarget, ...],
    weights: ArrayLike | None = None,
) -> tuple[FloatArray, FloatArray]:
    """A mesh in its rest pose with targets mixed in.

    Args:
        vertices: (V, 3) m.
        normals: (V, 3) unit.
        targets: W of them.
        weights: (W,); by default those at rest.

    Returns:
        vertices (V, 3) and unit normals (V, 3).

    Raises:
        ValueError: another number of weights.

    >>> import numpy as np
    >>> from motorcade.animation.morphs import MorphTarget, morphed
    >>> raise_it = MorphTarget("up", np.array([1]), np.array([[0, 0, 2.0]]), np.zeros((1, 3)))
    >>> normals = np.tile([0, 0, 1.0], (2, 1))
    >>> morphed(np.zeros((2, 3)), normals, (raise_it,), [0.25])[0]
    array([[0. , 0. , 0. ],
           [0. , 0. , 0.5]])
    """
    mixed = [one.weight for one in targets] if weights is None else weights
    shares = checked_floats(mixed, "morphed(weights)", ())
    if shares.shape != (len(targets),):
        raise ValueError(f"morphed(weights): expected {len(targets)}, got shape {shares.shape}")
    if not shares.any():
        return vertices, normals
    places, facing = vertices.copy(), normals.copy()
    for target, share in zip(targets, shares.tolist(), strict=True):
        if share:
            places[target.rows] += share * target.positions
            facing[target.rows] += share * target.normals
    return places, unit(facing, UP)
