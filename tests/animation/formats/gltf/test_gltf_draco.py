"""Meshes compressed by Draco are those that were compressed; what is wrong with them is refused."""

import struct
from importlib import util
from typing import Any

import numpy as np
import pytest

from motorcade.animation import Character, read_character
from motorcade.animation.formats import FormatError
from motorcade.animation.formats.gltf import compression
from tests.animation.formats import samples
from tests.animation.formats.packed import DRACO, draco_tower
from tests.animation.formats.samples import Gltf, Write

pytest.importorskip("DracoPy")


def corners(character: Character) -> np.ndarray:
    """Corners of all triangles with their normals and weights, in an order that is the mesh's."""
    weights = np.zeros((len(character.vertices), len(character.skeleton)))
    rows = np.arange(len(weights))[:, None]
    np.add.at(weights, (rows, character.joints), character.weights)
    every = np.concatenate([character.vertices, character.normals, weights], axis=1)
    found = every[character.triangles]
    first = np.lexsort(np.round(found[..., :3], 4).transpose(2, 0, 1))[:, 0]
    turned = [np.roll(one, -first[k], axis=0) for k, one in enumerate(found)]
    return np.array(sorted(np.round(turned, 4).tolist()))


@pytest.mark.parametrize("edgebreaker", [False, True])
def test_compressed_towers_are_plain_ones(write: Write, edgebreaker: bool) -> None:
    plain = samples.gltf_tower()
    (part,) = plain.document["meshes"][0]["primitives"]
    part["attributes"]["NORMAL"] = plain.add(np.tile([0.0, 0.0, 1.0], (12, 1)))
    wanted = read_character(write("plain.glb", plain.glb()))
    packed = draco_tower(edgebreaker=edgebreaker)
    found = read_character(write("packed.glb", packed.glb()))
    assert found.notices == wanted.notices
    np.testing.assert_allclose(corners(found), corners(wanted), atol=2e-4)
    np.testing.assert_array_equal(
        found.clips[0].poses.coefficients, wanted.clips[0].poses.coefficients
    )


def test_plain_data_is_taken_where_it_comes_along(write: Write) -> None:
    made = samples.gltf_tower()
    (part,) = made.document["meshes"][0]["primitives"]
    part["extensions"] = {DRACO: {"bufferView": 0, "attributes": {}}}
    made.document["extensionsUsed"] = [DRACO]
    assert len(read_character(write("both.glb", made.glb())).vertices) == 12


def test_primitives_may_share_a_compressed_mesh(write: Write) -> None:
    made = draco_tower()
    parts = made.document["meshes"][0]["primitives"]
    parts.append(dict(parts[0]))
    assert len(read_character(write("twice.glb", made.glb())).triangles) == 2 * 20


def changed(made: Gltf, path: tuple[Any, ...], value: object) -> bytes:
    here: Any = made.document
    for step in path[:-1]:
        here = here[step]
    here[path[-1]] = value
    return made.glb()


PART = ("meshes", 0, "primitives", 0)


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ((*PART, "mode"), 5, r"mode: expected triangles"),
        ((*PART, "extensions", DRACO, "bufferView"), 0, "expected a mesh of Draco 2"),
        ((*PART, "extensions", DRACO, "bufferView"), 99, "a whole number from 0"),
        ((*PART, "extensions", DRACO, "attributes", "POSITION"), 55, "an attribute of the mesh"),
        ((*PART, "extensions", DRACO, "attributes", "HAT"), 0, "those of its primitive"),
        ((*PART, "attributes", "WEIGHTS_0"), 0, r"as accessors\[0\]"),
        (("accessors", 1, "type"), "MAT2", r"MAT2, as accessors\[1\], got 12 x 3 numbers"),
    ],
)
def test_what_does_not_fit_is_refused(
    write: Write, path: tuple[Any, ...], value: object, told: str
) -> None:
    made = draco_tower(edgebreaker=False)
    with pytest.raises(FormatError, match=told):
        read_character(write("odd.glb", changed(made, path, value)))


def test_counts_are_those_that_were_encoded(write: Write) -> None:
    """Khronos' samples count the vertices before their encoder merged those that are alike."""
    made = draco_tower(edgebreaker=False)
    for accessor in made.document["accessors"]:
        if "bufferView" not in accessor:
            accessor["count"] += 5
    wanted = read_character(write("exact.glb", draco_tower(edgebreaker=False).glb()))
    read = read_character(write("more.glb", made.glb()))
    np.testing.assert_array_equal(read.vertices, wanted.vertices)
    np.testing.assert_array_equal(read.triangles, wanted.triangles)


def test_whole_numbers_must_fit_what_holds_them(write: Write) -> None:
    made = draco_tower(edgebreaker=False)
    (part,) = made.document["meshes"][0]["primitives"]
    made.document["accessors"][part["attributes"]["JOINTS_0"]] |= {"type": "VEC4"}
    weights = part["extensions"][DRACO]["attributes"]
    weights["JOINTS_0"] = weights["WEIGHTS_0"]
    with pytest.raises(FormatError, match="numbers of uint8"):
        read_character(write("half.glb", made.glb()))


def test_broken_meshes_end_in_an_error_of_one_line(write: Write) -> None:
    made = draco_tower()
    view = made.document["bufferViews"][-1]
    start, size = view["byteOffset"], view["byteLength"]
    made.data[start + 11 : start + size] = b"\xff" * (size - 11)
    with pytest.raises(FormatError, match="expected meshes that can be decoded, got") as told:
        read_character(write("broken.glb", made.glb()))
    assert "\n" not in str(told.value)


def bomb(points: int) -> bytes:
    """A mesh whose attribute of zeros is a thousand times as large as it."""
    import DracoPy

    side = int(np.sqrt(points))
    rows, columns = np.divmod(np.arange((side - 1) ** 2), side - 1)
    at = (rows * side + columns).astype(np.uint32)
    faces = np.stack([at, at + 1, at + side], axis=1)
    places = np.zeros((side * side, 3), np.float32)
    places[:, 0], places[:, 1] = np.divmod(np.arange(side * side), side)
    zeros = np.zeros((side * side, 250), np.uint8)
    made: bytes = DracoPy.encode(
        places, faces, quantization_bits=8, compression_level=10, generic_attributes={5: zeros}
    )
    return made


def test_meshes_that_unpack_to_too_much_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = bomb(40_000)
    assert len(data) < 100_000
    made = draco_tower()
    view = made.view(np.frombuffer(data, np.uint8))
    glb = changed(made, (*PART, "extensions", DRACO, "bufferView"), view)
    monkeypatch.setattr(compression, "MAX_VALUES", 1_000_000)
    with pytest.raises(FormatError, match="expected at most 1000000 numbers, got more"):
        read_character(write("bomb.glb", glb))
    monkeypatch.setattr(compression, "MAX_VALUES", 32 << 20)
    monkeypatch.setattr(compression, "MEMORY_LIMIT_BYTES", 150 << 20)
    with pytest.raises(FormatError, match="expected meshes that can be decoded"):
        read_character(write("bomb.glb", glb))


def test_clouds_of_points_are_refused(write: Write) -> None:
    made = draco_tower()
    view = made.document["bufferViews"][-1]
    struct.pack_into("B", made.data, view["byteOffset"] + 7, 0)
    with pytest.raises(FormatError, match="expected a mesh of Draco 2"):
        read_character(write("points.glb", made.glb()))


def test_what_brings_the_decoder_is_named(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compression, "find_spec", {"DracoPy": None}.get)
    assert util.find_spec("DracoPy") is not None
    path = write("tower.glb", draco_tower().glb())
    with pytest.raises(ModuleNotFoundError, match=r"DracoPy: pip install .motorcade\[pipeline\]"):
        read_character(path)
