"""Feet on the ground: stances found in a motion, held where they are, and nothing below ground.

A foot in stance neither slides nor turns: over each stance its ball is held over one place of the
ground and its heading is kept; what that takes is faded in and out over the swings between. The
ball's height is shifted as a whole, so that it comes down and rises as it did. Where its heel or
toes would sink the foot is turned about the ball; else it keeps its orientation. A foot that swings
is lifted, between toe-off and landing, where heel, ball or toes would graze. Then the leg is bent
to it, and the hips are lowered where a leg would not reach.

Where a foot's heel and toes are is known from the rest pose, in which soles lie on z = 0: the heel
behind the ankle and the tip before the ball by shares of the way between the two. Boots are longer
and wider: their edges are known where a mesh was measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.easing import smootherstep, smoothstep
from motorcade.animation.ik.chain import bend_limb
from motorcade.animation.skeleton import Skeleton, at_or_below, turned_joint, with_joint
from motorcade.animation.vectors import UP, shortest_turn, turn_z
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# The clearance of a swinging foot as a share of the leg's length, as toes of walkers have it at the
# least (13 mm, Winter 1992), and at most so much of the way that the foot goes in the swing.
CLEAR, CLEAR_OF_WAY = 0.014, 0.05
# Toe-off and landing: how long a swing takes to come to its clearance, and to give it up; and how
# far a lift reaches before and after where it is needed.
ROLL_S, SPREAD_S = 0.1, 0.1
# A foot that is so far from where it stands, in lengths of the leg, goes through the air: sooner,
# and the lift jolts knees at toe-off; later, and feet of blends slide.
GONE = 0.08


def swing_lift_m(
    at: FloatArray,
    low_m: FloatArray,
    time_s: FloatArray,
    standing: NDArray[np.bool_],
    leg_m: float,
) -> FloatArray:
    """Smooth lifts ``(F,)`` by which swings clear the ground; 0 in stances.

    A swing is lifted by a smooth curve over what its clearance lacks: the most lacking within
    `SPREAD_S` of each moment, averaged over as much by a kernel that falls to 0. Within `ROLL_S`
    of a stance the lift fades, so that toes leave the ground and heels meet it as they did, but for
    feet that go along the ground there.

    Args:
        at: ``(F, 3)`` of the foot in the world.
        low_m: ``(F,)`` clearance of its lowest part as it goes; below 0 where it is sunk.
        time_s: ``(F,)`` rising.
        standing: ``(F,)``.
        leg_m: length of the leg, to which the clearance is in proportion.
    """
    lift = np.zeros(len(at))
    for start, end in segments(~standing):
        rows = slice(max(start - 1, 0), min(end + 1, len(at)))
        when = time_s[rows]
        way = float(np.linalg.norm(np.ptp(at[rows, :2], axis=0)))
        share = np.ones(len(when))
        roll = max(min(ROLL_S, 0.4 * (when[-1] - when[0])), 1e-9)
        for held, end_s, edge in ((start > 0, when[0], 0), (end < len(at), when[-1], -1)):
            if held:
                gone = np.linalg.norm(at[rows, :2] - at[rows, :2][edge], axis=1) / (GONE * leg_m)
                near = (1.0 - smootherstep(part) for part in (np.abs(when - end_s) / roll, gone))
                share *= 1.0 - np.prod(list(near), axis=0)
        lacking = np.maximum(min(CLEAR * leg_m, CLEAR_OF_WAY * way) - low_m[rows], 0.0)
        lift[rows] = share * smooth_over(lacking, when)
    return lift


def smooth_over(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """A smooth curve ``(F,)`` nowhere below values ``(F,)``, each spread over `SPREAD_S`."""
    first = np.searchsorted(time_s, time_s - SPREAD_S, side="left")
    last = np.searchsorted(time_s, time_s + SPREAD_S, side="right")
    near = [slice(a, b) for a, b in zip(first, last, strict=True)]
    most = np.array([values[rows].max() for rows in near])
    smoothed = np.empty_like(most)
    for k, rows in enumerate(near):
        weight = np.maximum(1.0 - ((time_s[rows] - time_s[k]) / SPREAD_S) ** 2, 0.0) ** 3
        smoothed[k] = weight @ most[rows] / weight.sum()
    return smoothed


def segments(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Starts and ends of segments that are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


# A stance: lower than this share of the foot's lift, and slower than this share of its fastest.
LOW, SLOW = 0.25, 0.12
SHORTEST_STANCE_S = 0.08
# Legs are kept a little bent, so that knees do not snap.
STRETCH = 0.998


@dataclass(frozen=True)
class Leg:
    """The joints of a leg.

    Args:
        hip, knee, ankle: each above the next.
        ball: what touches the ground last; by default the ankle.
        heel: how far behind the ankle the sole begins, as a share of the way from ankle to ball.
        tip: how far before the ball it ends, likewise. Both by default as of a human foot in a
            shoe; `fitted_legs` measures them on a mesh.
        foot_m, toes_m: points of the skin in character space at rest, where it may touch the
            ground: those that go along with the ankle, and with the ball. `fitted_legs` finds them.

    >>> from motorcade.animation.ik import Leg
    >>> Leg("left_thigh", "left_calf", "left_foot", ball="left_toes").limb
    ('left_thigh', 'left_calf', 'left_foot')
    """

    hip: str
    knee: str
    ankle: str
    ball: str = ""
    heel: float = 0.47
    tip: float = 0.7
    foot_m: tuple[tuple[float, float, float], ...] = ()
    toes_m: tuple[tuple[float, float, float], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ball", self.ball or self.ankle)

    @property
    def limb(self) -> tuple[str, str, str]:
        """Hip, knee and ankle."""
        return self.hip, self.knee, self.ankle

    def foot(self, skeleton: Skeleton) -> tuple[int, int]:
        """Numbers of ankle and ball."""
        return skeleton.index(self.ankle), skeleton.index(self.ball)

    def sole(self, skeleton: Skeleton) -> Sole:
        """What the foot stands on."""
        foot, toes = (np.reshape(points, (-1, 3)) for points in (self.foot_m, self.toes_m))
        return Sole(*self.foot(skeleton), self.heel, self.tip, foot, toes)


@dataclass(frozen=True)
class GroundHeights:
    """Heights of the ground.

    Args:
        height_m: takes positions ``(*, 2)`` of the world's x and y, gives heights ``(*)``; flat at
            z = 0 by default.

    >>> import numpy as np
    >>> from motorcade.animation.ik import GroundHeights
    >>> ramp = GroundHeights(lambda at: 0.1 * at[..., 0])  # rises 10 cm a metre along x
    >>> ramp.height_m(np.array([[0.0, 0.0], [2.0, 5.0]]))
    array([0. , 0.2])
    """

    height_m: Callable[[FloatArray], FloatArray] = lambda at: np.zeros(at.shape[:-1])


def find_stances(positions_m: FloatArray, time_s: FloatArray) -> NDArray[np.bool_]:
    """Where a foot stands: low and slow, ``(F,)``, for at least 0.08 s at a time.

    Args:
        positions_m: ``(F, 3)`` of the ball in the world.
        time_s: ``(F,)`` rising.

    >>> import numpy as np
    >>> from motorcade.animation.ik import find_stances
    >>> time_s = 0.1 * np.arange(7)
    >>> x_m = np.array([0.0, 0.0, 0.0, 0.3, 0.6, 0.6, 0.6])
    >>> z_m = np.array([0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    >>> find_stances(np.stack([x_m, 0.0 * x_m, z_m], axis=-1), time_s)
    array([ True,  True, False, False, False,  True,  True])
    """
    height = positions_m[:, 2]
    speed = np.linalg.norm(np.gradient(positions_m, time_s, axis=0), axis=1)
    low = height <= height.min() + LOW * np.ptp(height) + 1e-9
    standing: NDArray[np.bool_] = low & (speed <= SLOW * speed.max() + 1e-9)
    for start, end in segments(standing):
        if time_s[end - 1] - time_s[start] < SHORTEST_STANCE_S:
            standing[start:end] = False
    return standing


def plant_feet(
    skeleton: Skeleton,
    time_s: FloatArray,
    poses: Motor,
    legs: Sequence[Leg],
    *,
    world_T_character: Motor | None = None,
    ground: GroundHeights | None = None,
    stances: Sequence[NDArray[np.bool_]] | None = None,
) -> Motor:
    """The motion with feet that neither slide nor sink.

    Args:
        skeleton: with J joints; its soles lie on z = 0 in the rest pose.
        time_s: ``(F,)`` rising seconds.
        poses: Motor ``(F, J)``, local poses.
        legs: which are planted.
        world_T_character: Motor ``(F,)``, where the character goes; by default it stays.
        ground: on which it walks.
        stances: ``(F,)`` for each leg; found in the motion by default.

    Returns:
        local poses ``(F, J)``.

    Raises:
        ValueError: joints that are no leg, shapes that do not fit.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton
    >>> from motorcade.animation.ik import Leg, plant_feet
    >>> from motorcade.ga import Motor
    >>> rest = Motor.from_translation([[0, 0, 0.9], [0, 0, 0], [0.02, 0, -0.45], [-0.02, 0, -0.45]])
    >>> skeleton = Skeleton(("hips", "thigh", "calf", "foot"), np.array([-1, 0, 1, 2]), rest)
    >>> time_s, still = np.linspace(0.0, 1.0, 21), Motor.stack([rest] * 21)
    >>> world_T_character = Motor.from_translation(time_s[:, None] * [0.1, 0.0, 0.0])  # it leans
    >>> planted = plant_feet(skeleton, time_s, still, [Leg("thigh", "calf", "foot")],
    ...     world_T_character=world_T_character, stances=[np.ones(21, bool)])
    >>> for poses in (still, planted):
    ...     world_T_joint = world_T_character.reshape(-1, 1) @ skeleton.world(poses)
    ...     print(np.ptp(world_T_joint[:, 3].translation_m, axis=0).round(3) + 0.0)  # foot, metres
    [0.1 0.  0. ]
    [0. 0. 0.]
    """
    if poses.shape != (len(time_s), len(skeleton)):
        raise ValueError(
            f"plant_feet(poses): expected shape ({len(time_s)}, {len(skeleton)}), got {poses.shape}"
        )
    way = Motor.identity((len(time_s),)) if world_T_character is None else world_T_character
    floor = GroundHeights() if ground is None else ground
    world = way.reshape(-1, 1) @ skeleton.world(poses)
    inside, feet, targets = way.inverse(), [], []
    for index, leg in enumerate(legs):
        ankle, ball = leg.foot(skeleton)
        at = world[:, ball].translation_m
        standing = find_stances(at, time_s) if stances is None else stances[index]
        sole = float(skeleton.rest_world[ball].translation_m[2])
        middle = at + _holding(at, time_s, standing, floor, sole)
        facing = _facing(skeleton, world, (ankle, ball), time_s, standing)
        foot, end = (
            Motor.from_rotor_translation(
                facing @ pose.rotor, middle + facing.apply(pose.translation_m - at)
            )
            for pose in (world[:, ankle], world[:, ball])
        )
        sole_of = Sole(ankle, ball, leg.heel, leg.tip)
        low = sole_clearance_m(skeleton, (foot, end), sole_of, floor.height_m)
        lift = swing_lift_m(middle, low, time_s, standing, _leg_m(skeleton, leg))
        below = floor.height_m(middle[:, :2]) + sole - middle[:, 2]
        up = Motor.from_translation(np.maximum(lift, below)[:, None] * UP)
        foot, end, toes = up @ foot, up @ end, end.rotor
        if skeleton.parents[ball] == ankle:
            foot, toes = raised_soles(skeleton, (foot, end), sole_of, floor.height_m)
        feet.append((inside.rotor @ foot.rotor, inside.rotor @ toes))
        targets.append(inside.apply(foot.translation_m))
    planted = _lowered(skeleton, poses, legs, targets)
    for leg, target, (foot_rotor, toe_rotor) in zip(legs, targets, feet, strict=True):
        ahead = _knee_ahead(skeleton, planted, leg.limb, target)
        planted = bend_limb(skeleton, planted, leg.limb, target, ahead)
        planted = _rotate_foot(skeleton, planted, leg, foot_rotor, toe_rotor)
    return planted


def _knee_ahead(
    skeleton: Skeleton, poses: Motor, limb: tuple[str, str, str], target: FloatArray
) -> FloatArray:
    """Towards what ``(F, 3)`` a knee bends whose leg is turned to a target: as it did, and along.

    A knee bent towards where it was would bend backwards, once the leg is laid beyond it.
    """
    at = skeleton.world(poses).translation_m
    hip, knee, ankle = (at[:, skeleton.index(name)] for name in limb)
    return hip + shortest_turn(ankle - hip, target - hip).apply(knee - hip)


def _rotate_foot(skeleton: Skeleton, poses: Motor, leg: Leg, foot: Rotor, toes: Rotor) -> Motor:
    """Poses in which ankle and ball are turned as given in character space ``(F,)``."""
    ankle, ball = leg.foot(skeleton)
    above = skeleton.world(poses)[:, int(skeleton.parents[ankle])].rotor
    posed = turned_joint(poses, ankle, above.inverse() @ foot)
    if skeleton.parents[ball] == ankle:
        posed = turned_joint(posed, ball, foot.inverse() @ toes)
    return posed


def _holding(
    at: FloatArray,
    time_s: FloatArray,
    standing: NDArray[np.bool_],
    ground: GroundHeights,
    sole_m: float,
) -> FloatArray:
    """Shifts ``(F, 3)`` that hold the ball over one place in each stance.

    Heights are shifted by their median over the stance: pressing the ball down from its first to
    its last moment would drag the swings down with it.
    """
    shift, known = np.zeros_like(at), np.zeros(len(at), dtype=bool)
    for start, end in segments(standing):
        anchor = np.median(at[start:end], axis=0)
        anchor[2] = ground.height_m(anchor[None, :2])[0] + sole_m
        shift[start:end, :2] = (anchor - at[start:end])[:, :2]
        shift[start:end, 2] = anchor[2] - np.median(at[start:end, 2])
        known[start:end] = True
    if np.any(known):
        for axis in range(3):
            shift[:, axis] = _faded(time_s, shift[:, axis], known)
    return shift


def _leg_m(skeleton: Skeleton, leg: Leg) -> float:
    joints = [skeleton.index(name) for name in leg.limb]
    bones = np.diff(skeleton.rest_world.translation_m[joints], axis=0)
    return float(np.linalg.norm(bones, axis=1).sum())


def _facing(
    skeleton: Skeleton,
    world: Motor,
    foot: tuple[int, int],
    time_s: FloatArray,
    standing: NDArray[np.bool_],
) -> Rotor:
    """Turns ``(F,)`` about z that keep the heading of what stands on the ball in each stance.

    The heading is told by the axis across the foot, which stays level while the heel rises: the
    way from ankle to ball has none once the ankle is over the ball, and turns back beyond it. It
    breaks down for a foot that lies on its side.
    """
    ankle, ball = foot
    rest = skeleton.rest_world
    along = rest[ball].translation_m - rest[ankle].translation_m
    turn = np.zeros(len(time_s))
    if np.any(standing) and np.any(along[:2]):
        across = rest[ball].rotor.inverse().apply(np.array([-along[1], along[0], 0.0]))
        side = world[:, ball].rotor.apply(across)
        heading = np.unwrap(np.arctan2(side[:, 1], side[:, 0]))
        for start, end in segments(standing):
            turn[start:end] = np.median(heading[start:end]) - heading[start:end]
        turn = _faded(time_s, turn, standing)
    return turn_z(turn)


def _faded(time_s: FloatArray, values: FloatArray, known: NDArray[np.bool_]) -> FloatArray:
    """Known values, and between them a passage with no velocity at its ends."""
    faded, at = values.copy(), np.flatnonzero(known)
    for before, after in pairwise(at):
        if after - before < 2:
            continue
        inner = np.arange(before + 1, after)
        x = (time_s[inner] - time_s[before]) / (time_s[after] - time_s[before])
        faded[inner] = values[before] + (values[after] - values[before]) * smoothstep(x)
    faded[: at[0]], faded[at[-1] + 1 :] = values[at[0]], values[at[-1]]
    return faded


def _lowered(
    skeleton: Skeleton, poses: Motor, legs: Sequence[Leg], targets: Sequence[FloatArray]
) -> Motor:
    """The root as much lower as the leg that lacks most needs it."""
    world = skeleton.world(poses)
    drop = np.zeros(poses.shape[0])
    for leg, target in zip(legs, targets, strict=True):
        hip, knee, ankle = (world[:, skeleton.index(name)].translation_m for name in leg.limb)
        reach = STRETCH * (
            np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
        )
        across = np.sum((target - hip)[:, :2] ** 2, axis=1)
        high = np.sqrt(np.maximum(reach**2 - across, 0.0))
        drop = np.maximum(drop, hip[:, 2] - target[:, 2] - high)
    down = Motor.from_translation(-drop[:, None] * UP)
    return with_joint(poses, skeleton.root, down @ poses[:, skeleton.root])


Heights = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Sole:
    """Numbers of a foot's joints, and how far heel and tip lie behind ankle and before ball.

    Fields:
        foot_m, toes_m: ``(P, 3)`` of the skin in character space at rest, where it may touch the
            ground; they go along with ankle and ball.
    """

    ankle: int
    ball: int
    heel: float
    tip: float
    foot_m: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    toes_m: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def marks(self, skeleton: Skeleton) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Heel, ball and tip of the sole in character space, at rest."""
        at = skeleton.rest_world.translation_m
        start, end = at[self.ankle], at[self.ball]
        points = start - self.heel * (end - start), end.copy(), end + self.tip * (end - start)
        for mark in points:
            mark[2] = 0.0
        return points


def raised_soles(
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> tuple[Motor, Rotor]:
    """A foot turned about its ball until its heel, and its toes until their tip, are not sunk.

    Args:
        skeleton: at rest with its soles on z = 0.
        feet: ankle and ball in the world ``(F,)`` each; the ball is where it shall be.
        sole: which joints they are.
        ground_m: heights ``(*)`` of the ground at positions ``(*, 2)``.

    Returns:
        the ankle in the world ``(F,)``, and the ball's rotor in the world ``(F,)``.
    """
    rest = skeleton.rest_world
    heel, _, tip = sole.marks(skeleton)
    ankle, ball = sole.ankle, sole.ball
    pivot = feet[1].translation_m
    behind = feet[0].apply(rest[ankle].inverse().apply(heel)) - pivot
    turn = _raising(behind, pivot, ground_m)
    foot = Motor.from_rotor_translation(
        turn @ feet[0].rotor, pivot + turn.apply(feet[0].translation_m - pivot)
    )
    toes = turn @ feet[1].rotor
    before = toes.apply(rest[ball].inverse().apply(tip))
    return Motor.normalize(foot.coefficients), _raising(before, pivot, ground_m) @ toes


def sole_clearance_m(
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> FloatArray:
    """Heights ``(F,)`` over the ground of the lowest of what the sole has, or the foot's joint.

    Args as for `raised_soles`; see `sole_points`.
    """
    at = sole_points(skeleton, feet, sole)
    clearance: FloatArray = np.min(at[..., 2] - ground_m(at[..., :2]), axis=1)
    return clearance


def sole_points(skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole) -> FloatArray:
    """Where the sole is in the world ``(F, P, 3)``: its skin if that was measured, or its marks.

    Marks are heel, ball and tip; a ball that is no child of the ankle, or is the ankle, has no mark
    but itself.

    Args as for `raised_soles`.
    """
    heel, middle, tip = sole.marks(skeleton)
    of_foot, of_toes = sole.foot_m, sole.toes_m
    if not len(of_foot) + len(of_toes):
        joined = skeleton.parents[sole.ball] == sole.ankle
        of_foot = np.array([heel] if joined else []).reshape(-1, 3)
        of_toes = np.array([middle, tip] if joined else [middle])
    parts = ((feet[0], sole.ankle, of_foot), (feet[1], sole.ball, of_toes))
    points_of = [
        pose.reshape(-1, 1).apply(skeleton.rest_world[joint].inverse().apply(points))
        for pose, joint, points in parts
    ]
    return np.concatenate(points_of, axis=1)


def bent_toes(
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> Rotor:
    """The ball's rotor in the world ``(F,)``: toes bent up about it until their tip is not sunk.

    Args as for `raised_soles`.
    """
    _, _, tip = sole.marks(skeleton)
    pivot = feet[1].translation_m
    before = feet[1].apply(skeleton.rest_world[sole.ball].inverse().apply(tip)) - pivot
    return _raising(before, pivot, ground_m) @ feet[1].rotor


def _raising(lever: FloatArray, pivot: FloatArray, ground_m: Heights) -> Rotor:
    """The least turns that bring the ends of levers ``(F, 3)`` up to the ground."""
    length = np.linalg.norm(lever, axis=1)
    least = ground_m((pivot + lever)[:, :2]) - pivot[:, 2]
    height = np.minimum(np.maximum(lever[:, 2], least), length)
    flat = np.linalg.norm(lever[:, :2], axis=1)
    across = np.sqrt(np.maximum(length**2 - height**2, 0.0))
    raised = lever * np.where(flat > 0.0, across / np.where(flat > 0.0, flat, 1.0), 1.0)[:, None]
    raised[:, 2] = height
    return shortest_turn(lever, raised)


# What lies lower, as a share of the height, is sole.
LOW_SHARE = 0.02
# Directions in which a foot's farthest points are sought: about the vertical, and off it.
AROUND, OFF_DEG = 12, (20.0, 40.0, 60.0, 80.0)


def fitted_legs(legs: Sequence[Leg], character: Character) -> list[Leg]:
    """The legs with heels, tips and edges where the mesh has them at rest, standing on z = 0.

    Edges are what can touch the ground first, however the foot is tilted. A leg without skin that
    follows its foot near the ground stays as it is; one without a ball keeps its heel and tip.

    Args:
        legs: of the character's skeleton.
        character: in its rest pose.
    """
    skeleton, at = character.skeleton, character.skeleton.rest_world.translation_m
    joints, _ = character.influences
    heaviest = joints[:, 0]
    low = character.vertices[:, 2] < LOW_SHARE * character.height_m
    fitted = []
    for leg in legs:
        ankle, ball = leg.foot(skeleton)
        along = (at[ball] - at[ankle])[:2]
        of_toes = at_or_below(skeleton.parents, ball)[heaviest]
        of_foot = at_or_below(skeleton.parents, ankle)[heaviest] & ~of_toes
        sole = character.vertices[low & (of_foot | of_toes)]
        if len(sole) and np.any(along):
            share = (sole[:, :2] - at[ankle, :2]) @ along / (along @ along)
            leg = replace(leg, heel=float(-share.min()), tip=float(share.max() - 1.0))
        if len(sole):
            foot, toes = (_outermost(character.vertices[rows]) for rows in (of_foot, of_toes))
            leg = replace(leg, foot_m=foot, toes_m=toes)
        fitted.append(leg)
    return fitted


def _outermost(points: FloatArray) -> tuple[tuple[float, float, float], ...]:
    """Of points ``(P, 3)`` those that lie farthest in directions that point down."""
    if not len(points):
        return ()
    off, turn = np.meshgrid(np.radians(OFF_DEG), 2.0 * np.pi * np.arange(AROUND) / AROUND)
    ways = np.stack([np.sin(off) * np.cos(turn), np.sin(off) * np.sin(turn), -np.cos(off)], axis=-1)
    ways = np.concatenate([[[0.0, 0.0, -1.0]], ways.reshape(-1, 3)])
    rows = np.unique(np.argmax(ways @ points.T, axis=1))
    return tuple((float(x), float(y), float(z)) for x, y, z in points[rows])
