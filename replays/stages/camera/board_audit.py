"""Whether the board and the camera that were described fit what the pictures of the board show."""

from __future__ import annotations

from itertools import islice

import numpy as np

from motorcade.replays.recording import Recording
from motorcade.tracking import Board, BoardTrack, CalibrationError, Camera, Checkerboard, calibrate
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.boards.checkerboard import extent_in_picture, extent_seen
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import spread_views

_PICTURES = 3
_VIEWS = 20
_FOCAL_SHARE = 0.02
"""A focal length wrong by so much puts a corner of the picture several pixels off."""
_SIGMAS = 5.0
_WORSE_PX, _TIMES = 0.2, 1.5


def audited_board(
    recording: Recording, board: Board, tracked: BoardTrack
) -> tuple[AuditFinding, ...]:
    """Compare the board's described corners, and the stated camera, with the tracked board."""
    findings = []
    if isinstance(board, Checkerboard):
        findings.append(_extent(recording, board, tracked))
    if recording.camera is not None:
        findings.append(_camera(recording.camera, board, tracked))
    return tuple(findings)


def _board_looks(recording: Recording, board: Checkerboard, tracked: BoardTrack) -> tuple[int, int]:
    """Columns and rows of inner corners that a checkerboard is seen to have.

    Fewer than described by what was tracked, more by the first three pictures that show it whole.
    """
    whole = [one for one in tracked.observations if len(one.ids) == len(board.points_m)]
    if not whole:
        return extent_seen(board, tracked.observations)
    corners = {one.time_ns: one.corners_px for one in whole[:_PICTURES]}
    shown = (frame for frame in recording.frames if frame.time_ns in corners)
    extents = [
        extent_in_picture(board, frame.gray(), corners[frame.time_ns])
        for frame in islice(shown, len(corners))
    ]
    return max((columns for columns, _ in extents)), max((rows for _, rows in extents))


def _extent(recording: Recording, board: Checkerboard, tracked: BoardTrack) -> AuditFinding:
    looks, described = _board_looks(recording, board, tracked), (board.columns, board.rows)
    off = float(max(abs(looks[0] - described[0]), abs(looks[1] - described[1])))
    seen = "the board looks like {} x {} inner corners".format(*looks)
    if looks == described:
        return AuditFinding("board_corners", "consistent", off, "corners", f"{seen}, as described")
    summary = "{}, not {} x {} as described".format(seen, *described)
    advice = "describe the board that is seen: poses from a wrong board are wrong"
    return AuditFinding("board_corners", "contradicted", off, "corners", summary, advice)


def _camera(camera: Camera, board: Board, tracked: BoardTrack) -> AuditFinding:
    """The stated camera against one that is calibrated from the same corners."""
    name = "camera_on_board"
    views = [
        BoardCorners(one.ids, one.corners_px, board.points_m[one.ids])
        for one in tracked.observations
    ]
    views = [view for view in views if view.spanning]
    try:
        chosen = [views[row] for row in spread_views(views, _VIEWS)] if views else []
        found = calibrate(chosen, (camera.width, camera.height), camera.model)
    except CalibrationError as why:
        summary = f"the board's views do not tell the camera ({why})"
        return AuditFinding(name, "unknown", None, "share", summary)
    ratio = np.array([found.camera.fx / camera.fx, found.camera.fy / camera.fy]) - 1.0
    off = float(np.max(np.abs(ratio)))
    sigma = float(np.max(found.deviation[:2]) / camera.fx)
    stated_px = float(np.nanmedian(tracked.error_px))
    seen = (
        f"the board's views say fx {found.camera.fx:.1f} px where {camera.fx:.1f} is stated, off "
        f"by {100.0 * off:.1f} %; they fit to {found.rmse_px:.2f} px, {stated_px:.2f} as stated"
    )
    worse = stated_px > max(_TIMES * found.rmse_px, found.rmse_px + _WORSE_PX)
    if (off > _FOCAL_SHARE and off > _SIGMAS * sigma) or worse:
        advice = "calibrate the camera, or state its focal length and distortion as they are"
        return AuditFinding(name, "contradicted", off, "share", seen, advice)
    return AuditFinding(name, "consistent", off, "share", seen)
