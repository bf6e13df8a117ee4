"""Stage `placed`: which character stands where, upright on the board or on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor
from motorcade.replays.recording import Recording
from motorcade.replays.stages.smoothed import Smoothed
from motorcade.tracking import Board

FLOOR_HEIGHT_M = 1.75
FARTHEST_M = 4.0
"""On a floor the character stands at most this far in front of the first camera."""


@dataclass(frozen=True)
class Placed:
    """A character by name, the clip it plays, and where it stands in the world."""

    character: str
    clip: str
    placement: Placement


def placed(
    recording: Recording,
    smoothed: Smoothed,
    *,
    character: Literal["mannequin"] = "mannequin",
    clip: Literal["idle", "walk"] = "idle",
    on: Literal["auto", "board", "floor"] = "auto",
    floor_m: float = 0.0,
    position_m: tuple[float, ...] = (),
    heading_deg: float | None = None,
    height_m: float | None = None,
) -> Placed:
    """Stand the character on the board's plane or on the world's floor, z = `floor_m`.

    `position_m` (x, y) lies in the plane's own frame; without it the character stands in the
    middle of the board, or on the floor where the first camera looks. `heading_deg` turns from
    the plane's x towards its y; without it the character looks at the first camera. `height_m` is
    the character's; without it, half the board's shorter side, or 1.75 m on a floor.
    """
    board = recording.board
    if on == "board" and board is None:
        raise ValueError(f"{recording.name}: placed.on=board, but no board is known")
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, came {len(position_m)} numbers")
    first_camera = next(iter(smoothed.trajectories.values())).motors[0]
    if board is not None and on != "floor":
        plane, height = recording.world_T_board, 0.5 * min(board.size_m)
        position = position_m or _middle(board)
    else:
        plane = Motor.from_rotor_translation(Rotor.identity(), [0.0, 0.0, floor_m])
        height = FLOOR_HEIGHT_M
        position = position_m or _where_it_looks(plane.inverse() @ first_camera)
    towards = (plane.inverse() @ first_camera).translation_m[:2] - position
    heading = np.arctan2(towards[1], towards[0]) if heading_deg is None else np.deg2rad(heading_deg)
    placement = place_on_plane(
        character_named(character),
        position,
        heading,
        height_m=height if height_m is None else height_m,
        world_T_plane=plane,
    )
    return Placed(character, clip, placement)


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
