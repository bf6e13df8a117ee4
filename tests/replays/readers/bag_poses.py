"""Bags of poses and transforms, of every kind, written by rosbags' own writers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from motorcade.replays.io.readers.ros.admission import message_types

KINDS = ("bag", "folder", "mcap")
TF = "tf2_msgs/msg/TFMessage"


class Messages:
    """Messages of poses of a version of ROS."""

    def __init__(self, *, ros1: bool) -> None:
        self.store, self.ros1 = message_types(ros1=ros1), ros1

    def make(self, name: str, **fields: Any) -> Any:
        return self.store.types[name](**fields)

    def header(self, time_ns: int, frame: str) -> Any:
        sec, nanosec = divmod(time_ns, 10**9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        seq = {"seq": 0} if self.ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **seq)

    def point(self, place: Sequence[float], name: str = "Point") -> Any:
        x, y, z = map(float, place)
        return self.make(f"geometry_msgs/msg/{name}", x=x, y=y, z=z)

    def turn(self, wxyz: Sequence[float]) -> Any:
        w, x, y, z = map(float, wxyz)
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, kind: str, time_ns: int, numbers: np.ndarray, frames: tuple[str, str]) -> Any:
        """A message of that type: position, quaternion wxyz."""
        header, place, turn = self.header(time_ns, frames[0]), numbers[:3], self.turn(numbers[3:])
        short = kind.rpartition("/")[2]
        if short == "PointStamped":
            return self.make(kind, header=header, point=self.point(place))
        if short == "TransformStamped":
            there = self.make(
                "geometry_msgs/msg/Transform",
                translation=self.point(place, "Vector3"),
                rotation=turn,
            )
            return self.make(kind, header=header, child_frame_id=frames[1], transform=there)
        pose = self.make("geometry_msgs/msg/Pose", position=self.point(place), orientation=turn)
        if short == "PoseStamped":
            return self.make(kind, header=header, pose=pose)
        unsure = self.make(
            "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36)
        )
        if short == "PoseWithCovarianceStamped":
            return self.make(kind, header=header, pose=unsure)
        still = self.point((0, 0, 0), "Vector3")
        twist = self.make("geometry_msgs/msg/Twist", linear=still, angular=still)
        moving = self.make(
            "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)
        )
        return self.make(kind, header=header, child_frame_id=frames[1], pose=unsure, twist=moving)

    def transforms(self, *every: Any) -> Any:
        return self.make(TF, transforms=list(every))


def write_messages(folder: Path, kind: str, sent: Sequence[tuple[str, int, Any]]) -> Path:
    """A bag of (topic, time of recording, message); returns what a user would name."""
    store = message_types(ros1=kind == "bag")
    path = folder / ("flight.bag" if kind == "bag" else "flight")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer: Any = (
        Writer1(path) if kind == "bag" else Writer2(path, version=9, storage_plugin=plugin)
    )
    pack = store.serialize_ros1 if kind == "bag" else store.serialize_cdr
    with writer:
        topics: dict[str, Any] = {}
        for topic, recorded_ns, message in sent:
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
            writer.write(topics[topic], recorded_ns, pack(message, message.__msgtype__))
    return next(path.glob("*.mcap")) if kind == "mcap" else path


def write_poses(folder: Path, kind: str) -> Path:
    """A bag of odometry, and of two frames upon each other."""
    made, sent = Messages(ros1=kind == "bag"), list[tuple[str, int, Any]]()
    row = np.array([1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5])
    for stamp in range(10**9, 10**10, 10**9):
        odometry = made.pose("nav_msgs/msg/Odometry", stamp, row, ("odom", "base"))
        links = [
            made.pose("geometry_msgs/msg/TransformStamped", stamp, row, link)
            for link in (("map", "odom"), ("odom", "base"))
        ]
        sent += [("/odom", stamp, odometry), ("/tf", stamp, made.transforms(*links))]
    return write_messages(folder, kind, sent)
