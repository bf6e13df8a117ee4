"""Tiny recordings with a smooth truth."""

from pathlib import Path

import cv2
import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.trajectories import write_trajectory

MANIFEST = """
[frames]
images = "images/*.png"
rate_hz = 20.0
[camera]
width = 24
height = 16
fx = 20.0
fy = 20.0
cx = 11.5
cy = 7.5
[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"
"""


def write_tiny(folder: Path, phase: float, count: int = 41) -> Path:
    """Forty small images along a smooth path."""
    (folder / "images").mkdir(parents=True)
    rng = np.random.default_rng(int(100 * phase))
    for index in range(count):
        image = rng.integers(0, 255, (16, 24), dtype=np.uint8)
        assert cv2.imwrite(str(folder / "images" / f"{index}.png"), image)
    t = np.arange(count) / 20.0
    turn = np.stack([0.3 * np.sin(2 * t + phase), 0.2 * np.cos(t), 0.4 * np.sin(t)], axis=-1)
    place = np.stack([np.sin(t), np.cos(1.5 * t + phase), 0.2 * t], axis=-1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)
    time_ns = np.rint(np.arange(count) * 5e7).astype(np.int64)
    write_trajectory(Trajectory(time_ns, poses), folder / "truth.tum")
    (folder / "motorcade.toml").write_text(MANIFEST)
    return folder
