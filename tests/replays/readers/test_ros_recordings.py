"""Bags of ROS 1 and ROS 2, written by rosbags' own writers, come back as they were."""

import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from motorcade.ga import Motor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from tests.fuzz.containers import join_bag, split_bag

START_NS = 1_700_000_000_123_456_789
COUNT, HEIGHT, WIDTH = 6, 16, 24
FORCE = np.random.default_rng(3).standard_normal((40, 3)) + np.array([0.0, 0.0, 9.81])
RATE = np.random.default_rng(4).standard_normal((40, 3))
CHAIN = """
cam0:
  camera_model: pinhole
  distortion_model: equidistant
  distortion_coeffs: [0.01, -0.02, 0.003, -0.0004]
  intrinsics: [20.0, 21.0, 11.5, 7.5]
  resolution: [24, 16]
  rostopic: /cam0/image_raw
  T_cam_imu: {}
"""
KINDS = ("bag", "folder", "mcap")


def image(index: int) -> np.ndarray:
    return np.random.default_rng(index).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)


class Messages:
    """Messages of a version of ROS."""

    def __init__(self, ros1: bool) -> None:
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        self.ros1 = ros1

    def make(self, name: str, **fields: Any) -> Any:
        return self.store.types[name](**fields)

    def header(self, time_ns: int) -> Any:
        stamp = self.make(
            "builtin_interfaces/msg/Time", sec=time_ns // 10**9, nanosec=time_ns % 10**9
        )
        seq = {"seq": 0} if self.ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id="cam", **seq)

    def image(self, time_ns: int, pixels: np.ndarray, encoding: str) -> Any:
        # Two bytes of padding a row, as some drivers leave.
        rows = np.pad(pixels.reshape(HEIGHT, -1), ((0, 0), (0, 2)))
        return self.make(
            "sensor_msgs/msg/Image",
            header=self.header(time_ns),
            height=HEIGHT,
            width=WIDTH,
            encoding=encoding,
            is_bigendian=0,
            step=rows.shape[1],
            data=rows.ravel(),
        )

    def compressed(self, time_ns: int, pixels: np.ndarray) -> Any:
        data = cv2.imencode(".png", pixels[..., ::-1])[1].ravel()
        return self.make(
            "sensor_msgs/msg/CompressedImage",
            header=self.header(time_ns),
            format="png",
            data=data,
        )

    def imu(self, time_ns: int, rate: np.ndarray, force: np.ndarray) -> Any:
        def vector(values: np.ndarray) -> Any:
            x, y, z = values.tolist()
            return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

        return self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(time_ns),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=np.zeros(9),
            angular_velocity=vector(rate),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(force),
            linear_acceleration_covariance=np.zeros(9),
        )


def messages(made: Messages, encoding: str) -> list[tuple[str, str, int, Any]]:
    """Topic, type, stamp and message, the images recorded a little after they were taken."""
    sent: list[tuple[str, str, int, Any]] = []
    for index in range(COUNT):
        stamp = START_NS + 50_000_000 * index
        pixels = image(index)
        if encoding == "png":
            one = made.compressed(stamp, pixels)
            sent.append(("/cam0/image_raw/compressed", one.__msgtype__, stamp + 7, one))
            continue
        stored = {"rgb8": pixels, "bgr8": pixels[..., ::-1], "mono8": pixels[..., 0]}[encoding]
        one = made.image(stamp, stored, encoding)
        sent.append(("/cam0/image_raw", one.__msgtype__, stamp + 7, one))
    for index, (rate, force) in enumerate(zip(RATE, FORCE, strict=True)):
        stamp = START_NS + 5_000_000 * index
        one = made.imu(stamp, rate, force)
        sent.append(("/imu0", one.__msgtype__, stamp, one))
    return sorted(sent, key=lambda entry: entry[2])


def write_bag(folder: Path, kind: str, encoding: str = "rgb8") -> Path:
    """A bag in `folder`; returns what a user would name."""
    made = Messages(kind == "bag")
    folder.mkdir(exist_ok=True)
    path = folder / ("flight.bag" if kind == "bag" else "flight")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer: Any = (
        Writer1(path) if kind == "bag" else Writer2(path, version=9, storage_plugin=plugin)
    )
    pack = made.store.serialize_ros1 if kind == "bag" else made.store.serialize_cdr
    with writer:
        topics: dict[str, Any] = {}
        for topic, name, recorded_ns, message in messages(made, encoding):
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=made.store)
            writer.write(topics[topic], recorded_ns, pack(message, name))
    return next(path.glob("*.mcap")) if kind == "mcap" else path


@pytest.mark.parametrize("kind", KINDS)
def test_images_and_imu_come_back(kind: str, tmp_path: Path) -> None:
    recording = open_recording(write_bag(tmp_path / "bags", kind))
    assert recording.layout == "ros"
    np.testing.assert_array_equal(
        recording.frames.time_ns, START_NS + 50_000_000 * np.arange(COUNT)
    )
    for index in (4, 0, 5, 1):
        np.testing.assert_array_equal(recording.frames[index].image(), image(index))
    assert recording.imu is not None
    np.testing.assert_array_equal(recording.imu.time_ns, START_NS + 5_000_000 * np.arange(40))
    np.testing.assert_array_equal(recording.imu.angular_rate_rad_s, RATE)
    np.testing.assert_array_equal(recording.imu.specific_force_m_s2, FORCE)
    elsewhere = pickle.loads(pickle.dumps(recording.frames))
    np.testing.assert_array_equal(elsewhere[2].image(), image(2))
    recording.check()


@pytest.mark.parametrize("encoding", ["bgr8", "mono8", "png"])
def test_encodings(encoding: str, tmp_path: Path) -> None:
    frames = open_recording(write_bag(tmp_path / "bags", "bag", encoding)).frames
    expected = image(3)[..., 0] if encoding == "mono8" else image(3)
    np.testing.assert_array_equal(frames[3].image(), expected)


def test_a_kalibr_chain_beside_the_bag_gives_camera_and_place(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bags", "bag")
    camera_T_imu = Motor.random(np.random.default_rng(8))
    chain = path.parent / "kalibr_imucam_chain.yaml"
    chain.write_text(CHAIN.format(camera_T_imu.as_matrix().tolist()))
    recording = open_recording(path)
    assert recording.camera is not None
    assert recording.imu_T_camera is not None
    assert (recording.camera.model, recording.camera.fx) == ("equidistant", 20.0)
    together = recording.imu_T_camera @ camera_T_imu
    np.testing.assert_allclose(together.as_matrix(), np.eye(4), atol=1e-12)
    assert open_recording(path.parent).camera == recording.camera
    named = chain.read_text()
    chain.write_text(named.rstrip() + "\n  timeshift_cam_imu: 0.5\n")
    late = open_recording(path)
    assert late.imu is not None
    assert recording.imu is not None
    np.testing.assert_array_equal(late.imu.time_ns, recording.imu.time_ns - 500_000_000)
    chain.write_text(named)
    chain.write_text(chain.read_text().replace("/cam0/image_raw", "/other"))
    with pytest.raises(RecordingError, match="expected a camera of the topic"):
        open_recording(path)


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _noise(path: Path) -> None:
    path.write_bytes(np.random.default_rng(1).bytes(5000))


@pytest.mark.parametrize("damage", [_cut, _noise])
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_damaged_bags_are_refused(
    kind: str, damage: Callable[[Path], None], tmp_path: Path
) -> None:
    path = write_bag(tmp_path / "bags", kind)
    damage(path)
    with pytest.raises(RecordingError, match="expected a whole ROS bag"):
        open_recording(path)


def test_topics_called_by_numbers_are_refused(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bags", "folder")
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("name: /cam0/image_raw", "name: 17"))
    with pytest.raises(RecordingError, match="expected names of topics and types, got '17'"):
        open_recording(path)


def test_two_connections_of_one_number_are_refused(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bags", "bag")
    root = split_bag(path.read_bytes())
    for one in root.inside:
        if b"op=\x07" in one.body:
            one.body = one.body.replace(b"conn=\0\0\0\0", b"conn=\1\0\0\0")
    path.write_bytes(join_bag(root))
    with pytest.raises(RecordingError, match="expected sensor_msgs/msg/Imu, got"):
        open_recording(path)


def test_a_bag_without_images_is_refused(tmp_path: Path, monkeypatch: Any) -> None:
    every = messages
    monkeypatch.setitem(
        globals(), "messages", lambda made, e: [one for one in every(made, e) if "imu" in one[0]]
    )
    with pytest.raises(RecordingError, match="expected messages of sensor_msgs/msg/Image"):
        open_recording(write_bag(tmp_path / "bags", "bag"))


def test_the_content_makes_the_digest_not_the_place(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bags", "bag")
    shutil.copytree(tmp_path / "bags", tmp_path / "moved")
    assert open_recording(path).digest() == open_recording(tmp_path / "moved" / path.name).digest()
