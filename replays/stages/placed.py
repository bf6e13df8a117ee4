"""Stage `placed`: which character stands where, upright on the board or on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.ga import Motor
from motorcade.replays.recording import Recording
from motorcade.tracking import Board


@dataclass(frozen=True)
class Placed:
    """A character by name, the clip it plays, and where it stands in the world."""

    character: str
    clip: str
    placement: Placement


def placed(
    recording: Recording,
    *,
    character: Literal["mannequin"] = "mannequin",
    clip: Literal["idle", "walk"] = "idle",
    on: Literal["auto", "board", "floor"] = "auto",
    position_m: tuple[float, ...] = (),
    heading_deg: float = 0.0,
    height_m: float | None = None,
) -> Placed:
    """Stand the character on the board's plane or on the world's floor, z = 0.

    `position_m` (x, y) lies in the plane's own frame; without it the character stands in the
    middle of the board, or at the world's origin. `height_m` is the character's; without it,
    half the board's shorter side, or 1.75 m on a floor.
    """
    board = recording.board
    on_board = on == "board" or (on == "auto" and board is not None)
    if on_board and board is None:
        raise ValueError(f"{recording.name}: placed.on=board, but no board is known")
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, came {len(position_m)} numbers")
    plane, centre, height = Motor.identity(), (0.0, 0.0), 1.75
    if on_board and board is not None:
        plane, centre, height = recording.world_T_board, _middle(board), 0.5 * min(board.size_m)
    placement = place_on_plane(
        character_named(character),
        position_m or centre,
        np.deg2rad(heading_deg),
        height_m=height_m or height,
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
