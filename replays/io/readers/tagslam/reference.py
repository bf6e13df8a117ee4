"""What TagSLAM itself made of a recording: where rig, cameras and tags were, frame by frame.

From `reference.bag`: the frames that `/tagslam/odom/body_*` has a pose for, with the transforms of
`/tf` at their stamps. Those are TagSLAM's estimates as of that frame, made from the same corners
(and odometry where there was one): they show agreement, not accuracy. Only for evaluation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.ros.bag import EmptyBag, read_bag
from motorcade.replays.io.readers.ros.reader import header_stamp_ns
from motorcade.replays.io.readers.tagslam.corners import ODOMETRY, bag_file, motor_of

_TRANSFORMS = "tf/msg/tfMessage"
_MAP, _TAG = "map", "tag_"
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

    def camera_T_tags(self, row: int, camera: str) -> dict[int, Motor]:
        """Pose of each tag's centred frame in a camera, by id, at one of the stamps."""
        known = self.world_T_frame[row]
        if camera not in known:
            return {}
        camera_T_world = known[camera].inverse()
        tags = {name: pose for name, pose in known.items() if name.startswith(_TAG)}
        return {
            int(name.removeprefix(_TAG)): camera_T_world @ pose
            for name, pose in tags.items()
            if name.removeprefix(_TAG).isdigit()
        }


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
        for one in message.transforms:
            there = motor_of(path, one.transform.translation, one.transform.rotation)
            tree = trees.setdefault(header_stamp_ns(one), {})
            tree[str(one.child_frame_id)] = (str(one.header.frame_id), there)
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
