"""Spectral energy and log dimensionless jerk against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    NotObservableError,
    energy_excess_above,
    jitter,
    log_dimensionless_jerk,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Rotor, Trajectory


def along(seconds, way):
    """Shift by `way` metres and turn by as many radians, each about an axis of its own."""
    motors = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(way[:, None] * [0.36, 0.48, 0.8]), way[:, None] * [0.6, 0.0, 0.8]
    )
    return Trajectory(np.round(seconds * 1e9).astype(np.int64), motors)


def test_the_minimum_jerk_movement_has_its_known_score():
    u = np.linspace(0.0, 1.0, 4001)
    for size, duration_s in ((1.0, 1.0), (0.3, 2.5)):
        way = size * (10 * u**3 - 15 * u**4 + 6 * u**5)
        found = log_dimensionless_jerk(along(duration_s * u, way))
        # 720 D²/T⁵ is the least integral of squared jerk, 15/8 D/T the peak of the velocity.
        expected = -np.log(720.0 / (15.0 / 8.0) ** 2)
        assert found.linear == pytest.approx(expected, abs=2e-3)
        assert found.angular == pytest.approx(expected, abs=2e-3)


def test_a_sine_has_its_known_score_also_at_uneven_stamps(rng):
    steps_ns = rng.integers(1_000_000, 3_000_000, 4999)
    seconds = 1e-9 * np.concatenate([[0], np.cumsum(steps_ns)])
    seconds = np.append(seconds[seconds < 9.998], 10.0)
    omega = 2.0 * np.pi * 0.7
    found = log_dimensionless_jerk(along(seconds, 0.4 * np.sin(omega * seconds)))
    # Peak velocity a ω, jerk a ω³ cos: 7 whole periods.
    expected = -np.log(10.0**4 * omega**4 / 2.0)
    assert found.linear == pytest.approx(expected, abs=0.02)
    assert found.angular == pytest.approx(expected, abs=0.02)


def test_noise_is_less_smooth_and_even_motion_has_no_score(rng):
    truth = MOTIONS["handheld"].sampled(30.0, 10.0)
    clean = log_dimensionless_jerk(truth)
    noisy = log_dimensionless_jerk(Gaussian(0.001, 0.001).apply(truth, rng))
    assert noisy.linear < clean.linear
    assert noisy.angular < clean.angular
    assert log_dimensionless_jerk(MOTIONS["screw"].sampled(30.0, 10.0)).angular is None
    still = Trajectory(truth.time_ns, truth.motors[np.zeros(len(truth), dtype=int)])
    assert log_dimensionless_jerk(still).linear is None
    with pytest.raises(NotObservableError, match="5 or more poses, got 4"):
        log_dimensionless_jerk(truth[:4])


def test_energy_above_is_that_of_the_tremor_added():
    seconds = np.arange(0.0, 40.0, 0.01)
    slow, size, frequency_hz = 0.5 * np.sin(2.0 * seconds), 1e-4, 8.0
    jittered = slow + size * np.sin(2.0 * np.pi * frequency_hz * seconds)
    truth, estimate = along(seconds, slow), along(seconds, jittered)
    omega = 2.0 * np.pi * frequency_hz
    # Second differences see ω² as (2 sin(ω dt/2) / dt)².
    seen = (2.0 * np.sin(0.5 * omega * 0.01) / 0.01) ** 2
    found = energy_excess_above(estimate, truth, 5.0)
    assert found.linear_m2_s4 == pytest.approx(0.5 * (size * seen) ** 2, rel=0.01)
    assert found.angular_rad2_s4 == pytest.approx(0.5 * (size * seen) ** 2, rel=0.01)
    above = energy_excess_above(estimate, truth, 12.0)
    assert abs(above.linear_m2_s4) < 1e-3 * found.linear_m2_s4
    back = energy_excess_above(truth, estimate, 5.0)
    assert back.linear_m2_s4 < 0.0


def test_energy_is_blind_to_phase_where_jitter_is_not():
    seconds = np.arange(0.0, 20.0, 0.01)
    truth, late = (along(seconds, 0.3 * np.sin(6.0 * (seconds - d))) for d in (0.0, 0.05))
    found = energy_excess_above(late, truth, 0.2)
    assert abs(found.linear_m2_s4) < 0.02 * 0.5 * (0.3 * 36.0) ** 2
    assert jitter(late, truth).linear_m_s2 > 1.0
