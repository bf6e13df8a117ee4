"""Linear blend skinning: a vertex moves by the weighted mean of its joints' matrices.

Fast and exact where one joint carries a vertex; where two joints differ by a large turn about
the bone's own axis the mean matrix shrinks, and the surface narrows there.
Source: Magnenat-Thalmann, Laperrière, Thalmann, Joint-dependent local deformations (1988).
"""

import numpy as np

from motorcade.animation.character import Character
from motorcade.ga import FloatArray, Motor


def skin(character: Character, local_pose: Motor) -> tuple[FloatArray, FloatArray]:
    """Positions and normals of a character's mesh in a pose.

    Normals are turned by the blended matrix and brought back to unit length, which is exact for
    rigidly carried vertices.

    Args:
        character: mesh, skeleton and weights.
        local_pose: Motor (*, J), poses `parent_T_joint`.

    Returns:
        vertices (*, V, 3) in character space, metres, and unit normals (*, V, 3).

    Raises:
        ValueError: a last dimension other than the number of joints.
    """
    skeleton = character.skeleton
    moved = skeleton.world(local_pose) @ skeleton.rest_world_inverse
    matrices = moved.as_matrix()[..., :3, :]
    rows = matrices.reshape(*matrices.shape[:-2], 12)
    carried = rows[..., character.joints[:, 0], :] * character.weights[:, 0, None]
    for k in range(1, 4):
        held = np.flatnonzero(character.weights[:, k])
        share = character.weights[held, k, None]
        carried[..., held, :] += rows[..., character.joints[held, k], :] * share
    blended = carried.reshape(*carried.shape[:-1], 3, 4)
    turn = blended[..., :3]
    vertices = np.einsum("...vij,vj->...vi", turn, character.vertices) + blended[..., 3]
    normals = np.einsum("...vij,vj->...vi", turn, character.normals)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return vertices, normals
