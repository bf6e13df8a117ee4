"""Before a camera that stays at its place a figure is seen whole, a fifth of the image high."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.stages.values.camera_poses import HELD_HEIGHT
from motorcade.replays.stages.view.anchored import level_ground
from motorcade.tracking.cameras.camera import Camera

LEVEL = Motor.from_rotor_translation(
    Rotor.from_matrix([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), [0.0, 0.0, HELD_HEIGHT]
)


@pytest.mark.parametrize("size", [(640, 480), (1920, 1080), (576, 1024)])
@pytest.mark.parametrize("sees_deg", [48.0, 64.0, 83.0])
def test_the_figure_is_a_fifth_of_the_image_and_within_it(
    rng: np.random.Generator, size: tuple[int, int], sees_deg: float
) -> None:
    focal_px = 0.5 * max(size) / np.tan(np.deg2rad(0.5 * sees_deg))
    camera = Camera(*size, focal_px, focal_px, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1))
    turns = Rotor.from_rotation_vector(0.01 * rng.standard_normal((5, 3)))
    turns = Motor.from_rotor_translation(turns, np.zeros(3))
    path = Trajectory(40_000_000 * np.arange(5), LEVEL @ turns, "world", "camera")
    ground = level_ground(camera, path, 0.0)
    place = ground.world_T_plane.apply([*ground.position_m, 0.0])
    ends = place + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, ground.height_m]])
    pixels = camera.project(path.motors.inverse()[:, None].apply(ends))
    high = (pixels[:, 0, 1] - pixels[:, 1, 1]) / size[1]
    np.testing.assert_allclose(high, 0.2, atol=0.03)
    assert np.all((pixels > 0.0) & (pixels < size))
