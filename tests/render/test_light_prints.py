"""Brightness and colour of light by printed paper, and by nothing but the images' mean."""

import numpy as np
import pytest

from motorcade.animation import Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting
from motorcade.render.light import (
    Prints,
    character_lighting,
    lighting_without_depth,
    sunlight_direction,
)
from motorcade.render.light.lamps import light_on
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
HEIGHT_M = 0.2
LIGHTS = [(1.0, 1.0, 1.0), (0.9, 0.7, 0.4), (0.25, 0.3, 0.4)]
UP = np.array([0.0, 0.0, 1.0])


def bytes_of(light: FloatArray) -> ImageArray:
    """Bytes (sRGB) of linear light (IEC 61966-2-1)."""
    x = np.clip(light, 0.0, 1.0)
    shown = np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.rint(255.0 * shown), dtype=np.uint8)


@pytest.fixture
def placement() -> Placement:
    return place_on_plane(mannequin(), (0.0, 0.0), 0.0, height_m=HEIGHT_M)


@pytest.fixture
def path() -> Trajectory:
    """Two poses above the plane z = 0, looking straight down."""
    down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    poses = Motor.from_rotor_translation(Rotor.identity((2,)) @ down, [[0, 0, 0.5], [0, 0, 0.6]])
    return Trajectory(np.array([0, 1_000_000_000]), poses, "world", "camera")


def board(light: FloatArray, veil: float = 0.0, paper: float = 0.85) -> ImageArray:
    """A checkerboard of paper and ink that fills the image."""
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
    white = ((x // 16 + y // 16) % 2 == 0)[..., None]
    return bytes_of(np.where(white, paper, 0.05) * light + veil)


def prints() -> Prints:
    return Prints(Motor.identity((1,)), np.array([[-0.15, -0.12]]), np.array([[0.15, 0.12]]))


def on_ground(lighting: Lighting) -> FloatArray:
    direct, other = light_on(lighting, np.zeros(3), UP)
    return direct + other


def frames(*images: ImageArray) -> list[tuple[int, ImageArray, None]]:
    return [(k * 500_000_000, image, None) for k, image in enumerate(images)]


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("veil", [0.0, 0.08])
def test_the_light_lights_the_paper_as_the_image_shows(
    light: tuple[float, float, float], veil: float, path: Trajectory, placement: Placement
) -> None:
    """Also where the lens adds light of its own, which black ink tells."""
    shown = board(0.9 * np.array(light), veil)
    made, told = lighting_without_depth(frames(shown), CAMERA, path, placement, HEIGHT_M, prints())
    np.testing.assert_allclose(on_ground(made), 0.9 * np.array(light), rtol=0.04)
    assert "printed paper" in told
    assert "direction assumed" in told


@pytest.mark.parametrize("light", [1.3, 1.5, 1.7])
def test_ink_tells_light_that_overexposes_paper(
    light: float, path: Trajectory, placement: Placement
) -> None:
    shown = board(light * np.ones(3), veil=0.01)
    lighting, _ = lighting_without_depth(frames(shown), CAMERA, path, placement, HEIGHT_M, prints())
    np.testing.assert_allclose(on_ground(lighting), light, rtol=0.15)


def test_only_brightness_and_colour_are_taken(path: Trajectory, placement: Placement) -> None:
    made, _ = lighting_without_depth(
        frames(board(np.array([0.3, 0.2, 0.1]))), CAMERA, path, placement, HEIGHT_M, prints()
    )
    cameras = path.motors
    direction = sunlight_direction(placement, cameras)
    usual = character_lighting(placement, cameras, HEIGHT_M, direction)
    assert made.sun.direction == usual.sun.direction
    for normal in np.eye(3):
        one, other = (
            np.add(*light_on(light, np.array([0.0, 0.0, 0.1]), normal)) for light in (made, usual)
        )
        ratio = one / other
        np.testing.assert_allclose(ratio, on_ground(made) / on_ground(usual), rtol=1e-9)


def test_one_frame_of_another_exposure_does_not_count(
    path: Trajectory, placement: Placement
) -> None:
    usual, dark = board(np.full(3, 0.8)), board(np.full(3, 0.1))
    given = frames(usual, dark, usual)
    made, _ = lighting_without_depth(given, CAMERA, path, placement, HEIGHT_M, prints())
    np.testing.assert_allclose(on_ground(made), 0.8, rtol=0.04)


def test_where_no_print_is_seen_half_of_a_grey_world_is_believed(
    path: Trajectory, placement: Placement
) -> None:
    """A print behind a sheet of grey, one that looks away, and none at all."""
    tint = np.array([1.2, 1.0, 0.7])
    shown = np.broadcast_to(bytes_of(0.18 * 0.5 * tint), (CAMERA.height, CAMERA.width, 3))
    away = Prints(
        Motor.from_rotor_translation(Rotor.from_rotation_vector([np.pi, 0, 0]), [0, 0, 0]).reshape(
            1
        ),
        prints().low_m,
        prints().high_m,
    )
    cameras = path.motors
    usual = on_ground(
        character_lighting(placement, cameras, HEIGHT_M, sunlight_direction(placement, cameras))
    )
    for known in (prints(), away, None):
        made, told = lighting_without_depth(
            frames(shown.copy()), CAMERA, path, placement, HEIGHT_M, known
        )
        half = np.sqrt(usual * 0.5 * tint / tint.mean())
        np.testing.assert_allclose(on_ground(made), half, rtol=0.05)
        assert "grey world" in told


def test_black_images_and_none_leave_a_light(path: Trajectory, placement: Placement) -> None:
    black = np.zeros((CAMERA.height, CAMERA.width, 3), dtype=np.uint8)
    made, _ = lighting_without_depth(frames(black), CAMERA, path, placement, HEIGHT_M, prints())
    assert np.all(on_ground(made) > 0.0)
    outside = [(5_000_000_000, black, None)]
    made, told = lighting_without_depth(outside, CAMERA, path, placement, HEIGHT_M)
    assert told == "a fixed light"


def test_prints_and_cameras_that_do_not_fit_are_refused(
    path: Trajectory, placement: Placement
) -> None:
    with pytest.raises(ValueError, match=r"Prints\.low_m: expected one row a print"):
        Prints(Motor.identity((2,)), np.zeros((1, 2)), np.ones((1, 2)))
    with pytest.raises(ValueError, match=r"Prints\.high_m: expected more than low_m"):
        Prints(Motor.identity((1,)), np.zeros((1, 2)), np.zeros((1, 2)))
    bent = Camera(160, 120, 140.0, 140.0, 79.5, 59.5, "radtan", (-0.1, 0.0))
    with pytest.raises(ValueError, match="expected pinhole, got radtan"):
        lighting_without_depth([], bent, path, placement, HEIGHT_M)
