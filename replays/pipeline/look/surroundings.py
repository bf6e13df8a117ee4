"""What stands around a run for a page: boards with their print, markers, planes, mapped points.

What hides characters in a page's view through the camera: recorded depth, prints, the ground.

The film hides a figure pixel by pixel. A page gets, for every frame, a smaller picture of the depth
of all that may be nearer than the figures, and nothing of what lies behind them.
"""

from __future__ import annotations

import math
import zlib
from typing import Any

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.render import Performer
from motorcade.render.light import Prints
from motorcade.render.scene import DepthArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.look.packing import packed, rows_of, text
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.view import PlacedCharacter
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


LONGEST_DEPTH_PX, MOST_BYTES = 320, 24 * 2**20
"""Of a picture of depth, and of all of them before they are compressed."""
FEWEST_PX = 32
"""Pictures so small would hide by blocks: the page then does without."""
LEVELS = 254
"""Steps of depth between the nearest and the farthest, evenly in its logarithm; 0 hides nothing."""


def shown_hiding(
    recording: Recording, figures: list[Performer], prints: Prints | None, drawn: FloatArray
) -> dict[str, Any]:
    """What hides figures, as in the film: the depth of each frame, or else prints and the ground.

    Args:
        recording: with the camera as the run found it.
        figures: who is drawn.
        prints: boards and markers; where figures ride on what moves, a map may not hold, and they
            hide nothing.
        drawn: ``(F, 7)`` poses of the drawn path at the frames' stamps, as `rows_at` gives them.

    Returns:
        `depth` (None without), `prints` by their corners, and the `ground` by its pose, None where
        all grounds move.
    """
    still = [one for one in figures if one.ground_motion is None]
    ground = None
    if still:
        ground = packed(rows_of(still[0].placement.world_T_character), "f64")
    return {
        "depth": None
        if isinstance(recording.frames, CornerFrames)
        else _depth(recording, figures, drawn),
        "prints": _corners(prints if len(still) == len(figures) else None),
        "ground": ground,
    }


def _corners(prints: Prints | None) -> dict[str, Any]:
    """Corners ``(P, 4, 3)`` of boards and markers."""
    if prints is None:
        return packed(np.zeros((0, 4, 3)))
    low, high = prints.low_m, prints.high_m
    around = [(low, low), (high, low), (high, high), (low, high)]
    flat = [np.stack([x[:, 0], y[:, 1], np.zeros(len(low))], axis=-1) for x, y in around]
    return packed(np.stack([prints.world_T_print.apply(one) for one in flat], axis=1))


def _depth(
    recording: Recording, figures: list[Performer], drawn: FloatArray
) -> dict[str, Any] | None:
    """Depth of all that is nearer than a figure's far side, a picture a frame; None without.

    `deflated` holds ``shape`` ``(F, h, w)`` bytes: 0 for nothing, then `near_m` to `far_m`.
    """
    camera = recording.camera
    assert camera is not None  # `look_of` refuses that before
    time_ns = recording.frames.time_ns
    if recording.frames[0].depth_m() is None:
        return None
    longest = max(camera.width, camera.height)
    fits = math.sqrt(MOST_BYTES / (len(time_ns) * camera.width * camera.height))
    share = min(LONGEST_DEPTH_PX / longest, fits, 1.0)
    if share * longest < FEWEST_PX:
        return None
    size = (max(1, int(share * camera.height)), max(1, int(share * camera.width)))
    behind_m = _farthest_m(figures, drawn, time_ns)
    small = np.zeros((len(time_ns), *size), dtype=np.float16)
    for k, frame in enumerate(track(recording.frames, "pictures of depth", len(time_ns))):
        depth_m = frame.depth_m()
        if depth_m is not None and behind_m[k] > 0.0:
            small[k] = _nearer(depth_m, size, behind_m[k])
    return _levelled(small)


def _farthest_m(
    figures: list[Performer], world_T_camera: FloatArray, time_ns: IntArray
) -> FloatArray:
    """Depth ``(F,)`` that no part of a figure is beyond, 0 where there is no pose."""
    x, y, z, w = (world_T_camera[:, k] for k in (4, 5, 6, 3))
    ahead = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    farthest = np.zeros(len(time_ns))
    for figure in figures:
        rigid, scale = figure.world_T_character(time_ns).as_motor_scale()
        tall_m = scale * figure.character.height_m
        away_m = np.sum(ahead * (rigid.translation_m - world_T_camera[:, :3]), axis=-1)
        # A figure walks off its footing by no more than its clip takes it.
        farthest = np.fmax(farthest, away_m + scale * _reach_m(figure) + tall_m)
    return farthest


def _reach_m(figure: Performer) -> float:
    """How far its clip takes the root from where it stands, in the character's space."""
    moments = np.linspace(figure.clip.time_s[0], figure.clip.time_s[-1], 64)
    root = figure.clip.at(moments).translation_m[..., 0, :]
    return float(np.max(np.linalg.norm(root, axis=-1)))


def _nearer(depth_m: DepthArray, size: tuple[int, int], behind_m: float) -> FloatArray:
    """A smaller picture ``size``, of single pixels, 0 where unknown or behind."""
    rows, columns = (
        ((np.arange(few) + 0.5) * many / few).astype(np.intp)
        for few, many in zip(size, depth_m.shape, strict=True)
    )
    some = depth_m[rows[:, None], columns]
    with np.errstate(invalid="ignore"):
        return np.where((some > 0.0) & (some < behind_m), some, 0.0)


def _levelled(depths_m: np.ndarray) -> dict[str, Any]:
    """Depths ``(F, h, w)`` by levels of their logarithm, compressed."""
    known = depths_m > 0.0
    near, far = (1.0, 2.0)
    if known.any():
        near, far = float(depths_m[known].min()), float(depths_m[known].max()) * 1.0001
    step = math.log(far / near) / LEVELS
    levels = np.zeros(depths_m.shape, dtype=np.uint8)
    for level, depth, seen in zip(levels, depths_m, known, strict=True):
        logs = np.log(depth[seen].astype(np.float64) / near)
        level[seen] = 1 + np.clip(np.rint(logs / step), 0, LEVELS)
    data = text(zlib.compress(levels.tobytes(), 6))
    return {"deflated": data, "shape": list(levels.shape), "near_m": near, "far_m": far}
