"""The renderer against the camera model: where points land, how deep they are, what edges weigh."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.render import (
    RENDERERS,
    Lamp,
    Layer,
    Lighting,
    RenderUnavailable,
    Sun,
    Surface,
    new_renderer,
)
from motorcade.render.backends import platform
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(320, 240, 260.3, 257.9, 166.4, 110.6)
LIGHTING = Lighting(
    (0.3, 0.3, 0.3),
    Sun((0.2, -0.3, -1.0), 3.0),
    (Lamp((1.0, 1.0, 1.0), 2.0),),
    (0.0, 0.0, 0.0),
    1.0,
)


def square(world_T_camera: Motor, center_camera: np.ndarray, half_m: float) -> Surface:
    """A white square that faces the camera squarely."""
    corners = np.array([[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
    return Surface(
        world_T_camera.apply(center_camera + half_m * corners),
        np.tile(world_T_camera.rotor.apply([0.0, 0.0, -1.0]), (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )


def weighted_middle(layer: Layer) -> np.ndarray:
    """Centre of gravity of a layer's alpha, pixels (x, y)."""
    alpha = layer.rgba[..., 3].astype(np.float64)
    y, x = np.mgrid[: alpha.shape[0], : alpha.shape[1]]
    return np.array([np.sum(alpha * x), np.sum(alpha * y)]) / alpha.sum()


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_points_land_where_the_camera_projects_them(name: str, rng: np.random.Generator) -> None:
    pose = Motor.random(rng)
    errors = []
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        for _ in range(12):
            depth = rng.uniform(0.5, 4.0)
            pixel = rng.uniform([40.0, 40.0], [280.0, 200.0])
            center = depth * CAMERA.unproject(pixel)
            renderer.show([square(pose, center, 0.05 * depth)], None)
            errors.append(weighted_middle(renderer.render(CAMERA, pose)) - pixel)
    # four samples a pixel place one square to about 0.1 px; the mean shows any fixed offset
    assert np.abs(errors).max() < 0.12
    assert np.abs(np.mean(errors, axis=0)).max() < 0.05


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_depth_is_metres_along_the_optical_axis(name: str, rng: np.random.Generator) -> None:
    pose = Motor.random(rng)
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        for depth in (0.1, 1.0, 5.0, 20.0):
            renderer.show([square(pose, np.array([0.0, 0.0, depth]), 0.2 * depth)], None)
            layer = renderer.render(CAMERA, pose)
            seen = layer.depth_m[layer.rgba[..., 3] == 255]
            assert np.abs(seen - depth).max() < 1e-5 + 2e-5 * depth**2
            assert np.all(layer.depth_m[layer.rgba[..., 3] == 0] == 0.0)


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_a_slanted_plane_has_the_depth_of_its_rays(name: str) -> None:
    turn = Rotor.from_euler([0.5, 0.4, 0.0])
    plane_T_camera = Motor.from_rotor_translation(turn, np.array([0.0, 0.0, -2.0]))
    corners = 3.0 * np.array(
        [[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]
    )
    surface = Surface(corners, np.tile([0.0, 0.0, -1.0], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        renderer.show([surface], None)
        layer = renderer.render(CAMERA, plane_T_camera)
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = CAMERA.unproject(np.stack([x, y], axis=-1).astype(np.float64))
    turned = plane_T_camera.rotor.apply(rays)
    expected = 2.0 / turned[..., 2]
    inside = layer.rgba[..., 3] == 255
    assert inside.mean() > 0.9
    # the depth of one sample of the pixel, which lies up to 0.4 px from its centre
    slope = np.hypot(*np.gradient(expected))
    error = np.abs(layer.depth_m - expected) / slope
    assert error[inside].max() < 0.5


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_color_is_premultiplied_by_coverage(name: str) -> None:
    pose = Motor.identity()
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        renderer.show([square(pose, np.array([0.013, 0.021, 1.0]), 0.3)], None)
        rgba = renderer.render(CAMERA, pose).rgba
    alpha = rgba[..., 3]
    assert np.any((alpha > 0) & (alpha < 255))
    for channel in range(3):
        np.testing.assert_array_equal(rgba[..., channel], alpha)
    assert not rgba[alpha == 0].any()


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_flat_textures_come_out_as_they_went_in(name: str) -> None:
    texture = np.zeros((64, 64, 3), dtype=np.uint8)
    texture[:32, :32], texture[:32, 32:] = (250, 10, 20), (10, 240, 30)
    texture[32:, :32], texture[32:, 32:] = (20, 30, 230), (120, 130, 140)
    surface = Surface(
        np.array([[-1.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0], [-1.0, -1.0, 2.0]]),
        np.tile([0.0, 0.0, -1.0], (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        texture=texture,
        texture_coordinates=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    )
    pose = Motor.identity()
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        # this square's front looks along -z: towards the camera, whose y points down
        front = Surface(
            surface.vertices,
            surface.normals,
            surface.triangles[:, ::-1],
            texture=texture,
            texture_coordinates=surface.texture_coordinates,
        )
        renderer.show([surface, front], None)
        rgba = renderer.render(CAMERA, pose).rgba
    corners = CAMERA.project(
        [[-0.5, -0.5, 2.0], [0.5, -0.5, 2.0], [-0.5, 0.5, 2.0], [0.5, 0.5, 2.0]]
    )
    expected = [(250, 10, 20), (10, 240, 30), (20, 30, 230), (120, 130, 140)]
    for (x, y), color in zip(np.rint(corners).astype(int), expected, strict=True):
        np.testing.assert_allclose(rgba[y, x, :3], color, atol=1)


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_a_moved_surface_is_drawn_like_a_new_one(name: str, rng: np.random.Generator) -> None:
    pose = Motor.identity()
    first = square(pose, np.array([0.0, 0.0, 1.0]), 0.1)
    second = square(pose, np.array([0.2, -0.1, 1.3]), 0.2)
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        renderer.show([first], LIGHTING)
        renderer.render(CAMERA, pose)
        renderer.move(0, second.vertices, second.normals)
        moved = renderer.render(CAMERA, pose)
        renderer.show([second], LIGHTING)
        fresh = renderer.render(CAMERA, pose)
    np.testing.assert_array_equal(moved.rgba, fresh.rgba)
    np.testing.assert_array_equal(moved.depth_m, fresh.depth_m)


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_the_sun_throws_a_shadow(name: str) -> None:
    ground = Surface(
        2.0 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]),
        np.tile([0.0, 0.0, 1.0], (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    roof = Surface(ground.vertices * 0.1 + [0.0, 0.0, 0.3], ground.normals, ground.triangles)
    down = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([np.pi, 0.0, 0.0]), np.array([0.0, 0.0, 2.0])
    )
    light = Lighting((0.1, 0.1, 0.1), Sun((1.0, 0.0, -1.0), 2.0), (), (0.0, 0.0, 0.1), 1.0)
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        renderer.show([ground, roof], light)
        rgba = renderer.render(CAMERA, down).rgba
    # a slanting sun carries the roof's shadow as far along +x as the roof is high
    at = down.inverse().apply([[0.3, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.6, 0.0, 0.0]])
    pixels = np.rint(CAMERA.project(at)).astype(int)
    dark, lit, beyond = (int(rgba[y, x, 0]) for x, y in pixels)
    assert dark < 0.6 * lit
    assert abs(beyond - lit) < 0.1 * lit


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_two_renderers_live_side_by_side(name: str) -> None:
    pose = Motor.identity()
    shape = square(pose, np.array([0.0, 0.0, 1.0]), 0.1)
    small = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    with new_renderer(name, CAMERA.width, CAMERA.height) as one:
        one.show([shape], None)
        before = one.render(CAMERA, pose)
        with new_renderer(name, 64, 48) as two:
            two.show([shape], None)
            assert two.render(small, pose).rgba.any()
        after = one.render(CAMERA, pose)
    np.testing.assert_array_equal(before.rgba, after.rgba)


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
def test_misuse_is_refused(name: str) -> None:
    pose = Motor.identity()
    shape = square(pose, np.array([0.0, 0.0, 1.0]), 0.1)
    renderer = new_renderer(name, CAMERA.width, CAMERA.height)
    with pytest.raises(RuntimeError, match="show"):
        renderer.render(CAMERA, pose)
    renderer.show([shape], None)
    with pytest.raises(ValueError, match="of 320 x 240"):
        renderer.render(Camera(64, 48, 50.0, 50.0, 31.5, 23.5), pose)
    with pytest.raises(ValueError, match="pinhole"):
        renderer.render(Camera(320, 240, 260.0, 260.0, 160.0, 120.0, "radtan", (0.1, 0.0)), pose)
    with pytest.raises(ValueError, match="expected shape"):
        renderer.move(0, np.zeros((3, 3)), np.zeros((3, 3)))
    renderer.close()
    renderer.close()
    with pytest.raises(RuntimeError, match="close"):
        renderer.render(CAMERA, pose)
    with pytest.raises(ValueError, match="1 pixel or more"):
        new_renderer(name, 0, 10)


def test_without_any_opengl_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv(platform.VARIABLE, raising=False)
    monkeypatch.setattr(platform, "working_egl_device", lambda: None)
    monkeypatch.setattr(platform, "osmesa_library", lambda: None)
    monkeypatch.delitem(sys.modules, "OpenGL", raising=False)
    with pytest.raises(RenderUnavailable, match="install libegl1") as caught:
        platform.choose_platform.__wrapped__()
    assert "\n" not in str(caught.value)
    assert platform.VARIABLE not in os.environ


def test_osmesa_is_taken_where_egl_is_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "working_egl_device", lambda: None)
    monkeypatch.setattr(platform, "osmesa_library", lambda: object())
    monkeypatch.setenv(platform.VARIABLE, "osmesa")
    assert platform.choose_platform.__wrapped__() == platform.Platform("osmesa", 0)


def test_an_unknown_platform_in_the_environment_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(platform.VARIABLE, "glx")
    with pytest.raises(RenderUnavailable, match="'glx': expected egl, osmesa"):
        platform.choose_platform.__wrapped__()


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.usefixtures("opengl")
@pytest.mark.slow
def test_osmesa_draws_what_egl_draws(name: str, tmp_path: Path) -> None:
    if platform.osmesa_library() is None or platform.working_egl_device() is None:
        pytest.skip("both EGL and OSMesa are needed to compare them")
    script = (
        "import sys, numpy as np\n"
        "from motorcade.ga import Motor\n"
        "from motorcade.render import Surface, new_renderer\n"
        "from motorcade.tracking.cameras.camera import Camera\n"
        "corners = np.array([[-1, -1, 3], [-1, 1, 4], [1, 1, 3], [1, -1, 4.0]])\n"
        "front = np.tile([0.0, 0.0, -1.0], (4, 1))\n"
        "s = Surface(corners, front, np.array([[0, 1, 2], [0, 2, 3]]), 0.5 + 0.1 * corners)\n"
        "with new_renderer(sys.argv[1], 160, 240) as r:\n"
        "    r.show([s], None)\n"
        "    layer = r.render(Camera(160, 240, 200.0, 200.0, 79.5, 119.5), Motor.identity())\n"
        "np.save(sys.argv[2], layer.rgba)\n"
    )
    images = []
    for kind in ("egl", "osmesa"):
        file = tmp_path / f"{kind}.npy"
        environment = os.environ | {platform.VARIABLE: kind}
        command = [sys.executable, "-c", script, name, str(file)]
        subprocess.run(command, check=True, env=environment)
        images.append(np.load(file).astype(int))
    assert images[0][..., 3].max() == 255
    assert np.mean(np.abs(images[0] - images[1]) > 2) < 1e-3
