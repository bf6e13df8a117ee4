"""Archives of arrays: what one would unpack to is told before memory is asked for it."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import archives
from motorcade.ga.archives import load_arrays, read_arrays, save_arrays, save_arrays_in_parts
from motorcade.ga.files import FileError


def member(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    """An array's header, without the array."""
    opened = io.BytesIO()
    content = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(opened, content)
    return opened.getvalue()


def archive(path: Path, content: bytes, method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as made:
        made.writestr("points.npy", content)
    return path


def test_what_was_saved_is_read_also_when_it_was_compressed_since(tmp_path: Path) -> None:
    arrays = {"points": np.arange(6.0).reshape(2, 3), "none": np.zeros((0, 3))}
    save_arrays(tmp_path / "plain.npz", "Points", "points 1", arrays)
    np.savez_compressed(tmp_path / "packed.npz", format=np.array("points 1"), **arrays)
    for name in ("plain.npz", "packed.npz"):
        read = load_arrays(tmp_path / name, "points", "points 1", dict)
        assert {key: value.tolist() for key, value in read.items() if key != "format"} == {
            key: value.tolist() for key, value in arrays.items()
        }


def test_a_bomb_is_refused_before_it_takes_memory(tmp_path: Path) -> None:
    zeros = np.zeros(40 << 20, np.uint8)
    np.savez_compressed(tmp_path / "bomb.npz", points=zeros, more=zeros)
    assert (tmp_path / "bomb.npz").stat().st_size < 1 << 20
    del zeros
    tracemalloc.start()
    try:
        with pytest.raises(FileError, match="expected at most 1000 arrays of 67108864 bytes"):
            read_arrays(tmp_path / "bomb.npz")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1 << 20


def test_a_large_archive_that_is_not_compressed_is_no_bomb(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archives, "MAX_UNPACKED_BYTES", 100)
    points = np.arange(1000.0)
    np.savez(tmp_path / "plain.npz", points=points)
    np.testing.assert_array_equal(read_arrays(tmp_path / "plain.npz")["points"], points)
    np.savez_compressed(tmp_path / "packed.npz", points=np.zeros(1000))
    with pytest.raises(FileError, match="got 1 of 8128"):
        read_arrays(tmp_path / "packed.npz")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (member((10**12,)), "got 128 bytes"),
        (member((10**12,), "<U0"), "got 128 bytes"),
        (member((1,), "<U99999999"), "got 128 bytes"),
        (member((1,), "|O"), "allow_pickle"),
        (b"no array", "magic"),
    ],
    ids=["long", "of nothing", "wide", "objects", "no array"],
)
def test_headers_that_tell_of_more_than_there_is_are_refused(
    tmp_path: Path, content: bytes, told: str
) -> None:
    with pytest.raises(FileError, match=rf"a\.npz: not a file of arrays: .*{told}"):
        read_arrays(archive(tmp_path / "a.npz", content))


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA], ids=["bzip2", "lzma"])
def test_packings_that_do_not_stop_at_a_length_are_refused(tmp_path: Path, method: int) -> None:
    with pytest.raises(FileError, match="expected it stored or deflated"):
        read_arrays(archive(tmp_path / "a.npz", member((0,)), method))


def test_long_directories_are_refused_unread(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "many.npz", "w") as made:
        for number in range(archives.MAX_ARRAYS + 1):
            made.writestr(f"{number}.npy", member((0,)))
    with pytest.raises(FileError, match="got 1001 and"):
        read_arrays(tmp_path / "many.npz")
    whole = archive(tmp_path / "a.npz", member((0,))).read_bytes()
    locator = b"PK\6\7" + bytes(16)
    (tmp_path / "a.npz").write_bytes(whole[:-22] + locator + whole[-22:])
    with pytest.raises(FileError, match="bytes of directory"):
        read_arrays(tmp_path / "a.npz")


def test_a_format_that_is_no_single_text_is_refused_in_one_line(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", format=np.full((9, 3), "points 1"))
    with pytest.raises(FileError, match="expected the format 'points 1', got ") as caught:
        load_arrays(tmp_path / "a.npz", "points", "points 1", dict)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("flags", [1, 1 << 6], ids=["encrypted", "strongly encrypted"])
def test_encrypted_archives_are_refused(tmp_path: Path, flags: int) -> None:
    data = bytearray(archive(tmp_path / "a.npz", member((0,))).read_bytes())
    for magic, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        struct.pack_into("<H", data, data.index(magic) + at, flags)
    (tmp_path / "a.npz").write_bytes(data)
    with pytest.raises(FileError, match="not a file of arrays"):
        read_arrays(tmp_path / "a.npz")


@pytest.mark.parametrize("cuts", [[], [1], [2, 2, 5]])
def test_arrays_in_parts_are_the_bytes_of_whole_ones(tmp_path, cuts):
    """An empty part among them, and columns that are no block of memory."""
    columns = {
        "stamps": np.arange(7) * 10**17,
        "points": np.asfortranarray(np.random.default_rng(0).normal(size=(7, 3))),
    }
    save_arrays(
        tmp_path / "whole.npz",
        "Points",
        "points 1",
        {name: np.ascontiguousarray(values) for name, values in columns.items()},
    )
    edges = [0, *cuts, 7]
    parts = ({name: values[a:b] for name, values in columns.items()} for a, b in pairwise(edges))
    save_arrays_in_parts(tmp_path / "parts.npz", "Points", "points 1", parts)
    assert (tmp_path / "parts.npz").read_bytes() == (tmp_path / "whole.npz").read_bytes()
    with pytest.raises(ValueError, match=r"expected a name ending in \.npz"):
        save_arrays_in_parts(tmp_path / "parts.zip", "Points", "points 1", [])
