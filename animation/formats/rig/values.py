"""What the readers hand over: nodes, surfaces, clips, axes and unit, as they stand in the file.

Keys into values between them: steps, lines, great arcs and cubic splines, many at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import Material
from motorcade.animation.formats.limits import (
    MAX_DEPTH,
    MAX_NODES,
    FormatError,
    check_count,
    expected,
)
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.classical.quaternion import quaternion_slerp


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
    >>> from motorcade.animation.formats.rig import NodeTree, Transforms
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
    >>> from motorcade.animation.formats.rig import Skin
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
    >>> from motorcade.animation.formats.rig import RigSurface
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
    >>> from motorcade.animation.formats.rig import RigClip
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
    >>> from motorcade.animation.formats.rig import NodeTree, Rig, Transforms, assemble_motion
    >>> from motorcade.animation.formats.rig import Wanted
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


def between(keys: FloatArray, times: FloatArray) -> tuple[np.ndarray, np.ndarray, FloatArray]:
    """The keys (n,) at or before each time and after it, and the fraction (n,) of the way.

    Times outside are held at the ends.
    """
    if len(keys) == 1:
        alone = np.zeros(len(times), dtype=np.int64)
        return alone, alone, np.zeros(len(times))
    before = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    fraction = (times - keys[before]) / (keys[before + 1] - keys[before])
    return before, before + 1, np.clip(fraction, 0.0, 1.0)


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
