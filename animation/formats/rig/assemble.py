"""From what a file says to a `Character` on its soles, or to a skeleton with clips."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip, MorphTrack
from motorcade.animation.formats.limits import MAX_VALUES, NoMeshError, check_count, expected
from motorcade.animation.formats.rig.joints import Binding, JointPoses, Joints, joint_poses
from motorcade.animation.formats.rig.stance import Stance, Wanted, growing
from motorcade.animation.formats.rig.surfaces import BoundMesh, bound_mesh
from motorcade.animation.formats.rig.values import Rig, RigClip, scaled_matrices
from motorcade.animation.skeleton import Skeleton, at_or_below, local_poses
from motorcade.animation.vectors import turn_z, unit
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray

# Of vertices so many are looked at for lost scale, which is told beyond this share of the height.
VERTICES_SEEN, LOST = 2000, 1e-4
# What is no larger has no size.
LEAST_M = 1e-6


@dataclass(frozen=True, eq=False)
class SkeletalMotion:
    r"""A skeleton with clips, and no mesh.

    Args:
        skeleton: with J joints; see `assemble_motion` on its rest pose.
        clips: motions of this skeleton.
        notices: what was left out or assumed when it was read.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from motorcade.animation.formats import read_motion
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


def assemble_character(rig: Rig, wanted: Wanted) -> Character:
    """A character out of a rig with surfaces.

    Args:
        rig: what the file says.
        wanted: what the caller knows better than the file.

    Raises:
        FormatError: nothing that joints carry, or values that make no character.
    """
    if not rig.surfaces:
        raise NoMeshError("meshes: expected one or more, got none; read_motion reads the rest")
    stage = Stance.of(rig, wanted)
    binding = stage.bound(rig)
    mesh = bound_mesh(rig.tree, stage.joints, binding, rig.surfaces, stage.world)
    if float(np.ptp(mesh.vertices, axis=0).max()) <= LEAST_M:
        raise expected("meshes", "vertices apart", "all at one point, as of nodes of scale 0")
    notices = [*stage.notices, *mesh.notices]
    if rig.clips or any(surface.skin is not None for surface in rig.surfaces):
        notices += _lost(rig, stage, mesh, binding)
    soles = Soles.of(stage, mesh, binding, rig.settled)
    lift = Motor.from_translation((0.0, 0.0, -soles.bound_m))
    skeleton = _skeleton(stage.joints, lift @ binding.world)
    vertices = mesh.vertices - (0.0, 0.0, soles.bound_m)
    height_m = float(max(vertices[:, 2].max(), LEAST_M))
    if not binding.agrees:
        notices.append("its nodes stand in another pose than that in which the mesh was bound")
    lowered_m, notice = soles.ground_m(stage.rest, stage.seen(rig), height_m)
    notices += notice
    stage = replace(stage, world=replace(stage.world, lowered_m=lowered_m))
    watched = _carrying(stage.joints, mesh)
    clips, notice = stage.clips(rig, binding.scale, height_m, watched)
    keys = sum(len(times) for given in rig.clips for times, _ in given.weights.values())
    check_count("morph weights of all clips", keys * len(mesh.morphs), MAX_VALUES // 2)
    clips = tuple(
        replace(clip, morphs=_track(rig_clip, mesh))
        for clip, rig_clip in zip(clips, rig.clips, strict=True)
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
        growing(stage.joints, rest.motors(), growth)[0],
        mesh.appearance,
        mesh.morphs,
    )


def assemble_motion(rig: Rig, wanted: Wanted) -> SkeletalMotion:
    """A skeleton with clips; meshes tell no more than the bind pose.

    At rest it stands as its mesh was bound; without a mesh as its nodes do or, where nobody can
    stand so, as at the moment of its clips that is most like standing. A rest pose that lies below
    the ground or hangs in the air is put on it by its lowest joint; clips stay where the file puts
    them, unless their feet stand on another height than the file's own zero.

    Raises:
        FormatError: no joints, or values that make no skeleton.
    """
    stage = Stance.of(rig, wanted)
    skinned = any(surface.skin is not None for surface in rig.surfaces)
    scale, notices = stage.rest.scale[0], list(stage.notices)
    if skinned:
        binding = stage.bound(rig)
        world, scale = binding.world, binding.scale
    else:
        world, notice = resting(stage, rig)
        notices += notice
    at = world.translation_m
    height_m = max(float(np.ptp(at, axis=0).max()), LEAST_M)
    lowest_m = float(at[:, 2].min())
    if lowest_m < 0.0 or lowest_m > IN_THE_AIR * height_m:
        world = Motor.from_translation((0.0, 0.0, -lowest_m)) @ world
    skeleton = _skeleton(stage.joints, world)
    lowered_m = 0.0 if rig.settled else standing_joints_m(stage, rig, height_m)
    if lowered_m:
        notices.append(
            f"its clips stand {lowered_m:+.3f} m over the file's zero: put on the ground"
        )
        stage = replace(stage, world=replace(stage.world, lowered_m=lowered_m))
    everything = np.ones(len(skeleton), dtype=bool)
    clips, notice = stage.clips(rig, scale, height_m, everything)
    return SkeletalMotion(skeleton, clips, (*notices, *notice))


def _track(rig_clip: RigClip, mesh: BoundMesh) -> MorphTrack | None:
    """Weights of all targets; those that the clip does not move stay at rest."""
    if not rig_clip.weights:
        return None
    times = np.unique(np.concatenate([one for one, _ in rig_clip.weights.values()]))
    weights = np.tile([target.weight for target in mesh.morphs], (len(times), 1))
    for column, (node, number) in enumerate(mesh.morph_nodes):
        if node in rig_clip.weights:
            own, values = rig_clip.weights[node]
            weights[:, column] = np.interp(times, own, values[:, number])
    return MorphTrack(times, weights)


def _lost(rig: Rig, stage: Stance, mesh: BoundMesh, binding: Binding) -> list[str]:
    """How far shear and uneven scales, in the nodes' pose and all clips, would move vertices on.

    What hangs on a node without a skin was placed by all the shear that the node has as it stands:
    of that it loses nothing, but for what clips change.
    """
    sheared = stage.sheared(rig)
    if not sheared:
        return []
    rows = np.arange(0, len(mesh.vertices), -(-len(mesh.vertices) // VERTICES_SEEN))
    joints, weights = mesh.joints[rows], mesh.weights[rows]
    frames = np.linalg.inv(binding.frames())[joints]
    places = np.einsum("vkij,vj->vki", frames[..., :3, :3], mesh.vertices[rows])
    places += frames[..., :3, 3]
    height_m, most, where = float(np.ptp(mesh.vertices[:, 2])) or 1.0, 0.0, ""
    hanging = np.repeat(
        [surface.skin is None for surface in rig.surfaces],
        [len(surface.vertices) for surface in rig.surfaces],
    )[rows]
    resting = stage.blocks(stage.rest)[0]
    bound = resting if stage.rest.lost is None else resting + stage.rest.lost[0]
    placed = np.linalg.pinv(bound, rcond=1e-9) @ resting
    for name, nodes in sheared.items():
        lost = np.zeros((len(nodes.scale), 1, 3, 3)) if nodes.lost is None else nodes.lost
        near = stage.blocks(nodes)
        hung = (near + lost) @ placed - near
        for own, other in zip(np.broadcast_to(lost, near.shape), hung, strict=True):
            beyond = np.where(hanging[:, None, None, None], other[joints], own[joints])
            shift = np.einsum("vk,vkij,vkj->vi", weights, beyond, places)
            worst = float(np.linalg.norm(shift, axis=1).max())
            if worst > most:
                most, where = worst, name
    if most < LOST * height_m:
        return []
    return [
        "joints have shear or different scales an axis: the nearest uniform scales stand in, off "
        f"by up to {1e3 * most:.3g} mm, {100.0 * most / height_m:.2g} % of its height, in {where}"
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


# Of a foot's vertices the lowest so many are sole enough to find the ground by.
SOLE_VERTICES = 100
FEWEST_VERTICES = 3
# The share of a clip's moments, the lowest, below which its feet are taken to stand.
LOW_SHARE = 0.1
# Heights that differ by less, as a share of the figure's, are one ground; clips farther off fly.
ONE_GROUND, FLYING = 0.01, 0.25
# Joints of soles lie over them: only clips farther off their file's zero are put on the ground.
IN_THE_AIR = 0.03
# The trunk and the legs of a rest in which one can stand, against up.
UPRIGHT = np.cos(np.radians(50.0))


@dataclass(frozen=True, eq=False)
class Soles:
    """Vertices of the feet, or of the whole mesh where no feet are known.

    Args:
        bound_m: height of the lowest in the bind pose, not lifted.
        rows: their numbers.
        mesh, binding, stage: of the figure.
        settled: whether the bind pose is known to stand where clips do.
    """

    bound_m: float
    rows: IntArray
    mesh: BoundMesh
    binding: Binding
    stage: Stance
    settled: bool = False

    @staticmethod
    def of(stage: Stance, mesh: BoundMesh, binding: Binding, settled: bool = False) -> Soles:
        """The vertices that mostly follow feet or toes (of an animal, forefeet too)."""
        heaviest = mesh.joints[np.arange(len(mesh.joints)), np.argmax(mesh.weights, axis=1)]
        lowest_rows: list[IntArray] = []
        for foot in _feet(stage):
            below = at_or_below(stage.joints.parents, foot)
            rows = np.flatnonzero(below[heaviest])
            if len(rows) < FEWEST_VERTICES:
                lowest_rows = []
                break
            lowest_rows.append(
                rows[np.argsort(mesh.vertices[rows, 2], kind="stable")[:SOLE_VERTICES]]
            )
        if lowest_rows:
            rows = np.concatenate(lowest_rows)
            lowest = float(mesh.vertices[rows, 2].min())
            return Soles(lowest, rows, mesh, binding, stage, settled)
        rows = np.argsort(mesh.vertices[:, 2], kind="stable")[:SOLE_VERTICES]
        return Soles(float(mesh.vertices[:, 2].min()), rows, mesh, binding, stage, settled)

    def heights(self, poses: JointPoses) -> FloatArray:
        """Height (F,) of the lowest of the vertices, skinned linearly, in the file's own world."""
        joints = self.stage.joints
        skeleton = Skeleton(joints.names, joints.parents, poses.motors()[0])
        growth = np.abs(poses.scale / self.binding.scale)
        world = scaled_matrices(skeleton.world(poses.motors()), growth)
        rows = (world @ self.binding.world.inverse().as_matrix())[:, :, 2]
        each = rows[:, self.mesh.joints[self.rows]]
        vertices = self.mesh.vertices[self.rows]
        heights = np.einsum("fvki,vi->fvk", each[..., :3], vertices) + each[..., 3]
        lowest: FloatArray = np.sum(heights * self.mesh.weights[self.rows], axis=2).min(axis=1)
        return lowest

    def ground_m(
        self, poses: JointPoses, clips: list[JointPoses], height_m: float
    ) -> tuple[float, list[str]]:
        """Height of the ground in the file's world, and a notice where clips tell another.

        Clips tell, where most of them stand on one height; else the bind pose, or the pose in
        which the nodes stand if that is another.

        Args:
            poses: the nodes' pose (1, J).
            clips: some poses (F, J) of each.
            height_m: of the figure.
        """
        own = self.bound_m
        if not self.binding.agrees or float(self.stage.axes.standing.angle()) > 0.0:
            own = float(self.heights(poses)[0])
        levels = [float(np.quantile(self.heights(one), LOW_SHARE)) for one in clips]
        if self.binding.agrees:
            levels = [one for one in levels if abs(one - own) < FLYING * height_m]
        if not levels or self.settled:
            return own, []
        near = [[b for b in levels if abs(b - a) <= ONE_GROUND * height_m] for a in levels]
        most = max(near, key=lambda group: (len(group), -abs(group[0] - own)))
        ground = float(np.median(most))
        if 2 * len(most) < len(levels) or (
            self.binding.agrees and abs(ground - own) <= ONE_GROUND * height_m
        ):
            return own, []
        if not self.binding.agrees:
            return ground, []
        return ground, [
            f"its clips stand {100.0 * (ground - own) / height_m:+.1f} % of its height over the "
            "soles of its bind pose: put on the ground by the clips"
        ]


def standing_joints_m(stage: Stance, rig: Rig, height_m: float) -> float:
    """Height on which the joints of feet stand in clips without a mesh; 0 where near zero."""
    feet = np.flatnonzero(at_or_below(stage.joints.parents, _feet(stage)))
    lows = [
        np.quantile(_places(stage, nodes)[:, feet, 2].min(axis=1), LOW_SHARE)
        for nodes in (stage.seen(rig) if len(feet) else [])
    ]
    lowest = float(np.median(lows)) if lows else 0.0
    return lowest if abs(lowest) > IN_THE_AIR * height_m else 0.0


def resting(stage: Stance, rig: Rig) -> tuple[Motor, list[str]]:
    """Motor (J,) `character_T_joint` of a rest pose to stand in, and a notice if it is a clip's."""
    joints = stage.joints
    skeleton = Skeleton(joints.names, joints.parents, stage.rest.motors()[0])
    turned = Motor.from_rotor_translation(stage.axes.standing, np.zeros(3)) @ skeleton.rest_world
    likeness = _standing_likeness(stage, turned.translation_m[None])
    if likeness is None or likeness[0] > UPRIGHT or not rig.clips:
        return turned, []
    best, most = None, -np.inf
    for poses in stage.seen(rig):
        world = skeleton.world(poses.motors())
        by_moment = _standing_likeness(stage, world.translation_m)
        assert by_moment is not None  # the same joints as above
        number = int(np.argmax(by_moment))
        if by_moment[number] > most:
            best, most = world[number], float(by_moment[number])
    if best is None or most <= UPRIGHT:
        return turned, []
    across, _ = _across(stage, best.translation_m[None])
    heading = turn_z(np.arctan2(across[0, 0], across[0, 1]))
    foot = best.translation_m[stage.axes.body.roles["hips"]] * [1.0, 1.0, 0.0]
    stood = Motor.from_rotor_translation(heading, -heading.apply(foot)) @ best
    return stood, ["nobody can stand as its joints rest: a moment of its clips is its rest pose"]


def _standing_likeness(stage: Stance, at: FloatArray) -> FloatArray | None:
    """The least cosine (F,) of trunk and legs against up; None where they are not known."""
    evidence = stage.axes.body.evidence
    if evidence is None or evidence.legs is None or "hips" not in stage.axes.body.roles:
        return None
    if stage.axes.body.four_legged:
        return None
    _, trunk = evidence.axes(at)
    hip, knee, ankle = (at[:, joints] for joints in evidence.legs)
    parts = [trunk[:, None], unit(hip - knee), unit(knee - ankle)]
    likeness: FloatArray = np.concatenate([one[..., 2] for one in parts], axis=1).min(axis=1)
    return likeness


def _across(stage: Stance, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """From right to left, and along the trunk."""
    body = stage.axes.body
    assert body.evidence is not None  # looked at before
    across, trunk = body.evidence.axes(at)
    legs = body.evidence.legs
    first = legs is None or int(legs[0, 0]) == body.roles["left_thigh"]
    return across if first else -across, trunk


def _places(stage: Stance, poses: JointPoses) -> FloatArray:
    joints = stage.joints
    skeleton = Skeleton(joints.names, joints.parents, poses.motors()[0])
    return skeleton.world(poses.motors()).translation_m


def _feet(stage: Stance) -> list[int]:
    body = stage.axes.body
    wanted = ["left_foot", "right_foot"]
    if body.four_legged:
        wanted += ["left_hand", "right_hand"]
    return [body.roles[role] for role in wanted if role in body.roles]
