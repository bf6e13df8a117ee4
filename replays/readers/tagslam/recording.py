"""TagSLAM's folders as recordings of the pipeline: corners, odometry, its result as reference.

The reference was made from the same corners (and odometry where there was one): errors against it
show agreement, not accuracy. TagSLAM may also be told how tags lie on their boards, which is not
read here: lengths are those of the tags' sides alone. In test_24 the two disagree by 2 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.replays.errors import one_line, refusal
from motorcade.replays.readers.calibration import read_yaml, yaml_floats
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.readers.tagslam.corners import bag_file
from motorcade.replays.readers.tagslam.corners import read as read_corners
from motorcade.replays.readers.tagslam.reference import read_odometry, read_reference
from motorcade.replays.recording import Odometry, Recording


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


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a folder of recorded tags; the path looked for is that of the first camera with a place.

    Raises:
        RecordingError: what `corners`, `odometry` or `reference` refuses.
    """
    found = read_corners(root)
    placed = [name for name in found.streams if name in found.rig_T_camera]
    first = placed[0] if placed else next(iter(found.streams))
    streams = {first: found.streams[first], **found.streams}
    known = {name: found.rig_T_camera[name] for name in placed} or {first: Motor.identity()}
    has_truth = own_truth and any((root / f"reference.bag{end}").is_file() for end in ("", ".bz2"))
    return Recording(
        name=root.resolve().name,
        root=root,
        layout="tagslam",
        frames=CornerFrames(bag_file(root, "tag_detections"), streams, known, found.side_m),
        camera=streams[first].camera,
        truth=_reference(root, first, streams[first].marker_ids) if has_truth else None,
        odometry=_odometry(root, known[first]),
    )


def _odometry(root: Path, rig_T_camera: Motor) -> Odometry | None:
    found = read_rig_odometry(root)
    if found is None:
        return None
    return Odometry(found.trajectory, found.odometry_T_rig @ rig_T_camera)


def _reference(root: Path, camera: str, marker_ids: IntArray) -> Trajectory | None:
    """`world_T_camera` by TagSLAM where it knew the camera; None where it never did.

    Our world is the markers'. Where TagSLAM holds the camera still and the markers are carried
    past it, the reference is therefore the camera seen from the marker that is seen most.
    """
    reference = read_reference(root)
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
