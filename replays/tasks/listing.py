"""What a bag, or a file of poses or inertial readings, holds, and which commands read it.

Recordings and characters are described by `inspection`.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.names import one_line
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.readers.ros.frame_tree import TRANSFORM_TYPES
from motorcade.replays.io.readers.ros.frames import IMAGE_TYPES
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.readers.ros.recording import CAMERA_INFO_TYPE, IMU_TYPE
from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories
from motorcade.replays.io.trajectories import read_trajectory, trajectory_format
from motorcade.replays.tasks.inspection import describe_stream

TEXT_SUFFIXES = (".tum", ".txt", ".csv", ".kitti")
"""Endings of files that may hold poses or inertial readings."""

_POSES = "poses: smooth, evaluate, fuse, trajectory"
_READ_BY = {
    **dict.fromkeys(IMAGE_TYPES, "pictures: run"),
    IMU_TYPE: "inertial readings: run, beside pictures",
    CAMERA_INFO_TYPE: "a camera",
    **dict.fromkeys(TRANSFORM_TYPES, "frames, listed below: smooth, evaluate, fuse, trajectory"),
}
_MOST_LINKS = 50
_LONGEST_NAME = 200


def describe_bag(path: Path) -> dict[str, Any]:
    """Topics of a bag and what reads each; JSON-ready.

    Raises:
        RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        kinds = bag.kinds()
    held = list_bag_trajectories(path)
    topics = [
        {
            "name": _told(name),
            "type": _told(kind),
            "messages": count,
            "read_as": _POSES if name in held.topics else _READ_BY.get(kind, "not read"),
        }
        for name, (kind, count) in kinds.items()
    ]
    frames = [_told(f"{parent}/{child}") for parent, child in held.links[:_MOST_LINKS]]
    about = {"name": path.name, "topics": topics, "frames": frames}
    named = [*held.topics, *(f"{parent}/{child}" for parent, child in held.links)]
    return about | {"next": _next(f"{path}:{named[0]}") if named else []}


def _told(name: str) -> str:
    """A name from a bag as it is, unless it would upset a terminal."""
    return name if name.isprintable() and len(name) <= _LONGEST_NAME else one_line(name)


def describe_text(path: Path) -> dict[str, Any]:
    """What a file of poses or of inertial readings holds; JSON-ready.

    Raises:
        RecordingError: neither.
    """
    try:
        fmt = trajectory_format(path)
        found = read_trajectory(path, rate_hz=1.0 if fmt == "kitti" else None)
    except RecordingError as no_poses:
        if path.suffix.lower() in (".tum", ".kitti"):
            raise
        return _inertial(path, no_poses)
    about: dict[str, Any] = {"name": path.name, "holds": f"poses, as {_WRITTEN[fmt]}"}
    if fmt == "kitti":
        about["poses_count"] = len(found.time_ns)
    else:
        about |= describe_stream("poses", found.time_ns)
    steps = np.diff(found.rigid.poses.translation_m, axis=0)
    about["path_m"] = float(np.linalg.norm(steps, axis=1).sum())
    return about | {"next": _next(str(path), " --rate-hz HZ" if fmt == "kitti" else "")}


_WRITTEN = {
    "tum": "TUM writes them (stamp, place, quaternion xyzw)",
    "euroc": "EuRoC writes them, or as the header names its columns",
    "kitti": "KITTI writes them (3 by 4 matrices, no stamps)",
}


def _inertial(path: Path, no_poses: RecordingError) -> dict[str, Any]:
    try:
        stream = read_imu(path)
    except RecordingError as fault:
        reasons = [str(one).removeprefix(f"{path}: ") for one in (no_poses, fault)]
        problem = f"holds neither poses ({reasons[0]}) nor inertial readings ({reasons[1]})"
        raise refusal(path, problem) from fault
    about: dict[str, Any] = {"name": path.name, "holds": "inertial readings"}
    quoted = shlex.quote(str(path))
    return (
        about
        | describe_stream("imu", stream.time_ns)
        | {
            "next": [
                f"motorcade orient {quoted} -o orientation.tum",
                f"motorcade fuse CAMERA_TRAJECTORY {quoted} -o fused.tum",
            ]
        }
    )


def _next(name: str, stamps: str = "") -> list[str]:
    """Commands that read a trajectory."""
    given = shlex.quote(name) + stamps
    return [
        f"motorcade smooth {given} -o smooth.tum",
        f"motorcade evaluate {given} GROUND_TRUTH",
        f"motorcade trajectory {given} --plot path.svg",
    ]
