"""Depth registered to colour: what one camera measured is what the other would have."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.depth import DepthCamera, register_depth
from motorcade.tracking.depth.cameras import edge_offset
from tests.textured_room.renderer import Renderer, Sensor, View
from tests.textured_room.scenarios import scenario
from tests.textured_room.scene import furnished_room

COLOUR = Camera(320, 240, 262.0, 262.0, 159.5, 119.5)
DEPTH = Camera(320, 240, 292.0, 292.0, 161.0, 118.0)
COLOUR_T_DEPTH = Motor.from_twist([0.004, -0.008, 0.003, -0.026, 0.001, 0.003])
TAKEN_BY = DepthCamera(DEPTH, COLOUR_T_DEPTH)


@functools.cache
def renderers() -> tuple[Renderer, Renderer]:
    """One furnished room, for the colour camera and for the depth camera."""
    room = furnished_room(np.random.default_rng(0))
    return Renderer(room, Sensor(COLOUR)), Renderer(room, Sensor(DEPTH))


@functools.cache
def seen(number: int) -> tuple[View, View]:
    """What both cameras see from where the handheld one is."""
    pose = scenario("handheld").truth().motors[number]
    colour, depth = renderers()
    rng = np.random.default_rng(number)
    return colour.view(pose, rng), depth.view(pose @ COLOUR_T_DEPTH, rng)


@pytest.mark.parametrize("number", [0, 60, 120])
def test_it_is_what_the_colour_camera_would_measure(number: int) -> None:
    colour, depth = seen(number)
    registered = register_depth(depth.depth_m, TAKEN_BY, COLOUR)
    known = np.isfinite(registered)
    assert known[20:-20, 20:-20].mean() > 0.97
    apart = np.abs(registered - colour.depth_m)[known]
    # A pixel's rounding on slopes; at edges of surfaces another surface, for a few in a hundred.
    assert np.median(apart) < 0.004
    assert np.mean(apart > 0.1) < 0.02


def test_what_is_nearer_hides_what_is_behind_it() -> None:
    """A board before a wall: where both fall on one pixel, the board is seen."""
    depth = np.full((240, 320), 4.0, np.float32)
    depth[80:160, 100:200] = 1.0
    taken_by = DepthCamera(COLOUR, Motor.from_translation([-0.1, 0.0, 0.0]))
    registered = register_depth(depth, taken_by, COLOUR)
    shift_px = 262.0 * 0.1
    left, right = round(100 - shift_px), round(199 - shift_px)
    assert np.all(registered[90:150, left + 1 : right] == 1.0)
    # The wall moved by a quarter of that: to the right of the board lies what it had hidden.
    assert np.isnan(registered[90:150, right + 2 : round(200 - shift_px / 4) - 1]).all()


def test_a_depth_image_of_half_the_size_leaves_no_gaps() -> None:
    small = Camera(160, 120, 131.0, 131.0, 79.5, 59.5)
    registered = register_depth(np.full((120, 160), 2.0, np.float32), DepthCamera(small), COLOUR)
    assert np.all(registered[4:-4, 4:-4] == 2.0)


def test_a_depth_image_of_a_sixteenth_of_the_size_leaves_no_gaps() -> None:
    tiny = Camera(20, 15, 16.375, 16.375, 9.5, 7.0)
    registered = register_depth(np.full((15, 20), 2.0, np.float32), DepthCamera(tiny), COLOUR)
    assert np.all(registered[8:-8, 8:-8] == 2.0)


def test_colour_too_fine_for_its_depth_is_refused() -> None:
    tiny = Camera(4, 3, 4.0, 4.0, 1.5, 1.0)
    with pytest.raises(ValueError, match="colour: expected at most 64 times"):
        register_depth(np.full((3, 4), 2.0, np.float32), DepthCamera(tiny), COLOUR)


@pytest.mark.parametrize("size", [(40, 15), (20, 30)])
def test_pixels_of_a_sensor_that_are_not_square_leave_no_gaps(size: tuple[int, int]) -> None:
    width, height = size
    right, down = width / 320, height / 240
    middle = 160.0 * right - 0.5, 120.0 * down - 0.5
    sensor = Camera(width, height, COLOUR.fx * right, COLOUR.fy * down, *middle)
    wall = np.full((height, width), 2.0, np.float32)
    registered = register_depth(wall, DepthCamera(sensor), COLOUR)
    assert np.mean(registered == 2.0) > 0.99


def test_unknown_depth_stays_unknown_and_other_sizes_are_refused() -> None:
    nothing = np.full((240, 320), np.nan, np.float32)
    nothing[3, 4], nothing[5, 6] = 0.0, -1.0
    assert np.isnan(register_depth(nothing, TAKEN_BY, COLOUR)).all()
    with pytest.raises(ValueError, match=r"expected shape \(240, 320\), got \(10, 10\)"):
        register_depth(np.ones((10, 10), np.float32), TAKEN_BY, COLOUR)


def cluttered(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """An image of boards that hang before each other, and its depth."""
    rng = np.random.default_rng(seed)
    gray = rng.normal(120.0, 4.0, (240, 320))
    depth = np.full((240, 320), 6.0, np.float32)
    for ahead in np.sort(rng.uniform(1.0, 5.0, 12))[::-1]:
        top, left = rng.integers(0, 200), rng.integers(0, 280)
        high, wide = rng.integers(30, 90), rng.integers(30, 90)
        depth[top : top + high, left : left + wide] = ahead
        gray[top : top + high, left : left + wide] += rng.uniform(-80.0, 80.0)
    return np.clip(gray, 0.0, 255.0).astype(np.uint8), depth


@pytest.mark.parametrize("shift", [(0, 0), (7, 0), (-4, 9)])
def test_edges_tell_how_far_depth_lies_off(shift: tuple[int, int]) -> None:
    right, down = shift
    grays, depths = zip(*(cluttered(seed) for seed in range(5)), strict=True)
    moved = [np.roll(depth, (-down, -right), axis=(0, 1)) for depth in depths]
    found = edge_offset(grays, moved)
    assert found.right_px == pytest.approx(right, abs=0.8)
    assert found.down_px == pytest.approx(down, abs=0.8)


def test_other_edges_that_fit_hardly_better_are_not_preferred() -> None:
    """A print that repeats what hangs there, a little more in contrast."""
    grays, depths = zip(*(cluttered(seed) for seed in range(5)), strict=True)
    both = [
        np.clip(120.0 + 0.5 * (gray - 120.0) + 0.51 * np.roll(gray - 120.0, 12, 0), 0, 255)
        for gray in map(np.float64, grays)
    ]
    found = edge_offset([gray.astype(np.uint8) for gray in both], depths)
    assert found.px < 1.5


def test_an_image_without_edges_tells_nothing() -> None:
    flat = np.full((240, 320), 90, np.uint8)
    found = edge_offset([flat], [np.full((240, 320), 2.0, np.float32)])
    assert np.isnan(found.px)


def test_opposite_sides_of_a_depth_image_make_no_edges() -> None:
    """A floor that rises gently from the bottom to the top, and a wall that turns away."""
    gray = np.full((240, 320), 90, np.uint8)
    down, right = np.linspace(1.0, 3.0, 240), np.linspace(1.0, 3.0, 320)
    for depth in (np.tile(right, (240, 1)), np.tile(down[:, None], (1, 320))):
        assert edge_offset([gray], [depth.astype(np.float32)]).pixels == 0
