"""All surfaces of a rig as one mesh in the bind pose, in character space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.errors import FormatError
from motorcade.animation.formats.rig.binding import Binding
from motorcade.animation.formats.rig.joints import Joints, nearest_joints
from motorcade.animation.formats.rig.mesh import normals_of, strongest_four
from motorcade.animation.formats.rig.values import NodeTree, RigSurface, Skin
from motorcade.animation.vectors import UP, unit
from motorcade.ga.arrays import FloatArray, IntArray

__all__ = ["BoundMesh", "bound_mesh"]


@dataclass(frozen=True, eq=False)
class BoundMesh:
    """What a `Character` needs of a mesh, and what was left out on the way."""

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    colors: FloatArray
    joints: IntArray
    weights: FloatArray
    notices: tuple[str, ...]


def bound_mesh(
    tree: NodeTree, joints: Joints, binding: Binding, surfaces: tuple[RigSurface, ...]
) -> BoundMesh:
    """Merge surfaces; a surface without a skin follows the joint above it.

    Raises:
        FormatError: no surface is carried by the skeleton, or weights or numbers out of range.
    """
    nearest = nearest_joints(tree, joints)
    frames = binding.frames()
    parts, notices = [], []
    for surface in surfaces:
        if surface.skin is None:
            joint = int(nearest[surface.node])
            if joint < 0:
                notices.append(f"'{surface.name}' hangs on no joint: left out")
                continue
            part = _hanging(tree, joints, frames, surface, joint)
        else:
            part = _skinned(joints, frames, surface, surface.skin)
        parts.append(part)
        notices += part.notices
    if not parts:
        raise FormatError("meshes: expected one or more that joints carry, got none")
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return BoundMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate(
            [part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)]
        ),
        np.concatenate([part.colors for part in parts]),
        np.concatenate([part.joints for part in parts]),
        np.concatenate([part.weights for part in parts]),
        tuple(notices),
    )


def _hanging(
    tree: NodeTree, joints: Joints, frames: FloatArray, surface: RigSurface, joint: int
) -> BoundMesh:
    """A surface that one joint carries, by the nodes between."""
    below = np.eye(4)
    node = surface.node
    while node != joints.nodes[joint]:
        below = tree.rest[node].as_matrices() @ below
        node = int(tree.parents[node])
    count = len(surface.vertices)
    numbers, weights = np.zeros((count, 4), dtype=np.int64), np.zeros((count, 4))
    numbers[:, 0], weights[:, 0] = joint, 1.0
    return _placed(surface, (frames[joint] @ below)[None], numbers, weights, ())


def _skinned(joints: Joints, frames: FloatArray, surface: RigSurface, skin: Skin) -> BoundMesh:
    """A surface in the bind pose that all share: posed there by its own bind matrices."""
    held = strongest_four(surface)
    own = np.searchsorted(joints.nodes, skin.nodes)
    matrices = frames[own] @ skin.inverse_bind
    used = np.unique(held.numbers[held.weights > 0.0])
    first = matrices[used[0]]
    far = np.abs(surface.vertices).max(initial=0.0)
    apart = np.abs(matrices[used] - first)
    apart[:, :3, :3] *= far
    size = float(np.abs(first[:3, :3]).max()) * far
    if apart.max() <= 1e-6 * max(size, 1e-12):
        each = first[None]
    else:
        each = np.einsum("vk,vkij->vij", held.weights, matrices[held.numbers])
    return _placed(surface, each, own[held.numbers], held.weights, held.notices)


def _placed(
    surface: RigSurface,
    matrices: FloatArray,
    numbers: IntArray,
    weights: FloatArray,
    notices: tuple[str, ...],
) -> BoundMesh:
    """Move a surface by one matrix, or one a vertex, (1 or V, 4, 4)."""
    blocks, places = matrices[:, :3, :3], matrices[:, :3, 3]
    if len(matrices) == 1:
        vertices = surface.vertices @ blocks[0].T + places[0]
    else:
        vertices = np.einsum("vij,vj->vi", blocks, surface.vertices) + places
    if not np.isfinite(vertices).all() or np.abs(vertices).max(initial=0.0) > 1e6:
        raise FormatError(f"'{surface.name}': expected vertices within 1e6 m, got farther ones")
    triangles = surface.triangles
    mirrored = np.linalg.det(blocks) < 0.0
    if mirrored.mean() > 0.5:
        triangles = triangles[:, ::-1]
    given = surface.normals
    if given is None:
        normals = normals_of(vertices, triangles)
    else:
        normals, mended = _normals(blocks, mirrored, given, vertices, triangles)
        if mended:
            notices += (f"'{surface.name}': {mended} normals of length zero made anew",)
    return BoundMesh(vertices, normals, triangles, surface.colors, numbers, weights, notices)


def _normals(
    blocks: FloatArray,
    mirrored: np.ndarray[tuple[int], np.dtype[np.bool_]],
    given: FloatArray,
    vertices: FloatArray,
    triangles: IntArray,
) -> tuple[FloatArray, int]:
    """Normals turned by the cofactors of the blocks, and how many were made anew."""
    a, b, c = blocks[:, 0], blocks[:, 1], blocks[:, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    cofactors = cofactors * np.where(mirrored, -1.0, 1.0)[:, None, None]
    if len(blocks) == 1:
        normals = given @ cofactors[0].T
    else:
        normals = np.einsum("vij,vj->vi", cofactors, given)
    size = float(np.abs(cofactors).max())
    bare = ~(np.linalg.norm(normals, axis=1) > 1e-3 * size)
    made = unit(normals, UP)
    if bare.any():
        made[bare] = normals_of(vertices, triangles)[bare]
    return made, int(np.count_nonzero(bare))
