"""Motions made ready to be blended: on the spot, facing +x, and in step with one another.

The one place where headings are aligned. Where a figure faces is told by its hips, where it goes by
the middle of them, whichever joint of its file carries the motion; a cycle on the spot goes as fast
as its standing feet go back. What is slow of the two is the way; what sways about it stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.blend.locomotion import RootMotion, heading_of, phase_between, without_way
from motorcade.animation.blend.methods import BlendMethod, additive
from motorcade.animation.blend.transitions import blend_clips
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg, find_stances, plant_feet
from motorcade.animation.ik.feet import segments
from motorcade.animation.retarget import body_of, facing_rad
from motorcade.animation.retarget.reference import ancestors
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

# Pelvises turn by 4 degrees to either side in walking (Saunders, Inman, Eberhart, 1953) and by more
# than twice that in running, which a gait by itself keeps; hips sway by less than this share of the
# height. Motions that stay so near to the character's place keep it.
SWAY_RAD, GAIT_SWAY_RAD, SWAY = np.deg2rad(4.0), np.deg2rad(12.0), 0.05
# A way is smooth over so long.
SMOOTH_S = 0.2
# A cycle's ends lie so near to one another, but for its way: metres and radians.
ENDS_ALIKE = 0.1
# Less than this share of the highest joint's height is no way for a cycle to go.
NO_WAY = 0.1
# Of the time, the lowest moments of a foot, by which the ground's speed is first guessed.
LOWEST, SAMPLES, REFINED = 0.3, 240, 3
# Contacts farther apart than this share of a cycle are not the same.
SAME_CONTACT = 0.2
# A foot this near to where it stands, as a share of the height, is on the ground.
TOUCHES = 0.003
PLANTINGS = 12
# Hips are lowered to a foot that stands by this share of the height at most.
LOWERED = 0.02
PHASES = np.linspace(0.0, 1.0, 129)


@dataclass(frozen=True, eq=False)
class GroundedMotion:
    """A motion on the spot, and where it goes.

    Fields:
        clip: facing +x, its hips over their place at rest, but for what sways.
        way: ``start_T_now`` of the character, x ahead.
        cycle: whether its ends are alike but for the way; its clip need not close to rounding.
    """

    clip: Clip
    way: RootMotion
    cycle: bool


def grounded(
    clip: Clip, skeleton: Skeleton, legs: Sequence[Leg] = (), sway_rad: float = SWAY_RAD
) -> GroundedMotion:
    """A motion of any file on the spot, facing +x, and its way over the ground.

    It breaks down for bodies that lie or stand on their heads: hips that are upright face nowhere,
    and the heading is taken from the moments around. A figure without thighs or arms faces where
    its root has turned since the rest pose.

    Args:
        clip: of the skeleton.
        skeleton: at rest facing +x, with its soles on z = 0.
        legs: where a cycle may walk on the spot: standing feet that go back tell its way.
        sway_rad: by how much the hips turn to either side without being on a way of their own.

    Raises:
        ValueError: a clip of a single pose.
    """
    if len(clip.time_s) < 2:
        raise ValueError(f"grounded(clip): expected two poses or more, got one in '{clip.name}'")
    world, rest = skeleton.world(clip.poses.rigid), skeleton.rest_world
    hips = body_of(skeleton).get("hips", skeleton.root)
    facing = _facing(clip.poses.rigid, skeleton)
    under = rest.translation_m[hips] * [1.0, 1.0, 0.0]
    at = world.translation_m[:, hips] * [1.0, 1.0, 0.0] - turn_z(facing).apply(under)
    tall = float(np.max(rest.translation_m[:, 2]))
    ends = _ground(facing[[0, -1]], at[[0, -1]])
    gone = ends[1] @ ends[0].inverse()
    gap = additive(skeleton.moved(clip.poses[-1], gone.inverse()), clip.poses[0]).as_twist()
    cycle = float(np.max(np.abs(gap))) <= ENDS_ALIKE and abs(facing[-1] - facing[0]) < np.pi
    share = (clip.time_s - clip.time_s[0]) / clip.duration_s
    even = Motor.exp(share[:, None] * (cycle * gone.log()))
    about = even.inverse() @ _ground(facing, at)
    plane_T_body = even @ _slow_way(about, clip.time_s, tall, cycle, sway_rad)
    inside = _hung_on_hips(without_way(clip, skeleton, plane_T_body), skeleton, hips)
    way = plane_T_body[0].inverse() @ plane_T_body
    if cycle and legs and np.linalg.norm(way.translation_m[-1]) < NO_WAY * tall:
        ahead_m = ground_speed(inside, skeleton, legs) * clip.duration_s
        if ahead_m >= NO_WAY * tall:
            way = way @ Motor.from_translation(share[:, None] * [ahead_m, 0.0, 0.0])
    return GroundedMotion(inside, RootMotion(clip.time_s, way, cycle), cycle)


def _facing(poses: Motor, skeleton: Skeleton) -> FloatArray:
    """Where a figure faces ``(F,)`` in poses ``(F, J)``, by its hips, or else by its root."""
    world, root = skeleton.world(poses), skeleton.root
    facing = facing_rad(skeleton, world.translation_m)
    if facing is None:
        facing = heading_of(world[:, root] @ skeleton.rest_world[root].inverse())
    return np.unwrap(facing)


def _hung_on_hips(clip: Clip, skeleton: Skeleton, hips: int) -> Clip:
    """The same motion with what lies above the hips where it rests, over the ground.

    In one file the root goes, in another the hips below it: taken back at the root, two motions
    would look alike and differ by half a turn in both joints, which no blend goes through well.
    """
    above = ancestors(skeleton, hips)
    if not above:
        return clip
    world, rest = skeleton.world(clip.poses), skeleton.rest_world
    changed = world.coefficients.copy()
    for joint in above:
        moved = world.rigid[:, joint] @ rest[joint].inverse()
        flat = _ground(heading_of(moved), moved.translation_m * [1.0, 1.0, 0.0]).inverse()
        kept = type(world)(changed[:, joint])
        motion = flat if isinstance(kept, Motor) else Similarity.from_motor_scale(flat)
        changed[:, joint] = (motion @ kept).coefficients
    return replace(clip, poses=skeleton.local(type(world)(changed)))


def _ground(heading_rad: FloatArray, position_m: FloatArray) -> Motor:
    return Motor.from_rotor_translation(turn_z(heading_rad), position_m)


def _slow_way(way: Motor, time_s: FloatArray, tall_m: float, cycle: bool, sway_rad: float) -> Motor:
    """What is slow of motions ``(F,)`` on the ground; of a cycle, all around it."""
    count = len(time_s) - 1
    values = np.column_stack([np.unwrap(heading_of(way)), way.translation_m[:, :2]])
    clock = time_s
    if cycle:
        turns = np.repeat([-1.0, 0.0, 1.0], count) * (time_s[-1] - time_s[0])
        values, clock = np.tile(values[:-1], (3, 1)), np.tile(time_s[:-1], 3) + turns
    reach = (sway_rad, SWAY * tall_m, SWAY * tall_m)
    slow = np.column_stack([_slow(*pair, clock) for pair in zip(values.T, reach, strict=True)])
    if cycle:
        slow = slow[np.append(np.arange(count, 2 * count), count)]
    return _ground(slow[:, 0], np.column_stack([slow[:, 1:], np.zeros(count + 1)]))


def _slow(values: FloatArray, reach: float, time_s: FloatArray) -> FloatArray:
    """Values ``(F,)`` that move only where others leave their reach, from 0 on if those begin near.

    What lags behind on the way there leads on the way back; their mean is in the middle. What never
    leaves its reach stands still: in the middle, or at 0 where that is near enough.
    """
    if np.ptp(values) <= 2.0 * reach:
        near = np.abs(values).max() <= reach
        return np.full(len(values), 0.0 if near else 0.5 * (values.min() + values.max()))
    first = 0.0 if abs(values[0]) <= reach else float(values[0])
    there = _dragged(values, reach, first)
    back = _dragged(values[::-1], reach, there[-1])
    there = _dragged(values, reach, first if first == 0.0 else back[-1])
    middle = 0.5 * (there + back[::-1])
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (middle[1:] + middle[:-1]) * np.diff(time_s))])
    half = np.minimum(0.5 * SMOOTH_S, np.minimum(time_s - time_s[0], time_s[-1] - time_s))
    before, after = (np.interp(time_s + sign * half, time_s, whole) for sign in (-1.0, 1.0))
    smooth = np.where(half > 0.0, (after - before) / np.where(half > 0.0, 2.0 * half, 1.0), middle)
    return np.clip(smooth, values - reach, values + reach)


def _dragged(values: FloatArray, reach: float, first: float) -> FloatArray:
    held, dragged = first, np.empty_like(values)
    for row, value in enumerate(values):
        held = min(max(held, value - reach), value + reach)
        dragged[row] = held
    return dragged


def ground_speed(clip: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> float:
    """How fast the ground has to go back under a loop for standing feet to stand on it."""
    time_s = np.linspace(0.0, clip.duration_s, SAMPLES + 1)
    poses = clip.at(clip.time_s[0] + time_s).rigid
    balls = [skeleton.index(leg.ball) for leg in legs]
    at = skeleton.world(poses).translation_m[:, balls]
    speed = float(np.median([_backward(at[:, k], time_s, None) for k in range(len(balls))]))
    for _ in range(REFINED):
        shift = np.stack([speed * time_s, 0.0 * time_s, 0.0 * time_s], axis=-1)
        speeds = []
        for k in range(len(balls)):
            standing = find_stances(at[:, k] + shift, time_s)
            speeds.append(_backward(at[:, k], time_s, standing if np.any(standing) else None))
        speed = float(np.mean(speeds))
    return speed


def _backward(at: FloatArray, time_s: FloatArray, standing: NDArray[np.bool_] | None) -> float:
    """Median speed towards −x while a foot stands, or at its lowest."""
    speed = -np.gradient(at[:, 0], time_s)
    if standing is None:
        return float(np.median(speed[np.argsort(at[:, 2])[: max(2, int(LOWEST * len(at)))]]))
    return float(np.median(speed[standing]))


def contacts(
    motion: GroundedMotion, skeleton: Skeleton, legs: Sequence[Leg], time_s: FloatArray
) -> NDArray[np.bool_]:
    """Which feet stand on the ground ``(F, L)`` at times of the motion ``(F,)``."""
    at = motion.way.at(time_s).reshape(-1, 1) @ skeleton.world(motion.clip.at(time_s).rigid)
    balls = [skeleton.index(leg.ball) for leg in legs]
    return np.stack([find_stances(at.translation_m[:, k], time_s) for k in balls], axis=-1)


def in_step(
    first: GroundedMotion, second: GroundedMotion, skeleton: Skeleton, legs: Sequence[Leg]
) -> tuple[GroundedMotion, float, str]:
    """A second cycle warped in time so that its feet come down and leave the ground as a first's.

    Both are loops. By the heights of feet a phase is told at which the second is like the first's
    start; from there each contact is laid on the nearest of its foot. Where feet go down in one
    order and up in another, as in a walk and a run, they come down together.

    Returns:
        the second, the phase of it with which it begins, and what could not be aligned, or "".
    """
    try:
        offset = phase_between(first.clip, second.clip, skeleton, [leg.ankle for leg in legs])
    except ValueError:  # feet that never move have no phase
        return second, 0.0, "feet of one stand all the time: the other keeps its own phase"
    feet = [_events(motion, skeleton, legs) for motion in (first, second)]
    pairs: list[tuple[float, float]] = []
    for kinds in (("down", "up"), ("down",)):
        pairs = _paired(feet[0], feet[1], offset, kinds)
        if pairs:
            break
    note = "" if pairs else "feet come down in another order or number: laid by their heights"
    phase = PHASES + offset
    if pairs:
        at, late = np.array(sorted(pairs)).T
        phase = phase + np.interp(PHASES, at, late, period=1.0)
    clip, way = second.clip, second.way
    clock = clip.time_s[0] + clip.duration_s * phase
    poses = clip.at(clock).coefficients.copy()
    poses[-1] = poses[0]
    morphs = clip.morphs
    if morphs is not None:
        morphs = replace(morphs, time_s=PHASES * clip.duration_s, weights=morphs.at(clock))
    warped = Clip(clip.name, PHASES * clip.duration_s, type(clip.poses)(poses), True, morphs=morphs)
    moved = way.at(clock)
    warped_way = RootMotion(warped.time_s, moved[0].inverse() @ moved, True)
    return GroundedMotion(warped, warped_way, True), offset, note


def _events(
    motion: GroundedMotion, skeleton: Skeleton, legs: Sequence[Leg]
) -> dict[tuple[str, int], FloatArray]:
    """Phases at which each foot comes down, and goes up, in a cycle."""
    count = SAMPLES
    step = motion.clip.duration_s / count
    clock = motion.clip.time_s[0] + step * np.arange(-count, 2 * count)
    standing = contacts(motion, skeleton, legs, clock)[count - 1 : 2 * count]
    change = np.diff(standing.astype(np.int8), axis=0)
    return {
        (kind, leg): np.flatnonzero(change[:, leg] == sign) / count
        for kind, sign in (("down", 1), ("up", -1))
        for leg in range(len(legs))
    }


def _paired(
    first: dict[tuple[str, int], FloatArray],
    second: dict[tuple[str, int], FloatArray],
    offset: float,
    kinds: tuple[str, ...],
) -> list[tuple[float, float]]:
    """Phases of the first's contacts, and how much later than `offset` says the second's are.

    None where counts differ, a contact is far from its like, or time would not go on.
    """
    pairs = []
    for key, own in first.items():
        if key[0] not in kinds:
            continue
        other = second[key]
        if len(own) != len(other):
            return []
        late = (other[None, :] - offset - own[:, None] + 0.5) % 1.0 - 0.5
        nearest = np.argmin(np.abs(late), axis=1) if len(own) else np.zeros(0, dtype=np.int64)
        if len(set(nearest)) < len(own):
            return []
        pairs += [(float(own[k]), float(late[k, other_k])) for k, other_k in enumerate(nearest)]
    at, late = np.array(sorted(pairs)).reshape(-1, 2).T
    reached = at + late
    rising = np.all(np.diff([*reached, *(reached[:1] + 1.0)]) > 0.0)
    return pairs if len(at) and rising and np.all(np.abs(late) < SAME_CONTACT) else []


def blend_motions(
    first: GroundedMotion,
    second: GroundedMotion,
    weight: float,
    skeleton: Skeleton,
    legs: Sequence[Leg],
    *,
    method: BlendMethod = "motor",
    rate_hz: float = 60.0,
) -> GroundedMotion:
    """A motion between two of one skeleton: poses, ways and morphs by their shares, feet planted.

    Two cycles are blended in phase, and are brought into step by `in_step` before; others are
    blended by the clock. Of a share of 0 or 1 feet stay as they are.

    Args:
        first: see `grounded`.
        second: likewise, of the same joints.
        weight: share of the second, 0 to 1.
        skeleton: of both.
        legs: whose feet are planted.
        method: see `motorcade.animation.blend.methods`.
        rate_hz: samples a second of the result.

    Raises:
        ValueError: see `blend_clips`.
    """
    pair = (first, second)
    in_phase = all(motion.cycle and motion.clip.looped for motion in pair)
    clip = blend_clips(first.clip, second.clip, weight, method, in_phase=in_phase, rate_hz=rate_hz)
    share = np.array([1.0 - weight, weight])
    steps, clocks = [], []
    for motion in pair:
        rate = motion.clip.duration_s / clip.duration_s if in_phase else 1.0
        clocks.append(motion.clip.time_s[0] + rate * clip.time_s)
        places = motion.way.at(clocks[-1])
        step = places[:-1].inverse() @ places[1:]
        steps.append(np.column_stack([heading_of(step), step.translation_m[:, :2]]))
    turns, *ahead = np.tensordot(share, steps, 1).T
    heading = np.concatenate([[0.0], np.cumsum(turns)])
    place = np.cumsum(np.exp(1j * heading[:-1]) * (ahead[0] + 1j * ahead[1]))
    place = np.concatenate([[0.0], place])
    at = np.stack([place.real, place.imag, np.zeros(len(place))], axis=-1)
    way = RootMotion(clip.time_s, _ground(heading, at), in_phase)
    faces = [
        _facing(motion.clip.at(clock).rigid, skeleton)
        for motion, clock in zip(pair, clocks, strict=True)
    ]
    off = share @ np.stack(faces) - _facing(clip.poses.rigid, skeleton)
    # Hips that lean face elsewhere halfway than halfway between where they face.
    hips = skeleton.world(clip.poses.rigid).translation_m[:, body_of(skeleton).get("hips", 0)]
    under = hips * [1.0, 1.0, 0.0]
    about = _ground(off, under - turn_z(off).apply(under))
    clip = replace(clip, poses=skeleton.moved(clip.poses, about))
    blended = GroundedMotion(clip, way, in_phase)
    return blended if weight in (0.0, 1.0) else planted(blended, skeleton, legs)


def planted(motion: GroundedMotion, skeleton: Skeleton, legs: Sequence[Leg]) -> GroundedMotion:
    """The motion with feet that neither slide nor sink on its way; of a loop, all around it.

    One whose joints grow, or that is shorter than three poses, stays as it is.
    """
    clip, count = motion.clip, len(motion.clip.time_s) - 1
    if not legs or not isinstance(clip.poses, Motor) or count < 3:
        return motion
    rows, time_s = np.arange(count + 1), clip.time_s
    rest = skeleton.rest_world.translation_m
    hips = body_of(skeleton).get("hips", skeleton.root)
    tall, balls = float(np.max(rest[:, 2])), [skeleton.index(leg.ball) for leg in legs]
    if clip.looped:  # no stance is cut by its ends
        turns = np.repeat([-1.0, 0.0, 1.0], count) * clip.duration_s
        rows, time_s = np.tile(rows[:-1], 3), np.tile(time_s[:-1], 3) + turns
    way, loose = motion.way.at(time_s), clip.poses[rows]
    stances = np.zeros((len(time_s), len(legs)), dtype=bool)
    released, held = stances.copy(), None
    for _ in range(PLANTINGS):  # what touches the ground as it is set down stands there already
        poses = plant_feet(skeleton, time_s, loose, legs, world_T_character=way, stances=held)
        at = (way.reshape(-1, 1) @ skeleton.world(poses)).translation_m
        touching = [_touching(at[:, k], time_s, rest[k, 2], tall) for k in balls]
        # Rather than that hips go down to it, a foot that is left behind goes along.
        drop = (loose[:, skeleton.root].translation_m - poses[:, skeleton.root].translation_m)[:, 2]
        far = np.linalg.norm(at[:, balls, :2] - at[:, hips, None, :2], axis=-1)
        lacking = np.flatnonzero(drop > LOWERED * tall)
        for k, rows_held in enumerate(map(np.flatnonzero, stances.T)):
            behind = lacking[np.argmax(far[lacking], axis=1) == k]
            if len(rows_held) and len(behind):  # in a swing, what it is held for before or after
                after = np.minimum(np.searchsorted(rows_held, behind), len(rows_held) - 1)
                released[rows_held[np.stack([np.maximum(after - 1, 0), after])], k] = True
        before, stances = stances, (stances | np.stack(touching, axis=1)) & ~released
        if held is not None and np.array_equal(before, stances):
            break
        held = list(stances.T)
    if clip.looped:
        poses = poses[np.append(count + rows[:count], count)]
    return replace(motion, clip=replace(clip, poses=poses))


def _touching(
    at: FloatArray, time_s: FloatArray, rest_m: float, tall_m: float
) -> NDArray[np.bool_]:
    """Stances ``(F,)``, from when a foot comes as low as it stands to when it leaves that."""
    standing = find_stances(at, time_s)
    longer = standing.copy()
    for start, end in segments(standing):
        low = at[:, 2] <= max(rest_m, np.max(at[start:end, 2])) + TOUCHES * tall_m
        longer[start - np.argmin([*low[:start][::-1], False]) : start] = True
        longer[end : end + np.argmin([*low[end:], False])] = True
    return longer
