"""What a recording or a character file holds, as JSON-ready values whose keys carry units.

Recordings: frames, rates, gaps, calibration, streams, truth. Characters and motions: joints,
triangles, influences, clips. Bags, and files of poses or inertial readings: which commands read
them.
"""

from __future__ import annotations

import shlex
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, Clip, Skeleton
from motorcade.animation.formats import NoMeshError, read_character, read_motion
from motorcade.fusion.health import check_health
from motorcade.fusion.imu import ImuStream, screen_imu
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.ga.stamps import near_steps
from motorcade.replays.engine.stage import StageError
from motorcade.replays.io.files import RecordingError, refusal
from motorcade.replays.io.readers import positions
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.layouts.detect import find_layout
from motorcade.replays.io.readers.manifest import LOCAL_NAME
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.readings import is_log_of_readings, read_readings
from motorcade.replays.io.readers.ros.frames import IMAGE_TYPES, BagFrames
from motorcade.replays.io.readers.ros.reader import Bag
from motorcade.replays.io.readers.ros.recording import CAMERA_INFO_TYPE, FIELD_TYPE, IMU_TYPE
from motorcade.replays.io.readers.ros.trajectories import TRANSFORM_TYPES, list_bag_trajectories
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory, trajectory_format
from motorcade.replays.pipeline.described.describing import open_described, summary
from motorcade.tracking.cameras.camera import AS_STORED


def describe(recording: Recording) -> dict[str, Any]:
    """Contents of a recording as JSON-ready values whose keys carry units."""
    about: dict[str, Any] = {"name": recording.name, "layout": recording.layout}
    about |= describe_stream("frames", recording.frames.time_ns)
    camera = recording.camera
    if camera is not None:
        about["image_size_px"] = [camera.width, camera.height]
        about["camera_model"] = camera.model
        about["focal_px"] = [camera.fx, camera.fy]
        about["principal_point_px"] = [camera.cx, camera.cy]
        about["distortion"] = list(camera.distortion)
        if recording.readout_s:
            about["readout_s"] = recording.readout_s
    frames = recording.frames
    if isinstance(frames, ImageFrames | VideoFrames) and frames.orientation != AS_STORED:
        about["shown_turned_deg"] = frames.orientation.degrees
    if isinstance(frames, VideoFrames) and frames.notes:
        about["notes"] = list(frames.notes)
    about |= _depth(recording)
    if recording.board is not None:
        about["board"] = recording.board.name
        about["board_size_m" if recording.metric else "board_size"] = list(recording.board.size_m)
    if recording.markers is not None:
        about["markers"] = recording.markers.family
    if recording.imu is not None:
        about |= describe_stream("imu", recording.imu.time_ns)
        about |= _health(recording, recording.imu)
    if recording.imu_noise is not None:
        about["imu_noise"] = str(recording.imu_noise)
    if recording.truth is not None:
        about |= describe_stream("truth", recording.truth.time_ns)
        steps = np.diff(recording.truth.poses.translation_m, axis=0)
        about["truth_path_m"] = float(np.linalg.norm(steps, axis=1).sum())
    return about


def describe_whole(path: Path, manifest: Path | None = None) -> dict[str, Any]:
    """Contents of a recording, with what was found out where neither it nor a manifest tells them.

    Raises RecordingError: as `open_recording`.
    """
    recording = _without_damage(open_recording(path, manifest))
    with tempfile.TemporaryDirectory() as cache:
        try:
            opened = open_described(recording, manifest, Path(cache), {})
        except StageError as fault:  # its images tell too little: that is worth telling, too
            return describe(recording) | {"not_found": str(fault)}
    return describe(_without_damage(opened.recording)) | summary(opened)


def _without_damage(recording: Recording) -> Recording:
    """Of a video, which is read whole for that: only then the count of its frames is certain."""
    return recording.intact() if isinstance(recording.frames, VideoFrames) else recording


def _depth(recording: Recording) -> dict[str, Any]:
    """How many frames have depth, in which unit, and what took it if not the frames' camera."""
    frames = recording.frames
    if isinstance(frames, BagFrames) and frames.depth_topic is not None:
        return {"depth_count": frames.depth_count, "depth_topic": frames.depth_topic}
    if not isinstance(frames, ImageFrames) or not any(frames.depth_files):
        return {}
    about: dict[str, Any] = {
        "depth_count": sum(path is not None for path in frames.depth_files),
        "depth_units_per_m": frames.depth_units_per_m,
    }
    if frames.depth_camera is not None:
        lens = frames.depth_camera.camera
        about["depth_image_size_px"] = [lens.width, lens.height]
        about["depth_focal_px"] = [lens.fx, lens.fy]
        about["depth_position_m"] = frames.depth_camera.colour_T_depth.translation_m.tolist()
    return about


def _health(recording: Recording, imu: ImuStream) -> dict[str, Any]:
    """What is wrong with the readings: by themselves, and beside the ground truth if there is."""
    try:
        problems = list(screen_imu(imu))
    except ValueError as fault:
        problems = [str(fault)]
    truth, imu_T_camera = recording.truth, recording.imu_T_camera
    if truth is None or imu_T_camera is None:
        return {"imu_health": problems} if problems else {}
    health = check_health(truth.rigid, imu, imu_T_camera, up=False)
    return {"imu_health": [*problems, *(one.summary for one in health.findings), *health.unknown]}


def describe_stream(name: str, time_ns: IntArray) -> dict[str, Any]:
    """Count, span, rate and gaps of a stamped stream, under keys that begin with its name."""
    about: dict[str, Any] = {f"{name}_count": len(time_ns)}
    if len(time_ns) < 2:
        return about
    steps_s = np.diff(time_ns) * 1e-9
    usual = float(np.median(steps_s))
    about[f"{name}_duration_s"] = float(steps_s.sum())
    about[f"{name}_rate_hz"] = 1.0 / usual
    about[f"{name}_gaps"] = int(np.count_nonzero(~near_steps(steps_s)))
    about[f"{name}_longest_gap_s"] = float(steps_s.max())
    return about


def describe_character(
    path: Path, pose: str | None = None, *, up: str | None = None, front: str | None = None
) -> dict[str, Any]:
    """Contents of a character or motion file; a motion has no mesh.

    Positions are in character space: metres, z up, facing +x.

    Args:
        path: the file.
        pose: `CLIP@SECONDS`, a moment at which to tell where the joints are; seconds count on
            the clip's own clock.
        up: the axis of the file that is up, where the caller knows better.
        front: the axis of the file that the figure faces at rest, likewise.

    Raises:
        FormatError: the file cannot be read.
        ValueError: no such clip, or a pose that is not `CLIP@SECONDS`.
    """
    try:
        character = read_character(path, up=up, front=front)
    except NoMeshError:
        motion = read_motion(path, up=up, front=front)
        about: dict[str, Any] = {"name": path.name}
        skeleton, clips, notices = motion.skeleton, motion.clips, motion.notices
    else:
        about = {"name": path.name} | _mesh(character)
        skeleton, clips, notices = character.skeleton, character.clips, character.notices
    about |= {
        "joint_count": len(skeleton),
        "joints": _joints(skeleton, skeleton.rest_world.translation_m, "rest_position_m"),
        "clip_count": len(clips),
        "clips": [
            {
                "name": clip.name,
                "seconds": clip.duration_s,
                "start_s": float(clip.time_s[0]),
                "keys": clip.key_count,
                "samples": len(clip.time_s),
                "looped": clip.looped,
            }
            for clip in clips
        ],
        "notices": list(notices),
    }
    if pose is not None:
        about["pose"] = _posed(skeleton, clips, pose)
    return about


def _mesh(character: Character) -> dict[str, Any]:
    held = (character.weights > 0.0).sum(axis=1)
    return {
        "height_m": character.height_m,
        "vertices": len(character.vertices),
        "triangles": len(character.triangles),
        "influences_max": int(held.max()),
        "influences_mean": float(held.mean()),
        "weighted_joints": len(np.unique(character.joints[character.weights > 0.0])),
    }


def _joints(skeleton: Skeleton, places: FloatArray, key: str) -> list[dict[str, Any]]:
    return [
        {"name": name, "parent": None if parent < 0 else skeleton.names[parent], key: place}
        for name, parent, place in zip(
            skeleton.names, skeleton.parents.tolist(), places.tolist(), strict=True
        )
    ]


def _posed(skeleton: Skeleton, clips: tuple[Clip, ...], pose: str) -> dict[str, Any]:
    name, _, seconds = pose.rpartition("@")
    chosen = next((clip for clip in clips if clip.name == name), None)
    if chosen is None:
        listed = ", ".join(f"'{clip.name}'" for clip in clips) or "none"
        raise ValueError(f"pose: expected CLIP@SECONDS with one of {listed}, got '{pose}'")
    try:
        at_s = float(seconds)
    except ValueError as fault:
        raise ValueError(f"pose: expected CLIP@SECONDS, got '{pose}'") from fault
    if not np.isfinite(at_s):
        raise ValueError(f"pose: expected CLIP@SECONDS with finite seconds, got '{pose}'")
    places = skeleton.world(chosen.at(at_s)).translation_m
    return {"clip": name, "at_s": at_s, "joints": _joints(skeleton, places, "position_m")}


_POSES = "poses: smooth, evaluate, fuse, trajectory"
_READ_BY = {
    **dict.fromkeys(IMAGE_TYPES, "images: run"),
    IMU_TYPE: "inertial readings: run, beside images; orient, fuse, sync",
    FIELD_TYPE: "a magnetometer: orient",
    CAMERA_INFO_TYPE: "a camera",
    **dict.fromkeys(TRANSFORM_TYPES, "frames, listed below: smooth, evaluate, fuse, trajectory"),
}
_MOST_LINKS = 50
_LONGEST_NAME = 200


def describe_bag(path: Path) -> dict[str, Any]:
    """Topics of a bag and what reads each; JSON-ready.

    Raises RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        kinds = bag.kinds()
    held = list_bag_trajectories(path)
    topics = [
        {
            "name": _printable(name),
            "type": _printable(kind),
            "messages": count,
            "read_as": _POSES if name in held.topics else _READ_BY.get(kind, "not read"),
        }
        for name, (kind, count) in kinds.items()
    ]
    frames = [_printable(f"{parent}/{child}") for parent, child in held.links[:_MOST_LINKS]]
    about = {"name": path.name, "topics": topics, "frames": frames}
    named = [*held.topics, *(f"{parent}/{child}" for parent, child in held.links)]
    return about | {"next": _next(f"{path}:{named[0]}") if named else []}


def _printable(name: str) -> str:
    """A name from a bag as it is, unless it would upset a terminal."""
    return name if name.isprintable() and len(name) <= _LONGEST_NAME else one_line(name)


def is_log(path: Path) -> bool:
    """Whether a path holds readings or positions, and nothing that a camera recorded."""
    if path.is_dir() and (find_layout(path) is not None or (path / LOCAL_NAME).exists()):
        return False
    return positions.recognise(path) or is_log_of_readings(path)


def describe_log(path: Path) -> dict[str, Any]:
    """What a log of readings or positions holds, and which commands read it; JSON-ready.

    Raises:
        RecordingError: neither, or damaged.
    """
    about: dict[str, Any] = {"name": path.name}
    faults, quoted = list[RecordingError](), shlex.quote(str(path))
    following = list[str]()
    if is_log_of_readings(path):
        try:
            about, following = _held_readings(path)
        except RecordingError as fault:
            faults.append(fault)
    if positions.recognise(path):
        try:
            track = positions.read_positions(path)
        except RecordingError as fault:
            faults.append(fault)
        else:
            about |= describe_stream("positions", track.time_ns) | {"path_m": _length_m(track)}
            following += [f"motorcade evaluate ESTIMATE {quoted}", *_next(str(path))[::2]]
    if not following:
        raise faults[0]
    return about | {"next": following}


def _held_readings(path: Path) -> tuple[dict[str, Any], list[str]]:
    """What a path holds as readings, and the commands that take them."""
    readings, quoted = read_readings(path), shlex.quote(str(path))
    held_by = "" if readings.held_by == "a table" else f", as {readings.held_by}"
    about = {"name": path.name, "holds": f"inertial readings{held_by}"}
    about |= describe_stream("imu", readings.imu.time_ns)
    field = ""
    if readings.field is not None:
        about |= describe_stream("magnetometer", readings.field[0])
        field = " --magnetometer"
    return about, [
        f"motorcade orient {quoted}{field} -o orientation.tum",
        f"motorcade fuse CAMERA_TRAJECTORY {quoted} -o fused.tum",
        f"motorcade sync CAMERA_TRAJECTORY {quoted}",
    ]


def describe_text(path: Path) -> dict[str, Any]:
    """What a file of poses or of inertial readings holds; JSON-ready.

    Raises RecordingError: neither.
    """
    try:
        fmt = trajectory_format(path)
        trajectory = read_trajectory(path, rate_hz=1.0 if fmt == "kitti" else None)
    except RecordingError as no_poses:
        if path.suffix.lower() in (".tum", ".kitti"):
            raise
        return _inertial(path, no_poses)
    about: dict[str, Any] = {"name": path.name, "holds": f"poses, as {_WRITTEN[fmt]}"}
    if fmt == "kitti":
        about["poses_count"] = len(trajectory.time_ns)
    else:
        about |= describe_stream("poses", trajectory.time_ns)
    about["path_m"] = _length_m(trajectory)
    return about | {"next": _next(str(path), " --rate-hz HZ" if fmt == "kitti" else "")}


def _length_m(trajectory: Trajectory) -> float:
    steps = np.diff(trajectory.rigid.poses.translation_m, axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


_WRITTEN = {
    "tum": "TUM writes them (stamp, place, quaternion xyzw)",
    "euroc": "EuRoC writes them, or as the header names its columns",
    "kitti": "KITTI writes them (3 by 4 matrices, no stamps)",
}


def _inertial(path: Path, no_poses: RecordingError) -> dict[str, Any]:
    try:
        about, following = _held_readings(path)
    except RecordingError as fault:
        reasons = [str(one).removeprefix(f"{path}: ") for one in (no_poses, fault)]
        problem = f"holds neither poses ({reasons[0]}) nor inertial readings ({reasons[1]})"
        raise refusal(path, problem) from fault
    return about | {"next": following}


def _next(name: str, stamps: str = "") -> list[str]:
    """Commands that read a trajectory."""
    quoted = shlex.quote(name) + stamps
    return [
        f"motorcade smooth {quoted} -o smooth.tum",
        f"motorcade evaluate {quoted} GROUND_TRUTH",
        f"motorcade trajectory {quoted} --plot path.svg",
    ]
