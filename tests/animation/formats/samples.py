"""Small character and motion files made here, byte by byte, without the library's own writer.

All show the same figure: a square tower of two joints, `base` at the ground and `top` one unit
above it; in the clip `top` turns by a quarter about the file's z axis within a second.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Write = Callable[[str, bytes], Path]

CORNERS = np.array([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)])
"""Of the tower's square, counter-clockwise."""
LEVELS = (0.0, 1.0, 2.0)
QUARTER = float(np.sqrt(0.5))
KINDS = {
    "float32": 5126,
    "uint8": 5121,
    "int8": 5120,
    "uint16": 5123,
    "int16": 5122,
    "uint32": 5125,
}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def tower() -> tuple[Array, Array, Array]:
    """Vertices (12, 3) with y up, triangles (T, 3) counter-clockwise, heights' levels (12,)."""
    vertices = np.array([(x, height, -y) for height in LEVELS for x, y in CORNERS])
    triangles = []
    for level in range(2):
        for side in range(4):
            a, b = 4 * level + side, 4 * level + (side + 1) % 4
            triangles += [(a, b, b + 4), (a, b + 4, a + 4)]
    triangles += [(8, 9, 10), (8, 10, 11), (2, 1, 0), (3, 2, 0)]
    return vertices, np.array(triangles), np.repeat([0, 1, 2], 4)


class Gltf:
    """A glTF document put together from NumPy arrays.

    `document` may be changed freely before `glb` or `gltf` turns it into bytes; `others` are
    further buffers of a `.glb`.
    """

    def __init__(self) -> None:
        self.data = bytearray()
        self.others: list[dict[str, Any]] = []
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "accessors": [],
            "bufferViews": [],
        }

    def view(self, array: Array, **more: Any) -> int:
        """A buffer view over an array."""
        self.data += b"\0" * (-len(self.data) % 4)
        views = self.document["bufferViews"]
        views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes} | more)
        self.data += np.ascontiguousarray(array).tobytes()
        return len(views) - 1

    def add(self, values: Any, kind: str = "float32", **more: Any) -> int:
        """An accessor over an array (n,) or (n, width)."""
        array = np.array(values, dtype=kind)
        width = 1 if array.ndim == 1 else array.shape[1]
        accessors = self.document["accessors"]
        accessors.append(
            {
                "bufferView": self.view(array),
                "componentType": KINDS[kind],
                "count": len(array),
                "type": TYPES[width],
            }
            | more
        )
        return len(accessors) - 1

    def gltf(self) -> bytes:
        """As `.gltf` with its buffer inside."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        return json.dumps(
            self.document | {"buffers": [{"byteLength": len(self.data), "uri": uri}]}
        ).encode()

    def glb(self) -> bytes:
        """As `.glb`."""
        document = self.document | {"buffers": [{"byteLength": len(self.data)}, *self.others]}
        return packed(json.dumps(document).encode(), bytes(self.data))


def packed(text: bytes, data: bytes) -> bytes:
    """A `.glb` of a JSON document and a buffer."""
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    return (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(data), b"BIN\0")
        + data
    )


def gltf_tower(scale: float = 1.0) -> Gltf:
    """The tower: nodes `scene`, `base`, `top`, `tower`; the scene node may scale everything."""
    made = Gltf()
    vertices, triangles, level = tower()
    weights = np.zeros((12, 4))
    weights[:, 0] = np.choose(level, [1.0, 0.5, 0.0])
    weights[:, 1] = 1.0 - weights[:, 0]
    binds = np.stack([np.eye(4), np.eye(4)])
    binds[1, 1, 3] = -1.0
    made.document |= {
        "scene": 0,
        "scenes": [{"nodes": [0, 3]}],
        "nodes": [
            {"name": "scene", "scale": [scale] * 3, "children": [1]},
            {"name": "base", "children": [2]},
            {"name": "top", "translation": [0.0, 1.0, 0.0]},
            {"name": "tower", "mesh": 0, "skin": 0},
        ],
        "skins": [
            {"joints": [1, 2],
             "inverseBindMatrices": made.add(binds.swapaxes(1, 2).reshape(-1, 16))}
        ],
        "meshes": [{"primitives": [{
            "attributes": {
                "POSITION": made.add(vertices),
                "JOINTS_0": made.add(np.tile([0, 1, 0, 0], (12, 1)), "uint8"),
                "WEIGHTS_0": made.add(weights),
            },
            "indices": made.add(triangles.reshape(-1), "uint16"),
        }]}],
    }  # fmt: skip
    turn = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, QUARTER, QUARTER]]
    animate(made, "bend", made.add([0.0, 1.0]), {(2, "rotation"): made.add(turn)})
    return made


def animate(
    made: Gltf, name: str, keys: int, outputs: dict[tuple[int, str], int], kind: str = "LINEAR"
) -> None:
    """Add an animation whose channels share their keys."""
    made.document.setdefault("animations", []).append(
        {
            "name": name,
            "samplers": [
                {"input": keys, "output": output, "interpolation": kind}
                for output in outputs.values()
            ],
            "channels": [
                {"sampler": i, "target": {"node": node, "path": path}}
                for i, (node, path) in enumerate(outputs)
            ],
        }
    )


def rich_gltf() -> Gltf:
    """The tower with steps, cubic splines, sparse and normalised values, colours and scale."""
    made = gltf_tower(0.01)
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["COLOR_0"] = made.add(
        np.tile([255, 128, 0, 255], (12, 1)), "uint8", normalized=True
    )
    part["attributes"]["NORMAL"] = made.add(np.tile([0.0, 0.0, 1.0], (12, 1)))
    part["material"] = 0
    part["targets"] = [{"POSITION": made.add(np.zeros((12, 3)))}]
    made.document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1]}}]
    rows = made.view(np.array([1, 3], np.uint16))
    values = made.view(np.array([[0.3, 0.0, 0.2], [-0.3, 0.0, 0.2]], np.float32))
    accessor = made.document["accessors"][part["attributes"]["POSITION"]]
    accessor["sparse"] = {
        "count": 2,
        "indices": {"bufferView": rows, "componentType": 5123},
        "values": {"bufferView": values},
    }
    keys = made.add([0.0, 0.5, 1.0])
    animate(made, "steps", keys, {(1, "translation"): made.add(np.eye(3))}, "STEP")
    cubic = made.add(np.tile([0.0, 0.0, 0.0, 1.0], (9, 1)) * ([[0], [1], [0]] * 3))
    animate(made, "curve", keys, {(2, "rotation"): cubic}, "CUBICSPLINE")
    grown = made.add([[1.0] * 3, [1.5] * 3, [1.0] * 3])
    animate(made, "growing", keys, {(2, "scale"): grown})
    return made


COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.5" name="half"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="red"><profile_COMMON><technique sid="t"><lambert><diffuse>
<color>0.8 0.2 0.1 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m"><instance_effect url="#red"/></material></library_materials>
<library_geometries><geometry id="tower" name="tower"><mesh>
<source id="p"><float_array id="pa" count="36">{positions}</float_array><technique_common>
<accessor source="#pa" count="12" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="s" count="10"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>{counts}</vcount><p>{corners}</p></polylist></mesh></geometry></library_geometries>
<library_controllers><controller id="skin"><skin source="#tower">
<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>
<source id="j"><Name_array id="ja" count="2">b t</Name_array></source>
<source id="b"><float_array id="ba" count="32">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1
1 0 0 0 0 1 0 0 0 0 1 -1 0 0 0 1</float_array><technique_common>
<accessor source="#ba" count="2" stride="16"/></technique_common></source>
<source id="w"><float_array id="wa" count="2">1 0.5</float_array></source>
<joints><input semantic="JOINT" source="#j"/>
<input semantic="INV_BIND_MATRIX" source="#b"/></joints>
<vertex_weights count="12"><input semantic="JOINT" source="#j" offset="0"/>
<input semantic="WEIGHT" source="#w" offset="1"/>
<vcount>1 1 1 1 2 2 2 2 1 1 1 1</vcount><v>{weights}</v></vertex_weights>
</skin></controller></library_controllers>
<library_animations><animation id="a">
<source id="i"><float_array id="ia" count="2">0 1</float_array></source>
<source id="o"><float_array id="oa" count="2">0 90</float_array></source>
<source id="k"><Name_array id="ka" count="2">{kind} {kind}</Name_array></source>
<source id="in"><float_array id="ina" count="4">-0.3 0 0.7 90</float_array></source>
<source id="out"><float_array id="outa" count="4">0.3 0 1.3 90</float_array></source>
<sampler id="s"><input semantic="INPUT" source="#i"/><input semantic="OUTPUT" source="#o"/>
<input semantic="INTERPOLATION" source="#k"/><input semantic="IN_TANGENT" source="#in"/>
<input semantic="OUT_TANGENT" source="#out"/></sampler>
<channel source="#s" target="top/turn.ANGLE"/></animation></library_animations>
<library_visual_scenes><visual_scene id="scene">
<node id="base" name="base" sid="b" type="JOINT"><translate sid="at">0 0 0</translate>
<node id="top" name="top" sid="t" type="JOINT"><translate>0 0 1</translate>
<rotate sid="turn">0 0 1 0</rotate></node></node>
<node id="mesh"><instance_controller url="#skin"><skeleton>#base</skeleton><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_controller></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>
"""


def collada_tower(kind: str = "LINEAR") -> bytes:
    """The tower with z up, in units of half a metre; quads and Euler angles."""
    vertices, _, _ = tower()
    positions = vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    quads = [
        [
            4 * level + side,
            4 * level + (side + 1) % 4,
            4 * level + 4 + (side + 1) % 4,
            4 * level + 4 + side,
        ]
        for level in range(2)
        for side in range(4)
    ] + [[8, 9, 10, 11], [3, 2, 1, 0]]
    weights = ["0 0"] * 4 + ["0 1 1 1"] * 4 + ["1 0"] * 4
    return COLLADA.format(
        positions=" ".join(f"{value:g}" for value in positions.reshape(-1)),
        counts=" ".join("4" for _ in quads),
        corners=" ".join(str(corner) for quad in quads for corner in quad),
        weights=" ".join(weights),
        kind=kind,
    ).encode()


def collada_with(*changes: tuple[str, str], kind: str = "LINEAR") -> bytes:
    """The Collada tower with parts of its text replaced, each found once or more."""
    text = collada_tower(kind).decode()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text.encode()


def collada_polygons() -> str:
    """The element that holds the polygons of the Collada tower."""
    text = collada_tower().decode()
    return text[text.index("<polylist") : text.index("</polylist>") + len("</polylist>")]


def md5_mesh_tower() -> bytes:
    """The tower with z up and its triangles clockwise."""
    vertices, triangles, level = tower()
    rows, weights = [], []
    for number, (x, height, minus_y) in enumerate(vertices):
        held = {0: [(0, 1.0)], 1: [(0, 0.5), (1, 0.5)], 2: [(1, 1.0)]}[int(level[number])]
        rows.append(f"vert {number} ( 0.5 0.5 ) {len(weights)} {len(held)}")
        for joint, share in held:
            weights.append(
                f"weight {len(weights)} {joint} {share} ( {x} {-minus_y} {height - joint} )"
            )
    faces = [f"tri {i} {a} {c} {b}" for i, (a, b, c) in enumerate(triangles)]
    joints = '"base" -1 ( 0 0 0 ) ( 0 0 0 ) // root\n"top" 0 ( 0 0 1 ) ( 0 0 0 )'
    return (
        'MD5Version 10\ncommandline ""\nnumJoints 2\nnumMeshes 1\n'
        f"joints {{\n{joints}\n}}\n"
        f'mesh {{\nshader "tower"\nnumverts {len(rows)}\n'
        + "\n".join(rows)
        + f"\nnumtris {len(faces)}\n"
        + "\n".join(faces)
        + f"\nnumweights {len(weights)}\n"
        + "\n".join(weights)
        + "\n}\n"
    ).encode()


def md5_motion_tower() -> bytes:
    """Three frames at 2 Hz in which `top` turns by a quarter about z."""
    half = np.sin(np.radians([0.0, 22.5, 45.0]))
    frames = "\n".join(f"frame {i} {{\n{-value:.9f}\n}}" for i, value in enumerate(half))
    return (
        'MD5Version 10\ncommandline ""\nnumFrames 3\nnumJoints 2\nframeRate 2\n'
        "numAnimatedComponents 1\n"
        'hierarchy {\n"base" -1 0 0\n"top" 0 32 0\n}\n'
        "bounds {\n( 0 0 0 ) ( 1 1 1 )\n( 0 0 0 ) ( 1 1 1 )\n( 0 0 0 ) ( 1 1 1 )\n}\n"
        "baseframe {\n( 0 0 0 ) ( 0 0 0 )\n( 0 0 1 ) ( 0 0 0 )\n}\n" + frames + "\n"
    ).encode()


BVH = b"""HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Head
  {
    OFFSET 0 5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
  JOINT LeftFoot
  {
    OFFSET 0.5 -5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftToe
    {
      OFFSET 0 -0.1 1
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 0 0.5
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.5
0 5 0 0 0 0 0 0 0 0 0 0 0 0 0
0 5 1 10 20 30 0 0 0 0 0 0 0 0 0
0 5 2 -90 45 60 30 20 10 0 0 0 0 0 0
"""
