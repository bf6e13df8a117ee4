"""Names that no reader may trip over: pipes, devices, links, folders, sparse and packed giants."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

import numpy as np

from tests.fuzz.images import png

__all__ = ["bomb_npz", "write_hostile"]

SPARSE_BYTES = 3 << 30


def write_hostile(folder: Path) -> tuple[str, ...]:
    """Make them in a folder; returns their names there, and some that lie nowhere."""
    names = []

    def new(name: str) -> Path:
        names.append(name)
        return folder / name

    os.mkfifo(new("pipe.csv"))
    new("zero.txt").symlink_to("/dev/zero")
    new("endless.yaml").symlink_to("endless.yaml")
    new("dangling.tum").symlink_to("nowhere.tum")
    new("folder.png").mkdir()
    new("empty.toml").touch()
    with new("sparse.csv").open("wb") as file:
        file.truncate(SPARSE_BYTES)
    new("huge.png").write_bytes(png(60_000, 60_000, zlib.compress(bytes(1 << 20))))
    new("bomb.npz").write_bytes(bomb_npz())
    new("binary.json").write_bytes(np.random.default_rng(0).bytes(3000))
    outside = ["../secret.png", "/dev/zero", "/etc/passwd", "..", ".", "", "*", "**/*", "a\0b"]
    return (*names, *outside, "x" * 5000, "\ud800", "http://localhost:1/a.mp4", "no such file")


def bomb_npz(name: str = "points", gibibytes: int = 4) -> bytes:
    """An archive of a few MiB with an array of so many GiB, as its directory says.

    Deflate's blocks stand for themselves after a full flush, so one of them is repeated.
    """
    count = gibibytes << 27
    header = np.lib.format.magic(1, 0)
    about = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}"
    about += " " * (63 - (len(header) + 2 + len(about)) % 64) + "\n"
    head = header + struct.pack("<H", len(about)) + about.encode()
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    first = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH)
    block = packer.compress(bytes(1 << 26)) + packer.flush(zlib.Z_FULL_FLUSH)
    body = first + block * (gibibytes << 4) + packer.flush()
    size, file = len(head) + (gibibytes << 30), f"{name}.npy".encode()
    extra = struct.pack("<HHQQ", 1, 16, size, len(body))
    shared = struct.pack("<HHHHIIIHH", 0, 8, 0, 33, 0, 2**32 - 1, 2**32 - 1, len(file), 20)
    local = b"PK\x03\x04" + struct.pack("<H", 45) + shared + file + extra
    entry = b"PK\x01\x02" + struct.pack("<HH", 45, 45) + shared
    entry += struct.pack("<HHHII", 0, 0, 0, 0, 0) + file + extra
    end = struct.pack("<HHHHIIH", 0, 0, 1, 1, len(entry), len(local) + len(body), 0)
    return local + body + entry + b"PK\x05\x06" + end
