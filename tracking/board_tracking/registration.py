"""How well a path sticks to its pictures: where it puts a board's corners, against where they are.

What is drawn along a path moves against the footage by as much, so this is the jitter and drift
that a viewer sees, in pixels.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.board_tracking.track import BoardTrack
from motorcade.tracking.boards import Board
from motorcade.tracking.cameras.camera import Camera

__all__ = ["registration_px"]


def registration_px(
    path: Trajectory, board_track: BoardTrack, board: Board, camera: Camera, world_T_board: Motor
) -> FloatArray:
    """Root mean square distance between projected and found corners, a frame.

    Args:
        path: ``world_T_camera``; frames outside its span are left out.
        board_track: the corners found in each of the N frames that show the board.
        board: what they belong to.
        camera: who saw them, with its distortion.
        world_T_board: where the board is.

    Returns:
        ``(M,)`` pixels, M at most N; corners that fall behind the camera make a frame NaN.

    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera, SingleMarker, registration_px, track_board
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> picture, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(picture.shape[1], picture.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> track = track_board([(0, picture), (33_000_000, picture)], camera, board)
    >>> path = track.measurements.trajectory  # the board's frame is the world
    >>> errors_px = registration_px(path, track, board, camera, world_T_board=Motor.identity())
    >>> bool(errors_px.max() < 0.2)
    True
    """
    found = []
    for seen in board_track.observations:
        if not path.time_ns[0] <= seen.time_ns <= path.time_ns[-1]:
            continue
        camera_T_board = path.motors_at(np.int64(seen.time_ns)).inverse() @ world_T_board
        expected = camera.project(camera_T_board.apply(board.points_m[seen.ids]))
        found.append(np.sqrt(np.mean(np.sum((expected - seen.corners_px) ** 2, axis=-1))))
    return np.array(found, dtype=np.float64)
