"""A lens that zooms within a clip is followed from frame to frame, and no other is said to zoom."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera, Checkerboard, self_calibrate_board
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.self_calibration import choosing

SIZE, FRAMES = (640, 480), 100
BOARD = Checkerboard(7, 5, 1.0)
NOISE_PX = 0.08  # twice what fits of boards in drawn images leave


def _eased(low: float, high: float, share: FloatArray) -> FloatArray:
    x = np.clip((share - low) / (high - low), 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))


PROFILES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "even": lambda u: u,
    "eased": lambda u: _eased(0.0, 1.0, u),
    "held before and after": lambda u: _eased(0.3, 0.7, u),
    "out": lambda u: 1.0 - _eased(0.2, 0.8, u),
    "in and out": lambda u: _eased(0.1, 0.5, u) - _eased(0.5, 0.9, u),
    "late": lambda u: _eased(0.6, 1.0, u),
    "none": lambda u: 0.0 * u,
}


def clip(seed: int, profile: str) -> tuple[list[BoardCorners | None], FloatArray]:
    """A board held before a camera whose focal length doubles, and that of each frame."""
    rng = np.random.default_rng(seed)
    first, phases = rng.uniform(420.0, 700.0), rng.uniform(0.0, 6.0, 3)
    focals = first * 2.0 ** PROFILES[profile](np.linspace(0.0, 1.0, FRAMES))
    face_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    views: list[BoardCorners | None] = []
    for frame, focal in enumerate(focals):
        camera, step = Camera(*SIZE, focal, focal, 319.5, 239.5), 0.1 * frame
        sway = 0.45 * np.sin([step + phases[0], 0.8 * step + phases[1], 0.5 * step + phases[2]])
        turn = Rotor.from_rotation_vector(sway) @ face_down
        middle = turn.apply(BOARD.points_m.mean(axis=0))
        away = 0.044 * first * (1.0 + 0.2 * np.sin(0.6 * step))
        pose = Motor.from_rotor_translation(turn, [0.0, 0.0, away] - middle)
        px = camera.project(pose.apply(BOARD.points_m))
        noisy = px + NOISE_PX * rng.standard_normal(px.shape)
        views.append(BoardCorners(np.arange(len(px)), noisy, BOARD.points_m))
    return views, focals


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "profile"), list(enumerate(PROFILES))[:-1])
def test_a_zoom_is_followed_to_two_per_cent_in_every_frame(seed: int, profile: str) -> None:
    views, focals = clip(seed, profile)
    stamps = 5_000_000_000 + 33_333_333 * np.arange(FRAMES)
    calibrated = self_calibrate_board(views, SIZE, stamps)
    assert calibrated.zoom is not None
    followed = calibrated.camera.fx * calibrated.zoom.at(stamps)
    assert np.abs(followed / focals - 1.0).max() < 0.02
    assert calibrated.zoom.ratio.min() == pytest.approx(1.0)
    assert calibrated.sigma_focal < 0.03
    assert calibrated.doubts[0].startswith("the lens zooms from ")


@pytest.mark.slow
@pytest.mark.parametrize("profile", ["even", "late"])
def test_a_zoom_that_is_not_followed_is_named(
    profile: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(choosing, "follow_zoom", lambda *_: None)
    views, _ = clip(21, profile)
    calibrated = self_calibrate_board(views, SIZE, 33_333_333 * np.arange(FRAMES))
    assert calibrated.zoom is None
    assert "the lens zooms, and one camera is right in hardly any frame" in calibrated.doubts[0]
    assert calibrated.sigma_focal > 0.15


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4, 13, 14])
def test_one_focal_length_is_no_zoom(seed: int) -> None:
    views, _ = clip(seed, "none")
    calibrated = self_calibrate_board(views, SIZE, 33_333_333 * np.arange(FRAMES))
    assert calibrated.zoom is None
    assert not any("within the shot" in doubt for doubt in calibrated.doubts)
    assert calibrated.sigma_focal < 0.02
