"""A small glTF file with everything that a surface may have: images, samplers, morphs, scenes."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from tests.animation.formats.samples import Gltf, animate, gltf_tower, tower

__all__ = ["dressed_gltf", "encoded"]

MAPS = ("normalTexture", "occlusionTexture", "emissiveTexture")


def encoded(kind: str, size: tuple[int, int] = (4, 2), color: Any = (250, 20, 0, 100)) -> bytes:
    """An image of one colour, as a file of that kind."""
    from PIL import Image

    made = io.BytesIO()
    mode = "RGB" if kind in ("JPEG", "BMP") else "RGBA"
    Image.new(mode, size, color[: len(mode)]).save(made, kind)
    return made.getvalue()


def dressed_gltf(images: tuple[bytes, ...]) -> Gltf:
    """The tower with a skin and every map, a hat on an animated node, and a mesh in no scene.

    Args:
        images: one or more files, which its five maps show in turn.
    """
    made = gltf_tower()
    _materials(made, images)
    meshes, nodes = made.document["meshes"], made.document["nodes"]
    part = meshes[0]["primitives"][0]
    part["attributes"] |= _attributes(made)
    part["material"] = 0
    raised = np.zeros((12, 3))
    raised[8:, 1] = 0.5
    part["targets"] = [{"POSITION": made.add(raised)}, {"NORMAL": made.add(-raised)}]
    meshes[0] |= {"weights": [0.0, 0.25], "extras": {"targetNames": ["up", "bent"]}}
    vertices, triangles, _ = tower()
    hat = {"POSITION": made.add(0.2 * vertices)} | _attributes(made)
    indices = made.add(triangles[::-1].reshape(-1), "uint16")
    meshes.append({"primitives": [
        {"attributes": hat, "indices": indices, "material": 1},
        {"attributes": hat, "mode": 5},
        {"attributes": hat, "mode": 0},
    ]})  # fmt: skip
    nodes += [
        {"name": "hat", "mesh": 1, "translation": [0.0, 1.0, 0.0], "scale": [1.0, 1.5, -1.0]},
        {"name": "elsewhere", "mesh": 1},
    ]
    nodes[2]["children"] = [4]
    made.document["scenes"].append({"nodes": [5]})
    keys = made.add([0.0, 0.5, 1.0])
    weights = made.add([0.0, 0.5, 1.0, 0.5, 0.0, 0.25])
    lifted = made.add([[0.0, 1.0, 0.0], [0.0, 1.2, 0.0], [0.0, 1.0, 0.0]])
    animate(made, "greet", keys, {(3, "weights"): weights, (4, "translation"): lifted})
    return made


def _attributes(made: Gltf) -> dict[str, int]:
    """Coordinates, tints, normals and tangents of twelve vertices."""
    uv = np.linspace(-1.0, 2.0, 24).reshape(12, 2)
    return {
        "TEXCOORD_0": made.add(uv),
        "TEXCOORD_1": made.add((100 * np.abs(uv)).astype(np.uint8), "uint8", normalized=True),
        "COLOR_0": made.add(np.tile([255, 128, 0, 200], (12, 1)), "uint8", normalized=True),
        "NORMAL": made.add(np.tile([0.0, 0.0, 1.0], (12, 1))),
        "TANGENT": made.add(np.tile([1.0, 0.0, 0.0, -1.0], (12, 1))),
    }


def _materials(made: Gltf, images: tuple[bytes, ...]) -> None:
    count = len(images)
    moved = {"offset": [0.25, 0.5], "rotation": 1.0, "scale": [2.0, 3.0], "texCoord": 1}
    links: list[dict[str, Any]] = [{"index": number % count} for number in range(5)]
    links[0]["extensions"] = {"KHR_texture_transform": moved}
    links[3]["texCoord"] = 1
    coat = {
        "name": "coat",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": links[0],
            "metallicRoughnessTexture": links[1],
            "metallicFactor": 0.25,
            "roughnessFactor": 0.75,
        },
        **dict(zip(MAPS, links[2:], strict=True)),
        "emissiveFactor": [0.0, 0.5, 1.0],
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "doubleSided": True,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
    }
    gloss = {"diffuseFactor": [0.5, 0.5, 0.5, 0.5], "glossinessFactor": 0.3}
    hat = {
        "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_unlit": {},
            "KHR_materials_sheen": {"sheenRoughnessFactor": 0.5},
            "KHR_materials_pbrSpecularGlossiness": gloss | {"diffuseTexture": {"index": 0}},
        },
    }
    made.document |= {
        "images": [
            {"bufferView": made.view(np.frombuffer(one, np.uint8)), "mimeType": "image/png"}
            for one in images
        ],
        "textures": [{"source": number, "sampler": number % 2} for number in range(len(images))],
        "samplers": [
            {"wrapS": 33648, "wrapT": 33071, "magFilter": 9728, "minFilter": 9729},
            {"wrapS": 10497, "minFilter": 9985},
        ],
        "materials": [coat, hat],
    }
