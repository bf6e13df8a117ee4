"""Stage `board_poses`: camera poses by a board in view."""

from __future__ import annotations

import time

from motorcade.replays.engine.progress import track
from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.board_check import warn_of_size, warn_of_wrong_board
from motorcade.replays.stages.camera.offered import camera_of, require_pictures
from motorcade.replays.values.board_poses import BoardPoses
from motorcade.tracking import PoseMeasurements, track_board

__all__ = ["board_poses"]


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
    warn_of_size(board)
    start = time.perf_counter()
    pictures = ((frame.time_ns, frame.gray()) for frame in track(frames, "tracking", len(frames)))
    tracked = track_board(pictures, camera, board)
    seconds = time.perf_counter() - start
    warn_of_wrong_board(recording, board, tracked)
    on_board = tracked.measurements
    in_world = on_board.trajectory.transformed_by(left=recording.world_T_board)
    return BoardPoses(
        PoseMeasurements(in_world, on_board.covariance),
        frames.time_ns,
        tracked.error_px,
        "board",
        f"tracked by the {board.name} in the images",
        seconds=seconds,
        track=tracked,
    )
