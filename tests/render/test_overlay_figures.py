"""Several figures in one image, against each of them drawn alone."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from motorcade.animation import Character, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import Performer, render_performers
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(240, 120, 150.0, 150.0, 119.5, 59.5)
FRAME: ImageArray = np.full((120, 240, 3), 120, dtype=np.uint8)


@pytest.fixture(scope="module")
def who() -> Character:
    return mannequin()


def figure(who: Character, at_m: tuple[float, float]) -> Performer:
    return Performer(who, who.clip("idle"), place_on_plane(who, at_m, -1.57, height_m=1.0))


def drawn(first: Performer, *others: Performer) -> ImageArray:
    upright = Rotor.from_rotation_vector([-1.5708 - 0.3, 0.0, 0.0])
    eye = Motor.from_rotor_translation(upright, np.array([0.0, -2.5, 1.4]))
    path = Trajectory(np.array([0, 10**9]), Motor.stack([eye, eye]))
    made = render_performers(
        [(0, FRAME)], CAMERA, path, [first, *others], light_direction=(-0.4, 0.3, -1.0)
    )
    return next(made)


def differs(one: ImageArray, other: ImageArray) -> NDArray[np.bool_]:
    return np.asarray(np.abs(one.astype(int) - other).max(axis=-1) > 3)


def test_figures_apart_are_both_drawn_where_each_is_alone(who):
    left, right = figure(who, (-1.0, 0.0)), figure(who, (1.0, 0.0))
    both = drawn(left, right)
    for one, half in ((left, np.s_[:, :120]), (right, np.s_[:, 120:])):
        changed = differs(drawn(one)[half], FRAME[half])
        of_both = differs(both[half], FRAME[half])
        assert changed.sum() > 400
        agreed = np.count_nonzero(changed & of_both) / np.count_nonzero(changed | of_both)
        # The lamps stand about the middle of all, and some of a figure is as grey as the frame.
        assert agreed > 0.9


def test_the_nearer_figure_hides_the_farther_whichever_comes_first(who):
    near, far = figure(who, (0.0, -0.8)), figure(who, (0.05, 0.6))
    near_alone = drawn(near).astype(int)
    for both in (drawn(near, far), drawn(far, near)):
        body = np.s_[65:90, 116:124]  # the middle of the nearer figure
        assert np.abs(both[body].astype(int) - near_alone[body]).mean() < 12.0


def test_shadows_that_overlap_do_not_darken_twice(who):
    one = figure(who, (0.0, 0.0))
    alone, twice = drawn(one).astype(int), drawn(one, one).astype(int)
    shadow = np.all(alone < 100, axis=-1) & np.all(alone == alone[..., :1], axis=-1)
    shadow = binary_erosion(shadow)  # without the rim of the figure, which may be grey too
    assert shadow.sum() > 30
    assert np.abs(twice - alone)[shadow].max() <= 6  # a second shadow would take tens
