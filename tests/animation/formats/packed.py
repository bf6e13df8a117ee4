"""The tower in compressed files."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.animation.formats.samples import Gltf, gltf_tower, tower

__all__ = ["DRACO", "MESHOPT", "add_stream", "draco_tower", "meshopt_streams", "meshopt_tower"]

DRACO = "KHR_draco_mesh_compression"
MESHOPT = "EXT_meshopt_compression"
STREAMS = Path(__file__).with_name("meshopt_streams.json")


def draco_tower(*, edgebreaker: bool = True) -> Gltf:
    """The tower with normals, in Draco's form alone; its order is kept unless by edgebreaker."""
    import DracoPy

    made = gltf_tower()
    vertices, triangles, level = tower()
    (part,) = made.document["meshes"][0]["primitives"]
    given = made.document["accessors"]
    part["attributes"]["NORMAL"] = made.add(np.tile([0.0, 0.0, 1.0], (12, 1)))
    weights = np.zeros((12, 4), np.float32)
    weights[:, 0] = np.choose(level, [1.0, 0.5, 0.0])
    weights[:, 1] = 1.0 - weights[:, 0]
    data = DracoPy.encode(
        vertices.astype(np.float32),
        triangles.astype(np.uint32),
        quantization_bits=20,
        compression_level=7,
        preserve_order=not edgebreaker,
        normals=np.tile([0.0, 0.0, 1.0], (12, 1)),
        generic_attributes={7: np.tile(np.array([0, 1, 0, 0], np.uint8), (12, 1)), 9: weights},
    )
    numbers = {
        {0: "POSITION", 1: "NORMAL"}.get(one["attribute_type"], str(one["unique_id"])): one
        for one in DracoPy.decode(data).attributes
    }
    names = {"POSITION": "POSITION", "NORMAL": "NORMAL", "JOINTS_0": "7", "WEIGHTS_0": "9"}
    places = {name: numbers[key]["unique_id"] for name, key in names.items()}
    count = len(numbers["POSITION"]["data"])
    for name in places:
        given[part["attributes"][name]].pop("bufferView")
        given[part["attributes"][name]]["count"] = count
    given[part["indices"]].pop("bufferView")
    view = made.view(np.frombuffer(data, np.uint8))
    part["extensions"] = {DRACO: {"bufferView": view, "attributes": places}}
    made.document |= {"extensionsUsed": [DRACO], "extensionsRequired": [DRACO]}
    return made


def meshopt_streams() -> list[dict[str, Any]]:
    """What meshoptimizer itself packed and unpacked; `packed` and `plain` as bytes."""
    made: list[dict[str, Any]] = json.loads(STREAMS.read_text())
    for one in made:
        one |= {key: base64.b64decode(one[key]) for key in ("packed", "plain") if key in one}
    return made


def add_stream(made: Gltf, stream: dict[str, Any]) -> int:
    """A compressed buffer view, whose plain bytes would lie in the second buffer."""
    view = made.view(np.frombuffer(stream["packed"], np.uint8))
    entry = made.document["bufferViews"][view]
    length = stream["count"] * stream["byteStride"]
    packed = {key: stream[key] for key in ("mode", "filter", "count", "byteStride")}
    extensions = {MESHOPT: packed | entry}
    made.document["bufferViews"][view] = {
        "buffer": 1,
        "byteLength": length,
        "extensions": extensions,
    }
    return view


def meshopt_tower() -> Gltf:
    """The tower with places and triangles compressed as meshoptimizer does."""
    made, streams = gltf_tower(), {one["name"]: one for one in meshopt_streams()}
    (part,) = made.document["meshes"][0]["primitives"]
    for name, holder in (("POSITION", part["attributes"]), ("indices", part)):
        view = add_stream(made, streams[f"tower {name}"])
        made.document["accessors"][holder[name]]["bufferView"] = view
    made.document |= {"extensionsUsed": [MESHOPT], "extensionsRequired": [MESHOPT]}
    fallback = {"byteLength": 1000, "extensions": {MESHOPT: {"fallback": True}}}
    made.others = [fallback]
    return made
