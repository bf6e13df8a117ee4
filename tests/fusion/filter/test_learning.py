"""Noise learnt from a recording: near the true one, and no worse than what it started from."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from motorcade.fusion.filter import fuse, learn_noise
from motorcade.fusion.imu import ADIS16448, ImuNoise
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.ga import Motor
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.learnt import learnt_figures
from tests.bench.fusion.recorded import BLACKOUTS, FLIGHTS, flight, measured
from tests.fusion.conftest import NOISE, Run


def nees(fused, truth) -> float:
    """Normalised error squared of a path, a dimension."""
    apart = fused.trajectory.motors.local(truth.motors_at(fused.trajectory.time_ns))
    inverse = np.linalg.inv(fused.covariance)
    return float(np.einsum("ni,nij,nj->n", apart, inverse, apart).mean()) / 6.0


@pytest.mark.parametrize(
    ("factor", "duration_s"), [(6.0, 26.0), pytest.param(0.2, 40.0, marks=pytest.mark.slow)]
)
def test_noise_that_was_stated_wrong_is_learnt(record, rng, factor, duration_s):
    run = record(rng, duration_s, 50.0)
    start = run.noise.scaled(factor)
    found = learn_noise(run.measurements, run.imu, start, run.imu_T_camera)
    assert found.learnt
    for name in ("gyro_density_rad_s_rthz", "accel_density_m_s2_rthz"):
        ratio = getattr(found.noise, name) / getattr(run.noise, name)
        assert 0.5 < ratio < 2.0, name
        assert dict(found.factors)[name] == pytest.approx(ratio / factor)
    assert found.before.log_density < found.after.log_density
    assert abs(found.after.nis_per_dimension - 1.0) < 0.1
    wrong, right = (
        nees(fuse(run.measurements, run.imu, noise, run.imu_T_camera, fits_noise=False), run.camera)
        for noise in (start, found.noise)
    )
    assert abs(np.log(right)) < min(np.log(1.4), abs(np.log(wrong)))
    json.dumps(found.as_dict(), allow_nan=False)


@pytest.mark.slow
def test_outliers_are_not_learnt_from(record, rng):
    run = record(rng, 40.0)
    path = run.measurements.trajectory
    off = np.where(rng.random(len(path)) < 0.1, 1.0, 0.0)[:, None] * np.array([0, 0, 0, 1, -2, 1.0])
    poses = replace(path, poses=path.motors @ Motor.from_twist(off))
    given = PoseMeasurements(poses, run.measurements.covariance)
    found = learn_noise(given, run.imu, run.noise, run.imu_T_camera)
    assert 0.4 < dict(found.factors)["accel_density_m_s2_rthz"] < 2.5


@pytest.mark.slow
def test_what_predicts_no_better_is_not_taken(record, rng):
    """From the noise that it was drawn with, only chance is left to learn."""
    run = record(rng, 26.0)
    found = learn_noise(run.measurements, run.imu, run.noise, run.imu_T_camera)
    better = found.after.log_density > found.before.log_density and (
        found.after.held_out_log_density >= found.before.held_out_log_density
    )
    assert not found.learnt or better
    assert (found.noise is run.noise) == (not found.learnt)
    assert ("stays as it was" in found.summary) == (not found.learnt)


@pytest.mark.slow
def test_what_poses_do_not_tell_stays_as_it_was(record, rng):
    """A gyroscope of another noise is not seen behind poses that turn by five degrees at random."""
    run = record(rng, 26.0)
    path = run.measurements.trajectory
    turns = np.zeros((len(path), 6))
    turns[:, :3] = np.deg2rad(5.0) * rng.standard_normal((len(path), 3))
    spread = run.measurements.covariance + np.diag([np.deg2rad(5.0) ** 2] * 3 + [0.0] * 3)
    given = PoseMeasurements(replace(path, poses=path.motors @ Motor.from_twist(turns)), spread)
    found = learn_noise(given, run.imu, run.noise, run.imu_T_camera)
    assert 0.9 < dict(found.factors)["gyro_walk_rad_s2_rthz"] <= 1.1
    assert dict(found.factors)["gyro_density_rad_s_rthz"] > 0.5


def test_short_recordings_keep_what_they_have(record, rng):
    run = record(rng, 5.0)
    found = learn_noise(run.measurements, run.imu, run.noise, run.imu_T_camera)
    assert found.noise is run.noise
    assert not found.learnt
    assert "24 s of poses are needed" in found.summary
    assert found.as_dict()["before"] is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("name", FLIGHTS)
def test_flights_know_their_errors_with_noise_that_they_taught(name, seed):
    """Constants were chosen on V1_02 and MH_05; `tests.bench.fusion.learnt` tries more draws."""
    one = flight(name, data_folder())
    if one is None:
        pytest.skip(f"{name} is not here")
    found = learnt_figures(one, seed)
    assert 0.6 < found["nees_after"] < 1.6
    assert found["gain"] >= 0.0
    assert found["error_ratio"] < 1.1


@pytest.mark.parametrize("times", [1.0, 8.0])
def test_noise_that_contradicts_the_poses_is_fitted_and_other_noise_stays(
    record: Callable[..., Run], times: float
) -> None:
    """A data sheet's densities, eight times too small: as good then as with the right ones."""
    rng = np.random.default_rng(71)
    run = record(rng, 40.0)
    stated = ImuNoise(
        NOISE.gyro_density_rad_s_rthz / times,
        NOISE.gyro_walk_rad_s2_rthz,
        NOISE.accel_density_m_s2_rthz / times,
        NOISE.accel_walk_m_s3_rthz,
    )
    found = fuse(run.measurements, run.imu, stated, run.imu_T_camera)
    assert (found.noise == stated) == (times == 1.0)
    right = fuse(run.measurements, run.imu, NOISE, run.imu_T_camera, fits_noise=False)
    true = run.camera.at(found.trajectory.time_ns)
    errors, best = (
        np.sqrt(np.mean(absolute_translation_m(one.trajectory.motors, true) ** 2))
        for one in (found, right)
    )
    assert errors < 1.1 * best
    assert 0.5 < nees(found, run.camera) < 1.7


@pytest.mark.slow
def test_a_flight_that_shakes_little_knows_its_errors_by_the_default_call():
    """V1_01, whose gyroscope's noise lies between two powers of two."""
    one = flight("V1_01", data_folder())
    if one is None:
        pytest.skip("no flight; set MOTORCADE_DATA")
    poses = measured(one, 1, degraded=BLACKOUTS)
    fused = fuse(poses, one.imu, ADIS16448, Motor.identity(), poses.trajectory.time_ns)
    assert 0.6 < nees(fused, one.truth) < 1.6


def test_poses_that_say_too_little_noise_do_not_change_the_imus(record: Callable[..., Run]) -> None:
    run = record(np.random.default_rng(72), 40.0)
    given = run.measurements
    modest = PoseMeasurements(given.trajectory, given.covariance / 9.0)
    assert fuse(modest, run.imu, NOISE, run.imu_T_camera).noise == NOISE
