"""Bags, MCAP, MP4 and GPMF taken apart into records, and put together again.

A record has a head, a body, and records within; its lengths are written anew, so that a fault in
one place does not touch the rest, unless they are meant to be wrong.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tests.fuzz.mutations import one_of

__all__ = [
    "Record",
    "changed",
    "join_bag",
    "join_mcap",
    "join_mp4",
    "split_bag",
    "split_mcap",
    "split_mp4",
]

INTEGERS = (0, 1, 2, 7, 255, 65_535, 2**31 - 1, 2**31, 2**32 - 1, 2**62, 2**63, 2**64 - 1)
MP4_FOLDERS = (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"edts", b"udta", b"mvex", b"moof")


@dataclass
class Record:
    """A record: its kind, what stands in it, what lies in it, and by how much its length lies."""

    kind: bytes
    body: bytes
    inside: list[Record] = field(default_factory=list)
    nested: bool = False
    lie: int = 0

    def every(self) -> Iterator[tuple[list[Record], int]]:
        """All records within, as places in lists."""
        for index, one in enumerate(self.inside):
            yield self.inside, index
            yield from one.every()


def changed(root: Record, rng: np.random.Generator) -> None:
    """Put one to three faults into records, in place."""
    for _ in range(int(rng.choice([1, 2, 3], p=[0.6, 0.25, 0.15]))):
        places = list(root.every())
        if not places:
            return
        holder, index = one_of(places, rng)
        one, kind = holder[index], rng.random()
        if kind < 0.1:
            del holder[index]
        elif kind < 0.2:
            holder.insert(index, holder[int(rng.integers(len(holder)))])
        elif kind < 0.28:
            other = int(rng.integers(len(holder)))
            holder[index], holder[other] = holder[other], holder[index]
        elif kind < 0.34:
            holder.extend([one] * int(rng.integers(1, 200)))
        elif kind < 0.42:
            one.lie = int(one_of([-1, 1, -4, 8, 2**20, 2**31 - 1, -(2**31)], rng))
        elif kind < 0.47:
            one.kind = bytes(rng.integers(0, 256, len(one.kind), dtype=np.uint8))
        else:
            one.body = _body(one.body, rng)


def _body(body: bytes, rng: np.random.Generator) -> bytes:
    """Another integer somewhere, one byte, less or more of it."""
    made, kind = bytearray(body), rng.random()
    if kind < 0.7 and len(made) >= 4:
        size = int(one_of([2, 4, 4, 8], rng))
        at = min(int(rng.integers(min(len(made), 400))), max(len(made) - size, 0))
        value = int(one_of(INTEGERS, rng)) % (1 << (8 * size))
        made[at : at + size] = value.to_bytes(size, "little" if rng.random() < 0.6 else "big")
    elif kind < 0.85 and made:
        made[int(rng.integers(len(made)))] = int(rng.integers(256))
    elif kind < 0.95:
        del made[int(rng.integers(len(made) + 1)) :]
    else:
        made += rng.bytes(int(rng.integers(1, 40)))
    return bytes(made)


def _length(one: Record, size: int, most: int) -> int:
    return max(0, min(size + one.lie, most))


# ROS 1: a length and a head of fields, a length and a body; chunks hold records.


def split_bag(data: bytes) -> Record:
    """The records of a bag."""
    root = Record(b"", b"#ROSBAG V2.0\n", nested=True)
    root.inside = _split_bag_records(data[13:])
    return root


def _split_bag_records(data: bytes) -> list[Record]:
    found, at = [], 0
    while at + 8 <= len(data):
        (size,) = struct.unpack_from("<I", data, at)
        head = data[at + 4 : at + 4 + size]
        at += 4 + size
        (size,) = struct.unpack_from("<I", data, at)
        body = data[at + 4 : at + 4 + size]
        at += 4 + size
        one = Record(b"", head)
        chunk = b"op=\x05" in head
        one.inside = _split_bag_records(body) if chunk else [Record(b"", body, nested=False)]
        one.nested = chunk
        found.append(one)
    return found


def join_bag(root: Record) -> bytes:
    """The bag, with the places of its chunks and of its index as they now are."""
    made, chunks, index = bytearray(root.body), [], None
    for one in root.inside:
        if b"op=\x05" in one.body:
            chunks.append(len(made))
        elif b"op=\x07" in one.body and index is None:
            index = len(made)
        head = one.body
        if b"chunk_pos=" in head and chunks:
            at = head.index(b"chunk_pos=") + 10
            head = head[:at] + struct.pack("<Q", chunks.pop(0)) + head[at + 8 :]
        made += _bag_record(Record(one.kind, head, one.inside, one.nested, one.lie))
    at = made.find(b"index_pos=")
    if at > 0 and index is not None:
        made[at + 10 : at + 18] = struct.pack("<Q", index)
    return bytes(made)


def _bag_record(one: Record) -> bytes:
    body = b"".join(_bag_record(part) if one.nested else part.body for part in one.inside)
    head = struct.pack("<I", len(one.body)) + one.body
    return head + struct.pack("<I", _length(one, len(body), 2**32 - 1)) + body


# MCAP: an operation, a length and a body; chunks (6) hold records behind 40 bytes of their own.


def split_mcap(data: bytes) -> Record:
    """The records of an MCAP file."""
    root = Record(b"", data[:8], nested=True)
    root.inside = _split_mcap_records(data[8:-8])
    return root


def _split_mcap_records(data: bytes) -> list[Record]:
    found, at = [], 0
    while at + 9 <= len(data):
        (size,) = struct.unpack_from("<Q", data, at + 1)
        body = data[at + 9 : at + 9 + size]
        one = Record(data[at : at + 1], body)
        if one.kind == b"\x06" and body[28:32] == bytes(4):  # not compressed
            one.body, one.inside, one.nested = body[:40], _split_mcap_records(body[40:]), True
        found.append(one)
        at += 9 + size
    return found


def join_mcap(root: Record) -> bytes:
    """The file, its chunks' sizes and the summary's place as they now are."""
    made, summary = bytearray(root.body), 0
    for one in root.inside:
        if not summary and made[-13:-12] != b"\x0f" and one.kind == b"\x0f":
            summary = len(made) + 13
        if one.kind == b"\x02" and summary and len(one.body) == 20:
            one = Record(one.kind, struct.pack("<Q", summary) + bytes(12), lie=one.lie)
        made += _mcap_record(one)
    return bytes(made + root.body)


def _mcap_record(one: Record) -> bytes:
    inside = b"".join(map(_mcap_record, one.inside))
    body = one.body
    if one.nested and len(body) == 40:
        size = struct.pack("<Q", len(inside))
        body = body[:16] + size + bytes(8) + size
    length = _length(one, len(body) + len(inside), 2**64 - 1)
    return one.kind[:1] + struct.pack("<Q", length) + body + inside


# MP4: a length, four letters and a body; some boxes hold boxes.


def split_mp4(data: bytes) -> Record:
    """The boxes of an MP4 file."""
    root = Record(b"", b"", nested=True)
    root.inside = _split_boxes(data)
    return root


def _split_boxes(data: bytes) -> list[Record]:
    found, at = [], 0
    while at + 8 <= len(data):
        (size,) = struct.unpack_from(">I", data, at)
        one = Record(data[at + 4 : at + 8], data[at + 8 : at + size])
        if one.kind in MP4_FOLDERS:
            one.inside, one.body = _split_boxes(one.body), b""
        found.append(one)
        at += max(size, 8)
    return found


def join_mp4(root: Record) -> bytes:
    """The file; samples stay where `stco` says only while no box before them changes its size."""
    return b"".join(map(_box, root.inside))


def _box(one: Record) -> bytes:
    body = one.body + b"".join(map(_box, one.inside))
    return struct.pack(">I", _length(one, len(body) + 8, 2**32 - 1)) + one.kind[:4] + body
