"""A lens that zooms within a clip is named by the focal lengths of its parts, and no other is."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, Checkerboard, self_calibrate_board
from motorcade.tracking.boards import BoardCorners

SIZE, FRAMES = (640, 480), 50
BOARD = Checkerboard(7, 5, 1.0)


def clip(seed: int, ratio: float, noise_px: float = 0.15) -> list[BoardCorners | None]:
    """A board held before a camera whose focal length grows by this ratio, frame by frame."""
    rng = np.random.default_rng(seed)
    first, phases = rng.uniform(420.0, 700.0), rng.uniform(0.0, 6.0, 3)
    face_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    views: list[BoardCorners | None] = []
    for frame in range(FRAMES):
        focal, step = first * ratio ** (frame / (FRAMES - 1)), 0.35 * frame
        camera = Camera(*SIZE, focal, focal, 319.5, 239.5)
        sway = 0.45 * np.sin([step + phases[0], 0.8 * step + phases[1], 0.5 * step + phases[2]])
        turn = Rotor.from_rotation_vector(sway) @ face_down
        middle = turn.apply(BOARD.points_m.mean(axis=0))
        away = 0.02 * focal * (1.0 + 0.2 * np.sin(0.6 * step))
        pose = Motor.from_rotor_translation(turn, [0.0, 0.0, away] - middle)
        px = camera.project(pose.apply(BOARD.points_m))
        noisy = px + noise_px * rng.standard_normal(px.shape)
        views.append(BoardCorners(np.arange(len(px)), noisy, BOARD.points_m))
    return views


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "ratio"), [(1, 2.0), (2, 0.5)])
def test_a_zoom_is_named_and_its_camera_unsure(seed: int, ratio: float) -> None:
    found = self_calibrate_board(clip(seed, ratio), SIZE, 33_000_000 * np.arange(FRAMES))
    assert found.doubts[0].startswith("the focal length changes by ")
    assert "within the shot" in found.doubts[0]
    assert found.sigma_focal > 0.15


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_one_focal_length_is_no_zoom(seed: int) -> None:
    found = self_calibrate_board(clip(seed, 1.0), SIZE, 33_000_000 * np.arange(FRAMES))
    assert not any("within the shot" in doubt for doubt in found.doubts)
    assert found.sigma_focal < 0.02
