"""The fast renderer: it looks as pyrender's does, carries vertices as NumPy does, and holds out."""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, Placement, mannequin
from motorcade.animation.skin import SKIN_METHODS, SkinMethod, palette, skin
from motorcade.ga import Motor, Rotor
from motorcade.render import (
    ContextLost,
    Lamp,
    Layer,
    Lighting,
    Sun,
    Surface,
    new_renderer,
)
from motorcade.render.backends.fast import FastRenderer
from motorcade.tracking.cameras.camera import Camera

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(320, 240, 260.3, 257.9, 166.4, 110.6)
# A sun that slants more makes pyrender's shadow map shade the surfaces that it was drawn from.
LIGHTING = Lighting(
    (0.3, 0.31, 0.33),
    Sun((0.25, 0.15, 1.0), 3.0, (1.0, 0.95, 0.9)),
    (Lamp((1.0, -1.0, 0.5), 2.0), Lamp((-1.0, 0.5, 1.0), 1.5, (0.8, 0.9, 1.0))),
    (0.0, 0.0, 2.0),
    2.3,
)


def ball(center: np.ndarray, radius_m: float, rings: int = 24) -> Surface:
    """A ball with colours, round enough that its outline is."""
    across, around = np.meshgrid(
        np.linspace(0.0, np.pi, rings), np.linspace(0.0, 2.0 * np.pi, 2 * rings), indexing="ij"
    )
    out = np.stack(
        [np.sin(across) * np.cos(around), np.sin(across) * np.sin(around), np.cos(across)], axis=-1
    )
    number = np.arange(out[..., 0].size).reshape(out.shape[:2])
    a, b, c, d = (number[i : i + rings - 1, j : j + 2 * rings - 1] for i in (0, 1) for j in (0, 1))
    triangles = np.concatenate(
        [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)]
    )
    normals = out.reshape(-1, 3)
    return Surface(center + radius_m * normals, normals, triangles, 0.5 + 0.4 * normals)


def wall(depth_m: float) -> Surface:
    """A textured wall before the camera, which shadows fall on."""
    x = 1.5 * np.array([-1.0, -1.0, 1.0, 1.0])
    y = 1.5 * np.array([-1.0, 1.0, 1.0, -1.0])
    texture = np.zeros((16, 16, 3), np.uint8)
    texture[::2, ::2] = texture[1::2, 1::2] = 180
    return Surface(
        np.stack([x, y, np.full(4, depth_m)], axis=1),
        np.tile([0.0, 0.0, -1.0], (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        texture=texture,
        texture_coordinates=np.stack([x, y], axis=1),
        roughness=0.42,
    )


def drawn(name: str, surfaces: list[Surface], lighting: Lighting | None) -> Layer:
    with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
        renderer.show(surfaces, lighting)
        return renderer.render(CAMERA, Motor.identity())


@pytest.mark.parametrize(("lighting", "levels"), [(LIGHTING, 2.0), (None, 0.5)])
def test_it_looks_as_pyrender_does(lighting: Lighting | None, levels: float) -> None:
    """In light two levels, for facets are hidden by another formula and mirror ambient light too.

    The texture is smooth, and in light nothing has colours: pyrender mixes texels as they are
    stored, and has colours dye highlights.
    """
    around = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    paint = np.full((64, 64, 3), 90, np.uint8)
    paint[..., 0], paint[..., 1] = 128 + 60 * np.sin(around), 128 + 60 * np.cos(around)[:, None]
    round_one = ball(np.array([-0.4, -0.25, 1.6]), 0.4)
    if lighting is not None:
        round_one = replace(round_one, colors=None)
    scene = [round_one, replace(wall(2.4), texture=paint)]
    ours, theirs = (drawn(name, scene, lighting) for name in ("fast", "pyrender"))
    off = np.abs(ours.rgba[..., :3].astype(int) - theirs.rgba[..., :3])
    shown = theirs.rgba[..., 3] > 0
    assert shown.mean() > 0.5
    # few pixels more: the shadow's rim is half as finely sampled
    assert off[shown].mean() < levels
    assert np.mean(off[shown].max(axis=-1) > 12) < 0.01
    np.testing.assert_allclose(ours.depth_m, theirs.depth_m, rtol=1e-3)


def test_outlines_agree_with_pyrender() -> None:
    scene = [ball(np.array([0.1, 0.05, 1.6]), 0.4), ball(np.array([-0.5, -0.2, 2.6]), 0.1)]
    ours, theirs = (drawn(name, scene, LIGHTING).rgba[..., 3] for name in ("fast", "pyrender"))
    both, either = np.minimum(ours, theirs).sum(), np.maximum(ours, theirs).sum()
    assert theirs.max() == 255
    assert both / either >= 0.995


def test_wherever_a_surface_goes_nothing_is_cut_off_or_left_behind() -> None:
    """Only the part of the image that can hold something is cleared, resolved and read."""
    shape = ball(np.zeros(3), 0.4, 12)
    with FastRenderer(CAMERA.width, CAMERA.height) as ours:
        theirs = new_renderer("pyrender", CAMERA.width, CAMERA.height)
        for renderer in (ours, theirs):
            renderer.show([shape], LIGHTING)
        seen = 0
        for place in (
            [0, 0, 1],
            [-1, 0.8, 2],
            [9, 0, 2],
            [0.7, -0.5, 1],
            [0, 0, -2],
            [0.3, 0, 0.3],
        ):
            for renderer in (ours, theirs):
                renderer.move(0, shape.vertices + np.array(place), shape.normals)
            found, expected = (r.render(CAMERA, Motor.identity()) for r in (ours, theirs))
            np.testing.assert_array_equal(found.rgba[..., 3], expected.rgba[..., 3])
            np.testing.assert_allclose(found.depth_m, expected.depth_m, rtol=1e-3)
            seen += int(found.rgba.any())
        theirs.close()
    assert seen == 4


@pytest.fixture(scope="module", params=["mannequin", "of eight", "makehuman"])
def character(request: pytest.FixtureRequest) -> Character:
    if request.param == "mannequin":
        return mannequin()
    if request.param == "of eight":
        figure, drawn = mannequin(), np.random.default_rng(4)
        shape = (len(figure.vertices), 8)
        joints = np.sort(drawn.integers(0, len(figure.skeleton), shape), axis=1)
        return replace(figure, joints=joints, weights=drawn.dirichlet(np.ones(8), len(joints)))
    from motorcade.animation.formats import read_character

    folder: Path = request.getfixturevalue("data_dir")
    return read_character(folder / "rigs" / "makehuman" / "mh_male_ge53_27k.glb")


@pytest.fixture(scope="module")
def renderer() -> Iterator[FastRenderer]:
    with FastRenderer(CAMERA.width, CAMERA.height) as made:
        yield made


@pytest.mark.parametrize("method", SKIN_METHODS)
def test_the_shader_carries_vertices_as_numpy_does(
    character: Character, renderer: FastRenderer, method: SkinMethod, rng: np.random.Generator
) -> None:
    surface = Surface(character.vertices, character.normals, character.triangles)
    renderer.show([surface], None)
    renderer.bind(0, character, method)
    placement = Placement(Motor.random(rng), 0.7)
    for time_s in rng.uniform(0.0, character.clips[-1].duration_s, 3):
        pose = character.clips[-1].at(time_s)
        renderer.pose(0, palette(character.skeleton, pose, method)[0], placement)
        vertices, normals = renderer.vertices(0)
        expected, turned = skin(character, pose, method)
        apart = np.linalg.norm(vertices - placement.apply(expected), axis=1)
        assert apart.max() < 1e-5 * placement.scale * character.height_m
        assert np.abs(expected - character.vertices).max() > 0.01 * character.height_m
        facing = placement.world_T_character.rotor.apply(turned)
        assert np.abs(normals - facing).max() < 1e-3


def test_a_carried_surface_is_drawn_like_a_moved_one(renderer: FastRenderer) -> None:
    figure = mannequin()
    pose = figure.clips[-1].at(0.4)
    stand = Placement(
        Motor.from_rotor_translation(
            Rotor.from_euler([0.5 * np.pi, 0.3, 0.0]), np.array([0.0, 0.4, 2.5])
        ),
        1.0 / figure.height_m,
    )
    surface = Surface(figure.vertices, figure.normals, figure.triangles, figure.colors)
    renderer.show([surface], LIGHTING)
    renderer.bind(0, figure, "motor")
    renderer.pose(0, palette(figure.skeleton, pose, "motor")[0], stand)
    carried = renderer.render(CAMERA, Motor.identity())
    vertices, normals = skin(figure, pose, "motor")
    renderer.move(0, stand.apply(vertices), stand.world_T_character.rotor.apply(normals))
    moved = renderer.render(CAMERA, Motor.identity())
    assert (moved.rgba[..., 3] > 0).sum() > 1000
    assert np.mean(np.any(np.abs(carried.rgba.astype(int) - moved.rgba) > 8, axis=-1)) < 1e-3


def test_what_does_not_fit_a_surface_is_refused(renderer: FastRenderer) -> None:
    figure = mannequin()
    renderer.show([wall(2.0), Surface(figure.vertices, figure.normals, figure.triangles)], None)
    with pytest.raises(ValueError, match="expected 4 vertices"):
        renderer.bind(0, figure)
    with pytest.raises(ValueError, match="expected one of linear"):
        renderer.bind(1, figure, "screw")
    entries = palette(figure.skeleton, figure.clips[0].at(0.0), "linear")[0]
    with pytest.raises(ValueError, match="that was bound, got 1"):
        renderer.pose(1, entries)
    renderer.bind(1, figure, "motor")
    with pytest.raises(ValueError, match="expected a palette of shape"):
        renderer.pose(1, entries)
    with pytest.raises(ValueError, match="renderer: expected one of fast, pyrender, got 'slow'"):
        new_renderer("slow", 10, 10)


@pytest.mark.parametrize("size_m", [1e-3, 1.0, 80.0, 3000.0])
def test_a_figure_of_any_size_is_drawn_whole(size_m: float) -> None:
    shape, place = ball(np.zeros(3), 0.4, 12), Motor.from_translation([0.0, 0.0, -2.0 * size_m])
    alone = drawn("fast", [ball(np.array([0.0, 0.0, 2.0]), 0.4, 12)], None)
    for name in ("fast", "pyrender"):
        with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
            renderer.show([Surface(size_m * shape.vertices, shape.normals, shape.triangles)], None)
            seen = renderer.render(CAMERA, place)
        np.testing.assert_array_equal(seen.rgba[..., 3], alone.rgba[..., 3])
        np.testing.assert_allclose(seen.depth_m, size_m * alone.depth_m, rtol=1e-4)


def test_a_camera_inside_a_mesh_sees_out_of_it() -> None:
    around, outside = ball(np.zeros(3), 0.5), wall(2.0)
    for name in ("fast", "pyrender"):
        with new_renderer(name, CAMERA.width, CAMERA.height) as renderer:
            renderer.show([around, outside], LIGHTING)
            inside = renderer.render(CAMERA, Motor.identity())
            renderer.show([outside], LIGHTING)
            alone = renderer.render(CAMERA, Motor.identity())
        # backs are not drawn; they throw no shadow on the wall either way it is looked at
        np.testing.assert_allclose(inside.depth_m, alone.depth_m, rtol=1e-5)
        assert inside.depth_m.max() == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("name", ["fast", "pyrender"])
def test_a_lost_context_is_told_of(name: str) -> None:
    renderer = new_renderer(name, 64, 48)
    renderer.show([wall(2.0)], None)
    renderer._context.destroy()  # type: ignore[attr-defined]
    with pytest.raises(ContextLost, match="context is lost"):
        renderer.render(Camera(64, 48, 50.0, 50.0, 31.5, 23.5), Motor.identity())
    renderer.close()
    # others draw on
    assert drawn(name, [wall(2.0)], None).rgba.any()


def test_images_larger_than_opengl_holds_are_refused() -> None:
    with pytest.raises(ValueError, match=r"expected at most \d+ pixels a side"):
        FastRenderer(1 << 20, 1)
    with pytest.raises(ValueError, match="1 pixel or more"):
        FastRenderer(64, 0)


@pytest.mark.slow
def test_eight_thousand_pixels_are_drawn() -> None:
    camera = Camera(7680, 4320, 6000.0, 6000.0, 3839.5, 2159.5)
    with FastRenderer(camera.width, camera.height) as renderer:
        renderer.show([ball(np.array([0.0, 0.0, 2.0]), 0.5, 64)], LIGHTING)
        layer = renderer.render(camera, Motor.identity())
    # the outline of a ball at distance d is a cone of tangent r / sqrt(d^2 - r^2)
    radius = 6000.0 * 0.5 / np.sqrt(2.0**2 - 0.5**2)
    covered = layer.rgba[..., 3].sum(dtype=np.int64) / 255
    assert covered == pytest.approx(np.pi * radius**2, rel=2e-3)


def resident_bytes() -> int:
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def test_a_thousand_frames_take_no_more_memory() -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("resident memory is read from /proc")
    shape = ball(np.array([0.0, 0.0, 2.0]), 0.5, 8)
    camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    with FastRenderer(64, 48) as renderer:
        before = 0
        for number in range(1100):
            if number == 100:
                before = resident_bytes()
            if number % 50 == 0:
                renderer.show([shape], LIGHTING)
            renderer.move(0, shape.vertices, shape.normals)
            renderer.render(camera, Motor.identity())
        # one layer a frame kept by mistake would be 25 MB, the framebuffers of one 0.3 MB
        assert resident_bytes() - before < 8e6
