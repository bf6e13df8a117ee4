"""Materials as the fast renderer draws them: alpha, sides, wrapping, and light that is linear."""

from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from motorcade.animation.appearance import Appearance, Material, MaterialPart, TextureMap, to_srgb
from motorcade.ga import Motor, Rotor
from motorcade.render import Layer, Lighting, OffscreenRenderer, Sun, Surface
from motorcade.render.backends.fast import FastRenderer
from motorcade.render.backends.materials import Images, mirrored_table
from motorcade.render.light.estimate import harmonics, rotate_harmonics
from motorcade.tracking.cameras.camera import Camera

pytestmark = pytest.mark.usefixtures("opengl")

CAMERA = Camera(32, 32, 32.0, 32.0, 15.5, 15.5)
AHEAD = Lighting((0.0, 0.0, 0.0), Sun((0.0, 0.0, 1.0), np.pi), (), (0.0, 0.0, 1e6), 1.0)
WHITE = Material(unlit=True)


def wall(material: Material, depth_m: float, *, turned: bool = False) -> Surface:
    """A square that fills the image, its texture once across it."""
    uv = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    places = np.column_stack([(uv - 0.5) * 1.02 * depth_m, np.full(4, depth_m)])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    if turned:
        triangles = triangles[:, ::-1]
    look = Appearance((MaterialPart(material, 0, 2),), uv[None].astype(np.float32))
    return Surface(places, np.tile([0.0, 0.0, -1.0], (4, 1)), triangles, appearance=look)


def drawn(*surfaces: Surface, lighting: Lighting | None = None) -> Layer:
    with FastRenderer(CAMERA.width, CAMERA.height) as renderer:
        renderer.show(surfaces, lighting)
        return renderer.render(CAMERA, Motor.identity())


def level(linear: float) -> float:
    return 255.0 * float(to_srgb(np.array(linear)))


def test_base_colour_is_encoded_as_srgb_and_not_by_a_power() -> None:
    for linear in (0.002, 0.02, 0.2, 0.9):
        seen = drawn(wall(replace(WHITE, base_color=(linear,) * 3 + (1.0,)), 1.0))
        assert seen.rgba[16, 16, 0] == pytest.approx(level(linear), abs=0.6)


def test_what_is_seen_through_is_mixed_in_linear_light_from_the_farthest_on() -> None:
    black = wall(replace(WHITE, base_color=(0.0, 0.0, 0.0, 1.0)), 3.0)
    red = wall(replace(WHITE, base_color=(1.0, 0.0, 0.0, 0.5), alpha_mode="blend"), 1.0)
    green = wall(replace(WHITE, base_color=(0.0, 1.0, 0.0, 0.5), alpha_mode="blend"), 2.0)
    for order in ((black, red, green), (green, red, black)):
        seen = drawn(*order)
        expected = [level(0.5), level(0.25), 0.0, 255.0]
        np.testing.assert_allclose(seen.rgba[16, 16], expected, atol=1.5)
        assert seen.depth_m[16, 16] == pytest.approx(1.0, rel=1e-3)
    alone = drawn(red)
    np.testing.assert_allclose(alone.rgba[16, 16], [127.5, 0.0, 0.0, 127.5], atol=1.0)


def test_backs_are_drawn_of_two_sided_materials_alone() -> None:
    for both in (False, True):
        seen = drawn(wall(replace(WHITE, double_sided=both), 1.0, turned=True))
        assert seen.rgba[16, 16, 3] == 255 * both


def image(alpha: bool = False) -> np.ndarray:
    """Left half black, right half white; or left half transparent."""
    made = np.full((8, 8, 4), 255, np.uint8)
    made[:, :4, 3 if alpha else slice(0, 3)] = 0
    return made


def test_a_mask_draws_what_reaches_its_cutoff() -> None:
    one = TextureMap(image(alpha=True), magnify="nearest", mipmaps=None)
    seen = drawn(wall(replace(WHITE, base_map=one, alpha_mode="mask"), 1.0))
    assert seen.rgba[16, 4, 3] == 0
    np.testing.assert_array_equal(seen.rgba[16, 28], 255)
    whole = drawn(wall(replace(WHITE, base_map=one), 1.0))
    assert whole.rgba[16, 4, 3] == 255  # an opaque material has no alpha


@pytest.mark.parametrize(
    ("wrap", "row"),
    [("repeat", [0, 255, 0, 255]), ("mirror", [0, 255, 255, 0]), ("clamp", [0, 255, 255, 255])],
)
def test_images_go_on_beyond_their_sides_as_samplers_say(wrap: str, row: list[int]) -> None:
    twice = ((2.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    one = TextureMap(image(), 0, (wrap, "clamp"), "nearest", mipmaps=None, transform=twice)
    seen = drawn(wall(replace(WHITE, base_map=one), 1.0))
    np.testing.assert_array_equal(seen.rgba[16, [4, 12, 20, 28], 0], row)


def test_a_rough_white_surface_gives_back_what_falls_on_it() -> None:
    """A sun of irradiance pi that faces a white surface: all of it, within what facets mirror."""
    seen = drawn(wall(Material(metallic=0.0), 1.0), lighting=AHEAD)
    assert seen.rgba[16, 16, 0] == pytest.approx(level(0.97), abs=2)
    lamp_off = drawn(
        wall(Material(emission=(0.2, 0.0, 0.0)), 1.0),
        lighting=replace(AHEAD, sun=Sun((0.0, 0.0, -1.0), 1.0)),
    )
    np.testing.assert_allclose(lamp_off.rgba[16, 16, :3], [level(0.2), 0, 0], atol=0.6)


def test_the_plainer_renderer_says_what_it_leaves_out(caplog: pytest.LogCaptureFixture) -> None:
    one = TextureMap(image())
    clear = replace(WHITE, base_map=one, normal_map=one, alpha_mode="blend")
    with OffscreenRenderer(CAMERA.width, CAMERA.height) as renderer:
        renderer.show([wall(Material(), 1.0)], None)
        assert not caplog.records
        renderer.show([wall(clear, 1.0)], None)
    assert "without base map, normal map, transparency; the fast" in caplog.text


def test_nothing_is_mirrored_that_did_not_arrive() -> None:
    table = mirrored_table().sum(axis=-1)
    assert table.max() <= 1.0 + 0.02
    assert table[:, 0].min() > 0.95  # smooth facets lose next to nothing
    np.testing.assert_array_less(table[16, 1:], table[16, :-1] + 0.01)


EVEN = ((np.sqrt(4.0 * np.pi) * 0.4,) * 3, *[(0.0, 0.0, 0.0)] * 8)
DARK = replace(AHEAD, sun=Sun((0.0, 0.0, 1.0), 0.0))


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_white_surfaces_vanish_in_even_surroundings(metallic: float, roughness: float) -> None:
    """All that arrives is given back, whatever the facets do to it."""
    white = Material(metallic=metallic, roughness=roughness)
    seen = drawn(wall(white, 1.0), lighting=replace(DARK, surroundings=EVEN))
    np.testing.assert_allclose(seen.rgba[16, 16, :3], level(0.4), atol=1.5)


def test_surroundings_light_a_surface_as_an_integral_over_them_does(
    rng: np.random.Generator,
) -> None:
    around = np.column_stack([EVEN, np.zeros((9, 0))]) + rng.normal(0.0, 0.1, (9, 3))
    lighting = replace(DARK, surroundings=tuple(map(tuple, around.tolist())))
    seen = drawn(wall(Material(metallic=0.0), 1.0), lighting=lighting).rgba[16, 16, :3]
    way = rng.normal(size=(200_000, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    facing = np.maximum(-way[:, 2], 0.0)  # the wall looks back at the camera
    falling = 4.0 * np.mean(facing[:, None] * (harmonics(way, 2) @ around), axis=0)
    # but for what is mirrored, a twenty-fifth of what comes from before it
    expected = [level(value) for value in falling]
    np.testing.assert_allclose(seen, expected, atol=2.5)


def test_surroundings_turn_with_the_scene(rng: np.random.Generator) -> None:
    around = np.array(EVEN) + rng.normal(0.0, 0.1, (9, 3))
    lighting = replace(DARK, surroundings=tuple(map(tuple, around.tolist())))
    shape, rotor = wall(Material(metallic=1.0, roughness=0.4), 1.0), Rotor.random(rng)
    turned = replace(
        shape, vertices=rotor.apply(shape.vertices), normals=rotor.apply(shape.normals)
    )
    expected = drawn(shape, lighting=lighting).rgba
    with FastRenderer(CAMERA.width, CAMERA.height) as renderer:
        rows = rotate_harmonics(around.T, rotor).T.tolist()
        renderer.show([turned], replace(lighting, surroundings=tuple(map(tuple, rows))))
        place = Motor.from_rotor_translation(rotor, np.zeros(3))
        seen = renderer.render(CAMERA, place).rgba
    assert expected[..., :3].std() > 1.0
    np.testing.assert_allclose(seen[2:-2, 2:-2], expected[2:-2, 2:-2], atol=2)


def test_textures_that_are_too_large_are_drawn_by_means_and_said_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Of stripes every third pixel would be of one colour; sRGB is averaged in linear light."""
    gl = MagicMock()
    gl.info = {"GL_MAX_TEXTURE_SIZE": 8}
    pixels = np.full((7, 22, 4), 255, np.uint8)
    pixels[:, ::2, :3] = 0
    images = Images(gl, lambda *given: None)
    for encoded in (True, False):
        images.texture(TextureMap(pixels), encoded=encoded)
    drawn = [call.args[2].astype(int) for call in gl.texture.call_args_list]
    assert [one.shape for one in drawn] == [(3, 8, 4)] * 2
    assert [call.args[0] for call in gl.texture.call_args_list] == [(8, 3)] * 2
    # Thirds of light, encoded by the standard's own curve, and the last column's one pixel.
    curve = [round(255 * (1.055 * share ** (1 / 2.4) - 0.055)) for share in (1 / 3, 2 / 3)]
    assert drawn[0][:, :, 0].tolist() == [[*curve * 3, curve[0], 255]] * 3
    assert drawn[1][:, :, 0].tolist() == [[85, 170] * 3 + [85, 255]] * 3
    assert all((one[..., 3] == 255).all() for one in drawn)
    (said,) = caplog.messages
    assert said == "textures of more than 8 pixels a side are drawn smaller, as one of 22 x 7"
