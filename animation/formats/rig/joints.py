"""Which nodes of a rig become joints, their rigid poses, and where they and the mesh rest.

Nodes between a joint and the joint above it are folded into its local pose: exporters put helper
nodes there, and scenes hang skeletons under nodes that turn axes and change units.

The world transform of a joint is ``T R s``: its frame keeps ``T R``, and `s` is told apart. In
its parent's rigid frame a joint then lies at the parent's scale times its own translation. Where
a block is no multiple of a rotation, the nearest one in the sense of Frobenius stands in.

A file says where a joint was when its mesh was bound by ``joint_T_mesh``. The mesh itself may
then be placed at will: it is put where the joints' rest transforms put it, if they all agree,
and upright in the middle of them if the nodes stand in some pose of a motion instead. With ``K``
the placing of the mesh, a joint's frame at rest is the rigid part of ``K inverse(joint_T_mesh)``
and its reference scale the rest of it: the constant scale of a rig ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.limits import MAX_NODES, FormatError, check_count, expected
from motorcade.animation.formats.rig.values import (
    NodeTree,
    Rig,
    RigSurface,
    Skin,
    Transforms,
    scaled_matrices,
)
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import along_axes, box_corners
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

HELPER = "_$AssimpFbx$_"


"""Part of the names of nodes into which an FBX joint is taken apart on export."""


@dataclass(frozen=True, eq=False)
class Joints:
    """J joints chosen among the nodes, parents first.

    Args:
        nodes: (J,) node numbers, increasing.
        parents: (J,) joint numbers, −1 for roots.
        names: J different names.
        chains: for each joint the nodes from below the joint above it down to itself.
        renamed: how many names had to be made up or told apart.
    """

    nodes: IntArray
    parents: IntArray
    names: tuple[str, ...]
    chains: tuple[tuple[int, ...], ...]
    renamed: int


def joints_of(rig: Rig) -> Joints:
    """The joints that the file names, or else the nodes of its trees that carry surfaces.

    A surface without a skin makes its own node a joint where nothing above it is one, as of the
    ground or another prop, or where clips move it against the joint above it.
    """
    tree = rig.tree
    held = set(rig.joints) or set(_moving_trees(rig))
    moving = {int(node) for clip in rig.clips for node in clip.nodes}
    loose = {surface.node for surface in rig.surfaces if surface.skin is None}
    chosen = sorted(held | {node for node in loose if not _follows(tree, node, held, moving)})
    number = {node: joint for joint, node in enumerate(chosen)}
    above = tree.parents.tolist()
    parents, chains = [], []
    for node in chosen:
        chain = [node]
        parent = above[node]
        while parent >= 0 and parent not in number:
            chain.append(parent)
            parent = above[parent]
        parents.append(number[parent] if parent >= 0 else -1)
        chains.append(tuple(reversed(chain)))
    check_count("nodes between joints", sum(map(len, chains)), MAX_NODES)
    names, renamed = _names([tree.names[node] for node in chosen])
    return Joints(np.array(chosen), np.array(parents), names, tuple(chains), renamed)


def nearest_joints(tree: NodeTree, joints: Joints) -> IntArray:
    """For each node (N,) the joint that it is or hangs below, −1 for none."""
    nearest = np.full(len(tree.names), -1, dtype=np.int64)
    nearest[joints.nodes] = np.arange(len(joints.nodes))
    for node, parent in enumerate(tree.parents.tolist()):
        if nearest[node] < 0 <= parent:
            nearest[node] = nearest[parent]
    return nearest


def _follows(tree: NodeTree, node: int, held: set[int], moving: set[int]) -> bool:
    """Whether a node is held, or hangs below one that is on nodes that do not move."""
    while node >= 0 and node not in held and node not in moving:
        node = int(tree.parents[node])
    return node in held


def _moving_trees(rig: Rig) -> list[int]:
    """Nodes of the trees that carry surfaces; without any, of the tree with most moving nodes.

    A node with surfaces counts as moving. Cameras and lights that move too stand in trees of their
    own, under a root that stands still.
    """
    tree = rig.tree
    moving = np.zeros(len(tree.names), dtype=bool)
    for clip in rig.clips:
        moving[clip.nodes] = True
    bearing = [surface.node for surface in rig.surfaces]
    moving[bearing] = True
    if not moving.any():
        raise FormatError("nodes: expected joints, a skin or an animation, got none")
    top = np.arange(len(tree.names))
    still = ~moving
    for node, parent in enumerate(tree.parents.tolist()):
        if parent < 0:
            continue
        still[node] &= still[parent]
        if not still[parent]:
            top[node] = top[parent]
    largest = int(np.argmax(np.bincount(top[moving], minlength=len(top))))
    kept = np.unique(top[bearing]) if bearing else np.array([largest])
    inside = np.flatnonzero(np.isin(top, kept) & ~still)
    return [int(node) for node in inside if HELPER not in tree.names[node]] or [largest]


def _names(values: list[str]) -> tuple[tuple[str, ...], int]:
    """Different names that are not empty, and how many had to be changed."""
    taken: set[str] = set()
    names, renamed = [], 0
    counts: dict[str, int] = {}
    for joint, wanted in enumerate(values):
        name = wanted or f"joint_{joint}"
        while name in taken:
            counts[wanted] = counts.get(wanted, 1) + 1
            name = f"{wanted}#{counts[wanted]}"
        renamed += name != wanted
        taken.add(name)
        names.append(name)
    return tuple(names), renamed


@dataclass(frozen=True, eq=False)
class World:
    """How a file's world lies in character space: turned, scaled, then lowered.

    Args:
        turn: Rotor from the file's axes to z up, facing +x.
        unit_m: length of the file's unit.
        lowered_m: how far everything is moved down, so that soles stand at z = 0.
    """

    turn: Rotor
    unit_m: float
    lowered_m: float = 0.0

    @property
    def motor(self) -> Motor:
        """The rigid part."""
        return Motor.from_rotor_translation(self.turn, (0.0, 0.0, -self.lowered_m))


def node_matrices(tree: NodeTree, world: World) -> FloatArray:
    """Where the nodes stand: (N, 4, 4) from their frames, with all scale and shear, to `world`."""
    matrices = tree.rest.as_matrices()
    start = scaled_matrices(world.motor, np.array(world.unit_m))
    for level in tree.levels:
        above = tree.parents[level]
        matrices[level] = (start if above[0] < 0 else matrices[above]) @ matrices[level]
    return matrices


@dataclass(frozen=True, eq=False)
class JointPoses:
    """F poses of J joints: `parent_T_joint`, roots in character space.

    Args:
        wxyz: (F, J, 4) unit quaternions.
        translation_m: (F, J, 3).
        scale: (F, J) world scale, metres for a unit of the joint's own frame; negative with a
            point reflection.
        lost: (F, J, 3, 3) what the world blocks have beyond scale times turn, or None.
    """

    wxyz: FloatArray
    translation_m: FloatArray
    scale: FloatArray
    lost: FloatArray | None

    def motors(self) -> Motor:
        """Local poses, Motor (F, J)."""
        return Motor.from_quaternion_translation(self.wxyz, self.translation_m)


def joint_poses(tree: NodeTree, joints: Joints, nodes: Transforms, world: World) -> JointPoses:
    """Poses of the joints from transforms (F, N) of the nodes, in the file's frame and unit."""
    if nodes.blocks is not None:
        return _sheared(tree, joints, nodes, world)
    scale = np.empty(nodes.shape)
    for level in tree.levels:
        above = tree.parents[level]
        over = np.where(above < 0, world.unit_m, scale[:, above])
        np.multiply(nodes.scale[:, level], over, out=over)
        scale[:, level] = over
    above = tree.parents[joints.nodes]
    wxyz = nodes.wxyz[:, joints.nodes]
    size = np.where(above < 0, world.unit_m, scale[:, above])[..., None]
    places = nodes.translation[:, joints.nodes] * size
    held = [
        joint
        for joint, chain in enumerate(joints.chains)
        if len(chain) > 1 or joints.parents[joint] < 0
    ]
    if held:
        motors = _folded(tree, [joints.chains[joint] for joint in held], nodes, scale, world)
        wxyz[:, held], places[:, held] = motors.as_quaternion_translation()
    return JointPoses(wxyz, places, scale[:, joints.nodes], None)


def _folded(
    tree: NodeTree,
    chains: list[tuple[int, ...]],
    nodes: Transforms,
    scale: FloatArray,
    world: World,
) -> Motor:
    """Rigid poses (F, C) of the last nodes of chains in the frames above their first."""
    coefficients = np.zeros((*nodes.shape[:1], len(chains), 8))
    rooted = np.array([tree.parents[chain[0]] < 0 for chain in chains])
    coefficients[:, rooted] = world.motor.coefficients
    coefficients[:, ~rooted, 0] = 1.0
    reached, step = list(range(len(chains))), 0
    while reached:  # all chains go on at once: files may have thousands of roots
        own = np.array([chains[which][step] for which in reached])
        above = tree.parents[own]
        size = np.where(above < 0, world.unit_m, scale[:, above])[..., None]
        further = Motor.from_quaternion_translation(
            nodes.wxyz[:, own], nodes.translation[:, own] * size
        )
        coefficients[:, reached] = (Motor(coefficients[:, reached]) @ further).coefficients
        step += 1
        reached = [which for which in reached if len(chains[which]) > step]
    return Motor(coefficients)


def _sheared(tree: NodeTree, joints: Joints, nodes: Transforms, world: World) -> JointPoses:
    """The same by matrices, for transforms with shear or different scales an axis."""
    blocks, places = nodes.as_blocks(), nodes.translation
    world_blocks, world_places = np.empty_like(blocks), np.empty_like(places)
    start = world.unit_m * world.turn.as_matrix()
    for level in tree.levels:
        above = tree.parents[level]
        if above[0] < 0:
            world_blocks[:, level] = start @ blocks[:, level]
            world_places[:, level] = places[:, level] @ start.T + world.motor.translation_m
            continue
        world_blocks[:, level] = world_blocks[:, above] @ blocks[:, level]
        world_places[:, level] = world_places[:, above] + np.einsum(
            "fnij,fnj->fni", world_blocks[:, above], places[:, level]
        )
    matrices = np.zeros((*nodes.shape[:1], len(joints.nodes), 4, 4))
    matrices[..., :3, :3] = world_blocks[:, joints.nodes]
    matrices[..., :3, 3] = world_places[:, joints.nodes]
    near = Transforms.from_matrices(matrices)
    motors = near.rigid()
    wxyz, local = near.wxyz.copy(), near.translation.copy()
    held = np.flatnonzero(joints.parents >= 0)
    inside = motors[:, joints.parents[held]].inverse() @ motors[:, held]
    wxyz[:, held], local[:, held] = inside.as_quaternion_translation()
    turn = Rotor.from_quaternion(near.wxyz).as_matrix() * near.scale[..., None, None]
    return JointPoses(wxyz, local, near.scale, matrices[..., :3, :3] - turn)


# Placings that differ by less, as a share of the mesh's size, are one.
AGREEING = 1e-3
# A mesh whose axes lie nearer than this to those of the file is taken to lie along them.
UPRIGHT_COSINE = np.cos(np.radians(44.0))


@dataclass(frozen=True, eq=False)
class Binding:
    """Rest frames of the joints.

    Args:
        world: Motor (J,) `character_T_joint` at rest.
        scale: (J,) reference scale: metres for a unit of the joint's frame in the file.
        agrees: whether the nodes' rest pose is the bind pose.
        node_frames: (J, 4, 4) the joints' frames, scale and all, as the nodes stand in the file.
    """

    world: Motor
    scale: FloatArray
    agrees: bool
    node_frames: FloatArray

    def frames(self) -> FloatArray:
        """Matrices (J, 4, 4) from the joints' frames in the file to character space."""
        return scaled_matrices(self.world, self.scale)


def bind(joints: Joints, rest: JointPoses, surfaces: tuple[RigSurface, ...]) -> Binding:
    """Rest frames from the skin that carries most triangles, else from the nodes' pose (1, J).

    Raises FormatError: an inverse bind matrix without an inverse.
    """
    local = rest.motors()[0]
    world = Skeleton(joints.names, joints.parents, local).rest_world
    scale = rest.scale[0]
    matrices = scaled_matrices(world, scale)
    main = max(surfaces, key=lambda surface: (surface.skin is not None, len(surface.triangles)))
    skin = main.skin
    if skin is None:
        return Binding(world, scale.copy(), agrees=True, node_frames=matrices)
    numbers = np.searchsorted(joints.nodes, skin.nodes)
    _check_invertible(skin)
    placing, agrees = _placing(main, skin, numbers, world, scale)
    full = skin.inverse_bind.copy()
    full[:, 3] = (0.0, 0.0, 0.0, 1.0)
    bound = Transforms.from_matrices(placing @ np.linalg.inv(full))
    coefficients, scales = np.array(world.coefficients), scale.copy()
    fixed = np.zeros(len(scales), dtype=bool)
    fixed[numbers] = True
    coefficients[numbers] = bound.rigid().coefficients
    scales[numbers] = bound.scale
    for joint, parent in enumerate(joints.parents.tolist()):
        if fixed[joint] or parent < 0:
            continue
        ratio = scales[parent] / scale[parent]
        step = local[joint]
        step_m = Motor.from_rotor_translation(step.rotor, ratio * step.translation_m)
        coefficients[joint] = (Motor(coefficients[parent]) @ step_m).coefficients
        scales[joint] = ratio * scale[joint]
    return Binding(Motor(coefficients), scales, agrees, matrices)


def _placing(
    main: RigSurface, skin: Skin, numbers: IntArray, world: Motor, scale: FloatArray
) -> tuple[FloatArray, bool]:
    """Matrix (4, 4) that places the mesh, and whether all joints agree on it."""
    placings = scaled_matrices(world[numbers], scale[numbers]) @ skin.inverse_bind
    mass = np.bincount(
        main.influences.reshape(-1), main.weights.reshape(-1), minlength=len(numbers)
    )[: len(numbers)]
    if not (np.isfinite(mass).all() and mass.sum() > 0.0):
        raise expected(f"weights of '{main.name}'", "a sum above zero", mass.sum())
    corners = box_corners(main.vertices)
    placed = np.einsum("mij,cj->mci", placings[:, :3, :3], corners) + placings[:, None, :3, 3]
    heaviest = int(np.argmax(mass))
    size = float(np.linalg.norm(np.ptp(placed[heaviest], axis=0)))
    apart = np.linalg.norm(placed - placed[heaviest], axis=-1).max(axis=-1)
    if apart[mass > 0.0].max() <= AGREEING * max(size, 1e-12):
        return placings[heaviest], True
    root = int(np.argmin(numbers))
    point = np.linalg.solve(skin.inverse_bind[root, :3, :3], -skin.inverse_bind[root, :3, 3])
    return _upright(
        placings,
        np.asarray(mass / mass.sum()),
        np.asarray(point),
        world[numbers[root]].translation_m,
    ), False


def _upright(
    placings: FloatArray, mass: FloatArray, point: FloatArray, place: FloatArray
) -> FloatArray:
    """One placing amid those of a posed skeleton, turned by quarters, `point` put in `place`."""
    near = Transforms.from_matrices(placings)
    scale = float(np.median(near.scale[mass > 0.0]))
    turns = Rotor.from_quaternion(near.wxyz).as_matrix()
    mean = np.einsum("m,mij->ij", mass, turns)
    u, _, vt = np.linalg.svd(mean)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    quarter = along_axes(Rotor.from_matrix(turn)).as_matrix()
    if np.diagonal(quarter.T @ turn).min() > UPRIGHT_COSINE:
        turn = quarter
    upright = np.eye(4)
    upright[:3, :3] = scale * turn
    upright[:3, 3] = place - upright[:3, :3] @ point
    return upright


def _check_invertible(skin: Skin) -> None:
    """Refuse inverse bind matrices that have no inverse."""
    blocks = skin.inverse_bind[:, :3, :3]
    size = np.abs(blocks).max(axis=(1, 2))
    singular = ~(np.abs(np.linalg.det(blocks)) > 1e-9 * size**3) | ~(size > 1e-9)
    if singular.any():
        raise FormatError(
            "inverse bind matrices: expected invertible ones, got "
            f"{int(np.count_nonzero(singular))} that are not"
        )
