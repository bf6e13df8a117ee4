"""Broken recordings: every reader gives a recording or one line of refusal.

Small recordings of every layout, a described folder, ROS bags, a video, TagSLAM's bag and loose
trajectories are made here; one of their files is mutated: bytes, words, lines, paths. Then the
recording is opened, checked, digested, and its first images are read. A file outside the
recording that is named is a fault.
"""

from __future__ import annotations

import bz2
from collections.abc import Callable
from pathlib import Path

import numpy as np

from motorcade.ga import Trajectory
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import read_imu, read_noise
from motorcade.replays.io.readers import gopro
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.readings import read_readings
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory
from tests.end_to_end import loggers
from tests.fuzz.mutations import mutated
from tests.fuzz.runner import Feed
from tests.replays import conftest as layouts
from tests.replays.readers import test_gopro, test_ros_recordings, test_tagslam

__all__ = ["Samples", "ended", "expect_inside", "look", "opened", "prepare"]

LONGEST = 700
SECRET = "secret.png"
TRUTH = "state_groundtruth_estimate0/data.csv"
PATHS = [
    f"../{SECRET}",
    f"images/../../{SECRET}",
    "/etc/passwd",
    "..",
    ".",
    "",
    "/dev/zero",
    "a\0b",
    "\\\\host\\share",
    "x" * 5000,
    "*",
    "**/*",
    "**/**",
    "[",
    "~",
    f"./././../{SECRET}",
]
MANIFEST = """
name = "all of it"
settings = ["fused.gate=0.99"]
[frames]
images = "images/*.jpg"
rate_hz = 25.0
[camera]
model = "radtan"
fx = 20.0
fy = 20.0
cx = 11.5
cy = 7.5
distortion = [-0.28, 0.07, 0.0002, 0.00002]
[board]
type = "checkerboard"
columns = 4
rows = 3
square_m = 0.04
[markers]
family = "tag36h11"
side_m = 0.08
[truth]
file = "poses.txt"
format = "matrix4"
convention = "world_T_camera"
board_frame = "opencv"
[imu]
file = "imu.csv"
noise_file = "imu.yaml"
clock_offset_s = 0.01
imu_T_camera = [[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0]]
"""
TEXTS = (".csv", ".txt", ".yaml", ".toml", ".tum", ".bag", ".mcap", ".db3", ".bz2", ".gpmf")

Reader = Callable[[Path], None]


class Samples:
    """The recordings, made once in a folder: what opens each, its root, and its files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        layouts.write_images(folder, [SECRET])
        self.made: list[tuple[Reader, Path]] = []
        for name in layouts.MAKERS:
            self.made.append((opened, layouts.MAKERS[name](_new(folder / name)).root))
        euroc, described = folder / "euroc" / "mav0", folder / "folder"
        (described / "motorcade.toml").write_text(MANIFEST)
        imu = (euroc / "imu0" / "data.csv").read_text().replace("14037152732", "0")
        (described / "imu.csv").write_text(imu)
        (described / "imu.yaml").write_bytes((euroc / "imu0" / "sensor.yaml").read_bytes())
        self.made.append((opened, described))
        for kind in test_ros_recordings.KINDS:
            path = test_ros_recordings.write_bag(folder / f"ros_{kind}", kind)
            self.made.append((opened, path))
        self.made.append((opened, _tagslam(_new(folder / "tagslam"))))
        video = layouts.video_file.__wrapped__(_new(folder / "video"))
        self.made.append((opened, video))
        short = loggers.draw(np.random.default_rng(1), 2.0)
        for kind, write in loggers.KINDS.items():
            self.made.append((_readings, write(_new(folder / f"log_{kind}"), short)))
        loose = _new(folder / "loose")
        truth = folder / "tum_rgbd" / "groundtruth.txt"
        for name, reader, content in (
            ("path.tum", _trajectory, truth.read_bytes()),
            (
                "path.csv",
                _trajectory,
                (euroc / "state_groundtruth_estimate0/data.csv").read_bytes(),
            ),
            ("path.kitti.txt", _kitti, (folder / "kitti" / "poses.txt").read_bytes()),
            ("imu.csv", _imu, (euroc / "imu0" / "data.csv").read_bytes()),
            ("imu.yaml", _noise, (euroc / "imu0" / "sensor.yaml").read_bytes()),
            ("packet.gpmf", _telemetry, test_gopro.packet(np.ones((8, 3)), np.ones((8, 3)))),
        ):
            (loose / name).write_bytes(content)
            self.made.append((reader, loose / name))

    def broken(self, rng: np.random.Generator) -> tuple[Reader, Path, Path, bytes]:
        """Mutate one file: what to call, with what, which file, and what stood in it."""
        reader, root = self.made[int(rng.integers(len(self.made)))]
        files = [root] if root.is_file() else sorted(p for p in root.rglob("*") if p.is_file())
        written = [path for path in files if path.suffix in TEXTS]
        if written and rng.random() < 0.8:
            files = written
        path = files[int(rng.integers(len(files)))]
        whole = path.read_bytes()
        path.write_bytes(_changed(path, whole, rng))
        return reader, root, path, whole


def prepare(folder: Path) -> Feed:
    """Recordings of every layout, one file mutated, opened."""
    samples = Samples(folder)
    whole: dict[Path, bytes] = {}

    def feed(rng: np.random.Generator) -> str:
        for path, content in whole.items():
            path.write_bytes(content)
        whole.clear()
        reader, root, path, content = samples.broken(rng)
        whole[path] = content
        return ended(reader, root)

    return feed


def ended(reader: Callable[[Path], None], root: Path) -> str:
    """How reading ended; a refusal must be one line of no great length."""
    try:
        reader(root)
    except RecordingError as refused:
        told = str(refused)
        if "\n" in told or len(told) > LONGEST:
            raise AssertionError(f"told in {told[:300]!r}") from refused
        return "refused"
    return "valid"


def _new(folder: Path) -> Path:
    folder.mkdir()
    return folder


def _tagslam(folder: Path) -> Path:
    for name, text in (
        ("cameras.yaml", test_tagslam.CAMERAS),
        ("camera_poses.yaml", test_tagslam.POSES),
        ("tagslam.yaml", test_tagslam.BODIES),
    ):
        (folder / name).write_text(text)
    bag = test_tagslam.packed_bag([(2, [10, 1]), (1, [2]), (3, [])])
    (folder / "tag_detections.bag.bz2").write_bytes(bag)
    return folder


def _changed(path: Path, data: bytes, rng: np.random.Generator) -> bytes:
    if path.suffix == ".bz2" and rng.random() < 0.7:  # else most of them end in the packing
        return bz2.compress(mutated("", bz2.decompress(data), rng))
    kind = rng.random()
    if kind < 0.15:
        return _path_named(data, rng)
    if kind < 0.25:
        return _lines(data, rng)
    return mutated("", data, rng)


def _path_named(data: bytes, rng: np.random.Generator) -> bytes:
    """A word that is or may be a path leads elsewhere."""
    word = PATHS[int(rng.integers(len(PATHS)))].encode()
    words = data.replace(b",", b" , ").replace(b'"', b' " ').split(b" ")
    places = [i for i, one in enumerate(words) if b"." in one or b"/" in one]
    if not places:
        return data
    words[places[int(rng.integers(len(places)))]] = word
    return b" ".join(words).replace(b" , ", b",").replace(b' " ', b'"')


def _lines(data: bytes, rng: np.random.Generator) -> bytes:
    """Lines are swapped, repeated or lost."""
    lines = data.split(b"\n")
    one, other = (int(k) for k in rng.integers(len(lines), size=2))
    kind = rng.random()
    if kind < 0.4:
        lines[one], lines[other] = lines[other], lines[one]
    elif kind < 0.7:
        lines.insert(one, lines[other])
    else:
        del lines[one]
    return b"\n".join(lines)


def opened(root: Path) -> None:
    """Open a recording and look at all that it holds."""
    recording = open_recording(root).intact()
    expect_inside(recording)
    look(recording)


def look(recording: Recording) -> None:
    """Look at all that a recording holds."""
    recording.digest()
    for index in {0, len(recording.frames) - 1}:
        frame = recording.frames[index]
        if recording.layout != "tagslam":
            frame.image(), frame.depth_m(), frame.right()
    if recording.truth is not None:
        _expect_finite(recording.truth)
    if recording.imu is not None and not np.isfinite(recording.imu.specific_force_m_s2).all():
        raise AssertionError("specific force is not finite")


def expect_inside(recording: Recording) -> None:
    """A recording that was opened by its own word names no file outside of it."""
    root = recording.root.resolve()
    if isinstance(recording.frames, ImageFrames):
        frames = recording.frames
        for path in (*frames.files, *filter(None, frames.depth_files), *frames.right_files):
            if not path.resolve().is_relative_to(root):
                raise AssertionError(f"{path} lies outside")


def _expect_finite(path: Trajectory) -> None:
    if not np.isfinite(path.poses.coefficients).all():
        raise AssertionError("poses are not finite")


def _trajectory(path: Path) -> None:
    try:
        _expect_finite(read_trajectory(path))
    except ValueError as fault:
        if isinstance(fault, RecordingError) or "only KITTI" in str(fault):
            raise
        if "KITTI files hold no stamps" not in str(fault):
            raise


def _kitti(path: Path) -> None:
    _expect_finite(read_trajectory(path, "kitti", rate_hz=10.0))


def _readings(path: Path) -> None:
    if not np.isfinite(read_readings(path).imu.specific_force_m_s2).all():
        raise AssertionError("specific force is not finite")


def _imu(path: Path) -> None:
    read_imu(path)


def _noise(path: Path) -> None:
    read_noise(path)


def _telemetry(path: Path) -> None:
    found = gopro._sensors(path.read_bytes(), path)
    if not all(np.isfinite(values).all() for values in found.values()):
        raise AssertionError("telemetry is not finite")
