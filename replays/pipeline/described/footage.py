"""What footage without a manifest is: its shots, of which one is run, and its camera.

Shots are found before anything is calibrated; the camera by a target in view, or by how wide it
sees.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from shlex import quote
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.progress import track
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.span import frames_between
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.replays.pipeline.described.values import (
    SampledImages,
    StatedLens,
    sample_rows,
    sampled_images,
)
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
from motorcade.tracking.cameras.camera import Camera, Zoom
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.self_calibration.lens import USUAL_FOCAL, doubt_of, view_deg, with_prior
from motorcade.tracking.shots import CameraMotion, ClipShot, Shots, find_shots
from motorcade.tracking.targets import (
    FoundTarget,
    SeenMarkers,
    corners_in_view,
    regapped,
    seen_markers,
)

_SURE_SIGMAS = 4.0
_ZOOM_GAP_S, _ZOOM_VIEWS = 0.25, 300


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """A camera and what speaks for it.

    Fields:
        camera: of the images.
        said: the same in words.
        source: what it was found by.
        target: as it was given, or with the gaps that this camera shows.
        shutter_s: ``(2,)`` of its read-out, from left to right and from top to bottom; 0 where
            nothing is known of it.
        doubts: what may be wrong with it.
        sigma: relative standard deviation of its focal length; 0 where it was told.
        zoom: focal lengths over the camera's, where the lens zooms.
    """

    camera: Camera
    said: str
    source: str
    target: FoundTarget | None
    shutter_s: tuple[float, float] = (0.0, 0.0)
    doubts: tuple[str, ...] = ()
    sigma: float = 0.0
    zoom: Zoom | None = None


def camera_by_view(size: tuple[int, int], fov_deg: float) -> Camera:
    """A lens without distortion that sees `fov_deg` along the longer side of its images."""
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
    is_known = math.isfinite(motion.focal_sigma)
    source = "how the image turns, and what is usual" if is_known else "what is usual"
    camera = camera_by_view(size, view_deg(focal))
    return FoundCamera(camera, said, source, None, doubts=(doubt_of(focal, sigma),), sigma=sigma)


def explained_by_rotation(recording: Recording, size: tuple[int, int]) -> bool:
    """Whether attitudes alone put corners where they are seen, in nearly every frame."""
    with suppress(TrackingError):
        camera = camera_by_view(size, view_deg(USUAL_FOCAL))
        poses = turning_poses(replace(recording, camera=camera))
        return len(poses.measurements) > 0.9 * len(recording.frames)
    return False


def camera_by_target(
    target: FoundTarget, sample: SampledImages, frames: FrameSequence
) -> FoundCamera:
    """The camera that saw a target, whose size does not matter.

    Of `frames` more are looked at where the lens zooms, and the sample is too thin to follow it.

    Raises:
        SelfCalibrationError: images that show it too seldom, or always from one side.
    """
    if target.family is not None and (target.board is None or isinstance(target.board, MarkerGrid)):
        seen = seen_markers(target.family, sample.images, set(target.marker_ids))
        detections = [_detections(str(target.family), markers) for markers in seen.markers]
        calibrated = self_calibrate_tags(detections, sample.size, sample.time_ns)
        if isinstance(target.board, MarkerGrid):
            target = replace(target, board=regapped(target.board, seen.markers, calibrated.camera))
        return _said(calibrated, "the markers in view", target)
    board = target.board
    if board is None:
        raise ValueError("target: expected a board or markers, got neither")
    views = [board.detect(image) for image in sample.images]
    if isinstance(board, Checkerboard):
        for row in sample.places:
            # A whole board's neighbours tell of the shutter; a part of one only of the lens.
            views[row] = views[row] or corners_in_view(board, sample.images[row])
    calibrated = self_calibrate_board(views, sample.size, sample.time_ns)
    gap_s = 1e-9 * float(np.ptp(sample.time_ns)) / len(sample.places)
    if calibrated.zoom is not None and gap_s > _ZOOM_GAP_S:
        rows = np.unique(np.linspace(0, len(frames) - 1, _ZOOM_VIEWS).astype(np.int64))
        views = [board.detect(frames[row].gray()) for row in rows.tolist()]
        calibrated = self_calibrate_board(views, sample.size, frames.time_ns[rows])
    return _said(calibrated, "the board in view", target)


def camera_by_motion(frames: FrameSequence, size: tuple[int, int]) -> FoundCamera:
    """The camera that moved through a scene without targets.

    Raises:
        SelfCalibrationError: motion or texture from which no camera follows.
    """
    images = (frame.gray() for frame in track(frames, "finding the camera", len(frames)))
    return _said(self_calibrate_motion(images, size, frames.time_ns), "the motion of the scene")


def _said(
    self_calibration: SelfCalibration, by: str, target: FoundTarget | None = None
) -> FoundCamera:
    said = (
        f"{self_calibration.camera.model}, focal length {self_calibration.camera.fx:.0f} px ± "
        f"{100.0 * self_calibration.sigma_focal:.2g} %, {self_calibration.rms_px:.2g} px RMS "
        f"over {self_calibration.views} frames"
    )
    source = f"self-calibration by {by}"
    shutter_s = _shutter_s(self_calibration)
    return FoundCamera(
        self_calibration.camera,
        said,
        source,
        target,
        shutter_s,
        self_calibration.doubts,
        self_calibration.sigma_focal,
        self_calibration.zoom,
    )


def _shutter_s(self_calibration: SelfCalibration) -> tuple[float, float]:
    """The read-out along both axes, where it is more than its own uncertainty."""
    readout = self_calibration.readout
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


log = logging.getLogger("motorcade.graph")


_SQUARE = 0.005
"""What rounding leaves of a pixel's width over its height."""


class ChosenShot:
    """The shot that is run.

    Args:
        recording: all of it.
        number: of the shot, from 1; 0 for the longest.
        lenient: whether images with nothing to see are taken as a shot.

    Attributes:
        recording: its frames alone.
        shot, shots: what it is, and beside which others.
        sample: images spread over it.

    Raises:
        ValueError: a number that no shot has, nothing to see, or a part of frames without parts.
    """

    def __init__(self, recording: Recording, number: int, *, lenient: bool = False) -> None:
        frames, name = recording.frames, recording.name
        kept: dict[int, GrayImage] = {}
        self.shots = find_shots(_read(frames, kept))
        count = len(self.shots.shots)
        if not count and lenient:
            alone = ClipShot(0, len(frames) - 1, CameraMotion("unknown"))
            self.shots, count = Shots((alone,), (), len(frames)), 1
        if not count:
            between = ", ".join(
                f"{each.first}-{each.last} {each.kind}" for each in self.shots.breaks[:4]
            )
            raise ValueError(
                f"{name}: expected images with something to see, got {len(frames)} that are "
                f"black, plain or too few to follow one another: {between}"
            )
        if number > count:
            raise ValueError(f"--shot: {name} has {count} shots, got {number}")
        self.row = number - 1 if number else self.shots.longest
        self.shot: ClipShot = self.shots.shots[self.row]
        log.info("%s: %s", name, self.said)
        self.whole = len(self.shot) == len(frames)
        if not self.whole and isinstance(frames, VideoFrames | ImageFrames):
            stamps = frames.time_ns[[self.shot.first, self.shot.last]]
            part = frames_between(frames, int(stamps[0]), int(stamps[1]))
            recording, kept = replace(recording, frames=part), {}
        self.recording = recording
        self.sample: SampledImages = sampled_images(recording.frames, kept)

    @property
    def said(self) -> str:
        """The shots, and which is run, in one line."""
        text = self.shots.described(self.row)
        others = [row for row in range(len(self.shots.shots)) if row != self.row]
        if others:
            text += f"; --shot {others[0] + 1} runs the {'other' if len(others) == 1 else 'next'}"
            text += ", --all-shots all"
        return text

    def span_toml(self, time_s: NDArray[np.floating[Any]]) -> str:
        """Keys of a manifest's `[frames]` that take these of all frames, whose stamps are given.

        Empty if they are all.
        """
        if len(self.recording.frames) == len(time_s):
            return ""
        first, last = self.shot.first, self.shot.last
        before, after = time_s[max(first - 1, 0)], time_s[min(last + 1, len(time_s) - 1)]
        start_s, end_s = 0.5 * (before + time_s[first]), 0.5 * (after + time_s[last])
        return f"start_s = {float(start_s):.6f}\nend_s = {float(end_s):.6f}\n"


def _read(frames: FrameSequence, kept: dict[int, GrayImage]) -> Iterator[GrayImage]:
    """Grey images one after another; those that a sample takes are kept."""
    rows: set[int] = set()
    for number, frame in enumerate(track(frames, "looking for shots", len(frames))):
        gray = np.asarray(frame.gray())
        if not number:
            rows = set(sample_rows(len(frames), gray.size)[0].tolist())
        if number in rows:
            kept[number] = gray
        yield gray


def refuse_oblong_pixels(recording: Recording) -> None:
    """Cameras are found for square pixels alone.

    Raises:
        ValueError: a video that is to be shown wider or narrower than it is stored.
    """
    frames = recording.frames
    if not isinstance(frames, VideoFrames) or abs(frames.pixel_aspect - 1) < _SQUARE:
        return
    name, wide = frames.path.name, float(frames.pixel_aspect)
    raise ValueError(
        f"{recording.name}: expected square pixels, got ones that are shown {wide:.3g} "
        f"times as wide as high: make them square first: ffmpeg -i {quote(name)} "
        "-vf 'scale=trunc(iw*sar/2)*2:ih,setsar=1' square.mp4"
    )
