"""Stage `placed`: which character stands where, upright on a board, a plane found, or the floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera_poses import CameraPoses
from motorcade.replays.stages.ground import ground_on_board, ground_on_floor, ground_on_plane
from motorcade.replays.stages.smoothed import Smoothed


@dataclass(frozen=True)
class Placed:
    """A character by name, the clip it plays, where it stands in the world, and on what."""

    character: str
    clip: str
    placement: Placement
    stands_on: str


def placed(
    recording: Recording,
    camera_poses: CameraPoses,
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
    """Stand the character on the board or markers, on a plane that was found, or on a floor.

    `on` "auto" takes the board or the marker seen most where the poses come from it, else the plane
    where one is found (in depth, or among the points that SLAM mapped; the floor where gravity is
    known, a plane that faces the picture's up where it is not), else the floor: z = `floor_m`, in
    the world of SLAM a level `floor_m` above the foot of what was mapped. `position_m` (x, y) lies
    in the plane's own frame; without it the character stands in the middle of the board, marker or
    plane, or on the floor where the first camera looks. `heading_deg` turns from the plane's x
    towards its y; without it the character looks at the first camera. `height_m` is the
    character's; without it, half the shorter side of the board or plane, a marker's side, and at
    most 1.75 m, or 1.75 m on a floor; where lengths have no unit, at most a quarter of the scene's
    depth. Raises ValueError for a board or plane that is asked for and not there.
    """
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, came {len(position_m)} numbers")
    path = next(iter(smoothed.trajectories.values()))
    first_camera = path.motors[0]
    ground = None
    if on in ("auto", "board"):
        ground = ground_on_board(recording, camera_poses)
    if on == "plane" or (on == "auto" and ground is None):
        ground = ground_on_plane(recording, camera_poses, path)
    if ground is None and on in ("board", "plane"):
        lacking = "no board is known" if on == "board" else "no plane that faces up was found"
        raise ValueError(f"{recording.name}: placed.on={on}, but {lacking}")
    if ground is None:
        ground = ground_on_floor(recording, camera_poses, path, floor_m)
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


def character_named(name: str) -> Character:
    """The character that a `Placed` speaks of."""
    if name != "mannequin":
        raise ValueError(f"placed.character: expected mannequin, came {name!r}")
    return mannequin()
