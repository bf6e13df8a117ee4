"""The film's own account of its figures equals a count on its pixels, and names planted faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Clip, mannequin, place_on_plane
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import Performer, render_performers
from motorcade.render.composite import Matching
from motorcade.render.figures import FigureSeen
from motorcade.replays.stages.view.overlay import check_figure
from motorcade.tracking.cameras.camera import Camera
from tests.end_to_end.film_account import draw_account

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(480, 320, 300.0, 300.0, 239.5, 159.5)
FRAME = np.full((320, 480, 3), 255, dtype=np.uint8)
FRAME[...] = (255, 0, 255)  # no colour of the figure, nor of its shadow


@pytest.fixture(scope="module")
def who() -> Character:
    return mannequin()


def standing(who: Character, at_m: tuple[float, float], clip: Clip | None = None) -> Performer:
    return Performer(who, clip or who.clip("idle"), place_on_plane(who, at_m, -1.57, height_m=1.0))


def seen(*figures: Performer, depth_m: np.ndarray | None = None) -> tuple[np.ndarray, tuple]:
    upright = Rotor.from_rotation_vector([-1.5708 - 0.3, 0.0, 0.0])
    eye = Motor.from_rotor_translation(upright, np.array([0.0, -2.5, 1.4]))
    path = Trajectory(np.array([0, 10**9]), Motor.stack([eye, eye]))
    visibility: list[tuple[FigureSeen, ...] | None] = []
    frame = (0, FRAME) if depth_m is None else (0, FRAME, depth_m)
    image = next(
        render_performers(
            [frame],
            CAMERA,
            path,
            figures,
            light_direction=(-0.4, 0.3, -1.0),
            matching=Matching(1.0, 0.0, 0.0),
            visibility=visibility,
        )
    )
    (shown,) = visibility
    assert shown is not None
    return image, shown


def drawn_px(image: np.ndarray) -> float:
    """Pixels with some green are the figure's: the frame and its shadow have none."""
    return float(np.count_nonzero(image[..., 1] > 8))


def test_visible_pixels_are_those_of_the_image(who):
    image, (figure,) = seen(standing(who, (0.1, 0.0)))
    assert figure.visible_px == pytest.approx(drawn_px(image), rel=0.06)  # rims are parts
    assert abs(figure.hidden) < 1e-9
    assert figure.inside == 1.0
    rows = np.flatnonzero(np.any(image[..., 1] > 8, axis=1))
    assert figure.height_px == pytest.approx(np.ptp(rows) + 1, abs=4.0)
    assert abs(figure.bottom) < 0.01


def test_what_is_nearer_hides_that_share(who):
    whole = seen(standing(who, (0.0, 0.0)))[1][0]
    depth_m = np.full(FRAME.shape[:2], 9.0, np.float32)
    depth_m[:, :240] = 0.5
    image, (figure,) = seen(standing(who, (0.0, 0.0)), depth_m=depth_m)
    assert figure.drawn_px == pytest.approx(whole.drawn_px)
    assert figure.visible_px == pytest.approx(drawn_px(image), rel=0.12)
    assert 0.3 < figure.hidden < 0.7


def test_the_farther_of_two_is_hidden_by_the_nearer(who):
    near, far = standing(who, (0.0, -0.8)), standing(who, (0.05, 0.6))
    for figures in ((near, far), (far, near)):
        _, shown = seen(*figures)
        first, second = shown if figures[0] is near else shown[::-1]
        assert first.hidden < 0.05
        assert second.hidden > 0.5


def _account(who: Character, clip: Clip, motion: Trajectory | None = None):
    performer = replace(standing(who, (0.0, 0.0), clip), motion=motion)
    shown = seen(performer)[1][0]
    time_ns = np.arange(0, 3 * 10**9, 10**8)
    return check_figure("who", performer, [shown] * len(time_ns), time_ns)


def test_planted_faults_are_named(who):
    idle, walk = who.clip("idle"), who.clip("walk")
    assert _account(who, idle).doubts(CAMERA.height) == ()

    def moved(clip: Clip, by: Motor) -> Clip:
        return replace(clip, poses=who.skeleton.moved(clip.poses, by), looped=False)

    tall = who.height_m
    sunk = _account(who, moved(idle, Motor.from_translation([0.0, 0.0, -0.2 * tall])))
    hovering = _account(who, moved(idle, Motor.from_translation([0.0, 0.0, 0.2 * tall])))
    assert any("below its ground" in doubt for doubt in sunk.doubts(CAMERA.height))
    assert any("hovers 20%" in doubt for doubt in hovering.doubts(CAMERA.height))
    time_s = np.linspace(0.0, 3.0, 180)
    for turn_rad, astray in ((0.0, False), (np.pi, True)):
        way = Motor.from_rotor_translation(
            turn_z(np.full(len(time_s), turn_rad)), time_s[:, None] * [0.8, 0.0, 0.0]
        )
        clip = Clip("on", time_s, who.skeleton.moved(walk.at(time_s).rigid, way))
        doubts = _account(who, clip).doubts(CAMERA.height)
        assert any("faces 1" in doubt for doubt in doubts) == astray
    sliding = _account(who, moved(idle, Motor.identity()))
    assert sliding.slide < 0.01
    way = Motor.from_translation(time_s[:, None] * [0.3, 0.0, 0.0])
    dragged = Clip("dragged", time_s, who.skeleton.moved(idle.at(time_s).rigid, way))
    assert any("slides" in doubt for doubt in _account(who, dragged).doubts(CAMERA.height))


def test_one_behind_the_camera_or_far_is_named(who):
    behind, far = standing(who, (0.0, -9.0)), standing(who, (0.0, 60.0))
    time_ns = np.arange(0, 10**9, 10**8)
    for performer, words in ((behind, "is seen in 0 of 10"), (far, "pixels high")):
        shown = seen(performer)[1][0]
        account = check_figure("who", performer, [shown] * len(time_ns), time_ns)
        assert any(words in doubt for doubt in account.doubts(CAMERA.height))


@pytest.mark.slow
@pytest.mark.parametrize("hidden_by", ["nothing", "wall"])
def test_of_two_that_stand_before_one_another_each_pixel_is_counted_once(hidden_by: str) -> None:
    rng = np.random.default_rng(9)
    for account in draw_account(rng, 2, hidden_by):
        assert account.off == []
