"""What the blends must come to, by scipy's rotations and rigid transforms."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

__all__ = ["blended_matrices"]


def blended_matrices(path: str, first: Motor, second: Motor, fraction: float) -> FloatArray:
    """The matrices ``(joints, 3, 4)`` of two poses blended.

    `path` is ``slerp`` (turns along the shortest arc, translations mixed), ``screw`` (turns and
    translations along the screw) or ``linear`` (unit dual quaternions mixed the short way round and
    made unit again).
    """
    from scipy.spatial.transform import RigidTransform

    a, b = (RigidTransform.from_matrix(poses.as_matrix()) for poses in (first, second))
    if path == "screw":
        blended = a * RigidTransform.from_exp_coords(fraction * (a.inv() * b).as_exp_coords())
    elif path == "linear":
        one, other = (transform.as_dual_quat(scalar_first=True) for transform in (a, b))
        sign = np.where(np.sum(one[:, :4] * other[:, :4], axis=1, keepdims=True) < 0.0, -1.0, 1.0)
        mixed = (1.0 - fraction) * one + fraction * sign * other
        blended = RigidTransform.from_dual_quat(mixed, scalar_first=True)
    else:
        turn = (a.rotation.inv() * b.rotation).as_rotvec()
        rotation = a.rotation * type(a.rotation).from_rotvec(fraction * turn)
        moved = (1.0 - fraction) * a.translation + fraction * b.translation
        blended = RigidTransform.from_components(moved, rotation)
    return np.asarray(blended.as_matrix()[:, :3])
