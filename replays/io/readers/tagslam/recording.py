"""TagSLAM's folders as recordings of the pipeline: corners, odometry, its result as reference.

The reference is what TagSLAM itself made of a recording: where rig, cameras and tags were, frame by
frame. From `reference.bag`: the frames that `/tagslam/odom/body_*` has a pose for, with the
transforms of `/tf` at their stamps. Those are TagSLAM's estimates as of that frame, made from the
same corners (and odometry where there was one): they show agreement, not accuracy. Only for
evaluation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.ros.reader import EmptyBag, header_stamp_ns, read_bag
from motorcade.replays.io.readers.tagslam.corners import (
    ODOMETRY,
    TagSlamRecording,
    bag_file,
    motor_of,
)
from motorcade.replays.io.readers.tagslam.corners import read as read_corners
from motorcade.replays.io.recording import Odometry, Recording


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
