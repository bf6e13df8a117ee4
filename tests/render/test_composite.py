"""Compositing: the law of "over", shadows on the ground, and the overlay as a whole."""

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import Layer, over, render_overlay
from motorcade.render.composite import as_rgb, darken
from motorcade.render.light import character_lighting, sunlight_direction
from motorcade.render.shadow import GRID, ShadowLook, ground_depth, shade_in_image
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(200, 150, 180.0, 180.0, 99.5, 74.5)


def random_layer(rng: np.random.Generator) -> Layer:
    """A layer with all alphas and colours that do not exceed them."""
    alpha = rng.integers(0, 256, (20, 30, 1))
    color = rng.integers(0, alpha + 1, (20, 30, 3))
    depth = rng.uniform(1.0, 2.0, (20, 30)) * (alpha[..., 0] > 0)
    rgba = np.concatenate([color, alpha], axis=-1).astype(np.uint8)
    return Layer(rgba, depth.astype(np.float32))


def test_over_keeps_the_frame_at_zero_alpha_and_the_layer_at_full(
    rng: np.random.Generator,
) -> None:
    frame = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    layer = random_layer(rng)
    layer.rgba[:5] = 0
    layer.rgba[5:10, :, 3] = 255
    result = over(frame, layer)
    np.testing.assert_array_equal(result[:5], frame[:5])
    np.testing.assert_array_equal(result[5:10], layer.rgba[5:10, :, :3])


def curve(light: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, written out, in bytes."""
    return 255.0 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def test_over_mixes_light_to_half_a_step(rng: np.random.Generator) -> None:
    frame = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    layer = random_layer(rng)
    light = np.interp(np.arange(256), curve(np.linspace(0, 1, 100_001)), np.linspace(0, 1, 100_001))
    alpha = layer.rgba[..., 3:] / 255.0
    own = np.interp(
        layer.rgba[..., :3] / np.maximum(alpha, 1e-9),
        curve(np.linspace(0, 1, 100_001)),
        np.linspace(0, 1, 100_001),
    )
    expected = curve(alpha * own + (1.0 - alpha) * light[frame])
    assert np.abs(over(frame, layer) - expected).max() <= 0.5 + 1e-3


def test_nearer_scene_hides_the_layer_and_unknown_depth_does_not(
    rng: np.random.Generator,
) -> None:
    frame = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    layer = random_layer(rng)
    depth = np.full((20, 30), 9.0, dtype=np.float32)
    depth[:4], depth[4:8], depth[8:12] = 0.5, np.nan, 0.0
    result = over(frame, layer, depth)
    # The edge between is soft: two rows on each side of it hold some of both.
    np.testing.assert_array_equal(result[:2], frame[:2])
    np.testing.assert_array_equal(result[7:], over(frame, layer)[7:])


def test_depth_within_the_sensors_noise_hides_nothing(rng: np.random.Generator) -> None:
    frame = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    layer = random_layer(rng)
    near = layer.depth_m - np.float32(0.001) * layer.depth_m**2
    np.testing.assert_array_equal(over(frame, layer, near), over(frame, layer))


def test_over_changes_neither_input(rng: np.random.Generator) -> None:
    frame = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    layer = random_layer(rng)
    copies = frame.copy(), layer.rgba.copy()
    over(frame, layer, np.full((20, 30), 1.5, dtype=np.float32))
    np.testing.assert_array_equal(frame, copies[0])
    np.testing.assert_array_equal(layer.rgba, copies[1])


def test_over_refuses_other_sizes(rng: np.random.Generator) -> None:
    layer = random_layer(rng)
    with pytest.raises(ValueError, match=r"over\(layer\)"):
        over(np.zeros((21, 30, 3), dtype=np.uint8), layer)
    with pytest.raises(ValueError, match="depth_m"):
        over(np.zeros((20, 30, 3), dtype=np.uint8), layer, np.ones((3, 3), dtype=np.float32))


def test_darken_by_nothing_and_by_all() -> None:
    frame = np.full((4, 4, 3), 200, dtype=np.uint8)
    np.testing.assert_array_equal(darken(frame, np.zeros((4, 4))), frame)
    assert not darken(frame, np.ones((4, 4))).any()


@pytest.mark.parametrize("shape", [(4, 4, 4), (4,), (4, 4, 1)])
def test_frames_of_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="frame: expected uint8"):
        as_rgb(np.zeros(shape, dtype=np.uint8))


def looking_at_origin(azimuth_rad: float, height_m: float = 0.4) -> Motor:
    """A camera 0.8 m from the z axis that looks at a point a little above the origin."""
    eye = np.array([0.8 * np.cos(azimuth_rad), 0.8 * np.sin(azimuth_rad), height_m])
    ahead = np.array([0.0, 0.0, 0.1]) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(ahead, right), ahead], axis=-1)
    return Motor.from_rotor_translation(Rotor.from_matrix(axes), eye)


def test_ground_shade_lands_where_the_camera_projects_it() -> None:
    shade = np.zeros((GRID, GRID))
    shade[200:206, 90:96] = 1.0
    cell = 2.0 * 0.5 / GRID
    center = np.array([93.0 * cell - 0.5, 203.0 * cell - 0.5, 0.0])
    for azimuth in (0.3, 2.0, 4.0):
        pose = looking_at_origin(azimuth)
        seen = shade_in_image(shade, 0.5, CAMERA, pose.inverse())
        assert seen is not None
        y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
        middle = np.array([np.sum(seen * x), np.sum(seen * y)]) / seen.sum()
        expected = CAMERA.project(pose.inverse().apply(center))
        np.testing.assert_allclose(middle, expected, atol=0.15)


def test_ground_is_not_shaded_from_below_nor_above_the_horizon() -> None:
    shade = np.ones((GRID, GRID))
    below = Motor.from_translation(np.array([0.0, 0.0, -1.0]))
    assert shade_in_image(shade, 0.5, CAMERA, below.inverse()) is None
    level = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    pose = Motor.from_rotor_translation(Rotor.from_matrix(level), np.array([-2.0, 0.0, 0.5]))
    seen = shade_in_image(shade, 50.0, CAMERA, pose.inverse())
    assert seen is not None
    assert not seen[:74].any()
    assert seen[80:, 100].min() > 0.9


def test_default_sun_comes_from_above_and_from_the_viewers_side() -> None:
    figure = mannequin()
    placement = place_on_plane(figure, (0.0, 0.0), 1.0, height_m=0.25)
    for azimuth in (0.0, 1.5, 4.0):
        pose = looking_at_origin(azimuth)
        direction = sunlight_direction(placement, Motor.stack([pose]))
        assert direction[2] < -0.5
        assert np.dot(direction[:2], pose.translation_m[:2]) < 0.0
        left_of_viewer = -pose.rotor.apply([1.0, 0.0, 0.0])
        assert np.dot(direction, left_of_viewer) < 0.0


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


@pytest.fixture(scope="module")
def placement(figure: Character) -> Placement:
    return place_on_plane(figure, (0.0, 0.0), 0.5, height_m=0.25)


def path(count: int) -> Trajectory:
    poses = Motor.stack([looking_at_origin(0.3 + 0.02 * k) for k in range(count)])
    return Trajectory(np.arange(count) * 33_333_333, poses)


@pytest.mark.usefixtures("opengl")
def test_overlay_draws_the_character_where_the_camera_sees_it(
    figure: Character, placement: Placement
) -> None:
    frame = np.full((150, 200), 90, dtype=np.uint8)
    trajectory = path(2)
    drawn = list(
        render_overlay(
            [(0, frame), (33_333_333, frame)],
            CAMERA,
            trajectory,
            figure,
            figure.clip("idle"),
            placement,
        )
    )
    assert [image.shape for image in drawn] == [(150, 200, 3)] * 2
    changed = np.argwhere(np.any(drawn[0] > 110, axis=-1))
    corners = placement.apply(figure.vertices)
    expected = CAMERA.project(trajectory.poses[0].inverse().apply(corners))
    assert abs(changed[:, 0].min() - expected[:, 1].min()) < 4.0
    assert changed[:, 0].max() <= expected[:, 1].max() + 2.0
    assert np.any(drawn[0] < 60)  # the shadow


@pytest.mark.usefixtures("opengl")
def test_frames_without_a_pose_come_back_as_they_are(
    figure: Character, placement: Placement, rng: np.random.Generator
) -> None:
    frame = rng.integers(0, 256, (150, 200, 3), dtype=np.uint8)
    stamps = [-5, 0, 33_333_333, 33_333_334]
    drawn = list(
        render_overlay(
            ((t, frame) for t in stamps), CAMERA, path(2), figure, figure.clip("walk"), placement
        )
    )
    np.testing.assert_array_equal(drawn[0], frame)
    np.testing.assert_array_equal(drawn[3], frame)
    assert not np.array_equal(drawn[1], frame)


@pytest.mark.usefixtures("opengl")
def test_the_same_overlay_has_the_same_bytes(figure: Character, placement: Placement) -> None:
    frame = np.full((150, 200, 3), 120, dtype=np.uint8)
    runs = [
        list(
            render_overlay(
                ((k * 33_333_333, frame) for k in range(4)),
                CAMERA,
                path(4),
                figure,
                figure.clip("walk"),
                placement,
            )
        )
        for _ in range(2)
    ]
    for one, two in zip(*runs, strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.usefixtures("opengl")
def test_depth_in_front_hides_the_character(figure: Character, placement: Placement) -> None:
    frame = np.full((150, 200, 3), 120, dtype=np.uint8)
    near = np.full((150, 200), 0.2, dtype=np.float32)
    camera_T_ground = path(2).motors[0].inverse() @ placement.world_T_character
    far = np.minimum(ground_depth(CAMERA, camera_T_ground), 5.0).astype(np.float32)
    arguments = (CAMERA, path(2), figure, figure.clip("idle"), placement)
    hidden = next(render_overlay([(0, frame, near)], *arguments))
    shown = next(render_overlay([(0, frame, far)], *arguments))
    plain = next(render_overlay([(0, frame, None)], *arguments))
    np.testing.assert_array_equal(hidden, frame)
    np.testing.assert_array_equal(shown, plain)


@pytest.mark.usefixtures("opengl")
def test_a_sensors_ground_hides_no_foot_and_what_stands_on_it_takes_no_shadow(
    figure: Character, placement: Placement, rng: np.random.Generator
) -> None:
    """Ground measured a centimetre too high, with noise and holes; a wall; a table's edge."""
    frame = np.full((150, 200, 3), 120, dtype=np.uint8)
    frame[0, 0, 2] = 121  # of a camera with colour, so that the figure has some
    camera_T_ground = path(2).motors[0].inverse() @ placement.world_T_character
    ground = np.minimum(ground_depth(CAMERA, camera_T_ground), 5.0)
    arguments = (CAMERA, path(2), figure, figure.clip("idle"), placement)
    plain = next(render_overlay([(0, frame, None)], *arguments)).astype(int)
    eye_m = camera_T_ground.inverse().translation_m[2]
    height_m = placement.scale * figure.height_m
    noisy = ground * (1.0 - 0.02 * height_m / eye_m * rng.uniform(0.3, 1.7, ground.shape))
    noisy[rng.random(noisy.shape) < 0.1] = np.nan
    measured = next(render_overlay([(0, frame, noisy.astype(np.float32))], *arguments))
    assert np.abs(measured - plain).max() <= 3
    for away in (0.3, -0.3):
        other = ground * (1.0 - away * height_m / eye_m)
        other = np.where(rng.random(other.shape) < 0.1, np.nan, other).astype(np.float32)
        made = next(render_overlay([(0, frame, other)], *arguments)).astype(int)
        shadow = (plain.max(axis=2) < 110) & (np.ptp(plain, axis=2) == 0)
        assert np.count_nonzero(shadow) > 100
        assert np.median(made[shadow]) == 120


@pytest.mark.usefixtures("opengl")
def test_a_frame_of_another_size_is_refused(figure: Character, placement: Placement) -> None:
    frame = np.zeros((10, 10), dtype=np.uint8)
    with pytest.raises(ValueError, match="expected 200 x 150"):
        next(render_overlay([(0, frame)], CAMERA, path(2), figure, figure.clip("idle"), placement))


@pytest.mark.usefixtures("opengl")
def test_a_camera_inside_the_figure_or_under_the_ground_draws_what_it_can(
    figure: Character, placement: Placement
) -> None:
    frame = np.full((150, 200, 3), 120, dtype=np.uint8)
    inside = looking_at_origin(0.3)
    middle = placement.apply(np.array([[0.0, 0.0, 0.9]]))[0]
    for place in (middle, np.array([0.0, 0.3, -0.4]), placement.apply(np.zeros((1, 3)))[0]):
        pose = Motor.from_rotor_translation(inside.rotor, place)
        still = Trajectory(np.array([0, 10]), Motor.stack([pose, pose]))
        made = next(
            render_overlay([(0, frame)], CAMERA, still, figure, figure.clip("idle"), placement)
        )
        assert made.shape == frame.shape


@pytest.mark.usefixtures("opengl")
def test_a_bent_overlay_is_drawn_where_the_lens_shows_it(
    figure: Character, placement: Placement
) -> None:
    bent = replace(CAMERA, model="radtan", distortion=(-0.25, 0.06))
    frame = np.full((150, 200, 3), 90, dtype=np.uint8)
    straight, curved = (
        next(
            render_overlay(
                [(0, frame)],
                camera,
                path(2),
                figure,
                figure.clip("idle"),
                placement,
                look=ShadowLook(strength=0.0, contact=0.0),
            )
        )
        for camera in (CAMERA, bent)
    )
    straightened = bent.undistort_image(curved)
    inner = np.s_[20:130, 20:180]
    apart = np.abs(straightened[inner].astype(int) - straight[inner]).mean(axis=2)
    drawn = np.any(straight[inner] != 90, axis=2)
    assert apart[drawn].mean() < 12.0
    assert apart[~drawn].mean() < 1.0
    assert np.any(curved != straight)


def test_light_given_twice_is_refused(figure: Character, placement: Placement) -> None:
    light = character_lighting(placement, path(2).motors, 0.25, np.array([0.0, 0.0, -1.0]))
    with pytest.raises(ValueError, match="got both"):
        next(
            render_overlay(
                [],
                CAMERA,
                path(2),
                figure,
                figure.clip("idle"),
                placement,
                light_direction=(0, 0, -1),
                lighting=light,
            )
        )
    with pytest.raises(ValueError, match="got zeros"):
        next(
            render_overlay(
                [],
                CAMERA,
                path(2),
                figure,
                figure.clip("idle"),
                placement,
                light_direction=(0, 0, 0),
            )
        )
