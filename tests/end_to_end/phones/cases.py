"""The twelve clips: what each shows, how the phone is held and what its camera does.

Two sets of seeds: constants of self-calibration are set on "setting", figures are given for
"judging". Seeds change paths, textures, stamps and noise, and lenses by some per cent.

Focal lengths are those of phones' main (26 mm), wide (13 to 16 mm) and long (52 mm) cameras for an
image of 36 mm across its long side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Board, Camera, CharucoBoard, Checkerboard, MarkerGrid
from tests.end_to_end.phones.scene import LaidTag
from tests.end_to_end.phones.sensor import PhoneCamera

__all__ = ["CASES", "SEEDS", "Case", "Seen", "path_of", "phone_of"]

SEEDS = {"setting": 100, "judging": 200}
Rotation = Literal[0, 90, 270]
Held = Literal["round", "across", "turning"]
LONG, SHORT = 1920, 1080


@dataclass(frozen=True)
class Seen:
    """What is laid on the desk: a board, loose tags, or nothing."""

    board: Board | None = None
    tags: tuple[LaidTag, ...] = ()
    family: str = "tag36h11"
    side_m: float = 0.08


@dataclass(frozen=True)
class Case:
    """One clip.

    Fields:
        name: of its file.
        shows: what is laid on the desk.
        focal_mm: for 36 mm along the image's long side.
        lens: distortion, by model.
        rotation: clockwise degrees by which a player turns the stored image.
        readout_s: of the sensor, in its own rows.
        exposure_s: of a line.
        breathing: amplitude of the relative change of the focal length.
        variable_rate: whether frames come unevenly and some are dropped.
        held: round the print, across the room, or turning about the lens.
        distance_m: from what is filmed.
        bears: whether a camera and a path follow from it.
    """

    name: str
    shows: Seen
    focal_mm: float
    lens: tuple[str, tuple[float, ...]]
    rotation: Rotation = 0
    readout_s: float = 0.0
    exposure_s: float = 0.004
    breathing: float = 0.0
    variable_rate: bool = False
    held: Held = "round"
    distance_m: float = 0.6
    bears: bool = True

    @property
    def size(self) -> tuple[int, int]:
        """Upright width and height."""
        return (LONG, SHORT) if self.rotation == 0 else (SHORT, LONG)


_LOOSE = (
    LaidTag(3, (0.0, 0.0, 0.001), (0.0, 0.0, 0.2)),
    LaidTag(11, (0.19, 0.07, 0.001), (0.0, 0.0, 1.1)),
    LaidTag(4, (-0.18, 0.10, 0.001), (0.0, 0.0, -0.5)),
    LaidTag(27, (0.05, 0.22, 0.06), (1.1, 0.0, 0.0)),
    LaidTag(8, (-0.14, -0.13, 0.04), (-0.5, 0.3, 0.4)),
)
_PLAIN = ("pinhole", ())
_MILD = ("radtan", (0.06, -0.09))
_BENT = ("radtan", (-0.13, 0.025))
_FISH = ("equidistant", (0.02, -0.008, 0.0, 0.0))

CASES = (
    Case("checker", Seen(Checkerboard(9, 6, 0.025)), 26.0, _MILD),
    Case(
        "checker_tall_rolling",
        Seen(Checkerboard(8, 5, 0.03)),
        26.0,
        _PLAIN,
        rotation=90,
        readout_s=0.020,
        variable_rate=True,
    ),
    Case(
        "charuco_wide",
        Seen(CharucoBoard("aruco_4x4_50", 7, 5, 0.04, 0.03)),
        14.0,
        _BENT,
        distance_m=0.34,
    ),
    Case(
        "charuco_tall_breathing",
        Seen(CharucoBoard("aruco_5x5_100", 6, 8, 0.03, 0.022)),
        26.0,
        _MILD,
        rotation=270,
        breathing=0.012,
        variable_rate=True,
    ),
    Case(
        "grid_rolling_blurred",
        Seen(MarkerGrid("tag36h11", 4, 3, 0.05, 0.015)),
        26.0,
        _MILD,
        readout_s=0.024,
        exposure_s=0.012,
    ),
    Case(
        "grid_tall_long",
        Seen(MarkerGrid("tag25h9", 3, 4, 0.045, 0.0135)),
        52.0,
        _PLAIN,
        rotation=90,
        distance_m=0.9,
        readout_s=0.012,
    ),
    Case("loose", Seen(tags=_LOOSE), 26.0, _MILD, variable_rate=True),
    Case(
        "loose_tall_rolling",
        Seen(tags=_LOOSE[:4]),
        26.0,
        _PLAIN,
        rotation=90,
        readout_s=0.018,
        variable_rate=True,
    ),
    Case(
        "loose_wide",
        Seen(tags=_LOOSE, family="aruco_4x4_50"),
        15.0,
        _FISH,
        distance_m=0.36,
        readout_s=0.015,
    ),
    Case("room", Seen(), 26.0, _MILD, held="across", distance_m=1.3),
    Case(
        "room_tall_rolling",
        Seen(),
        26.0,
        _PLAIN,
        rotation=90,
        readout_s=0.012,
        held="across",
        distance_m=1.3,
        variable_rate=True,
    ),
    Case("room_turning", Seen(), 26.0, _MILD, held="turning", distance_m=1.3, bears=False),
)


def phone_of(case: Case, seed: int) -> PhoneCamera:
    """The camera of a case: a seed moves focal length and centre as phones differ."""
    rng = np.random.default_rng([seed, CASES.index(case), 1])
    width, height = case.size
    focal = case.focal_mm / 36.0 * LONG * (1.0 + 0.04 * rng.uniform(-1.0, 1.0))
    middle = 0.5 * (np.array(case.size) - 1.0) + 8.0 * rng.uniform(-1.0, 1.0, 2)
    model, terms = case.lens
    camera = Camera(width, height, focal, focal, *middle.tolist(), model, terms)
    # A player turns stored rows clockwise: by 90 degrees the first becomes the rightmost column.
    readout = {0: (0.0, 1.0), 90: (-1.0, 0.0), 270: (1.0, 0.0)}[case.rotation]
    turned = (case.readout_s * readout[0], case.readout_s * readout[1])
    return PhoneCamera(camera, turned, case.exposure_s, case.breathing)


def path_of(case: Case, seed: int) -> Callable[[FloatArray], Motor]:
    """world_T_camera of a hand, at times in seconds; smooth, exact at any time."""
    rng = np.random.default_rng([seed, CASES.index(case), 2])
    phase = rng.uniform(0.0, 2.0 * np.pi, 9)
    rate = rng.uniform(0.85, 1.15, 9)

    def wave(time: FloatArray, which: int, radians_s: float) -> FloatArray:
        return np.asarray(np.sin(radians_s * rate[which] * time + phase[which]), np.float64)

    def at(time_s: FloatArray) -> Motor:
        time = np.asarray(time_s, np.float64)
        near = case.distance_m
        if case.held == "round":
            azimuth = -0.5 * np.pi + 0.75 * wave(time, 0, 0.9) + 0.02 * wave(time, 1, 5.0)
            height = 0.95 + 0.30 * wave(time, 2, 1.3) + 0.015 * wave(time, 3, 6.0)
            distance = near * (1.0 + 0.15 * wave(time, 4, 0.8))
            target = 0.10 * near * np.stack([wave(time, 5, 1.7), wave(time, 6, 1.4), 0 * time], -1)
        else:
            azimuth = -0.5 * np.pi + 0.30 * wave(time, 0, 0.8)
            height = 0.5 + 0.08 * wave(time, 2, 1.1)
            distance = near * (1.0 + 0.10 * wave(time, 4, 0.7))
            target = np.stack(
                [0.15 * wave(time, 5, 0.9), 0.3 + 0 * time, 0.08 + 0.05 * wave(time, 6, 1.3)], -1
            )
        if case.held == "turning":
            place = np.broadcast_to([0.0, -1.1, 0.7], (*time.shape, 3))
            target = np.stack(
                [0.5 * wave(time, 5, 1.1), 0.3 + 0 * time, 0.2 * wave(time, 6, 1.5)], -1
            )
        else:
            out = np.stack(
                [
                    np.cos(height) * np.cos(azimuth),
                    np.cos(height) * np.sin(azimuth),
                    np.sin(height),
                ],
                axis=-1,
            )
            place = target + distance[..., None] * out
        return _looking(place, target, 0.12 * wave(time, 7, 1.2))

    return at


def _looking(place: FloatArray, target: FloatArray, roll: FloatArray) -> Motor:
    """Cameras at places that look at targets, turned about the axis by `roll`."""
    ahead = target - place
    ahead = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right = right / np.linalg.norm(right, axis=-1, keepdims=True)
    down = np.cross(ahead, right)
    level = Rotor.from_matrix(np.stack([right, down, ahead], axis=-1))
    about = np.stack([0 * roll, 0 * roll, roll], axis=-1)
    return Motor.from_rotor_translation(level @ Rotor.from_rotation_vector(about), place)
