"""Streams of meshoptimizer hold what it packed; what is wrong with them is refused."""

import hashlib
import tracemalloc
from typing import Any

import numpy as np
import pytest

from motorcade.animation import read_character
from motorcade.animation.formats import FormatError
from motorcade.animation.formats.gltf import compression
from motorcade.animation.formats.gltf.compression import unpack_indices, unpack_triangles
from motorcade.animation.formats.gltf.document import open_gltf
from tests.animation.formats import samples
from tests.animation.formats.packed import MESHOPT, add_stream, meshopt_streams, meshopt_tower
from tests.animation.formats.samples import Gltf, Write

STREAMS = meshopt_streams()


def unpacked(write: Write, *streams: dict[str, Any]) -> list[bytes]:
    """What buffers the streams are, where a file's views hold them."""
    made = Gltf()
    for one in streams:
        add_stream(made, one)
    made.others = [{"byteLength": 1 << 20, "extensions": {MESHOPT: {}}}]
    document = open_gltf(write("streams.glb", made.glb()))
    compression.unpack_meshopt(document)
    return document.buffers[2:]


@pytest.mark.parametrize("one", STREAMS, ids=lambda one: f"{one['name']} {one['mode']}")
def test_streams_hold_what_was_packed(write: Write, one: dict[str, Any]) -> None:
    (found,) = unpacked(write, one)
    if one["filter"] == "NONE":
        assert hashlib.sha256(found).hexdigest() == one["sha256"]
    elif one["filter"] == "QUATERNION":  # which it computes in single precision
        far = np.frombuffer(found, "<i2").astype(int) - np.frombuffer(one["plain"], "<i2")
        assert np.abs(far).max() <= 1
    else:
        assert found == one["plain"]


def test_towers_are_plain_ones(write: Write) -> None:
    plain = samples.gltf_tower()
    wanted = read_character(write("plain.glb", plain.glb()))
    found = read_character(write("packed.glb", meshopt_tower().glb()))
    assert found.notices == wanted.notices
    np.testing.assert_array_equal(found.vertices, wanted.vertices)
    rows = [np.roll(one, -one.argmin()).tolist() for one in found.triangles]
    assert sorted(rows) == sorted(np.roll(one, -one.argmin()).tolist() for one in wanted.triangles)


NAMED = {(one["name"], one["mode"]): one for one in STREAMS}
GRID = NAMED["grid 2", "TRIANGLES"]
SMOOTH = NAMED["smooth 1", "ATTRIBUTES"]


@pytest.mark.parametrize(
    ("one", "told"),
    [
        (GRID | {"mode": "POINTS"}, "mode: expected ATTRIBUTES, TRIANGLES or INDICES"),
        (GRID | {"mode": "INDICES"}, "header: expected 0xd1, got 0xe1"),
        (GRID | {"mode": "ATTRIBUTES", "byteStride": 4}, "header: expected 0xa0 or 0xa1"),
        (GRID | {"count": 383}, "a multiple of 3, got 383"),
        (GRID | {"count": 300_000}, "one that is cut off"),
        (GRID | {"count": 0}, "count: expected a whole number from 1"),
        (GRID | {"byteStride": 3}, "expected 2 or 4 bytes and no filter"),
        (GRID | {"filter": "COLOR"}, "expected 2 or 4 bytes and no filter"),
        (GRID | {"packed": GRID["packed"][:40]}, "one that is cut off"),
        (SMOOTH | {"byteStride": 6}, "a multiple of 4, got 6"),
        (SMOOTH | {"byteStride": 512}, "from 1 to 256"),
        (SMOOTH | {"count": 545}, "cut off|bytes before the tail"),
        (SMOOTH | {"count": 40_000}, "cut off|bytes before the tail"),
        (SMOOTH | {"packed": b"\xa1"}, "cut off|bytes before the tail"),
        (SMOOTH | {"packed": SMOOTH["packed"] + b"\0"}, "bytes before the tail"),
        (SMOOTH | {"packed": SMOOTH["packed"][:-4] + b"\3\3\3\3"}, "channel: expected 0 to 2"),
        (SMOOTH | {"filter": "QUATERNION"}, "byteStride of quaternions: expected 8, got 16"),
        (SMOOTH | {"filter": "COLOR"}, "four numbers: expected 4 or 8, got 16"),
        (SMOOTH | {"filter": "WILD"}, "filter: expected NONE, OCTAHEDRAL"),
    ],
)
def test_what_is_no_stream_is_refused(write: Write, one: dict[str, Any], told: str) -> None:
    with pytest.raises(FormatError, match=told):
        unpacked(write, one)


@pytest.mark.parametrize("name", ["OCTAHEDRAL", "COLOR"])
def test_vectors_of_no_length_are_refused(write: Write, name: str) -> None:
    one = NAMED[name, "ATTRIBUTES"]
    with pytest.raises(FormatError, match="above 0"):
        unpacked(write, one | {"packed": nothing(one["count"], one["byteStride"])})


def nothing(count: int, width: int) -> bytes:
    """A stream of zeros, of at most 256 rows."""
    heads = bytes((count + 63) // 64 * width)
    return b"\xa0" + heads + bytes(32)


def test_streams_of_more_than_the_limit_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compression, "MAX_UNPACKED_BYTES", 1000)
    some = {"mode": "ATTRIBUTES", "filter": "NONE", "count": 100, "byteStride": 4}
    some["packed"] = nothing(100, 4)
    assert unpacked(write, some, some) == [bytes(400)] * 2
    with pytest.raises(FormatError, match="at most 1000 bytes in all"):
        unpacked(write, some, some, some)
    with pytest.raises(FormatError, match="a whole number from 1 to 1000"):
        unpacked(write, some | {"count": 1001})


@pytest.mark.parametrize("kind", ["triangles", "indices"])
def test_long_lists_of_corners_take_little_memory(kind: str) -> None:
    count = 300_000
    tracemalloc.start()
    try:
        if kind == "triangles":
            made = unpack_triangles(b"\xe1" + b"\xf0" * (count // 3) + bytes(16), count // 3)
        else:
            made = unpack_indices(b"\xd1" + b"\x04" * count + bytes(4), count)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(made) == count
    assert made.max() > 250_000, "no two are the same object"
    assert peak < 24 * count, "so many bytes a corner"
