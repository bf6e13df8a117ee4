"""ROS 1 and ROS 2 bags (`.bag`, `.mcap`, `.db3`, folders) as recordings: images, depth and IMU.

The topic that is named is read (`BAG:/topic`); where none is, the first by name of colour, else of
grey images; others are named in the log. Depth on the same pixels (of the same frame of axes) comes
beside it. The camera comes from a Kalibr chain beside the bag (`kalibr_imucam_chain.yaml`), which
also says where it sits on the IMU, or else from the bag's own `camera_info` (REP 104): K and D of
the lens, or P of rectified images, less the region of interest and binned. Stamps are those of the
messages' headers, or else times of receipt (`frames`). A folder of one bag and a chain, as OpenVINS
keeps them, is read as that bag. Message definitions that a bag brings along are never used.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.imu.screening import screen_imu
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import did_you_mean, one_line
from motorcade.replays.io.files import refusal, refusing
from motorcade.replays.io.imu import join_sensors, read_noise
from motorcade.replays.io.readers import kalibr
from motorcade.replays.io.readers.calibration import make_camera, yaml_model
from motorcade.replays.io.readers.ros.frames import (
    IMAGE_TYPES,
    BagFrames,
    ImageTopic,
    Stamps,
    choose_stamps,
    depth_beside,
)
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.recording import Recording
from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")
IMU_TYPE = "sensor_msgs/msg/Imu"
FIELD_TYPE = "sensor_msgs/msg/MagneticField"
CAMERA_INFO_TYPE = "sensor_msgs/msg/CameraInfo"
SUFFIXES = (".bag", ".mcap", ".db3")
_MOST_SAMPLES = 20_000_000
_TRANSPORTS = ("compressed", "compressedDepth")


def recognise(root: Path) -> bool:
    """Whether this is a bag's file, a ROS 2 bag's folder, or a folder of a bag and a chain."""
    if root.is_file():
        return root.suffix.lower() in SUFFIXES
    return (root / "metadata.yaml").is_file() or bool(_bags_with_chain(root))


def _bags_with_chain(folder: Path) -> list[Path]:
    """The bags of a folder that holds a chain besides."""
    if not folder.is_dir() or kalibr.find(folder, kalibr.CHAIN_NAMES) is None:
        return []
    files = [
        entry for entry in folder.iterdir() if entry.is_file() and entry.suffix.lower() in SUFFIXES
    ]
    return sorted([*files, *(entry.parent for entry in folder.glob("*/metadata.yaml"))])


def holds_images(path: Path) -> bool:
    """Whether a bag holds images, without which it is no recording.

    Raises:
        RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        return bool(bag.topics(IMAGE_TYPES))


def read(root: Path, *, own_truth: bool = True, topic: str | None = None) -> Recording:
    """Read a bag; images stay in it until they are asked for.

    Raises:
        RecordingError: no bag, damaged, without images or without the topic that is named, or
            with stamps that tell nothing.
    """
    name, folder = root.resolve().stem, root if root.is_dir() else root.parent
    root = _only_bag(root)
    with Bag(root) as bag:
        topics = _image_topics(bag)
        images = _chosen(topics, root, topic)
        depth = depth_beside(images, topics)
        extrinsics = _from_chain(folder, images.name)
        camera, raw_T_rectified = _camera(bag, images, extrinsics)
    size = None if camera is None else (camera.width, camera.height)
    frames = BagFrames(root, images.name, size, None if depth is None else depth.name)
    if frames.stamps.said:
        _LOG.warning("%s, %s: %s", root, one_line(images.name), frames.stamps.said)
    imu = read_bag_imu(root, frames=frames.stamps)
    imu_T_camera = extrinsics.imu_T_camera if extrinsics else None
    if imu_T_camera is not None and raw_T_rectified is not None:
        imu_T_camera = imu_T_camera @ raw_T_rectified
    noise = kalibr.find(folder, kalibr.IMU_NAMES)
    return Recording(
        name=name,
        root=root,
        layout="ros",
        frames=frames,
        camera=camera,
        imu=extrinsics.on_camera_clock(imu) if extrinsics else imu,
        imu_noise=read_noise(noise) if noise is not None and imu is not None else None,
        imu_T_camera=imu_T_camera,
    )


def _only_bag(root: Path) -> Path:
    """The bag itself, where a folder holds it beside a chain."""
    if root.is_file() or (root / "metadata.yaml").is_file():
        return root
    bags = _bags_with_chain(root)
    if len(bags) != 1:
        names = ", ".join(one_line(bag.name) for bag in bags[:6])
        raise refusal(root, f"expected one bag, got {names}", advice="name one of them")
    return bags[0]


def _image_topics(bag: Bag) -> dict[str, ImageTopic]:
    """What each image topic holds that has messages, by name."""
    firsts = (
        (name, next(iter(bag.messages([name], IMAGE_TYPES)), None))
        for name in bag.topics(IMAGE_TYPES)
    )
    return {name: ImageTopic.of(name, first[1]) for name, first in firsts if first is not None}


def _chosen(topics: dict[str, ImageTopic], root: Path, named: str | None) -> ImageTopic:
    """The topic of images: the one named, or the first of colour, or of grey.

    Raises:
        RecordingError: none of that name, depth, or nothing but depth.
    """
    images = {name: entry for name, entry in topics.items() if "depth" not in entry.kind}
    if named is not None:
        chosen = next((name for name in (named, f"/{named}") if name in topics), None)
        if chosen is None:
            problem = f"expected a topic of images, got {one_line(named)}"
            listed = ", ".join(map(one_line, images)) or "none"
            close = did_you_mean(named, tuple(topics))
            raise refusal(root, problem, advice=f"{close}; it has {listed}")
        if chosen not in images:
            problem = f"expected images, got {topics[chosen].kind}"
            raise refusal(root, problem, field=one_line(chosen), advice=_others(images))
        return topics[chosen]
    if not images:
        held = ", ".join(f"{entry.kind} in {one_line(name)}" for name, entry in topics.items())
        problem = f"expected messages of {' or '.join(IMAGE_TYPES)} that are images"
        advice = "`motorcade inspect` lists what it holds"
        raise refusal(root, f"{problem}, got {held or 'none'}", advice=advice)
    ranked = sorted(images.values(), key=lambda entry: (entry.kind != "colour", entry.name))
    if len(ranked) > 1:
        others = ", ".join(one_line(entry.name) for entry in ranked[1:6])
        text = "%s: the image topic is %s, not %s; %s:TOPIC names another"
        _LOG.warning(text, root, one_line(ranked[0].name), others, root)
    return ranked[0]


def _others(images: dict[str, ImageTopic]) -> str:
    return f"name one of {', '.join(map(one_line, images))}" if images else "it holds no others"


def _from_chain(folder: Path, topic: str) -> kalibr.ChainCamera | None:
    """The chain's camera of this topic; `cam0` where it names no topics."""
    path = kalibr.find(folder, kalibr.CHAIN_NAMES)
    if path is None:
        return None
    cameras = kalibr.read_chain(path)
    named = [entry for entry in cameras if entry.topic == topic]
    if not named and any(entry.topic is not None for entry in cameras):
        raise refusal(path, f"expected a camera of the topic {one_line(topic)}, got none")
    return (named or list(cameras))[0]


def _camera(
    bag: Bag, images: ImageTopic, chain: kalibr.ChainCamera | None
) -> tuple[Camera | None, Motor | None]:
    """The camera of the images, and how rectifying has turned it; None: not known, not turned."""
    place, _, last = _without_transport(images.name).rpartition("/")
    rectified = "rect" in last
    if chain is not None and not rectified:
        return chain.camera, None
    info = _info(bag, f"{place}/camera_info", images.frame_id)
    if info is None:
        if rectified and chain is not None:
            text = "%s: images of %s are rectified, and no camera_info says for which camera"
            _LOG.warning(text, bag.path, one_line(images.name))
        return None, None
    return _from_info(bag.path, info, rectified=rectified)


def _without_transport(topic: str) -> str:
    place, _, last = topic.rpartition("/")
    return place if last in _TRANSPORTS else topic


def _info(bag: Bag, beside: str, frame_id: str) -> Any | None:
    """The first camera_info beside the images, or else of the one topic with their frame."""
    topics = bag.topics((CAMERA_INFO_TYPE,))
    names = [beside] if beside in topics else topics
    firsts = [next(iter(bag.messages([name], (CAMERA_INFO_TYPE,))), None) for name in names]
    infos = [first[1] for first in firsts if first is not None]
    if names != [beside]:
        infos = [
            entry for entry in infos if str(entry.header.frame_id).removeprefix("/") == frame_id
        ]
    return infos[0] if len(infos) == 1 else None


def _from_info(path: Path, info: Any, *, rectified: bool) -> tuple[Camera | None, Motor | None]:
    """A camera by REP 104: of the lens (K, D), or of the rectified image (P, and R, how it turned).

    K and P are those of the whole sensor. Images show a region of it, and of so many of its
    pixels one of theirs is made, whose centre is that of them all.
    """
    k, d, r, p = (_numbers(info, letter) for letter in "kdrp")
    matrix = p.reshape(3, 4)[:, :3] if rectified and len(p) == 12 else k.reshape(3, 3)
    if rectified and not matrix[0, 0] > 0.0 and not np.any(d):
        matrix, r = k.reshape(3, 3), np.zeros(0)
    if not matrix[0, 0] > 0.0:
        return None, None  # an uncalibrated camera says so with zeros
    roi = info.roi
    binned = np.array([max(int(info.binning_x), 1), max(int(info.binning_y), 1)])
    region = np.array([roi.width or info.width, roi.height or info.height])
    focal = np.array([matrix[0, 0], matrix[1, 1]]) / binned
    corner = np.array([roi.x_offset, roi.y_offset])
    centre = (np.array([matrix[0, 2], matrix[1, 2]]) - corner + 0.5) / binned - 0.5
    plain = rectified or not np.any(d)
    content = {"distortion_model": info.distortion_model or "none"}
    model = "pinhole" if plain else yaml_model(path, content)
    size = (region // binned).tolist()
    camera = make_camera(
        path, size, (*focal.tolist(), *centre.tolist()), model, () if plain else d.tolist()
    )
    turned = rectified and len(r) == 9 and np.any(r)
    if not turned:
        return camera, None
    rectified_R_raw = Rotor.from_matrix(_nearest_rotation(r.reshape(3, 3), path))
    return camera, Motor.from_rotor_translation(rectified_R_raw.inverse(), np.zeros(3))


def _nearest_rotation(matrix: FloatArray, path: Path) -> FloatArray:
    left, sizes, right = np.linalg.svd(matrix)
    if np.abs(sizes - 1.0).max() > 0.01 or np.linalg.det(matrix) < 0.0:
        raise refusal(path, "expected a rotation, got another matrix", field="camera_info R")
    return np.asarray(left @ right, dtype=np.float64)


def _numbers(info: Any, letter: str) -> FloatArray:
    """A matrix of camera_info, whose name is a small letter in ROS 2."""
    values = getattr(info, letter, None)
    return np.asarray(getattr(info, letter.upper()) if values is None else values, np.float64)


def read_beside_chain(root: Path, topic: str | None = None) -> ImuStream | None:
    """A bag's IMU on the clock of the images, where a chain beside it says how they differ.

    Raises:
        RecordingError: as `read_bag_imu`.
    """
    folder, bag = root if root.is_dir() else root.parent, _only_bag(root)
    path = kalibr.find(folder, kalibr.CHAIN_NAMES)
    imu = read_bag_imu(bag, topic)
    if path is None or topic is not None or not holds_images(bag):
        return imu
    with Bag(bag) as opened:
        images = _chosen(_image_topics(opened), bag, None)
    chain = _from_chain(folder, images.name)
    return chain.on_camera_clock(imu) if chain else imu


def read_bag_imu(
    path: Path, topic: str | None = None, frames: Stamps | None = None
) -> ImuStream | None:
    """Readings of a bag's IMU: of the topic that is named, or the first; None where it has none.

    Accelerometer and gyroscope on topics of their own, as RealSense's driver writes them, are
    joined. Where `frames` are stamped by receipt, so are the readings, but for their spacing.

    Raises:
        RecordingError: damaged, none of the topic that is named, or readings that are no stream.
    """
    with Bag(path) as bag:
        topics = bag.topics((IMU_TYPE,))
        if topic is not None:
            topics = [name for name in topics if name in (topic, f"/{topic}")]
            if not topics:
                listed = ", ".join(map(one_line, bag.topics((IMU_TYPE,)))) or "none"
                raise refusal(path, f"expected one of {listed}, got {one_line(topic)}")
        streams = {name: _readings(bag, name, (IMU_TYPE,), _row, frames) for name in topics}
    streams = {name: entry for name, entry in streams.items() if len(entry[0])}
    if not streams:
        return None
    nothing = {name: np.nan_to_num(rows, nan=1.0) == 0.0 for name, (_, rows) in streams.items()}
    gyros = [name for name, zero in nothing.items() if zero[:, 3:].all()]
    accels = [name for name, zero in nothing.items() if zero[:, :3].all()]
    whole = [name for name in streams if name not in (*gyros, *accels)]
    with refusing(path, one_line(", ".join(streams))):
        if not whole and gyros and accels:
            (gyro_ns, rate), (accel_ns, force) = streams[gyros[0]], streams[accels[0]]
            stream = join_sensors(gyro_ns, rate[:, :3], accel_ns, force[:, 3:])
        else:
            name = _first(whole or list(streams), path, "IMU")
            time_ns, rows = streams[name]
            stream = ImuStream(time_ns, rows[:, :3], rows[:, 3:])
        for notice in screen_imu(stream):
            _LOG.warning("%s: %s", path, notice)
        return stream


def _first(topics: Sequence[str], root: Path, what: str) -> str:
    if len(topics) > 1:
        others = ", ".join(map(one_line, topics[1:6]))
        _LOG.warning("%s: the %s topic is %s, not %s", root, what, one_line(topics[0]), others)
    return topics[0]


def read_bag_field(path: Path) -> tuple[IntArray, FloatArray] | None:
    """Stamps ``(M,)`` and magnetic field ``(M, 3)`` in µT of a bag; None where it has none.

    Raises:
        RecordingError: damaged, or stamps that tell nothing.
    """
    with Bag(path) as bag:
        topics = bag.topics((FIELD_TYPE,))
        if not topics:
            return None
        name = _first(topics, path, "magnetometer's")
        time_ns, tesla = _readings(bag, name, (FIELD_TYPE,), _field, None)
    return time_ns, 1e6 * tesla


def _readings(
    bag: Bag, topic: str, types: Sequence[str], row: Any, frames: Stamps | None
) -> tuple[IntArray, FloatArray]:
    """Stamps ``(N,)`` and numbers ``(N, C)`` of a topic, on the clock of the frames."""
    times, rows = list[tuple[int, int]](), []
    for recorded_ns, time_ns, message in bag.recorded([topic], types):
        times.append((recorded_ns, time_ns))
        rows.append(row(message))
        if len(rows) > _MOST_SAMPLES:
            raise refusal(bag.path, f"expected at most {_MOST_SAMPLES} samples", field=topic)
    values, stamps = np.array(rows, dtype=np.float64), np.array(times, dtype=np.int64)
    if not rows:
        return np.zeros(0, np.int64), np.zeros((0, 6))
    digests = np.array([hash(entry) for entry in map(bytes, values)], dtype=np.int64)
    chosen = choose_stamps(stamps[:, 0], stamps[:, 1], digests)
    if chosen is None:
        problem = "expected header stamps, or times of receipt, that tell readings apart"
        raise refusal(bag.path, f"{problem}, got equal ones", field=one_line(topic))
    if chosen.said:
        _LOG.warning("%s, %s: readings: %s", bag.path, one_line(topic), chosen.said)
    shift_ns = 0
    if frames is not None and frames.by_receipt != chosen.by_receipt:
        shift_ns = chosen.latency_ns if frames.by_receipt else -frames.latency_ns
    return chosen.time_ns + shift_ns, values[chosen.rows]


def _row(message: Any) -> list[float]:
    pair = (message.angular_velocity, message.linear_acceleration)
    return [value for vector in pair for value in (vector.x, vector.y, vector.z)]


def _field(message: Any) -> list[float]:
    field = message.magnetic_field
    return [field.x, field.y, field.z]
