"""The loop against SciPy, eliminated blocks against the dense system, losses against slopes."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import project, reproject
from motorcade.tracking.optimise import (
    BlockEquations,
    NormalEquations,
    Stop,
    huber,
    huber_cauchy,
    minimise,
    pair_sums,
)

TIMES = np.linspace(0.0, 3.0, 40)


def curve(numbers: np.ndarray) -> np.ndarray:
    return numbers[0] * np.exp(-numbers[1] * TIMES) + numbers[2]


class Decay:
    """Noisy samples of a decay with outliers, under Huber's loss."""

    def __init__(self, samples: np.ndarray, at: np.ndarray) -> None:
        residuals = curve(at) - samples
        loss, weight = huber(np.abs(residuals), 0.1)
        self.cost = float(loss.sum())
        faded = np.exp(-at[1] * TIMES)
        jacobian = np.stack([faded, -at[0] * TIMES * faded, np.ones_like(TIMES)], axis=-1)
        self.equations = NormalEquations.of(jacobian, residuals, weight)


def test_it_finds_scipys_minimum_of_a_robust_loss(rng: np.random.Generator) -> None:
    samples = curve(np.array([2.0, 1.3, 0.5])) + rng.normal(0.0, 0.05, len(TIMES))
    samples[::9] += 3.0
    start = np.array([1.0, 0.5, 0.0])
    ours = minimise(start, lambda at: Decay(samples, at), np.add, Stop(steps=200, gain=1e-15))
    theirs = least_squares(
        lambda at: curve(at) - samples, start, loss="huber", f_scale=0.1, xtol=1e-14, ftol=1e-14
    )
    np.testing.assert_allclose(ours.state, theirs.x, atol=1e-5)
    assert ours.evaluation.cost == pytest.approx(theirs.cost)
    assert ours.evaluation.cost < ours.start_cost


def test_a_start_without_slope_stays_where_it_is() -> None:
    class Flat:
        def __init__(self, at: np.ndarray) -> None:
            self.cost = 1.0
            self.equations = NormalEquations(np.zeros((2, 2)), np.zeros(2))

    assert np.array_equal(minimise(np.ones(2), Flat, np.add, Stop()).state, np.ones(2))


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_eliminated_blocks_give_the_step_of_the_dense_system(
    rng: np.random.Generator, damping: float
) -> None:
    groups, width, blocks, size = 3, 2, 300, 3
    count = groups * width + blocks * size
    jacobian = np.zeros((2000, count))
    block_of, group_of = rng.integers(0, blocks, 2000), rng.integers(0, groups, 2000)
    for row in range(2000):
        at = groups * width + size * block_of[row]
        jacobian[row, at : at + size] = rng.normal(size=size)
        at = width * group_of[row]
        jacobian[row, at : at + width] = rng.normal(size=width)
    dense = NormalEquations.of(jacobian, rng.normal(size=2000))
    kept = groups * width
    own = dense.information[kept:, kept:].reshape(blocks, size, blocks, size)
    cross = dense.information[kept:, :kept].reshape(blocks, size, groups, width)
    rows, columns, _ = pair_sums(np.zeros(2000), block_of, group_of)
    every = np.arange(blocks)
    equations = BlockEquations(
        dense.information[:kept, :kept],
        dense.gradient[:kept],
        own[every, :, every],
        dense.gradient[kept:].reshape(blocks, size),
        rows,
        columns,
        cross[rows, :, columns],
    )
    one, other = equations.step(damping)
    step = np.concatenate([one.ravel(), other.ravel()])
    np.testing.assert_allclose(step, dense.step(damping), atol=1e-6)
    marginal = np.linalg.inv(dense.information)[:kept, :kept]
    np.testing.assert_allclose(
        np.linalg.inv(equations.reduced_information), marginal, rtol=1e-5, atol=1e-8
    )


def test_weights_are_the_losses_slopes() -> None:
    size = np.linspace(0.05, 12.0, 100)
    for loss in (lambda at: huber(at, 1.5), lambda at: huber_cauchy(at, 1.5, 3.0)):
        slope = (loss(size + 1e-6)[0] - loss(size - 1e-6)[0]) / 2e-6
        np.testing.assert_allclose(slope, loss(size)[1] * size, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(
    "camera",
    [
        Camera(640, 480, 400.0, 410.0, 320.0, 240.0),
        Camera(640, 480, 400.0, 410.0, 320.0, 240.0, "radtan", (-0.2, 0.05, 1e-3, -1e-3)),
        Camera(640, 480, 300.0, 300.0, 320.0, 240.0, "equidistant", (0.02, -0.01, 0.0, 0.0)),
    ],
)
def test_derivatives_are_those_of_differences(camera: Camera, rng: np.random.Generator) -> None:
    pose = Motor.random(rng, (), 0.5)
    points = pose.apply(rng.uniform((-1.0, -1.0, 2.0), (1.0, 1.0, 5.0), (20, 3)))
    in_camera = pose.inverse().apply(points)
    pixels, by_twist, by_point = reproject(camera, in_camera)
    np.testing.assert_allclose(pixels, project(camera, pose, points)[0])
    for axis, step in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (project(camera, pose.retract(one), points)[0] for one in (step, -step))
        np.testing.assert_allclose(by_twist[..., axis], (ahead - behind) / 2e-6, atol=1e-4)
    for axis, step in enumerate(1e-6 * np.eye(3)):
        slope = (camera.project(in_camera + step) - camera.project(in_camera - step)) / 2e-6
        np.testing.assert_allclose(by_point[..., axis], slope, atol=1e-4)
