"""A figure on a ground that moves, against the same figure placed anew for every frame."""

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Performer, Sun, render_performers
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
TIME_NS = np.array([0, 100_000_000, 200_000_000])
FIGURE = mannequin()
PLACEMENT = place_on_plane(FIGURE, (0.1, 0.0), 0.4, height_m=1.0)
FRAME: ImageArray = np.full((120, 160, 3), 200, dtype=np.uint8)


def cameras() -> Trajectory:
    upright = Rotor.from_rotation_vector([-1.5708 - 0.3, 0.0, 0.0])
    eyes = np.array([[-0.1, -2.5, 1.4], [0.0, -2.5, 1.4], [0.1, -2.5, 1.4]])
    return Trajectory(TIME_NS, Motor.from_rotor_translation(Rotor.identity((3,)) @ upright, eyes))


def moved(turns: FloatArray) -> Trajectory:
    """Shifted and turned about the vertical and a little out of it, more from frame to frame."""
    shifts = np.arange(3)[:, None] * np.array([0.1, 0.05, -0.05])
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turns), shifts)
    return Trajectory(TIME_NS, poses, "world", "start")


def sun(direction: tuple[float, float, float], share: float = 1.0) -> Lighting:
    return Lighting((0.4, 0.4, 0.4), Sun(direction, 2.0 * share), (), (0.1, 0.0, 0.5), 0.75)


def drawn(
    lighting: Lighting, ground_motion: Trajectory | None, only: int | None = None
) -> list[ImageArray]:
    """All frames; or one of them, with the figure and its light placed where the carry has it."""
    placement, light = PLACEMENT, lighting
    rows = range(3) if only is None else [only]
    if only is not None and ground_motion is not None:
        pose = ground_motion.motors[only] @ PLACEMENT.world_T_character
        placement = replace(PLACEMENT, world_T_character=pose)
        middle = ground_motion.motors[only].apply(np.array(lighting.shadow_center_m)).tolist()
        light, ground_motion = replace(lighting, shadow_center_m=tuple(middle)), None
    frames = [(0, FRAME)] + [(int(TIME_NS[k]), FRAME) for k in rows if k]
    made = list(
        render_performers(
            frames,
            CAMERA,
            cameras(),
            [Performer(FIGURE, FIGURE.clip("idle"), placement, ground_motion=ground_motion)],
            lighting=light,
        )
    )
    return made if only is None else made[-1:]


@pytest.mark.parametrize("direction", [(0.4, 0.5, -1.0), (-1.0, 0.2, -0.7)])
def test_light_stays_in_the_world_while_the_ground_moves(
    direction: tuple[float, float, float],
) -> None:
    ground_motion = moved(np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.7], [0.1, -0.1, 1.5]]))
    carried = drawn(sun(direction), ground_motion)
    for k in range(3):
        anew = drawn(sun(direction), ground_motion, only=k)[0]
        apart = np.abs(carried[k].astype(int) - anew)
        changed = np.any(anew != FRAME, axis=2)
        assert np.count_nonzero(changed) > 600
        assert apart[changed].mean() < 0.5
        assert np.quantile(apart[changed], 0.99) < 12


def test_a_ground_that_turns_away_from_the_sun_has_no_shadow_but_is_drawn() -> None:
    ground_motion = moved(np.array([[0.0, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 2.0, 0.0]]))
    carried = drawn(sun((1.0, 0.0, -0.4)), ground_motion)
    assert all(np.any(one != FRAME) for one in carried)
    with pytest.raises(ValueError, match="light from above"):
        drawn(sun((1.0, 0.0, 0.4)), None)
