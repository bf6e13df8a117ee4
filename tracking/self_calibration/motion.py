"""Self-calibration from a moving camera alone: corners tracked through a scene with depth.

Visual SLAM runs with a guessed lens, which is enough to find a path and points; a bundle adjustment
then frees the lens, and SLAM runs again with what was found. Last, the map's points are found again
in many frames between the keyframes, and all is fitted once more, at the end by halves of the
frames too, which shows how sure the focal length is.

Where the camera only turns there is a focal length but no path; where the scene is flat or the
camera only goes ahead, focal length and depth can hardly be told apart: such clips are refused.

Sources: Hartley & Zisserman 2003, ch. 19; Pollefeys et al. 1999 (a metric camera from its motion);
Wu 2014 (what a free focal length and k1 cannot tell).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.markers.corner_stream import checked_stamps
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.pictures import track_corners
from motorcade.tracking.self_calibration.bodies import velocities
from motorcade.tracking.self_calibration.lens import FOCAL_SPREAD, KINDS, LensKind, start_numbers
from motorcade.tracking.self_calibration.points import (
    PointFit,
    PointSightings,
    PointState,
    fit_points,
)
from motorcade.tracking.self_calibration.result import SelfCalibration, SelfCalibrationError
from motorcade.tracking.self_calibration.shutter import fit_with_shutter
from motorcade.tracking.slam.features import find_corners
from motorcade.tracking.slam.initialise import flow_beyond_rotation_px
from motorcade.tracking.slam.results import SlamResult
from motorcade.tracking.slam.slam import VisualSlam

_STARTS = (0.72, 0.45, 1.1, 1.7)
"""Focal lengths to start from, in long sides: a phone's main, wide and long cameras."""
_KIND = next(kind for kind in KINDS if kind.name == "radtan with k1 k2")
_SIMPLER: tuple[LensKind, ...] = tuple(
    kind for name in ("radtan with k1", "pinhole") for kind in KINDS if kind.name == name
)
_LONG_SIDE = 960  # pictures are tracked at this size: finer ones cost time and tell little more
_MOST_FRAMES = 450
_MOST_VIEWS = 40
_TRACKED_SHARE = 0.6
_FEWEST_VIEWS, _FEWEST_POINTS = 4, 60
_LEAST_PARALLAX_DEG = 2.0
_TURN_PX, _TURN_SHARE = 1.0, 0.06
_DOUBTFUL_FOCAL = 0.01
_FEWEST_CORNERS = 80


@dataclass(frozen=True, eq=False)
class _Frames:
    """Pictures as they are tracked."""

    time_ns: IntArray
    pictures: Sequence[GrayImage]
    size: tuple[int, int]  # of the pictures as given

    @property
    def scale(self) -> float:
        """Pixels as given in one as tracked."""
        return float(self.size[0] / self.small[0])

    @property
    def small(self) -> tuple[int, int]:
        """Width and height as tracked."""
        return self.pictures[0].shape[1], self.pictures[0].shape[0]


def self_calibrate_motion(
    pictures: Iterable[GrayImage], size: tuple[int, int], time_ns: Sequence[int] | IntArray
) -> SelfCalibration:
    """Find the camera of a clip that shows neither board nor tags, from how the scene moves.

    Args:
        pictures: upright grey frames in order, neighbours of the clip; the first 450 are taken.
        size: width and height of the pictures, pixels.
        time_ns: ``(F,)`` stamps of the frames, strictly increasing.

    Raises:
        SelfCalibrationError: too little texture, a camera that only turns, or motion from which
            the focal length does not follow.
        ValueError: pictures of another size.

    >>> import numpy as np
    >>> from motorcade.tracking import SelfCalibrationError, self_calibrate_motion
    >>> gray = [np.full((480, 640), 128, np.uint8)] * 6  # a plain wall
    >>> try:
    ...     self_calibrate_motion(gray, (640, 480), 33_000_000 * np.arange(6))
    ... except SelfCalibrationError as error:
    ...     print(error)
    pictures: expected 80 corners to follow, got 0: the scene is too plain to tell the camera from
    """
    frames = _reduced(pictures, size, checked_stamps(np.asarray(time_ns), "time_ns"))
    corners = len(find_corners(frames.pictures[0], 4 * _FEWEST_CORNERS))
    if corners < _FEWEST_CORNERS:
        raise SelfCalibrationError(
            f"pictures: expected {_FEWEST_CORNERS} corners to follow, got {corners}: the scene is "
            "too plain to tell the camera from"
        )
    _refuse_turning(frames)
    mapped = _first_map(frames)
    if mapped is None:
        raise SelfCalibrationError(
            "pictures: expected a motion that visual SLAM can follow, got none with any focal "
            "length; move sideways past things at different depths, slowly"
        )
    result, camera = mapped
    seen, start, velocity = _densified(frames, result, camera)
    straight, found, readout = fit_with_shutter(seen, start, velocity)
    return replace(_checked(frames, straight, found), readout=readout)


def _reduced(pictures: Iterable[GrayImage], size: tuple[int, int], time_ns: IntArray) -> _Frames:
    step = max(1, -(-max(size) // _LONG_SIDE))
    small = (size[0] // step, size[1] // step)
    kept: list[GrayImage] = []
    for number, picture in enumerate(islice(pictures, _MOST_FRAMES)):
        gray = checked_gray(picture)
        if gray.shape != (size[1], size[0]):
            raise ValueError(
                f"pictures[{number}]: expected {size[0]} x {size[1]} pixels, got "
                f"{gray.shape[1]} x {gray.shape[0]}"
            )
        part = gray[: small[1] * step, : small[0] * step]
        reduced = part if step == 1 else cv2.resize(part, small, interpolation=cv2.INTER_AREA)
        kept.append(np.asarray(reduced, np.uint8))
    if len(kept) < _FEWEST_VIEWS or len(time_ns) < len(kept):
        raise SelfCalibrationError(
            f"pictures: expected at least {_FEWEST_VIEWS} frames and a stamp each, got "
            f"{len(kept)} with {len(time_ns)}"
        )
    return _Frames(time_ns[: len(kept)], kept, (small[0] * step, small[1] * step))


def _middle(size: tuple[int, int], share: float) -> Camera:
    return KINDS[0].camera(start_numbers(share * max(size), size), size)


def _refuse_turning(frames: _Frames) -> None:
    """Refuse a clip in which every motion of the corners is a turn about the lens."""
    least: list[tuple[float, float, float]] = []
    for first_px, px in _followed(frames):
        flow = float(np.median(np.linalg.norm(px - first_px, axis=-1)))
        shares = np.geomspace(0.35, 2.5, 24)
        left = [
            flow_beyond_rotation_px(first_px, px, _middle(frames.small, share)) for share in shares
        ]
        best = int(np.argmin(left))
        least.append((left[best], flow, shares[best]))
    if not least:
        raise SelfCalibrationError(
            "pictures: expected corners that move through the picture, got none: the camera "
            "stands still, or moves too fast to be followed"
        )
    beyond, moved, told = np.array(least).T
    if np.all(beyond < np.maximum(_TURN_PX, _TURN_SHARE * moved)):
        focal = float(np.median(told)) * max(frames.size)
        raise SelfCalibrationError(
            "pictures: expected a camera that changes its place, got one that only turns (a focal "
            f"length of about {focal:.0f} pixels explains all motion); no path and no depth "
            "follow from that: move sideways past things at different depths"
        )


def _followed(frames: _Frames) -> list[tuple[FloatArray, FloatArray]]:
    """Corners of some frames, and where they are when they have moved far."""
    far = 0.12 * max(frames.small)
    found = []
    for first in np.linspace(0, len(frames.pictures) - 2, 6).astype(int):
        start = find_corners(frames.pictures[first], 300).px
        rows, px = np.arange(len(start)), start
        motion, before = np.zeros_like(px), Pyramid(frames.pictures[first])
        for picture in frames.pictures[first + 1 :]:
            after = Pyramid(picture)
            there, good = track_corners(before, after, px, px + motion)
            motion, before = (there - px)[good], after
            rows, px = rows[good], there[good]
            if len(px) < _FEWEST_CORNERS:
                break
            if np.median(np.linalg.norm(px - start[rows], axis=-1)) > far:
                break
        if len(px) >= _FEWEST_CORNERS // 2:
            moved = float(np.median(np.linalg.norm(px - start[rows], axis=-1)))
            if moved > 0.25 * far:
                found.append((start[rows], px))
    return found


def _first_map(frames: _Frames) -> tuple[SlamResult, Camera] | None:
    """A map by SLAM, and the camera it was made with: once with a guess, once with what it told."""
    for share in _STARTS:
        camera = _middle(frames.small, share)
        result = _mapped(frames, camera)
        if result is None:
            continue
        seen, state = _of_map(frames, result, camera)
        freed = _unfolded(frames, seen, fit_points(seen, state)).state
        camera = freed.kind.camera(freed.numbers, frames.small)
        again = _mapped(frames, camera)
        if again is not None:
            return again, camera
    return None


def _mapped(frames: _Frames, camera: Camera) -> SlamResult | None:
    """SLAM over all frames; None where it follows too few of them."""
    slam = VisualSlam(camera)
    for stamp, picture in zip(frames.time_ns.tolist(), frames.pictures, strict=True):
        slam.track(stamp, picture)
    result = slam.finish()
    if result.trajectory is None or len(result.map.points) < _FEWEST_POINTS:
        return None
    enough = len(result.trajectory) >= _TRACKED_SHARE * len(frames.pictures)
    return result if enough and len(result.map.time_ns) >= 2 else None


def _of_map(
    frames: _Frames, result: SlamResult, camera: Camera
) -> tuple[PointSightings, PointState]:
    """What the keyframes saw, in the pixels of the pictures."""
    layout = result.map
    px = camera.distort(layout.px)
    rows = np.flatnonzero(np.isfinite(px).all(axis=-1))
    points, which = np.unique(layout.point_of[rows], return_inverse=True)
    seen = PointSightings(frames.small, layout.keyframe_of[rows], which, px[rows])
    poses, places = layout.world_T_camera, layout.points[points]
    return seen, PointState(_KIND, _numbers(camera), poses, places)


def _numbers(camera: Camera) -> FloatArray:
    radial = camera.distortion[:2] or (0.0, 0.0)
    return np.array([camera.fx, camera.cx, camera.cy, *radial])


def _densified(
    frames: _Frames, result: SlamResult, camera: Camera
) -> tuple[PointSightings, PointState, FloatArray]:
    """The map's points found again in frames spread over the path, from the nearest keyframe.

    Returns:
        what was seen, from where, and how fast each view moved ``(V, 6)``.
    """
    path, layout = result.trajectory, result.map
    assert path is not None
    chosen = np.unique(np.linspace(0, len(path) - 1, _MOST_VIEWS).astype(np.int64))
    keyframes = np.searchsorted(frames.time_ns, layout.time_ns)
    shown = camera.distort(layout.px)
    views, points, pixels = [], [], []
    poses: list[Motor] = []
    velocity = velocities(1e-9 * (path.time_ns - path.time_ns[0]), path.motors)
    moved: list[FloatArray] = []
    for row in chosen.tolist():
        number = int(np.searchsorted(frames.time_ns, path.time_ns[row]))
        nearest = int(np.argmin(np.abs(keyframes - number)))
        rows = np.flatnonzero((layout.keyframe_of == nearest) & np.isfinite(shown).all(axis=-1))
        pose = path.motors[row]
        guess = camera.project(
            pose.inverse().apply(layout.points[layout.point_of[rows]]), allow_nan=True
        )
        rows, guess = rows[np.isfinite(guess).all(axis=-1)], guess[np.isfinite(guess).all(axis=-1)]
        there, good = track_corners(
            frames.pictures[keyframes[nearest]], frames.pictures[number], shown[rows], guess
        )
        if np.count_nonzero(good) < _FEWEST_POINTS // 2:
            continue
        views.append(np.full(int(good.sum()), len(poses)))
        points.append(layout.point_of[rows[good]])
        pixels.append(there[good])
        poses.append(pose)
        moved.append(velocity[row])
    if len(poses) < _FEWEST_VIEWS:
        raise SelfCalibrationError("pictures: expected frames that show one scene, got too few")
    seen = PointSightings(
        frames.small, np.concatenate(views), np.concatenate(points), np.concatenate(pixels)
    )
    start = PointState(_KIND, _numbers(camera), Motor.stack(poses), layout.points)
    return *_often_seen(seen, start), np.stack(moved)


def _often_seen(
    seen: PointSightings, state: PointState, least: int = 3
) -> tuple[PointSightings, PointState]:
    """Only points that enough views see, numbered anew; views keep their numbers."""
    counts = np.bincount(seen.point, minlength=len(state.points))
    rows = np.flatnonzero(counts[seen.point] >= least)
    points, which = np.unique(seen.point[rows], return_inverse=True)
    kept = replace(seen, view=seen.view[rows], point=which, px=seen.px[rows])
    return kept, replace(state, points=state.points[points])


def _checked(frames: _Frames, seen: PointSightings, found: PointFit) -> SelfCalibration:
    """The camera in the pictures' own pixels, if it follows from what was seen."""
    parallax = _parallax_deg(seen, found.state)
    if parallax < _LEAST_PARALLAX_DEG:
        raise SelfCalibrationError(
            "pictures: expected things seen from directions that differ by "
            f"{_LEAST_PARALLAX_DEG:g} degrees and more, got {parallax:.1f} in the middle: go "
            "farther sideways, or nearer"
        )
    found = _unfolded(frames, seen, found)
    numbers, views = found.state.numbers, int(found.state.world_T_camera.shape[0])
    halves = [fit_points(*_half(seen, found.state, one)).state.numbers[0] for one in (0, 1)]
    formal = float(np.sqrt(found.covariance[0, 0])) / numbers[0]
    sigma = max(formal, abs(halves[0] - halves[1]) / (2.0 * numbers[0]))
    if not sigma <= FOCAL_SPREAD:
        raise SelfCalibrationError(
            f"pictures: expected a motion that tells the focal length, got "
            f"{numbers[0] * frames.scale:.0f} pixels +- {sigma:.0%}, no better than a guess: a "
            "flat scene, or a camera that goes straight ahead, does not tell it; move sideways "
            "past things at different depths, and turn while you do"
        )
    inside = np.linalg.norm(found.residuals_px, axis=-1) < 6.0 * found.noise_px
    rms = float(np.sqrt((found.residuals_px[inside] ** 2).sum(axis=-1).mean()))
    doubts = ["found from the scene's motion alone: a printed board or tag tells the lens better"]
    if sigma > _DOUBTFUL_FOCAL:
        doubts.append(f"the focal length is known to {sigma:.1%} only")
    return SelfCalibration(
        _full_size(found, frames),
        "motion",
        float(sigma),
        f"{found.state.kind.name}: what a scene without a print can tell",
        rms * frames.scale,
        views,
        doubts=tuple(doubts),
    )


def _unfolded(frames: _Frames, seen: PointSightings, found: PointFit) -> PointFit:
    """The same; where its terms fold back in the picture, the fit with as many as do not."""
    for kind in (_KIND, *_SIMPLER):
        if kind.terms < found.state.kind.terms:
            numbers = kind.start(found.state.numbers, kind.terms)
            found = fit_points(seen, replace(found.state, kind=kind, numbers=numbers))
        if not _full_size(found, frames).folds():
            break
    return found


def _half(seen: PointSightings, state: PointState, one: int) -> tuple[PointSightings, PointState]:
    """Every second point, and the others: what they have in common is not halved."""
    rows = np.flatnonzero(seen.point % 2 == one)
    return _often_seen(seen.only(rows), state)


def _full_size(found: PointFit, frames: _Frames) -> Camera:
    """The camera of the pictures before they were made smaller by whole pixels."""
    scale, numbers = frames.scale, found.state.numbers.copy()
    numbers[0] *= scale
    numbers[1:3] = scale * (numbers[1:3] + 0.5) - 0.5
    return found.state.kind.camera(numbers, frames.size)


def _parallax_deg(seen: PointSightings, state: PointState) -> float:
    """Median over the points of the largest angle between directions that they were seen from."""
    towards = state.points[seen.point] - state.world_T_camera.translation_m[seen.view]
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    order = np.argsort(seen.point, kind="stable")
    first = np.searchsorted(seen.point[order], np.arange(len(state.points)))
    reference = towards[order][first]
    angle = np.arccos(np.clip((towards * reference[seen.point]).sum(axis=-1), -1.0, 1.0))
    largest = np.zeros(len(state.points))
    np.maximum.at(largest, seen.point, angle)
    return float(np.degrees(np.median(largest)))
