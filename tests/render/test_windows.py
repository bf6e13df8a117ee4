"""What is drawn in a window of an image is what is drawn there in the whole of it."""

from typing import Any

import numpy as np
import pytest

from motorcade.animation import mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import render_overlay
from motorcade.render.lens import LensWarp, Window
from motorcade.render.scene import Layer
from motorcade.render.shadow import DARKENS, GRID, shade_extent, shade_in_image
from motorcade.render.shots import FilmStage
from motorcade.tracking.cameras.camera import Camera

CAMERAS = (
    Camera(160, 120, 110.0, 110.0, 79.0, 60.0),
    Camera(160, 120, 110.0, 110.0, 79.0, 60.0, "radtan", (-0.25, 0.05, 0.002, -0.001)),
    Camera(161, 123, 130.0, 120.0, 70.0, 66.0, "radtan", (0.2, 0.05, -0.01, 0.004)),
    Camera(150, 90, 140.0, 140.0, 74.0, 45.0, "equidistant", (0.02, -0.01, 0.0, 0.0)),
)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_window_holds_all_that_a_part_of_the_drawn_image_shows(
    camera: Camera, rng: np.random.Generator
) -> None:
    lens = LensWarp(camera)
    size = lens.pinhole.width, lens.pinhole.height
    layer = Layer(
        rng.integers(0, 256, (size[1], size[0], 4), dtype=np.uint8),
        rng.uniform(1.0, 2.0, (size[1], size[0])).astype(np.float32),
    )
    whole = lens.layer(layer)
    for k in range(40):
        corners = np.sort(rng.integers(0, size, (2, 2)) if k else [[0, 0], [0, 0]], axis=0)
        rows, columns = (
            slice(corners[0, 1], corners[1, 1] + 1),
            slice(corners[0, 0], corners[1, 0] + 1),
        )
        part = Layer(np.zeros_like(layer.rgba), np.zeros_like(layer.depth_m))
        part.rgba[rows, columns] = layer.rgba[rows, columns]
        window = lens.shown((corners[0], corners[1]))
        outside = np.ones((camera.height, camera.width), bool)
        outside[window] = False
        assert not lens.layer(part).rgba[outside].any()
        seen = lens.layer(layer, window)
        np.testing.assert_array_equal(seen.rgba, whole.rgba[window])
        np.testing.assert_array_equal(seen.depth_m, whole.depth_m[window])
        # Nothing but the part of the drawn image that shows there is looked at.
        first, last = lens.drawn(window)
        kept = np.s_[first[1] : last[1] + 1, first[0] : last[0] + 1]
        held = Layer(np.zeros_like(layer.rgba), np.zeros_like(layer.depth_m))
        held.rgba[kept] = layer.rgba[kept]
        np.testing.assert_array_equal(lens.layer(held, window).rgba, seen.rgba)


def looking(azimuth: float, tilt: float, distance_m: float) -> Motor:
    """A camera that looks at the origin's neighbourhood from above the ground."""
    turned = Rotor.from_rotation_vector([0.0, 0.0, azimuth]) @ Rotor.from_rotation_vector(
        [-np.pi / 2 - tilt, 0.0, 0.0]
    )
    back = turned.apply([0.0, 0.0, -distance_m])
    return Motor.from_rotor_translation(turned, back + np.array([0.0, 0.0, 0.05]))


@pytest.mark.parametrize("camera", CAMERAS)
def test_shade_darkens_nothing_outside_of_its_extent(
    camera: Camera, rng: np.random.Generator
) -> None:
    pinhole = LensWarp(camera).pinhole
    told = 0
    for _ in range(40):
        shade = np.zeros((GRID, GRID), np.float32)
        low = rng.integers(0, GRID - 20, 2)
        shade[low[0] : low[0] + 20, low[1] : low[1] + 20] = rng.uniform(0.0, 1.0, (20, 20))
        pose = looking(rng.uniform(0, 6.3), rng.uniform(0.05, 1.5), rng.uniform(0.3, 3.0)).inverse()
        whole = shade_in_image(shade, 0.8, pinhole, pose)
        assert whole is not None
        extent = shade_extent(shade, 0.8, pinhole, pose)
        assert extent is not None
        first, last = extent
        inside = np.s_[first[1] : last[1] + 1, first[0] : last[0] + 1]
        part = shade_in_image(shade, 0.8, pinhole, pose, extent)
        assert part is not None
        np.testing.assert_allclose(part[inside], whole[inside], atol=0.02)
        outside = whole.copy()
        outside[inside] = 0.0
        assert outside.max() <= DARKENS
        told += part.max() > 0.1 and inside != np.s_[: pinhole.height, : pinhole.width]
    assert told > 10
    assert shade_extent(np.zeros((GRID, GRID), np.float32), 0.8, pinhole, pose) is None


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("distance_m", [0.5, 3.0])
def test_an_overlay_in_its_window_is_that_of_the_whole_image(
    camera: Camera,
    distance_m: float,
    rng: np.random.Generator,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    who = mannequin()
    placed = place_on_plane(who, (0.1, 0.0), 0.4, height_m=0.5)
    path = Trajectory([0, 10**9], Motor.stack([looking(0.3, 0.6, distance_m)] * 2))
    frame = rng.integers(0, 256, (camera.height, camera.width, 3), dtype=np.uint8)

    def drawn() -> np.ndarray:
        clip = who.clip("idle")
        return next(render_overlay([(0, frame)], camera, path, who, clip, placed))

    windows: list[Window] = []
    found = FilmStage._window

    def noted(*given: Any) -> Window:
        windows.append(found(*given))
        return windows[-1]

    monkeypatch.setattr(FilmStage, "_window", noted)
    in_window = drawn()
    all_of_it = slice(0, camera.height), slice(0, camera.width)
    monkeypatch.setattr(FilmStage, "_window", lambda *given: all_of_it)
    differing = np.abs(in_window.astype(int) - drawn())
    # Where the plane is sampled may be told by a last bit more or less.
    assert differing.max() <= 1
    assert np.count_nonzero(differing) < 1e-3 * frame.size
    assert np.count_nonzero(in_window != frame) > 200
    assert (windows[0] == all_of_it) is (distance_m < 1.0)
