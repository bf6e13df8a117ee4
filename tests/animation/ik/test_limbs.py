"""Limbs bent to targets, joints that aim, chains of a skeleton, and feet that stay put."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Skeleton
from motorcade.animation.ik import Chain, GroundHeights, Leg, aim, bend_limb, plant_feet, reach_with
from motorcade.animation.ik.feet import find_stances, swing_lift_m
from motorcade.ga import Motor, Rotor

NAMES = ("hips", "thigh", "calf", "foot", "toes", "head")
PARENTS = np.array([-1, 0, 1, 2, 3, 0])
LIMB = ("thigh", "calf", "foot")


@pytest.fixture
def skeleton(rng) -> Skeleton:
    """A leg of 0.9 m below the hips, joints turned anyhow."""
    at = np.array(
        [
            [0, 0, 1.0],
            [0, 0.1, 0.95],
            [0.03, 0.1, 0.5],
            [0, 0.1, 0.08],
            [0.15, 0.1, 0.0],
            [0, 0, 1.5],
        ]
    )
    world = Motor.from_rotor_translation(Rotor.random(rng, (6,)), at)
    rest = [world[0], *(world[int(p)].inverse() @ world[k + 1] for k, p in enumerate(PARENTS[1:]))]
    return Skeleton(NAMES, PARENTS, Motor.stack(rest))


def _at(skeleton, pose, name):
    return skeleton.world(pose)[..., skeleton.index(name)]


def test_a_limb_reaches_what_is_within_reach_and_bends_to_its_pole(skeleton, rng):
    hip = skeleton.rest_world[1].translation_m
    away = rng.standard_normal((500, 3))
    targets = hip + away / np.linalg.norm(away, axis=1, keepdims=True) * rng.uniform(
        0.1, 0.85, (500, 1)
    )
    poles = hip + rng.standard_normal((500, 3))
    made = bend_limb(skeleton, skeleton.rest, LIMB, targets, poles)
    assert made.shape == (500, 6)
    np.testing.assert_allclose(_at(skeleton, made, "foot").translation_m, targets, atol=1e-9)
    knee = _at(skeleton, made, "calf").translation_m - hip
    ahead = targets - hip
    normal = np.cross(ahead, poles - hip)
    np.testing.assert_allclose(np.sum(knee * normal, axis=1), 0.0, atol=1e-9)
    side = np.cross(normal, ahead)
    assert np.all(np.sum(knee * side, axis=1) > 0.0)
    # Bones keep their lengths, the foot its orientation, the rest its pose.
    lengths = [
        np.linalg.norm(
            _at(skeleton, made, b).translation_m - _at(skeleton, made, a).translation_m, axis=1
        )
        for a, b in (("thigh", "calf"), ("calf", "foot"))
    ]
    rest = skeleton.rest_world.translation_m
    np.testing.assert_allclose(lengths[0], np.linalg.norm(rest[2] - rest[1]), atol=1e-12)
    np.testing.assert_allclose(lengths[1], np.linalg.norm(rest[3] - rest[2]), atol=1e-12)
    turned = _at(skeleton, made, "foot").rotor.inverse() @ skeleton.rest_world[3].rotor
    assert float(turned.angle().max()) < 1e-7
    assert np.abs((made[:, 5].inverse() @ skeleton.rest[5:6]).as_twist()).max() < 1e-14


@pytest.mark.parametrize("distance", [3.0, 1e-9, 0.0])
def test_out_of_reach_a_limb_is_stretched_or_folded(skeleton, distance):
    rest = skeleton.rest_world.translation_m
    most = np.linalg.norm(rest[2] - rest[1]) + np.linalg.norm(rest[3] - rest[2])
    target = rest[1] + distance * np.array([0.6, 0.0, -0.8])
    made = bend_limb(skeleton, skeleton.rest, LIMB, target)
    reached = np.linalg.norm(_at(skeleton, made, "foot").translation_m - rest[1])
    least = abs(np.linalg.norm(rest[2] - rest[1]) - np.linalg.norm(rest[3] - rest[2]))
    expected = most if distance > 1 else least
    assert reached == pytest.approx(expected, abs=1e-5)
    assert np.isfinite(made.coefficients).all()


def test_a_joint_aims_by_the_least_turn_and_no_farther_than_allowed(skeleton, rng):
    targets = rng.standard_normal((200, 3)) * 3.0
    made = aim(skeleton, skeleton.rest, "head", targets, axis=(0, 0, 1.0))
    head = _at(skeleton, made, "head")
    ahead = head.rotor.apply([0.0, 0.0, 1.0])
    to = targets - head.translation_m
    to /= np.linalg.norm(to, axis=1, keepdims=True)
    np.testing.assert_allclose(ahead, to, atol=1e-9)
    held = aim(skeleton, skeleton.rest, "head", targets, axis=(0, 0, 1.0), max_turn_rad=0.3)
    turned = _at(skeleton, held, "head").rotor @ skeleton.rest_world[5].rotor.inverse()
    assert float(turned.angle().max()) <= 0.3 + 1e-9


def test_a_chain_of_a_skeleton_reaches(skeleton, rng):
    chain = Chain(("hips", "thigh", "calf", "foot", "toes"), 2.6)
    targets = skeleton.rest_world[0].translation_m + 0.4 * rng.standard_normal((100, 3))
    made, error = reach_with(skeleton, skeleton.rest, chain, targets)
    near = np.linalg.norm(targets - skeleton.rest_world[0].translation_m, axis=1) < 0.9
    assert error[near].max() < 1e-4
    at = _at(skeleton, made, "toes").translation_m
    np.testing.assert_allclose(np.linalg.norm(at - targets, axis=1)[near], 0.0, atol=1e-4)
    with pytest.raises(ValueError, match="expected 'hips' to be the parent of 'calf'"):
        reach_with(skeleton, skeleton.rest, Chain(("hips", "calf")), targets)


def _swinging(skeleton, time_s: np.ndarray, slide: float) -> Motor:
    """The foot stands for half a cycle of 1 s, sliding a little, and swings for the other."""
    phase = time_s % 1.0
    stance = phase < 0.5
    x = np.where(
        stance,
        slide * phase,
        0.5 * slide + 0.4 * (0.5 - 0.5 * np.cos(2 * np.pi * (phase - 0.5))) - (phase - 0.5) * slide,
    )
    z = np.where(stance, 0.08, 0.08 + 0.15 * np.sin(2 * np.pi * (phase - 0.5)))
    targets = np.stack([x, np.full_like(x, 0.1), z], axis=1)
    return bend_limb(skeleton, skeleton.rest, LIMB, targets)


def test_a_planted_foot_neither_slides_nor_sinks(skeleton):
    time_s = np.linspace(0.0, 2.0, 121)
    poses = _swinging(skeleton, time_s, slide=0.12)
    legs = [Leg("thigh", "calf", "foot", "toes")]
    before = _at(skeleton, poses, "toes").translation_m
    standing = find_stances(before, time_s)
    assert 0.3 < standing.mean() < 0.6
    hill = GroundHeights(lambda at: 0.05 * at[..., 0])
    made = plant_feet(skeleton, time_s, poses, legs, ground=hill)
    after = _at(skeleton, made, "toes").translation_m
    edges = np.flatnonzero(np.diff(standing.astype(int))) + 1
    for run in np.split(np.arange(len(time_s)), edges):
        if standing[run[0]]:
            assert np.ptp(before[run, 0]) > 0.02
            assert np.ptp(after[run, :2], axis=0).max() < 1e-6
            # It comes down and rises as it did, on the ground and not below.
            over = np.maximum(before[run, 2] - np.median(before[run, 2]), 0.0)
            np.testing.assert_allclose(after[run, 2] - 0.05 * after[run, 0], over, atol=1e-6)
    assert np.all(after[:, 2] > 0.05 * after[:, 0] - 1e-6)
    # What is held is faded in: no jump from frame to frame beyond the motion's own.
    steps = np.linalg.norm(np.diff(after, axis=0), axis=1).max()
    assert steps < 1.5 * np.linalg.norm(np.diff(before, axis=0), axis=1).max()


def _grazing(skeleton, rate_hz: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Toes ``(F, 3)``, played and planted, that swing there and back from 0.5 s to 1 s, so high."""
    time_s = np.arange(0.0, 1.5, 1.0 / rate_hz)
    standing = (time_s < 0.5) | (time_s > 1.0)
    swing = np.where(standing, 0.0, np.sin(2.0 * np.pi * (time_s - 0.5)) ** 2)
    targets = np.stack([0.25 * swing, np.full_like(swing, 0.1), 0.08 + high * swing], axis=1)
    low = skeleton.rest.coefficients.copy()
    low[0] = (Motor.from_twist([0, 0, 0, 0, 0, -0.1]) @ skeleton.rest[0]).coefficients
    poses = bend_limb(skeleton, Motor(low), LIMB, targets)
    legs = [Leg("thigh", "calf", "foot", "toes")]
    made = plant_feet(skeleton, time_s, poses, legs, stances=[standing])
    played, planted = (_at(skeleton, one, "toes").translation_m for one in (poses, made))
    return played, planted


@pytest.mark.parametrize("high", [-0.03, 0.0, 0.005, 0.03])
def test_a_swinging_foot_clears_the_ground_without_a_jolt(skeleton, high):
    """By 1.4 % of the leg's 0.87 m; and velocities change by half as much in half the time."""
    _, toes = _grazing(skeleton, 240.0, high)
    swing = toes[int(240 * 0.6) : int(240 * 0.9)]
    assert 0.012 < swing[:, 2].min() < 0.03
    assert np.abs(toes[: int(240 * 0.5), 2]).max() < 1e-6
    steps = []
    for rate_hz in (480.0, 960.0):
        speed = np.diff(_grazing(skeleton, rate_hz, high)[1], axis=0) * rate_hz
        steps.append(np.linalg.norm(np.diff(speed, axis=0), axis=1).max())
    assert steps[1] < 0.6 * steps[0]


def test_a_foot_that_goes_high_or_nowhere_is_not_lifted(skeleton):
    time_s = np.arange(0.0, 1.5, 1.0 / 60.0)
    before, after = _grazing(skeleton, 60.0, 0.15)
    np.testing.assert_allclose(after[42:48], before[42:48], atol=2e-3)
    legs, still = [Leg("thigh", "calf", "foot", "toes")], Motor.stack([skeleton.rest] * 90)
    moved = still.coefficients.copy()
    sway = np.zeros((90, 6))
    sway[:, 3] = 0.004 * np.sin(2.0 * np.pi * time_s)
    moved[:, 0] = (Motor.from_twist(sway) @ still[:, 0]).coefficients
    made = plant_feet(
        skeleton,
        time_s,
        Motor(moved),
        legs,
        stances=[(time_s % 1.0) < 0.5],
    )
    assert _at(skeleton, made, "toes").translation_m[:, 2].max() < 5e-4


def test_a_standing_foot_keeps_its_heading_while_the_ankle_goes_over_the_ball(skeleton):
    """At heel-off the way from ankle to ball turns back; the foot does not."""
    pitch = np.linspace(0.0, np.radians(130.0), 31)
    turn = Rotor.from_rotation_vector(pitch[:, None] * [0.0, 1.0, 0.0])
    poses = Motor.stack([skeleton.rest] * 31).coefficients.copy()
    foot, rest = skeleton.index("foot"), skeleton.rest_world
    place = np.tile(rest[foot].translation_m, (31, 1))
    turned = Motor.from_rotor_translation(turn @ rest[foot].rotor, place)
    poses[:, foot] = (rest[foot - 1].inverse() @ turned).coefficients
    plain = Motor(poses)
    along = np.diff(
        [_at(skeleton, plain, name).translation_m[:, 0] for name in ("foot", "toes")], axis=0
    )
    assert along.min() < -0.01 < 0.01 < along.max()
    made = plant_feet(
        skeleton,
        np.arange(31) / 60.0,
        plain,
        [Leg("thigh", "calf", "foot", "toes")],
        stances=[np.ones(31, dtype=bool)],
    )
    for name in ("foot", "toes"):
        across = rest[skeleton.index(name)].rotor.inverse().apply(np.array([0.0, 1.0, 0.0]))
        side = _at(skeleton, made, name).rotor.apply(across)
        np.testing.assert_allclose(side, np.tile([0.0, 1.0, 0.0], (31, 1)), atol=1e-6)


def test_a_knee_stays_ahead_where_the_leg_is_laid_beyond_it(skeleton):
    """A foot held 0.4 m ahead of where it slid: towards its old place the knee would fold back."""
    time_s = np.arange(60) / 60.0
    slid = np.linspace(0.4, -0.4, 60)
    targets = np.stack([slid, np.full(60, 0.1), np.full(60, 0.08)], axis=1)
    low = skeleton.rest.coefficients.copy()
    low[0] = (Motor.from_twist([0, 0, 0, 0, 0, -0.15]) @ skeleton.rest[0]).coefficients
    poses = bend_limb(skeleton, Motor(low), LIMB, targets, [9.0, 0.1, 0.5])
    made = plant_feet(
        skeleton,
        time_s,
        poses,
        [Leg("thigh", "calf", "foot", "toes")],
        stances=[np.ones(60, dtype=bool)],
    )
    for one in (poses, made):
        hip, knee, foot = (_at(skeleton, one, name).translation_m for name in LIMB)
        along = foot - hip
        share = np.sum((knee - hip) * along, axis=1) / np.sum(along**2, axis=1)
        assert (knee - hip - share[:, None] * along)[:, 0].min() > 0.05


def test_hips_come_down_where_a_leg_would_not_reach(skeleton):
    poses = Motor.stack([skeleton.rest] * 3)
    pit = GroundHeights(lambda at: np.full(at.shape[:-1], -0.2))
    time_s = np.array([0.0, 0.5, 1.0])
    made = plant_feet(
        skeleton,
        time_s,
        poses,
        [Leg("thigh", "calf", "foot")],
        ground=pit,
        stances=[np.ones(3, dtype=bool)],
    )
    foot = _at(skeleton, made, "foot").translation_m
    np.testing.assert_allclose(foot[:, 2], skeleton.rest_world[3].translation_m[2] - 0.2, atol=1e-6)
    assert _at(skeleton, made, "hips").translation_m[0, 2] < 0.95


def test_limbs_and_aims_that_are_none_are_refused(skeleton):
    rest = skeleton.rest
    flat = rest.coefficients.copy()
    flat[skeleton.index("calf")] = Motor.identity().coefficients
    with pytest.raises(ValueError, match="expected bones longer than 0"):
        bend_limb(skeleton, Motor(flat), LIMB, [0.0, 0.0, 0.5])
    with pytest.raises(ValueError, match=r"Chain\.joints: expected two or more, got \('hips',\)"):
        Chain(("hips",))
    with pytest.raises(ValueError, match=r"aim\(axis\): expected a direction"):
        aim(skeleton, rest, "head", [1.0, 0.0, 0.0], axis=(0.0, 0.0, 0.0))
    for share in (-0.1, 1.1, np.nan):
        with pytest.raises(ValueError, match=r"aim\(share\): expected 0 to 1"):
            aim(skeleton, rest, "head", [1.0, 0.0, 0.0], share=share)
    with pytest.raises(ValueError, match="got 'tail'"):
        aim(skeleton, rest, "tail", [1.0, 0.0, 0.0])
    for target in ([np.nan, 0.0, 0.0], [1.0, 0.0]):
        with pytest.raises(ValueError, match="target_m"):
            bend_limb(skeleton, rest, LIMB, target)


@pytest.mark.parametrize("keep", [True, False])
def test_the_end_of_a_limb_keeps_its_turn_in_the_world_or_follows_the_limb(skeleton, keep):
    target = skeleton.rest_world.translation_m[skeleton.index("foot")] + [0.2, 0.05, 0.2]
    made = bend_limb(skeleton, skeleton.rest, LIMB, target, keep_end_orientation=keep)
    number = skeleton.index("foot")
    if keep:
        found, wanted = skeleton.world(made)[number], skeleton.rest_world[number]
    else:
        found, wanted = made[number], skeleton.rest[number]
    assert float((found.rotor.inverse() @ wanted.rotor).angle()) < 1e-9


def test_a_foot_that_goes_along_the_ground_is_lifted_off_it_at_once() -> None:
    time_s = np.arange(60) / 60.0
    standing = (time_s < 0.3) | (time_s > 0.7)
    at = np.zeros((60, 3))
    at[:, 0] = np.clip(3.0 * (time_s - time_s[standing][0] - 0.3), 0.0, 1.2)  # 50 mm a frame
    lift = swing_lift_m(at, np.zeros(60), time_s, standing, 0.8)
    moved = np.abs(at[:, 0] - np.where(time_s < 0.5, 0.0, at[-1, 0])) > 0.02
    assert lift[~standing & moved].min() > 0.005  # 0.3 % of a height of 1.7 m
    assert np.all(lift[standing] == 0.0)
