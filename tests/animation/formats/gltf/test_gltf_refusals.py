"""Every field of a glTF document that can be wrong is refused by its name."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest

from motorcade.animation.formats import FormatError, read_character, read_motion
from motorcade.animation.formats.gltf import document as document_module
from tests.animation.formats import samples
from tests.animation.formats.samples import Gltf, Write

PART = ("meshes", 0, "primitives", 0)
ATTRIBUTES = (*PART, "attributes")
TWELVE = np.zeros((12, 3))


def set_in(made: Gltf, path: tuple[Any, ...], value: Any) -> None:
    """Replace one value of a document; the path leads to it."""
    at: Any = made.document
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("nodes",), [], "nodes: expected one or more, got none"),
        (("nodes",), {}, "nodes: expected an array, got 0 entries"),
        (("nodes", 1), 5, r"nodes\[1\]: expected an object, got 5"),
        (("nodes", 1, "scale"), [1, 1], "node.scale: expected 3 numbers"),
        (("nodes", 1, "scale"), [1, 1, True], "node.scale: expected 3 numbers"),
        (("nodes", 1, "scale"), [1, 1, 10**400], "scale: expected 3 numbers, got one .* too large"),
        (("nodes", 1, "matrix"), [1] * 15, "'base'.matrix: expected 16 numbers"),
        (("asset",), [], "asset: expected an object"),
        (("asset", "version"), 2.0, "asset.version: expected a string, got 2.0"),
        (("skins", 0, "inverseBindMatrices"), -1, "inverseBindMatrices: expected a whole number"),
        (("accessors", 0, "count"), 1, "inverseBindMatrices: expected 2 matrices"),
        ((*PART, "mode"), 7, "mode: expected a whole number from 0 to 6, got 7"),
        ((*PART, "indices"), 1, r"type: expected SCALAR, got VEC3"),
        ((*PART, "extensions"), 3, r"meshes\[0\].extensions: expected an object"),
        ((*PART, "material"), 0, "material: expected a whole number from 0 to -1"),
        (("bufferViews", 1, "byteStride"), 2, "byteStride: expected a whole number from 12 to 252"),
        (("animations", 0, "channels"), [1], "channels: expected objects with a target, got 1"),
        (("animations", 0, "channels", 0, "sampler"), 9, "sampler: expected a whole number"),
        (("animations", 0), 0, r"animations\[0\]: expected an object"),
    ],
)
def test_values_that_are_none_of_the_format_are_refused(
    write: Write, path: tuple[Any, ...], value: Any, message: str
) -> None:
    made = samples.gltf_tower()
    set_in(made, path, value)
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.glb", made.glb()))


@pytest.mark.parametrize(
    ("name", "values", "kind", "message"),
    [
        ("NORMAL", TWELVE[:5], "float32", "'tower'.NORMAL: expected 12 values, got 5"),
        ("COLOR_0", np.zeros((5, 4)), "float32", "'tower'.COLOR_0: expected 12 values, got 5"),
        ("TEXCOORD_0", np.zeros((5, 2)), "float32", "TEXCOORD_0: expected 12 values up to 1e6"),
        ("TEXCOORD_0", np.full((12, 2), 1e8), "float32", "TEXCOORD_0: expected 12 values up to"),
        ("POSITION", np.full((12, 3), 1e12), "float32", "POSITION: expected numbers up to 1e9"),
        ("POSITION", np.full((12, 3), 1e8), "float32", "expected vertices within 1e6 m"),
        ("JOINTS_0", np.zeros((12, 4)), "float32", "JOINTS_0: expected integers, got floating"),
        ("JOINTS_0", np.zeros((5, 4)), "uint8", "expected 12 values, got 5"),
        ("WEIGHTS_0", np.zeros((5, 4)), "float32", "WEIGHTS_0: expected 12 values, got 5"),
    ],
)
def test_attributes_that_do_not_fit_the_mesh_are_refused(
    write: Write, name: str, values: np.ndarray, kind: str, message: str
) -> None:
    made = samples.gltf_tower()
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"][name] = made.add(values, kind)
    if name.startswith("TEXCOORD"):
        part["material"] = 0
        pixel = np.frombuffer(_bitmap(), np.uint8)
        made.document |= {
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"bufferView": made.view(pixel)}],
        }
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.glb", made.glb()))


def _bitmap() -> bytes:
    """An image of one white pixel, as a BMP."""
    head = struct.pack("<2sIHHI", b"BM", 58, 0, 0, 54)
    return head + struct.pack("<IiiHHIIiiII", 40, 1, 1, 1, 24, 0, 4, 0, 0, 0, 0) + b"\xff" * 4


def test_a_mesh_with_a_skin_needs_joints(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["meshes"][0]["primitives"][0]["attributes"].pop("JOINTS_0")
    with pytest.raises(FormatError, match="expected JOINTS_0 on a mesh with a skin, got none"):
        read_character(write("bad.glb", made.glb()))


@pytest.mark.parametrize(
    ("keys", "values", "message"),
    [
        ([0.0, 1.0], [[0, 0, 0, 1]] * 3, "rotation: expected 2 keys, got 3"),
        ([0.0, 1.0], [[0, 0, 0, 0]] * 2, "rotation: expected quaternions, got one of length zero"),
        ([0.0, 1e7], [[0, 0, 0, 1]] * 2, "expected increasing seconds up to 1e6"),
        ([0.0, 1.0], [[0, 0, 0, 1e10]] * 2, "rotation: expected finite keys up to 1e9"),
    ],
)
def test_keys_that_do_not_fit_are_refused(
    write: Write, keys: list[float], values: list[list[float]], message: str
) -> None:
    made = samples.gltf_tower()
    samples.animate(made, "bad", made.add(keys), {(2, "rotation"): made.add(values)})
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.glb", made.glb()))


@pytest.mark.parametrize("name", ["inverseBindMatrices", "WEIGHTS_0", "keys", "turns"])
@pytest.mark.parametrize("bits", [0x7FA00000, 0xFFA00001, 0x7FC00000, 0x7F800000])
def test_numbers_that_are_none_are_refused_quietly_whatever_their_bits(
    write: Write, name: str, bits: int
) -> None:
    """A NaN that signals would warn of its cast before any check sees it."""
    made = samples.gltf_tower()
    document = made.document
    number = {
        "inverseBindMatrices": document["skins"][0]["inverseBindMatrices"],
        "WEIGHTS_0": document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"],
        "keys": document["animations"][0]["samplers"][0]["input"],
        "turns": document["animations"][0]["samplers"][0]["output"],
    }[name]
    start = document["bufferViews"][document["accessors"][number]["bufferView"]]["byteOffset"]
    struct.pack_into("<I", made.data, start + 4, bits)
    with pytest.raises(FormatError, match=r"expected (finite|increasing)"):
        read_character(write("signal.glb", made.glb()))


@pytest.mark.parametrize(
    ("rows", "kind", "message"),
    [
        ([1, 1], "uint16", "indices: expected increasing numbers below 12"),
        ([1, 99], "uint16", "indices: expected increasing numbers below 12"),
        ([1, 2], "int16", "indices.componentType: expected unsigned integers"),
    ],
)
def test_sparse_rows_that_are_none_are_refused(
    write: Write, rows: list[int], kind: str, message: str
) -> None:
    made = samples.gltf_tower()
    number = made.document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    made.document["accessors"][number]["sparse"] = {
        "count": 2,
        "indices": {
            "bufferView": made.view(np.array(rows, kind)),
            "componentType": samples.KINDS[kind],
        },
        "values": {"bufferView": made.view(np.zeros((2, 3), np.float32))},
    }
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.glb", made.glb()))


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (b"{", "JSON: expected a document"),
        (b"[]", "document: expected an object"),
        (b'{"asset": {"version": "2.0"}, "buffers": 5}', "buffers: expected an array, got 5"),
        (b"\xff\xfe{}", "JSON: expected a document"),
        (b'{"asset": {"version": NaN}}', "JSON: expected numbers, got NaN"),
        (b'{"a": ' + b"1" * 5000 + b"}", "JSON: "),
    ],
)
def test_texts_that_are_no_documents_are_refused(
    write: Write, document: bytes, message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.gltf", document))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data[:16], "header: expected 20 bytes or more, got 16"),
        (lambda data: data[:4] + struct.pack("<I", 1) + data[8:], "version: expected 2, got 1"),
        (lambda data: data[:8] + struct.pack("<I", 10**9) + data[12:], "length: expected at most"),
        (lambda data: data[:12] + struct.pack("<I", 10**9) + data[16:], "chunk length: expected"),
        (lambda data: data[:16] + b"JUNK" + data[20:], "expected a JSON chunk, got none"),
    ],
)
def test_containers_that_are_cut_or_none_are_refused(
    write: Write, change: Any, message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.glb", change(samples.gltf_tower().glb())))


@pytest.mark.parametrize(
    ("uri", "message"),
    [
        ("data:application/octet-stream,plain", "expected base64 data"),
        ("data:application/octet-stream;base64,!!!", "expected base64 data"),
        ("data:application/octet-stream;base64,AAAA", "byteLength: expected at most 3"),
        ("lost.bin", "'lost.bin': the file is missing"),
        ("a" * 2000, "expected the name of a file beside this one"),
        ("b" * 999, "expected the name of a file|cannot be read"),
        (7, "uri: expected a string"),
    ],
)
def test_buffers_that_cannot_be_had_are_refused(write: Write, uri: Any, message: str) -> None:
    made = samples.gltf_tower()
    document = made.document | {"buffers": [{"byteLength": len(made.data), "uri": uri}]}
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.gltf", json.dumps(document).encode()))


def test_a_buffer_without_bytes_is_refused(write: Write) -> None:
    """Only the first buffer of a `.glb` may be the chunk behind the document."""
    made = samples.gltf_tower()
    document = made.document | {"buffers": [{"byteLength": len(made.data)}]}
    with pytest.raises(FormatError, match="byteLength: expected at most 0, what there is"):
        read_character(write("bad.gltf", json.dumps(document).encode()))


@pytest.mark.parametrize(
    ("name", "limit", "message"),
    [
        ("document.MAX_TEXT_BYTES", 100, "JSON: expected at most 100 bytes"),
        ("document.MAX_FILE_BYTES", 100, "from 0 to 100"),
        ("document.MAX_VALUES", 100, "at most 100 numbers in all, got more"),
        ("animations.MAX_POSES", 1, "expected at most 1 keys in all, got more"),
        ("animations.MAX_CLIPS", 0, "expected at most 0, got 1"),
        ("MAX_VERTICES", 11, "vertices and triangles: expected at most 11"),
        ("animations.MAX_NODES", 3, "nodes: expected at most 3, got 4"),
    ],
)
def test_files_beyond_the_limits_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch, name: str, limit: int, message: str
) -> None:
    """Limits are lowered for the test rather than files made that large."""
    monkeypatch.setattr(f"motorcade.animation.formats.gltf.{name}", limit)
    with pytest.raises(FormatError, match=message):
        read_character(write("large.glb", samples.gltf_tower().glb()))


def test_buffers_that_are_too_large_together_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = samples.gltf_tower()
    size = len(made.data)
    monkeypatch.setattr(document_module, "MAX_FILE_BYTES", size)
    write("tower.bin", bytes(made.data))
    buffers = [{"byteLength": size, "uri": "tower.bin"}] * 3
    document = json.dumps(made.document | {"buffers": buffers}).encode()
    with pytest.raises(FormatError, match=f"buffers: expected at most {2 * size} bytes"):
        read_character(write("large.gltf", document))


def test_an_image_beyond_the_limit_is_not_decoded(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is told, and plain colours stand in."""
    from motorcade.animation.formats import images

    monkeypatch.setattr(images, "MAX_IMAGE_PIXELS", 0)
    made = samples.gltf_tower()
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["TEXCOORD_0"] = made.add(np.zeros((12, 2)))
    part["material"] = 0
    made.document |= {
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": made.view(np.frombuffer(_bitmap(), np.uint8))}],
    }
    told = read_character(write("large.glb", made.glb())).notices
    assert any("expected at most 0 pixels, and" in notice for notice in told)


def test_a_document_in_which_nothing_moves_is_refused(write: Write) -> None:
    made = samples.gltf_tower()
    for name in ("animations", "skins", "meshes"):
        made.document.pop(name)
    made.document["nodes"][3] = {"name": "tower"}
    with pytest.raises(FormatError, match="joints, a skin or an animation, got none"):
        read_motion(write("still.glb", made.glb()))


@pytest.mark.parametrize(
    ("name", "program"),
    [
        ("KHR_texture_basisu", "gltf-transform ktxdecompress IN OUT"),
    ],
)
def test_compression_that_is_not_read_is_refused_with_what_undoes_it(
    write: Write, name: str, program: str
) -> None:
    made = samples.gltf_tower()
    made.document["extensionsRequired"] = [name]
    with pytest.raises(FormatError, match=f"plain data .`{program}` makes it.*got {name}"):
        read_character(write("packed.glb", made.glb()))


def test_documents_of_too_many_entries_are_not_taken_apart(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lists of empty tables, two bytes each, would take thirty times the file's size of memory."""
    monkeypatch.setattr(document_module, "MAX_ENTRIES", 400)
    made = samples.gltf_tower()
    assert len(read_character(write("few.glb", made.glb())).vertices) == 12
    made.document["extras"] = [{}] * 400
    with pytest.raises(FormatError, match="entries of the JSON document: expected at most 400"):
        read_character(write("many.glb", made.glb()))
