"""From what a file says to a `Character`, or to a skeleton with clips."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.formats.errors import FormatError, NoMeshError
from motorcade.animation.formats.limits import MAX_VALUES, check_count
from motorcade.animation.formats.rig.axes import axes_of, guessed_unit_m, is_plausible
from motorcade.animation.formats.rig.binding import Binding, bind
from motorcade.animation.formats.rig.joints import JointPoses, Joints, World, joint_poses, joints_of
from motorcade.animation.formats.rig.sampling import Sampler
from motorcade.animation.formats.rig.surfaces import BoundMesh, bound_mesh
from motorcade.animation.formats.rig.transforms import scaled_matrices
from motorcade.animation.formats.rig.values import Rig, RigClip
from motorcade.animation.morphs import MorphTrack
from motorcade.animation.skeleton import Skeleton, local_poses
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray

CONSTANT_SCALE = 1e-4
"""Scales that stay this near to the rest's, as a share of it, count as constant."""


@dataclass(frozen=True, eq=False)
class SkeletalMotion:
    r"""A skeleton with clips, and no mesh.

    Args:
        skeleton: with J joints; its rest pose is that in which the file's nodes stand.
        clips: motions of this skeleton.
        notices: what was left out or assumed when it was read.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from motorcade.animation import read_motion
    >>> lines = [
    ...     "HIERARCHY", "ROOT hips {", "OFFSET 0 0 0", "CHANNELS 3 Xposition Yposition Zposition",
    ...     "End Site {", "OFFSET 0 100 0", "}", "}",
    ...     "MOTION", "Frames: 2", "Frame Time: 0.5", "0 0 0", "0 0 90",
    ... ]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "step.bvh")
    ...     _ = path.write_text("\n".join(lines))
    ...     motion = read_motion(path)
    >>> len(motion.skeleton), [clip.duration_s for clip in motion.clips]
    (1, [0.5])
    """

    skeleton: Skeleton
    clips: tuple[Clip, ...]
    notices: tuple[str, ...]


def assemble_character(rig: Rig, unit_m: float | None) -> Character:
    """A character out of a rig with surfaces.

    Args:
        rig: what the file says.
        unit_m: length of the file's unit, where the caller knows it better than the file.

    Raises:
        FormatError: nothing that joints carry, or values that make no character.
    """
    if not rig.surfaces:
        raise NoMeshError("meshes: expected one or more, got none; read_motion reads the rest")
    stage = _Stance.of(rig, unit_m)
    binding = bind(stage.joints, stage.rest, rig.surfaces)
    mesh = bound_mesh(rig.tree, stage.joints, binding, rig.surfaces, stage.world)
    notices = [*stage.notices, *mesh.notices]
    if rig.clips or any(surface.skin is not None for surface in rig.surfaces):
        notices += _lost(stage.rest, mesh)
    soles_m = float(mesh.vertices[:, 2].min())
    lift = Motor.from_translation((0.0, 0.0, -soles_m))
    skeleton = _skeleton(stage.joints, lift @ binding.world)
    vertices = mesh.vertices - (0.0, 0.0, soles_m)
    if not binding.agrees:
        notices.append("its nodes stand in another pose than that in which the mesh was bound")
        soles_m = _lowest(skeleton, vertices, mesh, stage.rest, binding)
    stage = replace(stage, world=replace(stage.world, lowered_m=soles_m))
    watched = _carrying(stage.joints, mesh)
    height_m = float(max(vertices[:, 2].max(), 1e-6))
    clips, notice = stage.clips(rig, binding.scale, height_m, watched)
    keys = sum(len(times) for given in rig.clips for times, _ in given.weights.values())
    check_count("morph weights of all clips", keys * len(mesh.morphs), MAX_VALUES // 2)
    clips = tuple(
        replace(clip, morphs=_track(given, mesh))
        for clip, given in zip(clips, rig.clips, strict=True)
    )
    rest = joint_poses(rig.tree, stage.joints, rig.tree.rest[None], stage.world)
    growth = np.abs(rest.scale / binding.scale)
    return Character(
        skeleton,
        vertices,
        mesh.normals,
        mesh.triangles,
        mesh.colors,
        mesh.joints,
        mesh.weights,
        clips,
        (*notices, *notice),
        Similarity.from_motor_scale(stage.world.motor, stage.world.unit_m),
        _growing(stage.joints, rest.motors(), growth)[0],
        mesh.appearance,
        mesh.morphs,
    )


def assemble_motion(rig: Rig, unit_m: float | None) -> SkeletalMotion:
    """A skeleton at the rest of its nodes, with clips; meshes are not looked at.

    A rest pose that lies below the ground is lifted until its lowest joint is at z = 0; clips
    stay where the file puts them.

    Raises:
        FormatError: no joints, or values that make no skeleton.
    """
    stage = _Stance.of(rig, unit_m)
    local = stage.rest.motors()[0]
    skeleton = Skeleton(stage.joints.names, stage.joints.parents, local)
    lowest_m = float(skeleton.rest_world.translation_m[:, 2].min())
    if lowest_m < 0.0:
        lift = Motor.from_translation((0.0, 0.0, -lowest_m))
        skeleton = _skeleton(stage.joints, lift @ skeleton.rest_world)
    height_m = float(np.ptp(skeleton.rest_world.translation_m, axis=0).max())
    everything = np.ones(len(skeleton), dtype=bool)
    clips, notice = stage.clips(rig, stage.rest.scale[0], max(height_m, 1e-6), everything)
    return SkeletalMotion(skeleton, clips, (*stage.notices, *notice))


@dataclass(frozen=True, eq=False)
class _Stance:
    """Joints, the lie of the file's world, and the pose (1, J) in which the nodes stand."""

    joints: Joints
    world: World
    rest: JointPoses
    notices: tuple[str, ...]

    @staticmethod
    def of(rig: Rig, unit_m: float | None) -> _Stance:
        joints = joints_of(rig)
        plain = joint_poses(rig.tree, joints, rig.tree.rest[None], World(Rotor.identity(), 1.0))
        skeleton = Skeleton(joints.names, joints.parents, plain.motors()[0])
        places = skeleton.rest_world.translation_m
        axes = axes_of(rig, joints, places)
        notices = [*rig.notices, *axes.notices]
        unit = unit_m if unit_m is not None else rig.unit_m
        # Meshes may lie in units of their own: only where joints do not tell do they count.
        height = float(np.ptp(axes.turn.apply(places)[:, 2])) or _tallest(rig)
        unsure = rig.unit_checked and unit_m is None and not is_plausible(height * (unit or 1.0))
        if unit is None or unsure:
            unit, notice = guessed_unit_m(height)
            notices.append(notice)
        if joints.renamed:
            notices.append(f"{joints.renamed} joints without a name of their own were named")
        world = World(axes.turn, unit)
        rest = joint_poses(rig.tree, joints, rig.tree.rest[None], world)
        mirrored = int(np.count_nonzero(rest.scale[0] < 0.0))
        if mirrored:
            notices.append(f"{mirrored} joints are mirrored: their frames stay right-handed")
        return _Stance(joints, world, rest, tuple(notices))

    def clips(
        self, rig: Rig, reference: FloatArray, height_m: float, watched: NDArray[np.bool_]
    ) -> tuple[tuple[Clip, ...], list[str]]:
        """Clips over joints of reference scales (J,)."""
        if not rig.clips:
            return (), []
        sampler = Sampler(rig.tree, self.joints, self.world, height_m, watched)
        sampled = sampler(rig.clips)
        motors = sampled.poses.motors()
        growth = sampled.poses.scale / reference
        notices: list[str] = []
        if np.any(growth <= 0.0):
            notices.append("clips turn joints inside out: their mirroring was left out")
            growth = np.abs(growth)
        names: set[str] = set()
        made: list[Clip] = []
        for number, given in enumerate(rig.clips):
            name = _new_name(given.name, names)
            names.add(name)
            if name != given.name:
                notices.append(f"a clip called '{given.name}' is now '{name}'")
            where = slice(sampled.starts[number], sampled.starts[number + 1])
            poses = _growing(self.joints, motors[where], growth[where])
            made.append(_clip(given, name, sampled.times[number], poses))
        return tuple(made), notices


def _track(given: RigClip, mesh: BoundMesh) -> MorphTrack | None:
    """Weights of all targets; those that the clip does not move stay at rest."""
    if not given.weights:
        return None
    times = np.unique(np.concatenate([one for one, _ in given.weights.values()]))
    made = np.tile([target.weight for target in mesh.morphs], (len(times), 1))
    for column, (node, number) in enumerate(mesh.morph_nodes):
        if node in given.weights:
            own, values = given.weights[node]
            made[:, column] = np.interp(times, own, values[:, number])
    return MorphTrack(times, made)


def _clip(given: RigClip, name: str, times: FloatArray, poses: Motor | Similarity) -> Clip:
    keys = given.key_count or len(given.key_times)
    if given.looped and len(times) > 1:
        try:
            return Clip(name, times, poses, looped=True, key_count=keys)
        except ValueError as fault:
            raise FormatError(f"animation '{name}': said to repeat, but {fault}") from fault
    return Clip(name, times, poses, key_count=keys)


def _growing(joints: Joints, motors: Motor, growth: FloatArray) -> Motor | Similarity:
    """Poses (F, J), as similarities only where joints (F, J) really grow or shrink."""
    if np.abs(growth - 1.0).max(initial=0.0) <= CONSTANT_SCALE:
        return motors
    above = np.where(joints.parents < 0, 1.0, growth[:, joints.parents])
    steps = motors.translation_m / above[..., None]
    return Similarity.from_rotor_translation_scale(motors.rotor, steps, growth / above)


def _lowest(
    skeleton: Skeleton, vertices: FloatArray, mesh: BoundMesh, rest: JointPoses, binding: Binding
) -> float:
    """Height of the lowest vertex in the pose in which the nodes stand."""
    growth = np.abs(rest.scale[0] / binding.scale)
    world = scaled_matrices(skeleton.world(rest.motors()[0]), growth)
    rows = (world @ skeleton.rest_world_inverse.as_matrix())[:, 2]
    heights = np.einsum("vki,vi->vk", rows[mesh.joints, :3], vertices) + rows[mesh.joints, 3]
    return float(np.sum(heights * mesh.weights, axis=1).min())


def _lost(rest: JointPoses, mesh: BoundMesh) -> list[str]:
    """What shear and uneven scales move vertices by around their joints, in the nodes' pose."""
    if rest.lost is None:
        return []
    share = np.linalg.norm(rest.lost[0], axis=(1, 2)) / np.abs(rest.scale[0])
    most = float(share[np.unique(mesh.joints[mesh.weights > 0.0])].max())
    if most < 1e-4:
        return []
    return [
        "joints have shear or different scales an axis: the nearest uniform scales stand in, off "
        f"by up to {100.0 * most:.2g} % of the distance from a joint"
    ]


def _carrying(joints: Joints, mesh: BoundMesh) -> NDArray[np.bool_]:
    """Whether each joint (J,) or one below it carries vertices."""
    used = np.zeros(len(joints.nodes), dtype=bool)
    used[mesh.joints[mesh.weights > 0.0]] = True
    for joint in range(len(used) - 1, -1, -1):
        if used[joint] and joints.parents[joint] >= 0:
            used[joints.parents[joint]] = True
    return used


def _skeleton(joints: Joints, world: Motor) -> Skeleton:
    """A skeleton whose rest pose is `character_T_joint` (J,)."""
    return Skeleton(joints.names, joints.parents, local_poses(joints.parents, world))


def _new_name(wanted: str, taken: set[str]) -> str:
    """A name that is not taken yet."""
    name, count = wanted or "motion", 1
    while name in taken:
        count += 1
        name = f"{wanted or 'motion'}#{count}"
    return name


def _tallest(rig: Rig) -> float:
    """Largest side of the surfaces' boxes in the file's unit; 0 without any."""
    return max(
        (float(np.ptp(surface.vertices, axis=0).max()) for surface in rig.surfaces), default=0.0
    )
