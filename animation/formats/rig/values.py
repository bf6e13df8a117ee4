"""What the readers hand over: nodes, surfaces, clips, axes and unit, as they stand in the file.

A transform is kept as a similarity (quaternion wxyz, translation, one signed scale) wherever it
is one. A negative scale is a point reflection, which exporters use for mirrored limbs. Where
matrices have shear or different scales an axis, the whole batch also keeps its 3x3 blocks.

Keys into values between them: steps, lines, great arcs and cubic splines, many at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import Material
from motorcade.animation.clip import between
from motorcade.animation.formats.limits import (
    MAX_DEPTH,
    MAX_NODES,
    FormatError,
    check_count,
    expected,
)
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.classical.quaternion import quaternion_slerp

# How far from one uniform scale the axes may be, as a share of it, before a block counts as
# sheared. Files with six printed digits, and matrices split into float32 parts, stay below.
UNIFORM_TOLERANCE = 1e-4
# Scales below this stand for hidden parts; a similarity needs more than nothing.
LEAST_SCALE = 1e-4


@dataclass(frozen=True, eq=False)
class Transforms:
    """Similarities `parent_T_node` of batch shape (*).

    Args:
        wxyz: (*, 4) unit quaternions.
        translation: (*, 3) in the file's unit.
        scale: (*) not zero; negative with a point reflection.
        blocks: (*, 3, 3) the true blocks where some are no multiple of a rotation, else None.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import Transforms
    >>> wxyz, translation = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 100.0, 0.0])
    >>> parent_T_node = Transforms.from_parts(wxyz, translation, scales=np.array([2.0, 2.0, 2.0]))
    >>> parent_T_node.as_matrices()[:3]
    array([[  2.,   0.,   0.,   0.],
           [  0.,   2.,   0., 100.],
           [  0.,   0.,   2.,   0.]])
    """

    wxyz: FloatArray
    translation: FloatArray
    scale: FloatArray
    blocks: FloatArray | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        return self.scale.shape

    @staticmethod
    def from_parts(wxyz: FloatArray, translation: FloatArray, scales: FloatArray) -> Transforms:
        """From quaternions (*, 4) of any length, translations (*, 3), scales an axis (*, 3).

        Raises:
            FormatError: NaN or infinity, or a quaternion of length zero.
        """
        for name, values in (("rotation", wxyz), ("translation", translation), ("scale", scales)):
            if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
                raise FormatError(f"{name}: expected finite numbers up to 1e9, got others")
        length = np.sqrt(np.einsum("...i,...i->...", wxyz, wxyz))
        if not np.all(length > 1e-6):
            raise FormatError("rotation: expected quaternions, got one of length zero")
        unit = wxyz / length[..., None]
        low, high = scales.min(axis=-1, initial=np.inf), scales.max(axis=-1, initial=-np.inf)
        scale = 0.5 * (low + high)
        if np.all(high - low <= UNIFORM_TOLERANCE * np.abs(scale)):
            return Transforms(unit, translation, _not_zero(scale))
        blocks = Rotor.from_quaternion(unit).as_matrix() * _not_zero(scales)[..., None, :]
        return _split(blocks, translation)

    @staticmethod
    def from_matrices(matrices: FloatArray) -> Transforms:
        """From matrices (*, 4, 4) that act on columns; their last row is not looked at.

        Raises:
            FormatError: NaN or infinity.
        """
        used = matrices[..., :3, :]
        if not np.isfinite(used).all() or np.abs(used).max(initial=0.0) > 1e9:
            raise FormatError("matrix: expected finite numbers up to 1e9, got others")
        return _split(used[..., :3], used[..., 3])

    def as_matrices(self) -> FloatArray:
        """Matrices (*, 4, 4) that act on columns."""
        matrices = np.zeros((*self.shape, 4, 4))
        matrices[..., :3, :3] = self.as_blocks()
        matrices[..., :3, 3] = self.translation
        matrices[..., 3, 3] = 1.0
        return matrices

    def as_blocks(self) -> FloatArray:
        """Blocks (*, 3, 3) of turn and scale."""
        if self.blocks is not None:
            return self.blocks
        turn: FloatArray = Rotor.from_quaternion(self.wxyz).as_matrix()
        return turn * self.scale[..., None, None]

    def rigid(self) -> Motor:
        """The turns and translations alone."""
        return Motor.from_quaternion_translation(self.wxyz, self.translation)

    def __getitem__(self, index: Any) -> Transforms:
        """Index the batch."""
        blocks = None if self.blocks is None else self.blocks[index]
        return Transforms(
            self.wxyz[index],
            self.translation[index],
            self.scale[index],
            blocks,
        )

    @staticmethod
    def concatenate(parts: list[Transforms]) -> Transforms:
        """Join batches along their first dimension."""
        blocks = None
        if any(part.blocks is not None for part in parts):
            blocks = np.concatenate([part.as_blocks() for part in parts])
        return Transforms(
            np.concatenate([part.wxyz for part in parts]),
            np.concatenate([part.translation for part in parts]),
            np.concatenate([part.scale for part in parts]),
            blocks,
        )


def scaled_matrices(motors: Motor, scale: FloatArray) -> FloatArray:
    """Matrices (*, 4, 4) that first scale by numbers (*), then move by motors (*)."""
    matrices: FloatArray = motors.as_matrix()
    matrices[..., :3, :3] *= scale[..., None, None]
    return matrices


def _not_zero(scale: FloatArray) -> FloatArray:
    """Scales of at least LEAST_SCALE in size, with their sign."""
    least = np.where(scale < 0.0, -LEAST_SCALE, LEAST_SCALE)
    return np.where(np.abs(scale) < LEAST_SCALE, least, scale)


def _split(blocks: FloatArray, translation: FloatArray) -> Transforms:
    """The nearest similarities, with the blocks where they are not near enough."""
    gram = np.einsum("...ki,...kj->...ij", blocks, blocks)
    square = np.trace(gram, axis1=-2, axis2=-1) / 3.0
    off = np.abs(gram - square[..., None, None] * np.eye(3)).max(axis=(-2, -1), initial=0.0)
    even = off <= 2.0 * UNIFORM_TOLERANCE * square
    sign = np.where(np.linalg.det(blocks) < 0.0, -1.0, 1.0)
    if np.all(even) and np.all(square > LEAST_SCALE**2):
        scale = sign * np.sqrt(square)
        turn = blocks / scale[..., None, None]
        # One step of Newton towards the nearest rotation: what is left is of second order.
        turn = 1.5 * turn - 0.5 * turn @ np.swapaxes(turn, -1, -2) @ turn
        return Transforms(Rotor.from_matrix(turn).as_quaternion(), translation, scale)
    u, singular, vt = np.linalg.svd(blocks * sign[..., None, None])
    turn = u @ vt
    turn *= np.where(np.linalg.det(turn) < 0.0, -1.0, 1.0)[..., None, None]
    scale = _not_zero(sign * singular.mean(axis=-1))
    return Transforms(Rotor.from_matrix(turn).as_quaternion(), translation, scale, blocks)


@dataclass(frozen=True, eq=False)
class NodeTree:
    """Nodes of a scene, parents before their children.

    Args:
        names: N names; they may repeat or be empty.
        parents: (N,) number of each node's parent, smaller than its own; −1 for a root.
        rest: Transforms (N,), `parent_T_node`.

    Raises:
        FormatError: no nodes, more than the limit, or deeper than the limit.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import NodeTree, Transforms
    >>> rest = Transforms.from_matrices(np.broadcast_to(np.eye(4), (3, 4, 4)))
    >>> tree = NodeTree(("hips", "thigh_l", "thigh_r"), np.array([-1, 0, 0]), rest)
    >>> [level.tolist() for level in tree.levels]
    [[0], [1, 2]]
    """

    names: tuple[str, ...]
    parents: IntArray
    rest: Transforms

    def __post_init__(self) -> None:
        check_count("nodes", len(self.names), MAX_NODES)
        if not self.names:
            raise FormatError("nodes: expected one or more, got none")
        if self.depth.max() >= MAX_DEPTH:
            raise expected("nodes", f"at most {MAX_DEPTH} levels", int(self.depth.max()) + 1)

    @property
    def depth(self) -> IntArray:
        """Distance (N,) of each node from its root."""
        depth = np.zeros(len(self.names), dtype=np.int64)
        for node, parent in enumerate(self.parents.tolist()):
            depth[node] = 0 if parent < 0 else depth[parent] + 1
        return depth

    @property
    def levels(self) -> list[IntArray]:
        """Node numbers by their distance from the root."""
        depth = self.depth
        return [np.flatnonzero(depth == level) for level in range(int(depth.max()) + 1)]


@dataclass(frozen=True, eq=False)
class Skin:
    """The joints that carry a surface.

    Args:
        nodes: (M,) node numbers.
        inverse_bind: (M, 4, 4), `joint_T_mesh` in the pose in which the mesh was bound.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import Skin
    >>> mesh_T_joint = np.stack([np.eye(4), np.eye(4)])
    >>> mesh_T_joint[1, :3, 3] = [0.0, 0.0, 0.4]  # where the second joint stood when it was bound
    >>> skin = Skin(np.array([3, 4]), np.linalg.inv(mesh_T_joint))
    >>> skin.inverse_bind[1, :3, 3]
    array([ 0. ,  0. , -0.4])
    """

    nodes: IntArray
    inverse_bind: FloatArray


@dataclass(frozen=True, eq=False)
class RigMorph:
    """What one weight of a node adds to a surface.

    Args:
        name: what it is called; may be empty.
        weight: at rest.
        rows: (R,) numbers of the vertices that it moves.
        positions: (R, 3) in the mesh's own frame and the file's unit.
        normals: (R, 3), or None for none.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import RigMorph
    >>> RigMorph("smile", 0.5, np.array([3]), np.ones((1, 3)), None).weight
    0.5
    """

    name: str
    weight: float
    rows: IntArray
    positions: FloatArray
    normals: FloatArray | None


@dataclass(frozen=True, eq=False)
class RigSurface:
    """Triangles that hang on a node, or are carried by a skin.

    Args:
        name: for messages.
        node: the node it hangs on; only used without a skin.
        vertices: (V, 3) in the mesh's own frame and the file's unit.
        normals: (V, 3), or None where the file has none.
        triangles: (T, 3) vertex numbers, counter-clockwise seen from outside.
        colors: (V, 3) sRGB, 0 to 1.
        skin: what carries it, or None.
        influences: (V, K) numbers of joints of the skin.
        weights: (V, K) their shares, 0 or more.
        material: what a renderer that samples textures draws, or None where `colors` say it all.
        coordinates: sets of texture coordinates, (V, 2) each.
        vertex_colors: (V, 4) linear, which multiply the material's base colour; None for white.
        flat: whether each triangle is shaded by its own plane.
        morphs: what the weights of its node add to vertices and normals, in the mesh's own frame.
        tangents: (V, 4) where texture coordinates grow, and 1 or −1 for the side of the other
            axis; None where the file does not say.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import RigSurface
    >>> corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    >>> flag = RigSurface("flag", 0, corners, None, np.array([[0, 1, 2]]), np.ones((3, 3)))
    >>> flag.skin is None  # it hangs on node 0
    True
    """

    name: str
    node: int
    vertices: FloatArray
    normals: FloatArray | None
    triangles: IntArray
    colors: FloatArray
    skin: Skin | None = None
    influences: IntArray = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int64))
    weights: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    material: Material | None = None
    coordinates: tuple[NDArray[np.float32], ...] = ()
    vertex_colors: FloatArray | None = None
    flat: bool = False
    morphs: tuple[RigMorph, ...] = ()
    tangents: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class RigClip:
    """A motion of the nodes.

    Args:
        name: what it is called; it may repeat or be empty.
        key_times: (F,) strictly increasing seconds: those at which the file has a key, and those
            just before its steps.
        at: Transforms (n, N) at times (n,) from the first key to the last.
        nodes: (A,) numbers of the nodes that it moves.
        straight: whether between keys turns follow the great arc and translations a line.
        looped: whether the file says that it repeats.
        key_count: how many keys the fullest channel has; by default the number of `key_times`.
        weights: by node, times (K,) and weights (K, M) of its M morph targets, on straight lines
            between.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.values import RigClip
    >>> turns = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (2, 1, 4))  # two keys, one node
    >>> places = np.array([[[0.0, 0.0, 0.0]], [[10.0, 0.0, 0.0]]])
    >>> clip = RigClip.of_all_nodes("slide", np.array([0.0, 1.0]), turns, places)
    >>> clip.at(np.array([0.25])).translation
    array([[[2.5, 0. , 0. ]]])
    """

    name: str
    key_times: FloatArray
    at: Callable[[FloatArray], Transforms]
    nodes: IntArray
    straight: bool = True
    looped: bool = False
    key_count: int = 0
    weights: Mapping[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict)

    @staticmethod
    def of_all_nodes(
        name: str, key_times: FloatArray, wxyz: FloatArray, translation: FloatArray
    ) -> RigClip:
        """A clip in which all nodes have keys at all times: turns (F, N, 4), places (F, N, 3)."""

        def at(times: FloatArray) -> Transforms:
            turned = great_arc(key_times, wxyz, times)
            places = with_times(key_times, translation, times)
            return Transforms(turned, places, np.ones(turned.shape[:-1]))

        return RigClip(name, key_times, at, np.arange(wxyz.shape[1]))


@dataclass(frozen=True, eq=False)
class Rig:
    """A character or motion as its file describes it.

    Args:
        tree: all nodes of the file.
        joints: numbers of the nodes that the file calls joints; empty where it names none.
        surfaces: meshes.
        clips: motions.
        up: unit vector (3,) of the file's frame, or None where it does not say.
        forward: unit vector (3,) that characters of this format face, or None.
        unit_m: length of one unit in metres, or None where the file does not say.
        unit_checked: whether `unit_m` is only believed of figures of a plausible height.
        notices: what was left out or assumed so far.
        settled: whether its zero is the ground, as in files that `write_gltf` wrote.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig.assemble import assemble_motion
    >>> from motorcade.animation.formats.rig.stance import Wanted
    >>> from motorcade.animation.formats.rig.values import NodeTree, Rig, Transforms
    >>> file_T_node = np.stack([np.eye(4), np.eye(4)])
    >>> file_T_node[1, :3, 3] = [0.0, 0.5, 0.0]  # y is up in this file
    >>> tree = NodeTree(("hips", "head"), np.array([-1, 0]), Transforms.from_matrices(file_T_node))
    >>> up, forward = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    >>> rig = Rig(tree, (0, 1), (), (), up, forward, unit_m=1.0)
    >>> assemble_motion(rig, Wanted(unit_m=1.0)).skeleton.rest_world.translation_m.round(6) + 0.0
    array([[0. , 0. , 0. ],
           [0. , 0. , 0.5]])
    """

    tree: NodeTree
    joints: tuple[int, ...]
    surfaces: tuple[RigSurface, ...]
    clips: tuple[RigClip, ...]
    up: tuple[float, float, float] | None
    forward: tuple[float, float, float] | None
    unit_m: float | None
    unit_checked: bool = False
    notices: tuple[str, ...] = ()
    settled: bool = False


def transforms_over(rest: Transforms, count: int) -> Transforms:
    """The rest transforms (N,) repeated as writable arrays (count, N)."""
    blocks = rest.blocks
    return Transforms(
        np.repeat(rest.wxyz[None], count, axis=0),
        np.repeat(rest.translation[None], count, axis=0),
        np.repeat(rest.scale[None], count, axis=0),
        None if blocks is None else np.repeat(blocks[None], count, axis=0),
    )


JUMP_S = 1e-6
"""How long before a step its old value is sampled last."""


def with_times(keys: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Values (n, ...) at times on straight lines between keys (K,) with values (K, ...)."""
    if len(keys) == len(times) and np.array_equal(keys, times):
        return values
    before, after, fraction = between(keys, times)
    share = fraction.reshape(-1, *[1] * (values.ndim - 1))
    interpolated: FloatArray = values[before] + share * (values[after] - values[before])
    return interpolated


def great_arc(keys: FloatArray, wxyz: FloatArray, times: FloatArray) -> FloatArray:
    """Unit quaternions (n, ..., 4) at times, turning evenly and the short way between keys."""
    if len(keys) == len(times) and np.array_equal(keys, times):
        return wxyz
    before, after, fraction = between(keys, times)
    share = fraction.reshape(-1, *[1] * (wxyz.ndim - 2))
    return quaternion_slerp(wxyz[before], wxyz[after], share)


def stepped(keys: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Values of the last key at or before each time; of the first key before it."""
    return values[np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 1)]


def hermite(
    keys: FloatArray, values: FloatArray, into: FloatArray, out: FloatArray, times: FloatArray
) -> FloatArray:
    """Values (n, ...) on cubics with slopes a second `into` and `out` of the keys (K, ...)."""
    before, after, fraction = between(keys, times)
    shape = (-1, *[1] * (values.ndim - 1))
    u = fraction.reshape(shape)
    step = (keys[after] - keys[before]).reshape(shape)
    interpolated: FloatArray = (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * values[before]
        + u * (1.0 - u) ** 2 * step * out[before]
        + u**2 * (3.0 - 2.0 * u) * values[after]
        + u**2 * (u - 1.0) * step * into[after]
    )
    return interpolated


def key_times(keys: list[FloatArray], stepped: list[bool]) -> FloatArray:
    """All times of curves' keys (K,), and times just before the steps of those that step."""
    jumps = [one[1:] - JUMP_S for one in keys]
    kept = [
        jump[jump > key[:-1]]
        for jump, key, steps in zip(jumps, keys, stepped, strict=True)
        if steps
    ]
    return np.unique(np.concatenate([*keys, *kept]))
