"""Allan deviation against the handbook's numbers, and noise found again in what was simulated."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.imu import (
    ADIS16448,
    ContinuousPath,
    ImuNoise,
    ImuStream,
    estimate_noise,
    simulate_imu,
)
from motorcade.fusion.imu.allan import allan_deviation, fitted_noise
from motorcade.fusion.imu.screening import refuse_movement
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.motion import Factor, Motion, Polynomial
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import read_imu

STANDING = Motion((Factor(np.zeros(6), Polynomial((1.0,))),), Motor)


def handbook_points() -> FloatArray:
    """The 1000 points of NIST SP 1065, section 12.4: a congruential generator."""
    points = [1234567890]
    while len(points) < 1000:
        points.append(16807 * points[-1] % 2147483647)
    return np.array(points) / 2147483647


def noisy(
    count: int, rate_hz: float, density: float, walk: float, rng: np.random.Generator
) -> FloatArray:
    white, steps = rng.standard_normal((2, count))
    return density * np.sqrt(rate_hz) * white + np.cumsum(walk / np.sqrt(rate_hz) * steps)


def test_the_handbooks_example_comes_out():
    """Overlapping Allan deviation of its table 31, at averages of 1, 10 and 100."""
    found = allan_deviation(handbook_points(), 1.0, [1.0, 10.0, 100.0])
    np.testing.assert_allclose(
        found.deviation, [2.922319e-01, 9.159953e-02, 3.241343e-02], rtol=3e-7
    )
    # the rate only names the times, and offsets do not count
    faster = allan_deviation(1e6 + handbook_points(), 50.0, [0.02, 0.2, 2.0])
    np.testing.assert_allclose(faster.deviation, found.deviation, rtol=1e-8)
    np.testing.assert_allclose(faster.tau_s, [0.02, 0.2, 2.0])


def test_it_is_the_definition_written_out(rng):
    values = rng.standard_normal((50, 2))
    found = allan_deviation(values, 10.0, [0.1, 0.3, 0.7, 2.4])
    for m, row in zip((1, 3, 7, 24), found.deviation, strict=True):
        means = np.stack([values[k : k + m].mean(axis=0) for k in range(50 - m + 1)])
        steps = means[m:] - means[:-m]
        np.testing.assert_allclose(row, np.sqrt(0.5 * np.mean(steps**2, axis=0)), rtol=1e-12)


@pytest.mark.slow
def test_four_hours_give_the_simulated_densities_back():
    """All four densities of EuRoC's sensor, within 10 %, by way of the simulator."""
    path = ContinuousPath.along(STANDING, 4 * 3600.0)
    simulated = simulate_imu(path, 40.0, ADIS16448, np.random.default_rng(0))
    found = estimate_noise(simulated.stream)
    for name in (
        "gyro_density_rad_s_rthz",
        "gyro_walk_rad_s2_rthz",
        "accel_density_m_s2_rthz",
        "accel_walk_m_s3_rthz",
    ):
        assert getattr(found.noise, name) == pytest.approx(getattr(ADIS16448, name), rel=0.1)
    # and each axis alone, by its own deviation
    for axis in found.gyro:
        assert abs(axis.density - 1.6968e-4) < 4.0 * axis.density_deviation < 0.03 * 1.6968e-4
        assert abs(axis.walk - 1.9393e-5) < 4.0 * axis.walk_deviation < 0.3 * 1.9393e-5
        assert axis.flicker == 0.0


def test_the_deviations_it_states_are_those_of_many_runs(rng):
    """Errors over stated deviations have a spread of one; a fit of independent points has 0.3."""
    density, walk = 2e-3, 3e-4
    found = [
        fitted_noise(allan_deviation(noisy(2000, 10.0, density, walk, rng)[:, None], 10.0), 0)
        for _ in range(40)
    ]
    for name, truth in (("density", density), ("walk", walk)):
        errors = np.array([getattr(one, name) - truth for one in found])
        scores = errors / [getattr(one, f"{name}_deviation") for one in found]
        assert 0.7 < np.std(scores) < 1.4
        assert abs(np.mean(scores)) < 0.6


def test_flicker_is_seen_where_there_is_some(rng):
    """White noise and flicker made in the frequency domain, one-sided B² / (π f)."""
    count, rate_hz, flicker = 2**17, 20.0, 4e-3
    frequency = np.fft.rfftfreq(count, 1.0 / rate_hz)[1:]
    size = np.sqrt(flicker**2 / (2.0 * np.pi * frequency) * count * rate_hz)
    phases = rng.standard_normal((2, frequency.size)) / np.sqrt(2.0)
    spectrum = np.concatenate([[0.0], size * (phases[0] + 1j * phases[1])])
    signal = np.fft.irfft(spectrum, count) + noisy(count, rate_hz, 2e-3, 0.0, rng)
    found = fitted_noise(allan_deviation(signal[:, None], rate_hz), 0)
    assert found.flicker == pytest.approx(flicker, rel=0.15)
    assert found.density == pytest.approx(2e-3, rel=0.1)
    middle = allan_deviation(signal, rate_hz, [50.0])
    assert found.curve(middle.tau_s) == pytest.approx(middle.deviation, rel=0.2)


def test_without_a_walk_its_bound_is_given(rng):
    noise = ImuNoise(1e-3, 1e-12, 1e-2, 1e-12)
    path = ContinuousPath.along(STANDING, 300.0)
    found = estimate_noise(simulate_imu(path, 50.0, noise, rng).stream)
    assert found.noise.gyro_density_rad_s_rthz == pytest.approx(1e-3, rel=0.05)
    assert all(axis.walk < 4.0 * axis.walk_deviation for axis in found.gyro)
    assert 0.0 < found.noise.gyro_walk_rad_s2_rthz < 2e-4


def test_what_has_no_allan_deviation_is_refused(rng):
    values = rng.standard_normal(100)
    for arguments, message in [
        ((values[:2], 1.0), r"signal: expected three or more finite samples, got shape \(2,\)"),
        ((np.append(values, np.nan), 1.0), r"got shape \(101,\) with NaN"),
        ((values, 0.0), "rate_hz: expected a number above 0, got 0.0"),
        ((values, 1.0, [0.1]), "tau_s: expected times from 1 s to 50 s, got 0.1 to 0.1 s"),
        ((values, 1.0, [51.0]), "tau_s: expected times from 1 s to 50 s, got 51 to 51 s"),
    ]:
        with pytest.raises(ValueError, match=message):
            allan_deviation(*arguments)
    stamps = np.arange(200) * 10_000_000
    noise = rng.standard_normal((200, 3))
    with pytest.raises(ValueError, match="imu: expected at least 100 samples, got 50"):
        estimate_noise(ImuStream(stamps[:50], noise[:50], noise[:50]))
    gapped = stamps + 10_000_000 * (np.arange(200) > 120)
    with pytest.raises(ValueError, match=r"a gap of 0.0200 s after 1200000000 ns; cut"):
        estimate_noise(ImuStream(gapped, noise, noise))
    with pytest.raises(ValueError, match="expected noise on axis 1, got readings that do not"):
        estimate_noise(ImuStream(stamps, noise, noise * [1.0, 0.0, 1.0]))
    with pytest.raises(ValueError, match="expected noise on axis 0, got readings that do not"):
        estimate_noise(ImuStream(stamps, 1e-150 * noise, noise))


def test_one_reading_far_from_all_others_is_no_overflow():
    force = np.tile([0.0, 0.0, 1e9], (400, 1))
    force[200, 2] = 0.0
    rate = np.random.default_rng(0).standard_normal((400, 3))
    with pytest.raises(ValueError, match="expected"):
        estimate_noise(ImuStream(1000 * np.arange(400), rate, force))
    curve = allan_deviation(force, 1e6)
    found = fitted_noise(curve, 2)
    assert np.isfinite([found.density, found.density_deviation, found.walk_deviation]).all()


@pytest.mark.parametrize("name", ["handheld", "walk_and_look", "distant_circle", "stop_and_go"])
def test_a_sensor_that_moves_is_refused(name, rng):
    path = ContinuousPath.along(MOTIONS[name], 20.0)
    moving = simulate_imu(path, 200.0, ADIS16448, rng).stream
    with pytest.raises(ValueError, match=r"at rest, got one that moves: .*; Allan deviation takes"):
        estimate_noise(moving)


def test_a_flight_is_refused(data_dir):
    with pytest.raises(ValueError, match="at rest, got one that moves: its mean angular rate"):
        estimate_noise(read_imu(data_dir / "imu/V102_imu.txt"))


@pytest.mark.parametrize("noise", [1.0, 10.0, 100.0])
def test_a_sensor_at_rest_passes_however_noisy_and_drifting(noise, rng):
    sizes = noise * np.array([1.7e-4, 1.9e-5, 2e-3, 3e-3])
    path = ContinuousPath.along(STANDING, 300.0)
    still = simulate_imu(path, 100.0, ImuNoise(*sizes), rng).stream
    refuse_movement(still)
    with pytest.raises(ValueError, match="at rest, got one that moves"):
        refuse_movement(_leaned(still))


def _leaned(still: ImuStream) -> ImuStream:
    """The same, turned on its side halfway."""
    force = still.specific_force_m_s2.copy()
    force[len(still) // 2 :] += [9.81, 0.0, -9.81]
    return ImuStream(still.time_ns, still.angular_rate_rad_s, force)


@pytest.mark.parametrize(
    ("turned", "pushed", "said"),
    [
        (0.045, 0.0, None),
        (0.0, 0.29, None),
        (0.06, 0.0, "its mean angular rate over half a second changes by 0.06 rad/s"),
        (0.0, 0.32, "its mean specific force over half a second changes by 0.32 m/s²"),
    ],
)
def test_what_is_a_movement_is_told_with_its_time(turned, pushed, said):
    """Readings that step once, at 7 s, as those of a sensor that was touched; no noise."""
    stamps = np.arange(2000) * 10_000_000
    after = (np.arange(2000) >= 700)[:, None]
    rate, force = after * [0.0, turned, 0.0], np.array([0.0, 0.0, 9.81]) + after * [pushed, 0, 0]
    touched = ImuStream(stamps, rate, force)
    if said is None:
        refuse_movement(touched)
        return
    with pytest.raises(ValueError, match=f"{said} into the next, 7.0 s after its first sample"):
        refuse_movement(touched)


def test_too_short_a_recording_says_nothing_of_movement(rng):
    stamps, rate = np.arange(1000) * 10_000_000, 1e-3 * rng.standard_normal((1000, 3))
    moved = _leaned(ImuStream(stamps, rate, np.tile([0.0, 0.0, 9.81], (1000, 1))))
    with pytest.raises(ValueError, match="at rest, got one that moves"):
        refuse_movement(moved)
    few = slice(500 - 49, 500 + 50)
    short = stamps[few], moved.angular_rate_rad_s[few], moved.specific_force_m_s2[few]
    refuse_movement(ImuStream(*short))
