"""A marker to stand on that may move: where it is in every frame, smooth, and held while unseen.

The camera's path comes from whatever stands still, and takes the marker's two planar poses of each
frame to the world. The likeliest sequence of these is chosen (a chain: small error, little turning)
and smoothed between jumps. A marker that one pose explains in all frames does not move; if a map
holds its pose, that one is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.place import followed
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import LooseMarkers, Recording
from motorcade.replays.stages.camera.marker_poses import markers_found
from motorcade.tracking import MarkerGrid, SingleMarker
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import pose_stream
from motorcade.tracking.markers.disambiguate.states import most_probable
from motorcade.tracking.markers.families import marker_points_m

FIXED_PX = 1.5
"""A marker that one pose brings this near to nine in ten of its sightings does not move."""
FASTEST_SIDES_S = 25.0
"""A marker carried by hand passes no more of its own sides in a second; more is a leap."""
LEAST_SIGMA_PX, TURNING_RAD_S, TURNING_RAD = 0.3, 3.0, 0.1
UNSEEN_S, FEWEST_ALIKE, FEWEST_SMOOTHED = 0.15, 3, 16


@dataclass(frozen=True, eq=False)
class FoundMarker:
    """A marker in the world.

    Attributes:
        side_m: of its black square.
        world_T_marker: where it is first, or always.
        path: where it is at every frame that has a pose; None where it does not move.
    """

    side_m: float
    world_T_marker: Motor
    path: Trajectory | None


def find_marker(
    recording: Recording, world_T_camera: Trajectory, marker_id: int, known: Motor | None
) -> FoundMarker:
    """Find a marker in all frames that have a pose.

    Args:
        recording: with pictures and a family of markers, or with recorded corners.
        world_T_camera: the camera's path, smoothed, by what does not move.
        marker_id: of the marker.
        known: its pose in the world, where a map tells one; taken if the pictures do not refute it.

    Raises:
        ValueError: no camera, no family to look for, or a marker that no frame shows.
    """
    stream, side_m = _sightings_of(recording, marker_id)
    inside = (stream.time_ns[stream.frame] >= world_T_camera.time_ns[0]) & (
        stream.time_ns[stream.frame] <= world_T_camera.time_ns[-1]
    )
    seen = CornerStream(
        stream.camera,
        stream.time_ns,
        stream.frame[inside],
        stream.marker_ids[inside],
        stream.corners_px[inside],
    )
    posed = pose_stream(seen, {marker_id: side_m})
    if not len(posed):
        raise ValueError(
            f"{recording.name}: placed.marker={marker_id}, but no frame with a pose shows it"
        )
    cameras = world_T_camera.motors_at(seen.time_ns[seen.frame])
    stamps = posed.time_ns[posed.frame]
    both = world_T_camera.motors_at(stamps).reshape(-1, 1) @ posed.camera_T_marker
    chosen = _likeliest(both, posed.error_px, 1e-9 * (stamps - stamps[0]))
    poses = both[np.arange(len(chosen)), chosen]
    for fixed in (known, _one_pose(poses, cameras, seen, side_m)):
        if fixed is not None and _explains(fixed, cameras, seen, side_m):
            return FoundMarker(side_m, fixed, None)
    frames_ns = stream.time_ns[
        (stream.time_ns >= world_T_camera.time_ns[0])
        & (stream.time_ns <= world_T_camera.time_ns[-1])
    ]
    path = _shown(poses, stamps, frames_ns, FASTEST_SIDES_S * side_m)
    return FoundMarker(side_m, path.motors[0], path)


def _sightings_of(recording: Recording, marker_id: int) -> tuple[CornerStream, float]:
    """Corners of one marker, all frames counting, and its size."""
    frames = recording.frames
    if isinstance(frames, CornerFrames):
        stream = frames.first
        if marker_id not in frames.side_m:
            raise ValueError(f"{recording.name}: placed.marker={marker_id} is none of its markers")
        side_m = frames.side_m[marker_id]
    else:
        loose = _looked_for(recording, marker_id)
        stream, side_m = markers_found(recording, loose)[0], loose.side_m
    own = stream.marker_ids == marker_id
    return CornerStream(
        stream.camera,
        stream.time_ns,
        stream.frame[own],
        stream.marker_ids[own],
        stream.corners_px[own],
    ), side_m


def _looked_for(recording: Recording, marker_id: int) -> LooseMarkers:
    board = recording.board
    if isinstance(board, MarkerGrid | SingleMarker) and marker_id in board.marker_ids:
        side_m = board.marker_m if isinstance(board, MarkerGrid) else board.side_m
        return LooseMarkers(board.family, side_m)
    if recording.markers is None:
        raise ValueError(
            f"{recording.name}: placed.marker={marker_id}, but no family of markers is known; name "
            "it in a manifest ([markers])"
        )
    return recording.markers


def _likeliest(both: Motor, error_px: FloatArray, time_s: FloatArray) -> IntArray:
    """Which of the two poses of each sighting: small errors, and little turning between them."""
    sigma = max(LEAST_SIGMA_PX, float(np.median(error_px[:, 0])))
    unary = 4.0 * (error_px / sigma) ** 2
    between = both[:-1, :, None].rotor.inverse() @ both[1:, None, :].rotor
    angle = np.linalg.norm(between.as_rotation_vector(), axis=-1)
    bearable = TURNING_RAD + TURNING_RAD_S * np.diff(time_s)
    steps = np.minimum(0.5 * (angle / bearable[:, None, None]) ** 2, 50.0)
    return most_probable(np.zeros(2), unary, steps)


def _one_pose(poses: Motor, cameras: Motor, seen: CornerStream, side_m: float) -> Motor:
    """The pose that explains all corners best, robustly."""
    from scipy.optimize import least_squares

    start = poses[int(np.argmin(_apart(poses)))]

    def residuals(twist: FloatArray) -> FloatArray:
        return _missed_px(start @ Motor.from_twist(twist), cameras, seen, side_m).ravel()

    found = least_squares(residuals, np.zeros(6), loss="soft_l1", x_scale=[1, 1, 1] + [side_m] * 3)
    return start @ Motor.from_twist(found.x)


def _apart(poses: Motor) -> FloatArray:
    """How far each pose is from the median place, metres."""
    places = poses.translation_m
    return np.asarray(np.linalg.norm(places - np.median(places, axis=0), axis=-1))


def _missed_px(
    world_T_marker: Motor, cameras: Motor, seen: CornerStream, side_m: float
) -> FloatArray:
    """(N, 4, 2) from each corner seen to where one pose of the marker has it."""
    corners = world_T_marker.apply(marker_points_m(side_m))
    camera: Camera = seen.camera
    return camera.project(cameras.inverse().reshape(-1, 1).apply(corners)) - seen.corners_px


def _explains(world_T_marker: Motor, cameras: Motor, seen: CornerStream, side_m: float) -> bool:
    missed = _missed_px(world_T_marker, cameras, seen, side_m)
    each = np.sqrt(np.mean(np.sum(missed**2, axis=-1), axis=-1))
    return bool(np.quantile(each, 0.9) <= FIXED_PX)


def _shown(poses: Motor, stamps: IntArray, frames_ns: IntArray, fastest_m_s: float) -> Trajectory:
    """The path at every frame: smooth between leaps, which are glided over."""
    time_s = 1e-9 * (stamps - frames_ns[0])
    passed = np.diff(time_s)
    step_m = np.linalg.norm(np.diff(poses.translation_m, axis=0), axis=-1)
    begins = np.flatnonzero((passed > UNSEEN_S) | (step_m > fastest_m_s * passed)) + 1
    parts = np.split(np.arange(len(stamps)), begins)
    # A few frames apart from what is before and after are wrong, unless there is nothing else.
    parts = [part for part in parts if len(part) >= FEWEST_ALIKE] or parts
    smoothed = [_smooth(Trajectory(stamps[part], poses[part])) for part in parts]
    rows = np.concatenate(parts)
    shown = followed(
        time_s[rows],
        Motor.concatenate(smoothed),
        1e-9 * (frames_ns - frames_ns[0]),
        fastest_m_s=fastest_m_s,
    )
    return Trajectory(frames_ns, shown, "world", "marker")


def _smooth(path: Trajectory) -> Motor:
    return path.motors if len(path) < FEWEST_SMOOTHED else smooth(path).motors
