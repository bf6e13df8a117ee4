"""Recordings in one container, and their changes: bags, TagSLAM's corners, a GoPro's video."""

from __future__ import annotations

import bz2
import shutil
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Trajectory
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.trajectories import write_trajectory
from tests.bench.data import data_folder
from tests.fuzz.kinds.trajectories import smooth_path
from tests.replays.readers import test_ros_recordings, test_tagslam

TELEMETRY = data_folder() / "replays" / "gopro" / "karma.mp4"
"""Written by a camera: nothing here writes such tracks."""


SEEN = '[truth]\nfile = "{}"\nformat = "tum"\nconvention = "world_T_camera"\n'


def seen_along(path: Path, time_ns: NDArray[np.int64]) -> str:
    """A smooth path of these stamps in a file; the manifest's table that names it."""
    write_trajectory(Trajectory(time_ns, smooth_path(len(time_ns), 0.05).motors), path)
    return SEEN.format(path)


def with_bag(kind: str, folder: Path) -> Path:
    """A bag of ROS with its manifest; gives the file that holds the messages."""
    path = test_ros_recordings.write_bag(folder / kind, kind)
    stamps = test_ros_recordings.START_NS + 50_000_000 * np.arange(test_ros_recordings.COUNT)
    (folder / "given.toml").write_text(seen_along(folder / "seen.tum", stamps))
    return next(path.glob("*.db3")) if path.is_dir() else path


def repainted_message(path: Path) -> None:
    """One value of an image in a bag is another one."""
    pixels = test_ros_recordings.image(3).tobytes()[:24]
    data = path.read_bytes()
    assert pixels in data
    path.write_bytes(data.replace(pixels, bytes([pixels[0] ^ 1]) + pixels[1:], 1))


def with_tagslam(changed: str, folder: Path) -> Path:
    """Corners that TagSLAM recorded; gives the one of its files."""
    made = folder / "tagslam"
    made.mkdir()
    for name, text in (
        ("cameras.yaml", test_tagslam.CAMERAS),
        ("camera_poses.yaml", test_tagslam.POSES),
        ("tagslam.yaml", test_tagslam.BODIES),
    ):
        (made / name).write_text(text)
    seconds = range(1, 7)
    bag = bz2.decompress(test_tagslam.packed_bag([(one, [1, 2]) for one in seconds]))
    (made / "tag_detections.bag").write_bytes(bag)
    stamps = 10**9 * np.array(seconds) + 5
    (folder / "given.toml").write_text(seen_along(folder / "seen.tum", stamps))
    return made / changed


def moved_corner(path: Path) -> None:
    """One coordinate of a corner in TagSLAM's bag is another one."""
    forty = struct.pack("<d", 40.0)
    data = path.read_bytes()
    assert forty in data
    path.write_bytes(data.replace(forty, struct.pack("<d", 41.0), 1))


def with_telemetry(folder: Path) -> Path:
    """A camera's own video with telemetry."""
    clip = folder / "karma.mp4"
    shutil.copy(TELEMETRY, clip)
    frames = open_recording(clip).frames
    stamps = np.array([one.time_ns for one in frames], dtype=np.int64)
    camera = "[camera]\nfov_deg = 88.0\n"
    (folder / "given.toml").write_text(camera + seen_along(folder / "seen.tum", stamps))
    return clip


def turned(path: Path) -> None:
    """One byte of the telemetry's first rate is another one."""
    data = bytearray(path.read_bytes())
    at = data.index(b"GYROs\x06") + 9  # behind the key, the type, the size and the count
    data[at] ^= 1
    path.write_bytes(data)
