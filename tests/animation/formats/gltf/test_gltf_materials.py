"""Materials of glTF files arrive whole: factors, maps, samplers, transforms, and what is named."""

import io

import numpy as np
import pytest
from PIL import Image

from motorcade.animation import read_character
from motorcade.animation.appearance import Material, TextureMap
from motorcade.animation.formats import FormatError
from tests.animation.formats.samples import Gltf, Write, tower


def dressed(material: dict[str, object], sets: int = 1) -> Gltf:
    """A tower with a material, and an image of 4 x 2 pixels whose alpha is 100."""
    made = Gltf()
    vertices, triangles, _ = tower()
    data = io.BytesIO()
    Image.new("RGBA", (4, 2), (250, 20, 0, 100)).save(data, "PNG")
    attributes = {"POSITION": made.add(vertices)}
    for which in range(sets):
        attributes[f"TEXCOORD_{which}"] = made.add(np.full((len(vertices), 2), float(which)))
    part = {
        "attributes": attributes,
        "indices": made.add(triangles.reshape(-1), "uint32"),
        "material": 0,
    }
    made.document |= {
        "images": [{"bufferView": made.view(np.frombuffer(data.getvalue(), np.uint8))}],
        "textures": [{"source": 0}, {"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33648, "wrapT": 33071, "magFilter": 9728, "minFilter": 9729}],
        "materials": [material],
        "meshes": [{"primitives": [part]}],
        "nodes": [{"name": "tower", "mesh": 0}],
    }
    return made


def material_of(write: Write, made: Gltf) -> Material:
    found = read_character(write("dressed.glb", made.glb())).appearance
    assert found is not None
    assert [(part.first, part.stop, part.flat) for part in found.parts] == [(0, 20, True)]
    return found.parts[0].material


def test_everything_that_a_material_says_arrives(write: Write) -> None:
    turn = {"offset": [0.25, 0.5], "rotation": np.pi / 2, "scale": [2.0, 3.0], "texCoord": 1}
    moved = {"index": 1, "extensions": {"KHR_texture_transform": turn}}
    found = material_of(
        write,
        dressed(
            {
                "name": "coat",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
                    "baseColorTexture": moved,
                    "metallicFactor": 0.25,
                    "roughnessFactor": 0.75,
                },
                "normalTexture": {"index": 0, "scale": 0.5},
                "occlusionTexture": {"index": 0, "strength": 0.8},
                "emissiveFactor": [0.0, 0.5, 1.0],
                "emissiveTexture": {"index": 0},
                "alphaMode": "MASK",
                "alphaCutoff": 0.3,
                "doubleSided": True,
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
            },
            sets=2,
        ),
    )
    assert (found.name, found.metallic, found.roughness) == ("coat", 0.25, 0.75)
    np.testing.assert_allclose(found.base_color, [0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(found.emission, [0.0, 2.0, 4.0])
    assert (found.alpha_mode, found.alpha_cutoff, found.double_sided) == ("mask", 0.3, True)
    assert (found.normal_scale, found.occlusion_strength, found.unlit) == (0.5, 0.8, False)
    assert set(found.maps) == {"base_map", "normal_map", "occlusion_map", "emission_map"}
    base = found.base_map
    assert isinstance(base, TextureMap)
    assert (base.coordinate_set, base.wrap) == (1, ("mirror", "clamp"))
    assert (base.magnify, base.minify, base.mipmaps) == ("nearest", "linear", None)
    np.testing.assert_allclose(base.transform, [[0, 3, 0.25], [-2, 0, 0.5]], atol=1e-12)
    np.testing.assert_array_equal(base.pixels[0, 0], [250, 20, 0, 100])
    assert base.encoded.startswith(b"\x89PNG")


def test_what_is_not_drawn_is_named_once(write: Write) -> None:
    made = dressed({"extensions": {"KHR_materials_sheen": {}, "KHR_materials_clearcoat": {}}})
    notices = read_character(write("plain.glb", made.glb())).notices
    assert "materials are drawn without KHR_materials_clearcoat, KHR_materials_sheen" in notices
    made.document["extensionsUsed"] = ["KHR_materials_sheen", "EXT_mesh_gpu_instancing"]
    notices = read_character(write("plain.glb", made.glb())).notices
    assert "extensions that are not read: EXT_mesh_gpu_instancing" in notices
    lost = dressed({"emissiveTexture": {"index": 0, "texCoord": 2}})
    found = read_character(write("lost.glb", lost.glb()))
    assert "meshes without coordinates for their emission_map are drawn without" in found.notices
    assert found.appearance is not None
    assert not found.appearance.parts[0].material.maps


@pytest.mark.parametrize(
    ("material", "field"),
    [
        ({"alphaMode": "SOMETIMES"}, "alphaMode"),
        ({"doubleSided": 1}, "doubleSided"),
        ({"pbrMetallicRoughness": {"metallicFactor": "much"}}, "metallicFactor"),
        ({"normalTexture": {"index": 7}}, "normalTexture"),
        ({"emissiveFactor": [1.0, 2.0]}, "emissiveFactor"),
        ({"alphaCutoff": [0.5]}, "alphaCutoff"),
    ],
)
def test_materials_that_break_the_format_are_refused_by_name(
    write: Write, material: dict[str, object], field: str
) -> None:
    with pytest.raises(FormatError, match=field):
        read_character(write("broken.glb", dressed(material).glb()))


@pytest.mark.parametrize("field", ["wrapS", "wrapT", "magFilter", "minFilter"])
@pytest.mark.parametrize("value", [[], "10497", 1, None])
def test_samplers_that_break_the_format_are_refused_by_name(
    write: Write, field: str, value: object
) -> None:
    made = dressed({"normalTexture": {"index": 1}})
    made.document["samplers"][0][field] = value
    with pytest.raises(FormatError, match=f"sampler.{field}"):
        read_character(write("broken.glb", made.glb()))
