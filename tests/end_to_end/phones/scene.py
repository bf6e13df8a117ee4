"""What a phone is pointed at: a desk with boxes before a wall, and what is printed and laid on it.

World: metres, z up, the desk's top at z = 0, its middle the origin, the wall behind it at +y.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Board, SingleMarker
from tests.textured_room.scene import Panel, bars_over_noise, upright_box

__all__ = ["LaidTag", "desk", "print_on", "tag_panels"]

_PRINT_PIXELS = 1400.0  # along a print's longer side
_FINENESS = 3.0  # texels of 1/256 m are too coarse for what is a metre away
_DESK_M, _WALL_Y_M, _WALL_M = 2.4, 1.1, (4.0, 2.4)
# centre x, y; size x, y, z; turn about z
_BOXES = (
    (-0.62, 0.42, 0.30, 0.22, 0.34, 0.4),
    (0.60, 0.46, 0.24, 0.30, 0.22, -0.3),
    (0.05, 0.72, 0.40, 0.16, 0.46, 0.1),
    (-0.66, -0.30, 0.18, 0.20, 0.12, 0.7),
    (0.68, -0.22, 0.20, 0.16, 0.15, -0.6),
)


@dataclass(frozen=True)
class LaidTag:
    """A tag that lies or leans somewhere: its id, where its middle is, and how it is turned."""

    marker_id: int
    middle_m: tuple[float, float, float]
    turn_rad: tuple[float, float, float]

    def world_T_tag(self) -> Motor:
        """Pose of its middle; a tag's x is right and y up as printed."""
        turn = Rotor.from_rotation_vector(self.turn_rad)
        return Motor.from_rotor_translation(turn, self.middle_m)


def desk(rng: np.random.Generator, *, boxes: bool) -> list[Panel]:
    """The desk's top and the wall, and boxes on it."""
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    z = np.array([0.0, 0.0, 1.0])
    wide, tall = _WALL_M
    faces = [
        (np.array([-0.5 * _DESK_M, _WALL_Y_M, 0.0]), _DESK_M * x, -_DESK_M * y),
        (np.array([-0.5 * wide, _WALL_Y_M, tall - 0.6]), wide * x, -tall * z),
    ]
    for bx, by, sx, sy, sz, turn in _BOXES if boxes else ():
        faces += upright_box((bx, by), (sx, sy, sz), turn)[:5]
    return [
        Panel(*face, bars_over_noise(_FINENESS * face[1], _FINENESS * face[2], rng))
        for face in faces
    ]


def print_on(board: Board, middle_m: FloatArray, turn: Rotor) -> Panel:
    """A board printed on stiff paper, its middle somewhere; x right and y up as printed."""
    scale = _PRINT_PIXELS / max(board.size_m)
    image, (left, top) = board.draw(scale)
    height, width = image.shape
    low, high = board.points_m.min(axis=0), board.points_m.max(axis=0)
    # From the board's origin to the texture's corner; pixel (0, 0) is a centre.
    corner = np.array([-(left + 0.5) / scale, (top + 0.5) / scale, 0.0]) - 0.5 * (low + high)
    right, down = np.array([width / scale, 0.0, 0.0]), np.array([0.0, -height / scale, 0.0])
    return Panel(turn.apply(corner) + middle_m, turn.apply(right), turn.apply(down), image)


def tag_panels(family: str, side_m: float, tags: tuple[LaidTag, ...]) -> list[Panel]:
    """Loose tags as prints."""
    return [
        print_on(
            SingleMarker(family, tag.marker_id, side_m),
            np.array(tag.middle_m),
            Rotor.from_rotation_vector(tag.turn_rad),
        )
        for tag in tags
    ]
