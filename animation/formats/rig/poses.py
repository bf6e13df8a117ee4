"""Rigid poses of the joints out of the transforms of all nodes, with scale factored out.

The world transform of a joint is ``T R s``: its frame keeps ``T R``, and `s` is told apart. In
its parent's rigid frame a joint then lies at the parent's scale times its own translation. Where
a block is no multiple of a rotation, the nearest one in the sense of Frobenius stands in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.rig.joints import Joints
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import NodeTree
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["JointPoses", "World", "joint_poses"]


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
    for joint, chain in enumerate(joints.chains):
        if len(chain) > 1 or joints.parents[joint] < 0:
            motor = _folded(tree, chain, nodes, scale, world)
            wxyz[:, joint], places[:, joint] = motor.as_quaternion_translation()
    return JointPoses(wxyz, places, scale[:, joints.nodes], None)


def _folded(
    tree: NodeTree, chain: tuple[int, ...], nodes: Transforms, scale: FloatArray, world: World
) -> Motor:
    """Rigid poses (F,) of the last node of a chain in the frame above its first."""
    motor = world.motor if tree.parents[chain[0]] < 0 else Motor.identity()
    for node in chain:
        parent = tree.parents[node]
        size = world.unit_m if parent < 0 else scale[:, parent, None]
        motor = motor @ Motor.from_quaternion_translation(
            nodes.wxyz[:, node], nodes.translation[:, node] * size
        )
    return motor


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
