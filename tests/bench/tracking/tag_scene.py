"""Markers drawn as a camera sees them, with exact truth: for measuring what detectors do to them.

Each marker is a flat print with a white margin, drawn through its homography at four times the
image's resolution and averaged down; then lens blur, light, noise and rounding. A pinhole camera:
what lenses do is measured elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.families import layout, marker_cells, marker_points_m

__all__ = ["TagScene", "handheld_path", "wall_of_markers"]

_FINE = 4
_CELL_PX = 24
_BLACK, _WHITE, _AROUND = 40.0, 200.0, 120.0


@dataclass(frozen=True, eq=False)
class TagScene:
    """Markers of one family that hang still.

    Args:
        camera: a pinhole.
        family: of all markers.
        marker_ids: ``(M,)``.
        side_m: of all of them.
        world_T_marker: Motor ``(M,)``, frames at the printed top-left corners.
        blur_px: standard deviation of the lens's blur.
        noise: standard deviation of the pixels' noise, grey levels.
    """

    camera: Camera
    family: str
    marker_ids: IntArray
    side_m: float
    world_T_marker: Motor
    blur_px: float = 0.7
    noise: float = 3.0

    def image(self, world_T_camera: Motor, rng: np.random.Generator) -> GrayImage:
        """What the camera sees from a pose."""
        height, width = self.camera.height, self.camera.width
        fine: NDArray[np.float32] = np.full((height * _FINE, width * _FINE), _AROUND, np.float32)
        camera_T_marker = world_T_camera.inverse().reshape(1) @ self.world_T_marker
        order = np.argsort(-camera_T_marker.translation_m[:, 2])
        for row in order:
            self._draw(fine, camera_T_marker[row], int(self.marker_ids[row]))
        small = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
        if self.blur_px > 0.0:
            small = cv2.GaussianBlur(small, (0, 0), self.blur_px)
        noisy = small + self.noise * rng.standard_normal(small.shape)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8)

    def corners_px(self, world_T_camera: Motor) -> FloatArray:
        """Where the corners truly are, ``(M, 4, 2)``."""
        camera_T_marker = world_T_camera.inverse().reshape(1) @ self.world_T_marker
        return self.camera.project(camera_T_marker[:, None].apply(marker_points_m(self.side_m)))

    def _draw(self, fine: NDArray[np.float32], camera_T_marker: Motor, marker_id: int) -> None:
        cells = np.pad(marker_cells(self.family, marker_id), 1, constant_values=True)
        levels = np.where(cells, _WHITE, _BLACK).astype(np.float32)
        print_ = np.kron(levels, np.ones((_CELL_PX, _CELL_PX), np.float32))
        shape = layout(self.family)
        # Metres of the print's pixel centres, the margin left of and above the marker's corner.
        step = self.side_m / (shape.side_cells * _CELL_PX)
        first = (0.5 - (1 + shape.margin) * _CELL_PX) * step
        to_marker = np.array([[step, 0.0, first], [0.0, -step, -first], [0.0, 0.0, 1.0]])
        view = camera_T_marker.as_matrix()[:3][:, [0, 1, 3]]
        finer = np.array(
            [[_FINE, 0, 0.5 * (_FINE - 1)], [0, _FINE, 0.5 * (_FINE - 1)], [0, 0, 1.0]]
        )
        homography = finer @ np.array(self.camera.matrix) @ view @ to_marker
        size = (fine.shape[1], fine.shape[0])
        drawn = cv2.warpPerspective(print_, homography, size, flags=cv2.INTER_LINEAR)
        whole = np.ones_like(print_)
        inside = cv2.warpPerspective(whole, homography, size, flags=cv2.INTER_NEAREST) > 0.5
        fine[inside] = drawn[inside]


def wall_of_markers(
    columns: int, rows: int, pitch_m: float, tilt_deg: float, rng: np.random.Generator
) -> Motor:
    """Markers near the plane z = 0 in a grid about the origin, each tilted its own way."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    places = np.stack([x.ravel() - 0.5 * columns + 0.2, 0.5 * rows - y.ravel() - 0.2], axis=-1)
    places = np.pad(pitch_m * places, ((0, 0), (0, 1)))
    tilt = np.radians(tilt_deg) * rng.uniform(-1.0, 1.0, (columns * rows, 3))
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(tilt), places)


def handheld_path(frames: int, distance_m: float) -> Motor:
    """``world_T_camera`` ``(frames,)``: a slow sway before the origin, which it looks at."""
    phase = np.linspace(0.0, 0.12 * frames, frames)
    centre = distance_m * np.stack(
        [
            0.45 * np.sin(phase),
            0.3 * np.sin(1.31 * phase + 1.0),
            1.0 + 0.15 * np.sin(0.7 * phase),
        ],
        axis=-1,
    )
    ahead = -centre / np.linalg.norm(centre, axis=-1, keepdims=True)
    right = np.cross(ahead, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    axes = np.stack([right, np.cross(ahead, right), ahead], axis=-1)
    return Motor.from_rotor_translation(Rotor.from_matrix(axes), centre)
