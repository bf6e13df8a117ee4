"""The mannequin: the file that ships, and that the generator beside the documentation makes it."""

import io
import json
import struct
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from docs.making.figure.build import figure as made_anew
from docs.making.figure.proportions import figure_skeleton
from docs.making.figure.shape.anatomy import body_field
from docs.making.figure.shape.fields import BodyField
from docs.making.figure.shape.pieces import pieces
from docs.making.figure.shape.surface import SymmetricMesh, meshed
from docs.making.figure.shape.weights import influences
from motorcade.animation import Character, mannequin, read_character, skin, write_gltf

SHIPPED = files("motorcade.animation.mannequin") / "mannequin.glb"


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def field() -> BodyField:
    return body_field()


@pytest.fixture(scope="module")
def coarse(field: BodyField) -> SymmetricMesh:
    return meshed(field, 6_000)


def test_the_file_is_small_and_says_nothing_is_amiss(figure: Character) -> None:
    assert len(SHIPPED.read_bytes()) <= 1_000_000
    assert figure.notices == ()
    assert 6_000 <= len(figure.triangles) <= 12_000


def document_of(data: bytes) -> tuple[dict, bytes]:
    """The JSON of a .glb and its buffer, taken apart by hand."""
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def test_its_file_has_images_and_a_material_with_every_map_that_it_needs() -> None:
    document, buffer = document_of(SHIPPED.read_bytes())
    (material,) = document["materials"]
    surface = material["pbrMetallicRoughness"]
    assert {"baseColorTexture", "metallicRoughnessTexture"} <= surface.keys()
    assert {"normalTexture", "occlusionTexture"} <= material.keys()
    sizes = []
    for image in document["images"]:
        view = document["bufferViews"][image["bufferView"]]
        data = buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        sizes.append(Image.open(io.BytesIO(data)).size)
    assert sizes == [(1024, 1024), (512, 512), (1024, 1024)]


@pytest.mark.slow
def test_the_generator_makes_the_file_that_ships(figure: Character, tmp_path: Path) -> None:
    """To the last bit with one set of libraries; others may round and pack images otherwise."""
    write_gltf(tmp_path / "anew.glb", made_anew())
    again = read_character(tmp_path / "anew.glb")
    assert len(again.vertices) == len(figure.vertices)
    for name in ("vertices", "normals", "weights"):
        apart = np.abs(getattr(again, name) - getattr(figure, name))
        assert np.quantile(apart, 0.999) < 1e-5, name
    np.testing.assert_array_equal(again.triangles, figure.triangles)
    for clip, other in zip(again.clips, figure.clips, strict=True):
        np.testing.assert_allclose(
            clip.at(0.3).as_matrix(), other.at(0.3).as_matrix(), atol=1e-5, err_msg=clip.name
        )
    assert again.appearance is not None
    assert figure.appearance is not None
    np.testing.assert_allclose(
        again.appearance.coordinates, figure.appearance.coordinates, atol=1e-5
    )
    pairs = (one.appearance.parts[0].material.maps for one in (again, figure))
    for first, second in zip(*(maps.values() for maps in pairs), strict=True):
        apart = np.abs(first.pixels.astype(int) - second.pixels.astype(int))
        assert apart.mean() < 0.5


def test_it_stands_on_the_ground_at_the_asked_height_and_faces_x(figure: Character) -> None:
    small = mannequin(0.25)
    assert small.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    assert small.height_m == pytest.approx(0.25, abs=1e-9)
    world = small.skeleton.rest_world.translation_m
    toes, heel = small.skeleton.index("left_toes"), small.skeleton.index("left_foot")
    assert world[toes, 0] > world[heel, 0]
    assert world[toes, 1] > 0.0
    # soles lie flat: what is lowest spans most of a shoe
    sole = figure.vertices[(figure.vertices[:, 2] < 0.006) & (figure.vertices[:, 1] > 0.0)]
    assert np.ptp(sole[:, 0]) > 0.2
    assert np.ptp(sole[:, 1]) > 0.08


def test_it_has_the_joints_of_a_body_with_fingers(figure: Character) -> None:
    names = figure.skeleton.names
    assert names == figure_skeleton().names
    wanted = {
        f"{side}_{finger}_{k}"
        for side in ("left", "right")
        for finger in ("thumb", "index", "middle", "little")
        for k in (1, 2, 3)
    }
    assert wanted | {"hips", "spine", "chest", "neck", "head", "left_upper_arm"} <= set(names)


@pytest.mark.parametrize("height_m", [0.0, -1.0, np.nan, np.inf])
def test_a_height_that_is_not_positive_is_refused(height_m: float) -> None:
    with pytest.raises(ValueError, match="height_m"):
        mannequin(height_m)


def test_every_height_is_the_same_figure() -> None:
    one, two = mannequin(1.0), mannequin(2.0)
    np.testing.assert_allclose(2.0 * one.vertices, two.vertices, atol=1e-12)
    np.testing.assert_allclose(
        2.0 * one.shaped([1.0, 0.5]).vertices, two.shaped([1.0, 0.5]).vertices, atol=1e-12
    )
    for name in ("walk", "idle"):
        np.testing.assert_allclose(
            2.0 * one.clip(name).at(0.3).translation_m,
            two.clip(name).at(0.3).translation_m,
            atol=1e-12,
        )


def test_normals_point_outwards(figure: Character) -> None:
    corners = figure.vertices[figure.triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    agree = np.sum(face * figure.normals[figure.triangles].sum(axis=1), axis=1)
    area = np.linalg.norm(face, axis=1)
    assert area[agree > 0.0].sum() / area.sum() > 0.998


def test_left_and_right_mirror_each_other(figure: Character) -> None:
    """Apart from the scarf, each vertex has its like on the other side."""
    from scipy.spatial import cKDTree

    flip = np.array([1.0, -1.0, 1.0])
    apart = cKDTree(figure.vertices).query(figure.vertices * flip)[0]
    assert np.mean(apart < 1e-5) > 0.9
    away = np.linalg.norm(figure.vertices[apart >= 1e-5] - [0.03, 0.0, 1.2], axis=1)
    assert away.max() < 0.23


def test_every_joint_carries_skin_that_lies_around_it(figure: Character) -> None:
    dense = dense_weights(figure.joints, figure.weights, len(figure.skeleton))
    held = dense.max(axis=0)
    assert held.min() > 0.2, figure.skeleton.names[int(np.argmin(held))]
    world = figure.skeleton.rest_world.translation_m
    for joint in range(len(figure.skeleton)):
        own = dense[:, joint] > 0.2
        away = np.linalg.norm(figure.vertices[own] - world[joint], axis=1).max()
        assert away < 0.56, figure.skeleton.names[joint]


def dense_weights(joints: np.ndarray, weights: np.ndarray, count: int) -> np.ndarray:
    made = np.zeros((len(joints), count))
    for k in range(4):
        np.add.at(made, (np.arange(len(joints)), joints[:, k]), weights[:, k])
    return made


def test_weights_change_smoothly_along_the_skin(figure: Character) -> None:
    dense = dense_weights(figure.joints, figure.weights, len(figure.skeleton))
    edges = np.unique(np.sort(figure.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    change = np.abs(dense[edges[:, 0]] - dense[edges[:, 1]]).max(axis=1)
    # the steepest are finger joints, where a triangle is half as long as a bone
    assert change.max() < 0.75
    assert np.quantile(change, 0.9) < 0.15


def test_its_face_moves_as_one_with_its_head(figure: Character) -> None:
    """Nothing that sits on the face slides on it: both are the head's alone."""
    dense = dense_weights(figure.joints, figure.weights, len(figure.skeleton))
    face = (figure.vertices[:, 2] > 1.34) & (np.abs(figure.vertices[:, 1]) < 0.26)
    np.testing.assert_allclose(dense[face, figure.skeleton.index("head")], 1.0, atol=3e-3)


def test_a_blink_closes_the_eyes_and_a_smile_widens_the_mouth(figure: Character) -> None:
    blink, smile = figure.morphs
    assert (blink.name, smile.name) == ("blink", "smile")
    open_m = np.ptp(figure.vertices[blink.rows, 2])
    assert np.ptp(figure.shaped([1.0, 0.0]).vertices[blink.rows, 2]) < 0.25 * open_m
    mouth = np.setdiff1d(smile.rows, blink.rows)
    mouth = mouth[figure.vertices[mouth, 2] < 1.42]
    wide_m = np.ptp(figure.vertices[mouth, 1])
    assert np.ptp(figure.shaped([0.0, 1.0]).vertices[mouth, 1]) > 1.2 * wide_m


def test_it_blinks_as_it_stands_and_smiles_as_it_waves(figure: Character) -> None:
    times = np.linspace(0.0, 7.2, 721)
    blinking = figure.clip("idle").morph_weights(times)
    assert blinking is not None
    shut = blinking[:, 0] > 0.5
    assert 2 <= np.count_nonzero(np.diff(shut.astype(int)) == 1) <= 4
    assert shut.mean() < 0.1
    waving = figure.clip("wave").morph_weights([0.0, 1.8, 3.6])
    assert waving is not None
    np.testing.assert_allclose(waving[:, 1], [0.0, 1.0, 0.0], atol=1e-6)


def test_no_joint_collapses_where_it_bends_far(figure: Character) -> None:
    """A knee bent by 100° and an elbow by 120° keep four fifths of the skin's width there."""
    from docs.making.gallery import bent

    for joint, turn in (("left_calf", (0.0, 1.75, 0.0)), ("left_forearm", (0.0, -2.1, 0.0))):
        number = figure.skeleton.index(joint)
        pose = bent(figure, joint, turn)
        rest = figure.skeleton.rest_world.translation_m[number]
        near = np.linalg.norm(figure.vertices - rest, axis=1) < 0.11
        place = figure.skeleton.world(pose).translation_m[number]
        before = np.linalg.norm(figure.vertices[near] - rest, axis=1)
        after = np.linalg.norm(skin(figure, pose, "motor")[0][near] - place, axis=1)
        assert np.min(after / before) > 0.5, joint
        assert np.median(after / before) > 0.9, joint


def edges_of(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2) of a mesh, smaller number first, and how often each occurs."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, times = np.unique(edges, axis=0, return_counts=True)
    return unique, times


def test_the_body_is_one_closed_skin_on_the_zero_of_its_field(
    field: BodyField, coarse: SymmetricMesh
) -> None:
    assert len(coarse.vertices) - len(edges_of(coarse.triangles)[0]) + len(coarse.triangles) == 2
    assert np.all(edges_of(coarse.triangles)[1] == 2)
    assert np.abs(field.distance_m(coarse.vertices, 0.01)).max() < 2e-3
    joints, weights = influences(coarse, figure_skeleton())
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert joints.max() < len(figure_skeleton())


def test_pieces_are_closed_and_their_normals_point_outwards(field: BodyField) -> None:
    for piece in pieces(field):
        a, b, c = np.moveaxis(piece.vertices[piece.triangles], 1, 0)
        face = np.cross(b - a, c - a)
        assert np.sum(a * face) > 0.0, piece.name  # the volume that it encloses
        agree = np.sum(face * piece.normals[piece.triangles].sum(axis=1), axis=1)
        assert np.mean(agree > 0.0) > 0.99, piece.name


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
