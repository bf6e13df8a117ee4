"""A small recording of a checkerboard, drawn through exact homographies, with its ground truth."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.trajectories import write_trajectory
from motorcade.tracking import Camera, Checkerboard

FRAMES = 24
CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
BOARD = Checkerboard(columns=7, rows=5, square_m=0.03)

MANIFEST = """
name = "small board"
settings = ["errors.align=none"]
[frames]
images = "*.png"
rate_hz = 20.0
[camera]
model = "pinhole"
fx = 300.0
fy = 300.0
cx = 159.5
cy = 119.5
[board]
type = "checkerboard"
columns = 7
rows = 5
square_m = 0.03
[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"
"""


def truth() -> Trajectory:
    """A camera that circles over the board, swaying."""
    phase = np.linspace(0.0, 2.0, FRAMES)
    middle = BOARD.points_m.mean(axis=0)
    looking_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    sway = np.stack([0.3 * np.sin(phase), 0.25 * np.cos(2 * phase), 0.4 * phase], axis=-1)
    rotor = looking_down @ Rotor.from_rotation_vector(sway)
    behind = -0.35 * rotor.apply(np.array([0.0, 0.0, 1.0]))
    stamps = np.round(np.arange(FRAMES) * 1e9 / 20.0).astype(np.int64)
    return Trajectory(stamps, Motor.from_rotor_translation(rotor, middle + behind))


def photograph(world_T_camera: Motor) -> np.ndarray:
    """What the camera sees: the drawing through its homography, supersampled."""
    scale, fine = 4000.0, 4
    drawing, origin = BOARD.draw(scale)
    to_board = np.array([[1, 0, -origin[0]], [0, -1, origin[1]], [0, 0, scale]]) / scale
    view = world_T_camera.inverse().as_matrix()[:3][:, [0, 1, 3]]
    finer = np.diag([fine, fine, 1.0]) + np.array([[0, 0, 1.5], [0, 0, 1.5], [0, 0, 0]])
    homography = finer @ CAMERA.matrix @ view @ to_board
    size = (CAMERA.width * fine, CAMERA.height * fine)
    large = cv2.warpPerspective(drawing, homography, size, flags=cv2.INTER_AREA, borderValue=150)
    return cv2.resize(large, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA)


def write_board(folder: Path) -> Path:
    """Write the recording into a new folder."""
    folder.mkdir()
    path = truth()
    for i in range(FRAMES):
        cv2.imwrite(str(folder / f"{i:03d}.png"), photograph(path.poses[i]))
    write_trajectory(path, folder / "truth.tum")
    (folder / "motorcade.toml").write_text(MANIFEST)
    return folder


@pytest.fixture(scope="session")
def board_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a recording that describes itself; tests must copy it before they change it."""
    return write_board(tmp_path_factory.mktemp("recordings") / "small_board")
