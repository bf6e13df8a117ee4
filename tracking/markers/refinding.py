"""Markers that a search missed, looked for where a known map says that they are.

Found markers give the camera's pose in the map; each other marker that faces the camera is then
projected into the image, its sides are fitted there and its print is read. A marker that is dark,
small or half in shadow shows its sides and its print long after it shows no loop round it.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.markers.detection import Detection, readable
from motorcade.tracking.markers.edges import refine_quads
from motorcade.tracking.markers.families import border_share, layout, marker_points_m
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.markers.reading import read_markers
from motorcade.tracking.pose import RefinedPose, TrackingError, planar_candidates, refine

_LEAST_MARKERS = 2  # one alone has two poses, and the false one sends the search astray
_STARTS = 3
_WORST_ERROR_PX = 2.0
# Cells smaller than a pixel are blurred into their neighbours.
_LEAST_CELL_PX = 1.0


def refind_markers(
    image: GrayImage, family: str, camera: Camera, known: MarkerMap, seen: tuple[Detection, ...]
) -> tuple[Detection, ...]:
    """What was found in an image, and markers of a map that were missed.

    Args:
        image: ``(height, width)`` uint8.
        family: of the map's markers.
        camera: what the image was taken with.
        known: where markers stand.
        seen: by `detect_markers`; at least two that the map knows, or nothing is added.

    Returns:
        detections by rising id, then from left to right. Where the found markers do not agree with
        the map to 2 px, they come back alone.

    Raises:
        ValueError: not a grey uint8 image, or an unknown family.
    """
    gray = checked_gray(image)
    pose = _pose(camera, known, seen)
    if pose is None:
        return seen
    rows, quads = _expected(camera, known, pose.world_T_camera, layout(family).side_cells)
    missed = ~np.isin(known.marker_ids[rows], [one.marker_id for one in seen])
    rows, quads = rows[missed], quads[missed]
    if len(rows) == 0:
        return seen
    ids = known.marker_ids[rows]
    corners, sharp = refine_quads(
        gray, quads, border_share(family), camera, layout(family).white_inside
    )
    reading = read_markers(gray, corners, family, ids)
    added = [
        Detection(
            family=family,
            marker_id=int(ids[row]),
            corners_px=corners[row],
            wrong_cells=int(reading.wrong_cells[row]),
            agreement=float(reading.agreement[row]),
            sharp=True,
        )
        for row in np.flatnonzero(sharp & readable(reading))
    ]
    return tuple(
        sorted(
            [*seen, *added],
            key=lambda detection: (detection.marker_id, *detection.corners_px.mean(axis=0)),
        )
    )


def _pose(
    camera: Camera, known: MarkerMap, detections: tuple[Detection, ...]
) -> RefinedPose | None:
    """The camera in the map by all found markers; None where they are too few or contradict it."""
    ids = [one.marker_id for one in detections]
    seen = {one.marker_id: one.corners_px for one in detections if ids.count(one.marker_id) == 1}
    rows = np.flatnonzero(np.isin(known.marker_ids, list(seen)))
    if len(rows) < _LEAST_MARKERS:
        return None
    pixels = np.stack([seen[int(known.marker_ids[row])] for row in rows])
    points = known.points_m.reshape(-1, 4, 3)[rows]
    corner_ids = (4 * rows[:, None] + np.arange(4)).ravel()
    corners = BoardCorners(corner_ids, pixels.reshape(-1, 2), points.reshape(-1, 3))
    best: RefinedPose | None = None
    for index in np.argsort(-np.ptp(pixels, axis=1).sum(axis=-1))[:_STARTS]:
        for start in _starts(camera, known, int(rows[index]), pixels[index]):
            try:
                tried = refine(corners, camera, start)
            except TrackingError:
                continue  # from this start some marker is behind the camera; others are tried
            if best is None or tried.error_px < best.error_px:
                best = tried
    return best if best is not None and best.error_px <= _WORST_ERROR_PX else None


def _starts(camera: Camera, known: MarkerMap, row: int, corners_px: FloatArray) -> list[Motor]:
    """Both poses that one marker allows; none where the lens has no rays through its corners."""
    own = BoardCorners(np.arange(4), corners_px, marker_points_m(known.side_m[row]))
    try:
        marker_T_camera = planar_candidates(own, camera).world_T_camera
    except TrackingError:
        return []
    return [known.world_T_marker[row] @ marker_T_camera[which] for which in (0, 1)]


def _expected(
    camera: Camera, known: MarkerMap, world_T_camera: Motor, cells: int
) -> tuple[IntArray, FloatArray]:
    """Rows of markers that face the camera within the image, and their corners ``(m, 4, 2)``."""
    points = world_T_camera.inverse().apply(known.points_m).reshape(-1, 4, 3)
    across, down = points[:, 1] - points[:, 0], points[:, 3] - points[:, 0]
    facing = np.sum(np.cross(across, down) * points.mean(axis=1), axis=-1) > 0.0
    quads = camera.project(points)
    limit = (camera.width - 1.0, camera.height - 1.0)
    with np.errstate(invalid="ignore"):
        inside = np.all((quads >= 0.0) & (quads <= limit), axis=(1, 2))  # not where unknown
        sides = np.linalg.norm(np.roll(quads, 1, axis=1) - quads, axis=-1).min(axis=1)
        rows = np.flatnonzero(facing & inside & (sides >= _LEAST_CELL_PX * cells))
    return rows, quads[rows]
