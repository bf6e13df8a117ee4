"""Every trouble of the simulated sensor by a witness of its own, and chunks against the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, freqs, welch
from scipy.spatial.transform import Rotation

from motorcade.fusion.imu import (
    ADIS16448,
    ContinuousPath,
    ImuFaults,
    ImuNoise,
    ImuStream,
    VibrationSpectrum,
    simulate,
    simulate_imu,
    simulate_imu_in_chunks,
)
from motorcade.fusion.imu.allan import allan_deviation
from motorcade.fusion.imu.simulate import SimulatedImu
from motorcade.fusion.motions import MOTIONS, Factor, Motion
from motorcade.fusion.motions.motion import Polynomial
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.imu import read_imu

STILL = Motion((Factor(np.zeros(6), Polynomial((1.0,))),), Motor)
TINY = ImuNoise(1e-9, 1e-12, 1e-9, 1e-12)
ROTORS = VibrationSpectrum(
    [0.0, 20.0, 40.0, 60.0, 80.0, 90.0],
    1e-5 * np.array([0.0, 0.0, 4.0, 1.0, 2.0, 0.0])[:, None] * [1.0, 2.0, 3.0],
    1e-2 * np.array([0.0, 0.0, 1.0, 3.0, 2.0, 0.0])[:, None] * [3.0, 2.0, 1.0],
)
TROUBLED = ImuFaults(
    gyro_turn_rad=[0.01, 0.02, -0.03],
    gyro_g_sensitivity_rad_s_m=1e-3,
    gyro_flicker_rad_s=1e-4,
    accel_flicker_m_s2=[1e-3, 2e-3, 3e-3],
    warming_k=20.0,
    warming_time_s=5.0,
    gyro_bias_rad_s_k=1e-4,
    accel_scale_k=1e-5,
    gyro_lowpass_hz=60.0,
    accel_lowpass_hz=40.0,
    accel_delay_s=0.003,
    stamp_jitter_s=2e-4,
    accel_step_m_s2=0.001,
    dropped_share=0.05,
)


def resting(faults: ImuFaults, seconds: float, rate_hz: float = 100.0, **given) -> SimulatedImu:
    path = ContinuousPath.along(STILL, seconds)
    return simulate_imu(path, rate_hz, None, np.random.default_rng(1), faults=faults, **given)


@pytest.mark.parametrize("chunk_size", [2, 3, 100, 4096, 8191, 8192, 8193, 10**6])
def test_chunks_are_the_whole_whatever_their_size(chunk_size):
    """Over a gap, through every filter and fault; 2 is tried on the first three hundred alone."""
    stamps = 50_000_000 * np.arange(600) + np.where(np.arange(600) > 300, 10**12, 0)
    path = Trajectory(stamps, MOTIONS["handheld"].sampled(20.0, 29.95).poses)
    path = path[:20] if chunk_size < 10 else path
    given = {"faults": TROUBLED, "vibration": ROTORS, "time_offset_s": 0.01}
    noise = ADIS16448, ADIS16448.scaled(2.0), ADIS16448.scaled(3.0)
    rng, again = np.random.default_rng(3), np.random.default_rng(3)
    whole = simulate_imu(path, 500.0, noise, rng, **given)
    chunks = list(simulate_imu_in_chunks(path, 500.0, noise, again, chunk_size=chunk_size, **given))
    assert all(len(chunk.stream) == chunk_size for chunk in chunks[:-1])
    for columns in [
        lambda one: one.stream.time_ns,
        lambda one: one.stream.angular_rate_rad_s,
        lambda one: one.stream.specific_force_m_s2,
        lambda one: one.gyro_bias_rad_s,
        lambda one: one.accel_bias_m_s2,
        lambda one: one.path.time_ns,
        lambda one: one.path.poses.coefficients,
        lambda one: one.velocity_m_s,
    ]:
        joined = np.concatenate([columns(chunk) for chunk in chunks])
        assert np.array_equal(joined, columns(whole))
    assert rng.random() == again.random()


@pytest.mark.parametrize("block", [64, 1000])
def test_terms_remember_across_blocks(monkeypatch, block):
    """The same sensor made in smaller blocks, but for the vibration, whose block is its own."""
    path = ContinuousPath.along(MOTIONS["handheld"], 5.0)
    whole = simulate_imu(path, 500.0, ADIS16448, np.random.default_rng(3), faults=TROUBLED)
    monkeypatch.setattr(simulate, "BLOCK", block)
    parts = simulate_imu(path, 500.0, ADIS16448, np.random.default_rng(3), faults=TROUBLED)
    assert np.array_equal(whole.stream.time_ns, parts.stream.time_ns)
    np.testing.assert_allclose(
        parts.stream.angular_rate_rad_s, whole.stream.angular_rate_rad_s, atol=1e-13
    )
    np.testing.assert_allclose(parts.accel_bias_m_s2, whole.accel_bias_m_s2, atol=1e-14)


def test_vibration_goes_on_from_block_to_block(monkeypatch):
    whole = resting(ImuFaults(), 20.0, 200.0, vibration=ROTORS).stream
    monkeypatch.setattr(simulate, "BLOCK", 512)
    parts = resting(ImuFaults(), 20.0, 200.0, vibration=ROTORS).stream
    hz, power = welch(parts.specific_force_m_s2, 200.0, nperseg=64, axis=0)
    _, expected = welch(whole.specific_force_m_s2, 200.0, nperseg=64, axis=0)
    inside = (hz > 25.0) & (hz < 85.0)
    assert np.max(np.abs(np.log(power[inside] / expected[inside]))) < 0.5


def test_flicker_lies_flat_in_the_allan_deviation():
    """At 0.664 B (IEEE Std 952), averaged over 24 sensors' axes."""
    instability = np.array([1e-4, 3e-4, 1e-3])
    faults = ImuFaults(gyro_flicker_rad_s=instability)
    variances = []
    for seed in range(8):
        path = ContinuousPath.along(STILL, 2000.0)
        made = simulate_imu(path, 20.0, None, np.random.default_rng(seed), faults=faults)
        curve = allan_deviation(made.stream.angular_rate_rad_s, 20.0, [1.0, 4.0, 16.0, 64.0])
        variances.append((curve.deviation / instability) ** 2)
    flat = np.sqrt(np.mean(variances, axis=(0, 2)))
    assert np.allclose(flat, np.sqrt(2.0 * np.log(2.0) / np.pi), rtol=0.08)
    assert np.array_equal(made.gyro_bias_rad_s, made.stream.angular_rate_rad_s)


@pytest.mark.parametrize("rate_hz", [200.0, 1000.0])
def test_vibration_has_the_spectrum_given(rate_hz):
    stream = resting(ImuFaults(), 200.0, rate_hz, vibration=ROTORS).stream
    for values, density in [
        (stream.angular_rate_rad_s, ROTORS.gyro_rad2_s2_hz),
        (stream.specific_force_m_s2, ROTORS.accel_m2_s4_hz),
    ]:
        hz, power = welch(values, rate_hz, nperseg=int(rate_hz), axis=0)
        inside = (hz > 25.0) & (hz < 88.0)
        expected = np.stack([np.interp(hz, ROTORS.frequency_hz, one) for one in density.T], axis=-1)
        assert np.allclose(power[inside], expected[inside], rtol=0.35)
        total = np.trapezoid(power[inside], hz[inside], axis=0)
        assert np.allclose(total, np.trapezoid(expected[inside], hz[inside], axis=0), rtol=0.03)
    apart = np.corrcoef(stream.specific_force_m_s2.T)
    assert np.max(np.abs(apart - np.eye(3))) < 0.05


def test_vibration_above_half_the_rate_is_folded_unless_it_is_filtered():
    tone = np.array([0.0, 1.0, 0.0])[:, None] * np.ones(3)
    fast = VibrationSpectrum([168.0, 170.0, 172.0], tone, tone)
    plain = resting(ImuFaults(), 100.0, 200.0, vibration=fast).stream.specific_force_m_s2
    hz, power = welch(plain, 200.0, nperseg=400, axis=0)
    assert np.all(np.abs(hz[np.argmax(power, axis=0)] - 30.0) <= 1.0)
    assert np.allclose(np.std(plain, axis=0), fast.accel_rms_m_s2, rtol=0.1)
    filtered = resting(
        ImuFaults(accel_lowpass_hz=17.0), 100.0, 200.0, vibration=fast
    ).stream.specific_force_m_s2
    assert np.allclose(np.std(filtered, axis=0), 0.01 * np.std(plain, axis=0), rtol=0.1)


@pytest.mark.parametrize("name", ["V102_imu.txt", "flights/MH05_imu.txt", "flights/V103_imu.txt"])
def test_vibration_learnt_from_a_flight_is_that_of_the_flight(name, data_dir):
    imu = read_imu(data_dir / "imu" / name)
    learnt = VibrationSpectrum.learnt(imu, above_hz=10.0)
    again = VibrationSpectrum.learnt(
        resting(ImuFaults(), 120.0, imu.rate_hz, vibration=learnt).stream, above_hz=10.0
    )
    assert np.allclose(again.accel_rms_m_s2, learnt.accel_rms_m_s2, rtol=0.03)
    assert np.allclose(again.gyro_rms_rad_s, learnt.gyro_rms_rad_s, rtol=0.03)
    # From sample to sample a flight changes by its vibration, hardly by its motion.
    steps = np.diff(imu.specific_force_m_s2, axis=0)
    made = resting(ImuFaults(), 120.0, imu.rate_hz, vibration=learnt).stream
    felt = np.diff(made.specific_force_m_s2, axis=0)
    assert np.allclose(np.std(felt, axis=0), np.std(steps, axis=0), rtol=0.06)


def test_white_noise_is_not_learnt_twice():
    noise = ImuNoise(1e-3, 1e-9, 1e-2, 1e-9)
    path = ContinuousPath.along(STILL, 200.0)
    imu = simulate_imu(path, 200.0, noise, np.random.default_rng(0), vibration=ROTORS).stream
    learnt = VibrationSpectrum.learnt(imu, above_hz=10.0, noise=noise)
    assert np.allclose(learnt.accel_rms_m_s2, ROTORS.accel_rms_m_s2, rtol=0.05)
    assert np.allclose(learnt.gyro_rms_rad_s, ROTORS.gyro_rms_rad_s, rtol=0.05)


def test_the_gyroscope_turns_and_feels_force_as_kalibr_has_it():
    """ω = M C ω_true + A f, C from the accelerometer's axes to the gyroscope's."""
    turn, felt = np.array([0.1, -0.2, 0.3]), np.arange(9.0).reshape(3, 3) * 1e-3
    faults = ImuFaults(
        gyro_turn_rad=turn,
        gyro_g_sensitivity_rad_s_m=felt,
        gyro_scale=[1.1, 0.9, 1.0],
        gyro_misalignment_rad=[0.01, 0.02, 0.03],
    )
    path = ContinuousPath.along(MOTIONS["tumble"], 2.0)
    rng = np.random.default_rng(0)
    right = simulate_imu(path, 100.0, None, rng).stream
    wrong = simulate_imu(path, 100.0, None, rng, faults=faults).stream
    C_gyro_i = Rotation.from_rotvec(turn).inv().as_matrix()
    M = np.array([[1.1, 0.0, 0.0], [0.01, 0.9, 0.0], [0.02, 0.03, 1.0]])
    expected = right.angular_rate_rad_s @ (M @ C_gyro_i).T + right.specific_force_m_s2 @ felt.T
    np.testing.assert_allclose(wrong.angular_rate_rad_s, expected, atol=1e-12)
    assert np.array_equal(wrong.specific_force_m_s2, right.specific_force_m_s2)


def test_warming_moves_bias_and_scale():
    faults = ImuFaults(
        warming_k=30.0,
        warming_time_s=40.0,
        gyro_bias_rad_s_k=[1e-4, 0.0, -1e-4],
        accel_bias_m_s2_k=1e-3,
        accel_scale_k=[0.0, 0.0, 1e-4],
    )
    made = resting(faults, 100.0, 10.0)
    kelvins = 30.0 * (1.0 - np.exp(-made.path.time_s / 40.0))
    np.testing.assert_allclose(
        made.stream.angular_rate_rad_s, kelvins[:, None] * [1e-4, 0.0, -1e-4], atol=1e-15
    )
    expected = 9.81 * (1.0 + 1e-4 * kelvins) + 1e-3 * kelvins
    np.testing.assert_allclose(made.stream.specific_force_m_s2[:, 2], expected, rtol=1e-12)
    np.testing.assert_allclose(made.accel_bias_m_s2[:, 0], 1e-3 * kelvins, atol=1e-15)


def test_the_filter_lets_through_what_a_butterworth_does():
    """A swing of 8 Hz, in size and phase, against the analogue filter's response."""
    from motorcade.fusion.motions.motion import Sines

    swing = Motion((Factor([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], Sines.single(0.1, 8.0)),), Motor)
    path = ContinuousPath.along(swing, 10.0)
    rng = np.random.default_rng(0)
    faults = ImuFaults(gyro_lowpass_hz=10.0, gyro_delay_s=0.004)
    made = simulate_imu(path, 2000.0, None, rng, faults=faults).stream
    plain = simulate_imu(path, 2000.0, None, rng).stream
    time_s = made.time_ns * 1e-9
    late = time_s > 2.0
    wave = np.exp(-2j * np.pi * 8.0 * time_s[late])
    response = (made.angular_rate_rad_s[late, 2] @ wave) / (
        plain.angular_rate_rad_s[late, 2] @ wave
    )
    _, expected = freqs(*butter(2, 2.0 * np.pi * 10.0, analog=True), [2.0 * np.pi * 8.0])
    expected = expected[0] * np.exp(-2j * np.pi * 8.0 * 0.004)
    assert abs(response - expected) < 2e-3


def test_a_filter_is_settled_where_a_segment_begins():
    stamps = 50_000_000 * np.arange(40) + np.where(np.arange(40) > 20, 10**11, 0)
    path = Trajectory(stamps, Motor.identity((40,)))
    faults = ImuFaults(accel_lowpass_hz=5.0)
    force = simulate_imu(path, 100.0, None, np.random.default_rng(0), faults=faults).stream
    assert np.allclose(force.specific_force_m_s2, [0.0, 0.0, 9.81], atol=1e-9)


def test_a_delay_shows_the_past():
    path = ContinuousPath.along(MOTIONS["handheld"], 2.0)
    rng = np.random.default_rng(0)
    late = simulate_imu(path, 100.0, None, rng, faults=ImuFaults(accel_delay_s=0.03)).stream
    right = simulate_imu(path, 100.0, None, rng).stream
    np.testing.assert_allclose(
        late.specific_force_m_s2[3:], right.specific_force_m_s2[:-3], atol=1e-12
    )
    assert np.array_equal(late.angular_rate_rad_s, right.angular_rate_rad_s)


def test_stamps_jitter_and_keep_their_order():
    made = resting(ImuFaults(stamp_jitter_s=1e-3), 100.0, 100.0)
    off_s = (made.stream.time_ns - made.path.time_ns) * 1e-9
    assert np.std(off_s) == pytest.approx(1e-3, rel=0.03)
    assert np.abs(np.mean(off_s)) < 5e-5
    widest = resting(ImuFaults(stamp_jitter_s=2.5e-3), 100.0, 100.0).stream.time_ns
    assert np.min(np.diff(widest)) >= 2_000_000


def test_axes_have_noise_of_their_own():
    axes = tuple(ImuNoise(k * 1e-3, 1e-9, k * 1e-2, 1e-9) for k in (1.0, 2.0, 5.0))
    path = ContinuousPath.along(STILL, 100.0)
    made = simulate_imu(path, 100.0, axes, np.random.default_rng(0)).stream
    assert np.allclose(np.std(made.angular_rate_rad_s, axis=0), [0.01, 0.02, 0.05], rtol=0.03)
    assert np.allclose(np.std(made.specific_force_m_s2, axis=0), [0.1, 0.2, 0.5], rtol=0.03)


def test_no_trouble_changes_the_numbers_of_another():
    """White noise and walks are those of the same seed, whatever else is wrong."""
    path = ContinuousPath.along(STILL, 20.0)
    plain = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(5)).stream
    faults = replace(TROUBLED, dropped_share=0.0, accel_step_m_s2=0.0, stamp_jitter_s=0.0)
    quiet = simulate_imu(path, 200.0, TINY, np.random.default_rng(5), faults=faults).stream
    noisy = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(5), faults=faults).stream
    moved = noisy.angular_rate_rad_s - quiet.angular_rate_rad_s
    np.testing.assert_allclose(moved, plain.angular_rate_rad_s, atol=1e-7)


def test_troubles_that_no_sensor_has_are_refused():
    for fault, message in [
        ({"gyro_flicker_rad_s": -1.0}, "gyro_flicker_rad_s: expected numbers of at least 0"),
        ({"gyro_g_sensitivity_rad_s_m": [1.0, 2.0]}, "expected one number, three or 3 x 3"),
        ({"warming_time_s": 0.0}, "warming_time_s: expected a number above 0"),
        ({"warming_k": np.inf}, "warming_k: expected a finite number"),
        ({"gyro_lowpass_hz": 0.0}, "gyro_lowpass_hz: expected a number above 0"),
        ({"gyro_delay_s": -1.0}, "gyro_delay_s: expected a number of at least 0"),
    ]:
        with pytest.raises(ValueError, match=message):
            ImuFaults(**fault)
    with pytest.raises(ValueError, match=r"accel_lowpass_hz: expected less than half the rate"):
        resting(ImuFaults(accel_lowpass_hz=50.0), 1.0)
    with pytest.raises(ValueError, match=r"stamp_jitter_s: expected at most a quarter of the"):
        resting(ImuFaults(stamp_jitter_s=0.003), 1.0)
    path = ContinuousPath.along(STILL, 1.0)
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="chunk_size: expected at least 2 samples, got 1"):
        simulate_imu_in_chunks(path, 10.0, None, rng, chunk_size=1)
    with pytest.raises(ValueError, match=r"expected at most 1000000000 samples, got 1\.1e"):
        simulate_imu_in_chunks(ContinuousPath.along(STILL, 1100.0), 1e7, None, rng)
    with pytest.raises(ValueError, match="expected that of all axes, or of three, got 2"):
        simulate_imu(path, 10.0, (TINY, TINY), rng)
    with pytest.raises(ValueError, match=r"frequency_hz: expected two or more that increase"):
        VibrationSpectrum([1.0, 1.0], np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"accel_m2_s4_hz: expected shape \(2, 3\) and no number"):
        VibrationSpectrum([0.0, 1.0], np.zeros((2, 3)), -np.ones((2, 3)))
    still = ImuStream(10_000_000 * np.arange(500), np.zeros((500, 3)), np.zeros((500, 3)))
    with pytest.raises(ValueError, match="above_hz: expected from 0 to 50 Hz"):
        VibrationSpectrum.learnt(still, above_hz=50.0)
    with pytest.raises(ValueError, match="expected 10 s without a gap to learn its vibration"):
        VibrationSpectrum.learnt(still)
