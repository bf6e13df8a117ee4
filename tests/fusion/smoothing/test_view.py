"""A steadied view: turned on the spot, one place even in it, and the footage moved with it."""

import numpy as np
import pytest

from motorcade.fusion.smoothing.view import steady_view, turned_homography
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

N = 120
PLACE = np.array([0.1, -0.05, 1.2])
MATRIX = np.array([[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]])


@pytest.fixture
def path(rng: np.random.Generator) -> Trajectory:
    """A slow sweep with the tremor of a hand."""
    t = np.arange(N) / 30.0
    sweep = np.zeros((N, 6))
    sweep[:, 1], sweep[:, 3] = 0.1 * np.sin(0.8 * t), 0.1 * np.cos(0.6 * t)
    tremor = rng.normal(0.0, 1.0, (N, 6)) * [0.002, 0.002, 0.002, 0.0003, 0.0003, 0.0003]
    stamps = np.rint(1e9 * t).astype(np.int64)
    return Trajectory(stamps, Motor.exp(sweep) @ Motor.exp(tremor))


def pixels(path: Trajectory, point: FloatArray) -> FloatArray:
    seen = path.motors.inverse().apply(point) @ MATRIX.T
    return np.asarray(seen[:, :2] / seen[:, 2:])


def jitter(seen: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.diff(seen, 3, axis=0) ** 2)))


@pytest.mark.parametrize(("live", "share"), [(False, 0.25), (True, 0.45)])
def test_the_place_moves_evenly_and_the_camera_stays_where_it_was(
    path: Trajectory, live: bool, share: float
) -> None:
    view = steady_view(path, PLACE, live=live)
    np.testing.assert_allclose(view.motors.translation_m, path.motors.translation_m, atol=1e-14)
    assert jitter(pixels(view, PLACE)) < share * jitter(pixels(path, PLACE))


def test_the_homography_moves_points_of_any_depth_to_where_the_view_sees_them(
    path: Trajectory, rng: np.random.Generator
) -> None:
    """Projected by hand: both ways through the camera's matrix."""
    view = steady_view(path, PLACE)
    turns = turned_homography(MATRIX, path.motors.rotor, view.motors.rotor)
    for _ in range(5):
        point = PLACE + rng.uniform(-0.4, 0.4, 3)
        taken = np.pad(pixels(path, point), ((0, 0), (0, 1)), constant_values=1.0)
        moved = np.einsum("nij,nj->ni", turns, taken)
        np.testing.assert_allclose(moved[:, :2] / moved[:, 2:], pixels(view, point), atol=1e-8)


def test_the_live_view_does_not_look_ahead(path: Trajectory) -> None:
    early = Trajectory(path.time_ns[:60], path.motors[:60])
    np.testing.assert_allclose(
        steady_view(early, PLACE, live=True).motors.coefficients,
        steady_view(path, PLACE, live=True).motors.coefficients[:60],
        atol=1e-12,
    )


def test_refusals(path: Trajectory) -> None:
    with pytest.raises(ValueError, match="three poses or more, got 2"):
        steady_view(Trajectory(path.time_ns[:2], path.motors[:2]), PLACE)
    with pytest.raises(ValueError, match="before all cameras"):
        steady_view(path, [0.0, 0.0, -1.0])
