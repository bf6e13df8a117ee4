"""Casts in one file: every figure stands where its path says, here and in other programs."""

import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from motorcade.animation import mannequin, read_character, skin
from motorcade.animation.formats import CameraPath, CharacterOnPath, write_cast_gltf
from motorcade.ga import Motor, Similarity, Trajectory
from tests.animation.formats.gltf_vertices import GltfVertices
from tests.animation.formats.samples import Write, gltf_tower

SPAN_S = 3.0
TO_FILE = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""From z up to glTF's y up."""


def way(start: Motor, twist: np.ndarray, scale: float) -> Trajectory:
    """A screw from a pose on, of a figure of some size."""
    seconds = np.linspace(0.0, SPAN_S, 7)
    poses = start @ Motor.exp(seconds[:, None] * twist)
    stamps = 5_000_000_000 + np.round(1e9 * seconds).astype(np.int64)
    return Trajectory(stamps, Similarity.from_motor_scale(poses, np.float64(scale)))


@pytest.fixture
def cast(write: Write) -> list[CharacterOnPath]:
    """Two people, one of them small, and a tower that bends."""
    person, tower = mannequin(), read_character(write("tower.glb", gltf_tower().glb()))
    rng = np.random.default_rng(4)
    twists = 0.2 * rng.standard_normal((3, 6))
    starts = Motor.from_translation([[0.0, -2.0, 0.0], [1.0, 0.0, 0.3], [0.0, 2.0, 0.0]])
    return [
        CharacterOnPath("ann", person, person.clip("walk"), way(starts[0], twists[0], 1.0)),
        CharacterOnPath("ben", person, person.clip("wave"), way(starts[1], twists[1], 0.3)),
        CharacterOnPath("mast", tower, tower.clips[0], way(starts[2], twists[2], 1.5)),
    ]


def standing(cast: list[CharacterOnPath], time_s: float) -> np.ndarray:
    """Vertices of all at a time after the first stamp, in the file's axes."""
    made = []
    for one in cast:
        path = one.world_T_character
        shaped = one.character.shaped(one.clip.morph_weights(time_s))
        vertices, _ = skin(shaped, one.clip.at(time_s), "linear")
        at = path.at(path.time_ns[0] + round(1e9 * time_s)).apply(vertices)
        made.append(at[np.unique(one.character.triangles)])
    return np.concatenate(made) @ TO_FILE.T


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """The farthest that a point of either lies from the nearest of the other."""
    return float(max(cKDTree(one).query(other)[0].max(), cKDTree(other).query(one)[0].max()))


def test_everybody_stands_where_their_paths_say(
    cast: list[CharacterOnPath], tmp_path: Path
) -> None:
    write_cast_gltf(tmp_path / "cast.glb", cast)
    found = GltfVertices(tmp_path / "cast.glb")
    assert len(found.animations()) == 1
    for time_s in (0.0, 0.31, 1.0, 2.4, SPAN_S):
        # the file's numbers are of 32 bits
        assert apart(found.at(time_s), standing(cast, time_s)) < 3e-5


def test_assimp_reads_everybody_at_the_same_places(
    cast: list[CharacterOnPath], tmp_path: Path
) -> None:
    if shutil.which("assimp") is None:
        pytest.skip("assimp is not installed")
    # assimp writes no weights of morph targets
    cast = [replace(one, clip=replace(one.clip, morphs=None)) for one in cast]
    write_cast_gltf(tmp_path / "cast.glb", cast)
    command = ["assimp", "export", str(tmp_path / "cast.glb"), str(tmp_path / "again.glb")]
    subprocess.run(command, check=True, capture_output=True)
    found = GltfVertices(tmp_path / "again.glb")
    for time_s in (0.0, 1.3, 2.2):
        assert apart(found.at(time_s), standing(cast, time_s)) < 1e-3


def test_the_camera_comes_along(cast: list[CharacterOnPath], tmp_path: Path) -> None:
    camera = CameraPath(cast[0].world_T_character, 0.8, 1.5)
    points = np.random.default_rng(2).standard_normal((20, 3))
    write_cast_gltf(tmp_path / "cast.glb", cast, camera=camera, points_m=points)
    nodes = GltfVertices(tmp_path / "cast.glb").document["nodes"]
    names = [one["name"] for one in nodes]
    assert len(set(names)) == len(names)
    assert {"ann path", "ben mesh", "mast base", "camera", "map"} <= set(names)


def test_one_alone_keeps_the_names_of_its_joints(
    cast: list[CharacterOnPath], tmp_path: Path
) -> None:
    write_cast_gltf(tmp_path / "ann.glb", cast[:1])
    assert read_character(tmp_path / "ann.glb").skeleton.names == cast[0].character.skeleton.names


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda cast: [], "one or more names, each once, got"),
        (lambda cast: [*cast, cast[0]], "each once, got .'ann', 'ben', 'mast', 'ann'"),
        (
            lambda cast: [
                cast[0],
                CharacterOnPath(
                    "late",
                    cast[1].character,
                    cast[1].clip,
                    Trajectory(cast[1].world_T_character.time_ns + 7, Motor.identity((7,))),
                ),
            ],
            "paths from one stamp on, got .5000000000, 5000000007",
        ),
    ],
)
def test_what_is_no_cast_is_refused(
    cast: list[CharacterOnPath],
    tmp_path: Path,
    change: Callable[[list[CharacterOnPath]], list[CharacterOnPath]],
    told: str,
) -> None:
    with pytest.raises(ValueError, match=told):
        write_cast_gltf(tmp_path / "cast.glb", change(cast))
    with pytest.raises(ValueError, match=r"ends in \.glb, got 'cast\.txt'"):
        write_cast_gltf(tmp_path / "cast.txt", cast)
    with pytest.raises(ValueError, match="expected a name, got none"):
        CharacterOnPath("", cast[0].character, cast[0].clip, cast[0].world_T_character)
    with pytest.raises(ValueError, match=r"CharacterOnPath.clip: expected poses of 2 joints"):
        CharacterOnPath("x", cast[2].character, cast[0].clip, cast[0].world_T_character)
