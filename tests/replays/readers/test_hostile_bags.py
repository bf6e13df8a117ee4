"""Bags that would cost more than they weigh: pipes, bombs, databases that compute."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.ros import admission

IMU = "sensor_msgs/msg/Imu"
IMAGE = "sensor_msgs/msg/Image"


def test_databases_are_looked_at_for_so_long_and_no_longer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "flight.db3"
    with closing(sqlite3.connect(path)) as base:
        base.executescript("".join(f"CREATE TABLE t{k} (id INTEGER);" for k in range(500)))
    admission._admit_database(path)
    monkeypatch.setattr(admission, "SQLITE_LIMIT_S", 0.0)
    with pytest.raises(RecordingError, match="interrupted"):
        admission._admit_database(path)


def fill(writer: Any, stores: Stores) -> None:
    """Three grey images of 16 x 24 pixels, a second apart."""
    store = get_typestore(stores)
    types: Any = store.types
    ros1 = stores is Stores.ROS1_NOETIC
    with writer:
        link = writer.add_connection("/cam", IMAGE, typestore=store)
        for second in range(1, 4):
            stamp = types["builtin_interfaces/msg/Time"](sec=second, nanosec=0)
            seq = {"seq": 0} if ros1 else {}
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **seq)
            data = np.zeros(16 * 24, np.uint8)
            message = types[IMAGE](header, 16, 24, "mono8", 0, 24, data)
            pack = store.serialize_ros1 if ros1 else store.serialize_cdr
            writer.write(link, second * 10**9, pack(message, IMAGE))


def folder_bag(path: Path, plugin: StoragePlugin, mode: CompressionMode | None = None) -> Path:
    writer = Writer2(path, version=9, storage_plugin=plugin)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    fill(writer, Stores.ROS2_HUMBLE)
    return path


def refused(path: Path) -> str:
    with pytest.raises(RecordingError) as caught:
        open_recording(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_chunks_that_are_packed_are_read(tmp_path: Path) -> None:
    path = folder_bag(tmp_path / "flight", StoragePlugin.MCAP, CompressionMode.STORAGE)
    for one in (path, path / "flight.mcap"):
        assert len(open_recording(one).frames) == 3
    for form in Writer1.CompressionFormat:
        writer = Writer1(tmp_path / f"{form.value}.bag")
        writer.set_compression(form)
        fill(writer, Stores.ROS1_NOETIC)
        recording = open_recording(tmp_path / f"{form.value}.bag")
        np.testing.assert_array_equal(recording.frames[2].image(), np.zeros((16, 24)))


def test_chunks_that_unpack_to_too_much_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "CHUNK_LIMIT", 1000)
    path = folder_bag(tmp_path / "flight", StoragePlugin.MCAP, CompressionMode.STORAGE)
    assert "at most 1000 bytes unpacked" in refused(path)
    for form in Writer1.CompressionFormat:
        writer = Writer1(tmp_path / f"{form.value}.bag")
        writer.set_compression(form)
        fill(writer, Stores.ROS1_NOETIC)
        assert "at most 1000 bytes unpacked" in refused(tmp_path / f"{form.value}.bag")


def test_chunks_of_one_time_are_bounded_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = folder_bag(tmp_path / "flight", StoragePlugin.MCAP)
    monkeypatch.setattr(admission, "OVERLAP_LIMIT", 1000)
    assert "expected chunks of at most 1000 bytes at one time, got " in refused(path)
    assert "expected chunks of at most 1000 bytes at one time" in refused(path / "flight.mcap")


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_bags_packed_as_a_whole_are_refused_before_they_are_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: CompressionMode
) -> None:
    monkeypatch.setattr("tempfile.TemporaryDirectory", None)
    path = folder_bag(tmp_path / "flight", StoragePlugin.SQLITE3, mode)
    assert "expected plain storage, got compressed files" in refused(path)


@pytest.mark.parametrize("name", ["metadata.yaml", "flight.db3", "flight.mcap"])
def test_pipes_among_a_bags_files_are_refused(tmp_path: Path, name: str) -> None:
    plugin = StoragePlugin.MCAP if name.endswith("mcap") else StoragePlugin.SQLITE3
    path = folder_bag(tmp_path / "flight", plugin)
    (path / name).unlink()
    os.mkfifo(path / name)
    refused(path)
    if name != "metadata.yaml":
        assert f"{name}: expected a file, got a folder or a device" in refused(path)
        refused(path / name)


def test_names_of_files_are_not_read_as_addresses(tmp_path: Path) -> None:
    path = folder_bag(tmp_path / "flight", StoragePlugin.SQLITE3)
    (path / "flight.db3").rename(path / "a%2Epipe.db3")
    os.mkfifo(path / "a.pipe.db3")
    metadata = path / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("flight.db3", "a%2Epipe.db3"))
    assert "expected a path without ?, # and %" in refused(path)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "ALTER TABLE topics RENAME TO kept; CREATE VIEW topics AS SELECT * FROM kept",
            "expected tables alone, got 'topics'",
        ),
        (
            "ALTER TABLE messages ADD more BLOB AS (zeroblob(500000000))",
            "expected plain columns, got others in 'messages'",
        ),
        ("CREATE VIRTUAL TABLE more USING fts5(a)", "expected "),
    ],
    ids=["view", "computed column", "virtual table"],
)
def test_databases_that_compute_are_refused(tmp_path: Path, change: str, told: str) -> None:
    path = folder_bag(tmp_path / "flight", StoragePlugin.SQLITE3)
    database = sqlite3.connect(path / "flight.db3")
    database.executescript(change)
    database.close()
    assert told in refused(path)
    assert told in refused(path / "flight.db3")


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [1]\nb: *a\n",
        "[" * 5000,
        "rosbag2_bagfile_information: []\n",
        "rosbag2_bagfile_information: {relative_file_paths: 7}\n",
        "\xff",
    ],
)
def test_metadata_that_are_no_plain_names_are_refused(tmp_path: Path, text: str) -> None:
    path = folder_bag(tmp_path / "flight", StoragePlugin.MCAP)
    (path / "metadata.yaml").write_bytes(text.encode("latin-1"))
    assert "metadata.yaml" in refused(path)
