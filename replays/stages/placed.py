"""Stage `placed`: which character stands where, upright on a board, a plane found, or the floor.

Where a recording has no board but depth, the plane is searched in its depth. Which way is up is not
known there (the world of 7-Scenes, for one, is not upright): the largest plane whose normal is near
the picture's own up is taken, and what was taken is said in `Placed.stands_on`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor
from motorcade.replays.recording import Frame, Recording
from motorcade.replays.stages.smoothed import Smoothed
from motorcade.tracking import Board
from motorcade.tracking.planes import Plane, choose_stage, find_planes_in_depth

FLOOR_HEIGHT_M = 1.75
FARTHEST_M = 4.0
"""On a floor the character stands at most this far in front of the first camera."""
_FRAMES_SEARCHED = 5


@dataclass(frozen=True)
class Placed:
    """A character by name, the clip it plays, where it stands in the world, and on what."""

    character: str
    clip: str
    placement: Placement
    stands_on: str


@dataclass(frozen=True)
class _Ground:
    """A plane to stand on, with where on it and how high unless the user says otherwise."""

    world_T_plane: Motor
    position_m: tuple[float, float]
    height_m: float
    name: str


def placed(
    recording: Recording,
    smoothed: Smoothed,
    *,
    character: Literal["mannequin"] = "mannequin",
    clip: Literal["idle", "walk"] = "idle",
    on: Literal["auto", "board", "plane", "floor"] = "auto",
    floor_m: float = 0.0,
    position_m: tuple[float, ...] = (),
    heading_deg: float | None = None,
    height_m: float | None = None,
) -> Placed:
    """Stand the character on the board, on a plane found in depth, or on the floor, z = `floor_m`.

    `on` "auto" takes the board where there is one, else the plane where one is found, else the
    floor. `position_m` (x, y) lies in the plane's own frame; without it the character stands in the
    middle of the board or plane, or on the floor where the first camera looks. `heading_deg` turns
    from the plane's x towards its y; without it the character looks at the first camera. `height_m`
    is the character's; without it, half the shorter side of the board or plane and at most 1.75 m,
    or 1.75 m on a floor. Raises ValueError for a board or plane that is asked for and not there.
    """
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, came {len(position_m)} numbers")
    first_camera = next(iter(smoothed.trajectories.values())).motors[0]
    ground = None
    if on in ("auto", "board"):
        ground = _on_board(recording)
    if on == "plane" or (on == "auto" and ground is None):
        ground = _on_plane(recording, smoothed)
    if ground is None and on in ("board", "plane"):
        lacking = "no board is known" if on == "board" else "no plane that faces up has depth"
        raise ValueError(f"{recording.name}: placed.on={on}, but {lacking}")
    if ground is None:
        ground = _on_floor(first_camera, floor_m)
    plane = ground.world_T_plane
    position = position_m or ground.position_m
    towards = (plane.inverse() @ first_camera).translation_m[:2] - position
    heading = np.arctan2(towards[1], towards[0]) if heading_deg is None else np.deg2rad(heading_deg)
    placement = place_on_plane(
        character_named(character),
        position,
        heading,
        height_m=ground.height_m if height_m is None else height_m,
        world_T_plane=plane,
    )
    return Placed(character, clip, placement, ground.name)


def _on_board(recording: Recording) -> _Ground | None:
    board = recording.board
    if board is None:
        return None
    height = 0.5 * min(board.size_m)
    return _Ground(recording.world_T_board, _middle(board), height, "the board")


def _on_floor(first_camera: Motor, floor_m: float) -> _Ground:
    plane = Motor.from_rotor_translation(Rotor.identity(), [0.0, 0.0, floor_m])
    position = _where_it_looks(plane.inverse() @ first_camera)
    return _Ground(plane, position, FLOOR_HEIGHT_M, f"the world's z = {floor_m:g} m")


def _on_plane(recording: Recording, smoothed: Smoothed) -> _Ground | None:
    """The first plane to stand on that the depth of a few frames shows."""
    path = next(iter(smoothed.trajectories.values()))
    for frame in _with_depth(recording, int(path.time_ns[0]), int(path.time_ns[-1])):
        world_T_camera = path.motors_at(np.int64(frame.time_ns))
        plane = _stage(recording, frame, world_T_camera)
        if plane is not None:
            wide, tall = plane.size_m
            name = (
                f"a plane of {wide:.2f} x {tall:.2f} m found in the depth of {frame.name}, "
                "up being the picture's"
            )
            height = min(0.5 * min(plane.size_m), FLOOR_HEIGHT_M)
            return _Ground(plane.world_T_plane, (0.0, 0.0), height, name)
    return None


def _with_depth(recording: Recording, first_ns: int, last_ns: int) -> Iterator[Frame]:
    """A few frames that have depth and a pose, evenly over the recording."""
    if recording.camera is None:
        return
    stamps = recording.frames.time_ns
    posed = np.flatnonzero((stamps >= first_ns) & (stamps <= last_ns))
    step = max(1, len(posed) // _FRAMES_SEARCHED)
    for index in posed[::step][:_FRAMES_SEARCHED]:
        frame = recording.frames[int(index)]
        if frame.read_depth is not None:
            yield frame


def _stage(recording: Recording, frame: Frame, world_T_camera: Motor) -> Plane | None:
    """The plane to stand on in one frame's depth, in the world."""
    depth, camera = frame.depth_m(), recording.camera
    if depth is None or camera is None:
        return None
    try:
        found = find_planes_in_depth(depth, camera, np.random.default_rng(0))
    except ValueError:  # hardly any depth in this frame: another may have more
        return None
    return choose_stage([plane.moved(world_T_camera) for plane in found.planes], world_T_camera)


def character_named(name: str) -> Character:
    """The character that a `Placed` speaks of."""
    if name != "mannequin":
        raise ValueError(f"placed.character: expected mannequin, came {name!r}")
    return mannequin()


def _middle(board: Board) -> tuple[float, float]:
    """Centre of the board's corners in its own plane, metres."""
    low, high = board.points_m.min(axis=0), board.points_m.max(axis=0)
    x, y, _ = (low + high) / 2
    return float(x), float(y)


def _where_it_looks(floor_T_camera: Motor) -> tuple[float, float]:
    """Where the optical axis meets the floor, or a few paces ahead if that is far or never."""
    centre = floor_T_camera.translation_m
    gaze = floor_T_camera.rotor.apply([0.0, 0.0, 1.0])
    reach_m = -centre[2] / gaze[2] if gaze[2] < 0.0 < centre[2] else np.inf
    along = float(np.hypot(gaze[0], gaze[1]))
    ahead_m = min(reach_m * along, FARTHEST_M) if along > 0.0 else 0.0
    x, y = centre[:2] + (ahead_m / along * gaze[:2] if along > 0.0 else 0.0)
    return float(x), float(y)
