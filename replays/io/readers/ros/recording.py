"""ROS 1 and ROS 2 bags (`.bag`, `.mcap`, `.db3`, folders) as recordings: pictures and IMU.

The first image topic by name is read, and the first IMU topic; others are named in the log. The
camera comes from a Kalibr chain beside the bag (`kalibr_imucam_chain.yaml`), which also says where
it sits on the IMU, or else from the bag's own `camera_info`. Stamps are those of the messages'
headers. A folder of one bag and a chain, as OpenVINS keeps them, is read as that bag. Message
definitions that a bag brings along are never used.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.imu import read_noise
from motorcade.replays.io.readers import kalibr
from motorcade.replays.io.readers.calibration import make_camera, yaml_model
from motorcade.replays.io.readers.ros.frames import IMAGE_TYPES, BagFrames
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.recording import Recording
from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")
IMU_TYPE = "sensor_msgs/msg/Imu"
CAMERA_INFO_TYPE = "sensor_msgs/msg/CameraInfo"
_SUFFIXES = (".bag", ".mcap", ".db3")
_MOST_SAMPLES = 20_000_000


def recognise(root: Path) -> bool:
    """Whether this is a bag's file, a ROS 2 bag's folder, or a folder of a bag and a chain."""
    if root.is_file():
        return root.suffix.lower() in _SUFFIXES
    return (root / "metadata.yaml").is_file() or bool(_bags_with_chain(root))


def _bags_with_chain(folder: Path) -> list[Path]:
    """The bags of a folder that holds a chain besides."""
    if not folder.is_dir() or kalibr.find(folder, kalibr.CHAIN_NAMES) is None:
        return []
    files = [one for one in folder.iterdir() if one.is_file() and one.suffix.lower() in _SUFFIXES]
    return sorted([*files, *(one.parent for one in folder.glob("*/metadata.yaml"))])


def holds_pictures(path: Path) -> bool:
    """Whether a bag holds pictures, without which it is no recording.

    Raises:
        RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        return bool(bag.topics(IMAGE_TYPES))


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a bag; pictures stay in it until they are asked for.

    Raises:
        RecordingError: no bag, damaged, without pictures, or with stamps that do not increase.
    """
    name, folder = root.resolve().stem, root if root.is_dir() else root.parent
    if not root.is_file() and not (root / "metadata.yaml").is_file():
        bags = _bags_with_chain(root)
        if len(bags) != 1:
            names = ", ".join(one_line(one.name) for one in bags[:6])
            raise refusal(root, f"expected one bag, got {names}", advice="name one of them")
        root = bags[0]
    with Bag(root) as bag:
        topic = _first(bag.topics(IMAGE_TYPES), root, "image")
        if topic is None:
            raise refusal(
                root,
                f"expected messages of {' or '.join(IMAGE_TYPES)}, got none",
                advice="`motorcade inspect` lists what it holds",
            )
        imu_topic = _first(bag.topics((IMU_TYPE,)), root, "IMU")
        imu = None if imu_topic is None else _imu(bag, imu_topic)
        known = _from_chain(folder, topic)
        camera = known.camera if known else _from_info(bag, topic)
    imu = known.on_camera_clock(imu) if known else imu
    noise = kalibr.find(folder, kalibr.IMU_NAMES)
    return Recording(
        name=name,
        root=root,
        layout="ros",
        frames=BagFrames(root, topic, None if camera is None else (camera.width, camera.height)),
        camera=camera,
        imu=imu,
        imu_noise=read_noise(noise) if noise is not None and imu is not None else None,
        imu_T_camera=known.imu_T_camera if known else None,
    )


def _first(topics: list[str], root: Path, what: str) -> str | None:
    if len(topics) > 1:
        others = ", ".join(map(one_line, topics[1:6]))
        _LOG.warning("%s: the %s topic is %s, not %s", root, what, one_line(topics[0]), others)
    return topics[0] if topics else None


def _from_chain(folder: Path, topic: str) -> kalibr.ChainCamera | None:
    """The chain's camera of this topic; `cam0` where it names no topics."""
    path = kalibr.find(folder, kalibr.CHAIN_NAMES)
    if path is None:
        return None
    cameras = kalibr.read_chain(path)
    named = [one for one in cameras if one.topic == topic]
    if not named and any(one.topic is not None for one in cameras):
        raise refusal(path, f"expected a camera of the topic {one_line(topic)}, got none")
    return (named or list(cameras))[0]


def _from_info(bag: Bag, topic: str) -> Camera | None:
    """The camera of the first `camera_info` beside an image topic."""
    place = topic.removesuffix("/compressed").rpartition("/")[0]
    for _, message in bag.messages([f"{place}/camera_info"], (CAMERA_INFO_TYPE,)):
        content = {"distortion_model": message.distortion_model or "none"}
        k = [float(value) for value in getattr(message, "k", getattr(message, "K", ()))]
        d = [float(value) for value in getattr(message, "d", getattr(message, "D", ()))]
        if len(k) != 9 or not k[0] > 0.0:
            return None  # an uncalibrated camera says so with zeros
        model = yaml_model(bag.path, content) if any(d) else "pinhole"
        size = (message.width, message.height)
        return make_camera(bag.path, size, (k[0], k[4], k[2], k[5]), model, d if any(d) else ())
    return None


def _imu(bag: Bag, topic: str) -> ImuStream:
    stamps, rows = [], []
    for time_ns, message in bag.messages([topic], (IMU_TYPE,)):
        stamps.append(time_ns)
        rows.append(_row(message))
        if len(rows) > _MOST_SAMPLES:
            raise refusal(bag.path, f"expected at most {_MOST_SAMPLES} samples", field=topic)
    values = np.array(rows, dtype=np.float64).reshape(-1, 6)
    try:
        stream = ImuStream(np.array(stamps, dtype=np.int64), values[:, :3], values[:, 3:])
        for notice in screen_imu(stream):
            _LOG.warning("%s: %s", bag.path, notice)
        return stream
    except RecordingError:
        raise
    except ValueError as fault:
        raise refusal(bag.path, str(fault), field=one_line(topic)) from fault


def _row(message: Any) -> list[float]:
    pair = (message.angular_velocity, message.linear_acceleration)
    return [value for one in pair for value in (one.x, one.y, one.z)]
