"""Walks: a character that follows a path on the ground at its clip's own speed, feet planted.

It starts from standing and comes to stand at the path's end, by inertia (`blend.Inertialized`)
while the way slows down and speeds up, its cycle in step with its way, so that standing feet go
back as fast as the body goes on. It starts and stops where one foot stands under the body while the
other passes: what passes is set down beside. So that a way of any length ends in that phase,
strides are made a little shorter or longer, by half a step over the whole way at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.blend import Inertialized, closed, grounded
from motorcade.animation.blend.alignment import GAIT_SWAY_RAD, NO_WAY
from motorcade.animation.blend.transitions import PoseSource
from motorcade.animation.clip import Clip
from motorcade.animation.ik import GroundHeights, Leg, bend_limb, find_stances, plant_feet
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP, turn_z
from motorcade.ga import Motor, Rotor, Similarity, mean
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen

# Speeding up or slowing down takes half a cycle, but is no faster than this, for a person's size.
MOST_M_S2 = 4.0
# Of slowing down, when the walk is left for standing; and of a cycle, when after it that is done.
LEFT, DONE = 0.5, 0.15
SAMPLES = 240
# How much worse longer strides are than shorter ones: legs come short of them, and knees snap.
LONGER = 4.0
# How much lower hips stand than they rest, as a share of their height.
LOWER = 0.006


@dataclass(frozen=True)
class Pace:
    """A way of a length at a speed.

    Args:
        passing: times in the cycle when each foot stands under the body.
        starts: whether it starts from standing; else it comes walking.
        stops: whether it stops; else it walks on.
        most_m_s2: the fastest that it speeds up.
    """

    length_m: float
    speed_m_s: float
    period_s: float
    passing: tuple[float, ...]
    starts: bool = True
    stops: bool = True
    most_m_s2: float = MOST_M_S2

    @property
    def change_s(self) -> float:
        """How long it speeds up, and how long it slows down."""
        return max(0.5 * self.period_s, self.speed_m_s / self.most_m_s2)

    @property
    def ends(self) -> int:
        """How often it speeds up or slows down."""
        return self.starts + self.stops

    @property
    def top_m_s(self) -> float:
        """Its speed in between, less than the cycle's where the way is short."""
        if not self.ends:
            return self.speed_m_s
        return min(self.speed_m_s, self.length_m / (0.5 * self.ends * self.change_s))

    @property
    def duration_s(self) -> float:
        """From the way's start to its end."""
        return self.length_m / self.top_m_s + 0.5 * self.ends * self.change_s

    @property
    def left_s(self) -> float:
        """When the walk is left for standing."""
        return self.duration_s - (1.0 - LEFT) * self.change_s

    @property
    def done_s(self) -> float:
        """When it stands, or where it does not stop, is at the way's end."""
        return self.duration_s + (DONE * self.period_s if self.stops else 0.0)

    def along_m(self, time_s: ArrayLike) -> FloatArray:
        """How far it has come ``(*)`` at times ``(*)``; below 0 and beyond the end as it walks."""
        clock = np.asarray(time_s, dtype=np.float64)
        change, speed = self.change_s, self.top_m_s
        along = speed * clock
        if self.starts:
            along = np.where(
                clock < change, speed * change * _sped(clock / change), along - 0.5 * speed * change
            )
        if self.stops:
            left = self.duration_s - clock
            slow = self.length_m - speed * change * _sped(left / change)
            along = np.where(left < change, slow, along)
        return along

    @property
    def stride(self) -> float:
        """How long its strides are, as a share of the cycle's."""
        return self.length_m / self.speed_m_s / self._advance_s

    def phase_s(self, time_s: ArrayLike) -> FloatArray:
        """Times ``(*)`` in the cycle."""
        first = 0.0
        if self.starts:
            first = self.passing[0]
        elif self.stops:
            first = self.passing[0] - self._advance_s
        return first + self._advance_s * self.along_m(time_s) / self.length_m

    @property
    def _advance_s(self) -> float:
        """Of the cycle: between two ends from one foot's passing to another's, near the way's."""
        lasts_s = self.length_m / self.speed_m_s
        if self.ends < 2:
            return lasts_s

        def strain(advance_s: float) -> float:
            longer = float(np.log(lasts_s / advance_s))
            return max(LONGER * longer, -longer)

        steps = [
            end - self.passing[0] + turns * self.period_s
            for end in self.passing
            for turns in range(int(lasts_s / self.period_s) + 3)
        ]
        return min((one for one in steps if one > 0.25 * self.period_s), key=strain)


def _sped(x: FloatArray) -> FloatArray:
    """How far speed has led that grows from 0 to 1 by ``3 x² - 2 x³``."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 - 0.5 * x**4


def standing_pose(loop: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> Clip:
    """How a walker stands: legs and what carries them as at rest, all else as on average.

    Args:
        loop: a rigid cycle on the spot.
        skeleton: resting upright, with J joints.
        legs: of the skeleton.
    """
    clock = loop.time_s[0] + np.linspace(0.0, loop.duration_s, SAMPLES, endpoint=False)
    rotors = loop.at(clock).rotor
    resting = {
        skeleton.index(name) for leg in legs for name in (leg.hip, leg.knee, leg.ankle, leg.ball)
    }
    for joint in list(resting):
        while skeleton.parents[joint] >= 0:
            joint = int(skeleton.parents[joint])
            resting.add(joint)
    turns = [
        skeleton.rest[joint].rotor if joint in resting else mean(rotors[:, joint])
        for joint in range(len(skeleton))
    ]
    pose = Motor.from_rotor_translation(Rotor.stack(turns), skeleton.rest.translation_m)
    flexed = _with_flexed_knees(pose, skeleton, legs)
    return Clip("standing", np.zeros(1), flexed.reshape(1, -1))


def _with_flexed_knees(pose: Motor, skeleton: Skeleton, legs: Sequence[Leg]) -> Motor:
    """A pose lowered over its feet: legs that rest quite straight would snap when they come to."""
    at, flexed = skeleton.rest_world.translation_m, pose
    long_m = np.mean([at[skeleton.index(leg.hip), 2] for leg in legs])
    down = Motor.from_translation(-LOWER * long_m * UP)
    flexed = skeleton.moved(pose, down)
    for leg in legs:
        ankle, ahead = at[skeleton.index(leg.ankle)], at[skeleton.index(leg.knee)] + [9.0, 0, 0]
        flexed = bend_limb(skeleton, flexed, leg.limb, ankle, ahead)
    return flexed


def passing_s(
    loop: Clip, standing: Motor, skeleton: Skeleton, legs: Sequence[Leg], speed_m_s: float
) -> tuple[float, ...]:
    """When in a cycle each foot stands as far ahead of the body as it does in a pose.

    Args:
        loop: a cycle on the spot.
        standing: Motor ``(J,)``.
        skeleton: with J joints.
        legs: whose feet are told by their balls.
        speed_m_s: of the ground under the cycle.
    """
    clock = np.linspace(0.0, loop.duration_s, SAMPLES, endpoint=False)
    at = skeleton.world(loop.at(loop.time_s[0] + clock)).translation_m
    under = skeleton.world(standing).translation_m
    passing = []
    for leg in legs:
        ball = skeleton.index(leg.ball)
        over = np.tile(at[:, ball], (3, 1))  # no stance is cut by the cycle's ends
        times = np.concatenate([clock + turn * loop.duration_s for turn in range(3)])
        over[:, 0] += speed_m_s * times
        standing_still = find_stances(over, times)[SAMPLES : 2 * SAMPLES]
        off = np.abs(at[:, ball, 0] - under[ball, 0])
        passing.append(float(clock[np.argmin(np.where(standing_still, off, off + 1e3))]))
    return tuple(passing)


# Samples a metre of the curve on which its length is measured, and at most from point to point.
SAMPLES_A_METRE, MOST_SAMPLES = 200.0, 4000
# Strides are shorter than the cycle's by this factor at most; feet that hold still make up for it.
SHORTENED = 1.2
# How far, as a share of the highest joint's height, a foot is from where it stands for good.
NEAR = 0.002


@dataclass(frozen=True, eq=False)
class GroundPath:
    """A smooth curve through points of the ground, by its length.

    A centripetal Catmull-Rom spline: it passes through every point, without loops or overshoot
    where points stand unevenly (Yuksel, Schaefer, Keyser, 2011).

    Args:
        points_m: ``(P, 2)`` x and y on the plane, P at least 2, neighbours apart.

    Raises:
        ValueError: another shape, NaN or infinity, or neighbours at one place.

    >>> import numpy as np
    >>> from motorcade.animation import GroundPath
    >>> path = GroundPath(np.array([[0, 0], [1.0, 0], [1.0, 1.0]]))
    >>> position, heading_rad = path.at([0.0, path.length_m])
    >>> position.round(6) + 0.0
    array([[0., 0.],
           [1., 1.]])
    """

    points_m: FloatArray

    def __post_init__(self) -> None:
        points = checked_floats(self.points_m, "GroundPath.points_m", (2,))
        if points.ndim != 2 or len(points) < 2:
            raise ValueError(f"GroundPath.points_m: expected (P, 2), P >= 2, got {points.shape}")
        apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if np.any(apart < 1e-6):
            at = int(np.argmin(apart))
            raise ValueError(
                f"GroundPath.points_m: expected neighbours apart, got {at} and "
                f"{at + 1} at one place"
            )
        object.__setattr__(self, "points_m", frozen(points))

    @cached_property
    def _curve(self) -> FloatArray:
        return _catmull_rom(self.points_m)

    @cached_property
    def _along(self) -> FloatArray:
        steps = np.linalg.norm(np.diff(self._curve, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def _slope(self) -> FloatArray:
        return np.asarray(np.gradient(self._curve, self._along, axis=0))

    @property
    def length_m(self) -> float:
        """Length of the curve."""
        return float(self._along[-1])

    def at(self, along_m: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Positions ``(*, 2)`` and headings ``(*)`` in radians at lengths ``(*)`` along the curve.

        Beyond its ends the curve goes on straight.
        """
        wanted = checked_floats(along_m, "GroundPath.at(along_m)", ())
        inside = np.clip(wanted, 0.0, self.length_m)
        position = np.stack([np.interp(inside, self._along, axis) for axis in self._curve.T], -1)
        ahead = np.stack([np.interp(inside, self._along, axis) for axis in self._slope.T], -1)
        ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
        beyond = (wanted - inside)[..., None]
        return position + beyond * ahead, np.arctan2(ahead[..., 1], ahead[..., 0])


@dataclass(frozen=True, eq=False)
class Walk:
    """A character on its way.

    Fields:
        time_s: ``(F,)``.
        plane_T_character: Motor ``(F,)`` where it is, soles in the plane.
        poses: Motor ``(F, J)``, local poses with planted feet.

    >>> import numpy as np
    >>> from motorcade.animation.place.walks import Walk
    >>> from motorcade.ga import Motor
    >>> plane_T_character = Motor.from_translation([[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
    >>> character_T_hips = Motor.from_translation([[[0.0, 0.0, 0.9]], [[0.0, 0.0, 0.88]]])
    >>> walk = Walk(np.array([0.0, 1.0]), plane_T_character, character_T_hips)
    >>> (walk.plane_T_character.reshape(-1, 1) @ walk.poses).translation_m[1]  # the hips after 1 s
    array([[1.2 , 0.  , 0.88]])
    """

    time_s: FloatArray
    plane_T_character: Motor
    poses: Motor


def walk_along(
    path: GroundPath,
    clip: Clip,
    skeleton: Skeleton,
    legs: Sequence[Leg],
    speed_m_s: float,
    *,
    rate_hz: float = 60.0,
    scale: float = 1.0,
    ground: GroundHeights | None = None,
    standing: Clip | None = None,
    starts: bool = True,
    stops: bool = True,
) -> Walk:
    """Walk a path from its start to its end, from standing to standing.

    The clip plays in step with the way, so that the stance foot goes back as fast as the body goes
    on; what curves, rounding and strides fitted to the way leave of sliding is taken out by
    `plant_feet`. Speeding up and slowing down take half a cycle each, a run's longer; a clip that
    leaves the ground is slow in the air then.

    Args:
        path: on the plane, in its metres.
        clip: a cycle on the spot, rigid.
        skeleton: whose clip it is.
        legs: whose feet are planted.
        speed_m_s: of the clip, at the character's own size.
        rate_hz: frames a second.
        scale: of the character; a smaller one takes smaller steps, in the same time.
        ground: heights over the plane, in metres of the character's own size; told as well for
            a cycle before the path's start and after its end.
        standing: what it does before and after, rigid and on the spot, such as an idle clip; by
            default it stands as it rests, what legs do not carry as it is on average.
        starts: whether it starts from standing; else it comes walking, in any phase.
        stops: whether it comes to stand; else it is left in mid-stride.

    Raises:
        ValueError: a clip that is not looped or not rigid, a speed, rate or scale not above 0; no
            legs to start or stop with.
    """
    _check(clip, standing, legs if starts or stops else None)
    for name, value in (("speed_m_s", speed_m_s), ("rate_hz", rate_hz), ("scale", scale)):
        checked_positive(value, f"walk_along({name})")
    passing: tuple[float, ...] = ()
    if starts or stops:
        standing = standing_pose(clip, skeleton, legs) if standing is None else standing
        passing = passing_s(clip, rigid(standing, 0.0), skeleton, legs, speed_m_s)
    pace = Pace(path.length_m / scale, speed_m_s, clip.duration_s, passing, starts, stops)
    count = max(2, int(np.ceil(pace.done_s * rate_hz)) + 1)
    # A cycle before and after the way, so that no stance is cut by its ends.
    more = int(np.ceil(clip.duration_s * rate_hz))
    time_s = np.arange(-more, count + more) / rate_hz
    along = pace.along_m(time_s)
    if not stops:
        along[more + count - 1 :] += pace.length_m - along[more + count - 1]
    position, heading = path.at(scale * along)
    rotor = turn_z(heading)
    flat = np.concatenate([position, np.zeros((len(time_s), 1))], axis=1)
    # Feet are planted at the character's own size.
    own = Motor.from_rotor_translation(rotor, flat / scale)
    poses = rigid(played(clip, standing, pace), time_s)
    planted = plant_feet(
        skeleton,
        time_s,
        poses,
        legs,
        world_T_character=own,
        ground=ground,
        stances=stances_along(skeleton, legs, poses, time_s, pace),
    )
    way = slice(more, more + count)
    placed = Motor.from_rotor_translation(rotor[way], flat[way])
    return Walk(time_s[way], placed, planted[way])


def _check(clip: Clip, standing: Clip | None, legs: Sequence[Leg] | None) -> None:
    if not clip.looped or not isinstance(clip.poses, Motor):
        raise ValueError(f"walk_along(clip): expected a rigid loop, got '{clip.name}'")
    if standing is not None and not isinstance(standing.poses, Motor):
        raise ValueError(f"walk_along(standing): expected rigid poses, got '{standing.name}'")
    if legs is not None and not legs:
        raise ValueError("walk_along(legs): expected legs to start or stop with, got none")


@dataclass(frozen=True, eq=False)
class _InStep:
    """A cycle in step with a way; where strides are a lot shorter, it is nearer to standing."""

    cycle: Clip
    standing: Clip | None
    pace: Pace

    def at(self, time_s: ArrayLike) -> Motor:
        stepped = rigid(self.cycle, self.cycle.time_s[0] + self.pace.phase_s(time_s))
        share = SHORTENED * self.pace.stride
        if self.standing is None or share >= 1.0:
            return stepped
        return rigid(self.standing, time_s).interpolate(stepped, share)


def played(cycle: Clip, standing: Clip | None, pace: Pace) -> PoseSource:
    """What the character does, not yet planted."""
    pose_source: PoseSource = _InStep(cycle, standing, pace)
    if standing is not None and pace.starts:
        pose_source = Inertialized(standing, pose_source, 0.0, pace.change_s)
    if standing is not None and pace.stops:
        pose_source = Inertialized(pose_source, standing, pace.left_s, pace.done_s - pace.left_s)
    return pose_source


def rigid(motion: PoseSource, time_s: ArrayLike) -> Motor:
    """Local poses ``(*, J)`` of a motion, refused where they grow."""
    poses = motion.at(time_s)
    if not isinstance(poses, Motor):
        raise ValueError("walk_along: expected rigid poses, got some that grow")
    return poses


def stances_along(
    skeleton: Skeleton, legs: Sequence[Leg], poses: Motor, time_s: FloatArray, pace: Pace
) -> list[NDArray[np.bool_]]:
    """When each foot stands, ``(F,)`` each, were the way straight.

    Along a bend a body that turns drags its standing foot as fast as a slow swing.
    """
    at = skeleton.world(poses).translation_m
    at[..., 0] += pace.along_m(time_s)[:, None]
    near_m = NEAR * float(np.max(skeleton.rest_world.translation_m[:, 2]))
    stances = []
    for leg in legs:
        foot = at[:, skeleton.index(leg.ball)]
        if pace.starts or pace.stops:  # what would sink between walking and standing is low, too
            ground_m = foot[0 if pace.starts else -1, 2]
            foot[:, 2] = np.maximum(foot[:, 2], ground_m)
        standing = find_stances(foot, time_s)
        if pace.starts:
            standing = _stood_first(standing, foot, near_m, time_s < pace.change_s)
        if pace.stops:
            late = time_s[::-1] > pace.left_s
            standing = _stood_first(standing[::-1], foot[::-1], near_m, late)[::-1]
        stances.append(standing)
    return stances


def _stood_first(
    standing: NDArray[np.bool_], at: FloatArray, near_m: float, early: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Stances ``(F,)`` of a foot that stands at first, and if it goes early, goes slowly.

    It then stands no longer than it is where it stood.
    """
    here = ~np.logical_or.accumulate(np.linalg.norm(at - at[0], axis=1) > near_m)
    stands = standing | here
    first = int(np.argmin(stands))
    if early[first]:
        stands[:first] &= here[:first]
    return stands


def _catmull_rom(points: FloatArray) -> FloatArray:
    """The curve sampled densely, ``(S, 2)``."""
    ends = [2.0 * points[0] - points[1], 2.0 * points[-1] - points[-2]]
    p = np.concatenate([ends[:1], points, ends[1:]])
    pieces = [_piece(*p[k : k + 4]) for k in range(len(points) - 1)]
    return np.concatenate([*pieces, points[-1:]])


def _piece(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """From b towards c, the end left out (Barry and Goldman's pyramid, knots by root of length)."""
    t = np.cumsum([0.0, *(np.sqrt(np.linalg.norm(y - x)) for x, y in ((a, b), (b, c), (c, d)))])
    count = min(max(8, int(np.linalg.norm(c - b) * SAMPLES_A_METRE)), MOST_SAMPLES)
    s = np.linspace(t[1], t[2], count, endpoint=False)[:, None]

    def between(x: FloatArray, y: FloatArray, start: float, end: float) -> FloatArray:
        return ((end - s) * x + (s - start) * y) / (end - start)

    first = [between(x, y, t[k], t[k + 1]) for k, (x, y) in enumerate(((a, b), (b, c), (c, d)))]
    second = [between(first[k], first[k + 1], t[k], t[k + 2]) for k in range(2)]
    return between(second[0], second[1], t[1], t[2])


def on_the_spot(clip: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> tuple[Clip, float]:
    """A walk or run as a loop on the spot, facing +x, and its speed in m/s over the ground.

    What it travels, or how fast standing feet go back, is its way (see `grounded`); whoever goes
    sideways goes along +x and faces aside.

    Args:
        clip: one cycle, or a loop, of the skeleton.
        skeleton: with J joints.
        legs: whose feet tell the speed.

    Raises:
        ValueError: a clip of one pose, whose joints grow, or that does not end as it began; no
            legs for a clip on the spot, or one whose feet never go back.
    """
    poses = clip.poses
    if isinstance(poses, Similarity) or len(clip.time_s) < 2:
        raise ValueError(f"on_the_spot(clip): expected rigid poses, two or more, in '{clip.name}'")
    motion = grounded(clip, skeleton, legs, GAIT_SWAY_RAD)
    ahead_m = motion.way.start_T_now.translation_m[-1]
    length = float(np.linalg.norm(ahead_m))
    if length < NO_WAY * float(np.max(skeleton.rest_world.translation_m[:, 2])):
        if not legs:
            raise ValueError(
                f"on_the_spot(legs): expected legs, as '{clip.name}' stays on the spot"
            )
        raise ValueError(f"on_the_spot(clip): expected feet that go back, in '{clip.name}'")
    turn = turn_z(-np.arctan2(ahead_m[1], ahead_m[0]))
    along = Motor.from_rotor_translation(turn, np.zeros(3))
    inside = replace(motion.clip, poses=skeleton.moved(motion.clip.poses, along), looped=False)
    return closed(inside), length / clip.duration_s
