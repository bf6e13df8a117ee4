"""TagSLAM's recordings: marker corners of one or several cameras instead of pictures.

A folder with `tag_detections.bag` (or `.bag.bz2`), `cameras.yaml`, `camera_poses.yaml` and
`tagslam.yaml`; `reference` reads the `reference.bag` beside them. Recorded corners run
(-,-) (+,-) (+,+) (-,+) in the tag's frame with z out of its face, counter-clockwise from the
printed bottom-left one; they are turned round here. No picture tells whether the detector's "top"
is the print's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.replays.errors import one_line, refusal
from motorcade.replays.readers.calibration import make_camera, read_yaml, yaml_floats
from motorcade.replays.readers.ros.bag import read_bag
from motorcade.replays.readers.ros.reader import header_stamp_ns
from motorcade.replays.readers.tagslam.bodies import MarkerSides, read_marker_sides
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream

_TAGS = "apriltag_msgs/msg/ApriltagArrayStamped"
_MODELS = {"radtan": "radtan", "plumb_bob": "radtan", "equidistant": "equidistant"}
_MOST_CAMERAS = 64
_MOST_A_FRAME = 1000
_MOST_TAGS = 1_000_000
_HOUSE_ORDER = [3, 2, 1, 0]


@dataclass(frozen=True, eq=False)
class TagSlamRecording:
    """Corners that the cameras of a rig saw, and what is known of rig and tags beforehand.

    Args:
        root: the folder.
        streams: by the name of the camera, in the file's order. Tags that `tagslam.yaml` gives no
            size are left out.
        rig_T_camera: of the cameras whose pose `camera_poses.yaml` holds.
        side_m: side of the black square of each tag that was seen.
    """

    root: Path
    streams: Mapping[str, CornerStream]
    rig_T_camera: Mapping[str, Motor]
    side_m: Mapping[int, float]


def recognise(root: Path) -> bool:
    """Whether this is a folder of recorded tags."""
    names = ("tag_detections.bag", "tag_detections.bag.bz2")
    return any((root / name).is_file() for name in names)


def read(root: Path) -> TagSlamRecording:
    """Read corners and calibration; the reference is left alone.

    Raises:
        RecordingError: a file that is missing, too large, damaged or does not fit; a camera
            without messages; corners or stamps that are no numbers, or an id twice in a frame.
    """
    cameras = _cameras(root / "cameras.yaml")
    sides = read_marker_sides(root / "tagslam.yaml")
    path = bag_file(root, "tag_detections")
    topics = {topic: name for name, (_, topic) in cameras.items()}
    frames: dict[str, list[tuple[int, Sequence[Any]]]] = {name: [] for name in cameras}
    total = 0
    for topic, _, message in read_bag(path, (_TAGS,)):
        if topic not in topics:
            continue
        count = len(message.apriltags)
        total += count
        if count > _MOST_A_FRAME or total > _MOST_TAGS:
            problem = f"expected at most {_MOST_A_FRAME} tags a frame and {_MOST_TAGS} in all"
            raise refusal(path, problem, field=one_line(topic))
        frames[topics[topic]].append((header_stamp_ns(message), message.apriltags))
    streams = {}
    for name, (camera, topic) in cameras.items():
        if not frames[name]:
            raise refusal(path, f"expected messages on {one_line(topic)}, got none", field=name)
        try:
            streams[name] = _stream(camera, frames[name], sides)
        except ValueError as fault:
            raise refusal(path, str(fault), field=one_line(topic)) from fault
    seen = np.unique(np.concatenate([one.marker_ids for one in streams.values()]))
    side_m = {int(marker): sides.side_m(int(marker)) for marker in seen}
    known = {marker: side for marker, side in side_m.items() if side is not None}
    return TagSlamRecording(root, streams, _camera_poses(root / "camera_poses.yaml"), known)


def bag_file(root: Path, name: str) -> Path:
    """The bag of that name in the folder, plain or packed.

    Raises:
        RecordingError: neither is there.
    """
    for path in (root / f"{name}.bag", root / f"{name}.bag.bz2"):
        if path.is_file():
            return path
    raise refusal(root, f"expected {name}.bag or {name}.bag.bz2, got neither")


def _stream(
    camera: Camera, frames: Sequence[tuple[int, Sequence[Any]]], sides: MarkerSides
) -> CornerStream:
    """All detections of one camera, in the order of their stamps; sorted by id in a frame."""
    ordered = sorted(frames, key=lambda one: one[0])
    rows, ids, corners = [], [], []
    for row, (_, tags) in enumerate(ordered):
        for tag in sorted(tags, key=lambda one: int(one.id)):
            if sides.side_m(int(tag.id)) is not None:
                rows.append(row)
                ids.append(int(tag.id))
                corners.append([(corner.x, corner.y) for corner in tag.corners])
    return CornerStream(
        camera=camera,
        time_ns=np.array([time_ns for time_ns, _ in ordered]),
        frame=np.array(rows, np.int64),
        marker_ids=np.array(ids, np.int64),
        corners_px=np.array(corners, np.float64).reshape(-1, 4, 2)[:, _HOUSE_ORDER],
    )


def _cameras(path: Path) -> dict[str, tuple[Camera, str]]:
    """Camera and topic by name, from TagSLAM's (Kalibr's) `cameras.yaml`."""
    cameras = {}
    for name, entry in read_yaml(path).items():
        if not isinstance(entry, dict):
            raise refusal(path, f"expected a table, got {one_line(entry)}", field=one_line(name))
        model = _MODELS.get(str(entry.get("distortion_model")))
        if entry.get("camera_model") != "pinhole" or model is None:
            given = f"{entry.get('camera_model')}, {entry.get('distortion_model')}"
            problem = f"expected a pinhole with {', '.join(_MODELS)}, got {one_line(given)}"
            raise refusal(path, problem, field=one_line(name))
        size = yaml_floats(path, entry, "resolution", 2)
        intrinsics = yaml_floats(path, entry, "intrinsics", 4)
        coefficients = yaml_floats(path, entry, "distortion_coeffs", None)
        cameras[name] = (
            make_camera(path, size, intrinsics, model, coefficients),
            str(entry.get("tagtopic")),
        )
    if not 0 < len(cameras) <= _MOST_CAMERAS:
        raise refusal(path, f"expected 1 to {_MOST_CAMERAS} cameras, got {len(cameras)}")
    return cameras


def _camera_poses(path: Path) -> dict[str, Motor]:
    """Poses on the rig by camera name; rotations are rotation vectors, radians."""
    poses = {}
    for name, entry in read_yaml(path).items():
        pose = entry.get("pose") if isinstance(entry, dict) else None
        parts = []
        for part in ("position", "rotation"):
            found = pose.get(part) if isinstance(pose, dict) else None
            if not isinstance(found, dict):
                problem = f"expected x, y and z, got {one_line(found)}"
                raise refusal(path, problem, field=f"{one_line(name)}.pose.{part}")
            parts.append(yaml_floats(path, {part: [found.get(one) for one in "xyz"]}, part, 3))
        position, rotation = parts
        poses[name] = Motor.from_rotor_translation(Rotor.from_rotation_vector(rotation), position)
    return poses
