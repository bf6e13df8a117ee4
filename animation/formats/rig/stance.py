"""A rig made to stand: which way is up and ahead, its unit, the bind pose on its soles, its clips.

Formats fix some of this and leave the rest to habit. The bind pose tells first: limbs tell up and
sides, feet and bends the front; then motions; names of toes, feet and head where there are no two
limbs alike. A height tells the unit. What is told so, or merely assumed, becomes a notice.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.anatomy.body import Body, body_from
from motorcade.animation.anatomy.tree import JointTree
from motorcade.animation.clip import Clip
from motorcade.animation.formats.limits import FormatError, expected
from motorcade.animation.formats.rig.joints import (
    Binding,
    JointPoses,
    Joints,
    World,
    bind,
    joint_poses,
    joints_of,
)
from motorcade.animation.formats.rig.sampling import Sampler
from motorcade.animation.formats.rig.values import Rig, RigClip, Transforms
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import unit
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray

TOES = re.compile(r"toe|ball|foot.?thumb", re.IGNORECASE)
FEET = re.compile(r"foot|ankle", re.IGNORECASE)
HEAD = re.compile(r"head|neck", re.IGNORECASE)
CONTROLS = re.compile(r"ik\b|\bik|control|roll", re.IGNORECASE)

UNITS_M = {
    "metre": 1.0,
    "centimetre": 0.01,
    "inch": 0.0254,
    "CMU's 0.0564 m": 0.0254 / 0.45,
    "decimetre": 0.1,
    "millimetre": 0.001,
}
USUAL_HEIGHT_M = 1.7
PLAUSIBLE_M = (0.05, 20.0)
# Toes that point this far from an axis of the file do not tell which one was meant.
CLEAR_COSINE = 0.8
# A trunk this near to what is up stands; a mean over a motion that is this long tells up.
UPRIGHT_COSINE, CLEAR_MEAN = 0.5, 0.7
# Fronts this near to an axis of the file lie along it.
NEAR_AXIS_COSINE = np.cos(np.radians(25.0))
AXIS_NAMES = {
    f"{sign}{name}": tuple(value * float(k == at) for k in range(3))
    for at, name in enumerate("xyz")
    for sign, value in (("", 1.0), ("+", 1.0), ("-", -1.0))
}
"""Axes of a file as callers say them."""


@dataclass(frozen=True, eq=False)
class Places:
    """Where joints lie in the file's frame and unit.

    Args:
        bound: (J, 3) in the bind pose.
        standing: (J, 3) as the nodes stand.
        moving: (F, J, 3) in poses of the clips; None without clips.
        skin: (J, 3) centre of the vertices that follow each joint, NaN for none; None without mesh.
    """

    bound: FloatArray
    standing: FloatArray
    moving: FloatArray | None = None
    skin: FloatArray | None = None


def axis_named(name: str | None, option: str) -> FloatArray | None:
    """The unit vector (3,) of an axis such as "-y"; None of None.

    Raises FormatError: another word.
    """
    if name is None:
        return None
    if name not in AXIS_NAMES:
        raise expected(option, "one of x, -x, y, -y, z, -z", name)
    return np.array(AXIS_NAMES[name])


@dataclass(frozen=True, eq=False)
class Axes:
    """How the file's frame lies in that of characters, and how the bind pose is turned to stand.

    Args:
        turn: Rotor from the file's frame to z up, facing +x.
        notices: what was assumed.
        body: what the joints are, in the file's frame.
        standing: Rotor that turns the bind pose on, in character space, until it stands and faces
            +x; identity where it does.
    """

    turn: Rotor
    notices: tuple[str, ...]
    body: Body
    standing: Rotor


def axes_of(
    rig: Rig,
    joints: Joints,
    places: Places,
    up: FloatArray | None = None,
    front: FloatArray | None = None,
) -> Axes:
    """Find the rotation from the file's axes to those of characters.

    `up` and `front` (3,) are unit vectors of the file, where the caller knows them better.
    """
    tree = JointTree(joints.names, joints.parents, places.bound)
    notices: list[str] = []
    upward, notice = (up, "") if up is not None else _upward(rig, joints, tree, places)
    notices += [notice] if notice else []
    usual = _usual_forward(upward)
    if rig.forward is not None and abs(float(np.dot(rig.forward, upward))) < CLEAR_COSINE:
        usual = np.array(rig.forward)
    body = body_from(tree, upward, usual, motion=places.moving, skin=places.skin)
    stands = body.up is None or float(body.up @ upward) > UPRIGHT_COSINE
    if front is not None and abs(float(front @ upward)) < CLEAR_COSINE:
        ahead = front
    elif front is not None:
        across = f"an axis across {_axis_name(upward)}, which is up"
        raise expected("front", across, _axis_name(front))
    elif body.up is None or body.evidence is None:
        ahead, front_notice = _named_front(rig, joints, places.bound, upward, usual)
        notices += [front_notice] if front_notice else []
    else:
        seen = body.ahead if stands else _front_of_motion(body, places, upward)
        ahead, front_notice = _front(rig, body, seen, upward, usual)
        notices += [front_notice] if front_notice else []
    ahead = unit(ahead - (ahead @ upward) * upward)
    turn = Rotor.from_matrix(np.stack([ahead, np.cross(upward, ahead), upward]))
    faced = front if front is not None else body.ahead
    return Axes(turn, tuple(notices), body, _standing(body.up, faced, turn, stands))


def _upward(rig: Rig, joints: Joints, tree: JointTree, places: Places) -> tuple[FloatArray, str]:
    """What is up in the file's frame, and a notice where the file does not say or seems wrong."""
    stated = None if rig.up is None else np.array(rig.up)
    body = body_from(tree, stated)
    trunk = None
    if body.evidence is not None and not body.four_legged:
        poses = places.standing[None] if places.moving is None else places.moving
        mean = body.evidence.axes(poses)[1].mean(axis=0)
        trunk = mean if float(np.linalg.norm(mean)) > CLEAR_MEAN else None
    if stated is not None:
        rest = body.up
        wrong = rest is not None and float(rest @ stated) < UPRIGHT_COSINE
        if not wrong or rest is None:
            return stated, ""
        axis = _nearest_axis(rest)
        if not body.four_legged and (trunk is None or float(unit(trunk) @ axis) < CLEAR_COSINE):
            return stated, ""  # the bind pose lies, the figure stands
        return axis, (
            f"the file says that {_axis_name(stated)} is up, but the figure stands along "
            f"{_axis_name(axis)}: stood up; say another with --up"
        )
    if trunk is not None and places.moving is not None:
        axis, by = _nearest_axis(trunk), "its motion"
    elif body.up is not None:
        axis, by = _nearest_axis(body.up), "its limbs"
    else:
        axis, by = _up(joints, tree.at)
    return axis, (
        f"the file does not say which way is up: {_axis_name(axis)} by {by}; say another with --up"
    )


def _named_front(
    rig: Rig, joints: Joints, places: FloatArray, up: FloatArray, usual: FloatArray
) -> tuple[FloatArray, str]:
    """The front by names of toes, or by habit, and a notice."""
    seen = _facing(joints, places, up)
    if seen is None:
        return usual, (
            f"no toes tell the facing: assumed {_axis_name(usual)}; say another with --front"
        )
    if rig.forward is not None and seen @ usual < 0.9:
        return seen, (
            f"its toes point to {_axis_name(seen)} where the format says "
            f"{_axis_name(usual)}: turned by the toes"
        )
    return seen, ""


def _front(
    rig: Rig, body: Body, seen: FloatArray | None, up: FloatArray, usual: FloatArray
) -> tuple[FloatArray, str]:
    """The front that limbs tell, along an axis where it is near one, and a notice."""
    if seen is None:
        return usual, (
            f"neither feet nor bends nor motion tell the front: assumed {_axis_name(usual)}; "
            "say another, as --front=-x"
        )
    level = unit(seen - (seen @ up) * up)
    axis = _nearest_axis(level)
    ahead = axis if float(level @ axis) > NEAR_AXIS_COSINE else level
    stated = rig.forward is not None and float(np.dot(rig.forward, usual)) > CLEAR_COSINE
    if stated and float(ahead @ usual) < 0.9:
        return ahead, (
            f"it faces {_axis_name(axis)} by its {body.told_by} where the format says "
            f"{_axis_name(usual)}: turned by the {body.told_by}"
        )
    return ahead, ""


def _front_of_motion(body: Body, places: Places, up: FloatArray) -> FloatArray | None:
    """Where a figure faces as its clips begin, whose bind pose does not stand."""
    if body.evidence is None or body.ahead is None:
        return None
    poses = places.standing[None] if places.moving is None else places.moving
    first = "left_thigh" if body.evidence.legs is not None else "left_upper_arm"
    limb = body.evidence.legs if body.evidence.legs is not None else body.evidence.arms
    assert limb is not None  # a body has one of them
    sign = 1.0 if body.roles[first] == int(limb[0, 0]) else -1.0
    across, trunk = body.evidence.axes(poses)
    upright = trunk @ up > CLEAR_COSINE
    if not np.any(upright):
        return None
    front = unit(sign * np.cross(across[upright][:1], up))
    return np.asarray(front[0])


def _standing(
    own_up: FloatArray | None, faced: FloatArray | None, turn: Rotor, stands: bool
) -> Rotor:
    """The turn of the bind pose in character space until it stands and faces +x."""
    if own_up is None:
        return Rotor.identity()
    up = turn.apply(own_up)
    ahead = turn.apply(faced) if faced is not None else np.array([1.0, 0.0, 0.0])
    if stands and ahead[0] > NEAR_AXIS_COSINE:
        return Rotor.identity()
    side = unit(np.cross(up, ahead))
    rows = np.stack([np.cross(side, up), side, up])
    quarter = np.round(rows)
    near = np.abs(rows).max(axis=1).min() > NEAR_AXIS_COSINE
    if near and abs(float(np.linalg.det(quarter)) - 1.0) < 1e-9:
        rows = quarter
    return Rotor.from_matrix(rows)


def guessed_unit_m(height: float) -> tuple[float, str]:
    """The unit that brings a height nearest to that of a grown person, and a notice."""
    if height <= 0.0:
        return 1.0, "its unit is not known, and it has no size that tells: taken as metre"
    name = min(UNITS_M, key=lambda unit: _unlikely(height * UNITS_M[unit]))
    height_m = height * UNITS_M[name]
    if not is_plausible(height_m):
        return UNITS_M[name], (
            f"no unit in use makes a figure of a height of {height:.3g}: taken as {name}, which "
            f"makes it {height_m:.3g} m large"
        )
    return UNITS_M[name], (
        f"its unit is not known: taken as {name}, which makes it {height_m:.2f} m large"
    )


def nearer_unit_m(height: float, unit_m: float) -> tuple[float, str]:
    """What stands for a unit that makes no plausible height: a hundredth or a thousandth of it.

    Files are written in centimetres or millimetres that say metres; else as where none is stated.
    """
    parts = {"centimetre": 0.01, "millimetre": 0.001, "hundred metres": 100.0}
    name = min(parts, key=lambda unit: _unlikely(height * unit_m * parts[unit]))
    height_m = height * unit_m * parts[name]
    if not is_plausible(height_m):
        return guessed_unit_m(height)
    return unit_m * parts[name], (
        f"its unit is not known, {height * unit_m:.4g} m is no height of a figure: taken "
        f"as {name}, which makes it {height_m:.2f} m large"
    )


def _unlikely(height_m: float) -> float:
    """How far a height is from that of a grown person, as a ratio."""
    return abs(float(np.log(max(height_m, 1e-12) / USUAL_HEIGHT_M)))


def is_plausible(height_m: float) -> bool:
    """Whether a figure may well be that tall."""
    return PLAUSIBLE_M[0] <= height_m <= PLAUSIBLE_M[1]


def _up(joints: Joints, places: FloatArray) -> tuple[FloatArray, str]:
    """The axis from the feet to the head, or the longest one, or +y; and how it was told."""
    head = [place for name, place in zip(joints.names, places, strict=True) if HEAD.search(name)]
    feet = [
        place
        for name, place in zip(joints.names, places, strict=True)
        if (FEET.search(name) or TOES.search(name))
    ]
    if head and feet:
        return _nearest_axis(np.mean(head, axis=0) - np.mean(feet, axis=0)), "head and feet"
    return np.array([0.0, 1.0, 0.0]), "habit"


def _facing(joints: Joints, places: FloatArray, up: FloatArray) -> FloatArray | None:
    """The axis along which the toes point, or None where they do not tell."""
    steps = []
    for joint, name in enumerate(joints.names):
        parent = int(joints.parents[joint])
        if parent < 0 or not TOES.search(name) or not FEET.search(joints.names[parent]):
            continue
        if CONTROLS.search(name) or CONTROLS.search(joints.names[parent]):
            continue
        step = places[joint] - places[parent]
        level = step - (step @ up) * up
        length = float(np.linalg.norm(level))
        if length > 1e-9:
            steps.append(level / length)
    if not steps:
        return None
    mean = np.mean(steps, axis=0)
    axis = _nearest_axis(mean)
    return axis if float(mean @ axis) > CLEAR_COSINE else None


def _usual_forward(up: FloatArray) -> FloatArray:
    """Where figures face by habit: −y where z is up, else +z, else +y."""
    if abs(up[2]) > 0.5:
        return np.array([0.0, -1.0, 0.0])
    return np.array([0.0, 0.0, 1.0])


def _nearest_axis(vector: FloatArray) -> FloatArray:
    axis = np.zeros(3)
    largest = int(np.argmax(np.abs(vector)))
    axis[largest] = 1.0 if vector[largest] >= 0.0 else -1.0
    return axis


def _axis_name(axis: FloatArray) -> str:
    largest = int(np.argmax(np.abs(axis)))
    return f"{'+' if axis[largest] > 0.0 else '-'}{'xyz'[largest]}"


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
        places = _joint_places(rig, joints)
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


def _joint_places(rig: Rig, joints: Joints) -> Places:
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
    boxes = (float(np.ptp(surface.vertices, axis=0).max()) for surface in rig.surfaces)
    height = float(np.ptp(turned[:, 2])) or max(boxes, default=0.0)
    height = height or float(np.ptp(turned, axis=0).max())
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
