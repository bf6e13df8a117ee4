"""Trajectories in bags: topics of poses, points and odometry, and chains of frames of tf.

Poses are `header.frame_id`_T_`child`, and stamps those of the headers. A chain is named by its two
frames, `map/base_link`; where a bag has several topics of tf, `/robot/tf:map/base_link` names the
one that is meant. A dot does for the slash between frames, as in evo.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.ros.frame_tree import TRANSFORM_TYPES, FrameTree, StampedPoses
from motorcade.replays.io.readers.ros.reader import Bag

_LOG = logging.getLogger("motorcade.replays")
_MOST_POSES = 10_000_000
_SHOWN = 20
_POINT = "geometry_msgs/msg/PointStamped"
_FIX = "sensor_msgs/msg/NavSatFix"
_NO_FIX = -1


@dataclass(frozen=True)
class BagTrajectories:
    """What a bag holds that can be read as a trajectory.

    Args:
        topics: type and count of messages of each topic of poses, by name.
        links: frames that hang from each other: (parent, child).
    """

    topics: Mapping[str, tuple[str, int]]
    links: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        """What there is, in one line."""
        names = [f"{one_line(name)} ({kind})" for name, (kind, _) in self.topics.items()]
        names += [one_line(f"{parent}/{child}") for parent, child in self.links]
        more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        return ", ".join(names[:_SHOWN]) + more

    def __len__(self) -> int:
        return len(self.topics) + len(self.links)


def list_bag_trajectories(path: Path) -> BagTrajectories:
    """What a bag holds that can be read as a trajectory.

    Raises:
        RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        return _listed(bag)


def read_bag_trajectory(
    path: Path, name: str, parent: str | None = None, child: str | None = None
) -> Trajectory:
    """Read one trajectory of a bag.

    Args:
        path: a `.bag`, `.bag.bz2`, `.mcap`, `.db3` or a ROS 2 bag's folder.
        name: a topic of poses, or two frames that topics of tf join.
        parent: name of the frame that poses map to; by default what the bag calls it, or world.
        child: name of the frame that moves; by default what the bag calls it, or camera.

    Raises:
        RecordingError: missing, damaged, nothing of that name (the message lists what there is),
            poses that are no rigid motions, frames that change within a topic, or frames that no
            transforms join.
    """
    with Bag(path) as bag:
        topics = _pose_topics(bag)
        topic = next((entry for entry in (name, f"/{name}") if name and entry in topics), None)
        if topic is not None and topics[topic][0] == _FIX:
            return _fixes(bag, topic, parent, child)
        poses = _chain(bag, name) if topic is None else _poses(bag, topic, topics[topic][0])
    return Trajectory(poses.time_ns, poses.poses, parent or poses.parent, child or poses.child)


def _pose_topics(bag: Bag) -> dict[str, tuple[str, int]]:
    """Type and count of the messages of each topic of poses."""
    kinds = bag.kinds().items()
    return {name: kind for name, kind in kinds if kind[0] in (*_POSES, _FIX) and kind[1]}


def _listed(bag: Bag, tree: FrameTree | None = None) -> BagTrajectories:
    tree = tree or FrameTree(bag, bag.topics(TRANSFORM_TYPES))
    return BagTrajectories(_pose_topics(bag), tuple(tree.links))


def _poses(bag: Bag, topic: str, kind: str) -> Trajectory:
    """The trajectory of a topic of poses."""
    taken, field = _POSES[kind], one_line(topic)
    poses, frames = StampedPoses(bag.path, field), None
    if kind == _POINT:
        _LOG.warning("%s, %s: points do not turn; rotations are none", bag.path, field)
    for stamp, message in bag.messages([topic], (kind,)):
        place, turn = taken(message)
        poses.add(stamp, place, turn)
        named = str(message.header.frame_id), str(getattr(message, "child_frame_id", ""))
        frames = frames or named
        if named != frames:
            there, here = (one_line("_T_".join(entry)) for entry in (frames, named))
            problem = f"expected poses {there} throughout, got {here}"
            raise refusal(bag.path, problem, field=f"{field}, pose {len(poses) - 1}")
        if len(poses) > _MOST_POSES:
            raise refusal(bag.path, f"expected at most {_MOST_POSES} poses, got more", field=field)
    parent, child = (name.removeprefix("/") for name in frames or ("", ""))
    return Trajectory(*poses.ordered, parent or "world", child or "camera")


def _fixes(bag: Bag, topic: str, parent: str | None, child: str | None) -> Trajectory:
    """Positions of satellite navigation; REP 145's heights are over the ellipsoid."""
    from motorcade.replays.io.readers.positions import MOST_FIXES, geodetic_path

    rows = []
    for stamp, fix in bag.messages([topic], (_FIX,)):
        if fix.status.status > _NO_FIX:
            rows.append((stamp, fix.latitude, fix.longitude, fix.altitude))
        if len(rows) > MOST_FIXES:
            raise refusal(bag.path, f"expected at most {MOST_FIXES} fixes, got more", field=topic)
    stamps = np.array([row[0] for row in rows], dtype=np.int64)
    places = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 3)
    return geodetic_path(bag.path, stamps, places, None, parent, child)


def _chain(bag: Bag, name: str) -> Trajectory:
    """The trajectory of one frame in another, as `[TOPIC:]PARENT/CHILD` names them."""
    topics = bag.topics(TRANSFORM_TYPES)
    topic, colon, frames = name.partition(":")
    if colon:
        if topic not in topics:
            problem = f"expected one of {', '.join(map(one_line, topics)) or 'none'}"
            raise refusal(bag.path, f"{problem}, got {one_line(topic)}", field="topic of tf")
        topics = [entry for entry in topics if entry == topic or entry.endswith("tf_static")]
    else:
        frames = name
    tree = FrameTree(bag, topics)
    joints = [at for at, letter in enumerate(frames) if letter in "/."]
    pairs = [(frames[:at].removeprefix("/"), frames[at + 1 :].removeprefix("/")) for at in joints]
    known = [pair for pair in dict.fromkeys(pairs) if tree.frames.issuperset(pair)]
    if len(known) != 1:
        got = one_line(name) if name else "no name"
        problem = f"expected a topic of poses or two frames, got {got}"
        if known:
            problem = f"expected two frames, got {one_line(name)}, which is more than one pair"
        there = _listed(bag, tree if not colon else None)
        advice = f"name one of them as {bag.path}:NAME: {there}"
        raise refusal(bag.path, problem, advice=advice if there else "it holds none")
    return tree.trajectory(*known[0])


def _of_pose(message: Any) -> tuple[Any, Any]:
    return message.pose.position, message.pose.orientation


def _of_pose_with_covariance(message: Any) -> tuple[Any, Any]:
    return message.pose.pose.position, message.pose.pose.orientation


def _of_transform(message: Any) -> tuple[Any, Any]:
    return message.transform.translation, message.transform.rotation


def _of_point(message: Any) -> tuple[Any, None]:
    return message.point, None


_POSES: dict[str, Callable[[Any], tuple[Any, Any]]] = {
    "geometry_msgs/msg/PoseStamped": _of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _of_pose_with_covariance,
    "geometry_msgs/msg/TransformStamped": _of_transform,
    "nav_msgs/msg/Odometry": _of_pose_with_covariance,
    _POINT: _of_point,
}
