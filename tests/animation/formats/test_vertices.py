"""Vertices lie where the raw files say: at rest, and at 20 times of every clip."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import read_character, skin
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.gltf_vertices import GltfVertices
from tests.animation.formats.samples import Gltf, Write, animate, rich_gltf, tower

SHARE = 1e-5
"""How far a vertex may lie from its place, as a share of the largest side of what is shown."""
TIMES = 20

STILL = (
    "AlphaBlendModeTest/AlphaBlendModeTest.glb",
    "BoxTextured/BoxTextured.glb",
    "Boxes/Boxes.glb",
    "Duck/Duck.glb",
    "FlightHelmet/FlightHelmet.gltf",
    "MirroredDuck/MirroredDuck.glb",
    "NormalTangentTest/NormalTangentTest.glb",
    "SimpleSparseAccessor/SimpleSparseAccessor.gltf",
    "TextureSettingsTest/TextureSettingsTest.glb",
    "TextureTransformTest/TextureTransformTest.gltf",
    "VertexColorTest/VertexColorTest.glb",
)
MOVING = (
    "AnimatedMorphCube/AnimatedMorphCube.glb",
    "CesiumMan/CesiumMan.glb",
    "CesiumMilkTruck/CesiumMilkTruck.glb",
    "Fox/Fox.glb",
    "InterpolationTest/InterpolationTest.gltf",
    "MorphStressTest/MorphStressTest.gltf",
)
RIGS = (
    "arnaud/arnaud_fbx.glb",
    "astroboy/astro_max_dae.glb",
    "astroboy/astro_maya_dae.glb",
    "kaykit/Knight.glb",
    "makehuman/mh_male_ge53_135k_dressed.glb",
    "makehuman/mh_male_ge53_27k.glb",
    "md5/Bob_md5mesh.glb",
    "sinbad/sinbad.glb",
)
UNEVEN = "zoo/mannequiny-0.3.0.glb"
"""Its clips stretch joints along one axis, which a similarity cannot: 6 % in `air_jump`."""


def worst(path: Path, raw_path: Path | None = None) -> tuple[float, float]:
    """Largest distances, as shares, at rest and in all clips; the raw file may be another."""
    found, raw = read_character(path), GltfVertices(raw_path or path)
    assert found.found_pose is not None
    back = found.character_T_file.inverse()
    resting = raw.at()
    size = float(np.ptp(resting, axis=0).max())
    vertices, _ = skin(found.shaped(), found.found_pose, "linear")
    at_rest = np.abs(back.apply(vertices) - resting).max() / size
    animations, moving = raw.animations(), 0.0
    assert len(animations) == len(found.clips)
    for (number, keys), clip in zip(animations, found.clips, strict=True):
        for time_s in np.linspace(keys[0], keys[-1], TIMES).tolist():
            shaped = found.shaped(clip.morph_weights(time_s))
            vertices, _ = skin(shaped, clip.at(time_s), "linear")
            off = np.abs(back.apply(vertices) - raw.at(time_s, number)).max() / size
            moving = max(moving, float(off))
    return float(at_rest), moving


def uneven_gltf(key: str, values: object) -> Gltf:
    """A tower that hangs, without a skin, on a node of uneven scale under one that a clip turns."""
    made = Gltf()
    vertices, triangles, _ = tower()
    part = {
        "attributes": {"POSITION": made.add(vertices)},
        "indices": made.add(triangles.reshape(-1), "uint32"),
    }
    made.document |= {
        "meshes": [{"primitives": [part]}],
        "nodes": [
            {"name": "base", "children": [1], "scale": [1.0, 2.0, 1.0]},
            {"name": "tower", "mesh": 0, "rotation": [0.0, 0.0, 0.3826834, 0.9238795]},
        ],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    animate(made, "move", made.add([0.0, 1.0]), {(0, key): made.add(values)})
    return made


def test_parts_without_a_skin_that_only_turn_lose_no_shear(write: Write) -> None:
    made = uneven_gltf("rotation", [[0.0, 0.0, 0.0, 1.0], [0.0, 0.6, 0.0, 0.8]])
    path = write("turned.glb", made.glb())
    assert max(worst(path)) < SHARE
    assert not any("nearest uniform scales" in one for one in read_character(path).notices)


def test_parts_without_a_skin_that_are_stretched_are_as_far_off_as_is_told(write: Write) -> None:
    made = uneven_gltf("scale", [[1.0, 2.0, 1.0], [2.0, 1.0, 1.0]])
    path = write("stretched.glb", made.glb())
    at_rest, moving = worst(path)
    assert at_rest < 1e-6
    (told,) = [one for one in read_character(path).notices if "nearest uniform scales" in one]
    share = 0.01 * float(told.split("mm, ")[1].split(" %")[0])
    # Shares of the largest side and of the height, along an axis and in space, are not quite one.
    assert moving > 0.05
    assert 0.8 * moving < share < 2.0 * moving


@pytest.fixture(scope="session")
def looks(data_dir: Path) -> Path:
    """Folder of the models."""
    folder = data_dir / "looks" / "models"
    if not folder.is_dir():
        pytest.skip("no looks here")
    return folder


@pytest.mark.parametrize("name", ["dressed", "rich"])
def test_small_files_with_everything_stand_and_move_as_they_say(write: Write, name: str) -> None:
    made = rich_gltf() if name == "rich" else dressed_gltf((encoded("PNG"),))
    at_rest, moving = worst(write("small.glb", made.glb()))
    assert at_rest < 1e-7
    assert moving < SHARE


@pytest.mark.slow
@pytest.mark.parametrize("name", [*STILL, *MOVING])
def test_models_stand_and_move_as_their_files_say(looks: Path, name: str) -> None:
    at_rest, moving = worst(looks / name)
    assert at_rest < 1e-6
    assert moving < SHARE


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
def test_rigs_stand_and_move_as_their_files_say(rigs: Path, name: str) -> None:
    at_rest, moving = worst(rigs / name)
    assert at_rest < 1e-6
    assert moving < SHARE


@pytest.mark.slow
def test_rigid_parts_of_fbx_stand_and_move_as_another_program_writes_them(
    rigs: Path, tmp_path: Path
) -> None:
    if shutil.which("assimp") is None:
        pytest.skip("assimp is not installed")
    given, made = rigs / "zoo" / "robot.fbx", tmp_path / "robot.glb"
    subprocess.run(["assimp", "export", str(given), str(made)], check=True, capture_output=True)
    at_rest, moving = worst(given, made)
    assert at_rest < 1e-6
    assert moving < SHARE


@pytest.mark.slow
def test_joints_that_stretch_along_one_axis_are_as_far_off_as_is_told(rigs: Path) -> None:
    at_rest, moving = worst(rigs / UNEVEN)
    assert at_rest < 1e-4
    assert moving < 0.08
    notices = read_character(rigs / UNEVEN).notices
    assert any("nearest uniform scales stand in" in one for one in notices)
