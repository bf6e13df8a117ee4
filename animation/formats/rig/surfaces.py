"""All surfaces of a rig as one mesh in the bind pose, in character space.

Influences are cut to eight, and normals made where a file has none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import Appearance, MaterialPart
from motorcade.animation.clip import MorphTarget
from motorcade.animation.formats.limits import FormatError, expected
from motorcade.animation.formats.rig.joints import (
    Binding,
    Joints,
    World,
    nearest_joints,
    node_matrices,
)
from motorcade.animation.formats.rig.values import NodeTree, RigMorph, RigSurface
from motorcade.animation.vectors import UP, unit
from motorcade.ga.arrays import FloatArray, IntArray

# A dropped share or a sum off by this much is worth telling.
TOLD_SHARE = 0.01
# Influences of a vertex at most.
KEPT = 8


@dataclass(frozen=True, eq=False)
class Influences:
    """Up to four joints a vertex, or up to eight where some follow more.

    Args:
        numbers: (V, 4 or 8) joints of the skin.
        weights: (V, 4 or 8) shares that sum to 1.
        notices: what was dropped or mended.
    """

    numbers: IntArray
    weights: FloatArray
    notices: tuple[str, ...]


def strongest_influences(surface: RigSurface) -> Influences:
    """The four or eight largest influences of each vertex, brought to a sum of 1.

    A vertex without any weight is given to the first joint of its skin, which a notice says.

    Raises FormatError: weights that are negative, NaN or infinite.
    """
    numbers, weights = surface.influences, surface.weights
    if not np.isfinite(weights).all() or weights.min(initial=0.0) < 0.0:
        raise expected(f"weights of '{surface.name}'", "finite shares of 0 or more", "others")
    notices = []
    if weights.shape[1] > 4:
        order = np.argsort(-weights, axis=1, kind="stable")
        numbers = np.take_along_axis(numbers, order, axis=1)
        weights = np.take_along_axis(weights, order, axis=1)
    total = weights.sum(axis=1)
    lost = weights[:, KEPT:].sum(axis=1) / np.maximum(total, 1e-30)
    if lost.max(initial=0.0) > TOLD_SHARE:
        count = int(np.count_nonzero(lost > TOLD_SHARE))
        notices.append(
            f"'{surface.name}': {count} vertices have more than {KEPT} influences; up to "
            f"{100 * lost.max():.0f} % of their weight was left out"
        )
    width = KEPT if np.any(weights[:, 4:] > 0.0) else 4
    more = ((0, 0), (0, max(0, width - weights.shape[1])))
    numbers, weights = np.pad(numbers[:, :width], more), np.pad(weights[:, :width], more)
    if np.all(total > 1e-12) and np.abs(total - 1.0).max(initial=0.0) > TOLD_SHARE:
        notices.append(
            f"'{surface.name}': weights sum to {total.min():.3g} to {total.max():.3g}: divided "
            "by their sums"
        )
    total = weights.sum(axis=1, keepdims=True)
    bare = total[:, 0] <= 1e-12
    if bare.any():
        weights[bare], numbers[bare] = np.eye(width)[0], 0
        total = weights.sum(axis=1, keepdims=True)
        notices.append(
            f"'{surface.name}': {np.count_nonzero(bare)} vertices without weights follow the "
            "first joint of their skin"
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
    appearance: Appearance | None = None
    morphs: tuple[MorphTarget, ...] = ()
    morph_nodes: tuple[tuple[int, int], ...] = ()
    tangents: FloatArray | None = None
    """For each target its node, and its number among the targets of that."""


def bound_mesh(
    tree: NodeTree, joints: Joints, binding: Binding, surfaces: tuple[RigSurface, ...], world: World
) -> BoundMesh:
    """Merge surfaces; a surface without a skin follows the joint above it.

    Raises FormatError: weights or numbers out of range.
    """
    nearest = nearest_joints(tree, joints)
    frames = binding.frames()
    stands, from_found = node_matrices(tree, world), frames @ np.linalg.inv(binding.node_frames)
    parts: list[BoundMesh] = []
    notices: list[str] = []
    skins: dict[int, tuple[IntArray, FloatArray]] = {}
    for surface in surfaces:
        if surface.skin is None:
            joint = int(nearest[surface.node])
            part = _hanging(surface, joint, from_found[joint] @ stands[surface.node])
        else:
            if id(surface.skin) not in skins:
                own = np.searchsorted(joints.nodes, surface.skin.nodes)
                skins[id(surface.skin)] = own, frames[own] @ surface.skin.inverse_bind
            part = _skinned(surface, *skins[id(surface.skin)])
        parts.append(part)
        notices += part.notices
    width = max(part.joints.shape[1] for part in parts)
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return BoundMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate(
            [part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)]
        ),
        np.concatenate([part.colors for part in parts]),
        np.concatenate([_as_wide(part.joints, width) for part in parts]),
        np.concatenate([_as_wide(part.weights, width) for part in parts]),
        tuple(notices),
        _appearance(surfaces, parts),
        *_morphs(surfaces, parts),
    )


def _as_wide(values: NDArray[Any], width: int) -> NDArray[Any]:
    return np.pad(values, ((0, 0), (0, width - values.shape[1])))


def _morphs(
    surfaces: tuple[RigSurface, ...], parts: list[BoundMesh]
) -> tuple[tuple[MorphTarget, ...], tuple[tuple[int, int], ...]]:
    """Targets of all surfaces; those of one node and number are one, whatever primitive."""
    pieces: dict[tuple[int, int], list[MorphTarget]] = {}
    start = 0
    for surface, part in zip(surfaces, parts, strict=True):
        for number, morph in enumerate(part.morphs):
            moved = replace(morph, rows=morph.rows + start)
            pieces.setdefault((surface.node, number), []).append(moved)
        start += len(part.vertices)
    targets = tuple(
        MorphTarget(
            held[0].name,
            np.concatenate([one.rows for one in held]),
            np.concatenate([one.positions for one in held]),
            np.concatenate([one.normals for one in held]),
            held[0].weight,
        )
        for held in pieces.values()
    )
    return targets, tuple(pieces)


def _appearance(surfaces: tuple[RigSurface, ...], placed: list[BoundMesh]) -> Appearance | None:
    """The materials of surfaces, one after another; None where they have none."""
    if any(surface.material is None for surface in surfaces):
        return None
    sets = max(len(surface.coordinates) for surface in surfaces)
    count = sum(len(surface.vertices) for surface in surfaces)
    coordinates = np.zeros((sets, count, 2), np.float32)
    tinted = any(surface.vertex_colors is not None for surface in surfaces)
    colors = np.ones((count, 4), np.float32) if tinted else None
    turned = any(one.tangents is not None for one in placed)
    tangents = np.zeros((count, 4), np.float32) if turned else None
    parts: list[MaterialPart] = []
    vertex, triangle = 0, 0
    for surface, bound in zip(surfaces, placed, strict=True):
        where = slice(vertex, vertex + len(surface.vertices))
        for number, coordinate in enumerate(surface.coordinates):
            coordinates[number, where] = coordinate
        if colors is not None and surface.vertex_colors is not None:
            colors[where] = surface.vertex_colors
        if tangents is not None and bound.tangents is not None:
            tangents[where] = bound.tangents
        end = triangle + len(surface.triangles)
        last = parts[-1] if parts else None
        assert surface.material is not None  # looked at above
        alike = last and last.material is surface.material and last.flat == surface.flat
        # Parts through which one sees are drawn one by one, from the farthest.
        if last and alike and last.material.alpha_mode != "blend":
            parts[-1] = replace(last, stop=end)
        else:
            parts.append(MaterialPart(surface.material, triangle, end, surface.flat))
        vertex, triangle = where.stop, end
    return Appearance(tuple(parts), coordinates, colors, tangents)


def _hanging(surface: RigSurface, joint: int, matrix: FloatArray) -> BoundMesh:
    """A surface that one joint carries, placed by a matrix (4, 4) that may shear."""
    count = len(surface.vertices)
    numbers, weights = np.zeros((count, 4), dtype=np.int64), np.zeros((count, 4))
    numbers[:, 0], weights[:, 0] = joint, 1.0
    return _placed(surface, matrix[None], numbers, weights, ())


def _skinned(surface: RigSurface, own: IntArray, matrices: FloatArray) -> BoundMesh:
    """A surface in the bind pose that all share: posed there by its own bind matrices.

    Its skin's joints are `own` (M,), whose `matrices` (M, 4, 4) lead to character space.
    """
    held = strongest_influences(surface)
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
    file_normals = surface.normals
    if file_normals is None:
        normals = normals_of(vertices, triangles)
    else:
        normals, mended = _normals(blocks, mirrored, file_normals, vertices, triangles)
        if mended:
            notices += (f"'{surface.name}': {mended} normals of length zero made anew",)
    morphs = tuple(_morph(one, blocks, mirrored, len(vertices)) for one in surface.morphs)
    return BoundMesh(
        vertices,
        normals,
        triangles,
        surface.colors,
        numbers,
        weights,
        notices,
        morphs=morphs,
        tangents=_tangents(surface.tangents, blocks, mirrored),
    )


def _tangents(
    values: FloatArray | None, blocks: FloatArray, mirrored: NDArray[np.bool_]
) -> FloatArray | None:
    """Tangents turned with their surface: unit, or zero where the file's are."""
    if values is None:
        return None
    tangents = np.einsum("vij,vj->vi", np.broadcast_to(blocks, (len(values), 3, 3)), values[:, :3])
    sides = np.where(values[:, 3] < 0.0, -1.0, 1.0) * np.where(mirrored, -1.0, 1.0)
    return np.column_stack([unit(tangents, np.zeros(3)), sides])


def _morph(
    rig_morph: RigMorph, blocks: FloatArray, mirrored: NDArray[np.bool_], count: int
) -> MorphTarget:
    """A target turned and scaled as its surface of so many vertices was."""
    own = np.broadcast_to(blocks, (count, 3, 3))[rig_morph.rows]
    positions = np.einsum("vij,vj->vi", own, rig_morph.positions)
    normals = np.zeros_like(positions)
    if rig_morph.normals is not None and len(rig_morph.rows):
        cofactors = _cofactors(own, np.broadcast_to(mirrored, count)[rig_morph.rows])
        # Where scale is uniform, this is what makes the surface's own normal unit.
        size = np.linalg.norm(cofactors, axis=(1, 2)) / np.sqrt(3.0)
        turned = np.einsum("vij,vj->vi", cofactors, rig_morph.normals)
        normals = turned / np.maximum(size, 1e-30)[:, None]
    return MorphTarget(rig_morph.name, rig_morph.rows, positions, normals, rig_morph.weight)


def _cofactors(blocks: FloatArray, mirrored: NDArray[np.bool_]) -> FloatArray:
    """What turns normals as blocks (V, 3, 3) turn vertices."""
    after, last = blocks[:, [1, 2, 0]], blocks[:, [2, 0, 1]]
    # NumPy's cross product takes longer than all else where a file has thousands of meshes.
    cofactors = after[..., [1, 2, 0]] * last[..., [2, 0, 1]]
    cofactors -= after[..., [2, 0, 1]] * last[..., [1, 2, 0]]
    return cofactors * np.where(mirrored, -1.0, 1.0)[:, None, None]


def _normals(
    blocks: FloatArray,
    mirrored: NDArray[np.bool_],
    values: FloatArray,
    vertices: FloatArray,
    triangles: IntArray,
) -> tuple[FloatArray, int]:
    """Normals turned by the cofactors of the blocks, and how many were made anew."""
    cofactors = _cofactors(blocks, mirrored)
    if len(blocks) == 1:
        normals = values @ cofactors[0].T
    else:
        normals = np.einsum("vij,vj->vi", cofactors, values)
    size = float(np.abs(cofactors).max())
    bare = ~(np.linalg.norm(normals, axis=1) > 1e-3 * size)
    rotated = unit(normals, UP)
    if bare.any():
        rotated[bare] = normals_of(vertices, triangles)[bare]
    return rotated, int(np.count_nonzero(bare))
