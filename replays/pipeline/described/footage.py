"""What footage without a manifest is: its shots, of which one is run, and its camera.

Shots are found before anything is calibrated; the camera by a target in view, or by how wide it
sees.

How a GoPro's camera sits on the IMU of its telemetry: that is named by its axes: "up/down,
right/left, forward/back" are stored as z, x, y, on cameras since HERO8 as ORIN says, and
`readers.gopro` turns both to x, y, z. The lens looks along -y, the images' right is -x, their down
is -z. (Sources: gpmf-parser's README for the order; the signs from a HERO5's own footage.) The lens
is taken to be where the IMU is: they are some 3 cm apart, and no maker says how. Whether a clip
agrees is checked: features of neighbouring frames turn as the gyroscope says. Of all 24 ways in
which two right-handed frames can be laid on each other, none may fit clearly better than the stated
one. The gyroscope tells the focal length, too, where the camera pans.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import permutations, product
from shlex import quote
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu import ImuStream
from motorcade.ga.arrays import FloatArray
from motorcade.ga.progress import track
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.frames.views import frames_between
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
from motorcade.tracking.images import track_corners
from motorcade.tracking.self_calibration.lens import USUAL_FOCAL, doubt_of, view_deg, with_prior
from motorcade.tracking.shots import CameraMotion, ClipShot, Shots, find_shots
from motorcade.tracking.targets import (
    FoundTarget,
    SeenMarkers,
    corners_in_view,
    regapped,
    seen_markers,
)

GOPRO_IMU_R_CAMERA = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
_PAIRS = 24
_FEATURES, _FEWEST, _APART_PX = 200, 20, 12.0
_ROUNDS = 5
_LEAST_RATE_RAD_S = 0.02
_FEWEST_PAIRS = 6
_ALIKE, _AS_GOOD, _BETTER = 0.7, 0.05, 0.3
_LEAST_PAN_RAD_S, _FOCAL_ROUNDS = 0.05, 6
_ALIKE_FOCAL, _WORST_SIGMA = 0.9, 0.05

Verdict = Literal["agree", "contradict", "do not tell"]


@dataclass(frozen=True)
class AxesCheck:
    """Whether images and gyroscope agree on how the camera sits.

    Fields:
        verdict: what the images say of it.
        likeness: of both rates, as stated: their correlation about zero, 1 where they are alike.
        best: the same, of the best of all ways.

    >>> from motorcade.replays.pipeline.described.footage import AxesCheck
    >>> AxesCheck("agree", 0.97, 0.97).verdict
    'agree'
    """

    verdict: Verdict
    likeness: float
    best: float


def check_axes(turns: SeenTurns, camera: Camera, imu_R_camera: FloatArray) -> AxesCheck:
    """Ask pairs of neighbouring frames whether they turned as the gyroscope says.

    Breaks down where near things pass by: that the camera moves counts as turning here.
    """
    seen, stated_rad_s = turns.seen_rad_s(camera), turns.rate_rad_s
    known = np.isfinite(seen).all(axis=-1)
    seen, stated_rad_s = seen[known], stated_rad_s[known]
    sizes = float(np.linalg.norm(seen) * np.linalg.norm(stated_rad_s))
    if (
        len(seen) < _FEWEST_PAIRS
        or np.sqrt((stated_rad_s**2).sum(axis=-1).mean()) < _LEAST_RATE_RAD_S
    ):
        return AxesCheck("do not tell", 0.0, 0.0)
    likeness = {
        way.tobytes(): float(((seen @ way.T) * stated_rad_s).sum()) / max(sizes, 1e-12)
        for way in _ways()
    }
    stated, best = likeness[(np.rint(imu_R_camera) + 0.0).tobytes()], max(likeness.values())
    if stated >= _ALIKE and best - stated <= _AS_GOOD:
        return AxesCheck("agree", stated, best)
    against = best >= _ALIKE and best - stated >= _BETTER
    return AxesCheck("contradict" if against else "do not tell", stated, best)


def _ways() -> list[FloatArray]:
    """All rotations ``(3, 3)`` that lay axes on axes."""
    ways = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        way = np.zeros((3, 3))
        way[range(3), order] = signs
        if np.linalg.det(way) > 0.0:
            ways.append(way + 0.0)
    return ways


@dataclass(frozen=True, eq=False)
class SeenTurns:
    """Features of pairs of neighbouring frames, and how fast the IMU turned between them.

    Fields:
        before, after: px ``(n, 2)`` of each pair.
        seconds: ``(p,)`` between the two.
        rate_rad_s: ``(p, 3)`` mean angular rate, in the IMU's frame.
    """

    before: tuple[FloatArray, ...]
    after: tuple[FloatArray, ...]
    seconds: FloatArray
    rate_rad_s: FloatArray

    def seen_rad_s(self, camera: Camera) -> FloatArray:
        """Rates ``(p, 3)`` in the camera's frame, as if it only turned; NaN where none fits."""
        turns = [_turn(*pair, camera) for pair in zip(self.before, self.after, strict=True)]
        rates: FloatArray = np.array(turns).reshape(-1, 3) / self.seconds[:, None]
        return rates


def seen_turns(frames: FrameSequence, imu: ImuStream) -> SeenTurns:
    """Follow features between neighbouring frames at places that are spread over a recording."""
    stamps = frames.time_ns
    inside = (stamps[:-1] >= imu.time_ns[0]) & (stamps[1:] <= imu.time_ns[-1])
    rows = np.flatnonzero(inside)
    if len(rows):
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, _PAIRS).astype(int))]
    before, after, seconds, rates = [], [], [], []
    for row in map(int, rows):
        during = (imu.time_ns >= stamps[row]) & (imu.time_ns <= stamps[row + 1])
        px, there = _followed(frames[row].gray(), frames[row + 1].gray())
        if len(px) >= _FEWEST and during.any():
            before.append(px)
            after.append(there)
            seconds.append(1e-9 * float(stamps[row + 1] - stamps[row]))
            rates.append(imu.angular_rate_rad_s[during].mean(axis=0))
    rate = np.array(rates).reshape(-1, 3)
    return SeenTurns(tuple(before), tuple(after), np.array(seconds), rate)


def _followed(before: GrayImage, after: GrayImage) -> tuple[FloatArray, FloatArray]:
    """Features ``(n, 2)`` of one image, and where they are in the other."""
    corners = cv2.goodFeaturesToTrack(before, _FEATURES, 0.01, _APART_PX)
    if corners is None:
        return np.zeros((0, 2)), np.zeros((0, 2))
    px = corners.reshape(-1, 2).astype(np.float64)
    there, kept = track_corners(before, after, px, px)
    return px[kept], there[kept]


def _turn(before: FloatArray, after: FloatArray, camera: Camera) -> FloatArray:
    """The camera's rotation vector ``(3,)`` between two images, as if it only turned."""
    first, second = camera.bearings(before), camera.bearings(after)
    known = np.isfinite(first).all(axis=-1) & np.isfinite(second).all(axis=-1)
    if np.count_nonzero(known) < _FEWEST:
        return np.full(3, np.nan)
    middle = 0.5 * (first + second)[known]
    # A point that stands still moves by -(turn x bearing) in the camera's frame.
    rows = np.stack([np.cross(axis, middle) for axis in np.eye(3)], axis=-1)
    moved, weight, turn = (first - second)[known], np.ones(len(middle)), np.zeros(3)
    for _ in range(_ROUNDS):
        weighed = rows * weight[:, None, None]
        turn = np.linalg.lstsq(
            np.einsum("nij,nik->jk", weighed, rows), np.einsum("nij,ni->j", weighed, moved)
        )[0]
        off = np.linalg.norm(rows @ turn - moved, axis=-1)
        weight = 1.0 / np.maximum(off, np.median(off) + 1e-9)
    return np.asarray(turn)


@dataclass(frozen=True)
class TurnedFocal:
    """A focal length by what the images and the gyroscope say of the same turns.

    Fields:
        camera: square pixels, centre in the middle, no distortion.
        sigma: relative standard deviation of its focal length.
        pairs: of frames that were compared.
    """

    camera: Camera
    sigma: float
    pairs: int


def camera_by_turning(turns: SeenTurns, size: tuple[int, int]) -> TurnedFocal | None:
    """The focal length with which the images pan and tilt as fast as a GoPro's gyroscope says.

    None where the camera hardly pans, or both disagree. Near things that pass by, and a lens that
    bends, are errors here, and not told.
    """
    rates = turns.rate_rad_s @ GOPRO_IMU_R_CAMERA
    rates_seen = rates[:, :2]
    if (
        len(rates_seen) < _FEWEST_PAIRS
        or np.sqrt((rates_seen**2).sum(axis=-1).mean()) < _LEAST_PAN_RAD_S
    ):
        return None
    focal = 0.6 * max(size)
    middle = 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)
    for _ in range(_FOCAL_ROUNDS):
        camera = Camera(*size, focal, focal, *middle)
        seen = turns.seen_rad_s(camera)[:, :2]
        known = np.isfinite(seen).all(axis=-1)
        if np.count_nonzero(known) < _FEWEST_PAIRS:
            return None
        seen, truth = seen[known], rates_seen[known]
        ratio = float((seen * truth).sum() / (truth * truth).sum())
        if not 0.2 < ratio < 5.0:
            return None
        focal *= ratio
    likeness = float((seen * truth).sum() / (np.linalg.norm(seen) * np.linalg.norm(truth)))
    off = seen - ratio * truth
    sigma = float(np.sqrt((off**2).sum() / off.size / (truth**2).sum()))
    if likeness < _ALIKE_FOCAL or sigma > _WORST_SIGMA:
        return None
    return TurnedFocal(Camera(*size, focal, focal, *middle), sigma, len(truth))


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
