"""What stands around a run for a page: boards with their print, markers, planes, mapped points."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.recording import Recording
from motorcade.replays.studio.look.packing import packed, text
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.view import PlacedCharacter
from motorcade.tracking import Board, MarkerMap

MOST_POINTS = 60_000
LONGEST_PX = 512
_SHEET = 0.6
"""Half the side of the sheet under a character, in its heights."""


def shown_boards(recording: Recording, camera_poses: CameraPoses) -> list[dict[str, Any]]:
    """The board where the poses come from it: its corners in the world, and its print as PNG."""
    board = recording.board
    if board is None or camera_poses.origin not in ("board", "simulated"):
        return []
    picture, corners_m = _printed(board)
    written, data = cv2.imencode(".png", picture)
    if not written:
        raise OSError(f"{recording.name}: the board cannot be written as PNG")
    return [
        {
            "name": board.name,
            "corners_m": packed(recording.world_T_board.apply(corners_m), "f64"),
            "picture": f"data:image/png;base64,{text(data.tobytes())}",
        }
    ]


def _printed(board: Board) -> tuple[np.ndarray, FloatArray]:
    """The board's picture, and the corners ``(4, 3)`` of that sheet from its top left on."""
    scale = LONGEST_PX / max(board.size_m)
    picture, (column, row) = board.draw(scale)
    high, wide = picture.shape
    # A pixel's centre is at its number; rows run down, y of the board's frame up.
    x = (np.array([-0.5, wide - 0.5]) - column) / scale
    y = (row - np.array([-0.5, high - 0.5])) / scale
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    return picture, np.array([(*one, 0.0) for one in corners])


def shown_markers(marker_map: MarkerMap | None) -> list[dict[str, Any]]:
    """Markers of a map, with their corners ``(4, 3)`` in the world."""
    if marker_map is None:
        return []
    corners = marker_map.points_m.reshape(-1, 4, 3)
    return [
        {"id": int(number), "corners_m": packed(four, "f64")}
        for number, four in zip(marker_map.marker_ids, corners, strict=True)
    ]


def shown_plane(placed: PlacedCharacter, height_m: float) -> dict[str, Any]:
    """A square sheet of what the first character stands on, by its corners in the world."""
    half = _SHEET * height_m
    square = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=np.float64)
    stand: Motor = placed.placement.world_T_character
    return {"name": placed.stands_on, "corners_m": packed(stand.apply(square), "f64")}


def shown_points(camera_poses: CameraPoses) -> dict[str, Any]:
    """Points ``(P, 3)`` of the map, thinned evenly."""
    points = np.asarray(camera_poses.points, dtype=np.float64).reshape(-1, 3)
    return packed(points[:: -(-len(points) // MOST_POINTS) or 1])
