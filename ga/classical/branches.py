"""Branches of Euler angles: of all triples that are one rotation, those that lie near others.

Angles in radians, ``(*, 3)``, intrinsic, in the order of their sequence; see
`motorcade.ga.versors.euler_angles` for how they are converted.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.versors.euler_angles import LOCKED, axes_of


def nearest_branch(angles_rad: ArrayLike, reference_rad: ArrayLike) -> FloatArray:
    """Angles ``(*)`` plus the multiples of 2π that bring each within π of its reference.

    The difference of two angles is wrapped by the reference 0.

    Raises:
        ValueError: NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import nearest_branch
        >>> np.rad2deg(nearest_branch(np.deg2rad([-170.0, 20.0]), np.deg2rad([175.0, 10.0])))
        array([190.,  20.])
    """
    angles = checked_floats(angles_rad, "angles_rad", ())
    reference = checked_floats(reference_rad, "reference_rad", ())
    nearest: FloatArray = angles + 2.0 * np.pi * np.round((reference - angles) / (2.0 * np.pi))
    return nearest


def nearest_euler(
    angles_rad: ArrayLike, reference_rad: ArrayLike, sequence: str = "xyz"
) -> FloatArray:
    """Of all triples ``(*, 3)`` that are one rotation, those nearest to their references.

    Angles may turn by 2π, and there is a twin: ``(a + π, π - b, c + π)``, of sequences that end as
    they began ``(a + π, -b, c + π)``. What is nearest is the triple as a whole. At gimbal lock one
    of the first and third angle is free, and both move by the same amount.

    Args:
        angles_rad: in the order of the sequence, intrinsic.
        reference_rad: in any branch; batches broadcast.
        sequence: see `motorcade.ga.versors.euler_angles`.

    Raises:
        ValueError: an unknown sequence, wrong last dimension, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import nearest_euler
        >>> over = np.deg2rad([-180.0, 85.0, -180.0])  # a pitch that went on from 88 to 95
        >>> np.rad2deg(nearest_euler(over, np.deg2rad([0.0, 88.0, 0.0]))).round(6) + 0.0
        array([ 0., 95.,  0.])
    """
    angles = checked_floats(angles_rad, "angles_rad", (3,))
    reference = checked_floats(reference_rad, "reference_rad", (3,))
    branches = (angles, _twin(angles, sequence))
    own, twin = (nearest_branch(one, reference) for one in branches)
    far, near = (np.sum((one - reference) ** 2, axis=-1, keepdims=True) for one in (own, twin))
    nearest = np.where(near < far, twin, own)
    way = _lock_side(nearest[..., 1], sequence)
    if not np.any(way):
        return nearest
    # Only the first angle plus or minus the third is known there: both go half of the way.
    apart = nearest - reference
    half = 0.5 * nearest_branch(apart[..., 0] + way * apart[..., 2], 0.0)
    shared = reference + np.stack([half, apart[..., 1], way * half], axis=-1)
    return np.where(way[..., None] != 0.0, shared, nearest)


def follow_euler(angles_rad: ArrayLike, sequence: str = "xyz") -> FloatArray:
    """Angles ``(N, 3)`` of a path, each triple the nearest to the one before: see `nearest_euler`.

    The first stays as it is. Near gimbal lock angles turn fast still, and their noise with them.

    Raises:
        ValueError: an unknown sequence, angles of another shape, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Rotor
        >>> from motorcade.ga.classical import follow_euler
        >>> pitched = np.deg2rad([[0.0, 80.0, 0.0], [0.0, 100.0, 0.0], [0.0, 200.0, 0.0]])
        >>> np.rad2deg(follow_euler(Rotor.from_euler(pitched).as_euler())).round(6) + 0.0
        array([[  0.,  80.,   0.],
               [  0., 100.,   0.],
               [  0., 200.,   0.]])
    """
    angles = checked_floats(angles_rad, "angles_rad", (3,))
    if angles.ndim != 2:
        raise ValueError(f"angles_rad: expected (N, 3), got shape {angles.shape}")
    side = _lock_side(angles[:, 1], sequence)
    if len(angles) < 2:
        return angles.copy()
    starts = [1, *(1 + np.flatnonzero(np.diff(side[1:])) + 1).tolist(), len(angles)]
    made = angles.copy()
    for start, stop in pairwise(starts):
        last, given = made[start - 1], angles[start:stop]
        if side[start] == 0.0:
            made[start:stop] = _followed(last, given, sequence)
        else:
            made[start:stop] = _locked(last, given, float(side[start]))
    return made


def _followed(last: FloatArray, angles: FloatArray, sequence: str) -> FloatArray:
    """Triples ``(N, 3)`` after `last`, none at gimbal lock."""
    # Twins of two triples are as far apart as these: sides and turns depend on neighbours alone.
    whole = np.concatenate([last[None], angles])
    twin = _twin(whole, sequence)
    own, other = (nearest_branch(one[1:] - whole[:-1], 0.0) for one in (whole, twin))
    changes = np.sum(other**2, axis=-1) < np.sum(own**2, axis=-1)
    sides = np.cumsum(np.concatenate([np.zeros(1, dtype=np.bool_), changes])) % 2 == 1
    sided = np.where(sides[:, None], twin, whole)
    turns = np.cumsum(np.round((sided[:-1] - sided[1:]) / (2.0 * np.pi)), axis=0)
    followed: FloatArray = sided[1:] + 2.0 * np.pi * turns
    return followed


def _locked(last: FloatArray, angles: FloatArray, way: float) -> FloatArray:
    """Triples ``(N, 3)`` after `last`, all at a lock: a + `way` c is known, a - `way` c stays."""
    whole = np.concatenate([last[None], angles])
    known = whole[:, 0] + way * whole[:, 2]
    half = 0.5 * np.cumsum(nearest_branch(np.diff(known), 0.0))
    middle = nearest_branch(angles[:, 1], last[1])
    return np.stack([last[0] + half, middle, last[2] + way * half], axis=-1)


def _is_proper(sequence: str) -> bool:
    """Whether a sequence ends around the axis that it began with; an unknown one is refused."""
    axes_of(sequence)
    return sequence[0] == sequence[2]


def _lock_side(middle_rad: FloatArray, sequence: str) -> FloatArray:
    """Sign s of the a + s c that alone is known at gimbal lock; 0 of triples that are not there."""
    _, _, _, cyclic = axes_of(sequence)
    sine, cosine = np.sin(middle_rad), np.cos(middle_rad)
    lever, way = (sine, cosine) if _is_proper(sequence) else (cosine, cyclic * sine)
    side: FloatArray = np.where(np.abs(lever) <= 2.0 * LOCKED, np.sign(way), 0.0)
    return side


def _twin(angles: FloatArray, sequence: str) -> FloatArray:
    """The other triples ``(*, 3)`` of the same rotations, but for whole turns."""
    middle = -angles[..., 1] if _is_proper(sequence) else np.pi - angles[..., 1]
    return np.stack([angles[..., 0] + np.pi, middle, angles[..., 2] + np.pi], axis=-1)
