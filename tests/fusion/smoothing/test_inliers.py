"""The longest smooth chain of poses: the one that trying all joints finds, whatever is wrong."""

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers, PlanarFlips
from motorcade.fusion.smoothing.batch.inliers import Sizes, inlier_poses
from motorcade.fusion.smoothing.batch.start import first_sizes
from motorcade.ga import Motor
from tests.fusion.smoothing.chain_witness import witnessed_chain

NOISE = Gaussian(0.005, np.deg2rad(0.5))


@pytest.mark.parametrize("count", [3, 4, 5, 8, 16, 200])
@pytest.mark.parametrize("share", [0.0, 0.05, 0.3])
def test_it_is_the_witness_s(count: int, share: float, rng: np.random.Generator) -> None:
    true = MOTIONS["handheld"].sampled(30.0, (count - 1) / 30.0)
    for _ in range(5):
        path = Outliers(share, 0.3, 0.5).apply(NOISE.apply(true, rng), rng)
        path = PlanarFlips(share).apply(path, rng) if count > 16 else path
        sizes = first_sizes(path) if count > 4 else (Sizes(0.01, 0.6), Sizes(0.005, 0.3))
        given = path.time_s, path.motors, *sizes
        assert np.array_equal(inlier_poses(*given), witnessed_chain(*given))


@pytest.mark.parametrize("first", [0, 80, 185])
def test_a_run_that_agrees_with_itself_is_left_out(first: int, rng: np.random.Generator) -> None:
    true = MOTIONS["handheld"].sampled(30.0, 199 / 30.0)
    coefficients = np.array(NOISE.apply(true, rng).motors.coefficients)
    run = slice(first, first + 15)
    coefficients[run] = (
        Motor.from_translation([0.5, 0.0, 0.0]) @ Motor(coefficients[run])
    ).coefficients
    kept = inlier_poses(true.time_s, Motor(coefficients), Sizes(0.01, 0.6), Sizes(0.005, 0.3))
    assert np.flatnonzero(~kept).tolist() == list(range(run.start, run.stop))


def test_one_pose_or_two_belong_to_it() -> None:
    for count in (0, 1, 2):
        poses = Motor.identity((count,))
        kept = inlier_poses(np.arange(count) / 30.0, poses, Sizes(0.01, 0.6), Sizes(0.005, 0.3))
        assert kept.tolist() == [True] * count
