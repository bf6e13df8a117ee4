"""Stage `placed`: which character stands where, upright on the board or on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.animation.place import Placement, place_on_plane
from motorcade.replays.recording import Recording


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
    clip: Literal["idle", "walk"] = "walk",
    on: Literal["auto", "board", "floor"] = "auto",
    position_m: tuple[float, ...] = (),
    heading_deg: float = 0.0,
    height_m: float | None = None,
) -> Placed:
    """Stand the character on the board's plane or on the world's floor, z = 0.

    `position_m` (x, y) lies in the plane's own frame; without it the character stands in the
    middle of the board, or at the world's origin. `height_m` is the character's; without it, the
    board's shorter side, or 1.75 m on a floor.
    """
    board = recording.board
    on_board = on == "board" or (on == "auto" and board is not None)
    if on_board and board is None:
        raise ValueError(f"{recording.name}: placed.on=board, but no board is known")
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, came {len(position_m)} numbers")
    if on_board and board is not None:
        centre = board.centre_m[:2] if not position_m else np.array(position_m)
        height = height_m or min(board.size_m)
        world_T_plane = recording.world_T_board
    else:
        centre = np.array(position_m or (0.0, 0.0))
        height = height_m or 1.75
        world_T_plane = None
    placement = place_on_plane(
        centre, np.deg2rad(heading_deg), height_m=height, world_T_plane=world_T_plane
    )
    return Placed(character, clip, placement)
