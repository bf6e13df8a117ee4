"""Witnesses by pixels: what a pose puts into an image, drawn or projected, beside what is there.

Poses follow from corners, or from the sides of markers; what lies between these had no part in
them. There the image, laid into the board's plane through the lens, is registered with the drawing
by cross-correlation with an upsampled peak (Guizar-Sicairos, Thurman and Fienup 2008, through
scikit-image's `phase_cross_correlation`): as far as the two are apart, what is drawn slides.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.polynomial.polynomial import polyval2d, polyvander2d

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.board_tracking.tracker import BoardTrack
from motorcade.tracking.boards import Board, GrayImage
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.squares import SquaresBoard
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.families import border_share

_LARGEST_PX = 240
_UPSAMPLED = 20
_ALIKE = 0.5
"""Correlation from which on an image shows the print: half of its variance is explained by 0.7."""
_INSIDE = 0.9
_ROUND_CORNERS = 1.1
"""Of the windows in which corners are refined: what is left out about them."""


def pixel_offsets(
    image: GrayImage,
    board: Board,
    camera: Camera,
    world_T_camera: Motor,
    corners_m: FloatArray | None = None,
) -> FloatArray:
    """How far ``(n, 2)`` a print's image lies from where a pose draws it, right and down, pixels.

    Args:
        image: grey, of the camera's size.
        board: what is printed; its frame is the world.
        camera: with the distortion of the image.
        world_T_camera: one pose, with the board before the camera.
        corners_m: ``(n, 3)`` its corners where the print is not flat (`bent_track`).

    Returns:
        an offset for each quarter of the board, or for a marker alone, that lies in the image and
        looks like its print; those that are hidden have none. In pixels at the board's middle.

    Breaks down where a print repeats itself within a tenth of its size: the nearest repetition
    counts.

    >>> from motorcade.tracking import Camera, SingleMarker, track_board
    >>> from motorcade.tracking.board_tracking.witness import pixel_offsets
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> pose = track_board([(0, image)], camera, board).measurements.trajectory.motors[0]
    >>> bool(abs(pixel_offsets(image, board, camera, pose)).max() < 0.2)
    True
    """
    if isinstance(board, CircleGrid):
        return np.zeros((0, 2))  # poses follow from all that is printed
    camera_T_world = world_T_camera.inverse()
    middle = camera_T_world.apply(board.points_m.mean(axis=0))
    px_per_m = float(np.sqrt(camera.fx * camera.fy) / np.linalg.norm(middle))
    scale = min(px_per_m, _LARGEST_PX / max(board.size_m))
    drawn, free, points = _drawing(board, float(f"{scale:.1g}"))  # coarse: drawn once for many
    if corners_m is not None:
        points = points + _heights_between(points, corners_m)[..., None] * (0.0, 0.0, 1.0)
    places = camera.project(camera_T_world.apply(points))
    limit = (camera.width - 1, camera.height - 1)
    inside = np.all((places >= 0.0) & (places <= limit), axis=-1)
    shown = cv2.remap(image, places.astype(np.float32), None, cv2.INTER_LINEAR)
    weight = free * inside
    quarters = 1 if len(board.points_m) == 4 else 2
    lines, columns = (
        [slice(*ends) for ends in pairwise(cuts)]
        for cuts in (np.linspace(0, size, quarters + 1, dtype=int) for size in drawn.shape)
    )
    offsets = [
        offset
        for part in ((line, column) for line in lines for column in columns)
        if np.mean(inside[part]) >= _INSIDE
        and (offset := _offset(drawn[part], shown[part].astype(np.float64), weight[part]))
        is not None
    ]
    step_m = float(points[0, 1, 0] - points[0, 0, 0])
    return np.array(offsets).reshape(-1, 2) * step_m * px_per_m


def registration_px(
    path: Trajectory,
    board_track: BoardTrack,
    board: Board,
    camera: Camera,
    world_T_board: Motor,
    corners_m: FloatArray | None = None,
) -> FloatArray:
    """Root mean square distance between projected and found corners, a frame.

    Args:
        path: ``world_T_camera``; frames outside its span are left out.
        board_track: the corners found in each of the N frames that show the board.
        board: what they belong to.
        camera: who saw them, with its distortion.
        world_T_board: where the board is.
        corners_m: ``(n, 3)`` its corners where the print is not flat (`bent_track`).

    Returns:
        ``(M,)`` pixels, M at most N; corners that fall behind the camera make a frame NaN.

    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera, SingleMarker, registration_px, track_board
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> track = track_board([(0, image), (33_000_000, image)], camera, board)
    >>> path = track.measurements.trajectory  # the board's frame is the world
    >>> errors_px = registration_px(path, track, board, camera, world_T_board=Motor.identity())
    >>> bool(errors_px.max() < 0.2)
    True
    """
    points_m, errors_px = board.points_m if corners_m is None else corners_m, []
    for seen in board_track.observations:
        if not path.time_ns[0] <= seen.time_ns <= path.time_ns[-1]:
            continue
        camera_T_board = path.motors_at(np.int64(seen.time_ns)).inverse() @ world_T_board
        expected = camera.project(camera_T_board.apply(points_m[seen.ids]))
        errors_px.append(np.sqrt(np.mean(np.sum((expected - seen.corners_px) ** 2, axis=-1))))
    return np.array(errors_px, dtype=np.float64)


def _heights_between(points: FloatArray, corners_m: FloatArray) -> FloatArray:
    """Heights of a bent print at places ``(*, 3)``: the bicubic surface nearest to its corners."""
    middle, half = corners_m[:, :2].mean(axis=0), 0.5 * np.ptp(corners_m[:, :2], axis=0).max()
    at, known = ((xyz[..., :2] - middle) / half for xyz in (points, corners_m))
    terms = polyvander2d(known[:, 0], known[:, 1], (3, 3))
    surface = np.linalg.lstsq(terms, corners_m[:, 2], rcond=1e-6)[0]
    within = np.clip(at, known.min(axis=0), known.max(axis=0))  # a cubic runs away outside
    return np.asarray(polyval2d(within[..., 0], within[..., 1], surface.reshape(4, 4)))


def _offset(drawn: FloatArray, shown: FloatArray, free: FloatArray) -> FloatArray | None:
    """Of one part, in its texels; None where the image does not look like the print."""
    from skimage.registration import phase_cross_correlation

    weight = free * np.outer(*(np.hanning(size + 2)[1:-1] for size in free.shape))
    both = [weight * (part - np.average(part, weights=weight)) for part in (drawn, shown)]
    down_right = phase_cross_correlation(
        both[1], both[0], upsample_factor=_UPSAMPLED, normalization=None
    )[0]
    moved = np.roll(both[0], np.rint(down_right).astype(int), (0, 1))
    lengths = float(np.linalg.norm(moved) * np.linalg.norm(both[1]))
    alike = float(np.sum(moved * both[1])) >= _ALIKE * lengths > 0.0
    return np.asarray(down_right[::-1], np.float64) if alike else None


@lru_cache(maxsize=8)
def _drawing(board: Board, px_per_m: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A print's levels, how free of corners its texels are, 0 to 1, and these in its frame."""
    drawn, origin = board.draw(px_per_m)
    rows, columns = np.indices(drawn.shape)
    flat = np.stack([columns - origin[0], origin[1] - rows], axis=-1) / px_per_m
    points = np.concatenate([flat, np.zeros((*drawn.shape, 1))], axis=-1)
    free = np.zeros(drawn.shape, np.uint8)
    px = board.points_m[:, :2] * (px_per_m, -px_per_m) + origin
    if isinstance(board, SquaresBoard):
        free[:] = 1
        for corner in np.rint(px).astype(int).tolist():
            cv2.circle(free, corner, round(_ROUND_CORNERS * board.corner_reach_m * px_per_m), 0, -1)
    else:
        quads = px.reshape(-1, 4, 2)
        inner = 1.0 - 2.0 * border_share(board.family)  # type: ignore[attr-defined]
        middles = quads.mean(axis=1, keepdims=True)
        cv2.fillPoly(free, list(np.rint(middles + inner * (quads - middles)).astype(np.int32)), 1)
    soft = cv2.GaussianBlur(free.astype(np.float64), (0, 0), 1.0)
    return drawn.astype(np.float64), soft, points
