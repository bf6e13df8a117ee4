"""The odometry that TagSLAM's recordings hold beside the corners, and where the rig sits on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.errors import one_line, refusal
from motorcade.replays.readers.calibration import read_yaml, yaml_floats
from motorcade.replays.readers.tagslam.reference import read_odometry

__all__ = ["TagSlamOdometry", "read_rig_odometry"]


@dataclass(frozen=True, eq=False)
class TagSlamOdometry:
    """A path of what the odometry tracks, in its own world, and the rig's pose on that."""

    trajectory: Trajectory
    odometry_T_rig: Motor


def read_rig_odometry(root: Path) -> TagSlamOdometry | None:
    """Read both; None where no odometry was recorded.

    `T_body_odom` takes the body's coordinates to the odometry's frame, whatever its name says: the
    steps of odometry and tags in test_21 meet within 1 mrad that way, within 4 mrad the other.

    Raises:
        RecordingError: a bag or file that is missing or damaged, or no body with odometry.
    """
    trajectory = read_odometry(root)
    if trajectory is None:
        return None
    path = root / "tagslam.yaml"
    bodies = read_yaml(path).get("bodies")
    for entry in bodies if isinstance(bodies, list) else []:
        for name, body in entry.items() if isinstance(entry, dict) else ():
            if isinstance(body, dict) and "T_body_odom" in body:
                return TagSlamOdometry(trajectory, _pose(path, str(name), body["T_body_odom"]))
    raise refusal(path, "expected a body with T_body_odom, got none", field="bodies")


def _pose(path: Path, body: str, pose: object) -> Motor:
    parts = []
    for part in ("position", "rotation"):
        found = pose.get(part) if isinstance(pose, dict) else None
        if not isinstance(found, dict):
            field = f"{one_line(body)}.T_body_odom.{part}"
            raise refusal(path, f"expected x, y and z, got {one_line(found)}", field=field)
        parts.append(yaml_floats(path, {part: [found.get(one) for one in "xyz"]}, part, 3))
    position, rotation = (np.asarray(part) for part in parts)
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(rotation), position)
