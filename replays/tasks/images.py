"""Markers in image files: found, posed, described for machines, and drawn for people."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.files import RecordingError, refusing, write_bytes
from motorcade.replays.io.readers.frames.held import upright_camera
from motorcade.replays.io.readers.frames.images import (
    decode_gray,
    image_orientation,
    image_size,
    read_image_bytes,
)
from motorcade.replays.io.recording import ImageArray
from motorcade.tracking import Camera, Detection, TrackingError, detect_markers, pose_marker
from motorcade.tracking.boards import Board, BoardCorners
from motorcade.tracking.checks import check_length
from motorcade.tracking.markers.poses import PosedMarker
from motorcade.tracking.pose import planar_candidates, refine

_LOG = logging.getLogger("motorcade.replays")
_OUTLINE, _FIRST, _DOUBTFUL = (0, 200, 0), (0, 0, 255), (0, 165, 255)  # blue, green, red
_AXES = ((0, 0, 255), (0, 255, 0), (255, 0, 0))
_SUBPIXEL_BITS = 4


@dataclass(frozen=True, eq=False)
class MarkerImage:
    """The markers of one image, upright.

    Fields:
        gray: what was searched.
        detections: by rising id.
        posed: one for each detection where camera and size are known, else empty; None for a
            marker that has no pose (outside what the lens model covers).
        camera: of the upright image, where it is known.
        board: the corners of a board, where one was looked for in place of markers: none where it
            is not seen.
    """

    path: Path
    gray: ImageArray
    detections: tuple[Detection, ...]
    posed: tuple[PosedMarker | None, ...] = ()
    camera: Camera | None = None
    board: BoardCorners | None = None


def markers_in(
    paths: Sequence[Path],
    target: str | Board,
    camera: Camera | None = None,
    size_m: float | None = None,
    rotation_deg: int | None = None,
) -> Iterator[MarkerImage | RecordingError]:
    """Find the markers of image files, one by one; a file that cannot be read gives its error.

    Args:
        paths: PNG, JPEG, BMP or PNM files, grey or colour, 8 or 16 bits.
        target: one of `tracking.FAMILIES`, or a board whose corners alone are looked for.
        camera: undistorts lines; with `size_m` gives poses. The images must have its size, as
            shown or as stored.
        size_m: side of the markers' black square, metres.
        rotation_deg: the axes that the camera is stated in (see `readers.frames.held`).

    Raises:
        ValueError: an unknown family, a size that is not above zero or is given without a camera.
    """
    if size_m is not None and camera is None:
        raise ValueError("size_m: expected a camera with it, since poses need both, got none")
    if size_m is not None:
        check_length(size_m, "size_m")
    for path in paths:
        try:
            data = read_image_bytes(path, None, None)
            taken_by = None if camera is None else _camera_of(path, data, camera, rotation_deg)
            gray = decode_gray(path, data, None)
        except RecordingError as fault:
            yield fault
            continue
        if isinstance(target, Board):
            corners = target.detect(gray, taken_by)
            none = BoardCorners(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 3)))
            yield MarkerImage(path, gray, (), (), taken_by, corners or none)
            continue
        markers = detect_markers(gray, target, taken_by)
        posed: tuple[PosedMarker | None, ...] = ()
        if taken_by is not None and size_m is not None:
            posed = tuple(_posed(one, taken_by, size_m) for one in markers)
        yield MarkerImage(path, gray, markers, posed, taken_by)


def _camera_of(path: Path, data: bytes, stated: Camera, rotation_deg: int | None) -> Camera:
    """The camera of an image as shown; says what it took for granted."""
    with refusing(path):
        stated_camera = upright_camera(
            stated, rotation_deg, image_size(data), image_orientation(data)
        )
    if stated_camera.said:
        _LOG.warning("%s: %s", path, stated_camera.said)
    return stated_camera.camera


def _posed(detection: Detection, camera: Camera, size_m: float) -> PosedMarker | None:
    try:
        return pose_marker(detection, camera, size_m)
    except TrackingError:
        return None


def describe(image: MarkerImage) -> dict[str, Any]:
    """What was found, for JSON: pixels, metres, quaternions wxyz (see `motorcade detect`)."""
    height, width = image.gray.shape
    described: dict[str, Any] = {"file": str(image.path), "width_px": width, "height_px": height}
    if image.board is not None:
        return described | _described_board(image.board, image.camera)
    rows = []
    for index, detection in enumerate(image.detections):
        row: dict[str, Any] = {
            "id": detection.marker_id,
            "family": detection.family,
            "corners_px": np.round(detection.corners_px, 4).tolist(),
            "wrong_cells": detection.wrong_cells,
            "agreement": round(detection.agreement, 4),
            "sharp": detection.sharp,
        }
        if image.posed:
            row |= _described_pose(image.posed[index])
        rows.append(row)
    return described | {"markers": rows}


def _described_board(corners: BoardCorners, camera: Camera | None) -> dict[str, Any]:
    """Corners by their number on the board, and where it stands if the camera is known."""
    rows = [
        {"id": corner, "px": np.round(px, 4).tolist(), "point_m": point_m}
        for corner, px, point_m in zip(
            corners.ids.tolist(), corners.corners_px, corners.points_m.tolist(), strict=True
        )
    ]
    described: dict[str, Any] = {"corners": rows, "camera_T_board": None}
    if camera is not None and corners.spanning:
        with suppress(TrackingError):
            candidates = planar_candidates(corners, camera)
            pose = refine(corners, camera, candidates.world_T_camera[0])
            described["camera_T_board"] = _pose_json(pose.world_T_camera.inverse())
            described["reprojection_rmse_px"] = pose.error_px
    return described


def _pose_json(pose: Motor) -> dict[str, Any]:
    return {
        "translation_m": pose.translation_m.tolist(),
        "rotation_wxyz": pose.rotor.as_quaternion().tolist(),
    }


def _described_pose(posed: PosedMarker | None) -> dict[str, Any]:
    if posed is None:
        return {"candidates": [], "ambiguity": None}
    candidates = [
        {
            "camera_T_marker": _pose_json(pose),
            "reprojection_rmse_px": float(error),
        }
        for pose, error in zip(posed.camera_T_marker, posed.candidates.error_px, strict=True)
    ]
    return {"candidates": candidates, "ambiguity": posed.ambiguity}


def draw(image: MarkerImage) -> ImageArray:
    """The image with outlines, ids, a dot on each printed top-left corner, and axes of poses.

    Outlines of corners that are not sharp are orange. Returns BGR ``(height, width, 3)``.
    """
    canvas = cv2.cvtColor(image.gray, cv2.COLOR_GRAY2BGR)
    for corner in () if image.board is None else image.board.corners_px:
        cv2.circle(canvas, _fixed(corner).tolist(), 60, _OUTLINE, 1, cv2.LINE_AA, _SUBPIXEL_BITS)
    for index, detection in enumerate(image.detections):
        colour = _OUTLINE if detection.sharp else _DOUBTFUL
        cv2.polylines(
            canvas, [_fixed(detection.corners_px)], True, colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS
        )
        first = _fixed(detection.corners_px)[0]
        cv2.circle(canvas, first.tolist(), 40, _FIRST, -1, cv2.LINE_AA, _SUBPIXEL_BITS)
        posed = image.posed[index] if image.posed else None
        if image.camera is not None and posed is not None:
            _draw_axes(canvas, posed, image.camera)
        _write_id(canvas, detection)
    return np.asarray(canvas, np.uint8)


def drawing_names(paths: Sequence[Path]) -> list[str]:
    """A name for the drawing of each file: its own stem, numbered where it came up before."""
    stems = [path.stem for path in paths]
    before = [stems[:index].count(stem) for index, stem in enumerate(stems)]
    return [
        f"{stem}_{count + 1}.png" if count else f"{stem}.png"
        for stem, count in zip(stems, before, strict=True)
    ]


def write_drawing(image: MarkerImage, path: Path) -> None:
    """Write `draw`'s image as a PNG file. Raises OSError: a file that cannot be written."""
    _, data = cv2.imencode(".png", draw(image))
    write_bytes(path, data.tobytes())


def _draw_axes(canvas: ImageArray, posed: PosedMarker, camera: Camera) -> None:
    """The better pose's axes x red, y green, z blue, half a marker long, from its first corner."""
    pose = posed.camera_T_marker[0]
    far = np.linalg.norm(pose.apply([0.0, 0.0, 0.0]))
    spans = np.linalg.norm(posed.detection.corners_px[1] - posed.detection.corners_px[0])
    length = 0.5 * float(spans) * float(far) / camera.fx
    ends = camera.project(pose.apply(length * np.vstack([np.zeros(3), np.eye(3)])))
    if not np.isfinite(ends).all():
        return
    origin = _fixed(ends[0]).tolist()
    for end, colour in zip(ends[1:], _AXES, strict=True):
        cv2.line(canvas, origin, _fixed(end).tolist(), colour, 2, cv2.LINE_AA, _SUBPIXEL_BITS)


def _write_id(canvas: ImageArray, detection: Detection) -> None:
    span = float(np.linalg.norm(detection.corners_px[2] - detection.corners_px[0]))
    scale = float(np.clip(span / 80.0, 0.4, 2.0))
    text = str(detection.marker_id)
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    column, row = detection.corners_px.mean(axis=0) + np.array([-0.5 * width, 0.5 * height])
    place = (round(column), round(row))
    for colour, thickness in (((255, 255, 255), 4), ((200, 0, 200), 1)):
        cv2.putText(
            canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, scale, colour, thickness, cv2.LINE_AA
        )


def _fixed(places: FloatArray) -> Any:
    """Pixels as the fixed-point numbers that OpenCV draws sub-pixel places from."""
    return np.rint(places * 2**_SUBPIXEL_BITS).astype(np.int32)
