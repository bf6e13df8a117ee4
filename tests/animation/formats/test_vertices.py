"""Vertices lie where the raw files say: at rest, and at 20 times of every clip."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import read_character, skin
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.gltf_vertices import GltfVertices
from tests.animation.formats.samples import Write, rich_gltf

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
