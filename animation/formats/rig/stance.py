"""A rig made to stand: axes and unit found, bind pose upright on its soles, clips on the ground."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.clip import Clip
from motorcade.animation.formats.limits import FormatError
from motorcade.animation.formats.rig.axes import (
    Axes,
    Places,
    axes_of,
    axis_named,
    guessed_unit_m,
    is_plausible,
    nearer_unit_m,
)
from motorcade.animation.formats.rig.binding import Binding, bind
from motorcade.animation.formats.rig.joints import JointPoses, Joints, World, joint_poses, joints_of
from motorcade.animation.formats.rig.sampling import Sampler
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import Rig, RigClip
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray

CONSTANT_SCALE = 1e-4
"""Scales that stay this near to the rest's, as a share of it, count as constant."""
# Of so many clips so many poses each are looked at, and of no more nodes in all.
CLIPS_SEEN, POSES_SEEN, NODES_SEEN = 16, 16, 400_000
# Thigh and calf as a share of a standing person's height (Winter 2009).
LEG_SHARE = 0.49


@dataclass(frozen=True)
class Wanted:
    """What a caller knows better than the file.

    Args:
        unit_m: length of the file's unit.
        up: the axis of the file that is up, such as "z".
        front: the axis of the file that the figure faces at rest, such as "-y".
    """

    unit_m: float | None = None
    up: str | None = None
    front: str | None = None


@dataclass(frozen=True, eq=False)
class Stance:
    """Joints, how the file's world and axes lie, and the pose (1, J) in which the nodes stand."""

    joints: Joints
    world: World
    rest: JointPoses
    axes: Axes
    notices: tuple[str, ...]

    @staticmethod
    def of(rig: Rig, wanted: Wanted) -> Stance:
        """Find axes and unit. Raises FormatError: no joints; axes that are none."""
        joints = joints_of(rig)
        places = _places(rig, joints)
        up, front = axis_named(wanted.up, "up"), axis_named(wanted.front, "front")
        axes = axes_of(rig, joints, places, up, front)
        notices = [*rig.notices, *axes.notices]
        unit, notice = _unit_m(rig, axes, places, wanted.unit_m)
        notices += [notice] if notice else []
        if joints.renamed:
            notices.append(f"{joints.renamed} joints without a name of their own were named")
        world = World(axes.turn, unit)
        rest = joint_poses(rig.tree, joints, rig.tree.rest[None], world)
        mirrored = int(np.count_nonzero(rest.scale[0] < 0.0))
        if mirrored:
            notices.append(f"{mirrored} joints are mirrored: their frames stay right-handed")
        return Stance(joints, world, rest, axes, tuple(notices))

    def bound(self, rig: Rig) -> Binding:
        """The bind pose, turned to stand."""
        binding = bind(self.joints, self.rest, rig.surfaces)
        if not float(self.axes.standing.angle()):
            return binding
        return replace(
            binding,
            world=Motor.from_rotor_translation(self.axes.standing, np.zeros(3)) @ binding.world,
        )

    def seen(self, rig: Rig) -> list[JointPoses]:
        """Some poses (F, J) of each of some clips."""
        return [joint_poses(rig.tree, self.joints, nodes, self.world) for nodes in seen_nodes(rig)]

    def sheared(self, rig: Rig) -> dict[str, JointPoses]:
        """Some poses (F, J) of the nodes and each clip; of none where all joints scale evenly."""
        sheared_nodes = {} if self.rest.lost is None else {"the pose of its nodes": self.rest}
        every = zip(rig.clips, seen_nodes(rig, max(len(rig.clips), 1)), strict=True)
        return sheared_nodes | {
            f"clip '{clip.name}'": joint_poses(rig.tree, self.joints, nodes, self.world)
            for clip, nodes in every
            if nodes.blocks is not None or sheared_nodes
        }

    def blocks(self, poses: JointPoses) -> FloatArray:
        """Turns times scales (F, J, 3, 3) from the joints of poses to character space."""
        motors = poses.motors()
        skeleton = Skeleton(self.joints.names, self.joints.parents, motors[0])
        turns: FloatArray = skeleton.world(motors).rotor.as_matrix()
        return turns * poses.scale[..., None, None]

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
        clips: list[Clip] = []
        for number, clip in enumerate(rig.clips):
            name = new_name(clip.name, names)
            names.add(name)
            if name != clip.name:
                notices.append(f"a clip called '{clip.name}' is now '{name}'")
            where = slice(sampled.starts[number], sampled.starts[number + 1])
            poses = growing(self.joints, motors[where], growth[where])
            clips.append(_clip(clip, name, sampled.times[number], poses))
        return tuple(clips), notices


def _clip(rig_clip: RigClip, name: str, times: FloatArray, poses: Motor | Similarity) -> Clip:
    keys = rig_clip.key_count or len(rig_clip.key_times)
    if rig_clip.looped and len(times) > 1:
        try:
            return Clip(name, times, poses, looped=True, key_count=keys)
        except ValueError as fault:
            raise FormatError(f"animation '{name}': said to repeat, but {fault}") from fault
    return Clip(name, times, poses, key_count=keys)


def growing(joints: Joints, motors: Motor, growth: FloatArray) -> Motor | Similarity:
    """Poses (F, J), as similarities only where joints (F, J) really grow or shrink."""
    if np.abs(growth - 1.0).max(initial=0.0) <= CONSTANT_SCALE:
        return motors
    above = np.where(joints.parents < 0, 1.0, growth[:, joints.parents])
    steps = motors.translation_m / above[..., None]
    return Similarity.from_rotor_translation_scale(motors.rotor, steps, growth / above)


def new_name(wanted: str, taken: set[str]) -> str:
    """A name that is not taken yet."""
    name, count = wanted or "motion", 1
    while name in taken:
        count += 1
        name = f"{wanted or 'motion'}#{count}"
    return name


def seen_nodes(rig: Rig, most: int = CLIPS_SEEN) -> list[Transforms]:
    """Nodes (F, N) in some poses of each of so many clips."""
    each = max(2, min(POSES_SEEN, NODES_SEEN // (most * len(rig.tree.names))))
    step = max(1, -(-len(rig.clips) // most))
    seen = []
    for clip in rig.clips[::step]:
        keys = clip.key_times
        seen.append(clip.at(np.unique(np.linspace(keys[0], keys[-1], each))))
    return seen


def _places(rig: Rig, joints: Joints) -> Places:
    plain = World(Rotor.identity(), 1.0)
    rest = joint_poses(rig.tree, joints, rig.tree.rest[None], plain)
    skeleton = Skeleton(joints.names, joints.parents, rest.motors()[0])
    binding = bind(joints, rest, rig.surfaces) if rig.surfaces else None
    translation_m = skeleton.rest_world.translation_m
    bound = translation_m if binding is None else binding.world.translation_m
    moving = [
        skeleton.world(joint_poses(rig.tree, joints, nodes, plain).motors()).translation_m
        for nodes in seen_nodes(rig)
    ]
    return Places(
        bound,
        translation_m,
        np.concatenate(moving) if moving else None,
        None if binding is None else _skin(rig, joints, binding),
    )


def _skin(rig: Rig, joints: Joints, binding: Binding) -> FloatArray:
    """The centre (J, 3) of the vertices that mostly follow each joint; NaN for none."""
    sums, counts = np.zeros((len(joints.nodes), 3)), np.zeros(len(joints.nodes))
    frames = binding.frames()
    skins: dict[int, tuple[IntArray, FloatArray]] = {}
    for surface in rig.surfaces:
        if surface.skin is None or not surface.weights.size:
            continue
        if id(surface.skin) not in skins:
            own = np.searchsorted(joints.nodes, surface.skin.nodes)
            skins[id(surface.skin)] = own, frames[own] @ surface.skin.inverse_bind
        own, placed = skins[id(surface.skin)]
        rows = np.arange(len(surface.vertices))
        inside = surface.influences[rows, np.argmax(surface.weights, axis=1)]
        matrices = placed[inside]
        at = np.einsum("vij,vj->vi", matrices[:, :3, :3], surface.vertices) + matrices[:, :3, 3]
        np.add.at(sums, own[inside], at)
        np.add.at(counts, own[inside], 1.0)
    return np.asarray(np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], np.nan))


def _unit_m(rig: Rig, axes: Axes, places: Places, value: float | None) -> tuple[float, str]:
    """The length of the file's unit, and a notice where it was guessed."""
    if value is not None:
        return value, ""
    # Meshes may lie in units of their own: only where joints do not tell do they count.
    turned = (axes.standing @ axes.turn).apply(places.bound)
    height = float(np.ptp(turned[:, 2])) or _tallest(rig) or float(np.ptp(turned, axis=0).max())
    evidence = axes.body.evidence
    if evidence is not None and evidence.legs is not None and not axes.body.four_legged:
        bones = np.diff(places.bound[evidence.legs], axis=0)
        legs = float(np.linalg.norm(bones, axis=-1).sum(axis=0).mean())
        if not rig.surfaces:  # a rest that does not stand is no measure of height
            height = legs / LEG_SHARE
    unit = rig.unit_m
    doubted = rig.unit_checked or evidence is not None  # of limbs one knows how long they are
    unsure = unit is not None and doubted and not is_plausible(height * unit)
    if unit is None:
        return guessed_unit_m(height)
    if not unsure and not doubted and not is_plausible(height * unit):
        return unit, (
            f"it is {height * unit:.4g} m large as its file says, which few things are that stand "
            "in footage: state its height where that is not meant"
        )
    return nearer_unit_m(height, unit) if unsure else (unit, "")


def _tallest(rig: Rig) -> float:
    """Largest side of the surfaces' boxes in the file's unit; 0 without any."""
    return max(
        (float(np.ptp(surface.vertices, axis=0).max()) for surface in rig.surfaces), default=0.0
    )
