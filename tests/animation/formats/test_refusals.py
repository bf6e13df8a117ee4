"""Hostile and broken files are refused by name, before they cost anything."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.animation.formats import FormatError, read_character, write_gltf
from motorcade.animation.formats.limits import beside
from motorcade.ga.files import files_now, files_read
from tests.animation.formats import samples
from tests.animation.formats.samples import Write

BOMB = b"""<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">
<!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><COLLADA><asset>&b;</asset></COLLADA>"""


def changed(write: Write, *path: Any, value: Any) -> Path:
    """The tower with one value of its document replaced; the path leads to it."""
    made = samples.gltf_tower()
    at: Any = made.document
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return write("changed.glb", made.glb())


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("extensionsRequired",), ["KHR_texture_basisu"], "KHR_texture_basisu"),
        (("asset", "version"), "1.0", r"asset\.version: expected 2\.0, got 1\.0"),
        (("nodes", 2, "children"), [1], r"nodes\[1\]: expected one parent"),
        (("nodes", 2, "rotation"), [0, 0, 0, 0], "rotation: expected quaternions"),
        (("nodes", 2, "translation"), [0, 1e300, 0], "translation: expected finite numbers"),
        (("nodes", 1, "children"), [99], "children: expected a whole number from 0 to 3"),
        (("skins", 0, "joints"), [], "one or more different nodes"),
        (("skins", 0, "joints"), [1, 1], "one or more different nodes"),
        (("skins", 0, "joints"), [1], r"JOINTS: expected numbers below 1, got 1"),
        (("accessors", 0, "count"), 10**9, "count: expected a whole number"),
        (("accessors", 0, "componentType"), 7, "componentType: expected 5120 to 5126, got 7"),
        (("bufferViews", 0, "byteLength"), 10**9, "byteLength: expected a whole number"),
        (("animations", 0, "samplers", 0, "input"), 0, r"type: expected SCALAR, got MAT4"),
        (("animations", 0, "samplers", 0, "interpolation"), "WILD", "LINEAR, STEP or CUBIC"),
        (("meshes", 0, "primitives", 0, "attributes"), {}, "attributes: expected POSITION"),
    ],
)
def test_inconsistent_gltf_is_refused_by_name(
    write: Write, path: tuple[Any, ...], value: Any, message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(changed(write, *path, value=value))


def test_a_circle_of_nodes_is_refused(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["nodes"][0]["children"] = []
    made.document["nodes"][2]["children"] = [1]
    with pytest.raises(FormatError, match="a hierarchy, got a circle of 2 nodes"):
        read_character(write("circle.glb", made.glb()))


def test_deep_hierarchies_are_refused(write: Write) -> None:
    made = samples.gltf_tower()
    start = len(made.document["nodes"])
    made.document["nodes"] += [{"children": [start + i + 1]} for i in range(600)] + [{}]
    with pytest.raises(FormatError, match="at most 512 levels"):
        read_character(write("deep.glb", made.glb()))


@pytest.mark.parametrize("keys", [[0.0, 0.0], [1.0, 0.0], [0.0, np.nan]])
def test_keys_that_do_not_increase_are_refused(write: Write, keys: list[float]) -> None:
    made = samples.gltf_tower()
    made.document["animations"] = []
    turn = made.add([[0, 0, 0, 1]] * 2)
    samples.animate(made, "bad", made.add(keys), {(2, "rotation"): turn})
    with pytest.raises(FormatError, match=r"input: expected|finite"):
        read_character(write("keys.glb", made.glb()))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_keys_that_are_no_numbers_are_refused(write: Write, value: float) -> None:
    made = samples.gltf_tower()
    turn = made.add([[0, 0, 0, 1], [0, 0, value, 1]])
    samples.animate(made, "bad", made.add([0.0, 1.0]), {(2, "rotation"): turn})
    with pytest.raises(FormatError, match="finite keys"):
        read_character(write("nan.glb", made.glb()))


@pytest.mark.parametrize("weights", [[-0.5, 1.5, 0, 0], [np.nan, 0, 0, 0]])
def test_negative_and_missing_weights_are_refused(write: Write, weights: list[float]) -> None:
    made = samples.gltf_tower()
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["WEIGHTS_0"] = made.add(np.tile(weights, (12, 1)))
    with pytest.raises(FormatError, match=r"shares of 0 or more|finite"):
        read_character(write("weights.glb", made.glb()))


def test_weights_are_brought_to_a_sum_of_one_and_none_follows_the_first_joint(
    write: Write,
) -> None:
    made = samples.gltf_tower()
    part = made.document["meshes"][0]["primitives"][0]
    weights = np.tile([0.5, 1.5, 0.0, 0.0], (12, 1))
    weights[3] = 0.0
    part["attributes"]["WEIGHTS_0"] = made.add(weights)
    made_character = read_character(write("weights.glb", made.glb()))
    np.testing.assert_allclose(made_character.weights[0], [0.25, 0.75, 0, 0])
    assert made_character.joints[3].tolist() == [0, 0, 0, 0]
    assert any("1 vertices without weights" in notice for notice in made_character.notices)


def test_up_to_eight_influences_are_kept_the_largest_first(write: Write) -> None:
    made = samples.gltf_tower()
    attributes = made.document["meshes"][0]["primitives"][0]["attributes"]
    numbers = np.tile([0, 1, 0, 1], (12, 1))
    attributes["JOINTS_0"] = made.add(numbers, "uint8")
    attributes["JOINTS_1"] = made.add(numbers, "uint8")
    attributes["WEIGHTS_0"] = made.add(np.tile([0.3, 0.05, 0.2, 0.05], (12, 1)))
    attributes["WEIGHTS_1"] = made.add(np.tile([0.1, 0.2, 0.05, 0.05], (12, 1)))
    character = read_character(write("many.glb", made.glb()))
    wanted = np.array([6, 4, 4, 2, 1, 1, 1, 1]) / 20.0
    np.testing.assert_allclose(character.weights[0], wanted, atol=1e-6)
    assert not any("influences" in notice for notice in character.notices)
    back = write("back.glb", b"")
    write_gltf(back, character)
    np.testing.assert_allclose(read_character(back).weights[0], wanted, atol=1e-6)


def test_more_than_eight_influences_keep_the_largest(write: Write) -> None:
    made = samples.gltf_tower()
    attributes = made.document["meshes"][0]["primitives"][0]["attributes"]
    for group, share in enumerate((0.05, 0.15, 0.05)):
        attributes[f"JOINTS_{group}"] = made.add(np.tile([0, 1, 0, 1], (12, 1)), "uint8")
        attributes[f"WEIGHTS_{group}"] = made.add(np.tile([share] * 4, (12, 1)))
    character = read_character(write("many.glb", made.glb()))
    np.testing.assert_allclose(character.weights[0], [0.1875] * 4 + [0.0625] * 4, atol=1e-6)
    assert any("more than 8 influences; up to 20 %" in notice for notice in character.notices)


def test_what_is_lost_of_hardly_any_weight_is_not_worth_a_notice(write: Write) -> None:
    """A fifth influence of a thousandth, and shear of a joint that carries nothing."""
    made = samples.gltf_tower()
    attributes = made.document["meshes"][0]["primitives"][0]["attributes"]
    attributes["JOINTS_1"] = made.add(np.zeros((12, 4)), "uint8")
    attributes["WEIGHTS_0"] = made.add(np.tile([0.4, 0.3, 0.2, 0.099], (12, 1)))
    attributes["WEIGHTS_1"] = made.add(np.tile([0.001, 0.0, 0.0, 0.0], (12, 1)))
    document = made.document
    document["nodes"][2]["children"] = [4]
    document["nodes"].append({"name": "leaf", "scale": [1.0, 2.0, 1.0]})
    document["skins"][0] = {
        "joints": [1, 2, 4],
        "inverseBindMatrices": made.add(np.tile(np.eye(4).reshape(16), (3, 1))),
    }
    notices = read_character(write("light.glb", made.glb())).notices
    assert not any("influences" in told or "scales an axis" in told for told in notices)
    document["nodes"][2]["scale"] = [1.0, 2.0, 1.0]
    notices = read_character(write("heavy.glb", made.glb())).notices
    assert any("scales an axis" in told for told in notices)


def test_antipodal_keys_turn_the_short_way(write: Write) -> None:
    made = samples.gltf_tower()
    turn = np.array([[0, 0, 0, 1], [0, 0, -samples.QUARTER, -samples.QUARTER]])
    samples.animate(made, "far", made.add([0.0, 1.0]), {(2, "rotation"): made.add(turn)})
    character = read_character(write("far.glb", made.glb()))
    poses = character.clip("far").at([0.5, 1.0])
    world = character.skeleton.world(poses)
    angles = (world.rotor[:, 0].inverse() @ world.rotor[:, 1]).angle()
    np.testing.assert_allclose(np.degrees(angles), [45.0, 90.0], atol=1e-5)


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin",
        "/etc/passwd",
        "file:///etc/passwd",
        "a/../../b",
        "%2e%2e/x",
        "..\\x",
        "http://example.org/x",
    ],
)
def test_no_file_outside_the_folder_is_opened(write: Write, tmp_path: Path, uri: str) -> None:
    (tmp_path.parent / "secret.bin").write_bytes(bytes(4096))
    made = samples.gltf_tower()
    document = made.document | {"buffers": [{"byteLength": len(made.data), "uri": uri}]}
    with pytest.raises(FormatError, match=r"buffers\[0\]\.uri: expected"):
        read_character(write("out.gltf", json.dumps(document).encode()))


def test_links_do_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "secret.bin").write_bytes(b"secret")
    (inside / "link.bin").symlink_to(tmp_path / "secret.bin")
    (inside / "near.bin").write_bytes(b"near")
    with files_read() as record, pytest.raises(FormatError, match="inside the folder"):
        beside(inside, "link.bin", "uri")
    assert files_now(record) != record  # that link may be mended, and what was made without it goes
    assert beside(inside, "near.bin", "uri").read_bytes() == b"near"


def test_a_buffer_beside_the_file_is_read(write: Write) -> None:
    made = samples.gltf_tower()
    write("tower data.bin", bytes(made.data))
    document = made.document | {
        "buffers": [{"byteLength": len(made.data), "uri": "tower%20data.bin"}]
    }
    assert read_character(write("near.gltf", json.dumps(document).encode())).height_m == 2.0


def test_entities_and_document_types_are_refused(write: Write) -> None:
    with pytest.raises(FormatError, match="no document type and no entities"):
        read_character(write("bomb.dae", BOMB))


def test_deep_xml_is_refused(write: Write) -> None:
    with pytest.raises(FormatError, match="at most 512 levels"):
        read_character(write("deep.dae", b"<a>" * 2000))


def test_deep_json_is_refused(write: Write) -> None:
    with pytest.raises(FormatError, match="nested too deeply"):
        read_character(write("deep.gltf", b"[" * 200_000))


def test_a_motion_of_other_joints_is_refused(write: Write) -> None:
    write("tower.md5anim", samples.md5_motion_tower().replace(b'"top"', b'"hat"'))
    with pytest.raises(FormatError, match="the joints of the mesh beside it"):
        read_character(write("tower.md5mesh", samples.md5_mesh_tower()))


@pytest.mark.parametrize("name", ["a.glb", "a.dae", "a.md5mesh", "a.bvh"])
def test_empty_and_missing_files_are_refused(write: Write, tmp_path: Path, name: str) -> None:
    with pytest.raises(FormatError, match="the file is missing"):
        read_character(tmp_path / name)
    with pytest.raises(FormatError, match="is empty"):
        read_character(write(name, b""))


def test_messages_keep_to_one_line(write: Write) -> None:
    with pytest.raises(FormatError) as caught:
        read_character(changed(write, "asset", "version", value="1\n2\x1b[31m" + "x" * 5000))
    assert "\n" not in str(caught.value)
    assert "\x1b" not in str(caught.value)
    assert len(str(caught.value)) < 600
