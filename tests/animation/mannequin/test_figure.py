"""The mannequin: a sound mesh, and clips that loop, breathe and keep their feet on the ground."""

from collections import Counter

import numpy as np
import pytest

from motorcade.animation import Character, mannequin, skin
from motorcade.animation.mannequin.motions.posing import reach
from motorcade.ga import Motor, Rotor


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


def edges_of(triangles: np.ndarray) -> Counter[tuple[int, int]]:
    """Directed edges of a mesh, with how often each occurs."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return Counter(map(tuple, pairs.tolist()))


def test_it_stands_on_the_ground_at_the_asked_height_and_faces_x() -> None:
    small = mannequin(0.25)
    assert small.vertices[:, 2].min() == 0.0
    assert small.vertices[:, 2].max() == pytest.approx(0.25, abs=1e-12)
    world = small.skeleton.rest_world.translation_m
    toes, heel = small.skeleton.index("left_toes"), small.skeleton.index("left_foot")
    assert world[toes, 0] > world[heel, 0]
    assert world[toes, 1] > 0.0


def test_it_has_about_fifty_joints_and_thousands_of_triangles(figure: Character) -> None:
    assert 45 <= len(figure.skeleton) <= 60
    assert 23_000 <= len(figure.triangles) <= 31_000


def test_every_height_is_the_same_figure() -> None:
    one, two = mannequin(1.0), mannequin(2.0)
    np.testing.assert_allclose(2.0 * one.vertices, two.vertices, atol=1e-12)
    pose_one, pose_two = one.clip("walk").at(0.3), two.clip("walk").at(0.3)
    np.testing.assert_allclose(2.0 * skin(one, pose_one)[0], skin(two, pose_two)[0], atol=1e-9)


@pytest.mark.parametrize("height_m", [0.0, -1.0, np.nan, np.inf])
def test_a_height_that_is_not_positive_is_refused(height_m: float) -> None:
    with pytest.raises(ValueError, match="height_m"):
        mannequin(height_m)


def test_every_part_is_closed_and_consistently_turned(figure: Character) -> None:
    edges = edges_of(figure.triangles)
    assert max(edges.values()) == 1
    assert all((b, a) in edges for a, b in edges)


def test_normals_point_outwards(figure: Character) -> None:
    corners = figure.vertices[figure.triangles]
    # the volume that a closed surface encloses is positive where its faces look outwards
    volume = np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert 0.03 < volume < 0.12
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.sum(face[:, None] * figure.normals[figure.triangles], axis=-1).max(1) > -1e-12)


def test_left_and_right_mirror_each_other(figure: Character) -> None:
    world = figure.skeleton.rest_world.translation_m
    for joint, name in enumerate(figure.skeleton.names):
        if name.startswith("left_"):
            twin = figure.skeleton.index(name.replace("left_", "right_"))
            np.testing.assert_allclose(world[twin], world[joint] * [1.0, -1.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("name", ["idle", "walk"])
def test_clips_close_in_position_and_velocity(figure: Character, name: str) -> None:
    clip = figure.clip(name)
    step = float(np.diff(clip.time_s)[0])
    around = skin(figure, clip.at(clip.duration_s + step * np.arange(-2.0, 3.0)))[0]
    velocity = np.diff(around, axis=0) / step
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=-1).max()
    inside = skin(figure, clip.at(clip.time_s))[0]
    usual = np.linalg.norm(np.diff(inside, n=2, axis=0) / step, axis=-1).max()
    assert change <= 1.05 * usual


@pytest.mark.parametrize(("name", "most_m_s"), [("idle", 0.4), ("walk", 4.5)])
def test_clips_move_like_a_body(figure: Character, name: str, most_m_s: float) -> None:
    clip = figure.clip(name)
    vertices = skin(figure, clip.at(clip.time_s))[0]
    speed = np.linalg.norm(np.diff(vertices, axis=0), axis=-1) / np.diff(clip.time_s)[:, None]
    assert 0.01 < speed.max() < most_m_s


def test_idle_feet_do_not_move(figure: Character) -> None:
    clip = figure.clip("idle")
    world = figure.skeleton.world(clip.at(clip.time_s))
    for side in ("left", "right"):
        foot = world[:, figure.skeleton.index(f"{side}_foot")]
        still = (foot[:1].inverse() @ foot).as_twist()
        assert np.abs(still).max() < 1e-9


def test_an_ankle_out_of_reach_is_refused() -> None:
    with pytest.raises(ValueError, match=r"within 0\.855 m"):
        reach(Motor.identity((1,)), np.zeros(3), np.array([[0.0, 0.0, -1.0]]), Rotor.identity((1,)))


def test_it_is_made_the_same_every_time(figure: Character) -> None:
    again = mannequin()
    np.testing.assert_array_equal(figure.vertices, again.vertices)
    np.testing.assert_array_equal(
        figure.clip("idle").poses.coefficients, again.clip("idle").poses.coefficients
    )
