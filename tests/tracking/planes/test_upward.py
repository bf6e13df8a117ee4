"""Up is found where it can be, and never sure where it cannot; leaves are no surface."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.planes import (
    FlatSurface,
    belief_in,
    estimate_up,
    find_planes,
    fit_plane,
    foot_level,
    segment_rays,
)
from tests.tracking.planes.drawn_stands import CAMERA, board, by_hand, stood, thirty

DOWN = np.array([0.0, -1.0, 0.0])


def tilted(pitch_deg: float) -> FloatArray:
    """The normal of a level surface that a camera looks down on by so much, in its axes."""
    pitch = np.deg2rad(pitch_deg)
    return np.array([0.0, -np.cos(pitch), -np.sin(pitch)])


def off_deg(found: FloatArray, true: FloatArray) -> float:
    return float(np.rad2deg(np.arccos(np.clip(found @ true, -1.0, 1.0))))


@pytest.mark.parametrize("pitch_deg", [10.0, 40.0, 65.0, 80.0, 88.0])
def test_a_surface_is_level_however_steeply_it_is_seen(pitch_deg: float) -> None:
    table = FlatSurface(tilted(pitch_deg), 0.95)
    up = estimate_up(Motor.identity((1,)), depth_m=1.0, surfaces=[table])
    assert off_deg(up.direction, table.normal) < 3.0
    assert up.probability(table.normal) > 0.5


def test_the_steeper_the_likelier_it_is_a_wall() -> None:
    shares = []
    for pitch_deg in (45.0, 75.0, 90.0):
        wall = FlatSurface(tilted(pitch_deg), 0.95)
        up = estimate_up(Motor.identity((1,)), depth_m=1.0, surfaces=[wall])
        shares.append(up.probability_across(wall.normal))
    assert shares == sorted(shares)
    assert shares[-1] > 0.1  # head on, a table from above and a wall look the same


def test_gravity_outweighs_all_else(rng: np.random.Generator) -> None:
    true = Motor.random(rng).rotor.apply(DOWN)
    up = estimate_up(
        Motor.identity((1,)),
        depth_m=1.0,
        surfaces=[FlatSurface(tilted(30.0), 0.9)],
        gravity_up=true,
    )
    assert off_deg(up.direction, true) < 3.0
    assert up.share > 0.9


def test_turning_the_world_turns_up(rng: np.random.Generator) -> None:
    path = by_hand(rng, np.array([0.0, -2.0, 1.5]), np.array([0.0, 1.0, 0.5])).motors
    other_T_world = Motor.random(rng)
    one, other = (estimate_up(poses, depth_m=2.0) for poses in (path, other_T_world @ path))
    assert off_deg(other.direction, other_T_world.rotor.apply(one.direction)) < 3.0
    assert other.share == pytest.approx(one.share, abs=0.05)


def test_upright_edges_tell_the_pitch(rng: np.random.Generator) -> None:
    """Posts before a camera that looks down by 25 degrees, drawn as lines."""
    import cv2

    pitch = np.deg2rad(25.0)
    camera_T_world = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([-np.pi / 2 + pitch, 0.0, 0.0]).inverse(), np.zeros(3)
    )
    image = np.full((CAMERA.height, CAMERA.width), 40, np.uint8)
    up = camera_T_world.rotor.apply([0.0, 0.0, 1.0])
    assert up[1] < -0.8  # the image's up, nearly
    for x in np.linspace(-1.2, 1.2, 16):
        foot = np.array([x, 0.3, 3.0])
        ends = CAMERA.project(np.stack([foot, foot + 1.2 * up])).astype(int)
        cv2.line(image, *map(tuple, ends.tolist()), int(rng.integers(120, 255)), 5)
    lines = segment_rays(image, CAMERA, Motor.identity())
    assert len(lines) >= 16
    found = estimate_up(Motor.identity((1,)), depth_m=3.0, lines=lines)
    assert off_deg(found.direction, up) < 4.0


def test_leaves_are_no_surface_and_a_floor_with_things_on_it_is(rng: np.random.Generator) -> None:
    eye = np.array([[0.0, -3.0, 1.5]])
    leaves = rng.normal([0.0, 0.0, 1.0], 0.6, (500, 3))
    floor = rng.uniform([-1.5, -1.5, 0.0], [1.5, 1.5, 0.0], (300, 3))
    floor[:, 2] += rng.normal(0.0, 0.01, 300)
    for points, low, high in ((leaves, 0.0, 0.2), (np.concatenate([floor, leaves]), 0.6, 1.0)):
        plane = find_planes(points, 0.03, rng, seen_from_m=eye[0]).planes[0]
        assert low <= belief_in(plane, points, 0.03, eye) <= high


def test_what_is_seen_through_is_no_surface(rng: np.random.Generator) -> None:
    pane = rng.uniform([-1.0, 2.0, -1.0], [1.0, 2.0, 1.0], (300, 3))
    beyond = rng.uniform([-1.0, 3.0, -1.0], [1.0, 4.0, 1.0], (400, 3))
    pane[:, 1] += rng.normal(0.0, 0.005, 300)
    plane, eye = fit_plane(pane), np.zeros((1, 3))
    assert belief_in(plane, pane, 0.02, eye) > 0.8
    assert belief_in(plane, np.concatenate([pane, beyond]), 0.02, eye) < 0.1


def test_the_foot_is_below_the_camera(rng: np.random.Generator) -> None:
    points = rng.uniform([-1.0, 0.0, 1.0], [1.0, 3.0, 4.0], (100, 3))
    points[:40, 2] = 0.2
    assert foot_level(points, np.array([0.0, 0.0, 1.0]), 1.5) == pytest.approx(0.2)
    assert foot_level(points[40:], np.array([0.0, 0.0, 1.0]), 0.5) > 1.0


def test_refusals() -> None:
    with pytest.raises(ValueError, match="expected one or more poses"):
        estimate_up(Motor.identity((0,)), depth_m=1.0)


def test_a_steep_table_and_a_board_that_stands_upright() -> None:
    """Two of the thirty: what was pasted flat, and what came sideways out of a screen."""
    scenes = {scene.name: scene for scene in thirty(np.random.default_rng(11))}
    table, board = stood(scenes["table from 70 deg"]), stood(scenes["board upright"])
    assert table.right
    assert board.right or board.ground.doubt


@pytest.mark.parametrize("seed", [13, 14, 15, 37, 41])
def test_a_board_that_leans_is_doubted(seed: int) -> None:
    """From steeply above its face it looks as a lying one does, and most prints lie."""
    ground = stood(board(np.random.default_rng([1, seed, 3]), "leaning")).ground
    assert "lies flat is a guess" in ground.doubt


def test_a_board_that_lies_is_not_doubted() -> None:
    outcomes = [stood(board(np.random.default_rng([0, seed, 3]), "lying")) for seed in range(5)]
    assert not any(one.ground.doubt for one in outcomes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(20, 24), 4471])
def test_thirty_drawn_scenes_are_stood_on_rightly_or_doubted(seed: int) -> None:
    """None is wrong in silence, and most are right without any image to see lines in."""
    outcomes = [stood(scene) for scene in thirty(np.random.default_rng(seed))]
    silent = [one for one in outcomes if not one.right and not one.ground.doubt]
    assert not silent, [one.name for one in silent]
    assert sum(one.right for one in outcomes) >= 20
