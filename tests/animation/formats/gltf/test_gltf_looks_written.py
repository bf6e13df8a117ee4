"""What a written glTF file keeps of a character's looks: all of it."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, read_character, write_gltf
from motorcade.animation.appearance import Material, TextureMap
from tests.animation.formats.gltf.test_gltf_materials import dressed
from tests.animation.formats.gltf.test_gltf_morphs import morphing
from tests.animation.formats.samples import Write

EVERYTHING: dict[str, object] = {
    "name": "coat",
    "pbrMetallicRoughness": {
        "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
        "baseColorTexture": {
            "index": 1,
            "extensions": {
                "KHR_texture_transform": {
                    "offset": [0.25, 0.5],
                    "rotation": 2.5,
                    "scale": [2.0, -3.0],
                    "texCoord": 1,
                }
            },
        },
        "metallicFactor": 0.25,
    },
    "normalTexture": {"index": 0, "scale": 0.5},
    "occlusionTexture": {"index": 0, "strength": 0.8},
    "emissiveFactor": [0.0, 0.5, 1.0],
    "emissiveTexture": {"index": 0},
    "alphaMode": "MASK",
    "alphaCutoff": 0.3,
    "doubleSided": True,
    "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 4.0},
        "KHR_materials_unlit": {},
    },
}


def alike(one: object, other: object) -> None:
    """Every field of materials and maps."""
    assert type(one) is type(other)
    for name, value in vars(one).items():
        again = vars(other)[name]
        if isinstance(value, TextureMap):
            alike(value, again)
        elif name in ("pixels", "transform", "base_color", "emission"):
            np.testing.assert_allclose(again, value, atol=1e-12)
        else:
            assert again == value, name


def again(character: Character, folder: Path) -> Character:
    write_gltf(folder / "again.glb", character)
    return read_character(folder / "again.glb")


def test_materials_come_back_as_they_were(write: Write, tmp_path: Path) -> None:
    read = read_character(write("dressed.glb", dressed(EVERYTHING, sets=2).glb()))
    found = again(read, tmp_path)
    assert found.appearance is not None
    assert read.appearance is not None
    (part,), (given,) = found.appearance.parts, read.appearance.parts
    assert (part.first, part.stop, part.flat) == (given.first, given.stop, given.flat)
    assert isinstance(part.material, Material)
    alike(given.material, part.material)
    np.testing.assert_array_equal(found.appearance.coordinates, read.appearance.coordinates)
    np.testing.assert_array_equal(found.triangles, read.triangles)


def test_morph_targets_and_their_clips_come_back(write: Write, tmp_path: Path) -> None:
    read = read_character(write("morphing.glb", morphing().glb()))
    found = again(read, tmp_path)
    assert [(one.name, one.weight) for one in found.morphs] == [("up", 0.0), ("x", 0.25)]
    times = np.linspace(0.0, 2.0, 9)
    weights, given = (one.clips[0].morph_weights(times) for one in (found, read))
    assert weights is not None
    np.testing.assert_allclose(weights, given, atol=1e-6)
    for row in weights[::4]:
        np.testing.assert_allclose(found.shaped(row).vertices, read.shaped(row).vertices, atol=1e-6)


@pytest.mark.parametrize("tint", [3, 4])
def test_vertex_colours_keep_their_alpha(write: Write, tmp_path: Path, tint: int) -> None:
    made = dressed({"alphaMode": "BLEND"})
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["COLOR_0"] = made.add(np.linspace(0.0, 1.0, 12 * tint).reshape(12, tint))
    read = read_character(write("tinted.glb", made.glb()))
    found = again(read, tmp_path)
    assert found.appearance is not None
    assert read.appearance is not None
    assert found.appearance.colors is not None
    np.testing.assert_allclose(found.appearance.colors, read.appearance.colors, atol=1e-7)
    assert found.appearance.colors[:, 3].min() == (
        1.0 if tint == 3 else read.appearance.colors[0, 3]
    )
