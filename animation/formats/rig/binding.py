"""The bind pose: where joints and vertices stand when the mesh is at rest.

A file says where a joint was when its mesh was bound by ``joint_T_mesh``. The mesh itself may
then be placed at will: it is put where the joints' rest transforms put it, if they all agree,
and upright in the middle of them if the nodes stand in some pose of a motion instead.

With ``K`` the placing of the mesh, a joint's frame at rest is the rigid part of
``K inverse(joint_T_mesh)`` and its reference scale the rest of it: the constant scale of a rig,
in the mesh, in the nodes or in both, ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.limits import FormatError, expected
from motorcade.animation.formats.rig.joints import JointPoses, Joints
from motorcade.animation.formats.rig.transforms import Transforms, scaled_matrices
from motorcade.animation.formats.rig.values import RigSurface, Skin
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import along_axes, box_corners
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

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
