"""Skeletons, clips, characters and placements: what they refuse, and what they promise."""

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Clip, Placement, Skeleton, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor


def chain(joints: int = 3) -> Skeleton:
    """Joints one above the other, 1 m apart."""
    offsets = np.zeros((joints, 3))
    offsets[1:, 2] = 1.0
    rest = Motor.from_rotor_translation(Rotor.identity((joints,)), offsets)
    names = tuple(f"joint_{k}" for k in range(joints))
    return Skeleton(names, np.arange(joints) - 1, rest)


def triangle(skeleton: Skeleton) -> Character:
    """The smallest character: one triangle on the first joint."""
    weights = np.zeros((3, 4))
    weights[:, 0] = 1.0
    return Character(
        skeleton,
        np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        np.tile([1.0, 0.0, 0.0], (3, 1)),
        np.array([[0, 1, 2]]),
        np.full((3, 3), 0.5),
        np.zeros((3, 4), dtype=np.int64),
        weights,
    )


@pytest.mark.parametrize(
    ("names", "parents", "field"),
    [
        (("a", "a"), [-1, 0], "names"),
        ((), [], "names"),
        (("a", "b"), [-1], "parents"),
        (("a", "b"), [-1, 1], "parents"),
        (("a", "b"), [1, -1], "parents"),
        (("a", "b"), [-1, -2], "parents"),
        (("a", "b"), [-1.0, 0.0], "parents"),
        (("a", "b", "c"), [-1, 0, 1], "rest"),
    ],
)
def test_skeleton_refuses_what_is_no_tree(
    names: tuple[str, ...], parents: list[int], field: str
) -> None:
    with pytest.raises(ValueError, match=rf"Skeleton\.{field}"):
        Skeleton(names, np.array(parents), Motor.identity((2,)))


def test_world_pose_of_a_chain_is_the_product_of_matrices(rng: np.random.Generator) -> None:
    skeleton = chain(5)
    local = Motor.random(rng, (7, 5))
    matrices = local.as_matrix()
    expected = np.empty_like(matrices)
    expected[:, 0] = matrices[:, 0]
    for joint in range(1, 5):
        expected[:, joint] = expected[:, joint - 1] @ matrices[:, joint]
    np.testing.assert_allclose(skeleton.world(local).as_matrix(), expected, atol=1e-12)


def test_world_refuses_a_pose_of_another_skeleton() -> None:
    with pytest.raises(ValueError, match=r"expected shape \(\*, 3\)"):
        chain(3).world(Motor.identity((4,)))


def test_world_leaves_the_given_pose_alone(rng: np.random.Generator) -> None:
    local = Motor.random(rng, (3,))
    before = local.coefficients.copy()
    chain(3).world(local)
    np.testing.assert_array_equal(local.coefficients, before)


@pytest.mark.parametrize(
    ("name", "time_s", "count", "field"),
    [
        ("", [0.0, 1.0], 2, "name"),
        ("c", [], 0, "time_s"),
        ("c", [0.0, 0.0], 2, "time_s"),
        ("c", [0.0, np.nan], 2, "time_s"),
        ("c", [0.0, 1.0], 3, "poses"),
    ],
)
def test_clip_refuses_unordered_times_and_other_counts(
    name: str, time_s: list[float], count: int, field: str
) -> None:
    with pytest.raises(ValueError, match=rf"Clip\.{field}"):
        Clip(name, np.array(time_s), Motor.identity((count, 2)))


def test_looped_clip_refuses_ends_that_differ(rng: np.random.Generator) -> None:
    with pytest.raises(ValueError, match="last pose of a loop"):
        Clip("c", np.array([0.0, 1.0]), Motor.random(rng, (2, 3)), looped=True)


def test_looped_clip_accepts_the_other_sign_of_the_same_pose(rng: np.random.Generator) -> None:
    first = Motor.random(rng, (3,))
    ends = np.stack([first.coefficients, Motor.random(rng, (3,)).coefficients, -first.coefficients])
    assert Clip("c", np.array([0.0, 1.0, 2.0]), Motor(ends), looped=True).duration_s == 2.0


def test_clip_gives_its_samples_back(rng: np.random.Generator) -> None:
    poses = Motor.random(rng, (4, 3))
    times = np.array([0.5, 1.0, 1.25, 3.0])
    clip = Clip("c", times, poses)
    np.testing.assert_allclose(clip.at(times).as_matrix(), poses.as_matrix(), atol=1e-12)


def test_clip_holds_its_ends(rng: np.random.Generator) -> None:
    poses = Motor.random(rng, (2, 3))
    clip = Clip("c", np.array([0.0, 1.0]), poses)
    outside = clip.at(np.array([-5.0, 7.0])).as_matrix()
    np.testing.assert_allclose(outside, poses.as_matrix(), atol=1e-12)


def test_loop_repeats_with_its_period() -> None:
    walk = mannequin().clip("walk")
    times = np.linspace(-1.0, 2.0, 13)
    here, later = walk.at(times), walk.at(times + 3.0 * walk.duration_s)
    gap = (here.inverse() @ later).as_twist()
    assert np.abs(gap).max() < 1e-9


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("weights", np.full((3, 4), 0.3), "sum to 1"),
        ("weights", np.tile([1.5, -0.5, 0.0, 0.0], (3, 1)), "0 or more"),
        ("joints", np.full((3, 4), 3), "numbers from 0 to 2"),
        ("triangles", np.array([[0, 1, 3]]), "numbers from 0 to 2"),
        ("triangles", np.array([[0.0, 1.0, 2.0]]), "integers"),
        ("normals", np.full((3, 3), 2.0), "unit vectors"),
        ("colors", np.full((3, 3), 255.0), "sRGB from 0 to 1"),
        ("vertices", np.full((3, 3), np.nan), "finite"),
        ("colors", np.full((2, 3), 0.5), r"shape \(3, 3\)"),
        ("clips", (Clip("c", np.array([0.0]), Motor.identity((1, 9))),), "poses of 3 joints"),
    ],
)
def test_character_refuses(field: str, value: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(triangle(chain()), **{field: value})


def test_character_refuses_two_clips_of_one_name() -> None:
    clip = Clip("c", np.array([0.0]), Motor.identity((1, 3)))
    with pytest.raises(ValueError, match="different names"):
        replace(triangle(chain()), clips=(clip, clip))


@pytest.mark.parametrize("name", ["fly", -1, 0, 0.5, True, None, ""])
def test_unknown_clips_are_refused_with_those_there_are(name: object) -> None:
    """Clips go by their names; a number is none."""
    with pytest.raises(ValueError, match=rf"clip: expected one of 'idle', .*, got {name!r}"):
        mannequin().clip(name)


def test_arrays_of_a_character_are_read_only_copies() -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    character = replace(triangle(chain()), vertices=vertices)
    vertices[0] = 9.0
    assert character.vertices[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        character.vertices[0, 0] = 1.0


def test_placed_soles_lie_in_the_plane_and_the_height_is_as_asked(
    rng: np.random.Generator,
) -> None:
    figure = mannequin()
    world_T_plane = Motor.random(rng)
    placement = place_on_plane(figure, (0.3, -0.2), 0.7, height_m=0.25, world_T_plane=world_T_plane)
    placed = world_T_plane.inverse().apply(placement.apply(figure.vertices))
    assert abs(placed[:, 2].min()) < 1e-12
    assert placed[:, 2].max() == pytest.approx(0.25, abs=1e-12)


def test_heading_turns_the_face_from_x_towards_y() -> None:
    figure = mannequin()
    placement = place_on_plane(figure, (1.0, 2.0), np.pi / 2, height_m=1.0)
    ahead = placement.apply([[1.0, 0.0, 0.0]])[0] - placement.apply([[0.0, 0.0, 0.0]])[0]
    np.testing.assert_allclose(ahead, [0.0, placement.scale, 0.0], atol=1e-12)
    np.testing.assert_allclose(placement.world_T_character.translation_m, [1.0, 2.0, 0.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"height_m": 0.0}, "height_m"),
        ({"height_m": np.nan}, "height_m"),
        ({"height_m": 1.0, "position_m": (0.0, 0.0, 0.0)}, "position_m"),
        ({"height_m": 1.0, "heading_rad": np.inf}, "heading_rad"),
        ({"height_m": 1.0, "position_m": np.zeros((2, 2))}, "one position and one heading"),
        ({"height_m": 1.0, "heading_rad": [0.0, 1.0]}, "one position and one heading"),
        ({"height_m": 1.0, "world_T_plane": Motor.identity((2,))}, "one pose"),
    ],
)
def test_place_refuses(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        place_on_plane(mannequin(), **arguments)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.inf, np.nan])
def test_placement_refuses_a_scale_that_is_not_positive(scale: float) -> None:
    with pytest.raises(ValueError, match=r"Placement\.scale"):
        Placement(Motor.identity(), scale)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (("", [0.0], (1, 3)), r"Clip\.name: expected a name, got an empty string"),
        (("c", [0.0, 1.0], (3, 3)), r"Clip\.poses of 'c': expected shape \(2, J\), got \(3, 3\)"),
        (("c", [0.0], (1,)), r"Clip\.poses of 'c': expected shape \(1, J\), got \(1,\)"),
        (("c", [[0.0]], (1, 3)), r"Clip\.time_s of 'c': expected \(F,\)"),
        (("c", [0.0, 0.0], (2, 3)), r"Clip\.time_s of 'c': expected \(F,\) strictly increasing"),
    ],
)
def test_clips_that_are_none_are_refused_by_field(fields: tuple, message: str) -> None:
    name, time_s, shape = fields
    with pytest.raises(ValueError, match=message):
        Clip(name, np.array(time_s), Motor.identity(shape))


@pytest.mark.parametrize("count", [-1, 3])
def test_a_count_of_keys_beyond_the_samples_is_refused(count: int) -> None:
    with pytest.raises(ValueError, match=rf"Clip\.key_count of 'c': expected 1 to 2, got {count}"):
        Clip("c", np.array([0.0, 1.0]), Motor.identity((2, 3)), key_count=count)


def test_names_of_joints_lead_to_their_numbers() -> None:
    skeleton = chain(3)
    assert [skeleton.index(name) for name in skeleton.names] == [0, 1, 2]
    with pytest.raises(ValueError, match="expected one of its joints, got 'tail'"):
        skeleton.index("tail")


def test_a_character_without_vertices_is_refused() -> None:
    none = np.zeros((0, 3))
    with pytest.raises(ValueError, match="expected one vertex or more, got none"):
        Character(
            chain(),
            none,
            none,
            np.zeros((0, 3), dtype=np.int64),
            none,
            np.zeros((0, 4), dtype=np.int64),
            np.zeros((0, 4)),
        )


def test_the_heaviest_influence_of_each_vertex_stands_first() -> None:
    """Among equals the order of the file stays."""
    figure = replace(
        triangle(chain()),
        joints=np.array([[0, 1, 2, 0], [2, 1, 0, 0], [1, 0, 2, 0]]),
        weights=np.array([[0.1, 0.6, 0.3, 0.0], [0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]),
    )
    joints, weights = figure.influences
    assert joints.tolist() == [[1, 2, 0, 0], [2, 1, 0, 0], [1, 0, 2, 0]]
    np.testing.assert_array_equal(weights, np.sort(figure.weights, axis=1)[:, ::-1])
