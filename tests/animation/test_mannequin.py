"""The mannequin: a sound mesh, and clips that loop, breathe and keep their feet on the ground."""

from collections import Counter

import numpy as np
import pytest

from motorcade.animation import Character, Clip, mannequin, skin
from motorcade.animation.mannequin import walk as gait
from motorcade.animation.mannequin.posing import reach
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
    toes, heel = small.skeleton.index("toes_left"), small.skeleton.index("foot_left")
    assert world[toes, 0] > world[heel, 0]
    assert world[toes, 1] > 0.0


def test_it_has_about_fifty_joints_and_thousands_of_triangles(figure: Character) -> None:
    assert 45 <= len(figure.skeleton) <= 60
    assert 3_000 <= len(figure.triangles) <= 20_000


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
        if name.endswith("_left"):
            twin = figure.skeleton.index(name.replace("_left", "_right"))
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


@pytest.mark.parametrize("name", ["idle", "walk"])
def test_nothing_sinks_into_the_ground_and_something_always_stands(
    figure: Character, name: str
) -> None:
    clip = figure.clip(name)
    times = np.linspace(0.0, clip.duration_s, 90)
    lowest = skin(figure, clip.at(times))[0][..., 2].min(axis=-1)
    assert lowest.min() > -0.002
    assert lowest.max() < 0.002


def sole_heights(figure: Character, clip: Clip, side: str, times: np.ndarray) -> np.ndarray:
    """Lowest point of one foot with its toes, over time."""
    joints = [figure.skeleton.index(f"foot_{side}"), figure.skeleton.index(f"toes_{side}")]
    own = np.isin(figure.joints[:, 0], joints) & (figure.weights[:, 0] > 0.0)
    vertices = skin(figure, clip.at(times))[0]
    return np.asarray(vertices[:, own, 2].min(axis=-1))


@pytest.mark.parametrize(("side", "shift"), [("left", 0.0), ("right", 0.5)])
def test_a_standing_foot_stays_on_the_ground_within_millimetres(
    figure: Character, side: str, shift: float
) -> None:
    clip = figure.clip("walk")
    phase = np.linspace(0.02, gait.STANCE - 0.02, 40)
    heights = sole_heights(figure, clip, side, np.mod(phase + shift, 1.0) * clip.duration_s)
    assert np.abs(heights).max() < 0.002


@pytest.mark.parametrize(("side", "shift"), [("left", 0.0), ("right", 0.5)])
def test_a_swinging_foot_clears_the_ground(figure: Character, side: str, shift: float) -> None:
    clip = figure.clip("walk")
    phase = np.linspace(gait.STANCE + 0.05, 0.92, 30)
    heights = sole_heights(figure, clip, side, np.mod(phase + shift, 1.0) * clip.duration_s)
    assert heights.min() > 0.004


def test_a_flat_standing_foot_moves_exactly_with_the_ground(figure: Character) -> None:
    clip = figure.clip("walk")
    sampled = clip.time_s[
        (clip.time_s > gait.FLAT_FROM * gait.PERIOD_S)
        & (clip.time_s < gait.FLAT_UNTIL * gait.PERIOD_S)
    ]
    world = figure.skeleton.world(clip.at(sampled))
    foot = world[:, figure.skeleton.index("foot_left")].translation_m
    velocity = np.diff(foot, axis=0) / np.diff(sampled)[:, None]
    ground = np.tile([-gait.SPEED_M_S, 0.0, 0.0], (len(velocity), 1))
    np.testing.assert_allclose(velocity, ground, atol=1e-9)


def test_idle_feet_do_not_move(figure: Character) -> None:
    clip = figure.clip("idle")
    world = figure.skeleton.world(clip.at(clip.time_s))
    for side in ("left", "right"):
        foot = world[:, figure.skeleton.index(f"foot_{side}")]
        still = (foot[:1].inverse() @ foot).as_twist()
        assert np.abs(still).max() < 1e-9


def test_inverse_kinematics_reaches_its_target(figure: Character, rng: np.random.Generator) -> None:
    hips = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(0.2 * rng.standard_normal((50, 3))),
        np.array([0.0, 0.0, 0.8]) + 0.02 * rng.standard_normal((50, 3)),
    )
    ankle = np.array([0.05, 0.08, 0.12]) + 0.08 * rng.uniform(-1.0, 1.0, (50, 3))
    foot = Rotor.from_rotation_vector(0.3 * rng.standard_normal((50, 3)))
    skeleton = figure.skeleton
    offset = [
        skeleton.rest[skeleton.index(f"{n}_left")].translation_m for n in ("thigh", "calf", "foot")
    ]
    leg = reach(hips, offset[0], ankle, foot)
    chain = hips
    for rotor, at in zip((leg.thigh, leg.calf, leg.foot), offset, strict=True):
        chain = chain @ Motor.from_rotor_translation(rotor, np.broadcast_to(at, (50, 3)))
    np.testing.assert_allclose(chain.translation_m, ankle, atol=1e-12)
    assert np.max((chain.rotor.inverse() @ foot).angle()) < 1e-9


def test_an_ankle_out_of_reach_is_refused() -> None:
    with pytest.raises(ValueError, match=r"within 0\.855 m"):
        reach(Motor.identity((1,)), np.zeros(3), np.array([[0.0, 0.0, -1.0]]), Rotor.identity((1,)))


def test_it_is_made_the_same_every_time(figure: Character) -> None:
    again = mannequin()
    np.testing.assert_array_equal(figure.vertices, again.vertices)
    np.testing.assert_array_equal(
        figure.clip("idle").poses.coefficients, again.clip("idle").poses.coefficients
    )
