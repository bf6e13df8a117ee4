"""Trunks and hands of retargeted motions turn as the actor's did, fingers about their hinges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from motorcade.animation import Clip, Skeleton, mannequin
from motorcade.animation.formats import read_character, read_motion
from motorcade.animation.retarget import body_of, retarget
from motorcade.ga import Motor, Rotor

GAITS = ("walk", "jog", "run")
TARGETS = {"makehuman": "makehuman/mh_male_ge53_27k.glb", "sinbad": "sinbad/sinbad.glb"}
FINGERS = [f"{name}_{k}" for name in ("index", "middle", "ring", "little") for k in (2, 3)]
SIDES = ("left", "right")


@pytest.fixture(scope="module")
def rigs(data_dir: Path) -> dict:
    made = {name: read_character(data_dir / "rigs" / file) for name, file in TARGETS.items()}
    return made | {"mannequin": mannequin()}


@pytest.fixture(scope="module")
def bound(data_dir: Path) -> Skeleton:
    """The actor's skeleton as it stands in the mesh's file: a T pose."""
    return read_character(data_dir / "rigs" / "arnaud" / "arnaud_fbx.glb").skeleton


@pytest.fixture(scope="module")
def motions(data_dir: Path):
    """Walk, jog and run, whose own rest is their first frame."""
    return {gait: read_motion(data_dir / "rigs" / "arnaud" / f"{gait}_fbx.glb") for gait in GAITS}


def _turned(skeleton: Skeleton, poses: Motor, joint: int) -> Rotation:
    """From rest, in the world, ``(F,)``."""
    turn = skeleton.world(poses)[:, joint].rotor @ skeleton.rest_world[joint].rotor.inverse()
    return Rotation.from_matrix(turn.as_matrix())


def _spine(skeleton: Skeleton) -> tuple[list[int], np.ndarray]:
    """Its joints, and where the middles of their bones lie between 0 and 1."""
    body, at = body_of(skeleton), skeleton.rest_world.translation_m
    line = [body[role] for role in sorted(body) if role.startswith("spine")]
    ends = np.cumsum([0, *np.linalg.norm(np.diff(at[[*line, body["neck"]]], axis=0), axis=1)])
    return line, 0.5 * (ends[1:] + ends[:-1]) / ends[-1]


def _off_deg(one: Rotation, other: Rotation) -> float:
    return float(np.degrees((one.inv() * other).magnitude()).max())


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize("rig", [*TARGETS, "mannequin"])
def test_a_trunk_turns_from_its_rest_as_the_actors_did(rigs, bound, motions, rig, gait):
    """Whether the source's rest can be compared, or is the first frame of its walk."""
    motion, target = motions[gait], rigs[rig].skeleton
    copied = retarget(motion.clips[0], motion.skeleton, bound)
    straight = retarget(motion.clips[0], motion.skeleton, target)
    by_rests = retarget(copied, bound, target)
    ours, theirs = body_of(target), body_of(bound)
    wanted = {role: _turned(bound, copied.poses, theirs[role]) for role in theirs}
    line, shares = _spine(bound)
    turns = [_turned(bound, copied.poses, joint) for joint in line]
    for made, neck_deg, head_deg, clavicle_deg in (
        (straight, 2.0, 7.0, 17.0),
        (by_rests, 0.1, 0.1, 0.1),
    ):
        for role, most_deg in (
            ("hips", 0.1),
            ("neck", neck_deg),
            ("head", head_deg),
            ("left_clavicle", clavicle_deg),
            ("right_clavicle", clavicle_deg),
        ):
            found = _turned(target, made.poses, ours[role])
            assert _off_deg(wanted[role], found) < most_deg, role
        for joint, share in zip(*_spine(target), strict=True):
            found = _turned(target, made.poses, joint)
            at = float(np.clip(share, shares[0], shares[-1]))
            for frame in range(0, len(found), 8):
                keys = Rotation.concatenate([one[frame] for one in turns])
                assert _off_deg(Slerp(shares, keys)(at), found[frame]) < 1.0


def _hinges(rig: str, figure) -> dict[str, np.ndarray]:
    """About what fingers bend, in their own frames: of Sinbad, told by his closed hands."""
    if rig == "mannequin":
        names = [f"{side}_{part}" for side in SIDES for part in FINGERS if "ring" not in part]
        return {name: np.array([1.0, 0, 0]) for name in names}
    body, found = body_of(figure.skeleton), {}
    relaxed, closed = (figure.clip(name).poses.rotor for name in ("HandsRelaxed", "HandsClosed"))
    for role in (f"{side}_{part}" for side in SIDES for part in FINGERS):
        turn = (relaxed[0, body[role]].inverse() @ closed[0, body[role]]).as_rotation_vector()
        found[role] = turn / np.linalg.norm(turn)
    return found


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize(("rig", "most_deg"), [("mannequin", 4.0), ("sinbad", 22.0)])
def test_fingers_bend_about_their_own_hinges(rigs, bound, motions, rig, most_deg, gait):
    """The actor's bend about z of their joints. Sinbad's hinges are up to 20° off being across."""
    motion, target = motions[gait], rigs[rig].skeleton
    copied = retarget(motion.clips[0], motion.skeleton, bound)
    count, ours, theirs = len(copied.time_s), body_of(target), body_of(bound)
    for made in (
        retarget(motion.clips[0], motion.skeleton, target),
        retarget(copied, bound, target),
    ):
        turned, actors = target.world(made.poses).rotor, bound.world(copied.poses).rotor
        off = []
        for role, hinge in _hinges(rig, rigs[rig]).items():
            one = turned[:, ours[role]].apply(np.tile(hinge, (count, 1)))
            other = actors[:, theirs[role]].apply(np.tile([0.0, 0.0, 1.0], (count, 1)))
            cosine = np.abs(np.sum(one * other, axis=1)).min()
            off.append(np.degrees(np.arccos(min(cosine, 1.0))))
        assert max(off) < most_deg
        assert np.median(off) < 12.0


@pytest.mark.parametrize("rig", [*TARGETS, "mannequin"])
def test_fingers_are_laid_alike_with_a_rest_to_compare_by_and_without(rigs, bound, motions, rig):
    motion, target = motions["run"], rigs[rig].skeleton
    copied = retarget(motion.clips[0], motion.skeleton, bound)
    one = target.world(retarget(motion.clips[0], motion.skeleton, target).poses)
    other = target.world(retarget(copied, bound, target).poses)
    apart = np.degrees((one.rotor.inverse() @ other.rotor).angle()).max(axis=0)
    body = body_of(target)
    for role, joint in body.items():
        if role.endswith("_hand") or role.partition("_")[2] in FINGERS:
            assert apart[joint] < 10.0, role
        if "thumb" in role:
            assert apart[joint] < 25.0, role


def _chain(count: int) -> Skeleton:
    """Hips, a spine of so many joints over 0.6 m, neck and head."""
    names = ("hips", *(f"spine{k}" for k in range(count)), "neck", "head")
    shifts = [[0, 0, 1.0], [0, 0, 0.0], *([[0, 0, 0.6 / count]] * count), [0, 0, 0.1]]
    rest = Motor.from_translation(np.array(shifts))
    return Skeleton(names, np.arange(-1, len(names) - 1), rest)


def test_turns_of_a_spine_are_shared_by_length():
    source, target = _chain(2), _chain(3)
    poses = np.repeat(source.rest.coefficients[None], 3, axis=0)
    for joint in (1, 2):
        turn = Rotor.from_rotation_vector(np.outer([0.0, 0.2, 0.4], [0.0, 1.0, 0.0]))
        shift = np.tile(source.rest[joint].translation_m, (3, 1))
        poses[:, joint] = Motor.from_rotor_translation(turn, shift).coefficients
    made = retarget(Clip("bow", np.arange(3.0), Motor(poses)), source, target)
    turned = target.world(made.poses).rotor.as_rotation_vector()[-1, 1:4, 1]
    np.testing.assert_allclose(turned, [0.4, 0.6, 0.8], atol=1e-9)


def test_sides_are_the_figures_own(data_dir: Path):
    """Names of this one tell sides as a viewer sees them."""
    rig = read_character(data_dir / "rigs" / "md5" / "Bob.md5mesh").skeleton
    body, at = body_of(rig), rig.rest_world.translation_m
    assert rig.names[body["left_thigh"]] == "thigh.R"
    for part in ("thigh", "foot", "upper_arm", "hand"):
        assert at[body[f"left_{part}"], 1] > 0.1 > -0.1 > at[body[f"right_{part}"], 1]
    assert body_of(mannequin().skeleton)["left_thigh"] == mannequin().skeleton.index("left_thigh")


def test_a_spine_ends_where_the_arms_begin(data_dir: Path):
    rig = read_motion(data_dir / "rigs" / "bvh" / "jumping_jacks.bvh").skeleton
    body = body_of(rig)
    spine = [rig.names[body[role]] for role in sorted(body) if role.startswith("spine")]
    assert spine == ["lowerback", "Chest", "Chest2"]
    assert rig.names[body["neck"]] == "Neck"
