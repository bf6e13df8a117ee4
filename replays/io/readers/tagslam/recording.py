"""TagSLAM's recordings: corners of markers, odometry, and its own result as reference.

TagSLAM's recordings: marker corners of one or several cameras instead of images.

A folder with `tag_detections.bag` (or `.bag.bz2`), `cameras.yaml`, `camera_poses.yaml` and
`tagslam.yaml`; `reference` reads the `reference.bag` beside them. Recorded corners run
(-,-) (+,-) (+,+) (-,+) in the tag's frame with z out of its face, counter-clockwise from the
printed bottom-left one; they are turned round here. No image tells whether the detector's "top"
is the print's.

TagSLAM's folders as recordings of the pipeline: corners, odometry, its result as reference.

The reference is what TagSLAM itself made of a recording: where rig, cameras and tags were, frame by
frame. From `reference.bag`: the frames that `/tagslam/odom/body_*` has a pose for, with the
transforms of `/tf` at their stamps. Those are TagSLAM's estimates as of that frame, made from the
same corners (and odometry where there was one): they show agreement, not accuracy. Only for
evaluation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import read_bounded, refusal, refusing
from motorcade.replays.io.readers.calibration import make_camera, read_yaml, yaml_floats
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.ros.reader import EmptyBag, header_stamp_ns, read_bag
from motorcade.replays.io.readers.tagslam.scene import (
    MarkerRemap,
    SquashedTags,
    read_remaps,
    read_scene,
    read_squashed,
)
from motorcade.replays.io.recording import Odometry, Recording
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.scenes import BodyOdometry, MarkerScene

_TAGS = "apriltag_msgs/msg/ApriltagArrayStamped"
_MODELS = {"radtan": "radtan", "plumb_bob": "radtan", "equidistant": "equidistant"}
_MOST_CAMERAS = 64
_MOST_A_FRAME = 1000
_MOST_TAGS = 1_000_000
_UNIT = 1e-3
_LONGEST_LINK = 256
ODOMETRY = "nav_msgs/msg/Odometry"
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
        scene: all that was stated, and odometry.
    """

    root: Path
    streams: Mapping[str, CornerStream]
    rig_T_camera: Mapping[str, Motor]
    side_m: Mapping[int, float]
    scene: MarkerScene

    @property
    def odometry(self) -> BodyOdometry | None:
        """Of the first body with odometry; None where there is none."""
        topics = (body.odometry for body in self.scene.bodies)
        return next((one for one in topics if one is not None), None)


def recognise(root: Path) -> bool:
    """Whether this is a folder of recorded tags."""
    names = ("tag_detections.bag", "tag_detections.bag.bz2")
    return any((root / name).is_file() for name in names)


def read_corners(root: Path) -> TagSlamRecording:
    """Read corners and calibration; the reference is left alone.

    Raises:
        RecordingError: a file that is missing, too large, damaged or does not fit; a camera
            without messages; corners or stamps that are no numbers, or an id twice in a frame.
    """
    cameras = _cameras(root / "cameras.yaml")
    path = bag_file(root, "tag_detections")
    remaps = read_remaps(root / "tagslam.yaml")
    squashed = read_squashed(root / "tagslam.yaml")
    topics = {topic: name for name, (_, topic) in cameras.items()}
    frames: dict[str, list[tuple[int, Sequence[Any]]]] = {name: [] for name in cameras}
    odometry: dict[str, dict[int, Motor]] = {}
    total = 0
    for topic, kind, message in read_bag(path, (_TAGS, ODOMETRY)):
        if kind == ODOMETRY:
            pose = message.pose.pose
            poses = odometry.setdefault(topic, {})
            poses[header_stamp_ns(message)] = motor_of(path, pose.position, pose.orientation)
            continue
        if topic not in topics:
            continue
        count = len(message.apriltags)
        total += count
        if count > _MOST_A_FRAME or total > _MOST_TAGS:
            problem = f"expected at most {_MOST_A_FRAME} tags a frame and {_MOST_TAGS} in all"
            raise refusal(path, problem, field=one_line(topic))
        frames[topics[topic]].append((header_stamp_ns(message), message.apriltags))
    scene = read_scene(root, {topic: _path(poses) for topic, poses in odometry.items()})
    streams = {}
    for name, (camera, topic) in cameras.items():
        if not frames[name]:
            raise refusal(path, f"expected messages on {one_line(topic)}, got none", field=name)
        with refusing(path, one_line(topic)):
            streams[name] = _stream(camera, name, frames[name], scene, remaps, squashed)
    seen = np.unique(np.concatenate([one.marker_ids for one in streams.values()]))
    side_m = {int(marker): scene.side_m(int(marker)) for marker in seen}
    known = {marker: side for marker, side in side_m.items() if side is not None}
    rig_T_camera = {name: stated.pose for name, stated in scene.cameras.items() if name in cameras}
    return TagSlamRecording(root, streams, rig_T_camera, known, scene)


def bag_file(root: Path, name: str) -> Path:
    """The bag of that name in the folder, plain or packed.

    Where a checkout left a link as a text with the file's place, it is looked for there, in a
    folder beside this one.

    Raises:
        RecordingError: neither is there, or a text that names no such file.
    """
    for path in _plain_or_packed(root / f"{name}.bag"):
        if path.is_file():
            return _linked(root, path)
    raise refusal(root, f"expected {name}.bag or {name}.bag.bz2, got neither")


def _plain_or_packed(path: Path) -> tuple[Path, Path]:
    return path, path.with_name(path.name + ".bz2")


def _linked(root: Path, path: Path) -> Path:
    if path.stat().st_size > _LONGEST_LINK:
        return path
    text = read_bounded(path, _LONGEST_LINK).strip()
    if not text.startswith(b"../") or not text.endswith(b".bag"):
        return path
    target = PurePosixPath(text.decode("utf-8", "replace"))
    if len(target.parts) == 3 and ".." not in target.parts[1:]:
        for other in _plain_or_packed(root.parent / target.parts[1] / target.parts[2]):
            if other.is_file():
                return other
    raise refusal(path, f"expected a file beside this folder, got {one_line(str(target))}")


def motor_of(path: Path, position: Any, quaternion: Any) -> Motor:
    """A message's pose.

    Raises:
        RecordingError: no rigid motion.
    """
    numbers = np.array([quaternion.w, quaternion.x, quaternion.y, quaternion.z], np.float64)
    place = np.array([position.x, position.y, position.z], np.float64)
    norm = float(np.linalg.norm(numbers))
    if not abs(norm - 1.0) < _UNIT or not np.isfinite(place).all():
        raise refusal(path, f"expected a rigid motion, got {numbers} and {place}")
    return Motor.from_quaternion_translation(numbers / norm, place)


def _path(poses: Mapping[int, Motor]) -> Trajectory:
    stamps = sorted(poses)
    motors = Motor.stack([poses[stamp] for stamp in stamps])
    return Trajectory(np.array(stamps), motors, "odom", "odometry")


def _stream(
    camera: Camera,
    name: str,
    frames: Sequence[tuple[int, Sequence[Any]]],
    scene: MarkerScene,
    remaps: Sequence[MarkerRemap],
    squashed: Sequence[SquashedTags],
) -> CornerStream:
    """All detections of one camera, in the order of their stamps; sorted by id in a frame."""
    ordered = sorted(frames, key=lambda frame: frame[0])
    rows, ids, corners = [], [], []
    for row, (time_ns, tags) in enumerate(ordered):
        named = [(_meant(int(tag.id), time_ns, name, remaps), tag) for tag in tags]
        for marker, tag in sorted(named, key=lambda pair: pair[0]):
            corners_px = [(corner.x, corner.y) for corner in tag.corners]
            left_out = any(one.leaves_out(int(tag.id), time_ns) for one in squashed)
            if scene.side_m(marker) is None or left_out:
                continue
            rows.append(row)
            ids.append(marker)
            corners.append(corners_px)
    return CornerStream(
        camera=camera,
        time_ns=np.array([time_ns for time_ns, _ in ordered]),
        frame=np.array(rows, np.int64),
        marker_ids=np.array(ids, np.int64),
        corners_px=np.array(corners, np.float64).reshape(-1, 4, 2)[:, _HOUSE_ORDER],
    )


def _meant(marker: int, time_ns: int, camera: str, remaps: Sequence[MarkerRemap]) -> int:
    return next((one.instead for one in remaps if one.applies(marker, time_ns, camera)), marker)


def _cameras(path: Path) -> dict[str, tuple[Camera, str]]:
    """Camera and topic by name, from TagSLAM's (Kalibr's) `cameras.yaml`."""
    cameras = {}
    for name, entry in read_yaml(path).items():
        if not isinstance(entry, dict):
            raise refusal(path, f"expected a table, got {one_line(entry)}", field=one_line(name))
        model = _MODELS.get(str(entry.get("distortion_model")))
        if entry.get("camera_model") != "pinhole" or model is None:
            text = f"{entry.get('camera_model')}, {entry.get('distortion_model')}"
            problem = f"expected a pinhole with {', '.join(_MODELS)}, got {one_line(text)}"
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


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a folder of recorded tags; the path looked for is that of the first camera with a place.

    Raises:
        RecordingError: what `corners`, `odometry` or `reference` refuses.
    """
    corners = read_corners(root)
    placed = [name for name in corners.streams if name in corners.rig_T_camera]
    first = placed[0] if placed else next(iter(corners.streams))
    streams = {first: corners.streams[first], **corners.streams}
    known = {name: corners.rig_T_camera[name] for name in placed} or {first: Motor.identity()}
    has_truth = own_truth and any((root / f"reference.bag{end}").is_file() for end in ("", ".bz2"))
    return Recording(
        name=root.resolve().name,
        root=root,
        layout="tagslam",
        frames=CornerFrames(
            bag_file(root, "tag_detections"), streams, known, corners.side_m, corners.scene
        ),
        camera=streams[first].camera,
        truth=_reference(root, first, streams[first].marker_ids) if has_truth else None,
        odometry=_odometry(corners, known[first]),
    )


def _odometry(tag_slam_recording: TagSlamRecording, rig_T_camera: Motor) -> Odometry | None:
    odometry = tag_slam_recording.odometry
    if odometry is None:
        return None
    return Odometry(odometry.trajectory, odometry.body_T_odometry.inverse() @ rig_T_camera)


def _reference(root: Path, camera: str, marker_ids: IntArray) -> Trajectory | None:
    """`world_T_camera` by TagSLAM where it knew the camera; None where it never did.

    Our world is the markers'. Where TagSLAM holds the camera still and the markers are carried
    past it, the reference is therefore the camera seen from the marker that is seen most.
    """
    try:
        reference = read_reference(root)
    except EmptyBag:
        return None
    frames = reference.world_T_frame
    tag = f"tag_{np.bincount(marker_ids).argmax()}" if len(marker_ids) else ""
    known = [row for row, names in enumerate(frames) if camera in names]
    if not known:
        return None
    poses = Motor.stack([frames[row][camera] for row in known])
    if np.ptp(poses.translation_m, axis=0).max() > 0.0:
        return Trajectory(reference.time_ns[known], poses)
    known = [row for row in known if tag in frames[row]]
    if not known:
        return None
    seen = [frames[row][tag].inverse() @ frames[row][camera] for row in known]
    return Trajectory(reference.time_ns[known], Motor.stack(seen))


_TRANSFORMS = "tf/msg/tfMessage"
_MAP = "map"
_DEEPEST = 8
_MOST_TRANSFORMS = 5000


@dataclass(frozen=True, eq=False)
class TagSlamReference:
    """TagSLAM's result.

    Args:
        time_ns: ``(R,)`` stamps of the frames that have a pose.
        odometry: what `/tagslam/odom/body_*` tells, of the frame that it names its child.
        world_T_frame: by the frame's name (bodies, cameras, tags), at each of those stamps; None
            where the frame was not known then. Tags' frames have their origin at the centre, x
            right, y up, z out of the face.
    """

    time_ns: IntArray
    odometry: Trajectory
    world_T_frame: tuple[Mapping[str, Motor], ...]


def read_reference(root: Path) -> TagSlamReference:
    """Read the reference beside a recording.

    Raises:
        EmptyBag: no pose of any body.
        RecordingError: missing, damaged, or transforms that are no rigid motions
            or do not hang together.
    """
    path = bag_file(root, "reference")
    trees: dict[int, dict[str, tuple[str, Motor]]] = {}
    poses: dict[int, Motor] = {}
    child = ""
    for _, kind, message in read_bag(path, (ODOMETRY, _TRANSFORMS)):
        if kind == ODOMETRY:
            pose = message.pose.pose
            poses[header_stamp_ns(message)] = motor_of(path, pose.position, pose.orientation)
            child = str(message.child_frame_id) or "rig"
            continue
        if len(message.transforms) > _MOST_TRANSFORMS:
            raise refusal(path, f"expected at most {_MOST_TRANSFORMS} transforms a message")
        for transform in message.transforms:
            there = motor_of(path, transform.transform.translation, transform.transform.rotation)
            tree = trees.setdefault(header_stamp_ns(transform), {})
            tree[str(transform.child_frame_id)] = (str(transform.header.frame_id), there)
    stamps = sorted(poses)
    if not stamps:
        raise EmptyBag(str(refusal(path, "expected odometry, got none")))
    odometry = Trajectory(
        np.array(stamps), Motor.stack([poses[stamp] for stamp in stamps]), _MAP, child
    )
    rooted = tuple(_rooted(path, trees.get(stamp, {})) for stamp in stamps)
    return TagSlamReference(odometry.time_ns, odometry, rooted)


def _rooted(path: Path, tree: Mapping[str, tuple[str, Motor]]) -> dict[str, Motor]:
    """Every frame's pose in the map."""
    rooted = {}
    for name, (parent, pose) in tree.items():
        for _ in range(_DEEPEST):
            if parent == _MAP:
                break
            if parent not in tree:
                raise refusal(path, f"expected {one_line(parent)} to be known, got no transform")
            parent, upper = tree[parent]
            pose = upper @ pose
        else:
            raise refusal(path, f"expected {one_line(name)} to hang from {_MAP}, got a loop")
        rooted[name] = pose
    return rooted
