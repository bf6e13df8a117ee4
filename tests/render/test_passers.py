"""Who walks in front hides a figure and takes its shade; who stands behind it does not."""

import numpy as np
import pytest

from motorcade.animation import mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import render_overlay
from motorcade.replays.io.recording import ImageArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.masks import fill_masked, refine_mask, standing_depth

CAMERA = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
POSE = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([-1.9, 0.0, 0.0]), [0.0, -3.0, 1.4]
)  # looks along the world's y, and down
PATH = Trajectory(np.array([0, 10**9]), Motor.stack([POSE, POSE]), "world", "camera")
FOOTAGE = np.random.default_rng(2).integers(90, 160, (120, 160, 3)).astype(np.uint8)


def drawn(mask: ImageArray | None, depth_m: np.ndarray | None = None) -> ImageArray:
    """A film's image of a figure in the middle."""
    body = mannequin()
    place = place_on_plane(body, (0.0, 0.0), -1.57, height_m=1.0)
    frames = [(0, FOOTAGE, depth_m, mask)]
    return next(iter(render_overlay(frames, CAMERA, PATH, body, body.clip("idle"), place)))


def passer(foot_px: int, cut: bool = False) -> ImageArray:
    """Somebody whose feet are at a row, over the middle of the figure."""
    mask = np.zeros((120, 160), np.uint8)
    mask[20 : 120 if cut else foot_px, 74:90] = 255
    return mask


def test_who_stands_nearer_hides_the_figure_and_its_shade() -> None:
    alone, mask = drawn(None), passer(110)
    changed = np.any(alone != FOOTAGE, axis=2)
    assert np.count_nonzero(changed & (mask > 0)) > 200
    film = drawn(mask)
    np.testing.assert_array_equal(film[mask > 0], FOOTAGE[mask > 0])  # no grain either
    np.testing.assert_allclose(film[mask == 0].astype(int), alone[mask == 0], atol=12)
    np.testing.assert_array_equal(drawn(passer(110, cut=True))[:, 74:90], FOOTAGE[:, 74:90])


def test_who_stands_behind_hides_nothing_but_takes_no_shade() -> None:
    foot = CAMERA.project(POSE.inverse().apply([0.0, 0.8, 0.0]))[1]
    mask = passer(round(float(foot)))
    film, alone = drawn(mask).astype(int), drawn(None).astype(int)
    figure = np.abs(alone - FOOTAGE).max(axis=2) > 60
    assert np.count_nonzero(figure & (mask > 0)) > 50
    assert np.abs(film - alone)[figure & (mask > 0)].max() < 12


def test_depth_tells_who_is_behind() -> None:
    mask = passer(110, cut=True)
    behind, before = (np.where(mask > 0, m, np.nan).astype(np.float32) for m in (6.0, 1.0))
    assert np.any(drawn(mask, behind)[mask > 0] != FOOTAGE[mask > 0])
    np.testing.assert_array_equal(drawn(mask, before)[mask > 0], FOOTAGE[mask > 0])


@pytest.mark.parametrize("away_m", [0.5, 2.0, 5.0])
def test_where_somebody_stands_is_where_the_feet_meet_the_ground(away_m: float) -> None:
    foot = POSE.inverse().apply([0.0, away_m - 3.0 + 1.5, 0.0])
    row = float(CAMERA.project(foot)[1])
    mask = np.zeros((120, 160), np.uint8)
    mask[10 : round(row) + 1, 70:90] = 255
    if row < 117.0:
        far_m = standing_depth(mask, CAMERA, POSE.inverse(), None)
        assert far_m[20, 80] == pytest.approx(foot[2], rel=0.05)
        assert np.isinf(far_m[5, 10])


@pytest.mark.parametrize("grown_px", [-2, 0, 2])
def test_an_edge_goes_where_the_colours_change(grown_px: int) -> None:
    rng = np.random.default_rng(4)
    rows, columns = np.mgrid[:120, :320]
    away = np.hypot(rows - 60.0, columns - 160.0)
    truth, given = away < 40.0, away < 40.0 + grown_px
    image = np.where(truth[..., None], [180, 90, 60], [60, 100, 120])
    image = np.clip(image + rng.normal(0.0, 4.0, image.shape), 0, 255).astype(np.uint8)
    refined = refine_mask((255 * given).astype(np.uint8), image) >= 128
    assert np.count_nonzero(refined != truth) < 0.05 * 2.0 * np.pi * 40.0
    flat = np.full_like(image, 100)
    np.testing.assert_array_equal(refine_mask((255 * given).astype(np.uint8), flat) > 0, given)


def test_what_fills_a_mask_is_as_smooth_as_a_wall() -> None:
    image = np.random.default_rng(3).integers(80, 120, (120, 160)).astype(np.uint8)
    image[30:90, 50:100] = 255 * (np.indices((60, 50)).sum(axis=0) % 2)
    mask = np.zeros((120, 160), np.uint8)
    mask[30:90, 50:100] = 200
    filled = fill_masked(image, mask)
    assert np.ptp(filled[40:80, 60:90].astype(int)) < 12
    np.testing.assert_array_equal(filled[:20], image[:20])
