"""Self-calibration from markers of unknown layout and unknown size, all of one size.

Each marker is a planar square, which says something of the focal length (`homographies`); with it
the markers are mapped (`markers.mapping`), and then all is fitted at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.tracking.markers.corner_stream import CornerStream, checked_stamps
from motorcade.tracking.markers.detection import Detection
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.mapping.estimate import MappedRecording, map_markers
from motorcade.tracking.pose import TrackingError
from motorcade.tracking.self_calibration.bodies import (
    LEAST_VIEWS,
    BodyObservations,
    BodyState,
    spread_runs,
)
from motorcade.tracking.self_calibration.choosing import calibration_of, choose_lens
from motorcade.tracking.self_calibration.homographies import focal_from_planes
from motorcade.tracking.self_calibration.lens import PINHOLE, start_numbers
from motorcade.tracking.self_calibration.result import SelfCalibration, SelfCalibrationError

_MOST_VIEWS = 240
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
    shown = shown[spread_runs(len(shown), _MOST_VIEWS)]
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
    seen, start = _started(stream, mapped, focal)
    chosen = choose_lens(seen, start, readout=True)
    return calibration_of(chosen, seen, "tags", int(stream.time_ns[0]))


def _once(frame: Sequence[Detection]) -> list[Detection]:
    """The sharp markers of a frame whose ids stand there once, by rising id."""
    ids = [one.marker_id for one in frame]
    return sorted(
        (one for one in frame if ids.count(one.marker_id) == 1 and one.sharp),
        key=lambda marker: marker.marker_id,
    )


def _started(
    stream: CornerStream, mapped: MappedRecording, focal: float
) -> tuple[BodyObservations, BodyState]:
    """Observations of the map's markers in frames that have a pose, and where the fit begins."""
    layout, path = mapped.marker_map, mapped.trajectory
    sides = layout.world_T_marker
    size = stream.camera.width, stream.camera.height
    known = np.isin(stream.marker_ids, layout.marker_ids)
    known &= np.isin(stream.time_ns[stream.frame], path.time_ns)
    frame, ids = stream.frame[known], stream.marker_ids[known]
    view = np.searchsorted(path.time_ns, stream.time_ns[frame])
    body = np.searchsorted(layout.marker_ids, ids)
    square = marker_points_m(1.0)
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
        np.tile(square, (int(good.sum()), 1)),
        stream.corners_px[known][good].reshape(-1, 2),
    )
    start = BodyState(
        PINHOLE,
        start_numbers(focal, size),
        np.zeros(2),
        first @ path.motors[views],
        first @ sides[bodies],
    )
    return seen, start
