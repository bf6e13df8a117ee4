"""The solver of figures: goals reached, limits that hold, and what it says where they cannot be."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Skeleton, legs_of, mannequin
from motorcade.animation.ik import Ball, Hinge, IkSolver, LookAt, PoseGoal
from motorcade.animation.ik.chain import Floating
from motorcade.ga import Motor, Rotor
from tests.animation.ik.figures import chain, excess, mixed_joints, turns

STRAIGHT_NAMES = tuple(f"j{k}" for k in range(5))
STRAIGHT = Skeleton(
    STRAIGHT_NAMES,
    np.arange(5) - 1,
    Motor.from_translation([[0.0, 0, 0], *[[0, 0, 0.25]] * 4]),
)


def figure() -> Skeleton:
    """Hips, a chest with a head, two arms and two legs."""
    names = ["hips", "chest", "head"]
    parents, shifts = [-1, 0, 1], [[0, 0, 0.9], [0, 0, 0.3], [0, 0, 0.3]]
    for side, y in (("l", 1.0), ("r", -1.0)):
        for limb, root, start in (("arm", 1, [0, 0.2 * y, 0.2]), ("leg", 0, [0, 0.1 * y, 0])):
            bone = [0, 0.3 * y, 0] if limb == "arm" else [0, 0, -0.45]
            for k, shift in enumerate((start, bone, bone)):
                parents.append(root if k == 0 else len(names) - 1)
                names.append(f"{limb}{k}_{side}")
                shifts.append(shift)
    return Skeleton(tuple(names), np.array(parents), Motor.from_translation(shifts))


def human_joints() -> dict:
    made = {"hips": Floating(), "chest": Ball(0.5, (-0.5, 0.5), axis=[0, 0, 1.0])}
    made["head"] = Ball(0.9, (-1.3, 1.3), axis=[0, 0, 1.0])
    for side, y in (("l", 1.0), ("r", -1.0)):
        made[f"arm0_{side}"] = Ball(1.6, (-0.8, 0.8))
        made[f"arm1_{side}"] = Hinge([0, 0, -y], 0.0, 2.5)
        made[f"arm2_{side}"] = Ball(1.2, (-1.5, 1.5), axis=[0, y, 0])
        made[f"leg0_{side}"] = Ball((2.0, 0.7), (-0.6, 0.6), across=[0, 1.0, 0])
        made[f"leg1_{side}"] = Hinge([0, 1.0, 0], 0.0, 2.6)
        made[f"leg2_{side}"] = Ball(0.9, (-0.4, 0.4), axis=[0, 0, -1.0])
    return made


@pytest.mark.parametrize("reach", [0.0, 0.5, 1.0, 4.0])
def test_limits_hold_whatever_is_asked(reach, rng):
    for _ in range(12):
        skeleton = chain(rng, 8)
        joints = mixed_joints(rng, skeleton)
        solver = IkSolver(skeleton, joints)
        start = skeleton.rest.coefficients.copy()
        wild = Rotor.random(rng, (8,))
        start = Motor.from_rotor_translation(wild, skeleton.rest.translation_m)
        place = skeleton.rest.translation_m[0] + reach * rng.standard_normal((3, 3))
        goals = [PoseGoal("j7", place, Rotor.random(rng, (3,)))]
        solved = solver.solve(start, goals, restarts=2)
        for pose in solved.local_pose:
            assert excess(skeleton, pose, joints) < 1e-9
            np.testing.assert_allclose(pose.translation_m, skeleton.rest.translation_m, atol=1e-14)


def test_poses_within_the_limits_are_found_again(rng):
    reached = 0
    for _ in range(60):
        skeleton = chain(rng, 6)
        joints = mixed_joints(rng, skeleton)
        solver = IkSolver(skeleton, joints)
        wild = Motor.from_rotor_translation(Rotor.random(rng, (6,)), skeleton.rest.translation_m)
        # With any tolerance a pose is only brought within its limits.
        within = solver.solve(wild, [PoseGoal("j5", [0.0, 0, 0])], tolerance=1e9).local_pose
        goal = PoseGoal.anchor(skeleton, within, "j5")
        solved = solver.solve(skeleton.rest, [PoseGoal("j5", goal.position_m)], restarts=8)
        end = skeleton.world(solved.local_pose)[5].translation_m
        off = np.linalg.norm(end - goal.position_m)
        assert off == pytest.approx(solved.error_m[0], abs=1e-12)
        assert bool(solved.reached[0]) == (off <= 1.0001e-6 * solver.size_m)
        reached += int(solved.reached[0])
    assert reached >= 54  # local searches may be caught; what they say of it is checked above


def test_four_hands_and_feet_a_look_and_an_anchor_at_once(rng):
    body = figure()
    solver = IkSolver(body, human_joints())
    feet = [PoseGoal.anchor(body, body.rest, f"leg2_{side}") for side in "lr"]
    eye = [0.1, 0.0, 0.05]
    goals = [
        *feet,
        PoseGoal("arm2_l", [0.35, 0.35, 1.2]),
        PoseGoal("arm2_r", [0.2, -0.45, 0.8], weight=0.5),
        LookAt("head", [2.0, 1.0, 1.0], point_m=eye),
    ]
    solved = solver.solve(body.rest, goals)
    assert solved.reached.all(), solved.summary()
    assert excess(body, solved.local_pose, human_joints()) < 1e-9
    world = body.world(solved.local_pose)
    for foot in feet:
        at = world[body.index(foot.joint)]
        np.testing.assert_allclose(at.translation_m, foot.position_m, atol=3e-6)
        assert float((at.rotor.inverse() @ foot.rotor).angle()) < 3e-6
    head = world[body.index("head")]
    gaze = np.array([2.0, 1.0, 1.0]) - head.apply(eye)
    ahead = head.rotor.apply([1.0, 0, 0])
    assert np.linalg.norm(np.cross(ahead, gaze / np.linalg.norm(gaze))) < 3e-6
    assert ahead @ gaze > 0.0


def test_anchored_feet_stay_while_the_body_moves():
    body = figure()
    joints = {k: v for k, v in human_joints().items() if k.startswith("leg")}
    solver = IkSolver(body, joints)
    feet = [PoseGoal.anchor(body, body.rest, f"leg2_{side}") for side in "lr"]
    low = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.0, 0.15, 0.1]), [[0.05, 0.03, 0.78]]
    )
    moved = body.rest.coefficients.copy()
    moved[0] = low.coefficients[0]
    solved = solver.solve(Motor(moved), feet)
    assert solved.reached.all(), solved.summary()
    np.testing.assert_array_equal(solved.local_pose.coefficients[0], moved[0])


def test_the_mannequin_reaches_with_both_hands_from_where_it_stands(rng):
    person = mannequin().skeleton
    legs, hands = legs_of(person), ("left_hand", "right_hand")
    joints = {person.names[person.root]: Floating()}
    for name in (*hands, *(leg.ankle for leg in legs)):
        joint = person.index(name)
        while joint != person.root:
            joints[person.names[joint]] = Ball(1.2, (-0.6, 0.6), axis=[0, 1.0, 0])
            joint = int(person.parents[joint])
    solver = IkSolver(person, joints)
    feet = [PoseGoal.anchor(person, person.rest, leg.ankle) for leg in legs]
    rest = person.rest_world.translation_m
    shift = rng.uniform(-0.2, 0.2, (10, 3))
    reach = [PoseGoal(name, rest[person.index(name)] + shift) for name in hands]
    solved = solver.solve(person.rest, [*feet, *reach])
    assert solved.reached.shape == (10, 4)
    assert solved.reached.all()
    at = person.world(solved.local_pose)
    for goal in (*feet, *reach):
        place = at[:, person.index(goal.joint)].translation_m
        assert np.linalg.norm(place - goal.position_m, axis=1).max() < 3e-6
    assert max(excess(person, pose, joints) for pose in solved.local_pose) < 1e-9


def test_weights_share_out_what_cannot_be_reached_together():
    solver = IkSolver(STRAIGHT, dict.fromkeys(STRAIGHT_NAMES[:-1], Ball()))
    one, two = np.array([0.3, 0.2, 0.5]), np.array([0.5, 0.1, 0.3])
    goals = [PoseGoal("j4", one, weight=2.0), PoseGoal("j4", two, weight=1.0)]
    solved = solver.solve(STRAIGHT.rest, goals)
    end = STRAIGHT.world(solved.local_pose)[4].translation_m
    np.testing.assert_allclose(end, (4.0 * one + two) / 5.0, atol=1e-6)
    assert not solved.reached.any()
    assert "no limit holds it" in solved.summary()


@pytest.mark.parametrize("place", [[0.0, 0, 0], [0, 0, 0.4], [0, 0, -0.7], [0, 0, 1.0]])
def test_in_line_with_a_straight_chain_and_at_its_base(place):
    solver = IkSolver(STRAIGHT, dict.fromkeys(STRAIGHT_NAMES[:-1], Ball()))
    solved = solver.solve(STRAIGHT.rest, [PoseGoal("j4", place)], restarts=0)
    assert solved.reached[0], solved.summary()


def test_a_goal_that_is_met_already_moves_nothing(rng):
    body = figure()
    solver = IkSolver(body, human_joints())
    goals = [PoseGoal.anchor(body, body.rest, name) for name in ("arm2_l", "leg2_r")]
    solved = solver.solve(body.rest, goals)
    assert solved.rounds == 0
    np.testing.assert_allclose(solved.local_pose.coefficients, body.rest.coefficients, atol=1e-15)


def test_hinges_that_cannot_help_say_so():
    along = {name: Hinge([0, 0, 1.0], -1.0, 1.0) for name in STRAIGHT_NAMES[:-1]}
    solved = IkSolver(STRAIGHT, along).solve(STRAIGHT.rest, [PoseGoal("j4", [0.5, 0, 0.5])])
    assert not solved.reached[0]
    assert solved.error_m[0] == pytest.approx(np.sqrt(0.5), abs=1e-12)
    assert np.isfinite(solved.local_pose.coefficients).all()


def test_what_holds_a_goal_is_named_with_its_end():
    solver = IkSolver(STRAIGHT, {"j3": Hinge([0, 1.0, 0], -0.5, 1.0)})
    for place, end, angle in (([1.0, 0, 0.75], "high", 1.0), ([-1.0, 0, 0.75], "low", -0.5)):
        solved = solver.solve(STRAIGHT.rest, [PoseGoal("j4", place)])
        (held,) = solved.held_by(0)
        assert (held.joint, held.limit, held.end) == ("j3", "hinge", end)
        turn = turns(STRAIGHT, solved.local_pose, "j3").as_rotvec()
        np.testing.assert_allclose(turn, [0.0, angle, 0.0], atol=1e-12)
    solver = IkSolver(STRAIGHT, {"j3": Ball(0.4, (-0.2, 0.3))})
    turned = Rotor.from_rotation_vector([0.0, 0.0, 1.0])
    (held,) = solver.solve(STRAIGHT.rest, [PoseGoal("j3", rotor=turned)]).held_by(0)
    assert (held.limit, held.end) == ("twist", "high")
    (held,) = solver.solve(STRAIGHT.rest, [PoseGoal("j4", [0.25, 0, 0.75])]).held_by(0)
    assert (held.limit, held.end) == ("swing", "edge")


def test_moving_everything_alike_changes_no_joint(rng):
    for _ in range(10):
        skeleton = chain(rng, 6)
        joints = mixed_joints(rng, skeleton)
        del joints["j0"]
        place, rotor = 0.6 * rng.standard_normal(3), Rotor.random(rng)
        move = Motor.random(rng)
        solver = IkSolver(skeleton, joints)
        moved = skeleton.rest.coefficients.copy()
        moved[0] = (move @ skeleton.rest[0]).coefficients
        goals = [PoseGoal("j5", place), PoseGoal("j5", rotor=rotor)]
        also = [PoseGoal("j5", move.apply(place)), PoseGoal("j5", rotor=move.rotor @ rotor)]
        one = solver.solve(skeleton.rest, goals, restarts=0)
        two = solver.solve(Motor(moved), also, restarts=0)
        np.testing.assert_allclose(one.error_m, two.error_m, atol=1e-6)
        np.testing.assert_allclose(
            one.local_pose.rotor.coefficients[1:], two.local_pose.rotor.coefficients[1:], atol=1e-4
        )


@pytest.mark.parametrize(("size", "rate"), [(0.4, 0.5), (1.0, 0.9)])
@pytest.mark.parametrize("joint", [Ball(), Ball(0.9, (-0.3, 0.3))])
def test_a_pose_follows_a_target_without_jumps(joint, size, rate):
    """With a quarter of the steps' length turns get less: in reach in proportion; where the target
    leaves it, where a chain's bends go by the root of what it lacks, slower.
    """
    solver = IkSolver(STRAIGHT, dict.fromkeys(STRAIGHT_NAMES[:-1], joint))
    most = []
    for steps in (400, 1600):
        phase = np.linspace(0.0, 2.0 * np.pi, steps)
        swung = [0.3 * np.cos(phase), 0.8 * np.sin(phase), 0.5 * np.sin(2.0 * phase)]
        path = [0.4, 0.0, 0.6] + size * np.stack(swung, axis=-1)
        pose = solver.solve(STRAIGHT.rest, [PoseGoal("j4", path[0])]).local_pose
        turned = 0.0
        for place in path:
            after = solver.solve(pose, [PoseGoal("j4", place)], restarts=0).local_pose
            turned = max(turned, float((pose.rotor.inverse() @ after.rotor).angle().max()))
            pose = after
        most.append(turned)
    assert most[0] < 0.4
    assert most[1] < rate * most[0]


def test_the_same_question_has_the_same_bytes_alone_and_in_a_batch(rng):
    skeleton = chain(rng, 7)
    solver = IkSolver(skeleton, mixed_joints(rng, skeleton))
    places = rng.standard_normal((4, 3))
    batch = solver.solve(skeleton.rest, [PoseGoal("j6", places)])
    again = solver.solve(skeleton.rest, [PoseGoal("j6", places)])
    np.testing.assert_array_equal(batch.local_pose.coefficients, again.local_pose.coefficients)
    for k, place in enumerate(places):
        alone = solver.solve(skeleton.rest, [PoseGoal("j6", place)])
        np.testing.assert_array_equal(
            alone.local_pose.coefficients, batch.local_pose.coefficients[k]
        )


def test_a_turn_about_the_bone_of_a_target_behind_is_found():
    solver = IkSolver(STRAIGHT, {"j0": Ball()})
    solved = solver.solve(STRAIGHT.rest, [LookAt("j0", [0, 0, -3.0], axis=[0, 0, 1.0])])
    assert solved.reached[0]


REFUSED = [
    (lambda: IkSolver(STRAIGHT, {}), "expected one or more"),
    (lambda: IkSolver(STRAIGHT, {"j9": Ball()}), "one of its joints"),
    (lambda: IkSolver(STRAIGHT, {"j4": Ball(1.0)}), "an axis for the ball 'j4'"),
    (lambda: IkSolver(STRAIGHT, {"j1": Ball((1.0, 0.5), across=[0, 0, 2])}), "not along its axis"),
    (lambda: Ball(4.0), "from 0 to pi"),
    (lambda: Ball((1.0, 2.0)), r"Ball\(across\)"),
    (lambda: Ball(1.0, (0.2, 0.1)), "not below it"),
    (lambda: Hinge([0, 0, 0]), "a direction"),
    (lambda: Hinge([0, 0, 1], 1.0, np.nan), "not below it"),
    (lambda: PoseGoal("j4"), "got neither"),
    (lambda: PoseGoal("j4", [0, 0]), r"expected shape \(\*, 3\)"),
    (lambda: Hinge([0, 0, 1], 1e17, 1e18), "within 1000 rad or infinite"),
    (lambda: PoseGoal("j4", [0, 0, 1], weight=0.0), r"from 1e-06 to 1e\+06"),
    (lambda: PoseGoal("j4", [0, 0, 1e200]), r"position_m\): expected lengths within 1e\+09 m"),
    (lambda: PoseGoal("j4", [0, 0, 1], point_m=[1e200, 0, 0]), r"point_m\): expected lengths"),
    (lambda: LookAt("j4", [0, 0, 1e200]), r"target_m\): expected lengths"),
    (lambda: LookAt("j4", [0, 0, 1], axis=[0, 0, 0]), "a direction"),
    (lambda: LookAt("j4", [0, np.nan, 1]), "finite"),
]


@pytest.mark.parametrize(("made", "message"), REFUSED)
def test_what_makes_no_sense_is_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_goals_that_do_not_fit_are_refused():
    solver = IkSolver(STRAIGHT, {"j2": Ball()})
    goal = PoseGoal("j4", [0, 0, 1.0])
    for pose, goals, options, message in (
        (STRAIGHT.rest[:3], [goal], {}, "local_pose"),
        (STRAIGHT.rest, [], {}, "one or more"),
        (STRAIGHT.rest, [PoseGoal("j1", [0, 0, 1.0])], {}, "hang on, a joint that may turn"),
        (STRAIGHT.rest, [goal], {"restarts": -1}, "restarts"),
        (STRAIGHT.rest, [goal], {"tolerance": 0.0}, "tolerance"),
    ):
        with pytest.raises(ValueError, match=message):
            solver.solve(pose, goals, **options)


def test_things_of_another_kind_are_refused():
    solver = IkSolver(STRAIGHT, {"j2": Ball()})
    goal = PoseGoal("j4", [0, 0, 1.0])
    for made, message in (
        (lambda: IkSolver(STRAIGHT, ["j2"]), r"joints\): expected a mapping"),
        (
            lambda: IkSolver(STRAIGHT, {"j2": Hinge}),
            r"joints\): expected a Hinge, Ball or Floating",
        ),
        (lambda: Hinge([0, 0, 1], "low", 1.0), r"low_rad, high_rad\): expected a number"),
        (lambda: Ball(1.0, ("low", "high")), r"twist_rad\): expected a number"),
        (lambda: PoseGoal("j4", rotor=[1, 0, 0, 0]), r"rotor\): expected a Rotor"),
        (lambda: LookAt("j4", [0, 0, 1], weight="heavy"), r"weight\): expected a number"),
        (lambda: solver.solve(STRAIGHT.rest.coefficients, [goal]), r"local_pose\): .* a Motor"),
        (lambda: solver.solve(STRAIGHT.rest, goal), r"goals\): expected a list"),
        (lambda: solver.solve(STRAIGHT.rest, [goal], restarts=1.5), r"restarts\): .* whole number"),
    ):
        with pytest.raises(TypeError, match=message):
            made()


@pytest.mark.parametrize("size", [1e-300, 1e300])
def test_axes_of_any_length_turn_alike(size):
    """Their squares come to nothing, or overflow."""
    goal = PoseGoal("j4", [0.3, 0.0, 0.2])
    found = [
        IkSolver(STRAIGHT, {"j1": Hinge([0, one, 0])}).solve(STRAIGHT.rest, [goal]).error_m
        for one in (1.0, size)
    ]
    np.testing.assert_array_equal(*found)


def test_bones_whose_squares_overflow_are_refused_and_not_called_reached():
    parent_T_joint = Motor.from_translation([[0, 0, 0], [1e200, 0, 0], [1e200, 0, 0]])
    skeleton = Skeleton(("a", "b", "c"), np.array([-1, 0, 1]), parent_T_joint)
    solver = IkSolver(skeleton, {"b": Ball()})
    with pytest.raises(ValueError, match="within 1e9 m"):
        solver.solve(skeleton.rest, [PoseGoal("c", [1.0, 2.0, 3.0])])


def test_a_body_that_floats_comes_to_goals_however_far():
    skeleton = Skeleton(("hips",), np.array([-1]), Motor.identity((1,)))
    solver = IkSolver(skeleton, {"hips": Floating()})
    solved = solver.solve(skeleton.rest, [PoseGoal("hips", [0.0, -2e5, 2e6])])
    assert solved.reached[0]
    np.testing.assert_allclose(solved.local_pose.translation_m[0], [0.0, -2e5, 2e6], rtol=1e-12)


def test_a_chain_of_a_thousand_joints_is_solved_in_few_operations():
    """Its second derivatives would fill nine million numbers in every step."""
    shifts_m = [[0.01, 0, 0]] * 1000
    names = tuple(f"j{k}" for k in range(1000))
    skeleton = Skeleton(names, np.arange(-1, 999), Motor.from_translation(shifts_m))
    solver = IkSolver(skeleton, dict.fromkeys(names, Ball()))
    solved = solver.solve(skeleton.rest, [PoseGoal("j999", [0.0, 30.0, 0.0])])
    assert not solved.reached[0]
    assert 19.99 <= solved.error_m[0] < 22.0  # 9.99 m of bones, 10 mm off the origin


def test_targets_beyond_the_bones_are_approached_in_few_rounds(rng):
    """Chains that bend by 60 degrees a joint stretch out to any target in front of them; without a
    look at second derivatives they fold into a heap first, which takes hundreds of rounds.
    """
    names = tuple(f"j{k}" for k in range(21))
    shifts = [[0.0, 0.0, 0.0], *[[0.0, 0.0, 0.05]] * 20]
    skeleton = Skeleton(names, np.arange(21) - 1, Motor.from_translation(shifts))
    solver = IkSolver(skeleton, dict.fromkeys(names[:-1], Ball(np.pi / 3.0, (-0.8, 0.8))))
    places = rng.standard_normal((100, 3))
    places *= rng.uniform(1.1, 2.0, (100, 1)) / np.linalg.norm(places, axis=1, keepdims=True)
    least = np.linalg.norm(places, axis=1) - 1.0
    ahead = places[:, 2] > np.cos(np.pi / 3.0) * (1.0 + least)
    for place, lacks, near in zip(places, least, ahead, strict=True):
        solved = solver.solve(skeleton.rest, [PoseGoal("j20", place)], restarts=0)
        assert solved.error_m[0] >= lacks - 1e-9
        assert solved.error_m[0] < lacks + (1e-6 if near else 0.1)
        assert solved.rounds <= 60


def test_a_solution_of_a_batch_asks_for_which_pose():
    solver = IkSolver(STRAIGHT, {"j2": Ball()})
    solved = solver.solve(STRAIGHT.rest, [PoseGoal("j4", [[0, 0, 9.0], [0, 9.0, 0]])])
    assert solved.summary((1,)).startswith("j4: ")
    for at in ((), (2,), (0, 0)):
        with pytest.raises(ValueError, match=r"expected a place in a batch \(2,\)"):
            solved.summary(at)
    with pytest.raises(ValueError, match=r"held_by\(goal\): expected 0 to 0, got 1"):
        solved.held_by(1, (0,))
