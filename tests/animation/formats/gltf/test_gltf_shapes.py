"""What glTF allows besides plain triangles: strips, fans, matrices, strides, images inside."""

from __future__ import annotations

import base64
import io
import json
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.linalg import polar

from motorcade.animation import Character
from motorcade.animation.appearance import to_srgb
from motorcade.animation.formats import FormatError, read_character, read_motion
from tests.animation.formats import samples
from tests.animation.formats.samples import Gltf, Write

TRIANGLES, STRIP, FAN = 4, 5, 6


def part_of(made: Gltf) -> dict[str, Any]:
    """The only primitive of the tower."""
    part: dict[str, Any] = made.document["meshes"][0]["primitives"][0]
    return part


def faces(character: Character) -> set[tuple[int, ...]]:
    """Triangles, each turned so that its smallest corner stands first."""
    return {
        min(tuple(np.roll(corners, k)) for k in range(3))
        for corners in character.triangles.tolist()
    }


@pytest.mark.parametrize(
    ("mode", "run", "wanted"),
    [
        (TRIANGLES, [0, 1, 5, 0, 5, 4], {(0, 1, 5), (0, 5, 4)}),
        (TRIANGLES, [0, 1, 5, 0, 5, 4, 2, 3], {(0, 1, 5), (0, 5, 4)}),
        (STRIP, [0, 1, 4, 5, 8], {(0, 1, 4), (1, 5, 4), (4, 5, 8)}),
        (FAN, [0, 1, 5, 4], {(0, 1, 5), (0, 5, 4)}),
        (STRIP, [0, 1], set()),
        (FAN, [0, 1], set()),
    ],
)
def test_strips_and_fans_are_the_triangles_of_the_specification(
    write: Write, mode: int, run: list[int], wanted: set[tuple[int, ...]]
) -> None:
    """Every second triangle of a strip is turned round, so that all face one way."""
    made = samples.gltf_tower()
    part_of(made)["mode"] = mode
    part_of(made)["indices"] = made.add(run, "uint16")
    assert faces(read_character(write("strip.glb", made.glb()))) == wanted


def test_triangles_without_indices_take_the_vertices_in_their_order(write: Write) -> None:
    made = samples.gltf_tower()
    part_of(made).pop("indices")
    found = read_character(write("plain.glb", made.glb()))
    assert found.triangles.tolist() == np.arange(12).reshape(4, 3).tolist()


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_points_and_lines_are_left_out_and_told(write: Write, mode: int) -> None:
    made = samples.gltf_tower()
    plain = read_character(write("plain.glb", made.glb()))
    line = json.loads(json.dumps(part_of(made))) | {"mode": mode}
    made.document["meshes"][0]["primitives"].append(line)
    found = read_character(write("lines.glb", made.glb()))
    np.testing.assert_array_equal(found.vertices, plain.vertices)
    assert "1 meshes of points or lines are left out" in found.notices


def test_interleaved_values_are_those_apart(write: Write) -> None:
    made = samples.gltf_tower()
    vertices, _, _ = samples.tower()
    rows = np.zeros((12, 5), np.float32)
    rows[:, :3] = vertices
    accessor = made.document["accessors"][part_of(made)["attributes"]["POSITION"]]
    accessor["bufferView"] = made.view(rows, byteStride=20)
    plain = read_character(write("plain.glb", samples.gltf_tower().glb()))
    found = read_character(write("woven.glb", made.glb()))
    np.testing.assert_allclose(found.vertices, plain.vertices, atol=1e-7)


def test_an_accessor_without_a_view_holds_zeros(write: Write) -> None:
    """Over which sparse values are written."""
    made = samples.gltf_tower()
    accessor = made.document["accessors"][part_of(made)["attributes"]["POSITION"]]
    vertices, _, _ = samples.tower()
    accessor.pop("bufferView")
    accessor["sparse"] = {
        "count": 11,
        "indices": {
            "bufferView": made.view(np.arange(1, 12, dtype=np.uint8)),
            "componentType": 5121,
        },
        "values": {"bufferView": made.view(vertices[1:].astype(np.float32))},
    }
    found = read_character(write("sparse.glb", made.glb()))
    np.testing.assert_allclose(found.vertices[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.vertices[5], [0.2, 0.2, 1.0], atol=1e-6)


@pytest.mark.parametrize("kind", ["uint8", "int16"])
def test_turns_may_be_normalised_integers(write: Write, kind: str) -> None:
    """A half turn; integers that are not normalised count as they stand."""
    made = samples.gltf_tower()
    most = np.iinfo(kind).max
    turn = made.add([[0, 0, 0, most], [0, 0, most, 0]], kind, normalized=True)
    samples.animate(made, "round", made.add([0.0, 1.0]), {(2, "rotation"): turn})
    place = made.add([[0, 1, 0], [0, 3, 0]], "uint8")
    samples.animate(made, "up", made.add([0.0, 1.0]), {(2, "translation"): place})
    found = read_character(write("small.glb", made.glb()))
    world = found.skeleton.world(found.clip("round").at([0.5, 1.0]))
    angles = (world.rotor[:, 0].inverse() @ world.rotor[:, 1]).angle()
    np.testing.assert_allclose(angles, [np.pi / 2, np.pi], atol=1e-3)
    places = found.skeleton.world(found.clip("up").at([0.5, 1.0])).translation_m
    np.testing.assert_allclose(places[:, 1, 2], [2.0, 3.0], atol=1e-6)


def _matrix(scale: float, shear: float = 0.0) -> list[float]:
    made = np.eye(4)
    made[:3, :3] *= scale
    made[0, 1] = shear
    made[:3, 3] = (0.0, 1.0, 0.0)
    return made.T.reshape(-1).tolist()


def test_a_node_may_state_a_matrix(write: Write) -> None:
    """The same as its parts; with shear the nearest turn, which a notice says."""
    plain = read_character(write("plain.glb", samples.gltf_tower().glb()))
    made = samples.gltf_tower()
    top = made.document["nodes"][2]
    made.document["animations"] = []
    top.pop("translation")
    top["matrix"] = _matrix(1.0)
    found = read_character(write("matrix.glb", made.glb()))
    np.testing.assert_allclose(found.vertices, plain.vertices, atol=1e-7)
    np.testing.assert_allclose(
        found.skeleton.rest_world.as_matrix(), plain.skeleton.rest_world.as_matrix(), atol=1e-7
    )
    top["matrix"] = _matrix(1.0, shear=0.3)
    sheared = write("shear.glb", made.glb())
    told = read_character(sheared).notices
    assert any("have shear or different scales" in notice for notice in told)
    sheared_figure = read_character(sheared)
    rest = sheared_figure.skeleton.world(sheared_figure.found_pose)
    np.testing.assert_allclose(rest.translation_m[1], [0.0, 0.0, 1.0], atol=1e-7)
    turn, _ = polar(np.array(top["matrix"]).reshape(4, 4).T[:3, :3])
    axes = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(rest.rotor[1].as_matrix(), axes @ turn, atol=1e-7)


def test_a_skin_without_matrices_was_bound_where_its_mesh_stands(write: Write) -> None:
    """In identity, says the specification; so the joints rest where the mesh's frame is."""
    made = samples.gltf_tower()
    made.document["skins"][0].pop("inverseBindMatrices")
    made.document["animations"] = []
    found = read_character(write("unbound.glb", made.glb()))
    np.testing.assert_allclose(np.ptp(found.skeleton.rest_world.translation_m, axis=0), 0.0)
    np.testing.assert_allclose(np.ptp(found.vertices[:, 2]), 2.0, atol=1e-6)


def _image(color: tuple[int, int, int], mode: str = "RGB") -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (2, 2), color).convert(mode).save(file, "PNG")
    return file.getvalue()


def _painted(made: Gltf, image: dict[str, Any], material: dict[str, Any] | None = None) -> bytes:
    part_of(made)["attributes"]["TEXCOORD_0"] = made.add(np.full((12, 2), 0.5))
    part_of(made)["material"] = 0
    base = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    made.document |= {
        "materials": [base if material is None else material],
        "textures": [{"source": 0}],
        "images": [image],
    }
    return made.glb()


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P", "1"])
@pytest.mark.parametrize("place", ["buffer", "address"])
def test_images_may_lie_inside_the_file_in_any_mode(write: Write, mode: str, place: str) -> None:
    made = samples.gltf_tower()
    data = _image((255, 255, 255), mode)
    if place == "buffer":
        view = made.view(np.frombuffer(data, np.uint8))
        image: dict[str, Any] = {"bufferView": view, "mimeType": "image/png"}
    else:
        image = {"uri": "data:image/png;base64," + base64.b64encode(data).decode()}
    found = read_character(write("painted.glb", _painted(made, image)))
    np.testing.assert_allclose(found.colors, 1.0, atol=1e-9)


def test_an_image_that_is_none_is_told_and_leaves_a_plain_grey(write: Write) -> None:
    made = samples.gltf_tower()
    view = made.view(np.frombuffer(_image((9, 9, 9))[:40], np.uint8))
    found = read_character(write("broken.glb", _painted(made, {"bufferView": view, "name": "x"})))
    assert any("'x' was not read (expected an image" in notice for notice in found.notices)
    np.testing.assert_allclose(found.colors, found.colors[0, 0])


def test_one_image_for_many_meshes_is_told_once(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["meshes"][0]["primitives"] *= 3
    found = read_character(write("thrice.glb", _painted(made, {"uri": "lost.png"})))
    assert len([notice for notice in found.notices if "lost.png" in notice]) == 1


@pytest.mark.parametrize(
    ("material", "linear"),
    [
        (
            {
                "extensions": {
                    "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.2, 0.4, 0.6, 1.0]}
                }
            },
            [0.2, 0.4, 0.6],
        ),
        (
            {
                "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.1, 0.9, 1.0]},
                "extensions": {
                    "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.2, 0.4, 0.6, 1.0]}
                },
            },
            [0.1, 0.1, 0.9],
        ),
        ({}, [1.0, 1.0, 1.0]),
        ({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}, [1.0, 1.0, 1.0]),
    ],
)
def test_colours_come_from_whichever_way_the_material_states_them(
    write: Write, material: dict[str, Any], linear: list[float]
) -> None:
    """A texture without an image paints nothing."""
    made = samples.gltf_tower()
    _painted(made, {"uri": "none.png"}, material)
    made.document["textures"].append({})
    found = read_character(write("stated.glb", made.glb()))
    np.testing.assert_allclose(found.colors, np.tile(to_srgb(np.array(linear)), (12, 1)), atol=1e-9)


def test_colours_of_vertices_may_be_three_floats(write: Write) -> None:
    made = samples.gltf_tower()
    part_of(made)["attributes"]["COLOR_0"] = made.add(np.tile([0.5, 0.25, 2.0], (12, 1)))
    found = read_character(write("colors.glb", made.glb()))
    np.testing.assert_allclose(found.colors[0], to_srgb(np.array([0.5, 0.25, 1.0])), atol=1e-7)


def test_normals_of_length_zero_are_made_anew(write: Write) -> None:
    made = samples.gltf_tower()
    normals = np.tile([0.0, 0.0, 1.0], (12, 1))
    normals[4:8] = 0.0
    part_of(made)["attributes"]["NORMAL"] = made.add(normals)
    found = read_character(write("bare.glb", made.glb()))
    assert "'tower': 4 normals of length zero made anew" in found.notices
    np.testing.assert_allclose(found.normals[0], [1.0, 0.0, 0.0], atol=1e-7)
    outwards = found.vertices[4:8] * (1.0, 1.0, 0.0)
    assert np.all(np.sum(outwards * found.normals[4:8], axis=1) > 0.1)


def test_a_mirrored_mesh_keeps_its_outside(write: Write) -> None:
    """Exporters mirror limbs by a negative scale, which turns triangles inside out."""
    made = samples.gltf_tower()
    made.document["animations"] = []
    nodes = made.document["nodes"]
    hat = json.loads(json.dumps(part_of(made)))
    for name in ("JOINTS_0", "WEIGHTS_0"):
        hat["attributes"].pop(name)
    made.document["meshes"].append({"primitives": [hat]})
    nodes[2]["children"] = [4]
    nodes.append({"name": "hat", "mesh": 1, "scale": [-1.0, 1.0, 1.0]})
    found = read_character(write("mirror.glb", made.glb()))
    for first in (0, 12):
        held = found.triangles[
            (found.triangles >= first).all(1) & (found.triangles < first + 12).all(1)
        ]
        a, b, c = (found.vertices[held[:, corner]] for corner in range(3))
        centre = found.vertices[first : first + 12].mean(axis=0)
        volume = np.sum((a - centre) * np.cross(b - centre, c - centre)) / 6.0
        assert volume == pytest.approx(0.16 * 2.0, rel=1e-6)


def test_joints_without_names_of_their_own_are_named_and_clips_told_apart(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["nodes"][2]["name"] = "base"
    made.document["animations"].append(made.document["animations"][0])
    made.document["animations"].append({**made.document["animations"][0], "name": ""})
    found = read_character(write("names.glb", made.glb()))
    assert found.skeleton.names == ("base", "base#2")
    assert [clip.name for clip in found.clips] == ["bend", "bend#2", "motion"]
    assert "1 joints without a name of their own were named" in found.notices
    assert "a clip called 'bend' is now 'bend#2'" in found.notices


def test_channels_that_move_no_joint_are_left_out_and_told(write: Write) -> None:
    made = samples.gltf_tower()
    animation = made.document["animations"][0]
    animation["channels"].append({"sampler": 0, "target": {"node": 2, "path": "weights"}})
    animation["channels"].append({"sampler": 0, "target": {"path": "rotation"}})
    found = read_motion(write("left.glb", made.glb()))
    assert "2 channels that move no joint are left out" in found.notices


def test_a_mesh_outside_of_the_skeleton_is_a_joint_of_its_own(write: Write) -> None:
    made = samples.gltf_tower()
    ground = json.loads(json.dumps(part_of(made)))
    for name in ("JOINTS_0", "WEIGHTS_0"):
        ground["attributes"].pop(name)
    made.document["meshes"].append({"primitives": [ground]})
    made.document["nodes"].append({"name": "ground", "mesh": 1})
    made.document["scenes"][0]["nodes"].append(4)
    found = read_character(write("ground.glb", made.glb()))
    assert len(found.vertices) == 24
    assert found.skeleton.names[-1] == "ground"
    assert set(found.joints[12:, 0]) == {found.skeleton.index("ground")}


def test_extensions_that_change_nothing_here_may_be_required(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["extensionsRequired"] = ["KHR_mesh_quantization", "KHR_materials_unlit"]
    assert read_character(write("quantized.glb", made.glb())).height_m == pytest.approx(2.0)


def test_meshes_are_hidden_by_their_names(write: Write) -> None:
    """By those of the nodes that bear them; a name that is not there is answered."""
    made = samples.gltf_tower()
    document = made.document
    document["meshes"].append(document["meshes"][0])
    bearing = next(node for node in document["nodes"] if "mesh" in node)
    document["nodes"].append(bearing | {"mesh": 1, "name": "sword"})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    path = write("both.glb", made.glb())
    whole = read_character(path)
    assert 2 * len(read_character(path, hide=["sword"]).triangles) == len(whole.triangles)
    with pytest.raises(FormatError, match=r"hide: no mesh 'swrod'; did you mean sword\?"):
        read_character(path, hide=["swrod"])


@pytest.mark.parametrize("scale", [40.0, 1.0, 0.01])
def test_sizes_that_few_things_have_are_doubted(write: Write, scale: float) -> None:
    """Things without limbs keep what their file says; the tower is two metres high."""
    read = read_character(write("tower.glb", samples.gltf_tower(scale).glb()))
    assert any("m large as its file says" in notice for notice in read.notices) == (scale != 1.0)
