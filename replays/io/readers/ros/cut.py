"""Bags that were cut short are read to their last whole chunk.

A recorder that was killed, or a copy that broke off, leaves a file without the index that stands at
its end. What lies before it is whole: its chunks are found one after another (ROS 1: bag format
2.0; ROS 2: MCAP 1.0), and the index is made of them. A database (.db3) has no such parts.
"""

from __future__ import annotations

import os
import struct
from collections import defaultdict
from collections.abc import Mapping
from io import BytesIO
from typing import Any, BinaryIO

from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag1.reader import (
    Chunk,
    ChunkInfo,
    Header,
    IndexData,
    ReaderError,
    RecordType,
    decompressors,
)
from rosbags.rosbag2 import Reader as Reader2
from rosbags.rosbag2.errors import ReaderError as Reader2Error
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import ChunkInfo as McapChunk
from rosbags.rosbag2.storage_mcap import McapReader

_HEADER_LIMIT = 2**20
_MAGIC = b"\x89MCAP0\r\n"
_CHUNK, _ENDS = 0x06, (0x02, 0x0F)
"""Opcodes of MCAP: a chunk; the footer, and the end of the data."""


def _said(read: int, size: int) -> str:
    return f"cut short: read to its last whole chunk, {read} of {size} bytes"


class CutBagReader(Reader1):
    """A ROS 1 bag; one without an index is read chunk by chunk."""

    cut = ""

    def open(self) -> None:
        """Open it; raises as rosbags does."""
        try:
            super().open()
        except ReaderError as fault:
            with self.path.open("rb") as file:
                if not self._index_is_missing(file):
                    raise
                self._find_chunks(file)
            if not self.chunks:
                raise ReaderError("It is cut short before its first chunk ends.") from fault
            self.bio = self.path.open("rb")

    def _index_is_missing(self, file: BinaryIO) -> bool:
        """Whether the file ends before the index that its header promises, or promises none."""
        size = os.fstat(file.fileno()).st_size
        if file.readline(64) != b"#ROSBAG V2.0\n":
            return False
        head = _next_record(file, size)
        if head is None or head[0].get_uint8("op") != RecordType.BAGHEADER:
            return False
        index = head[0].get_uint64("index_pos")
        file.seek(head[1])
        return index == 0 or index >= size or self._index_is_cut(index, size)

    def _index_is_cut(self, index: int, size: int) -> bool:
        with self.path.open("rb") as file:
            file.seek(index)
            while file.tell() < size:
                record = _next_record(file, size)
                if record is None:
                    return True
                file.seek(record[1])
        return False

    def _find_chunks(self, file: BinaryIO) -> None:
        size, read = os.fstat(file.fileno()).st_size, file.tell()
        indexes: dict[int, list[IndexData]] = defaultdict(list)
        while (record := _next_record(file, size)) is not None:
            header, end = record
            if header.get_uint8("op") == RecordType.CHUNK:
                unpack = decompressors[header.get_string("compression")]
                at = file.tell()
                inner = BytesIO(unpack(file.read(end - at)))
                self._take(read, inner, indexes)
                self.chunks[read] = Chunk(end - at, at, unpack)
            file.seek(end)
            read = end
        self.indexes = {entry.id: sorted(indexes[entry.id]) for entry in self.connections}
        self.connections = [
            entry._replace(msgcount=len(self.indexes[entry.id])) for entry in self.connections
        ]
        self.cut = _said(read, size)

    def _take(self, place: int, inner: BytesIO, indexes: dict[int, list[IndexData]]) -> None:
        """Connections and places of messages of an unpacked chunk."""
        size, counts, times = len(inner.getbuffer()), defaultdict[int, int](int), [0]
        known = {entry.id for entry in self.connections}
        while (start := inner.tell()) < size:
            record = _next_record(inner, size)
            if record is None:
                raise ReaderError("A record of a chunk is cut short.")
            header, end = record
            kind, connection = header.get_uint8("op"), header.get_uint32("conn")
            if kind == RecordType.CONNECTION and connection not in known:
                inner.seek(start)
                self.bio, held = inner, self.bio
                self.connections.append(self.read_connection())
                self.bio = held
                known.add(connection)
            elif kind == RecordType.MSGDATA:
                times.append(header.get_time("time"))
                indexes[connection].append(IndexData(times[-1], place, start))
                counts[connection] += 1
            inner.seek(end)
        span = times[1:] or times
        self.chunk_infos.append(ChunkInfo(place, min(span), max(span) + 1, dict(counts)))


def _next_record(file: BinaryIO, size: int) -> tuple[Header, int] | None:
    """Header and end of the record that comes next, at its data; None: it is not whole."""
    start, head = file.tell(), file.read(4)
    if len(head) < 4:
        return None
    (length,) = struct.unpack("<L", head)
    if length > _HEADER_LIMIT or start + length + 8 > size:
        return None
    header = Header.read(BytesIO(head + file.read(length)))
    (data,) = struct.unpack("<L", file.read(4))
    end = file.tell() + data
    return None if end > size else (header, end)


class _CutMcapReader(McapReader):
    """An MCAP file; one without its footer is read chunk by chunk."""

    cut = ""

    def _open(self) -> None:
        try:
            super()._open()
        except (Reader2Error, AssertionError, OSError):
            if not self.data_start or self.bio is None:
                raise
            self.bio.seek(-len(_MAGIC), os.SEEK_END)
            if self.bio.read() == _MAGIC:
                raise
            self._find_chunks(self.bio)

    def _find_chunks(self, bio: BinaryIO) -> None:
        size, at = bio.seek(0, os.SEEK_END), self.data_start
        chunks = list[McapChunk]()
        while at + 9 <= size:
            bio.seek(at)
            kind, length = struct.unpack("<BQ", bio.read(9))
            if kind in _ENDS or at + 9 + length > size:
                break
            if kind == _CHUNK:
                first, last, unpacked, _, name = struct.unpack("<QQQII", bio.read(32))
                packing = bio.read(min(name, 64)).decode()
                (packed,) = struct.unpack("<Q", bio.read(8))
                sizes = packing, packed, unpacked
                chunks.append(McapChunk(first, last, at, 9 + length, {}, 0, *sizes, {}))
            at += 9 + length
        self.data_end = at
        self.meta_scan()
        counts = self.statistics.channel_message_counts if self.statistics else {}
        if not counts:
            raise Reader2Error("It is cut short before its first chunk ends.")
        every = dict.fromkeys(self.channels, 1)
        self.chunks = [chunk._replace(channel_count=every) for chunk in chunks]
        self.connections = [
            entry._replace(msgcount=counts.get(entry.id, 0)) for entry in self.connections
        ]
        self.cut = _said(at, size)


class _CutDirectoryReader(DirectoryReader):
    STORAGE_PLUGINS: Mapping[str, Any] = {**DirectoryReader.STORAGE_PLUGINS, "mcap": _CutMcapReader}


class McapOrCutReader(Reader2):
    """A ROS 2 bag, file or folder, whose MCAP files may be cut short."""

    STORAGE_PLUGINS: Mapping[str, Any] = {
        **Reader2.STORAGE_PLUGINS,
        "dir": _CutDirectoryReader,
        ".mcap": _CutMcapReader,
    }

    @property
    def cut(self) -> str:
        """What is said of the files that were."""
        files = getattr(self.storage, "storages", [self.storage])
        return "; ".join(filter(None, (getattr(entry, "cut", "") for entry in files)))
