"""Covariances of the filter stay symmetric and positive, however long it runs."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.filter import PoseFilter
from motorcade.fusion.imu import ADIS16448
from motorcade.ga import Motor

GRAVITY = np.array([0.0, 0.0, 9.81])


def check_covariances(seconds: float, rng: np.random.Generator) -> None:
    """Fast jittering at 200 Hz, a pose now and then: covariances stay what covariances are."""
    count = int(seconds * 200)
    stamps = np.arange(count, dtype=np.int64) * 5_000_000
    rate = rng.normal(0.0, 2.0, (count, 3))
    force = rng.normal(GRAVITY, 5.0, (count, 3))
    stream = PoseFilter(ADIS16448)
    tight = 1e-8 * np.eye(6)
    stream.imu(0, rate[0], force[0])
    stream.pose(0, Motor.identity(), tight)
    for start in range(1, count, 2000):
        part = slice(start, start + 2000)
        stream._engine.samples(stamps[part], rate[part], force[part])
        found = stream.state
        if start % 20_000 == 1:
            stream.pose(found.time_ns, found.world_T_imu, tight)
        covariance = stream.state.covariance
        np.testing.assert_array_equal(covariance, covariance.T)
        np.linalg.cholesky(covariance)
        scale = np.sqrt(np.diag(covariance))
        assert np.linalg.eigvalsh(covariance / np.outer(scale, scale))[0] > 0.0
        norm = found.world_T_imu.coefficients[:4]
        assert abs(norm @ norm - 1.0) < 1e-14


def test_covariances_stay_symmetric_and_positive_for_minutes(rng):
    check_covariances(200.0, rng)


@pytest.mark.slow
def test_covariances_stay_symmetric_and_positive_for_an_hour(rng):
    check_covariances(3600.0, rng)
