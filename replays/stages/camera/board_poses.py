"""Stage `board_poses`: camera poses by a board in view.

If the board in the pictures looks unlike the one described, the log says so; nothing is corrected.
"""

from __future__ import annotations

import logging
import time

from motorcade.ga.lookahead import ahead
from motorcade.replays.engine.progress import track
from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.board_audit import audited_board
from motorcade.replays.stages.camera.offered import camera_of, require_pictures
from motorcade.replays.values.board_poses import BoardPoses
from motorcade.tracking import Board, PoseMeasurements, track_board
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.rolling import unrolled_track

log = logging.getLogger("motorcade.camera_poses")

_LARGEST_M = 5.0
_SIZELESS = ", whose size is not known: lengths have no unit"


def warn_of_size(board: Board) -> None:
    """Warn of a board so wide that its lengths were hardly meant as metres."""
    if max(board.size_m) > _LARGEST_M:
        width, height = board.size_m
        log.warning(
            "camera_poses: the board is %g x %g m large; are its lengths in metres?", width, height
        )


def warn_of_contradictions(audit: tuple[AuditFinding, ...]) -> None:
    """Warn of what the pictures contradict: poses from a wrong board or camera are wrong."""
    for one in audit:
        if one.verdict == "contradicted":
            log.warning("camera_poses: %s; %s", one.summary, one.advice)


def board_poses(recording: Recording) -> BoardPoses:
    """Track the board that the recording names, through all its pictures.

    Raises:
        NotOffered: no camera, no pictures, or no board known.
        TrackingError: no frame shows the board.
    """
    camera = camera_of(recording)
    require_pictures(recording)
    board, frames = recording.board, recording.frames
    if board is None:
        raise NotOffered(f"{recording.name}: no board known; describe it in a manifest")
    if recording.metric:
        warn_of_size(board)
    start = time.perf_counter()
    pictures = ahead(
        lambda frame: (frame.time_ns, frame.gray()), track(frames, "tracking", len(frames))
    )
    tracked = track_board(pictures, camera, board)
    if recording.readout_s:
        tracked = unrolled_track(tracked, board, camera, recording.shutter_s)
    seconds = time.perf_counter() - start
    audit = audited_board(recording, board, tracked)
    warn_of_contradictions(audit)
    on_board = tracked.measurements
    in_world = on_board.trajectory.transformed_by(left=recording.world_T_board)
    return BoardPoses(
        PoseMeasurements(in_world, on_board.covariance),
        frames.time_ns,
        tracked.error_px,
        "board",
        f"tracked by the {board.name} in the images" + ("" if recording.metric else _SIZELESS),
        metric=recording.metric,
        audit=audit,
        seconds=seconds,
        track=tracked,
    )
