"""What a bag may cost is known before rosbags opens it: its files, and what their chunks unpack to.

rosbags opens whatever a folder's `metadata.yaml` names, unpacks files as a whole before it tells
that they are packed, and unpacks chunks as far as they go. A database is a program of its own: only
plain tables are asked.

Types of ROS messages by their usual definitions, with those that rosbags does not bring along.

The definitions that a bag brings along are never used.

Bags that were cut short are read to their last whole chunk.

A recorder that was killed, or a copy that broke off, leaves a file without the index that stands at
its end. What lies before it is whole: its chunks are found one after another (ROS 1: bag format
2.0; ROS 2: MCAP 1.0), and the index is made of them. A database (.db3) has no such parts.
"""

from __future__ import annotations

import bz2
import os
import sqlite3
import struct
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import closing
from functools import cache
from io import BytesIO
from itertools import accumulate
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, BinaryIO

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

from motorcade.ga.names import one_line
from motorcade.ga.plain_yaml import YamlError, parse_yaml
from motorcade.replays.io.files import admit_file, read_bounded, refusal

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


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


FILE_LIMIT = 1 << 40
METADATA_LIMIT = 1 << 20
SQLITE_LIMIT_S = 10.0
"""What a database holds is said in milliseconds, however long its tables are."""
_SQLITE_STEPS = 1000
CHUNK_LIMIT = 1 << 28
"""Of a chunk, or a message that is packed by itself, unpacked."""
OVERLAP_LIMIT = 1 << 30
"""Of all chunks of an MCAP that hold messages of one time, unpacked."""
PACKED_LIMIT = 2**26
BAG_LIMIT = 2**28
"""Of TagSLAM's bags, and of any bag that is packed as a whole: packed; plain."""


def admit_bag(path: Path) -> None:
    """Check every file that rosbags will open for a bag, a file or a folder.

    Raises:
        RecordingError: what the door refuses (`ga.files`), metadata that are no plain YAML, files
            that are packed as a whole, a database of more than tables.
    """
    for file in _files(path) if path.is_dir() else [path]:
        admit_file(file, FILE_LIMIT)
        if file.suffix == ".db3":
            _admit_database(file)


def _files(folder: Path) -> list[Path]:
    """The files that a folder's metadata name; rosbags takes them from the folder itself."""
    path = folder / "metadata.yaml"
    try:
        content = parse_yaml(read_bounded(path, METADATA_LIMIT).decode("utf-8"))
    except YamlError as fault:
        raise refusal(path, str(fault), line=fault.line) from fault
    except UnicodeDecodeError as fault:
        raise refusal(path, "expected YAML in UTF-8, got other bytes") from fault
    about = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    names = about.get("relative_file_paths") if isinstance(about, dict) else None
    if not isinstance(about, dict) or not isinstance(names, list):
        raise refusal(path, "expected the names of a bag's files, got none")
    if str(about.get("compression_mode") or "none").lower() != "none":
        problem = "expected plain storage, got compressed files"
        raise refusal(folder, problem, advice="`ros2 bag convert` or zstd unpacks them")
    return [folder / PurePath(str(name)).name for name in names]


def _admit_database(path: Path) -> None:
    """Only tables of plain columns: a view or a computed column may take any time and memory."""
    if any(letter in str(path) for letter in "?#%"):
        problem = "expected a path without ?, # and %, which mean something else to SQLite"
        raise refusal(path, problem, advice="rename it")
    try:
        until_s = time.monotonic() + SQLITE_LIMIT_S
        with closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as database:
            database.set_progress_handler(lambda: time.monotonic() > until_s, _SQLITE_STEPS)
            tables = database.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
            for kind, name, sql in tables:
                words = str(sql).upper().split()
                if kind not in ("table", "index") or words[:2] == ["CREATE", "VIRTUAL"]:
                    raise refusal(path, f"expected tables alone, got {one_line(name)}")
                columns = database.execute("SELECT hidden FROM pragma_table_xinfo(?)", (name,))
                if kind == "table" and any(hidden for (hidden,) in columns):
                    raise refusal(path, f"expected plain columns, got others in {one_line(name)}")
    except sqlite3.Error as fault:
        raise refusal(path, f"expected an SQLite database: {one_line(fault, 100)}") from fault


def bound_chunks() -> None:
    """Have rosbags unpack no chunk to more than `CHUNK_LIMIT`, in this process."""
    from lz4.frame import LZ4FrameDecompressor
    from rosbags.rosbag1.reader import decompressors
    from rosbags.rosbag2.storage_mcap import DECOMPRESSORS

    if sys.version_info >= (3, 14):
        from compression.zstd import ZstdDecompressor
    else:
        from backports.zstd import ZstdDecompressor

    unpack_lz4 = _unpacker(LZ4FrameDecompressor)
    unpack_zstd = _unpacker(ZstdDecompressor)
    decompressors.update(bz2=_unpacker(bz2.BZ2Decompressor), lz4=unpack_lz4)
    DECOMPRESSORS.update(lz4=lambda data, _: unpack_lz4(data))
    DECOMPRESSORS.update(zstd=lambda data, _: unpack_zstd(data))


def check_overlaps(reader: Any) -> None:
    """Refuse an MCAP whose chunks lie at the same time and are too large together.

    rosbags unpacks all chunks of a stamp before it gives the first message.

    Raises:
        RecordingError: more than `OVERLAP_LIMIT` bytes.
    """
    storage = getattr(reader, "storage", None)
    for store in getattr(storage, "storages", [storage]):
        chunks = getattr(store, "chunks", [])
        ends = [(chunk.message_end_time, 1, -chunk.uncompressed_size) for chunk in chunks]
        starts = [(chunk.message_start_time, 0, chunk.uncompressed_size) for chunk in chunks]
        at_once = max(accumulate(size for _, _, size in sorted(starts + ends)), default=0)
        if at_once > OVERLAP_LIMIT:
            problem = f"expected chunks of at most {OVERLAP_LIMIT} bytes at one time, got {at_once}"
            raise refusal(reader.path, problem)


def _unpacker(make: Callable[[], Any]) -> Callable[[bytes], bytes]:
    def unpack(data: bytes) -> bytes:
        parts, left = [], CHUNK_LIMIT
        while data:
            storage = make()
            parts.append(storage.decompress(data, max_length=left + 1))
            left -= len(parts[-1])
            if left < 0:
                raise ValueError(f"expected chunks of at most {CHUNK_LIMIT} bytes unpacked")
            if not storage.eof:
                raise ValueError("expected a whole chunk, got one that is cut short")
            data = storage.unused_data or b""
        return b"".join(parts)

    return unpack


_APRILTAG = """
int32 id
string family
int32 hamming
int32 border
int32 bits
geometry_msgs/Point center
geometry_msgs/Point[4] corners
"""
_OF_ROS1 = {
    "apriltag_msgs/msg/Apriltag": _APRILTAG,
    "apriltag_msgs/msg/ApriltagArrayStamped": "std_msgs/Header header\nApriltag[] apriltags\n",
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
}


@cache
def message_types(*, ros1: bool) -> Typestore:
    """The types of ROS 1 Noetic, TagSLAM's and tf's among them, or those of ROS 2 Humble."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name, text in _OF_ROS1.items() if ros1 else ():
        types = get_types_from_msg(text, name)
        store.register({key: value for key, value in types.items() if key not in store.types})
    return store


def plain_bag(path: Path, folder: Path) -> Path:
    """The bag itself, unpacked into `folder` where it is packed with bzip2.

    Raises:
        RecordingError: missing, too large, packed or plain, or damaged.
    """
    if path.suffix != ".bz2":
        admit_file(path, BAG_LIMIT)
        return path
    packed = read_bounded(path, PACKED_LIMIT)
    unpacker = bz2.BZ2Decompressor()
    try:
        content = unpacker.decompress(packed, max_length=BAG_LIMIT + 1)
    except (OSError, ValueError) as fault:
        raise refusal(path, f"expected bzip2: {fault}") from fault
    if len(content) > BAG_LIMIT:
        raise refusal(path, f"expected at most {BAG_LIMIT} bytes unpacked, got more")
    if not unpacker.eof:
        raise refusal(path, "expected a whole bzip2 file, got one that is cut short")
    plain = folder / "recording.bag"
    plain.write_bytes(content)
    return plain
