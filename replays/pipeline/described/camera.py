"""The camera of a recording that names none: by a target in view, or by how wide it sees."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace

from motorcade.ga.progress import track
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.replays.pipeline.described.stated import StatedLens
from motorcade.replays.pipeline.described.values import SampledPictures
from motorcade.replays.stages.camera.turning_poses import turning_poses
from motorcade.tracking import (
    Checkerboard,
    Detection,
    MarkerGrid,
    SelfCalibration,
    TrackingError,
    self_calibrate_board,
    self_calibrate_motion,
    self_calibrate_tags,
)
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.self_calibration.lens import USUAL_FOCAL
from motorcade.tracking.self_calibration.usual import doubt_of, view_deg, with_prior
from motorcade.tracking.shots import CameraMotion
from motorcade.tracking.targets import (
    FoundTarget,
    SeenMarkers,
    corners_in_view,
    regapped,
    seen_markers,
)

_SURE_SIGMAS = 4.0


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """A camera and what speaks for it.

    Fields:
        camera: of the pictures.
        said: the same in words.
        source: what it was found by.
        target: as it was given, or with the gaps that this camera shows.
        shutter_s: ``(2,)`` of its read-out, from left to right and from top to bottom; 0 where
            nothing is known of it.
        doubts: what may be wrong with it.
        sigma: relative standard deviation of its focal length; 0 where it was told.
    """

    camera: Camera
    said: str
    source: str
    target: FoundTarget | None
    shutter_s: tuple[float, float] = (0.0, 0.0)
    doubts: tuple[str, ...] = ()
    sigma: float = 0.0


def camera_by_view(size: tuple[int, int], fov_deg: float) -> Camera:
    """A lens without distortion that sees `fov_deg` along the longer side of its pictures."""
    focal = 0.5 * max(size) / math.tan(math.radians(0.5 * fov_deg))
    return Camera(*size, focal, focal, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1))


def camera_of_fixed_place(
    motion: CameraMotion, size: tuple[int, int], stated: StatedLens | None
) -> FoundCamera:
    """The camera of a shot in which it stays at its place: stated, by its turns, or a usual one."""
    if stated is not None and stated.camera is not None:
        doubts = ("the lens is as the file states it: good to look at, not to measure with",)
        return FoundCamera(stated.camera, stated.said, "the file's own notes", None, doubts=doubts)
    focal, sigma = with_prior(motion.focal, motion.focal_sigma)
    said = f"a lens without distortion that sees {view_deg(focal):.0f} degrees"
    told = math.isfinite(motion.focal_sigma)
    source = "how the picture turns, and what is usual" if told else "what is usual"
    camera = camera_by_view(size, view_deg(focal))
    return FoundCamera(camera, said, source, None, doubts=(doubt_of(focal, sigma),), sigma=sigma)


def explained_by_rotation(recording: Recording, size: tuple[int, int]) -> bool:
    """Whether attitudes alone put corners where they are seen, in nearly every frame."""
    with suppress(TrackingError):
        camera = camera_by_view(size, view_deg(USUAL_FOCAL))
        poses = turning_poses(replace(recording, camera=camera))
        return len(poses.measurements) > 0.9 * len(recording.frames)
    return False


def camera_by_target(target: FoundTarget, sample: SampledPictures) -> FoundCamera:
    """The camera that saw a target, whose size does not matter.

    Raises:
        SelfCalibrationError: pictures that show it too seldom, or always from one side.
    """
    if target.family is not None and (target.board is None or isinstance(target.board, MarkerGrid)):
        seen = seen_markers(target.family, sample.pictures, set(target.marker_ids))
        frames = [_detections(str(target.family), one) for one in seen.markers]
        made = self_calibrate_tags(frames, sample.size, sample.time_ns)
        if isinstance(target.board, MarkerGrid):
            target = replace(target, board=regapped(target.board, seen.markers, made.camera))
        return _said(made, "the markers in view", target)
    board = target.board
    if board is None:
        raise ValueError("target: expected a board or markers, got neither")
    views = [board.detect(image) for image in sample.pictures]
    if isinstance(board, Checkerboard):
        for row in sample.places:
            # A whole board's neighbours tell of the shutter; a part of one only of the lens.
            views[row] = views[row] or corners_in_view(board, sample.pictures[row])
    made = self_calibrate_board(views, sample.size, sample.time_ns)
    return _said(made, "the board in view", target)


def camera_by_motion(frames: FrameSequence, size: tuple[int, int]) -> FoundCamera:
    """The camera that moved through a scene without targets.

    Raises:
        SelfCalibrationError: motion or texture from which no camera follows.
    """
    pictures = (frame.gray() for frame in track(frames, "finding the camera", len(frames)))
    return _said(self_calibrate_motion(pictures, size, frames.time_ns), "the motion of the scene")


def _said(made: SelfCalibration, by: str, target: FoundTarget | None = None) -> FoundCamera:
    said = (
        f"{made.camera.model}, focal length {made.camera.fx:.0f} px ± "
        f"{100.0 * made.sigma_focal:.2g} %, {made.rms_px:.2g} px RMS over {made.views} frames"
    )
    source = f"self-calibration by {by}"
    shutter_s = _shutter_s(made)
    return FoundCamera(made.camera, said, source, target, shutter_s, made.doubts, made.sigma_focal)


def _shutter_s(made: SelfCalibration) -> tuple[float, float]:
    """The read-out along both axes, where it is more than its own uncertainty."""
    readout = made.readout
    if readout is None or readout.seconds < _SURE_SIGMAS * readout.sigma_s:
        return 0.0, 0.0
    way = {"right": (1.0, 0.0), "left": (-1.0, 0.0), "down": (0.0, 1.0), "up": (0.0, -1.0)}
    across, down = way[readout.axis]
    return across * readout.seconds, down * readout.seconds


def _detections(family: str, seen: SeenMarkers) -> list[Detection]:
    return [
        Detection(family, int(marker), corners, 0, 1.0, sharp=True)
        for marker, corners in zip(seen.ids, seen.corners_px, strict=True)
    ]
