"""Written characters come back as they were, here and in other programs."""

import json
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, Clip, Skeleton, mannequin
from motorcade.animation.formats import (
    CameraPath,
    CharacterOnPath,
    FormatError,
    read_character,
    write_cast_gltf,
    write_gltf,
)
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from tests.animation.formats import samples
from tests.animation.formats.samples import Write
from tests.animation.formats.witness import Witness

NEAR_M = 1e-5


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def written(figure: Character, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "figure.glb"
    write_gltf(path, figure)
    return path


def places(character: Character, clip: Clip, times: np.ndarray) -> np.ndarray:
    return character.skeleton.world(clip.at(times)).translation_m


def test_a_character_comes_back_as_it_was(figure: Character, written: Path) -> None:
    found = read_character(written)
    assert found.skeleton.names == figure.skeleton.names
    assert found.skeleton.parents.tolist() == figure.skeleton.parents.tolist()
    np.testing.assert_array_equal(found.triangles, figure.triangles)
    for name in ("vertices", "normals", "colors", "weights"):
        np.testing.assert_allclose(getattr(found, name), getattr(figure, name), atol=1e-6)
    np.testing.assert_allclose(
        found.skeleton.rest_world.as_matrix(), figure.skeleton.rest_world.as_matrix(), atol=1e-6
    )
    assert found.notices == ()


@pytest.mark.parametrize("name", ["idle", "walk"])
def test_clips_come_back_also_between_their_keys(
    figure: Character, written: Path, name: str
) -> None:
    found = read_character(written)
    clip, back = figure.clip(name), found.clip(name)
    assert back.looped == clip.looped
    times = np.linspace(-0.3, 2.5 * clip.duration_s, 997)
    np.testing.assert_allclose(places(found, back, times), places(figure, clip, times), atol=NEAR_M)


def test_others_see_the_same_motion_by_plain_interpolation(
    figure: Character, written: Path
) -> None:
    """A program that turns and moves joints apart between keys stays on our screws."""
    witness = Witness(written)
    clip = figure.clip("walk")
    number = [one["name"] for one in witness.document["animations"]].index("walk")
    for time_s in np.linspace(0.0, clip.duration_s, 23)[:-1]:
        world = witness.world(float(time_s), number)
        found = np.array([world[name][:3, 3] for name in figure.skeleton.names])
        wanted = places(figure, clip, np.array(time_s))
        np.testing.assert_allclose(found[:, [2, 0, 1]], wanted, atol=NEAR_M)


def test_similarities_come_back(write: Write, tmp_path: Path) -> None:
    character = read_character(write("rich.glb", samples.rich_gltf().glb()), unit_m=100.0)
    write_gltf(tmp_path / "back.glb", character)
    found = read_character(tmp_path / "back.glb")
    clip, back = character.clip("growing"), found.clip("growing")
    assert isinstance(back.poses, Similarity)
    times = np.linspace(0.0, 1.0, 31)
    first, second = character.skeleton.world(clip.at(times)), found.skeleton.world(back.at(times))
    np.testing.assert_allclose(second.as_matrix(), first.as_matrix(), atol=1e-5)


def test_a_path_carries_the_character_and_the_camera(
    figure: Character, tmp_path: Path, rng: np.random.Generator
) -> None:
    stamps = 1_000_000_000 + np.arange(40) * 100_000_000
    steps = Motor.exp(0.05 * rng.standard_normal((40, 6)))
    world_T_character = Trajectory(stamps, steps, "world", "character")
    back = Motor.from_rotor_translation(Rotor.identity((40,)), rng.standard_normal((40, 3)))
    camera = CameraPath(Trajectory(stamps, back), 0.8, 4.0 / 3.0)
    path = tmp_path / "path.glb"
    member = CharacterOnPath("figure", figure, figure.clip("walk"), world_T_character)
    write_cast_gltf(path, [member], camera=camera)
    witness = Witness(path)
    assert witness.span()[1] >= 3.9
    axes = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    period = figure.clip("walk").duration_s
    for number in (0, 7, 26, 39):
        time_s = 0.1 * number
        world = witness.world(time_s)
        local = figure.skeleton.world(figure.clip("walk").at(time_s % period))
        wanted = (steps[number] @ local).translation_m
        found = np.array([(axes @ world[name])[:3, 3] for name in figure.skeleton.names])
        np.testing.assert_allclose(found, wanted, atol=NEAR_M)
        view = axes @ world["camera"]
        np.testing.assert_allclose(view[:3, 3], back[number].translation_m, atol=NEAR_M)
        np.testing.assert_allclose(view[:3, 2], [0, 0, -1], atol=1e-6)  # looks along world +z
        np.testing.assert_allclose(view[:3, 1], [0, -1, 0], atol=1e-6)


def test_points_lie_where_they_are_in_the_world_and_a_still_figure_is_carried(
    figure: Character, tmp_path: Path, rng: np.random.Generator
) -> None:
    """A clip of the rest pose alone lasts all along the path."""
    stamps = np.array([0, 500_000_000, 1_000_000_000])
    steps = Motor.from_twist(0.3 * rng.standard_normal((3, 6)))
    points = rng.standard_normal((5, 3))
    path = tmp_path / "points.glb"
    way = Trajectory(stamps, steps, "world", "character")
    rest = Clip("rest", np.zeros(1), figure.skeleton.rest.reshape(1, -1))
    write_cast_gltf(path, [CharacterOnPath("figure", figure, rest, way)], points_m=points)
    witness = Witness(path)
    axes = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    world = witness.world(0.5)
    cloud = witness.document["meshes"][1]["primitives"][0]
    assert cloud["mode"] == 0
    stored = witness.accessor(cloud["attributes"]["POSITION"])
    placed = np.concatenate([stored, np.ones((5, 1))], axis=1) @ (axes @ world["map"]).T
    np.testing.assert_allclose(placed[:, :3], points, atol=1e-6)
    found = np.array([(axes @ world[name])[:3, 3] for name in figure.skeleton.names])
    wanted = (steps[1] @ figure.skeleton.rest_world).translation_m
    np.testing.assert_allclose(found, wanted, atol=NEAR_M)


def test_a_path_may_change_the_size_of_what_it_carries(figure: Character, tmp_path: Path) -> None:
    """And a clip that is no loop is played once."""
    stamps = np.array([0, 2_000_000_000])
    sizes = Similarity.from_motor_scale(Motor.identity((2,)), np.array([1.0, 4.0]))
    once = Clip("once", np.array([0.0, 0.1]), figure.clip("walk").at([0.0, 0.1]))
    path = tmp_path / "grown.glb"
    write_cast_gltf(path, [CharacterOnPath("figure", figure, once, Trajectory(stamps, sizes))])
    witness = Witness(path)
    for time_s, size in ((0.0, 1.0), (1.0, 2.0), (2.0, 4.0)):
        world = witness.world(time_s)
        block = world["path"][:3, :3]
        assert np.cbrt(np.linalg.det(block)) == pytest.approx(size, rel=1e-3)
    local = figure.skeleton.world(once.at(1.0)).translation_m
    world = witness.world(2.0)
    found = np.array([world[name][:3, 3] for name in figure.skeleton.names])[:, [2, 0, 1]]
    np.testing.assert_allclose(found, 4.0 * local, atol=1e-4)


def test_many_joints_are_numbered_by_two_bytes(tmp_path: Path) -> None:
    count = 300
    shift = np.zeros((count, 6))
    shift[1:, 5] = 0.01
    skeleton = Skeleton(
        tuple(f"joint {k}" for k in range(count)), np.arange(count) - 1, Motor.from_twist(shift)
    )
    weights, joints = np.zeros((count, 4)), np.zeros((count, 4), dtype=np.int64)
    weights[:, 0], joints[:, 0] = 1.0, np.arange(count)
    vertices = np.stack([np.arange(count) % 2, np.arange(count) % 3, np.arange(count)], axis=1)
    long = Character(
        skeleton,
        0.1 * vertices,
        np.tile([1.0, 0, 0], (count, 1)),
        np.array([[0, 1, 2]]),
        np.full((count, 3), 0.5),
        joints,
        weights,
    )
    write_gltf(tmp_path / "long.glb", long)
    found = read_character(tmp_path / "long.glb", unit_m=1.0)
    np.testing.assert_array_equal(found.joints, joints)


def test_the_file_states_what_the_format_asks_for(written: Path) -> None:
    data = written.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    witness = Witness(written)
    document = witness.document
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    assert {"min", "max"} <= document["accessors"][attributes["POSITION"]].keys()
    for animation in document["animations"]:
        for sampler in animation["samplers"]:
            assert {"min", "max"} <= document["accessors"][sampler["input"]].keys()
    for view in document["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
    weights = witness.accessor(attributes["WEIGHTS_0"])
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-6)


def test_trimesh_reads_the_same_surface(figure: Character, written: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.load(written, process=False)
    mesh = next(iter(scene.geometry.values()))
    np.testing.assert_allclose(np.asarray(mesh.vertices), figure.vertices, atol=1e-6)
    assert len(mesh.faces) == len(figure.triangles)


@pytest.mark.skipif(shutil.which("assimp") is None, reason="the program assimp is not installed")
def test_assimp_reads_the_same_skeleton_and_clips(
    figure: Character, written: Path, tmp_path: Path
) -> None:
    back = tmp_path / "back.glb"
    subprocess.run(["assimp", "export", str(written), str(back)], check=True, capture_output=True)
    witness = Witness(back)
    world = witness.world()
    found = np.array([world[name][:3, 3] for name in figure.skeleton.names])
    np.testing.assert_allclose(
        found[:, [2, 0, 1]], figure.skeleton.rest_world.translation_m, atol=NEAR_M
    )
    found_clips = [one["name"] for one in witness.document["animations"]]
    assert found_clips == [clip.name for clip in figure.clips]


def test_wrong_requests_are_refused(figure: Character, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"ends in \.glb"):
        write_gltf(tmp_path / "figure.obj", figure)
    with pytest.raises(ValueError, match="different names"):
        write_gltf(tmp_path / "figure.glb", figure, [figure.clip("walk")] * 2)
    other = Clip("other", np.zeros(1), Motor.identity((1, 3)))
    with pytest.raises(ValueError, match=f"poses of {len(figure.skeleton)} joints, got 3"):
        write_gltf(tmp_path / "figure.glb", figure, [other])
    still = Trajectory(np.array([0]), Motor.identity((1,)))
    with pytest.raises(ValueError, match="between 0 and pi"):
        CameraPath(still, 4.0, 1.0)
    for aspect in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"CameraPath\.aspect: expected a number above 0"):
            CameraPath(still, 0.8, aspect)
    points = np.zeros((4, 3))
    member = CharacterOnPath("figure", figure, figure.clip("walk"), still)
    for wrong in (points[:0], points[:, :2], points[0], points * np.nan):
        with pytest.raises(ValueError, match=r"points_m\): expected finite points \(N, 3\)"):
            write_cast_gltf(tmp_path / "figure.glb", [member], points_m=wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_loop_whose_ends_differ_is_refused(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["animations"][0]["extras"] = {"looped": True}
    assert json.dumps(made.document)
    with pytest.raises(FormatError, match="said to repeat"):
        read_character(write("loop.glb", made.glb()))
