"""Bags of ROS 1 and 2, MCAP, MP4 and telemetry with faults in their records.

Records are changed, lost, repeated or swapped, and the file's lengths and offsets are made to fit
again, or to lie; messages hold any sizes; SQLite storage is changed by SQL. Packed giants are among
the chunks.
"""

from __future__ import annotations

import bz2
import copy
import shutil
import sqlite3
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.replays.io.readers import gopro
from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories
from motorcade.replays.io.trajectories import read_trajectory
from tests.fuzz.containers import (
    Record,
    changed,
    join_bag,
    join_mcap,
    join_mp4,
    split_bag,
    split_mcap,
    split_mp4,
)
from tests.fuzz.kinds.recordings import ended, opened
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.runner import Feed
from tests.replays import conftest as layouts
from tests.replays.readers import test_gopro, test_ros_recordings
from tests.replays.readers.bag_poses import write_poses

__all__ = ["prepare"]

SQL_VALUES = (
    "NULL",
    "-1",
    "9223372036854775807",
    "'text'",
    "x'00'",
    "zeroblob(1000)",
    "1e308",
    "''",
)
SQL_COLUMNS = {
    "messages": ("id", "topic_id", "timestamp", "data"),
    "topics": ("id", "name", "type", "serialization_format", "offered_qos_profiles"),
}
SQL_WHOLE = (
    "DROP TABLE messages",
    "DROP TABLE topics",
    "ALTER TABLE messages DROP COLUMN data",
    "ALTER TABLE topics RENAME COLUMN type TO kind",
    "DELETE FROM messages",
    "DELETE FROM topics",
    "INSERT INTO messages SELECT id + 1000, topic_id, timestamp, data FROM messages",
    "UPDATE messages SET timestamp = 0",
    "UPDATE messages SET data = (SELECT data FROM messages LIMIT 1)",
    "DROP TABLE messages; CREATE VIEW messages AS WITH RECURSIVE r(id) AS "
    "(SELECT 1 UNION ALL SELECT id + 1 FROM r) SELECT id, 1 AS topic_id, id AS timestamp, "
    "x'00' AS data FROM r",
)


def prepare(folder: Path) -> Feed:
    """Files of every container, changed by records, opened and looked at."""
    made = {kind: folder / kind for kind in (*test_ros_recordings.KINDS, "video", "given")}
    made["given"].mkdir()
    bag, storage, mcap = (
        test_ros_recordings.write_bag(made[kind], kind) for kind in test_ros_recordings.KINDS
    )
    made["video"].mkdir()
    video = layouts.video_file.__wrapped__(made["video"])
    telemetry = Record(b"", test_gopro.packet(np.ones((8, 3)), np.ones((8, 3))))
    given, poses = made["given"], folder / "poses"
    poses.mkdir()
    bags = split_bag(bag.read_bytes())
    files: list[tuple[Path, Record, Callable[[Record], bytes]]] = [
        (given / "a.bag", bags, join_bag),
        (given / "a.bag", bags, join_bag),
        (given / "a.mcap", split_mcap(mcap.read_bytes()), join_mcap),
        (given / "a.mcap", split_mcap(mcap.read_bytes()), join_mcap),
        (given / "a.mp4", split_mp4(video.read_bytes()), join_mp4),
        (given / "poses.bag", split_bag(write_poses(poses, "bag").read_bytes()), join_bag),
        (given / "poses.mcap", split_mcap(write_poses(poses, "mcap").read_bytes()), join_mcap),
    ]

    def feed(rng: np.random.Generator) -> str:
        kind = rng.random()
        if kind < 0.15:
            return _storage(storage, given / "flight", rng)
        if kind < 0.25:
            body = mutated("", telemetry.body, rng) if kind < 0.2 else _items(telemetry.body, rng)
            return ended(lambda _: _telemetry(body), given)
        path, record, join = one_of(files, rng)
        record = copy.deepcopy(record)
        changed(record, rng)
        data = join(record)
        if path.suffix == ".bag" and rng.random() < 0.02:
            data = _packed(bags, rng)
        path.write_bytes(data)
        return ended(_trajectories if path.stem == "poses" else opened, path)

    return feed


def _trajectories(path: Path) -> None:
    """Read all that a bag says it holds."""
    found = list_bag_trajectories(path)
    str(found)
    for name in (*found.topics, "map/base", "base/map"):
        poses = read_trajectory(f"{path}:{name}").poses
        if not np.isfinite(poses.coefficients).all():
            raise AssertionError(f"{name}: not finite")


def _packed(bag: Record, rng: np.random.Generator) -> bytes:
    """A bag whose first chunk is packed: as it was, or a giant."""
    made = copy.deepcopy(bag)
    chunk = next(one for one in made.inside if b"op=\x05" in one.body)
    plain = join_bag(Record(b"", b"", chunk.inside, True))
    giant = rng.random() < 0.3
    body = bz2.compress(bytes(1 << 26)) * 40 if giant else bz2.compress(plain)
    size = (40 << 26) if giant else len(plain)
    fields = (b"op=\x05", b"compression=bz2", b"size=" + struct.pack("<I", size))
    chunk.body = b"".join(struct.pack("<I", len(one)) + one for one in fields)
    chunk.inside, chunk.nested = [Record(b"", body)], False
    return join_bag(made)


def _items(data: bytes, rng: np.random.Generator) -> bytes:
    """Telemetry with another type, size or count in the head of an item."""
    made = bytearray(data)
    keys = [b"STRM", b"ACCL", b"GYRO", b"SCAL", b"SIUN", b"DEVC", b"STNM"]
    at = made.find(one_of(keys, rng), int(rng.integers(len(made))))
    if at < 0:
        return bytes(made)
    if rng.random() < 0.3:
        made[at : at + 4] = one_of(keys, rng)
    made[at + 4 + int(rng.integers(4))] = int(one_of([0, 1, 255, 115, 102, 63, 6, 2], rng))
    return bytes(made)


def _telemetry(body: bytes) -> None:
    found: dict[bytes, Any] = dict(gopro._sensors(body, Path("a.mp4")))
    if not all(np.isfinite(values).all() for values in found.values()):
        raise AssertionError("telemetry is not finite")


def _storage(whole: Path, given: Path, rng: np.random.Generator) -> str:
    """A folder of SQLite storage, changed by SQL, or its description as text."""
    shutil.rmtree(given, ignore_errors=True)
    shutil.copytree(whole, given)
    if rng.random() < 0.3:
        about = given / "metadata.yaml"
        about.write_bytes(mutated("", about.read_bytes(), rng))
    else:
        base = sqlite3.connect(next(given.glob("*.db3")))
        try:
            for _ in range(int(rng.integers(1, 3))):
                base.executescript(_statement(rng))
        except sqlite3.Error:
            pass
        finally:
            base.close()
    return ended(opened, given)


def _statement(rng: np.random.Generator) -> str:
    if rng.random() < 0.3:
        return str(one_of(SQL_WHOLE, rng))
    table = one_of(list(SQL_COLUMNS), rng)
    column = one_of(SQL_COLUMNS[table], rng)
    some = f"rowid % 7 = {int(rng.integers(7))}" if rng.random() < 0.7 else "1"
    value = one_of(SQL_VALUES, rng)
    if column == "data" and rng.random() < 0.6:
        value = f"substr(data, 1, {int(rng.integers(120))}) || randomblob({int(rng.integers(60))})"
    return f"UPDATE {table} SET {column} = {value} WHERE {some}"
