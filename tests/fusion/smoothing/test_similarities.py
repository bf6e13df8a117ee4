"""Paths with a scale are smoothed as paths with a scale, and rigid ones stay rigid."""

import numpy as np
import pytest

from motorcade.fusion.smoothing import smooth
from motorcade.ga import Similarity, Trajectory
from motorcade.ga.arrays import IntArray

SCREW = np.array([0.3, 1.0, 0.5, 0.1, 0.2, -0.4])


def uneven(rng: np.random.Generator, count: int) -> IntArray:
    return np.cumsum(rng.integers(5_000_000, 60_000_000, count)).astype(np.int64)


@pytest.mark.parametrize("method", ["gaussian", "savitzky_golay", "local_polynomial"])
def test_similarities_are_smoothed_with_their_scale(method: str, rng: np.random.Generator) -> None:
    """A constant spiral stays; the tangent of similarities bends no scale."""
    time_ns = uneven(rng, 100)
    spiral = np.append(SCREW, 0.2) * (time_ns * 1e-9)[:, None]
    path = Trajectory(time_ns, Similarity.from_twist(spiral))
    found = smooth(path, method, "similarity")
    assert isinstance(found.poses, Similarity)
    assert np.abs((path.poses.inverse() @ found.poses).as_twist()).max() < 1e-10
    beside = smooth(path, method, "motor")
    assert isinstance(beside.poses, Similarity)
    np.testing.assert_allclose(beside.poses.scale, path.poses.scale, rtol=0.02)
