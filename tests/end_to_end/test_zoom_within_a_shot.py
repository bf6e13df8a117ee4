"""Clips without a manifest whose lens zooms by two within the shot: focal length and registration.

A checkerboard on a textured floor is drawn by homographies. Figures of all kinds are printed by
``pytest -m slow -s`` on this file.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render import write_video
from motorcade.replays import open_recording
from motorcade.replays.pipeline.described.describing import open_described
from motorcade.replays.stages.camera.board_poses import board_poses
from tests.tracking.self_calibration.test_zooming import PROFILES

SIZE, FRAMES, SQUARES = (640, 480), 90, (8, 6)
STAMPS = np.arange(FRAMES) * 33_333_333


def _floor(rng: np.random.Generator, px: int = 60) -> np.ndarray:
    """A floor with a print of `px` a square in its middle, its squares' corner in the centre."""
    wide, high = (px * count for count in SQUARES)
    paper = np.full((high + 2 * px, wide + 2 * px), 245, np.uint8)
    rows, columns = np.indices((high, wide)) // px
    paper[px:-px, px:-px] = np.where((rows + columns) % 2 == 0, 15, 245)
    floor = cv2.resize(rng.integers(60, 200, (160, 160), np.uint8), (2400, 2400))
    top, left = (1200 - side // 2 for side in paper.shape)
    floor[top : top + paper.shape[0], left : left + paper.shape[1]] = paper
    return np.asarray(floor)


def _clip(path: Path, seed: int, profile: str) -> tuple[FloatArray, Motor]:
    """Draw a clip; its focal lengths, and ``camera_T_print`` in squares, y up as printed."""
    rng = np.random.default_rng(seed)
    first, phases, floor = rng.uniform(480.0, 640.0), rng.uniform(0.0, 6.0, 3), _floor(rng)
    focals = first * 2.0 ** PROFILES[profile](np.linspace(0.0, 1.0, FRAMES))
    steps = 0.1 * np.arange(FRAMES)
    sway = 0.4 * np.sin(steps[:, None] * [1.0, 0.8, 0.5] + phases)
    turn = Rotor.from_rotation_vector(sway) @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    away = 0.032 * first * (1.0 + 0.15 * np.sin(0.6 * steps))
    poses = Motor.from_rotor_translation(turn, away[:, None] * [0.0, 0.0, 1.0])
    plane_T_px = np.array([[1 / 60, 0, -1199.5 / 60], [0, -1 / 60, 1199.5 / 60], [0, 0, 1.0]])

    def images() -> Iterator[np.ndarray]:
        for focal, pose in zip(focals, poses.as_matrix(), strict=True):
            lens = np.array(
                [[2 * focal, 0, SIZE[0] - 0.5], [0, 2 * focal, SIZE[1] - 0.5], [0, 0, 1]]
            )
            shown = lens @ pose[:3][:, [0, 1, 3]] @ plane_T_px
            fine = cv2.warpPerspective(floor, shown, (2 * SIZE[0], 2 * SIZE[1]), borderValue=(160,))
            small = cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA)
            noisy = small + rng.normal(0.0, 2.0, small.shape)
            yield np.repeat(np.clip(noisy, 0, 255).astype(np.uint8)[..., None], 3, axis=-1)

    write_video(path, images(), STAMPS)
    return focals, poses


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "profile"), [(51, "eased"), (52, "out"), (53, "in and out")])
def test_a_zoom_of_two_is_followed_and_poses_register(
    seed: int, profile: str, tmp_path: Path
) -> None:
    focals, camera_T_print = _clip(tmp_path / "clip.mp4", seed, profile)
    opened = open_described(open_recording(tmp_path / "clip.mp4"), None, tmp_path / "cache", {})
    recording = opened.recording
    assert recording.camera is not None
    ratio = np.array([frame.zoom for frame in recording.frames])
    followed = ratio * recording.camera.fx
    assert np.abs(followed / focals - 1.0).max() < 0.02
    path = board_poses(recording).measurements.trajectory
    rows = np.searchsorted(path.time_ns, recording.frames.time_ns)
    assert len(path) == FRAMES
    board = recording.board
    assert board is not None
    points = board.points_m - board.points_m.mean(axis=0)
    shown = path.motors[rows].inverse()[:, None].apply(board.points_m)
    px = followed[:, None, None] * shown[..., :2] / shown[..., 2:]
    px += [recording.camera.cx, recording.camera.cy]
    errors = []
    for half_turn in (1.0, -1.0):  # a board of 8 by 6 squares looks the same upside down
        true = camera_T_print[:, None].apply(points * [half_turn, half_turn, 1.0])
        there = focals[:, None, None] * true[..., :2] / true[..., 2:] + [319.5, 239.5]
        errors.append(np.sqrt(((px - there) ** 2).sum(axis=-1).mean(axis=-1)))
    worst = min(float(error.max()) for error in errors)
    focal = float(np.abs(followed / focals - 1.0).max())
    print(f"{profile}: focal length to {focal:.2%}, registration {worst:.3f} px")
    assert worst < 0.5
