"""Scenes that nobody meant to draw: they are drawn, or it is said that nothing is seen."""

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation.appearance import Appearance, Material, MaterialPart, TextureMap
from motorcade.ga import Motor
from motorcade.render import Layer, Lighting, Sun, Surface
from motorcade.render.backends.fast import FastRenderer
from motorcade.tracking.cameras.camera import Camera

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
LIGHT = Lighting((0.3, 0.3, 0.3), Sun((0.2, 0.1, 1.0), 3.0), (), (0.0, 0.0, 2.0), 2.0)
HERE = Motor.identity()


def square(depth_m: float, half_m: float = 0.3, **look: object) -> Surface:
    """A square that faces the camera, with a material."""
    uv = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    places = np.column_stack([(2.0 * uv - 1.0) * half_m, np.full(4, depth_m)])
    material = Material(metallic=0.0, **look)  # type: ignore[arg-type]
    paint = Appearance((MaterialPart(material, 0, 2),), uv[None].astype(np.float32))
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    return Surface(places, np.tile([0.0, 0.0, -1.0], (4, 1)), triangles, appearance=paint)


def plain(triangles: int, vertices: int, *, flat: bool = False) -> Appearance:
    """White paint without maps."""
    part = MaterialPart(Material(metallic=0.0), 0, triangles, flat)
    return Appearance((part,), np.zeros((0, vertices, 2), np.float32))


def drawn(*surfaces: Surface, pose: Motor = HERE) -> Layer:
    with FastRenderer(CAMERA.width, CAMERA.height) as renderer:
        renderer.show(surfaces, LIGHT)
        return renderer.render(CAMERA, pose)


def test_triangles_without_area_change_nothing() -> None:
    whole = square(2.0)
    thin = np.array([[0, 0, 0], [1, 1, 2], [0, 2, 0]])
    look = plain(5, 4)
    flat = replace(whole, triangles=np.concatenate([whole.triangles, thin]), appearance=look)
    seen, expected = drawn(flat), drawn(whole)
    np.testing.assert_array_equal(seen.rgba, expected.rgba)
    assert seen.rgba.any()


@pytest.mark.parametrize("flat", [False, True])
def test_normals_of_length_zero_give_light_and_no_holes(flat: bool) -> None:
    whole = square(2.0)
    look = plain(2, 4, flat=flat)
    seen = drawn(replace(whole, normals=np.zeros((4, 3)), appearance=look))
    np.testing.assert_array_equal(seen.rgba[..., 3], drawn(whole).rgba[..., 3])


@pytest.mark.parametrize("far_m", [1e4, 1e6])
def test_a_figure_far_from_the_origin_looks_as_it_does_there(far_m: float) -> None:
    away = np.array([far_m, -far_m, 0.5 * far_m])
    near, moved = square(2.0), square(2.0)
    moved = replace(moved, vertices=moved.vertices + away)
    light = LIGHT.translated_by(away)
    with FastRenderer(CAMERA.width, CAMERA.height) as renderer:
        renderer.show([moved], light)
        seen = renderer.render(CAMERA, Motor.from_translation(away))
        renderer.move(0, moved.vertices, moved.normals)
        again = renderer.render(CAMERA, Motor.from_translation(away))
    expected = drawn(near)
    np.testing.assert_array_equal(seen.rgba[..., 3], expected.rgba[..., 3])
    np.testing.assert_allclose(seen.rgba, expected.rgba, atol=2)
    np.testing.assert_allclose(seen.depth_m, expected.depth_m, rtol=1e-4)
    np.testing.assert_array_equal(again.rgba, seen.rgba)


def test_textures_of_one_texel_and_of_more_than_opengl_holds() -> None:
    red = np.array([[[255, 0, 0, 255]]], np.uint8)
    seen = drawn(square(2.0, base_map=TextureMap(red), unlit=True))
    np.testing.assert_array_equal(seen.rgba[24, 32], [255, 0, 0, 255])
    wide = np.tile(red, (2, 16385, 1))
    np.testing.assert_array_equal(
        drawn(square(2.0, base_map=TextureMap(wide), unlit=True)).rgba[24, 32], [255, 0, 0, 255]
    )


def test_a_million_triangles_are_drawn() -> None:
    side = 708
    u, v = np.meshgrid(np.linspace(-0.3, 0.3, side), np.linspace(-0.3, 0.3, side))
    places = np.stack([u.ravel(), v.ravel(), np.full(u.size, 2.0)], axis=1)
    a = np.arange(side * side).reshape(side, side)
    b, c, d = a[1:, :-1].ravel(), a[1:, 1:].ravel(), a[:-1, 1:].ravel()
    a = a[:-1, :-1].ravel()
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    look = plain(len(triangles), len(places))
    normals = np.tile([0.0, 0.0, -1.0], (len(places), 1))
    seen, expected = drawn(Surface(places, normals, triangles, appearance=look)), drawn(square(2.0))
    assert len(triangles) > 990_000
    np.testing.assert_allclose(seen.rgba, expected.rgba, atol=1)


def test_what_lies_behind_the_camera_is_left_out() -> None:
    around = square(0.0, 1.0)
    corners = around.vertices[:, [2, 0, 1]] * 2.0 + (0.3, 0.0, 1.5)  # from behind to far ahead
    wall = replace(around, vertices=corners, appearance=None)
    both = replace(wall, triangles=np.concatenate([wall.triangles, wall.triangles[:, ::-1]]))
    seen = drawn(both)
    assert 0 < (seen.rgba[..., 3] > 0).sum() < 48 * 64
    assert seen.depth_m.max() < 3.6
    assert not drawn(square(-2.0)).rgba.any()
