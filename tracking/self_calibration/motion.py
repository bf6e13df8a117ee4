"""Self-calibration from a moving camera alone: corners tracked through a scene with depth.

Visual SLAM runs with a guessed lens, which is enough to find a path and points; a bundle adjustment
then frees the lens, and SLAM runs again with what was found. Last, the map's points are found again
in many frames between the keyframes, and all is fitted once more, at the end by halves of the
frames too, which shows how sure the focal length is.

Where the camera only turns there is a focal length but no path: such clips are refused. Where the
scene is flat or the camera only goes ahead, focal length and depth can hardly be told apart: what
was found is then drawn towards what is usual, and of some focal lengths the one taken with which
SLAM keeps most frames.

Sources: Hartley & Zisserman 2003, ch. 19; Pollefeys et al. 1999 (a metric camera from its motion);
Wu 2014 (what a free focal length and k1 cannot tell).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.images import track_corners
from motorcade.tracking.markers.corner_stream import checked_stamps
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.self_calibration.bodies import velocities
from motorcade.tracking.self_calibration.lens import (
    CENTRE_SHARE,
    KINDS,
    USUAL_FOCAL,
    LensKind,
    doubt_of,
    start_numbers,
    view_deg,
    with_prior,
)
from motorcade.tracking.self_calibration.points import (
    PointFit,
    PointObservations,
    PointState,
    fit_points,
    fit_with_shutter,
    parallax_deg,
)
from motorcade.tracking.self_calibration.result import (
    OnlyTurnsError,
    SelfCalibration,
    SelfCalibrationError,
)
from motorcade.tracking.self_calibration.zooming import focal_range, zoom_doubt
from motorcade.tracking.slam.features import find_corners
from motorcade.tracking.slam.geometry import flow_beyond_rotation_px
from motorcade.tracking.slam.results import SlamResult
from motorcade.tracking.slam.slam import VisualSlam

_STARTS = (0.72, 0.45, 1.1, 1.7)
"""Focal lengths to start from, in long sides: a phone's main, wide and long cameras."""
_KIND = next(kind for kind in KINDS if kind.name == "radtan with k1 k2")
_SIMPLER: tuple[LensKind, ...] = tuple(
    kind for name in ("radtan with k1", "pinhole") for kind in KINDS if kind.name == name
)
_LONG_SIDE = 960  # images are tracked at this size: finer ones cost time and tell little more
_MOST_FRAMES = 450
_MOST_VIEWS = 40
_TRACKED_SHARE, _LEAST_TRACKED = 0.6, 0.4
_PLACES = 6
_FEWEST_VIEWS, _FEWEST_POINTS = 4, 60
_LEAST_PARALLAX_DEG = 2.0
_TOLD_FOCAL, _DOUBTFUL_FOCAL = 0.1, 0.01
_FARTHEST_ASIDE = 5.0 * CENTRE_SHARE


@dataclass(frozen=True, eq=False)
class _Frames:
    """Images as they are tracked."""

    time_ns: IntArray
    images: Sequence[GrayImage]
    size: tuple[int, int]  # of the images as given
    scale: int = 1  # pixels as given in one as tracked; what is left over at the right is cut off

    @property
    def small(self) -> tuple[int, int]:
        """Width and height as tracked."""
        return self.images[0].shape[1], self.images[0].shape[0]


def self_calibrate_motion(
    images: Iterable[GrayImage], size: tuple[int, int], time_ns: Sequence[int] | IntArray
) -> SelfCalibration:
    """Find the camera of a clip that shows neither board nor tags, from how the scene moves.

    Args:
        images: upright grey frames in order, neighbours of the clip; the first 450 are taken.
        size: width and height of the images, pixels.
        time_ns: ``(F,)`` stamps of the frames, strictly increasing.

    Raises:
        SelfCalibrationError: too little texture, a camera that only turns, or motion from which
            the focal length does not follow.
        ValueError: images of another size.

    >>> import numpy as np
    >>> from motorcade.tracking import SelfCalibrationError, self_calibrate_motion
    >>> gray = [np.full((480, 640), 128, np.uint8)] * 6  # a plain wall
    >>> try:
    ...     self_calibrate_motion(gray, (640, 480), 33_000_000 * np.arange(6))
    ... except SelfCalibrationError as error:
    ...     print(error)
    images: expected 80 corners to follow, got 0: the scene is too plain to tell the camera from
    """
    frames = _reduced(images, size, checked_stamps(np.asarray(time_ns), "time_ns"))
    some = np.unique(np.linspace(0, len(frames.images) - 1, _PLACES).astype(int))
    corners = max(len(find_corners(frames.images[row], 4 * FEWEST_CORNERS)) for row in some)
    if corners < FEWEST_CORNERS:
        raise SelfCalibrationError(
            f"images: expected {FEWEST_CORNERS} corners to follow, got {corners}: the scene is "
            "too plain to tell the camera from"
        )
    refuse_turning(frames.images, frames.size)
    mapped = _first_map(frames)
    if mapped is None:
        return _guessed(frames, USUAL_FOCAL, np.inf, "no focal length lets SLAM keep most frames")
    result, camera = mapped
    try:
        seen, start, velocity = _densified(frames, result, camera)
    except SelfCalibrationError as why:
        return _guessed(frames, camera.fx / max(frames.small), np.inf, str(why))
    straight, fit, readout = fit_with_shutter(seen, start, velocity)
    zoom = focal_range(fit.state.world_T_camera.shape[0], partial(_focal_of, straight, fit))
    parallax, focal = parallax_deg(straight, fit.state), float(fit.state.numbers[0])
    fit = _unfolded(frames, straight, fit)
    middle = 0.5 * (np.array(frames.small) - 1.0)
    aside = np.linalg.norm(fit.state.numbers[1:3] - middle) / max(frames.small)
    sigma = _focal_sigma(straight, fit)
    reason = ""
    if zoom is not None:
        sigma = max(sigma, 0.5 * float(np.log(zoom[1] / zoom[0])))
        reason = zoom_doubt(*(frames.scale * np.array(zoom)))
    elif parallax < _LEAST_PARALLAX_DEG or not sigma <= _TOLD_FOCAL:
        reason = f"things are seen from directions {parallax:.1f} degrees apart in the middle"
    elif aside > _FARTHEST_ASIDE:
        reason = (
            f"its centre came out {aside:.0%} of the image beside the middle, where no lens has "
            "it; of a clip cut from the side of another, state the camera"
        )
    if reason:
        return _guessed(frames, focal / max(frames.small), max(sigma, _TOLD_FOCAL), reason)
    return replace(_checked(frames, fit, sigma), readout=readout)


def _reduced(images: Iterable[GrayImage], size: tuple[int, int], time_ns: IntArray) -> _Frames:
    step = max(1, -(-max(size) // _LONG_SIDE))
    small = (size[0] // step, size[1] // step)
    kept: list[GrayImage] = []
    for number, image in enumerate(islice(images, _MOST_FRAMES)):
        gray = checked_gray(image)
        if gray.shape != (size[1], size[0]):
            raise ValueError(
                f"images[{number}]: expected {size[0]} x {size[1]} pixels, got "
                f"{gray.shape[1]} x {gray.shape[0]}"
            )
        part = gray[: small[1] * step, : small[0] * step]
        reduced = part if step == 1 else cv2.resize(part, small, interpolation=cv2.INTER_AREA)
        kept.append(np.asarray(reduced, np.uint8))
    if len(kept) < _FEWEST_VIEWS or len(time_ns) < len(kept):
        raise SelfCalibrationError(
            f"images: expected at least {_FEWEST_VIEWS} frames and a stamp each, got "
            f"{len(kept)} with {len(time_ns)}"
        )
    return _Frames(time_ns[: len(kept)], kept, size, step)


def _first_map(frames: _Frames) -> tuple[SlamResult, Camera] | None:
    """A map by SLAM, and the camera it was made with: once with a guess, once with what it told."""
    for share in _STARTS:
        camera = middle_camera(frames.small, share)
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


def _mapped(frames: _Frames, camera: Camera, least: float = _TRACKED_SHARE) -> SlamResult | None:
    """SLAM over all frames; None where it follows too few of them."""
    slam = VisualSlam(camera)
    every = zip(frames.time_ns.tolist(), frames.images, strict=True)
    for stamp, image in track(every, "mapping for the lens", len(frames.images)):
        slam.track(stamp, image)
    result = slam.finish()
    if result.trajectory is None or len(result.map.points) < _FEWEST_POINTS:
        return None
    enough = len(result.trajectory) >= least * len(frames.images)
    return result if enough and len(result.map.time_ns) >= 2 else None


def _of_map(
    frames: _Frames, result: SlamResult, camera: Camera
) -> tuple[PointObservations, PointState]:
    """What the keyframes saw, in the pixels of the images."""
    layout = result.map
    px = camera.distort(layout.px)
    rows = np.flatnonzero(np.isfinite(px).all(axis=-1))
    points, which = np.unique(layout.point_of[rows], return_inverse=True)
    seen = PointObservations(frames.small, layout.keyframe_of[rows], which, px[rows])
    poses, places = layout.world_T_camera, layout.points[points]
    return seen, PointState(_KIND, _numbers(camera), poses, places)


def _numbers(camera: Camera) -> FloatArray:
    radial = camera.distortion[:2] or (0.0, 0.0)
    return np.array([camera.fx, camera.cx, camera.cy, *radial])


def _densified(
    frames: _Frames, result: SlamResult, camera: Camera
) -> tuple[PointObservations, PointState, FloatArray]:
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
            frames.images[keyframes[nearest]], frames.images[number], shown[rows], guess
        )
        if np.count_nonzero(good) < _FEWEST_POINTS // 2:
            continue
        views.append(np.full(int(good.sum()), len(poses)))
        points.append(layout.point_of[rows[good]])
        pixels.append(there[good])
        poses.append(pose)
        moved.append(velocity[row])
    if len(poses) < _FEWEST_VIEWS:
        raise SelfCalibrationError("images: expected frames that show one scene, got too few")
    seen = PointObservations(
        frames.small, np.concatenate(views), np.concatenate(points), np.concatenate(pixels)
    )
    start = PointState(_KIND, _numbers(camera), Motor.stack(poses), layout.points)
    return *_often_seen(seen, start), np.stack(moved)


def _often_seen(
    seen: PointObservations, state: PointState, least: int = 3
) -> tuple[PointObservations, PointState]:
    """Only points that enough views see, numbered anew; views keep their numbers."""
    counts = np.bincount(seen.point, minlength=len(state.points))
    rows = np.flatnonzero(counts[seen.point] >= least)
    points, which = np.unique(seen.point[rows], return_inverse=True)
    kept = replace(seen, view=seen.view[rows], point=which, px=seen.px[rows])
    return kept, replace(state, points=state.points[points])


def _focal_sigma(seen: PointObservations, fit: PointFit) -> float:
    """Relative standard deviation of the focal length, by the residuals and by halves."""
    numbers = fit.state.numbers
    halves = [float(fit_points(*_half(seen, fit.state, one)).state.numbers[0]) for one in (0, 1)]
    formal = float(np.sqrt(fit.covariance[0, 0]) / numbers[0])
    return max(formal, abs(halves[0] - halves[1]) / (2.0 * float(numbers[0])))


def _guessed(frames: _Frames, focal: float, sigma: float, why: str) -> SelfCalibration:
    """The lens without distortion, of some focal lengths, with which SLAM keeps most frames.

    Args:
        frames: as they are tracked.
        focal: what motion says, in longer sides, and
        sigma: how sure that is.
        why: it is not surer.

    Raises:
        SelfCalibrationError: with none of them it keeps enough.
    """
    usual, spread = with_prior(focal, sigma)
    tried: list[tuple[int, float]] = []
    for share in (usual, usual * np.exp(spread), usual * np.exp(-spread)):
        result = _mapped(frames, middle_camera(frames.small, share), _LEAST_TRACKED)
        path = None if result is None else result.trajectory
        tried.append((0 if path is None else len(path), share))
        if tried[-1][0] > 0.95 * len(frames.images):
            break
    kept, share = max(tried, key=lambda row: row[0])
    if not kept:
        views = ", ".join(f"{view_deg(share):.0f}" for _, share in tried)
        raise SelfCalibrationError(
            f"images: expected a motion that visual SLAM can follow, got one of which it keeps "
            f"fewer than {_LEAST_TRACKED:.0%} of {len(frames.images)} frames, whether the lens "
            f"sees {views} degrees; move sideways past things at different depths, slowly"
        )
    doubts = (
        f"{doubt_of(share, spread)} ({why})",
        *(
            []
            if kept > 0.95 * len(frames.images)
            else [f"SLAM keeps {kept} of the first {len(frames.images)} frames"]
        ),
    )
    reason = "pinhole: motion does not tell more"
    camera = middle_camera(frames.size, share)
    return SelfCalibration(camera, "motion", float(spread), reason, 0.0, kept, doubts=doubts)


def _checked(frames: _Frames, fit: PointFit, sigma: float) -> SelfCalibration:
    """The camera in the images' own pixels."""
    views = int(fit.state.world_T_camera.shape[0])
    inside = np.linalg.norm(fit.residuals_px, axis=-1) < 6.0 * fit.noise_px
    rms = float(np.sqrt((fit.residuals_px[inside] ** 2).sum(axis=-1).mean()))
    doubts = ["found from the scene's motion alone: a printed board or tag tells the lens better"]
    if sigma > _DOUBTFUL_FOCAL:
        doubts.append(f"the focal length is known to {sigma:.1%} only")
    return SelfCalibration(
        _full_size(fit, frames),
        "motion",
        float(sigma),
        f"{fit.state.kind.name}: what a scene without a print can tell",
        rms * frames.scale,
        views,
        doubts=tuple(doubts),
    )


def _focal_of(
    seen: PointObservations, fit: PointFit, views: IntArray
) -> tuple[float, float] | None:
    """What some views alone tell of the focal length, and its deviation, pixels as tracked."""
    rows = np.flatnonzero(np.isin(seen.view, views))
    part = replace(seen.only(rows), view=np.searchsorted(views, seen.view[rows]))
    state = replace(fit.state, world_T_camera=fit.state.world_T_camera[views])
    try:
        alone = fit_points(*_often_seen(part, state))
    except (ValueError, np.linalg.LinAlgError):
        return None
    variance = float(alone.covariance[0, 0])  # below 0 by rounding where nothing tells it
    return (float(alone.state.numbers[0]), variance**0.5) if variance > 0.0 else None


def _unfolded(frames: _Frames, seen: PointObservations, fit: PointFit) -> PointFit:
    """The same; where its terms fold back in the image, the fit with as many as do not."""
    for kind in (_KIND, *_SIMPLER):
        if kind.terms < fit.state.kind.terms:
            numbers = kind.start(fit.state.numbers, kind.terms)
            fit = fit_points(seen, replace(fit.state, kind=kind, numbers=numbers))
        if not _full_size(fit, frames).folds():
            break
    return fit


def _half(
    seen: PointObservations, state: PointState, odd: int
) -> tuple[PointObservations, PointState]:
    """Every second point, and the others: what they have in common is not halved."""
    rows = np.flatnonzero(seen.point % 2 == odd)
    return _often_seen(seen.only(rows), state)


def _full_size(fit: PointFit, frames: _Frames) -> Camera:
    """The camera of the images before they were made smaller by whole pixels."""
    scale, numbers = frames.scale, fit.state.numbers.copy()
    numbers[0] *= scale
    numbers[1:3] = scale * (numbers[1:3] + 0.5) - 0.5
    return fit.state.kind.camera(numbers, frames.size)


_TURN_PX, _TURN_SHARE = 1.0, 0.06
FEWEST_CORNERS = 80


def middle_camera(size: tuple[int, int], share: float) -> Camera:
    """A lens without distortion in the middle, its focal length in longer sides."""
    return KINDS[0].camera(start_numbers(share * max(size), size), size)


def refuse_turning(images: Sequence[GrayImage], size: tuple[int, int]) -> None:
    """Refuse a clip in which every motion of the corners is a turn about the lens.

    Args:
        images: as they are tracked.
        size: width and height of the images as given, for the message.

    Raises:
        OnlyTurnsError: such a clip.
        SelfCalibrationError: corners that cannot be followed.
    """
    small = images[0].shape[1], images[0].shape[0]
    least: list[tuple[float, float, float]] = []
    for first_px, px in _followed(images):
        flow = float(np.median(np.linalg.norm(px - first_px, axis=-1)))
        shares = np.geomspace(0.35, 2.5, 24)
        left = [
            flow_beyond_rotation_px(first_px, px, middle_camera(small, share)) for share in shares
        ]
        best = int(np.argmin(left))
        least.append((left[best], flow, shares[best]))
    if not least:
        raise SelfCalibrationError(
            "images: expected corners that move through the image, got none: the camera "
            "stands still, or moves too fast to be followed"
        )
    beyond, moved, focals = np.array(least).T
    if np.all(beyond < np.maximum(_TURN_PX, _TURN_SHARE * moved)):
        focal = float(np.median(focals)) * max(size)
        raise OnlyTurnsError(
            "images: expected a camera that changes its place, got one that only turns (a focal "
            f"length of about {focal:.0f} pixels explains all motion); no path and no depth "
            "follow from that: move sideways past things at different depths",
            float(np.median(focals)),
        )


def _followed(images: Sequence[GrayImage]) -> list[tuple[FloatArray, FloatArray]]:
    """Corners of some frames, and where they are when they have moved far."""
    far = 0.12 * max(images[0].shape)
    flows = []
    for first in np.linspace(0, len(images) - 2, 6).astype(int):
        start = find_corners(images[first], 300).px
        rows, px = np.arange(len(start)), start
        motion, before = np.zeros_like(px), Pyramid(images[first])
        for image in images[first + 1 :]:
            after = Pyramid(image)
            there, good = track_corners(before, after, px, px + motion)
            motion, before = (there - px)[good], after
            rows, px = rows[good], there[good]
            if len(px) < FEWEST_CORNERS:
                break
            if np.median(np.linalg.norm(px - start[rows], axis=-1)) > far:
                break
        if len(px) >= FEWEST_CORNERS // 2:
            moved = float(np.median(np.linalg.norm(px - start[rows], axis=-1)))
            if moved > 0.25 * far:
                flows.append((start[rows], px))
    return flows
