"""Clips, transitions and spaces at their edges: nothing inside, one key, other skeletons, any time.

After ozz-animation's job tests, like `test_validity`.
"""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.animation.blend import (
    BlendSpace,
    CrossFade,
    Inertialized,
    RootMotion,
    Shifted,
    blend_clips,
    closed,
)
from motorcade.animation.blend.locomotion import split_root_motion
from motorcade.animation.blend.methods import BLEND_METHODS
from motorcade.animation.skin import PoseRuntime
from motorcade.ga import Motor, Similarity

JOINTS = 3
KINDS = ("clip", "grown", "loop", "one key", "shifted", "cross-fade", "inertialized")


@pytest.fixture
def skeleton() -> Skeleton:
    return Skeleton(("root", "middle", "end"), np.arange(3) - 1, Motor.identity((JOINTS,)))


def _clip(seed: int, keys: int = 4, looped: bool = False) -> Clip:
    rng = np.random.default_rng(seed)
    twists = 0.5 * rng.standard_normal((keys, JOINTS, 6))
    if looped:
        twists[-1] = twists[0]
    return Clip(f"clip {seed}", np.linspace(0.5, 1.5, keys), Motor.from_twist(twists), looped)


def _motion(kind: str):
    first, second = _clip(1), _clip(2)
    return {
        "clip": first,
        "grown": Clip("g", first.time_s, Similarity.from_motor_scale(first.poses, 1.5)),
        "loop": _clip(3, looped=True),
        "one key": Clip("one", np.array([1.0]), first.poses[:1]),
        "shifted": Shifted(first, 0.2, 0.3, 2.0),
        "cross-fade": CrossFade(first, second, 0.9, 0.2),
        "inertialized": Inertialized(first, second, 0.9, 0.2),
    }[kind]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("time_s", [np.nan, np.inf, -np.inf, [0.0, np.nan]])
def test_times_that_are_none_are_refused(kind, time_s):
    with pytest.raises(ValueError, match=r"time_s.*finite"):
        _motion(kind).at(time_s)


@pytest.mark.parametrize("kind", KINDS)
def test_poses_at_any_time_are_poses(kind):
    """Far before, far after, and of any shape of times."""
    motion = _motion(kind)
    for time_s in (-1e300, -1e6, -0.0, 0.5, 1.5, 1e6, 1e300):
        made = motion.at(time_s)
        again = type(made)(made.coefficients)  # refuses what is not unit
        assert again.shape == (JOINTS,)
    assert motion.at(np.zeros((2, 0))).shape == (2, 0, JOINTS)
    assert motion.at(np.full((2, 5), 0.7)).shape == (2, 5, JOINTS)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "loop"])
def test_before_the_start_and_after_the_end_a_motion_stands(kind):
    motion = _motion(kind)
    for inside, outside in ((-0.1, -1e9), (1.8, 1e9)):
        one, two = motion.at(inside), motion.at(outside)
        np.testing.assert_allclose(one.as_matrix(), two.as_matrix(), atol=1e-12)


@pytest.mark.parametrize("looped", [False, True])
def test_clips_without_keys_are_refused(looped):
    with pytest.raises(ValueError, match=r"Clip\.time_s of 'c'.*got shape \(0,\)"):
        Clip("c", np.zeros(0), Motor.identity((0, JOINTS)), looped)


def test_a_clip_of_one_key_is_that_pose_and_no_cycle(skeleton):
    one, clip = _motion("one key"), _clip(1)
    for time_s in (-7.0, 1.0, 9.0):
        np.testing.assert_array_equal(one.at(time_s).coefficients, one.poses[0].coefficients)
    with pytest.raises(ValueError, match="a loop needs two samples"):
        Clip("c", one.time_s, one.poses, looped=True)
    with pytest.raises(ValueError, match="expected two poses or more, got one in 'one'"):
        closed(one)
    with pytest.raises(ValueError, match="a clip of two poses or more"):
        split_root_motion(one, skeleton)
    with pytest.raises(ValueError, match="F at least 2"):
        RootMotion(one.time_s, one.poses[:, 0], False)
    with pytest.raises(ValueError, match="expected loops of 3 joints, got 'one'"):
        BlendSpace(np.array([0.0, 1.0]), (one, clip))


@pytest.mark.parametrize("method", BLEND_METHODS)
def test_a_clip_of_one_key_blends_as_a_pose_held(method):
    one, clip = _motion("one key"), _clip(1)
    held = Clip("held", clip.time_s, Motor.stack([one.poses[0]] * len(clip.time_s)))
    found, expected = (
        blend_clips(first, clip, 0.4, method, in_phase=False) for first in (one, held)
    )
    np.testing.assert_allclose(found.poses.coefficients, expected.poses.coefficients, atol=1e-12)
    with pytest.raises(ValueError, match="have no length"):
        blend_clips(one, one, 0.4, method)


def test_motions_of_other_skeletons_are_refused():
    """Even of one joint, which arrays would spread over all."""
    three, one = _clip(1), Clip("one joint", np.array([0.0, 1.0]), Motor.identity((2, 1)))
    for kind in (CrossFade, Inertialized):
        with pytest.raises(ValueError, match="of the same joints"):
            kind(three, one, 0.7, 0.2).at(0.8)
    with pytest.raises(ValueError, match="of one skeleton, got 3 joints in 'clip 1' and 1 in"):
        blend_clips(three, one, 0.5)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_parameters_and_phases_that_are_none_are_refused(value):
    space = BlendSpace(np.array([1.0, 2.0]), (_clip(3, looped=True), _clip(4, looped=True)))
    with pytest.raises(ValueError, match=r"weights\(value\): expected finite"):
        space.pose(value, 0.5)
    with pytest.raises(ValueError, match=r"pose\(phase\): expected finite"):
        space.pose(1.5, value)
    with pytest.raises(ValueError, match=r"phases\(time_s\): expected finite"):
        space.phases([0.0, value], [1.0, 1.0])


@pytest.mark.parametrize("method", BLEND_METHODS)
def test_a_space_goes_round_and_holds_its_ends(method):
    """One cycle on it is the same pose, beyond the last clip the last clip."""
    loops = (_clip(3, looped=True), _clip(4, looped=True))
    space = BlendSpace(np.array([1.0, 2.0]), loops, method=method)
    here, later = (space.pose(1.3, phase) for phase in (0.3, -6.7))
    np.testing.assert_allclose(here.as_matrix(), later.as_matrix(), atol=1e-9)
    last = space.pose(1e9, 0.3)
    np.testing.assert_allclose(last.as_matrix(), loops[1].at(0.5 + 0.3).as_matrix(), atol=1e-9)


def test_a_way_holds_its_ends_or_goes_on_by_cycles():
    start = Motor.identity((1,))
    end = Motor.from_twist([[0.0, 0.0, 0.4, 1.0, 0.0, 0.0]])
    way = Motor(np.concatenate([start.coefficients, end.coefficients]))
    once, again = (RootMotion(np.array([2.0, 3.0]), way, repeated) for repeated in (False, True))
    for time_s, expected in ((-50.0, start[0]), (2.0, start[0]), (3.0, end[0]), (80.0, end[0])):
        np.testing.assert_allclose(once.at(time_s).as_matrix(), expected.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(again.at(4.0).as_matrix(), (end[0] @ end[0]).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(again.at(1.0).as_matrix(), end[0].inverse().as_matrix(), atol=1e-12)
    with pytest.raises(ValueError, match="finite"):
        again.at(np.nan)


@pytest.mark.parametrize("method", ["motor", "motor_linear"])
def test_the_runtime_bears_one_key_and_any_time(skeleton, method):
    clips = [_motion(kind) for kind in ("clip", "loop", "one key")]
    runtime = PoseRuntime(skeleton, clips, method)
    for number, clip in enumerate(clips):
        for time_s in (-1e6, 0.0, 1.0, 1e6):
            found = runtime.local([(number, time_s, 2.0)]).astype(np.float64)
            apart = (found.inverse() @ clip.at(time_s)).as_twist()
            assert np.abs(apart).max() < 1e-5


def test_a_runtime_without_clips_plays_nothing(skeleton):
    with pytest.raises(ValueError, match="number of a clip to be from 0 to -1, got 0"):
        PoseRuntime(skeleton, []).palette([(0, 0.0, 1.0)])
