"""Skinning in double precision: a mesh in a pose, or in a whole batch of poses, by four methods.

Each vertex is carried by the weighted sum of its joints' palette entries, taken to the nearest
motion. ``linear`` sums matrices, which shrinks a surface where its joints differ by a large turn
(an elbow that twists narrows like a sweet's wrapper). ``dual_quaternion`` and ``motor`` stay rigid,
and are one and the same by theory; they bulge a little where joints bend. ``similarity`` grows as
well. For one pose after another in real time see `Skinner`.
Sources: Magnenat-Thalmann, Laperrière, Thalmann (1988) for linear; Kavan, Collins, Zara, O'Sullivan
(2007) for dual quaternions, whose signs are taken from a vertex's heaviest joint.
"""

from __future__ import annotations

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.skin.palette import SkinMethod, palette
from motorcade.ga import Motor, Similarity, kernels
from motorcade.ga.arrays import FloatArray

__all__ = ["SKIN_KERNELS", "skin"]

SKIN_KERNELS: dict[SkinMethod, str] = {
    "linear": "carry_matrix",
    "dual_quaternion": "carry_dual_quaternion",
    "motor": "carry_motor",
    "similarity": "carry_similarity",
}
"""The generated kernel that carries a vertex by a method."""


def skin(
    character: Character, local_pose: Motor | Similarity, method: SkinMethod = "linear"
) -> tuple[FloatArray, FloatArray]:
    """Positions and normals of a character's mesh in a pose.

    Normals are turned with the surface and are unit; under ``linear`` that is exact only where a
    vertex is carried rigidly.

    Args:
        character: mesh, skeleton and weights.
        local_pose: Motor or Similarity ``(*, J)``, poses `parent_T_joint`.
        method: one of `SKIN_METHODS`.

    Returns:
        vertices ``(*, V, 3)`` in character space, metres, and unit normals ``(*, V, 3)``.

    Raises:
        ValueError: an unknown method, or a last dimension other than the number of joints.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton, skin
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> raised = Motor.from_translation([[0, 0, 0.5]])  # parent_T_joint
    >>> vertices, normals = skin(flag, raised)
    >>> vertices
    array([[0. , 0. , 0.5],
           [1. , 0. , 0.5],
           [0. , 0. , 2.5]])
    """
    entries, scale = palette(character.skeleton, local_pose, method)
    sums = _sums(character, entries, with_signs=method != "linear")
    rest = character.vertices
    if scale is not None:
        share = np.sum(scale[..., character.joints] * character.weights, axis=-1)
        rest = rest * share[..., None]
    skinned = np.empty((*sums.shape[:-1], 6))
    batch = sums.shape[:-1]
    kernels.function(SKIN_KERNELS[method])(
        np.ascontiguousarray(sums).reshape(-1, sums.shape[-1]),
        np.ascontiguousarray(np.broadcast_to(rest, (*batch, 3))).reshape(-1, 3),
        np.ascontiguousarray(np.broadcast_to(character.normals, (*batch, 3))).reshape(-1, 3),
        skinned.reshape(-1, 6),
    )
    return skinned[..., :3], skinned[..., 3:]


def _sums(character: Character, entries: FloatArray, with_signs: bool) -> FloatArray:
    """Weighted sums of palette entries ``(*, V, 8 or 12)``."""
    joints, weights = character.influences
    first = entries[..., joints[:, 0], :]
    total: FloatArray = first * weights[:, 0, None]
    for k in range(1, 4):
        held = np.flatnonzero(weights[:, k])
        other, share = entries[..., joints[held, k], :], weights[held, k, None]
        if with_signs:
            dot = np.sum(first[..., held, :4] * other[..., :4], axis=-1, keepdims=True)
            share = np.where(dot < 0.0, -share, share)
        total[..., held, :] += other * share
    return total
