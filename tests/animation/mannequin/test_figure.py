"""The mannequin's body: one closed, smooth, symmetric skin of any fineness, bound softly."""

import subprocess
import sys

import numpy as np
import pytest

from motorcade.animation import Character, mannequin
from motorcade.animation.mannequin.proportions import mannequin_skeleton
from motorcade.animation.mannequin.shape.anatomy import body_field
from motorcade.animation.mannequin.shape.surface import SymmetricMesh, meshed
from motorcade.animation.mannequin.shape.weights import influences


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def coarse() -> SymmetricMesh:
    return meshed(body_field(), 6_000)


def edges_of(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2) of a mesh, smaller number first, and how often each occurs."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, times = np.unique(edges, axis=0, return_counts=True)
    return unique, times


def characteristic(vertices: np.ndarray, triangles: np.ndarray) -> int:
    """Euler's number, 2 for a sphere."""
    return len(vertices) - len(edges_of(triangles)[0]) + len(triangles)


def test_it_stands_on_the_ground_at_the_asked_height_and_faces_x() -> None:
    small = mannequin(0.25)
    assert small.vertices[:, 2].min() == 0.0
    assert small.vertices[:, 2].max() == pytest.approx(0.25, abs=1e-12)
    world = small.skeleton.rest_world.translation_m
    toes, heel = small.skeleton.index("left_toes"), small.skeleton.index("left_foot")
    assert world[toes, 0] > world[heel, 0]
    assert world[toes, 1] > 0.0


def test_it_has_the_joints_of_a_body_with_fingers(figure: Character) -> None:
    names = figure.skeleton.names
    assert len(names) == 52
    fingers = ("thumb", "index", "middle", "ring", "little")
    wanted = {
        f"{side}_{finger}_{k}"
        for side in ("left", "right")
        for finger in fingers
        for k in (1, 2, 3)
    }
    assert wanted | {"hips", "spine", "chest", "neck", "head", "left_upper_arm"} <= set(names)


@pytest.mark.parametrize(
    "triangles",
    [5_000, 8_000, 11_500, 27_000, pytest.param(140_000, marks=pytest.mark.slow)],
)
def test_the_knob_sets_the_number_of_triangles_of_one_whole_skin(triangles: int) -> None:
    mesh = meshed(body_field(), triangles)
    assert abs(len(mesh.triangles) / triangles - 1.0) < 0.15
    assert characteristic(mesh.vertices, mesh.triangles) == 2
    assert np.all(edges_of(mesh.triangles)[1] == 2)


@pytest.mark.parametrize("triangles", [4_999, 140_001])
def test_other_numbers_of_triangles_are_refused(triangles: int) -> None:
    with pytest.raises(ValueError, match="5,000 to 140,000"):
        mannequin(triangles=triangles)


@pytest.mark.parametrize("height_m", [0.0, -1.0, np.nan, np.inf])
def test_a_height_that_is_not_positive_is_refused(height_m: float) -> None:
    with pytest.raises(ValueError, match="height_m"):
        mannequin(height_m)


def test_the_skin_is_the_zero_of_the_field_and_normals_are_its_slope(coarse: SymmetricMesh) -> None:
    field, step = body_field(), 1e-4
    assert np.abs(field.distance_m(coarse.vertices, 0.01)).max() < 1.5e-3
    # a point a little along the normal is outside by about as much, one below it inside
    outside = field.distance_m(coarse.vertices + step * coarse.normals, 0.01)
    inside = field.distance_m(coarse.vertices - step * coarse.normals, 0.01)
    assert np.all(outside > inside)


def test_normals_point_outwards(figure: Character) -> None:
    corners = figure.vertices[figure.triangles]
    # the volume that a closed surface encloses is positive where its faces look outwards; a body
    # of 1.75 m displaces about 60 litres
    volume = np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert 0.05 < volume < 0.07
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    agree = np.sum(face * figure.normals[figure.triangles].sum(axis=1), axis=1)
    assert np.mean(agree > 0.0) > 0.999


def test_left_and_right_mirror_each_other_in_joints_skin_and_weights(coarse: SymmetricMesh) -> None:
    skeleton = mannequin_skeleton()
    world = skeleton.rest_world.translation_m
    mirrored = [
        skeleton.index(name.replace("left_", "right_"))
        if name.startswith("left_")
        else skeleton.index(name.replace("right_", "left_"))
        for name in skeleton.names
    ]
    np.testing.assert_allclose(world[mirrored], world * [1.0, -1.0, 1.0], atol=1e-12)
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_array_equal(coarse.vertices[coarse.twins], coarse.vertices * flip)
    np.testing.assert_array_equal(coarse.normals[coarse.twins], coarse.normals * flip)
    dense = dense_weights(*influences(coarse, skeleton), len(skeleton))
    np.testing.assert_allclose(dense[coarse.twins][:, mirrored], dense, atol=1e-9)


def dense_weights(joints: np.ndarray, weights: np.ndarray, count: int) -> np.ndarray:
    made = np.zeros((len(joints), count))
    for k in range(4):
        np.add.at(made, (np.arange(len(joints)), joints[:, k]), weights[:, k])
    return made


def test_weights_change_smoothly_along_the_skin(figure: Character) -> None:
    dense = dense_weights(figure.joints, figure.weights, len(figure.skeleton))
    edges, _ = edges_of(figure.triangles)
    change = np.abs(dense[edges[:, 0]] - dense[edges[:, 1]]).max(axis=1)
    # the steepest are finger joints, where a triangle is half as long as a bone
    assert change.max() < 0.5
    fingers = [k for k, name in enumerate(figure.skeleton.names) if name[-1].isdigit()]
    away = dense[edges[:, 0]][:, fingers].sum(axis=1) + dense[edges[:, 1]][:, fingers].sum(axis=1)
    assert change[away < 0.01].max() < 0.35
    assert np.quantile(change, 0.9) < 0.15


def test_every_joint_carries_skin_that_lies_around_it(figure: Character) -> None:
    dense = dense_weights(figure.joints, figure.weights, len(figure.skeleton))
    held = dense.max(axis=0)
    assert held.min() > 0.4, figure.skeleton.names[int(np.argmin(held))]
    world = figure.skeleton.rest_world.translation_m
    for joint in range(len(figure.skeleton)):
        own = dense[:, joint] > 0.3
        away = np.linalg.norm(figure.vertices[own] - world[joint], axis=1).max()
        assert away < 0.56, figure.skeleton.names[joint]


def test_every_height_is_the_same_figure() -> None:
    one, two = mannequin(1.0), mannequin(2.0)
    np.testing.assert_allclose(2.0 * one.vertices, two.vertices, atol=1e-12)
    np.testing.assert_allclose(
        2.0 * one.clip("walk").at(0.3).translation_m,
        two.clip("walk").at(0.3).translation_m,
        atol=1e-12,
    )


def test_it_is_made_the_same_every_time(coarse: SymmetricMesh) -> None:
    again = meshed(body_field(), 6_000)
    for name in ("vertices", "normals", "triangles"):
        np.testing.assert_array_equal(getattr(coarse, name), getattr(again, name))


def test_the_room_is_imported_without_what_makes_the_skin() -> None:
    program = "import sys, motorcade.animation; print('skimage' in sys.modules)"
    made = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert made.stdout.strip() == "False", made.stderr


class _Balls:
    """Balls of 0.3 m at points (N, 3), in the place of a body."""

    def __init__(self, *centres_m: tuple[float, float, float]) -> None:
        self._centres_m = centres_m

    def distance_m(self, points_m: np.ndarray, near_m: float = 0.0) -> np.ndarray:
        apart = [np.linalg.norm(points_m - centre, axis=1) for centre in self._centres_m]
        return np.min(apart, axis=0) - 0.15


def test_a_solid_in_pieces_is_refused() -> None:
    """Half of a body is one piece: what floats beside it would tear its skin."""
    with pytest.raises(RuntimeError, match="no grid gives about 2000 triangles in one whole piece"):
        meshed(_Balls((0.0, 0.0, 0.4), (0.0, 0.4, 0.9)), 2_000)


def test_without_scikit_image_the_extra_that_brings_it_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "skimage.measure", None)
    with pytest.raises(ModuleNotFoundError, match=r'pip install "motorcade\[pipeline\]"'):
        meshed(_Balls((0.0, 0.0, 0.4)), 2_000)
