"""Bodies told from trees of joints: under any names, turned, scaled, and in poses of a motion."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Skeleton, mannequin
from motorcade.animation.anatomy.body import body_from
from motorcade.animation.anatomy.tree import JointTree
from motorcade.animation.retarget import body_of
from motorcade.animation.vectors import UP
from motorcade.ga import Rotor

AHEAD = np.array([1.0, 0.0, 0.0])
LIMBS = ("thigh", "calf", "foot", "toes", "clavicle", "upper_arm", "forearm", "hand")


@pytest.fixture(scope="module")
def skeleton() -> Skeleton:
    return mannequin().skeleton


def random_names(rng: np.random.Generator, count: int) -> tuple[str, ...]:
    """Different names that say nothing."""
    letters = np.array(list("bcdfghjkmpqstvwxz"))
    return tuple("".join(rng.choice(letters, 9)) + str(k) for k in range(count))


def _limbs(roles) -> dict[str, int]:
    wanted = [f"{side}_{part}" for side in ("left", "right") for part in LIMBS]
    return {role: roles[role] for role in [*wanted, "hips", "neck", "head"]}


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
def test_names_size_and_lie_do_not_matter(skeleton, rng, scale):
    at = skeleton.rest_world.translation_m
    for turn in Rotor.random(rng, (8,)):
        names = random_names(rng, len(skeleton))
        tree = JointTree(names, skeleton.parents, scale * turn.apply(at) + rng.normal(size=3))
        body = body_from(tree)
        assert _limbs(body.roles) == _limbs(body_of(skeleton))
        assert body.up is not None
        assert body.ahead is not None
        assert body.up @ turn.apply(UP) > np.cos(0.15)
        assert body.ahead @ turn.apply(AHEAD) > np.cos(0.15)


def test_a_skeleton_with_other_names_has_the_same_body(skeleton, rng):
    other = Skeleton(random_names(rng, len(skeleton)), skeleton.parents, skeleton.rest)
    spine = {r: j for r, j in body_of(skeleton).items() if r.startswith("spine")}
    assert _limbs(body_of(other)) == _limbs(body_of(skeleton))
    assert {r: j for r, j in body_of(other).items() if r.startswith("spine")} == spine


def test_names_of_the_wrong_side_are_turned_about(skeleton):
    swap = {"left": "right", "right": "left"}
    names = tuple(
        "_".join(swap.get(word, word) for word in name.split("_")) for name in skeleton.names
    )
    assert names != skeleton.names
    other = Skeleton(names, skeleton.parents, skeleton.rest)
    assert _limbs(body_of(other)) == _limbs(body_of(skeleton))


@pytest.mark.parametrize("clip", ["walk", "run", "wave", "turn"])
def test_any_pose_of_a_motion_tells_the_body(skeleton, rng, clip):
    """As a rest pose that is none: mid-stride, in the air."""
    figure = mannequin()
    motion = figure.clip(clip)
    names = random_names(rng, len(skeleton))
    for time_s in np.linspace(motion.time_s[0], motion.time_s[-1], 12):
        at = skeleton.world(motion.at(time_s).rigid).translation_m
        body = body_from(JointTree(names, skeleton.parents, at))
        assert _limbs(body.roles) == _limbs(body_of(skeleton))


def test_an_animal_stands_on_four_legs(rng):
    """Trunk level, limbs hanging from both ends: forelegs where the head is."""
    leg = np.array([[0.0, 0.0, 0.5], [0.05, 0.0, 0.25], [-0.03, 0.0, 0.05], [0.05, 0.0, 0.0]])
    at = [[0, 0, 0.55], [0.3, 0, 0.57], [0.6, 0, 0.55], [0.75, 0, 0.65], [0.9, 0, 0.65]]
    parents = [-1, 0, 1, 2, 3]
    for x, above in ((0.0, 0), (0.6, 2)):
        for y in (0.1, -0.1):
            for k, place in enumerate(leg[: 4 if x == 0.0 else 3] + np.array([x, y, 0.0])):
                at.append(place.tolist())
                parents.append(above if k == 0 else len(at) - 2)
    tree = JointTree(random_names(rng, len(at)), np.array(parents), np.array(at))
    body = body_from(tree)
    assert body.four_legged
    assert body.ahead @ AHEAD > 0.99
    assert body.up @ UP > 0.99
    assert tree.at[body.roles["left_thigh"], 1] > 0 > tree.at[body.roles["right_hand"], 1]
    assert tree.at[body.roles["left_thigh"], 0] < 0.1 < tree.at[body.roles["left_upper_arm"], 0]


def test_two_columns_alike_tell_no_front(rng):
    """Straight legs without feet, no arms: either way may be ahead."""
    leg = np.array([[0, 0.1, 0.9], [0, 0.1, 0.5], [0, 0.1, 0.1]])
    at = np.concatenate([[[0, 0, 1.0]], leg, leg * [1, -1, 1]])
    tree = JointTree(random_names(rng, 7), np.array([-1, 0, 1, 2, 0, 4, 5]), at)
    assert body_from(tree, UP).ahead is None
    assert body_from(tree, UP, AHEAD).ahead @ AHEAD == pytest.approx(1.0)


def test_legs_alone_tell_up_in_any_lie(rng):
    """No arms, no names, no word of what is up: legs stand, and toes point ahead."""
    leg = np.array([[0, 0.1, 0.9], [0.02, 0.1, 0.5], [0, 0.1, 0.1], [0.12, 0.1, 0.0]])
    at = np.concatenate([[[0, 0, 1.0]], leg, leg * [1, -1, 1], [[0, 0, 1.2]]])
    parents = np.array([-1, 0, 1, 2, 3, 0, 5, 6, 7, 0])
    for turn in Rotor.random(rng, (8,)):
        body = body_from(JointTree(random_names(rng, 10), parents, turn.apply(at)))
        assert body.up @ turn.apply(UP) > 0.99
        assert body.ahead @ turn.apply(AHEAD) > 0.99
        assert body.roles["left_thigh"] == 1


@pytest.mark.parametrize("lost", ["left_thigh", "right_upper_arm"])
@pytest.mark.parametrize("named", ["own", "other"])
def test_a_limb_without_a_like_goes_by_its_name(skeleton, lost, named):
    """Of the side on which it is, even where all names tell the sides as a viewer sees them."""
    roles = body_of(skeleton)
    tree = JointTree(skeleton.names, skeleton.parents, skeleton.rest_world.translation_m)
    kept = [k for k in range(len(skeleton)) if not tree.is_below(k, roles[lost])]
    place = {-1: -1} | {k: number for number, k in enumerate(kept)}
    names = [skeleton.names[k] for k in kept]
    if named == "other":
        swap = {"left": "right", "right": "left", "l": "r", "r": "l"}
        names = ["_".join(swap.get(word, word) for word in name.split("_")) for name in names]
        assert names != [skeleton.names[k] for k in kept]
    parents = np.array([place[int(skeleton.parents[k])] for k in kept])
    # Feet or arms left over must tell the front against the names: elbows are bent.
    found = body_from(JointTree(tuple(names), parents, tree.at[kept]), UP, AHEAD, habit=2.0).roles
    side, _, first = lost.partition("_")
    parts = LIMBS[:3] if first == "thigh" else LIMBS[5:]
    other = "right" if side == "left" else "left"
    for part in parts:
        assert found[f"{other}_{part}"] == place[roles[f"{other}_{part}"]]
        assert f"{side}_{part}" not in found
