"""What the fused path is good for: less error, blackouts, wrong starts, outliers, real flights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.fusion.filter.fused import camera_covariance
from motorcade.fusion.filter.settings import RestDetection
from motorcade.fusion.imu import ImuStream
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import absolute_translation_m, associate, rotation_rad, tilt_rad
from motorcade.fusion.motions.degradations import Blackouts, InTurn, Latency, Outliers
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.layouts.euroc import read as read_euroc
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking.measurements import PoseMeasurements


def errors_of(path: Trajectory, truth: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Errors of position (m) and rotation (deg) at every stamp of the path."""
    true = truth.at(path.time_ns)
    return absolute_translation_m(path.poses, true), np.rad2deg(rotation_rad(path.poses, true))


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def degraded(measurements: PoseMeasurements, which: np.ndarray, twist: list[float]):
    """The measurements with some of them off by a twist."""
    off = Motor.from_twist(np.where(which[:, None], np.array(twist), 0.0))
    return PoseMeasurements(
        measurements.trajectory.transformed_by(right=off), measurements.covariance
    )


def test_fusion_more_than_halves_the_measurements_errors(record, rng):
    run = record(rng)
    for measured, fused in zip(
        errors_of(run.measurements.trajectory, run.camera),
        errors_of(run.fuse().trajectory, run.camera),
        strict=True,
    ):
        assert rms(fused) < 0.5 * rms(measured)


def test_it_answers_at_any_stamps_and_agrees_with_itself(record, rng):
    run = record(rng, 3.0)
    coarse, fine = run.fuse(), run.fuse(stamps_ns=run.imu.time_ns)
    assert len(fine.trajectory) == len(run.imu)
    shared = np.isin(fine.trajectory.time_ns, coarse.trajectory.time_ns)
    apart = (fine.trajectory.poses[shared].inverse() @ coarse.trajectory.poses).as_twist()
    assert np.max(np.abs(apart)) < 1e-9
    assert np.all(np.isnan(fine.nis[~shared]))
    assert np.all(np.isfinite(fine.nis[shared][1:]))
    between = run.imu.time_ns[:-1:7] + 3_141_593
    odd = run.fuse(stamps_ns=between).trajectory
    np.testing.assert_array_equal(odd.time_ns, between)
    assert rms(errors_of(odd, run.camera)[0]) < 0.006


@pytest.mark.parametrize("offset_s", [-0.012, 0.012, -0.0375])
def test_measurements_stamped_by_another_clock_fuse_as_if_by_the_imus(record, rng, offset_s):
    run = record(rng, 3.0)
    stamps = run.measurements.trajectory.time_ns
    inside = stamps[(stamps > 50_000_000) & (stamps < stamps[-1] - 50_000_000)]
    some = np.isin(stamps, inside)
    path = replace(
        run.measurements.trajectory, time_ns=inside, poses=run.measurements.trajectory.motors[some]
    )
    covariance = run.measurements.covariance[some]
    own = fuse(PoseMeasurements(path, covariance), run.imu, run.noise, run.imu_T_camera)
    late = replace(path, time_ns=inside - round(offset_s * 1e9))
    other = fuse(
        PoseMeasurements(late, covariance),
        run.imu,
        run.noise,
        run.imu_T_camera,
        time_offset_s=offset_s,
    )
    np.testing.assert_array_equal(other.trajectory.time_ns, own.trajectory.time_ns)
    apart = (own.trajectory.motors.inverse() @ other.trajectory.motors).as_twist()
    assert np.max(np.abs(apart)) < 1e-9


@pytest.mark.parametrize("more", [{}, {"gravity_sigma_rad": 0.02, "extrinsics_sigma_rad": 0.02}])
@pytest.mark.parametrize("smoothed", [False, True])
def test_the_cameras_covariance_is_that_of_the_state_seen_from_it(record, rng, smoothed, more):
    run = record(rng, 10.0)
    options = {"settings": FilterSettings(**more), "smoothed": smoothed}
    whole, lean = run.fuse(**options), run.fuse(**options, state_covariances=False)
    expected = camera_covariance(whole.state_covariance, whole.imu_T_camera)
    sigma = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    scale = sigma[:, :, None] * sigma[:, None]
    np.testing.assert_allclose(whole.covariance / scale, expected / scale, atol=1e-9)
    np.testing.assert_array_equal(lean.covariance, whole.covariance)
    np.testing.assert_array_equal(
        lean.trajectory.motors.coefficients, whole.trajectory.motors.coefficients
    )
    assert len(lean.state_covariance) == 0
    assert lean.doubts == ()
    assert [line[:40] for line in whole.doubts] == [
        "deviations of extrinsics and offset hold"
    ] * bool(more)


def blacked_out(measurements: PoseMeasurements, spans_s) -> PoseMeasurements:
    """The measurements outside the spans [start, end) in seconds after the first."""
    path, seen = measurements.trajectory, np.ones(len(measurements), dtype=np.bool_)
    for start_s, end_s in spans_s:
        seen &= (path.time_s < start_s) | (path.time_s >= end_s)
    return PoseMeasurements(path[seen], measurements.covariance[seen])


def test_a_blackout_is_bridged_and_looking_ahead_helps(record, rng):
    run = record(rng, 8.0, 200.0)
    run = replace(run, measurements=blacked_out(run.measurements, [(4.0, 5.0), (6.0, 7.5)]))
    dark = run.imu.time_ns[(np.diff(run.imu.time_ns, prepend=0) > 0)]
    dark = dark[(dark > dark[0] + 4_000_000_000) & (dark < dark[0] + 5_000_000_000)]
    online, offline = (
        errors_of(run.fuse(stamps_ns=dark, smoothed=smoothed).trajectory, run.camera)[0]
        for smoothed in (False, True)
    )
    assert np.max(offline) < 0.02
    assert np.max(offline) < 0.5 * np.max(online)


def test_uncertainty_grows_through_a_blackout_and_matches_the_error(record, rng):
    run = record(rng, 8.0, 100.0)
    run = replace(run, measurements=blacked_out(run.measurements, [(4.0, 5.5)]))
    fused = run.fuse(stamps_ns=run.imu.time_ns, smoothed=False)
    sigma = np.sqrt(np.trace(fused.covariance[:, 3:, 3:], axis1=1, axis2=2))
    assert sigma[545] > 3.0 * sigma[395]
    error = errors_of(fused.trajectory, run.camera)[0]
    assert np.max(error[400:550] / sigma[400:550]) < 3.0


@pytest.mark.parametrize("tilt_deg", [5.0, 40.0, 120.0])
def test_a_wrong_start_converges_with_biases_unknown(record, rng, tilt_deg):
    run = record(rng, 6.0)
    settings = FilterSettings(initial_tilt_error_rad=np.deg2rad(tilt_deg))
    fused = run.fuse(settings=settings, smoothed=False)
    pairs = associate(fused.trajectory, run.camera)
    tilt = np.rad2deg(tilt_rad(pairs.estimate, pairs.reference))
    assert tilt[0] == pytest.approx(tilt_deg, abs=1.5)
    assert np.max(tilt[40:]) < 0.5
    biases = fused.gyro_bias_rad_s[-1] - run.gyro_bias[-1]
    assert np.max(np.abs(biases)) < 5e-3


def test_gross_outliers_leave_no_trace(record, rng):
    """Every tenth pose flipped by 40° or a metre off: as good as without those poses."""
    run = record(rng, 6.0)
    bad = np.arange(len(run.measurements)) % 10 == 7
    rest = PoseMeasurements(run.measurements.trajectory[~bad], run.measurements.covariance[~bad])
    stamps = run.measurements.trajectory.time_ns
    clean = fuse(rest, run.imu, run.noise, run.imu_T_camera, stamps)
    for twist in ([0.7, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]):
        found = fuse(
            degraded(run.measurements, bad, twist), run.imu, run.noise, run.imu_T_camera, stamps
        )
        np.testing.assert_array_equal(found.accepted, ~bad)
        apart = (clean.trajectory.poses.inverse() @ found.trajectory.poses).as_twist()
        assert np.max(np.abs(apart)) < 1e-9


def test_moderate_outliers_are_weighed_down(record, rng):
    run = record(rng, 6.0)
    bad = np.arange(len(run.measurements)) % 10 == 7
    off = degraded(run.measurements, bad, [0.0, 0.0, 0.0, 0.08, 0.0, 0.0])
    gated, open_to_all = (
        fuse(off, run.imu, run.noise, run.imu_T_camera, settings=FilterSettings(gate=gate))
        for gate in (0.9999, 1.0)
    )
    assert np.all(gated.accepted)
    assert rms(errors_of(gated.trajectory, run.camera)[0]) < 0.8 * rms(
        errors_of(open_to_all.trajectory, run.camera)[0]
    )


def test_when_the_world_has_moved_the_camera_is_believed_again(record, rng):
    """A tracker that restarts elsewhere: live the IMU carries on for a while, in the old world, as
    it might be a burst of wrong poses; looking back none is left out.
    """
    run = record(rng, 8.0)
    stamps = run.measurements.trajectory.time_ns
    seconds = (stamps - stamps[0]) * 1e-9
    later = seconds > 4.0
    jump = Motor.from_euler_translation(np.array([0.0, 0.0, 0.9]), np.array([2.0, -1.0, 0.5]))
    poses = run.measurements.trajectory.poses
    moved = Motor.concatenate([poses[~later], jump @ poses[later]])
    jumped = PoseMeasurements(Trajectory(stamps, moved), run.measurements.covariance)
    for smoothed in (False, True):
        found = fuse(jumped, run.imu, run.noise, run.imu_T_camera, smoothed=smoothed)
        path, left_out = found.trajectory.poses, seconds[~found.accepted]
        believed = seconds >= (4.0 if smoothed else left_out[-1])
        if smoothed:
            assert not left_out.size
        else:
            assert 5 <= left_out.size <= 41
            np.testing.assert_array_equal(left_out, seconds[later][: left_out.size])
            old = absolute_translation_m(path, run.camera.at(stamps))
            assert np.max(old[later & ~believed]) < 0.1
            assert found.given_up_ns[0, 0] == stamps[later][0]
        true = Motor.concatenate(
            [run.camera.at(stamps[~believed]), jump @ run.camera.at(stamps[believed])]
        )
        settled = np.abs(seconds - seconds[believed][0]) > 0.5
        settled &= found.accepted
        assert np.max(absolute_translation_m(path, true)[settled]) < 0.06


def test_the_path_does_not_depend_on_heading_or_place_of_the_world(record, rng):
    """Gravity fixes the vertical only: turn and shift the world, and the path turns with it."""
    run = record(rng, 4.0)
    turn = Rotor.from_rotation_vector([0.0, 0.0, 2.1])
    left = Motor.from_rotor_translation(turn, np.array([300.0, -50.0, 7.0]))
    moved = PoseMeasurements(
        run.measurements.trajectory.transformed_by(left), run.measurements.covariance
    )
    here = run.fuse()
    there = fuse(moved, run.imu, run.noise, run.imu_T_camera)
    apart = ((left @ here.trajectory.poses).inverse() @ there.trajectory.poses).as_twist()
    assert np.max(np.abs(apart)) < 1e-8
    np.testing.assert_allclose(there.covariance, here.covariance, atol=1e-10)


def test_inputs_stay_as_they_were_and_results_repeat(record, rng):
    run = record(rng, 2.0)
    before = run.imu.angular_rate_rad_s.tobytes(), run.measurements.covariance.tobytes()
    first, second = run.fuse(), run.fuse()
    assert (
        first.trajectory.poses.coefficients.tobytes()
        == second.trajectory.poses.coefficients.tobytes()
    )
    assert before == (run.imu.angular_rate_rad_s.tobytes(), run.measurements.covariance.tobytes())


def test_refusals(record, rng):
    run = record(rng, 2.0)
    far = ImuStream(
        run.imu.time_ns + 10**12, run.imu.angular_rate_rad_s, run.imu.specific_force_m_s2
    )
    with pytest.raises(ValueError, match="measurements and imu: expected spans that overlap"):
        fuse(run.measurements, far, run.noise, run.imu_T_camera)
    with pytest.raises(ValueError, match="stamps_ns: expected rising integer nanoseconds"):
        run.fuse(stamps_ns=run.imu.time_ns[::-1])
    with pytest.raises(ValueError, match="stamps_ns: expected rising integer nanoseconds"):
        run.fuse(stamps_ns=run.imu.time_ns * 1.0)
    with pytest.raises(ValueError, match="stamps_ns: expected some within"):
        run.fuse(stamps_ns=far.time_ns)
    with pytest.raises(ValueError, match=r"FilterSettings.gate: expected a probability .* got 1.5"):
        FilterSettings(gate=1.5)
    with pytest.raises(ValueError, match=r"FilterSettings.gravity_m_s2: expected a number above 0"):
        FilterSettings(gravity_m_s2=float("nan"))
    for name, value in (
        ("gap_s", 0.0),
        ("gap_rate_rad_s", -1.0),
        ("gravity_sigma_rad", float("inf")),
        ("extrinsics_sigma_m", -0.1),
        ("time_offset_sigma_s", -1.0),
        ("initial_tilt_error_rad", float("nan")),
    ):
        with pytest.raises(ValueError, match=rf"FilterSettings.{name}: expected"):
            FilterSettings(**{name: value})
    with pytest.raises(ValueError, match=r"RestDetection.window_s: expected a number above 0"):
        RestDetection(window_s=0.0)


# Simulated camera poses -------------------------------------------------------------------------


def test_simulated_poses_have_their_noise_and_rate(handheld):
    truth = handheld.trajectory(200.0, 100.0)
    rng = np.random.default_rng
    whole = simulate_camera_poses(truth, 20.0, 0.01, 0.02, rng(3))
    assert len(whole) == 2001
    np.testing.assert_allclose(np.diff(whole.trajectory.time_s), 0.05, atol=1e-9)
    error = (truth.at(whole.trajectory.time_ns).inverse() @ whole.trajectory.poses).as_twist()
    sigma = np.repeat([0.02, 0.01], 3)
    np.testing.assert_allclose(np.std(error, axis=0), sigma, rtol=0.06)
    np.testing.assert_allclose(whole.covariance[0], np.diag(sigma**2))
    for arguments, message in [
        ((0.0, 0.01, 0.02, rng(0)), "rate_hz: expected a number above 0, got 0.0"),
        ((20.0, 0.0, 0.02, rng(0)), "sigma_m: expected"),
    ]:
        with pytest.raises(ValueError, match=message):
            simulate_camera_poses(truth, *arguments)


def test_simulated_poses_can_be_degraded_besides(handheld):
    truth = handheld.trajectory(200.0, 40.0)
    degraded = InTurn((Outliers(0.1, 0.5, 0.5), Blackouts(2.0, 15.0), Latency(0.02)))
    plain, found = (
        simulate_camera_poses(truth, 20.0, 0.01, 0.02, np.random.default_rng(3), how)
        for how in (None, degraded)
    )
    assert len(plain) - len(found) == 80
    assert len(found.covariance) == len(found)
    seen = np.isin(plain.trajectory.time_ns, found.trajectory.time_ns - 20_000_000)
    assert np.count_nonzero(seen) == len(found)
    apart = (plain.trajectory.motors[seen].inverse() @ found.trajectory.motors).as_twist()
    assert 0.05 < np.mean(np.abs(apart).max(axis=1) > 1e-9) < 0.15


# A real flight ----------------------------------------------------------------------------------

FLIGHT_NOISE_FACTOR = 5.0  # where the mean NIS is 6, as it should be with six degrees of freedom


@pytest.fixture(scope="module")
def flight(data_dir: Path) -> Recording:
    return read_euroc(data_dir / "replays" / "euroc_V1_01")


def flown(flight, truth_file: str, rng, dark_s=()):
    imu_T_camera, noise = flight.imu_T_camera, flight.imu_noise.scaled(FLIGHT_NOISE_FACTOR)
    truth = read_trajectory(flight.root / truth_file).transformed_by(
        right=imu_T_camera, child="camera"
    )
    measured = simulate_camera_poses(truth, 20.0, 0.01, np.deg2rad(0.5), rng)
    return truth, blacked_out(measured, dark_s), (flight.imu, noise, imu_T_camera)


@pytest.mark.slow
@pytest.mark.parametrize("truth_file", ["V1_01_easy.txt", "V1_01_easy_original.txt"])
def test_a_recorded_imu_more_than_halves_the_errors_and_bridges_blackouts(flight, rng, truth_file):
    spans = [(start, start + 1.0) for start in range(12, 140, 16)]
    truth, measured, sensor = flown(flight, truth_file, rng, spans)
    stamps = truth.time_ns[:: round(0.05 / np.median(np.diff(truth.time_s)))]
    fused = fuse(measured, *sensor, stamps)
    position, rotation = errors_of(fused.trajectory, truth)
    noisy_position, noisy_rotation = errors_of(measured.trajectory, truth)
    assert rms(position) < 0.5 * rms(noisy_position)
    assert rms(rotation) < 0.5 * rms(noisy_rotation)
    seconds = (fused.trajectory.time_ns - truth.time_ns[0]) * 1e-9
    for start, end in spans:
        assert np.max(position[(seconds >= start) & (seconds <= end)]) < 0.05


def test_a_recorded_imu_converges_from_a_wrong_tilt_with_no_bias_known(flight, rng):
    truth, measured, sensor = flown(flight, "V1_01_easy.txt", rng)
    first = PoseMeasurements(measured.trajectory[:500], measured.covariance[:500])
    settings = FilterSettings(initial_tilt_error_rad=np.deg2rad(5.0))
    fused: Fused = fuse(first, *sensor, settings=settings, smoothed=False)
    tilt = np.rad2deg(tilt_rad(fused.trajectory.poses, truth.at(fused.trajectory.time_ns)))
    assert tilt[0] > 4.0
    assert np.max(tilt[60:]) < 0.5
    assert np.mean(fused.nis[1:]) == pytest.approx(6.0, abs=0.6)
    _, bias = gyroscope_against_truth(flight)
    assert np.linalg.norm(bias) > np.deg2rad(4.0)
    np.testing.assert_allclose(fused.gyro_bias_rad_s[-1], bias, atol=3e-3)


def test_the_flights_truth_is_that_of_the_imu(flight):
    """The ground truth turns as the gyroscope says, axis by axis: its moving frame is the IMU's."""
    fitted, _ = gyroscope_against_truth(flight)
    np.testing.assert_allclose(fitted, np.eye(3), atol=2e-3)


def gyroscope_against_truth(flight) -> tuple[FloatArray, FloatArray]:
    """Least-squares matrix (3, 3) from measured to true turns, and the gyroscope's bias."""
    imu, truth = flight.imu, read_trajectory(flight.root / "V1_01_easy.txt")
    truth = truth[(truth.time_ns >= imu.time_ns[0]) & (truth.time_ns <= imu.time_ns[-1])]
    seconds = (imu.time_ns - imu.time_ns[0]) * 1e-9
    mean = 0.5 * (imu.angular_rate_rad_s[1:] + imu.angular_rate_rad_s[:-1])
    total = np.vstack([np.zeros(3), np.cumsum(mean * np.diff(seconds)[:, None], axis=0)])
    stamps = (truth.time_ns - imu.time_ns[0]) * 1e-9
    turned = np.stack([np.interp(stamps, seconds, column) for column in total.T], axis=-1)
    rotors, steps = truth.poses.rotor, np.diff(stamps)[:, None]
    seen = (rotors[:-1].inverse() @ rotors[1:]).as_rotation_vector() / steps
    felt = np.hstack([np.diff(turned, axis=0) / steps, np.ones_like(steps)])
    fitted = np.linalg.lstsq(felt, seen, rcond=None)[0]
    return fitted[:3], -fitted[3]
