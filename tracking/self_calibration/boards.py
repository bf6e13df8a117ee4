"""Self-calibration from boards of known layout, and from markers of unknown layout and size.

Sources: Zhang 2000 (views of a plane fix the lens), Hartley & Zisserman 2003, ch. 8.8.

Each marker is a planar square, which says something of the focal length; with it
the markers are mapped (`markers.mapping`), and then all is fitted at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import IntArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream, checked_stamps
from motorcade.tracking.markers.detection import Detection
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.mapping.estimate import MappedRecording, map_markers
from motorcade.tracking.pose import TrackingError, planar_candidates, refine
from motorcade.tracking.self_calibration.bodies import (
    LEAST_VIEWS,
    BodyObservations,
    BodyState,
    spread_runs,
)
from motorcade.tracking.self_calibration.choosing import calibration_of, choose_lens
from motorcade.tracking.self_calibration.lens import PINHOLE, focal_from_planes, start_numbers
from motorcade.tracking.self_calibration.result import SelfCalibration, SelfCalibrationError
from motorcade.tracking.self_calibration.zooming import follow_zoom

_MOST_CORNERS = 6_000
_MOST_VIEWS = 300
_ZOOMED = np.geomspace(0.35, 2.83, 7)
_BAD_VIEW = 4.0  # times the median error of a view's own best pose


def self_calibrate_board(
    views: Sequence[BoardCorners | None], size: tuple[int, int], time_ns: Sequence[int] | IntArray
) -> SelfCalibration:
    """Find the camera of a clip from a board that it shows.

    Args:
        views: of each frame the board's corners, None where it is not seen; every frame of the
            clip if there is time, neighbours at least, since a rolling shutter is told by how fast
            the camera moved. The unit of the board's lengths does not matter.
        size: width and height of the images, pixels.
        time_ns: ``(F,)`` stamps of all frames, strictly increasing.

    Raises:
        SelfCalibrationError: too few frames with the board, or frames from which the focal length
            does not follow (the board always at one angle, or far away).
        ValueError: stamps and views that do not agree.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, Checkerboard, self_calibrate_board
    >>> from motorcade.tracking.boards import BoardCorners
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> points = Checkerboard(6, 5, 1.0).points_m
    >>> views = []
    >>> for step in range(12):
    ...     turn = Rotor.from_rotation_vector([0.4 * np.sin(step), 0.4 * np.cos(step), 0.0])
    ...     face_down = turn @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    ...     pose = Motor.from_rotor_translation(face_down, [-2.5, -2.0, 10.0])
    ...     views.append(BoardCorners(np.arange(30), camera.project(pose.apply(points)), points))
    >>> found = self_calibrate_board(views, (640, 480), 100_000_000 * np.arange(12))
    >>> round(found.camera.fx, 2), found.camera.model
    (500.0, 'pinhole')
    """
    stamps = checked_stamps(np.asarray(time_ns), "time_ns")
    if len(stamps) != len(views):
        raise ValueError(f"time_ns: expected {len(views)} stamps, one a view, got {len(stamps)}")
    shown = [k for k, view in enumerate(views) if view is not None and view.spanning]
    if len(shown) < LEAST_VIEWS:
        raise SelfCalibrationError(
            f"views: expected at least {LEAST_VIEWS} frames that show the board, got "
            f"{len(shown)} of {len(views)}"
        )
    few = np.asarray(shown)[spread_runs(len(shown), _MOST_VIEWS)]
    kept = [(int(k), view) for k in few if (view := views[int(k)]) is not None]
    focal = focal_from_planes([(view.points_m, view.corners_px) for _, view in kept], size)
    seen, start = board_observations(kept, stamps, size, focal)
    if len(kept) - len(seen.time_s) >= LEAST_VIEWS:  # which a zoom may explain
        zoomed = board_observations(kept, stamps, size, focal, zoom=True)
        if len(zoomed[0].time_s) > len(seen.time_s) and follow_zoom(*zoomed) is not None:
            seen, start = zoomed
    chosen = choose_lens(seen, start, readout=True)
    return calibration_of(chosen, seen, "board", int(stamps[0]))


def board_observations(
    views: Sequence[tuple[int, BoardCorners]],
    time_ns: IntArray,
    size: tuple[int, int],
    focal: float,
    *,
    zoom: bool = False,
) -> tuple[BodyObservations, BodyState]:
    """A board in the views that some pose explains, and where a fit of them begins.

    Args:
        views: rows of `time_ns`, rising, and what they show of the board.
        time_ns: stamps of all frames.
        size: width and height of the images.
        focal: of a camera without distortion, pixels, near the right one.
        zoom: whether a view may have another focal length, by up to 2.8 times.

    Raises:
        SelfCalibrationError: fewer views than a fit takes.
    """
    focals = focal * (_ZOOMED if zoom else np.ones(1))
    cameras = [PINHOLE.camera(start_numbers(float(tried), size), size) for tried in focals]
    posed = [
        (row, view, *min((_posed(view, camera) for camera in cameras), key=itemgetter(1)))
        for row, view in views
    ]
    errors = np.array([error for *_, error in posed])
    good = errors <= _BAD_VIEW * np.median(errors)
    kept_views = [one for one, fine in zip(posed, good, strict=True) if fine]
    if len(kept_views) < LEAST_VIEWS or not np.isfinite(errors[good]).all():
        raise SelfCalibrationError("views: expected corners that some camera explains, got none")
    every = max(1, sum(len(view) for _, view, *_ in kept_views) // _MOST_CORNERS + 1)
    seen = _observations(kept_views, time_ns, size, every)
    start = BodyState(
        PINHOLE,
        start_numbers(focal, size),
        np.zeros(2),
        Motor.stack([pose for *_, pose, _ in kept_views]),
        Motor.identity((1,)),
    )
    return seen, start


def _posed(view: BoardCorners, camera: Camera) -> tuple[Motor, float]:
    """The camera's better pose, refined, and its error; infinite where there is none."""
    try:
        pose = refine(view, camera, planar_candidates(view, camera).world_T_camera[0])
    except TrackingError:
        return Motor.identity(), np.inf
    return pose.world_T_camera, pose.error_px


def _observations(
    views: Sequence[tuple[int, BoardCorners, Motor, float]],
    stamps: IntArray,
    size: tuple[int, int],
    every: int,
) -> BodyObservations:
    """All views as one body's; of each view every `every`-th corner, from another on each time."""
    rows = [
        np.arange(k % every, len(view), every) if len(view) >= 4 * every else np.arange(len(view))
        for k, (_, view, *_) in enumerate(views)
    ]
    points = [view.points_m[part] for part, (_, view, *_) in zip(rows, views, strict=True)]
    px = [view.corners_px[part] for part, (_, view, *_) in zip(rows, views, strict=True)]
    number = np.repeat(np.arange(len(views)), [len(one) for one in points])
    time_s = 1e-9 * (stamps[[row for row, *_ in views]] - stamps[0])
    return BodyObservations(
        size,
        time_s,
        number,
        np.zeros(len(number), np.int64),
        np.concatenate(points),
        np.concatenate(px),
    )


_MOST_OBSERVED = 240
_MOST_ERROR = 5.0  # an observation's error in the first map, over the median


def self_calibrate_tags(
    detections: Sequence[Sequence[Detection]],
    size: tuple[int, int],
    time_ns: Sequence[int] | IntArray,
) -> SelfCalibration:
    """Find the camera of a clip from markers whose places and size nobody knows.

    Args:
        detections: of each frame, as `detect_markers` gives them; every frame of the clip if there
            is time, neighbours at least. An id that a frame shows twice is left out there. The
            markers lie still and are of one size; those never seen beside the others are left out.
        size: width and height of the images, pixels.
        time_ns: ``(F,)`` stamps of all frames, strictly increasing.

    Raises:
        SelfCalibrationError: too few frames with markers, or frames from which the focal length
            does not follow.
        ValueError: stamps and detections that do not agree.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, Detection, self_calibrate_tags
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, -1.0, 0.0]])
    >>> frames = []
    >>> for step in range(20):
    ...     turn = Rotor.from_rotation_vector([0.5 * np.sin(step), 0.5 * np.cos(step), 0.0])
    ...     face_down = turn @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    ...     pose = Motor.from_rotor_translation(face_down, [-1.0, 0.0, 6.0])
    ...     px = [camera.project(pose.apply(square + [2.0 * tag, 0.0, 0.0])) for tag in range(2)]
    ...     frames.append([Detection("tag36h11", tag, px[tag], 0, 1.0, True) for tag in range(2)])
    >>> found = self_calibrate_tags(frames, (640, 480), 100_000_000 * np.arange(20))
    >>> round(found.camera.fx, 2), found.basis
    (500.0, 'tags')
    """
    stamps = checked_stamps(np.asarray(time_ns), "time_ns")
    if len(stamps) != len(detections):
        raise ValueError(
            f"time_ns: expected {len(detections)} stamps, one a frame, got {len(stamps)}"
        )
    frames = [_once(frame) for frame in detections]
    shown = np.array([k for k, frame in enumerate(frames) if frame], np.int64)
    if len(shown) < LEAST_VIEWS:
        raise SelfCalibrationError(
            f"detections: expected at least {LEAST_VIEWS} frames that show a marker, got "
            f"{len(shown)} of {len(detections)}"
        )
    shown = shown[spread_runs(len(shown), _MOST_OBSERVED)]
    square = marker_points_m(1.0)
    focal = focal_from_planes(
        [(square, one.corners_px) for row in shown for one in frames[row]], size
    )
    stream = CornerStream(
        PINHOLE.camera(start_numbers(focal, size), size),
        stamps[shown],
        np.repeat(np.arange(len(shown)), [len(frames[row]) for row in shown]),
        np.array([one.marker_id for row in shown for one in frames[row]]),
        np.array([one.corners_px for row in shown for one in frames[row]]),
    )
    try:
        mapped = map_markers({"camera": stream}, {int(one): 1.0 for one in stream.marker_ids})
    except TrackingError as error:
        raise SelfCalibrationError(f"markers: {error}") from error
    seen, start = tag_observations(stream, mapped)
    chosen = choose_lens(seen, start, readout=True)
    return calibration_of(chosen, seen, "tags", int(stream.time_ns[0]))


def _once(frame: Sequence[Detection]) -> list[Detection]:
    """The sharp markers of a frame whose ids stand there once, by rising id."""
    ids = [one.marker_id for one in frame]
    return sorted(
        (one for one in frame if ids.count(one.marker_id) == 1 and one.sharp),
        key=lambda marker: marker.marker_id,
    )


def tag_observations(
    stream: CornerStream, mapped: MappedRecording
) -> tuple[BodyObservations, BodyState]:
    """Markers of a map in frames that have a pose, and where a fit of them begins.

    Args:
        stream: of a camera without distortion, its axis in the middle.
        mapped: of it, the rig being the camera.

    Raises:
        SelfCalibrationError: fewer views than a fit takes.
    """
    layout, path = mapped.marker_map, mapped.trajectory
    sides = layout.world_T_marker
    size = stream.camera.width, stream.camera.height
    known = np.isin(stream.marker_ids, layout.marker_ids)
    known &= np.isin(stream.time_ns[stream.frame], path.time_ns)
    frame, ids = stream.frame[known], stream.marker_ids[known]
    view = np.searchsorted(path.time_ns, stream.time_ns[frame])
    body = np.searchsorted(layout.marker_ids, ids)
    square = layout.side_m[body, None, None] * marker_points_m(1.0)
    points = (path.motors[view].inverse() @ sides[body])[:, None].apply(square)
    error = np.linalg.norm(stream.camera.project(points) - stream.corners_px[known], axis=-1).max(
        axis=-1
    )
    good = np.nan_to_num(error, nan=np.inf) <= _MOST_ERROR * max(float(np.nanmedian(error)), 0.2)
    views, bodies = np.unique(view[good]), np.unique(body[good])
    if len(views) < LEAST_VIEWS:
        raise SelfCalibrationError("markers: expected frames that fit one layout, got too few")
    first = sides[bodies[:1]].inverse()
    corners = np.repeat(np.flatnonzero(good), 4)
    seen = BodyObservations(
        size,
        1e-9 * (path.time_ns[views] - stream.time_ns[0]),
        np.searchsorted(views, view[corners]),
        np.searchsorted(bodies, body[corners]),
        square[good].reshape(-1, 3),
        stream.corners_px[known][good].reshape(-1, 2),
    )
    start = BodyState(
        PINHOLE,
        start_numbers(stream.camera.fx, size),
        np.zeros(2),
        first @ path.motors[views],
        first @ sides[bodies],
    )
    return seen, start
