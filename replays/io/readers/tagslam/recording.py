"""TagSLAM's folders as recordings of the pipeline: corners, odometry, its result as reference.

The reference was made from the same corners (and odometry where there was one): errors against it
show agreement, not accuracy.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.ros.bag import EmptyBag
from motorcade.replays.io.readers.tagslam.corners import TagSlamRecording, bag_file
from motorcade.replays.io.readers.tagslam.corners import read as read_corners
from motorcade.replays.io.readers.tagslam.reference import read_reference
from motorcade.replays.io.recording import Odometry, Recording


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
        frames=CornerFrames(
            bag_file(root, "tag_detections"), streams, known, found.side_m, found.scene
        ),
        camera=streams[first].camera,
        truth=_reference(root, first, streams[first].marker_ids) if has_truth else None,
        odometry=_odometry(found, known[first]),
    )


def _odometry(found: TagSlamRecording, rig_T_camera: Motor) -> Odometry | None:
    odometry = found.odometry
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
