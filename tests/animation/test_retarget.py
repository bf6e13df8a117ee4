"""Retargeting: to itself exactly, to other frames, lengths and rest poses as bones point."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.animation.retarget import retarget
from motorcade.animation.retarget.reference import joints_alike
from motorcade.ga import Motor, Rotor

NAMES = ("Hips", "Spine", "LeftArm", "LeftForeArm", "LeftHand", "LeftUpLeg", "LeftLeg")
PARENTS = np.array([-1, 0, 1, 2, 3, 0, 5])
# T pose: the arm along +y.
POSITIONS = np.array(
    [
        [0, 0, 1.0],
        [0, 0, 1.3],
        [0, 0.2, 1.5],
        [0, 0.5, 1.5],
        [0, 0.75, 1.5],
        [0, 0.1, 0.95],
        [0, 0.1, 0.5],
    ]
)


def _skeleton(positions: np.ndarray, rotors: Rotor, names=NAMES) -> Skeleton:
    world = Motor.from_rotor_translation(rotors, positions)
    rest = [
        world[k] if p < 0 else world[int(p)].inverse() @ world[k] for k, p in enumerate(PARENTS)
    ]
    return Skeleton(names, PARENTS, Motor.stack(rest))


@pytest.fixture
def source(rng) -> Skeleton:
    return _skeleton(POSITIONS, Rotor.random(rng, (7,)))


@pytest.fixture
def clip(source, rng) -> Clip:
    turns = Motor.from_twist(
        np.concatenate([0.5 * rng.standard_normal((5, 7, 3)), np.zeros((5, 7, 3))], axis=-1)
    )
    poses = (source.rest @ turns).coefficients.copy()
    way = Motor.from_twist(np.linspace(0, 1, 5)[:, None] * [0.0, 0.0, 0.0, 1.0, 0.2, 0.1])
    poses[:, 0] = (way @ Motor(poses[:, 0])).coefficients
    return Clip("go", np.linspace(0.0, 1.0, 5), Motor(poses))


def _bones(skeleton: Skeleton, poses: Motor) -> np.ndarray:
    """Unit directions of upper arm, forearm and thigh."""
    at = skeleton.world(poses).translation_m
    bones = np.stack([at[..., b, :] - at[..., a, :] for a, b in ((2, 3), (3, 4), (5, 6))], axis=-2)
    return bones / np.linalg.norm(bones, axis=-1, keepdims=True)


def test_to_the_same_skeleton_it_is_the_same_clip(source, clip):
    made = retarget(clip, source, source)
    assert np.abs((made.poses.inverse() @ clip.poses).as_twist()).max() < 1e-12


def test_other_frames_and_lengths_play_the_same_motion(source, clip, rng):
    target = _skeleton(1.5 * POSITIONS, Rotor.random(rng, (7,)))
    made = retarget(clip, source, target)
    np.testing.assert_allclose(_bones(target, made.poses), _bones(source, clip.poses), atol=1e-12)
    far, near = (s.world(c.poses).translation_m for s, c in ((target, made), (source, clip)))
    np.testing.assert_allclose(far, 1.5 * near, atol=1e-12)


def test_an_a_pose_follows_a_t_pose(source, clip, rng):
    lowered = POSITIONS.copy()
    lowered[3], lowered[4] = [0, 0.4, 1.25], [0, 0.57, 1.05]
    target = _skeleton(lowered, Rotor.random(rng, (7,)))
    made = retarget(clip, source, target)
    np.testing.assert_allclose(_bones(target, made.poses), _bones(source, clip.poses), atol=1e-12)


def test_names_are_alike_across_exporters_and_the_rest_stays_at_rest(source, clip, rng):
    other = ("mixamorig:hips", "Spine", "left_arm", "Left.Fore.Arm", "tail", "LeftUpLeg", "leftLeg")
    target = _skeleton(POSITIONS, Rotor.random(rng, (7,)), other)
    pairs = joints_alike(target, source)
    assert pairs["mixamorig:hips"] == "Hips"
    assert pairs["Left.Fore.Arm"] == "LeftForeArm"
    assert "tail" not in pairs
    made = retarget(clip, source, target)
    tail = made.poses[:, 4]
    assert np.abs((tail.inverse() @ target.rest[4:5]).as_twist()).max() < 1e-12


def test_refusals(source, clip):
    strange = Skeleton(("a",), np.array([-1]), Motor.identity((1,)))
    with pytest.raises(ValueError, match="the skeletons share neither limbs nor names"):
        retarget(clip, source, strange)
    with pytest.raises(ValueError, match="expected one of its joints, got 'Tail'"):
        retarget(clip, source, source, {"Tail": "Hips"})
