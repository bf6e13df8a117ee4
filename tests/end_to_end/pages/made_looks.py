"""Pages of runs that never were: any camera, path and character, and films whose frames tell their
own numbers.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import Performer
from motorcade.replays.pipeline.look import shown_camera, shown_character
from motorcade.replays.pipeline.packing import packed, rows_at
from motorcade.replays.web.film import write_film
from motorcade.replays.web.page import inner_film, view_page
from motorcade.tracking import Camera

BITS, SIDE_PX = 12, 16
RATE_HZ = 30.0


def stamps(frames: int) -> np.ndarray:
    return np.round(np.arange(frames) * 1e9 / RATE_HZ).astype(np.int64)


def numbered(frames: int, camera: Camera) -> Iterator[np.ndarray]:
    """Moving waves; the first row of squares is the frame's number in black and white."""
    rows, columns = np.mgrid[: camera.height, : camera.width]
    for number in range(frames):
        wave = 40 * np.sin(0.05 * columns + 0.21 * number) * np.cos(0.04 * rows - 0.13 * number)
        image = (128 + wave).astype(np.uint8)
        for bit in range(BITS):
            square = np.s_[:SIDE_PX, SIDE_PX * bit : SIDE_PX * (bit + 1)]
            image[square] = 255 * (number >> bit & 1)
        yield image


def looking_at(target_m: np.ndarray, from_m: np.ndarray, roll_rad: np.ndarray) -> Motor:
    """Cameras ``(F,)`` in OpenCV's axes that look at a point, rolled about their axis."""
    ahead = target_m - from_m
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    turned = Rotor.from_matrix(np.stack([right, np.cross(ahead, right), ahead], axis=-1))
    about = Rotor.from_rotation_vector(np.stack([0 * roll_rad, 0 * roll_rad, roll_rad], axis=-1))
    return Motor.from_rotor_translation(turned @ about, from_m)


@dataclass(frozen=True)
class MadeLook:
    """What a page shows: a camera on its way, and a figure."""

    camera: Camera
    world_T_camera: Motor
    figure: Performer
    hiding: dict[str, Any] | None = None

    @property
    def time_ns(self) -> np.ndarray:
        return stamps(len(self.world_T_camera.translation_m))

    def document(self, clips: list[dict[str, str]]) -> dict[str, Any]:
        time_ns = self.time_ns
        path = Trajectory(time_ns, self.world_T_camera, "world", "camera")
        square = np.array([[-1.0, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
        line = {
            "line_s": packed(1e-9 * time_ns, "f64"),
            "line_m": packed(self.world_T_camera.translation_m),
            "at_frames": packed(rows_at(path, time_ns), "f64"),
        }
        camera = shown_camera(self.camera)
        return {
            "format": "motorcade-look",
            "version": 1,
            "name": "made",
            "headline": "a run that never was",
            "unit": "m",
            "up": [0.0, 0.0, 1.0],
            "film": {
                "width": camera["width"],
                "height": camera["height"],
                "rate_hz": RATE_HZ,
                "time_s": packed(1e-9 * time_ns, "f64"),
                "clips": clips,
            },
            "camera": camera,
            "drawn": "motor",
            "paths": [{"name": "motor", "label": "Smoothed, motors", **line}],
            "boards": [],
            "markers": [],
            "planes": [
                {
                    "name": "floor",
                    "corners_m": packed(
                        self.figure.placement.world_T_character.apply(square), "f64"
                    ),
                }
            ],
            "points_m": packed(np.zeros((0, 3))),
            "characters": [shown_character("figure", self.figure, time_ns)],
            "hiding": self.hiding
            or {"depth": None, "prints": packed(np.zeros((0, 4, 3))), "ground": None},
            "plots": [],
            "states": [],
        }

    def write(self, path: Path, film: bool) -> Path:
        """Write the page, with a film of numbered frames where one is asked for."""
        films, clips = [], []
        if film:
            place = path.with_suffix(".mp4")
            write_film(place, numbered(len(self.time_ns), self.camera), self.time_ns)
            films = [inner_film("film-1", place)]
            clips = [{"name": "footage", "src": "#film-1"}]
        path.write_text(view_page([self.document(clips)], films), encoding="utf-8")
        return path
