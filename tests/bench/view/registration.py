"""How a virtual checkerboard drawn onto the real one of `vamr_board` sticks to it, in pixels.

The board is drawn into every frame along the path, and its drawn corners are found again by the
detector that found the real ones. Once on the frames as they were taken, drawn through the lens,
and once on frames whose distortion was taken out. Beside it, how much a virtual point above the
board jitters in the image along each path. Smoothing steadies the point, but the footage itself
is shaken by the hand that took it: what is smoother than that slides against it, and the distances
of corners say by how much.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.smoothing import smooth
from motorcade.fusion.smoothing.view import steady_view, turned_homography
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.composite import as_rgb, over
from motorcade.render.lens import LensWarp
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.tracking import BoardTrack, track_board
from motorcade.tracking.boards import BoardCorners, Checkerboard
from motorcade.tracking.cameras.camera import Camera
from tests.bench.data import data_folder
from tests.bench.tracking.board_smoothing import CAUSAL, OFFLINE
from tests.bench.view.printed import printed_surface

__all__ = [
    "Registration",
    "bench_registration",
    "drawn_corner_distances_px",
    "jitter_px",
    "registration_lines",
    "straightened",
    "vamr_board",
]

PIXELS_PER_M = 4000.0
INK, PAPER = np.array([32, 44, 96]), np.array([244, 240, 228])
EDGE_PX = 10.0
RATIOS = 0.4, 0.24
ABOVE_M = (0.16, -0.10, 0.15)
"""The virtual point: over the middle of the board, as high as a character's head."""
_MANIFEST = Path(__file__).parents[3] / "docs" / "manifests" / "vamr_board.toml"


@dataclass(frozen=True, eq=False)
class Registration:
    """Distances between drawn and real corners of all frames in which the drawn board was found.

    Attributes:
        distance_px: (K,) all corners of all frames.
        frames: in which it was looked for.
        found: in which it was found.
    """

    distance_px: FloatArray
    frames: int
    found: int

    @property
    def rms_px(self) -> float:
        """Root mean square distance."""
        return float(np.sqrt(np.mean(self.distance_px**2)))


def drawn_corner_distances_px(
    frames: Iterable[tuple[int, ImageArray]],
    camera: Camera,
    path: Trajectory,
    track: BoardTrack,
    board: Checkerboard,
    world_T_board: Motor,
) -> Registration:
    """Draw the board over the real one along a path, find it again, and measure.

    Args:
        frames: stamps and images, of `camera`'s size.
        camera: whose images these are, with its distortion.
        path: `world_T_camera`.
        track: where the real corners were found, in pixels of the camera that tracked; straight
            ones are taken where `camera` has no distortion and the track's had.
        board: the real board.
        world_T_board: where it is.
    """
    lens = LensWarp(camera)
    image, origin = board.draw(PIXELS_PER_M)
    tone = image[..., None] / 255.0
    colored = np.rint(INK + (PAPER - INK) * tone).astype(np.uint8)
    surface = printed_surface(colored, PIXELS_PER_M, origin, world_T_board)
    real = {seen.time_ns: seen for seen in track.observations}
    distances, looked = [], 0
    with new_renderer("fast", lens.pinhole.width, lens.pinhole.height) as renderer:
        renderer.show([surface], None)
        for time_ns, frame in frames:
            if time_ns not in real or not path.time_ns[0] <= time_ns <= path.time_ns[-1]:
                continue
            looked += 1
            layer = lens.layer(renderer.render(lens.pinhole, path.motors_at(np.int64(time_ns))))
            made = over(as_rgb(frame), layer)
            seen = real[time_ns]
            expected = np.full((board.columns * board.rows, 2), np.nan)
            expected[seen.ids] = seen.corners_px
            drawn = _found(board, made[..., 1].copy(), expected)
            apart = np.linalg.norm(drawn.corners_px - expected[drawn.ids], axis=1)
            apart = apart[np.isfinite(apart)]
            if apart.size:
                distances.append(apart)
    return Registration(np.concatenate(distances), looked, len(distances))


def _found(board: Checkerboard, image: ImageArray, real_px: FloatArray) -> BoardCorners:
    """The drawn corners: all of them, or where the board reaches out of the image, those in it.

    The latter are sought as saddles about where the real ones are.
    """
    drawn = board.detect(image)
    if drawn is not None:
        return board.aligned(drawn, np.nan_to_num(real_px))
    size = np.array([image.shape[1], image.shape[0]])
    with np.errstate(invalid="ignore"):
        ids = np.flatnonzero(np.all((real_px > EDGE_PX) & (real_px < size - EDGE_PX), axis=1))
    return board.refine_corners(image, BoardCorners(ids, real_px[ids], board.points_m[ids]))


def jitter_px(path: Trajectory, camera: Camera, point_m: FloatArray) -> float:
    """How much a point of the world jitters in the images along a path, pixels.

    Root mean square of third differences over √20: the deviation of white noise that would give
    them, while smooth motion hardly counts.

    Args:
        path: `world_T_camera`, at even stamps.
        camera: who sees the point.
        point_m: (3,) world.
    """
    seen = camera.project(path.motors.inverse().apply(point_m))
    third = np.diff(seen, 3, axis=0)
    return float(np.sqrt(np.mean(np.sum(third**2, axis=1)) / 20.0))


def vamr_board() -> tuple[Recording, Checkerboard, Camera, BoardTrack]:
    """The recording, its board and camera, and where the board was found.

    Raises:
        OSError: the recording is not here.
        ValueError: it has no camera or no checkerboard.
    """
    recording = open_recording(data_folder() / "replays" / "vamr_board", _MANIFEST)
    if recording.camera is None or not isinstance(recording.board, Checkerboard):
        raise ValueError(f"{recording.name}: expected a camera and a checkerboard, got none")
    images = ((frame.time_ns, frame.gray()) for frame in recording.frames)
    return (
        recording,
        recording.board,
        recording.camera,
        track_board(images, recording.camera, recording.board),
    )


def straightened(track: BoardTrack, camera: Camera) -> BoardTrack:
    """The same track with its corners as the camera without distortion would have them."""
    moved = tuple(
        replace(seen, corners_px=camera.undistort(seen.corners_px)) for seen in track.observations
    )
    return replace(track, observations=moved)


def bench_registration() -> dict[str, Any]:
    """Distances and jitter along the path as tracked, and smoothed causally and offline.

    Raises:
        OSError: the recording is not here.
    """
    recording, board, camera, track = vamr_board()
    raw = track.measurements.trajectory
    paths = {"as tracked": raw}
    for name, (method, settings) in (("causal", CAUSAL), ("offline", OFFLINE)):
        paths[name] = smooth(raw, method, "motor", **settings)
    images = [(frame.time_ns, frame.image()) for frame in recording.frames]
    straight = [(stamp, camera.undistort_image(one)) for stamp, one in images]
    corners = []
    for name, path in paths.items():
        for kind, frames, lens, seen in (
            ("distorted", images, camera, track),
            ("undistorted", straight, camera.undistorted(), straightened(track, camera)),
        ):
            found = drawn_corner_distances_px(frames, lens, path, seen, board, Motor.identity())
            corners.append(
                {
                    "path": name,
                    "frames_are": kind,
                    "corner_rms_px": found.rms_px,
                    "corner_max_px": float(found.distance_px.max()),
                    "found": found.found,
                    "frames": found.frames,
                }
            )
    steadied = {
        name: steadied_view(raw, track, board, camera, live=live)
        for name, live in (("live", True), ("offline", False))
    }
    if recording.truth is not None:
        paths["reference"] = recording.truth
    jitters = {name: jitter_px(path, camera, np.array(ABOVE_M)) for name, path in paths.items()}
    point_m = np.array(ABOVE_M)
    least = [(ratio, least_slide_px(raw, camera, point_m, ratio)) for ratio in RATIOS]
    return {"corners": corners, "jitter_px": jitters, "steadied": steadied, "least_px": least}


def steadied_view(
    path: Trajectory, track: BoardTrack, board: Checkerboard, camera: Camera, *, live: bool
) -> dict[str, float]:
    """Jitter of the virtual point in a steadied view, over that in the footage as tracked, and how
    far drawn corners lie from the real ones in the images so turned.
    """
    straight = camera.undistorted()
    view = steady_view(path, ABOVE_M, live=live)
    turns = turned_homography(straight.matrix, path.motors.rotor, view.motors.rotor)
    apart = []
    for k, seen in enumerate(track.observations):
        flat = camera.undistort(seen.corners_px)
        moved = np.pad(flat, ((0, 0), (0, 1)), constant_values=1.0) @ turns[k].T
        drawn = straight.project(view.motors[k].inverse().apply(board.points_m[seen.ids]))
        apart.append(np.sum((drawn - moved[:, :2] / moved[:, 2:]) ** 2, axis=1))
    point = np.array(ABOVE_M)
    share = jitter_px(view, straight, point) / jitter_px(path, straight, point)
    return {"jitter_share": share, "corner_rms_px": float(np.sqrt(np.mean(np.concatenate(apart))))}


def least_slide_px(path: Trajectory, camera: Camera, point_m: FloatArray, ratio: float) -> float:
    """Least root mean square distance that any path's image of a point has from the tracked one's
    where it jitters by `ratio` of that at most: the smoothest line near a line (Whittaker 1923).
    """
    seen = camera.undistorted().project(path.motors.inverse().apply(point_m))
    third = np.diff(np.eye(len(seen)), 3, axis=0)
    wanted = ratio * np.linalg.norm(third @ seen)
    low, high = -6.0, 6.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        line = np.linalg.solve(np.eye(len(seen)) + 10.0**middle * third.T @ third, seen)
        low, high = (middle, high) if np.linalg.norm(third @ line) > wanted else (low, middle)
    return float(np.sqrt(np.mean(np.sum((line - seen) ** 2, axis=1))))


def registration_lines(found: Mapping[str, Any]) -> Iterator[str]:
    """A line a path and kind of frames, then one a path."""
    for row in found["corners"]:
        yield (
            f"  {row['path']:<12}{row['frames_are']:<13}{row['corner_rms_px']:.3f} px RMS, at most "
            f"{row['corner_max_px']:.2f}, drawn board found in {row['found']} of {row['frames']}"
        )
    for name, row in found["steadied"].items():
        yield (
            f"  steadied view, {name:<8} jitters {row['jitter_share']:.2f} of as tracked, drawn "
            f"corners {row['corner_rms_px']:.3f} px RMS from the real ones"
        )
    for ratio, pixels in found["least_px"]:
        yield (
            f"  on footage as it is, what jitters {ratio:.2f} of as tracked slides {pixels:.2f} px "
            "or more, whatever the filter"
        )
    tracked = found["jitter_px"]["as tracked"]
    for name, pixels in found["jitter_px"].items():
        yield f"  {name:<12}jitters {pixels:.3f} px, {pixels / tracked:.2f} of as tracked"


if __name__ == "__main__":
    print("\n".join(registration_lines(bench_registration())))
