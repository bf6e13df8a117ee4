"""Drawn images bent, blurred, brightened and made noisy as the footage is."""

from typing import Any

import cv2
import numpy as np
import pytest
from skimage.color import rgb2xyz, xyz2rgb

from motorcade.animation import Placement, mannequin
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import render_overlay
from motorcade.render.composite import (
    Matching,
    blended,
    darken,
    exposed,
    frame_noise,
    greyed,
    is_grey,
    noisy,
    stored_ends,
)
from motorcade.render.lens import LensWarp, warped
from motorcade.render.scene import Layer
from motorcade.tracking.cameras.camera import Camera

BENT = Camera(160, 120, 110.0, 110.0, 79.0, 60.0, "radtan", (-0.25, 0.05, 0.002, -0.001))


def dotted(camera: Camera, point_px: np.ndarray) -> Layer:
    """A soft dot around a pixel, drawn as a layer."""
    y, x = np.mgrid[: camera.height, : camera.width]
    square = (x - point_px[0]) ** 2 + (y - point_px[1]) ** 2
    alpha = np.rint(255.0 * np.exp(-square / 8.0)).astype(np.uint8)
    depth = np.where(alpha > 0, 2.0, 0.0).astype(np.float32)
    return Layer(np.repeat(alpha[..., None], 4, axis=2), depth)


def test_a_bent_layer_shows_points_where_the_lens_does() -> None:
    lens = LensWarp(BENT)
    for ray in ([-0.5, -0.4, 1.0], [0.0, 0.0, 1.0], [0.55, 0.3, 1.0], [0.3, -0.45, 1.0]):
        bent = lens.layer(dotted(lens.pinhole, lens.pinhole.project(ray)))
        weight = bent.rgba[..., 3].astype(float)
        y, x = np.mgrid[: BENT.height, : BENT.width]
        middle = np.array([np.sum(weight * x), np.sum(weight * y)]) / weight.sum()
        np.testing.assert_allclose(middle, BENT.project(ray), atol=0.2)


def test_the_pinhole_image_holds_every_bent_pixel() -> None:
    lens = LensWarp(BENT)
    full = np.full((lens.pinhole.height, lens.pinhole.width), 1.0, np.float32)
    np.testing.assert_allclose(lens.smooth(full), 1.0, atol=1e-6)


def test_a_camera_without_distortion_changes_nothing() -> None:
    plain = BENT.undistorted()
    lens = LensWarp(plain)
    layer = dotted(plain, np.array([50.0, 60.0]))
    assert lens.layer(layer) is layer


@pytest.mark.parametrize(
    "camera",
    [
        Camera(200, 160, 64.0, 64.0, 99.5, 79.5, "equidistant", (0.0, 0.0, 0.0, 0.0)),
        Camera(200, 160, 120.0, 120.0, 99.5, 79.5, "radtan", (-0.5, 0.0)),
    ],
    ids=["too wide", "folds"],
)
def test_pixels_without_a_use_are_never_drawn_into_and_all_others_are(camera: Camera) -> None:
    lens = LensWarp(camera)
    size = lens.pinhole.height, lens.pinhole.width
    assert size[0] <= 3 * camera.height + 4
    assert size[1] <= 3 * camera.width + 4
    full = Layer(np.full((*size, 4), 255, np.uint8), np.ones(size, np.float32))
    shown = lens.layer(full)
    y, x = np.mgrid[: camera.height, : camera.width]
    seen = camera.undistort(np.stack([x, y], axis=-1))
    far = np.abs(seen - (camera.cx, camera.cy)) / (camera.width, camera.height)
    usable = np.all(far < 1.5, axis=-1)
    assert 0.3 < np.mean(usable) < 0.99
    assert lens.drawable == np.mean(usable)
    np.testing.assert_array_equal(shown.rgba[..., 3], np.where(usable, 255, 0))
    np.testing.assert_array_equal(shown.depth_m, np.where(usable, 1.0, 0.0))
    window = lens.shown((np.zeros(2, int), np.array(size[::-1]) - 1))
    assert np.count_nonzero(usable[window]) == np.count_nonzero(usable)
    corner = slice(0, 2), slice(0, 2)  # a window of such pixels alone
    assert not usable[corner].any()
    assert not lens.smooth(np.ones(size, np.float32), corner).any()
    lens.drawn(corner)


def test_twice_the_light_is_twice_the_light() -> None:
    layer = Layer(np.full((4, 4, 4), 255, dtype=np.uint8), np.ones((4, 4), dtype=np.float32))
    layer.rgba[..., :3] = 90
    shown = exposed(layer, 2.0).rgba[..., :3]
    np.testing.assert_allclose(
        to_linear(shown / 255.0) / to_linear(np.array(90 / 255.0)), 2.0, rtol=0.01
    )
    assert exposed(layer, 1000.0).rgba[..., :3].max() == 255
    half = Layer(layer.rgba // 2, layer.depth_m)
    assert exposed(half, 1000.0).rgba[..., :3].max() == 127  # never more than its alpha


def test_motion_blur_is_the_mean_over_the_exposure() -> None:
    moments = Matching(exposure_s=0.02).moments_ns(1_000_000_000)
    assert moments.mean() == 1_000_000_000
    assert abs(int(moments[-1] - moments[0]) - 0.02e9 * 6 / 7) < 2
    np.testing.assert_array_equal(Matching().moments_ns(5), [5])
    layers = [dotted(BENT, np.array([60.0 + k, 50.0])) for k in range(7)]
    mixed = blended(layers)
    expected = np.mean([layer.rgba for layer in layers], axis=0)
    np.testing.assert_allclose(mixed.rgba, expected, atol=0.5)
    assert np.all((mixed.depth_m > 0.0) == np.any([one.depth_m > 0 for one in layers], axis=0))


def test_noise_is_measured_and_made_as_strong_as_said(rng: np.random.Generator) -> None:
    y, x = np.mgrid[:240, :320]
    plain = np.repeat((60 + 0.3 * x + 0.2 * y)[..., None], 3, axis=2)
    grain = rng.normal(0.0, 4.0, (240, 320, 1))
    seen = np.clip(np.rint(plain + grain), 0, 255).astype(np.uint8)
    assert frame_noise(seen) == pytest.approx(4.0, rel=0.1)
    smooth = np.rint(plain).astype(np.uint8)
    assert frame_noise(cv2.GaussianBlur(smooth, (0, 0), 2)) < 0.6
    alpha = np.zeros((240, 320))
    alpha[:, 160:] = 1.0
    made = noisy(smooth, alpha, 4.0, rng)
    np.testing.assert_array_equal(made[:, :160], smooth[:, :160])
    assert (made[:, 160:].astype(float) - smooth[:, 160:]).std() == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"gain": 0.0}, "gain"),
        ({"exposure_s": -1.0}, "exposure_s"),
        ({"noise": np.nan}, "noise"),
        ({"ends": (200, 100)}, "ends"),
    ],
)
def test_matching_that_means_nothing_is_refused(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=f"Matching.{told}"):
        Matching(**settings)


def test_a_warped_image_moves_by_whole_pixels_exactly_and_repeats_its_edge(
    rng: np.random.Generator,
) -> None:
    image = rng.integers(0, 256, (30, 40), dtype=np.uint8)
    moved = warped(image, np.array([[1.0, 0.0, 3.0], [0.0, 1.0, -2.0], [0.0, 0.0, 1.0]]))
    np.testing.assert_array_equal(moved[:28, 3:], image[2:, :37])
    np.testing.assert_array_equal(moved[:28, 0], image[2:, 0])


def test_what_is_drawn_into_grey_footage_has_no_colour(rng: np.random.Generator) -> None:
    rgba = rng.integers(0, 200, (20, 30, 4), dtype=np.uint8)
    rgba[..., 3] = 255
    grey = greyed(Layer(rgba, np.ones((20, 30), np.float32))).rgba
    np.testing.assert_array_equal(grey[..., 0], grey[..., 2])
    luma = rgba[..., :3] @ [0.2126, 0.7152, 0.0722]  # Rec. 709
    np.testing.assert_allclose(grey[..., 1], luma, atol=1.0)
    assert is_grey(grey[..., :3])
    assert not is_grey(rgba[..., :3])


@pytest.mark.parametrize("share", [0.01, 0.3, 0.77])
def test_darkening_takes_that_share_of_light(share: float) -> None:
    frame = np.arange(256, dtype=np.uint8).repeat(3).reshape(16, 16, 3)
    left = darken(frame, np.full((16, 16), share))
    # skimage's curves are the witness
    expected = rgb2xyz(frame / 255.0) * (1.0 - share)
    np.testing.assert_allclose(left, 255.0 * xyz2rgb(expected), atol=0.85)


def test_what_is_overexposed_is_darkened_from_the_light_that_it_has() -> None:
    frame = np.array([[[0, 120, 255]]], np.uint8)
    dark = [darken(frame, np.full((1, 1), share), white=1.5)[0, 0] for share in (0.3, 0.5)]
    plain = [darken(frame, np.full((1, 1), share))[0, 0] for share in (0.3, 0.5)]
    assert dark[0][2] == 255  # 1.05 of what an image can show
    assert to_linear(dark[1][2] / 255.0) == pytest.approx(0.75, abs=0.01)
    np.testing.assert_array_equal([one[:2] for one in dark], [one[:2] for one in plain])


def test_what_is_drawn_is_stored_between_the_footages_own_ends(rng: np.random.Generator) -> None:
    scene = rng.normal(0.5, 0.3, (60, 80, 3))
    limited = np.clip(np.rint(16 + 219 * scene + rng.normal(0.0, 0.7, scene.shape)), 14, 237)
    black, white = stored_ends([np.clip(limited, 15, 236).astype(np.uint8)])
    assert 14 <= black <= 17
    assert 233 <= white <= 237
    full = np.clip(rng.normal(120.0, 25.0, (60, 80, 3)), 0, 255).astype(np.uint8)
    assert stored_ends([full]) == (0, 255)  # nothing piles up
    layer = Layer(np.full((2, 2, 4), 255, np.uint8), np.ones((2, 2), np.float32))
    layer.rgba[0, :, :3], layer.rgba[1, 1] = 0, (127, 127, 127, 127)
    shown = exposed(layer, 1.0, (16, 235)).rgba[..., 0]
    np.testing.assert_array_equal(shown, [[16, 16], [235, 117]])


@pytest.mark.usefixtures("opengl")
def test_a_figure_that_no_frame_shows_is_told(caplog: pytest.LogCaptureFixture) -> None:
    figure, plain = mannequin(), BENT.undistorted()
    path = Trajectory(np.array([0, 10**9]), Motor.stack([Motor.identity()] * 2), "world", "camera")
    frames = [(0, np.zeros((plain.height, plain.width, 3), np.uint8))]
    for depth_m, told in ((-5.0, 1), (5.0, 0)):
        caplog.clear()
        stand = Motor.from_rotor_translation(
            Rotor.from_euler([0.5 * np.pi, 0.0, 0.0]), np.array([0.0, 1.0, depth_m])
        )
        list(render_overlay(frames, plain, path, figure, figure.clips[0], Placement(stand, 1.0)))
        assert sum("no figure shows a pixel" in one for one in caplog.messages) == told
