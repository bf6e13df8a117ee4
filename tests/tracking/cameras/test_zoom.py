"""Images of a lens that zooms, scaled to one focal length about its centre, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.render.lens import LensWarp
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import Zoom

CAMERA = Camera(160, 120, 100.0, 100.0, 79.0, 61.0)


@pytest.mark.parametrize("ratio", [0.7, 1.0, 1.8])
def test_a_point_lies_where_the_cameras_own_focal_length_shows_it(ratio: float) -> None:
    columns, rows = np.meshgrid(np.arange(160), np.arange(120))
    point = np.array([90.0, 50.0])
    far = (columns - point[0]) ** 2 + (rows - point[1]) ** 2
    image = np.asarray(255.0 * np.exp(-far / 18.0), np.uint8)
    shown = Zoom(np.zeros(1), np.array([ratio])).unzoomed(image, CAMERA, 0).astype(float)
    middle = np.array([(shown * columns).sum(), (shown * rows).sum()]) / shown.sum()
    centre = np.array([CAMERA.cx, CAMERA.cy])
    np.testing.assert_allclose(middle, centre + (point - centre) / ratio, atol=0.05)


@pytest.mark.parametrize("ratio", [1.3, 2.0])
def test_a_zoomed_lens_draws_as_the_lens_of_that_focal_length(ratio: float) -> None:
    bent = replace(CAMERA, model="radtan", distortion=(-0.2, 0.03, 0.0, 0.0))
    longer = LensWarp(bent).zoomed(ratio)
    truth = replace(bent, fx=ratio * bent.fx, fy=ratio * bent.fy)
    columns, rows = np.meshgrid(np.arange(8, 152, 8), np.arange(8, 112, 8))
    px = np.stack([columns, rows], axis=-1)
    rays = (truth.undistort(px.astype(float)) - (truth.cx, truth.cy)) / truth.fx
    drawn = longer._source[rows, columns] - (longer.pinhole.cx, longer.pinhole.cy)
    np.testing.assert_allclose(drawn / longer.pinhole.fx, rays, atol=2e-3)
    assert longer.camera == truth
    assert (longer.pinhole.width, longer.pinhole.height) == (
        LensWarp(bent).pinhole.width,
        LensWarp(bent).pinhole.height,
    )


def test_times_that_do_not_rise_and_ratios_of_zero_are_refused() -> None:
    with pytest.raises(ValueError, match=r"Zoom\.time_s: expected rising"):
        Zoom(np.array([1.0, 1.0]), np.ones(2))
    with pytest.raises(ValueError, match=r"Zoom\.ratio: expected 2 numbers above 0"):
        Zoom(np.arange(2.0), np.array([1.0, 0.0]))
