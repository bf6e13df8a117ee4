"""What stands before something, by other views: against drawn panels and against measured depth."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.replays import open_recording
from motorcade.tracking import Camera
from motorcade.tracking.depth.sweep import MOST_VIEWS, Nearer, SceneViews

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
FAR_M, PANEL_M, BETWEEN_M = 4.0, 2.0, 3.0
# A floor 1.2 m below the camera: OpenCV's axes, y down.
GROUND = Motor.from_translation([0.0, 1.2, 0.0]) @ Motor.from_twist([np.pi / 2, 0, 0, 0, 0, 0])
NO_GROUND = Motor.from_translation([0.0, 0.0, -99.0])
FACTOR = 400.0  # texels a metre


@cache
def _texture(seed: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(seed).normal(128.0, 60.0, (2000, 3000))
    return np.clip(12.0 * (cv2.GaussianBlur(noise, (0, 0), 5.0) - 128.0) + 128.0, 0, 255).astype(
        np.uint8
    )


def _looked_up(texture: NDArray[np.uint8], x_m: NDArray, y_m: NDArray) -> NDArray[np.uint8]:
    at = (FACTOR * np.stack([x_m, y_m], -1) + [1500, 1000]).astype(np.float32)
    return cv2.remap(texture, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)


def _drawn(eye_x_m: float, panel: bool) -> NDArray[np.uint8]:
    """A wall 4 m away and, if asked for, a panel half as far that ends at x = 0."""
    columns, rows = np.meshgrid(np.arange(320), np.arange(240))
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    wall = _looked_up(_texture(1), FAR_M * x + eye_x_m, FAR_M * y)
    before = _looked_up(_texture(2), PANEL_M * x + eye_x_m, PANEL_M * y)
    return np.where(panel & (PANEL_M * x + eye_x_m < 0.0), before, wall).astype(np.uint8)


def _views(panel: bool, reach_m: float) -> SceneViews:
    eyes = np.linspace(-reach_m, reach_m, 9)
    at = Motor.from_translation(np.stack([eyes, 0 * eyes, 0 * eyes], axis=1))
    return SceneViews(CAMERA, [_drawn(x, panel) for x in eyes], at, np.arange(9))


def _hull(depth_m: float) -> NDArray[np.float64]:
    return np.array(
        [[x, y, depth_m + z] for x in (-0.6, 0.6) for y in (-0.6, 0.6) for z in (0.0, 0.1)]
    )


def _asked(views: SceneViews, panel: bool, depth_m: float = BETWEEN_M) -> Nearer | None:
    here = Motor.from_translation([0.0, 0.0, 0.0])
    return views.nearer(_drawn(0.0, panel), here, _hull(depth_m), GROUND)


def test_a_panel_before_the_hull_is_nearer_and_the_wall_behind_is_not() -> None:
    nearer = _asked(_views(panel=True, reach_m=0.6), panel=True)
    assert nearer is not None
    columns = (np.arange(nearer.share.shape[1]) + nearer.first_px[0] + 0.5) / nearer.scale - 0.5
    left, right = columns < CAMERA.cx - 4, columns > CAMERA.cx + 4
    assert np.mean(nearer.share[:, left] > 0.0) > 0.97
    assert np.mean(nearer.share[:, right] < 0.0) > 0.97
    assert nearer.depth_m == pytest.approx(PANEL_M, rel=0.03)


def test_nothing_is_nearer_than_what_stands_before_all() -> None:
    assert _asked(_views(panel=True, reach_m=0.6), panel=True, depth_m=1.7) is None
    assert _asked(_views(panel=False, reach_m=0.6), panel=False) is None


def test_views_from_one_place_tell_nothing() -> None:
    assert _asked(_views(panel=True, reach_m=0.02), panel=True) is None


def test_the_ground_before_something_does_not_hide_it() -> None:
    rows = np.arange(240)[:, None] - CAMERA.cy
    depth_m = np.where(rows > 0, 1.2 * CAMERA.fy / np.maximum(rows, 1e-9), np.inf)
    depth_m = np.broadcast_to(np.minimum(depth_m, 8.0), (240, 320))
    x = (np.arange(320) - CAMERA.cx) / CAMERA.fx * depth_m

    def floor(eye_x_m: float) -> NDArray[np.uint8]:
        along = np.where(depth_m < 8.0, depth_m - 4.0, 1.2 + rows / CAMERA.fy)
        return _looked_up(_texture(3), 0.5 * (x + eye_x_m), 0.5 * along)

    eyes = np.linspace(-0.6, 0.6, 9)
    at = Motor.from_translation(np.stack([eyes, 0 * eyes, 0 * eyes], axis=1))
    views = SceneViews(CAMERA, [floor(x) for x in eyes], at, np.arange(9))
    # It stands 5 m away, and reaches as far down in the image as the floor 3 m away.
    hull = _hull(5.0) + np.array([0.0, 1.4, 0.0])
    assert views.nearer(floor(0.0), Motor.from_translation([0, 0, 0]), hull, GROUND) is None
    beneath = Motor.from_translation([0.0, 5.0, 0.0]) @ GROUND
    assert views.nearer(floor(0.0), Motor.from_translation([0, 0, 0]), hull, beneath) is not None


@pytest.mark.parametrize(
    ("name", "rows"), [("7scenes_redkitchen", (10, 40)), ("7scenes_redkitchen_200", (40, 100))]
)
def test_what_views_call_nearer_is_nearer_in_measured_depth(
    name: str, rows: tuple[int, ...], data_dir: Path
) -> None:
    """The depth camera stands 25 mm beside: edges are some pixels off, of flat things too."""
    recording = open_recording(data_dir / "replays" / name)
    frames, path = recording.frames, recording.truth
    assert path is not None
    colour = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
    kept = np.unique(np.linspace(0, len(frames) - 1, MOST_VIEWS).round().astype(int))
    images = [frames[int(k)].gray() for k in kept]
    views = SceneViews(colour, images, path.motors_at(frames.time_ns[kept]), kept)
    right = called = there = 0
    for k in rows:
        frame, pose = frames[k], path.motors_at(frames.time_ns[k])
        depth_m = frame.depth_m()
        assert depth_m is not None
        middle_m = float(np.nanmedian(depth_m))
        hull = np.array([[x, y, z] for x in (-0.4, 0.4) for y in (-0.5, 0.5) for z in (2.0, 2.1)])
        nearer = views.nearer(frame.gray(), pose, pose.apply(0.5 * middle_m * hull), NO_GROUND)
        assert nearer is not None
        sides = zip(nearer.share.shape, nearer.first_px[::-1], strict=True)
        y, x = ((np.arange(count) + first + 0.5) / nearer.scale for count, first in sides)
        measured = depth_m[np.ix_(y.astype(int), x.astype(int))]
        near, far, says = measured < 0.85 * middle_m, measured > middle_m, nearer.share > 0.0
        right += np.count_nonzero(says & near)
        called += np.count_nonzero(says & (near | far))
        there += np.count_nonzero(near)
    assert right > 0.85 * called
    assert right > 0.75 * there
