"""Captured walks and runs on other figures: bones, feet and methods of blending, measured."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, Clip, mannequin, skin
from motorcade.animation.blend import closed, differences_m
from motorcade.animation.blend.locomotion import split_root_motion
from motorcade.animation.blend.methods import BLEND_METHODS
from motorcade.animation.formats import read_character, read_motion
from motorcade.animation.ik import Leg, find_stances, plant_feet
from motorcade.animation.ik.feet import fitted_legs
from motorcade.animation.place import GroundPath, on_the_spot, walk_along
from motorcade.animation.retarget import body_of, legs_of, retarget
from motorcade.animation.retarget.reference import joints_alike
from motorcade.ga import Motor

GAITS = ("walk", "jog", "run")
FIGURES = ("arnaud", "makehuman", "sinbad", "mannequin")
FILES = {
    "arnaud": "arnaud/arnaud_fbx.glb",
    "makehuman": "makehuman/mh_male_ge53_27k.glb",
    "sinbad": "sinbad/sinbad.glb",
}
# A vertex stands that is this low for as many frames.
TOUCH_M, STAND_FRAMES = 0.002, 6
# A vertex touches that is this low for as many frames, whatever its foot does; toe-off and landing
# last so long.
TOUCH_FRAMES, ROLL_S = 3, 0.06
# Most that any skin goes that touches, standing or not: toes that roll off included.
ANY_M = 0.02
LIMBS = (("thigh", "calf"), ("calf", "foot"), ("upper_arm", "forearm"), ("forearm", "hand"))


@pytest.fixture(scope="module")
def figures(data_dir: Path) -> dict[str, Character]:
    made = {name: read_character(data_dir / "rigs" / file) for name, file in FILES.items()}
    return made | {"mannequin": mannequin()}


@pytest.fixture(scope="module")
def motions(data_dir: Path):
    return {gait: read_motion(data_dir / "rigs" / "arnaud" / f"{gait}_fbx.glb") for gait in GAITS}


def _limbs(skeleton, poses: Motor) -> np.ndarray:
    """Unit directions of both arms and legs, ``(F, 8, 3)``."""
    body, at = body_of(skeleton), skeleton.world(poses).translation_m
    bones = [
        at[:, body[f"{side}_{b}"]] - at[:, body[f"{side}_{a}"]]
        for side in ("left", "right")
        for a, b in LIMBS
    ]
    made = np.stack(bones, axis=1)
    return made / np.linalg.norm(made, axis=-1, keepdims=True)


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("gait", GAITS)
def test_arms_and_legs_point_where_the_actors_did(figures, motions, figure, gait):
    """The rest of these motions is their first frame: a walk, no pose to compare by."""
    motion, skeleton = motions[gait], figures[figure].skeleton
    assert len(joints_alike(skeleton, motion.skeleton)) >= min(50, len(skeleton))
    clip = motion.clips[0]
    made = retarget(clip, motion.skeleton, skeleton)
    wanted = _limbs(motion.skeleton, clip.poses)
    angle = np.arccos(np.clip(np.sum(_limbs(skeleton, made.poses) * wanted, axis=-1), -1, 1))
    assert np.degrees(angle).max() < 1.0
    # Hips go as far as the legs' lengths say, and stand as high over the feet.
    hips, others = body_of(skeleton)["hips"], body_of(motion.skeleton)["hips"]
    way, other = (
        s.world(c.poses).translation_m[[0, -1], j]
        for s, c, j in ((skeleton, made, hips), (motion.skeleton, clip, others))
    )
    legs = [_leg_m(s) for s in (skeleton, motion.skeleton)]
    np.testing.assert_allclose(
        (way[1] - way[0]) / legs[0], (other[1] - other[0]) / legs[1], atol=0.02
    )


def _leg_m(skeleton) -> float:
    body, at = body_of(skeleton), skeleton.rest_world.translation_m
    line = [at[body[f"left_{part}"]] for part in ("thigh", "calf", "foot")]
    return sum(float(np.linalg.norm(b - a)) for a, b in pairwise(line))


@pytest.mark.parametrize("gait", GAITS)
def test_without_a_rest_to_compare_by_the_motion_tells_as_much(figures, motions, gait):
    """The straight way against the way by the bound figure, whose rest can be compared."""
    motion = motions[gait]
    bound, target = figures["arnaud"].skeleton, figures["makehuman"].skeleton
    straight = retarget(motion.clips[0], motion.skeleton, target)
    by_rests = retarget(retarget(motion.clips[0], motion.skeleton, bound), bound, target)
    one, other = target.world(straight.poses), target.world(by_rests.poses)
    apart = np.degrees((one.rotor.inverse() @ other.rotor).angle()).mean(axis=0)
    body = body_of(target)
    for side in ("left", "right"):
        for part in ("thigh", "calf", "upper_arm", "forearm", "hand"):
            assert apart[body[f"{side}_{part}"]] < 10.0, part
    for part in ("hips", "head", "left_foot", "right_foot"):
        assert apart[body[part]] < 20.0, part


def test_the_same_rig_copies_rotations(figures, motions):
    motion, target = motions["walk"], figures["arnaud"].skeleton
    made = retarget(motion.clips[0], motion.skeleton, target)
    for name in ("LeftArm", "RightLeg", "Head", "Spine2"):
        one, other = (
            s.world(c.poses)[:, s.index(name)].rotor
            for s, c in ((target, made), (motion.skeleton, motion.clips[0]))
        )
        assert float((one.inverse() @ other).angle().max()) < 1e-6


def _legs(figure: Character) -> list[Leg]:
    """Its legs with soles as long as its mesh has them."""
    return fitted_legs(legs_of(figure.skeleton), figure)


def _soles(figure: Character) -> Character:
    """The lowest part of the mesh, which alone can touch the ground."""
    low = figure.vertices[:, 2] < 0.06 * figure.height_m
    rows = (figure.vertices, figure.normals, figure.colors, figure.joints, figure.weights)
    vertices, normals, colors, joints, weights = (row[low] for row in rows)
    none = np.zeros((0, 3), dtype=np.int64)
    return Character(figure.skeleton, vertices, normals, none, colors, joints, weights)


def _runs(flags) -> list[np.ndarray]:
    rows = np.flatnonzero(flags)
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if len(rows) else []


def _gone_m(at, flags, frames: int) -> float:
    """How far a point goes over the ground, at most, in one segment of so many frames."""
    gone = [np.ptp(at[run, :2], axis=0) for run in _runs(flags) if len(run) >= frames]
    return max((float(np.linalg.norm(one)) for one in gone), default=0.0)


def _stances(figure: Character, time_s, plain: Motor) -> list[np.ndarray]:
    """By joints in the world ``(F, J)``, ``(F,)`` for each leg."""
    at = plain.translation_m
    balls = [figure.skeleton.index(leg.ball) for leg in legs_of(figure.skeleton)]
    return [find_stances(at[:, ball], time_s) for ball in balls]


def _swings(standing: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """When a foot swings, toe-off and landing left out."""
    near = np.abs(time_s[:, None] - time_s[standing]).min(axis=1)
    return near > ROLL_S


def _contact(
    figure: Character, poses: Motor, way: Motor, stances: list[np.ndarray], time_s: np.ndarray
):
    """How far what touches the ground goes over it, and how low any part is, in metres.

    Returns:
        skin of a standing foot, its ball, skin of any foot at any time, skin of a swinging foot
        (one frame is enough to touch: it goes as far as from the frame before to the one after);
        the lowest point; and the median height of what is lowest of a standing foot.
    """
    soles, made, over_m = _soles(figure), np.zeros((0, 4)), 0.0
    held = way.reshape(-1, 1) @ figure.skeleton.world(poses)
    at = way.reshape(-1, 1).apply(skin(soles, poses, "linear")[0])
    carried_by = soles.joints[np.arange(len(soles.joints)), np.argmax(soles.weights, axis=1)]
    for leg, standing in zip(legs_of(figure.skeleton), stances, strict=True):
        ankle, ball = (figure.skeleton.index(name) for name in (leg.ankle, leg.ball))
        assert np.any(standing)
        ball_m = _gone_m(held[:, ball].translation_m, standing, 1)
        mine = np.flatnonzero(np.isin(carried_by, (ankle, ball)))
        over_m = max(over_m, float(np.median(at[standing][:, mine, 2].min(axis=1))))
        for vertex in mine:
            here, low = at[:, vertex], at[:, vertex, 2] < TOUCH_M
            grazing = low & _swings(standing, time_s)
            grazing[1:-1] |= grazing[:-2] | grazing[2:]
            row = (
                _gone_m(here, standing & low, STAND_FRAMES),
                ball_m,
                _gone_m(here, low, TOUCH_FRAMES),
                _gone_m(here, grazing, 1),
            )
            made = np.concatenate([made, [row]])
    return (*made.max(axis=0), float(at[..., 2].min()), over_m)


TOLD = "standing skin, ball, any skin, swinging skin, depth, height in mm:"


def _told(*values: float) -> list[float]:
    return [round(1e3 * float(x), 1) for x in values]


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["arnaud", "makehuman", "mannequin"])
@pytest.mark.parametrize("gait", GAITS)
def test_feet_of_a_retargeted_gait_neither_slide_nor_sink(figures, motions, figure, gait):
    """At the clip's own speed, as it was captured."""
    who, motion = figures[figure], motions[gait]
    clip = retarget(motion.clips[0], motion.skeleton, who.skeleton)
    stay = Motor.identity((len(clip.time_s),))
    legs = _legs(who) if figure == "mannequin" else legs_of(who.skeleton)
    stances = _stances(who, clip.time_s, who.skeleton.world(clip.poses))
    planted = plant_feet(who.skeleton, clip.time_s, clip.poses, legs)
    after = _contact(who, planted, stay, stances, clip.time_s)
    before = _contact(who, clip.poses, stay, stances, clip.time_s)
    print(figure, gait, TOLD, *_told(*after), "before:", *_told(*before))
    # its shoes are half as long as its legs, those of the people who were filmed a third
    assert after[0] < (0.015 if figure == "mannequin" else 0.01)
    assert after[1] < 0.001
    assert after[2] < (2.5 * ANY_M if figure == "mannequin" else ANY_M)
    assert after[3] < 0.01
    assert after[4] > (-0.013 if figure == "mannequin" else -0.01)
    assert after[5] < TOUCH_M
    assert before[1] > 0.01
    if gait == "walk":
        assert before[3] > 0.1


BEND = ((0, 0), (1.5, 0), (2.5, 1.0), (2.5, 2.5), (4.0, 3.0))


def _along_a_bend(who: Character, clip: Clip):
    legs = _legs(who)
    loop, speed_m_s = on_the_spot(clip, who.skeleton, legs)
    made = walk_along(
        GroundPath(np.array(BEND)), loop, who.skeleton, legs, speed_m_s, starts=False, stops=False
    )
    # When feet stand is told by the clip on a straight way without ends: a turn drags them.
    more = int(np.ceil(60.0 * loop.duration_s))
    time_s = np.arange(-more, len(made.time_s) + more) / 60.0
    ahead = Motor.from_twist(np.outer(speed_m_s * time_s, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]))
    plain = ahead.reshape(-1, 1) @ who.skeleton.world(loop.at(loop.time_s[0] + time_s))
    stances = [one[more : more + len(made.time_s)] for one in _stances(who, time_s, plain)]
    return _contact(who, made.poses, made.plane_T_character, stances, made.time_s)


@pytest.mark.parametrize("gait", GAITS)
def test_own_feet_along_a_bend_neither_slide_nor_sink(gait):
    figure = mannequin()
    found = _along_a_bend(figure, figure.clip(gait))
    print(
        "own",
        gait,
        "standing skin, ball, any skin, swinging skin, depth, height in mm:",
        *_told(*found),
    )
    assert found[0] < 0.013
    assert found[1] < 0.001
    assert found[2] < ANY_M
    assert found[3] < 0.01
    assert found[4] > -0.01
    assert found[5] < TOUCH_M


@pytest.mark.slow
@pytest.mark.parametrize("gait", GAITS)
def test_captured_feet_along_a_bend_neither_slide_nor_sink(figures, motions, gait):
    who, motion = figures["arnaud"], motions[gait]
    found = _along_a_bend(who, retarget(motion.clips[0], motion.skeleton, who.skeleton))
    print(
        "captured",
        gait,
        "standing skin, ball, any skin, swinging skin, depth, height in mm:",
        *_told(*found),
    )
    assert found[0] < 0.01
    assert found[1] < 0.001
    assert found[2] < ANY_M
    assert found[3] < 0.01
    assert found[4] > -0.01
    assert found[5] < TOUCH_M


@pytest.mark.parametrize(
    ("gait", "far_m"), [("walk", 0.4), ("walk", 1.7), ("walk", 3.0), ("jog", 3.0), ("run", 3.0)]
)
def test_a_walker_starts_and_stops_on_feet_that_stay(gait, far_m):
    """All skin of feet that touches the ground, from the first frame to the last."""
    who = mannequin()
    legs = _legs(who)
    loop, speed_m_s = on_the_spot(who.clip(gait), who.skeleton, legs)
    path = GroundPath(np.array([[0.0, 0.0], [far_m, 0.0]]))
    made = walk_along(path, loop, who.skeleton, legs, speed_m_s)
    at = made.plane_T_character.reshape(-1, 1).apply(skin(_soles(who), made.poses, "linear")[0])
    gone_m = max(_gone_m(at[:, k], at[:, k, 2] < TOUCH_M, TOUCH_FRAMES) for k in range(at.shape[1]))
    world = made.plane_T_character.reshape(-1, 1) @ who.skeleton.world(made.poses)
    knees = world[:, [who.skeleton.index(leg.knee) for leg in legs]].translation_m
    jolt = np.linalg.norm(np.diff(knees, 2, axis=0), axis=-1).max() * 60.0**2
    print(
        gait,
        far_m,
        "any skin, depth in mm; knees in m/s²:",
        *_told(gone_m, at[..., 2].min()),
        round(float(jolt)),
    )
    # On the shortest ways, strides much shorter than the cycle's drag their toes a little.
    assert gone_m < (0.018 if far_m > 1.0 else 0.025)
    assert at[..., 2].min() > -0.01
    assert jolt < 200.0
    # It stands in the end: feet beside each other, under the body, and still.
    feet = world[-1, [who.skeleton.index(leg.ball) for leg in legs]].translation_m
    assert abs(feet[0, 0] - feet[1, 0]) < 0.01
    assert abs(feet[:, 0].mean() - far_m - 0.11) < 0.03
    still = np.linalg.norm(np.diff(world.translation_m[[0, 1, -2, -1]], axis=0)[[0, 2]], axis=-1)
    assert still.max() * 60.0 < 0.03


def test_the_mannequins_gaits_tell_their_speed_by_their_feet():
    """The gaits were made for these speeds: people's, by the root of the share of its legs."""
    figure = mannequin()
    for name, made_for_m_s in (("walk", 0.993), ("jog", 1.907), ("run", 2.861)):
        _, speed = on_the_spot(figure.clip(name), figure.skeleton, legs_of(figure.skeleton))
        assert speed == pytest.approx(made_for_m_s, rel=0.01)


def test_methods_differ_on_walk_to_run_by_what_theory_lets_them(figures, motions):
    """Largest distance of a joint between two methods, halfway from walk to run and around."""
    skeleton = figures["arnaud"].skeleton
    clips = []
    for gait in ("walk", "run"):
        made = retarget(motions[gait].clips[0], motions[gait].skeleton, skeleton)
        clips.append(closed(split_root_motion(made, skeleton)[0]))
    found = {pair: 1e3 * apart for pair, apart in differences_m(*clips, skeleton).items()}
    assert {name for pair in found for name in pair} == set(BLEND_METHODS)
    ties = (
        ("motor", "similarity"),
        ("motor", "dual_quaternion"),
        ("rotor", "quaternion"),
        ("motor_linear", "dual_quaternion_linear"),
        ("rotor_linear", "quaternion_linear"),
    )
    for pair in ties:
        assert _of(found, pair) < 1e-6
    # Bones do not grow under any, so that methods differ by the speed of turns and the hips' way.
    assert 1.0 < _of(found, ("motor", "motor_linear")) < 30.0
    assert 1.0 < _of(found, ("rotor", "rotor_linear")) < 30.0
    assert _of(found, ("motor", "rotor")) < 10.0
    assert _of(found, ("motor", "euler")) > 20.0


def _of(found: dict, pair: tuple[str, str]) -> float:
    return float(found[pair] if pair in found else found[pair[::-1]])


def test_a_gait_with_another_way_is_no_clip_on_the_spot(figures):
    figure = figures["mannequin"]
    with pytest.raises(ValueError, match="expected legs, as 'walk' stays on the spot"):
        on_the_spot(figure.clip("walk"), figure.skeleton, [])
    with pytest.raises(ValueError, match="expected feet that go back, in 'wave'"):
        on_the_spot(figure.clip("wave"), figure.skeleton, legs_of(figure.skeleton))
    single = Clip("still", np.zeros(1), Motor.stack([figure.skeleton.rest]))
    with pytest.raises(ValueError, match=r"expected rigid poses, two or more, in 'still'"):
        on_the_spot(single, figure.skeleton, legs_of(figure.skeleton))


@pytest.mark.parametrize("file", ["astro_max.dae", "astro_maya.dae"])
def test_astroboy_keeps_its_size_under_rigid_methods(data_dir: Path, file: str):
    """Scale left in its palettes would blow it up, or be lost where motors are made unit."""
    figure = read_character(data_dir / "rigs" / "astroboy" / file)
    clip = figure.clips[0]
    for time_s in np.linspace(0.0, clip.duration_s, 5):
        pose = clip.at(time_s)
        linear, motor, dual = (
            skin(figure, pose, method)[0] for method in ("linear", "motor", "dual_quaternion")
        )
        np.testing.assert_allclose(motor, dual, atol=1e-9 * figure.height_m)
        apart = np.linalg.norm(motor - linear, axis=1) / figure.height_m
        assert 1e-4 < apart.max() < 0.03
        assert np.median(apart) < 1e-3
