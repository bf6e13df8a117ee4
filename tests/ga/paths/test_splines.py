"""Splines on motors: exact derivatives, what the fit reproduces, what is refused.

Witnesses: scipy's B-splines where nothing turns, finite differences, closed forms of a handheld
motion, and the velocity, gyroscope and accelerometer of a recorded flight.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation, RotationSpline

from motorcade.ga import CumulativeBSpline, Motor, Rotor, SplineSample, Trajectory

START_NS = 1_403_715_273_262_142_976


def handheld_position(time_s: np.ndarray, derivative: int = 0) -> np.ndarray:
    """A hand that shakes at up to 2 Hz, three metres from the origin; metres."""
    total = np.zeros((*np.shape(time_s), 3))
    for axis, size, hertz, phase in ((0, 0.3, 0.7, 0.0), (1, 0.2, 1.1, 1.0), (2, 0.05, 2.0, 0.5)):
        rate = 2 * np.pi * hertz
        total[..., axis] = (
            size * rate**derivative * np.sin(rate * time_s + phase + derivative * np.pi / 2)
        )
    return total + ([0.0, 3.0, 1.0] if derivative == 0 else 0.0)


def handheld_angles(time_s: np.ndarray, derivative: int = 0) -> np.ndarray:
    """Intrinsic x, y, z angles of the same hand; radians."""
    total = np.zeros((*np.shape(time_s), 3))
    for axis, size, hertz in ((0, 0.5, 0.5), (1, 0.4, 0.9), (2, 1.2, 0.3)):
        rate = 2 * np.pi * hertz
        total[..., axis] = (
            size * rate**derivative * np.sin(rate * time_s + axis + derivative * np.pi / 2)
        )
    return total


def handheld(time_s: np.ndarray) -> Motor:
    return Motor.from_euler_translation(handheld_angles(time_s), handheld_position(time_s))


def handheld_body_rate(time_s: np.ndarray) -> np.ndarray:
    """Closed form for R = Rx(a) Ry(b) Rz(c): each axis' rate seen from the body."""
    (_, b, c), rates = handheld_angles(time_s).T, handheld_angles(time_s, 1)
    zero = np.zeros_like(b)
    about_x = np.stack([np.cos(b) * np.cos(c), -np.cos(b) * np.sin(c), np.sin(b)], axis=-1)
    about_y = np.stack([np.sin(c), np.cos(c), zero], axis=-1)
    total: np.ndarray = rates[:, :1] * about_x + rates[:, 1:2] * about_y
    total[:, 2] += rates[:, 2]
    return total


def sampled(rate_hz: float = 30.0, seconds: float = 10.0) -> Trajectory:
    offset_ns = np.arange(0, seconds * 1e9, 1e9 / rate_hz).astype(np.int64)
    return Trajectory(START_NS + offset_ns, handheld(offset_ns * 1e-9))


def worst(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.max(np.abs(a - b)))


@pytest.fixture
def spline(rng: np.random.Generator) -> CumulativeBSpline:
    """A wild one, with up to 1.5 rad from knot to knot."""
    steps = Motor.from_twist(rng.uniform(-0.85, 0.85, (15, 6)))
    controls = [Motor.random(rng)]
    for step in steps:
        controls.append(controls[-1] @ step)
    return CumulativeBSpline(START_NS, 0.1, Motor.stack(controls), "map", "imu")


def test_without_rotation_it_is_scipys_bspline(rng: np.random.Generator) -> None:
    points, spacing = rng.standard_normal((12, 3)), 0.25
    spline = CumulativeBSpline(
        0, spacing, Motor.from_rotor_translation(Rotor.identity((12,)), points)
    )
    knots = (np.arange(12 + 6) - 5) * spacing
    witness = BSpline(knots, points, 5)
    time_s = np.linspace(0, spline.duration_s, 101)
    sample = spline.evaluate(time_s)
    assert spline.duration_s == pytest.approx(7 * spacing)
    assert worst(sample.pose.translation_m, witness(time_s)) < 1e-13
    assert worst(sample.world_velocity_m_s, witness(time_s, nu=1)) < 1e-12
    assert worst(sample.world_acceleration_m_s2, witness(time_s, nu=2)) < 1e-10
    assert worst(sample.body_angular_rate_rad_s, np.zeros(3)) == 0.0


def test_derivatives_are_those_of_the_pose(spline: CumulativeBSpline) -> None:
    step = 1e-3
    time_s = np.linspace(2.1 * step, spline.duration_s - 2.1 * step, 200)
    around = [spline.evaluate(time_s + k * step) for k in (-2, -1, 0, 1, 2)]
    middle = around[2]

    def slope(values: list[np.ndarray]) -> np.ndarray:
        total: np.ndarray = (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * step)
        return total

    positions = [sample.pose.translation_m for sample in around]
    velocities = [sample.world_velocity_m_s for sample in around]
    rates = [sample.body_angular_rate_rad_s for sample in around]
    turns = [(middle.pose.rotor.inverse() @ s.pose.rotor).as_rotation_vector() for s in around]
    assert worst(slope(positions), middle.world_velocity_m_s) < 1e-4
    assert worst(slope(velocities), middle.world_acceleration_m_s2) < 1e-2
    assert worst(slope(turns), middle.body_angular_rate_rad_s) < 1e-4
    assert worst(slope(rates), middle.body_angular_acceleration_rad_s2) < 1e-2
    assert np.max(np.abs(middle.world_acceleration_m_s2)) > 50


def test_acceleration_is_smooth_across_knots(spline: CumulativeBSpline) -> None:
    knot_s = spline.knot_spacing_s * np.arange(1, 9)

    def jump(gap_s: float) -> float:
        before, after = spline.evaluate(knot_s - gap_s), spline.evaluate(knot_s + gap_s)
        return worst(before.world_acceleration_m_s2, after.world_acceleration_m_s2)

    assert jump(1e-9) < 1e-3
    # Twice the gap, twice the difference: the third derivative exists on both sides.
    assert jump(2e-6) == pytest.approx(2 * jump(1e-6), rel=1e-2)


def test_poses_by_stamp_and_by_seconds_are_the_same(spline: CumulativeBSpline) -> None:
    offset_ns = np.linspace(0, spline.duration_s * 1e9, 50).astype(np.int64)
    by_stamp = spline.at(START_NS + offset_ns).coefficients
    by_seconds = spline.evaluate(offset_ns * 1e-9).pose.coefficients
    assert worst(by_stamp, by_seconds) < 1e-13
    assert spline.evaluate(0.05).world_velocity_m_s.shape == (3,)
    assert spline.evaluate(np.full((2, 3), 0.05)).pose.shape == (2, 3)


def test_moving_the_world_moves_pose_velocity_and_acceleration(
    spline: CumulativeBSpline, rng: np.random.Generator
) -> None:
    moved = Motor.random(rng)
    other = CumulativeBSpline(START_NS, spline.knot_spacing_s, moved @ spline.controls)
    time_s = np.linspace(0, spline.duration_s, 40)
    here, there = spline.evaluate(time_s), other.evaluate(time_s)
    assert worst((moved @ here.pose).as_matrix(), there.pose.as_matrix()) < 1e-13
    turned = moved.rotor.apply(here.world_acceleration_m_s2)
    assert worst(turned, there.world_acceleration_m_s2) < 1e-9
    assert worst(here.body_angular_rate_rad_s, there.body_angular_rate_rad_s) < 1e-11


def test_a_steady_screw_is_reproduced_exactly(rng: np.random.Generator) -> None:
    speed = np.array([0.4, -0.3, 0.9, 0.5, 1.0, -0.2])
    start, time_s = Motor.random(rng), np.arange(0, 4, 0.02)
    poses = start @ Motor.from_twist(time_s[:, None] * speed)
    fitted = CumulativeBSpline.fit(Trajectory((time_s * 1e9).astype(np.int64), poses), 0.2)
    sample = fitted.evaluate(np.linspace(0, fitted.duration_s, 77))
    assert worst(sample.body_angular_rate_rad_s, speed[:3]) < 1e-7
    assert worst(sample.body_angular_acceleration_rad_s2, np.zeros(3)) < 1e-6
    assert worst(fitted.at((time_s * 1e9).astype(np.int64)).as_matrix(), poses.as_matrix()) < 1e-8


def errors_of(sample: SplineSample, time_s: np.ndarray) -> dict[str, float]:
    truth = handheld(time_s)
    return {
        "position": worst(sample.pose.translation_m, truth.translation_m),
        "angle": float(np.max((sample.pose.rotor.inverse() @ truth.rotor).angle())),
        "velocity": worst(sample.world_velocity_m_s, handheld_position(time_s, 1)),
        "acceleration": worst(sample.world_acceleration_m_s2, handheld_position(time_s, 2)),
        "rate": worst(sample.body_angular_rate_rad_s, handheld_body_rate(time_s)),
    }


def test_handheld_motion_at_30_hz_is_reproduced() -> None:
    fitted = CumulativeBSpline.fit(sampled(), 0.05)
    time_s = np.linspace(0, fitted.duration_s, 4001)
    whole = errors_of(fitted.evaluate(time_s), time_s)
    assert whole["position"] < 2e-5
    assert whole["angle"] < 5e-6
    inner_s = time_s[(time_s > 0.2) & (time_s < fitted.duration_s - 0.2)]
    inner = errors_of(fitted.evaluate(inner_s), inner_s)
    assert inner["position"] < 2e-6
    assert inner["velocity"] < 2e-4
    assert inner["acceleration"] < 0.03
    assert inner["rate"] < 2e-4


def test_error_falls_with_a_high_power_of_the_spacing() -> None:
    trajectory = sampled(200.0, 5.0)
    errors = []
    for spacing in (0.16, 0.08):
        fitted = CumulativeBSpline.fit(trajectory, spacing)
        time_s = np.linspace(1.0, 4.0, 1501)
        errors.append(errors_of(fitted.evaluate(time_s), time_s)["position"])
    assert errors[0] / errors[1] > 2**5


def test_noise_is_averaged_and_does_not_upset_the_fit(rng: np.random.Generator) -> None:
    clean = sampled(30.0, 20.0)
    noise = rng.standard_normal((len(clean), 6)) * np.repeat([0.0087, 0.01], 3)
    noisy = Trajectory(clean.time_ns, clean.poses @ Motor.from_twist(noise))
    for spacing in (0.03, 0.05, 0.1, 0.2):
        fitted = CumulativeBSpline.fit(noisy, spacing)
        error = worst(fitted.at(clean.time_ns).translation_m, clean.poses.translation_m)
        assert error < (0.05 if spacing < 0.1 else 0.03)


def test_a_gap_is_crossed_along_the_screw(rng: np.random.Generator) -> None:
    whole = sampled(30.0, 6.0)
    gone = (whole.time_s > 2.0) & (whole.time_s < 3.0)
    kept = whole[~gone]
    fitted = CumulativeBSpline.fit(kept, 0.05)
    middle = whole.time_ns[(whole.time_s > 2.2) & (whole.time_s < 2.8)]
    assert worst(fitted.at(middle).as_matrix(), kept.at(middle).as_matrix()) < 3e-3


def test_distance_from_the_origin_does_not_matter() -> None:
    far = sampled(30.0, 3.0).transformed_by(
        Motor.from_quaternion_translation([1, 0, 0, 0], [1e4, -2e4, 300.0])
    )
    fitted = CumulativeBSpline.fit(far, 0.05)
    assert worst(fitted.at(far.time_ns).translation_m, far.poses.translation_m) < 1e-5


def test_two_poses_are_enough() -> None:
    pair = sampled()[:2]
    fitted = CumulativeBSpline.fit(pair, 0.1)
    assert worst(fitted.at(pair.time_ns).as_matrix(), pair.poses.as_matrix()) < 1e-6


@pytest.mark.parametrize(("spacing_s", "steps"), [(0.05, 3), (0.1, 4)])
def test_derivatives_are_exact_so_that_few_steps_settle_a_fit(
    spacing_s: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps by wrong derivatives shrink by a factor each; by exact ones, by their square."""
    monkeypatch.setattr("motorcade.ga.splines._MAX_STEPS", steps)
    CumulativeBSpline.fit(sampled(), spacing_s)


def test_names_and_span_come_from_the_trajectory() -> None:
    named = Trajectory(sampled().time_ns, sampled().poses, "map", "imu")
    fitted = CumulativeBSpline.fit(named, 0.07)
    assert (fitted.parent, fitted.child, fitted.start_ns) == ("map", "imu", START_NS)
    assert fitted.duration_s == pytest.approx(named.duration_s, rel=1e-12)
    assert fitted.knot_spacing_s <= 0.07
    fitted.at(named.time_ns[[0, -1]])


def test_scipys_rotation_spline_agrees_on_body_rates() -> None:
    trajectory = sampled(200.0, 3.0)
    fitted = CumulativeBSpline.fit(trajectory, 0.05)
    quaternions = trajectory.poses.rotor.as_quaternion()
    witness = RotationSpline(trajectory.time_s, Rotation.from_quat(quaternions, scalar_first=True))
    time_s = np.linspace(0.2, 2.8, 100)
    ours = fitted.evaluate(time_s).body_angular_rate_rad_s
    assert worst(ours, witness(time_s, 1)) < 1e-4
    assert worst(handheld_body_rate(time_s), witness(time_s, 1)) < 1e-6


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan, np.inf])
def test_spacings_that_are_not_positive_are_refused(spacing: float) -> None:
    with pytest.raises(ValueError, match="knot_spacing_s: expected a positive number"):
        CumulativeBSpline.fit(sampled(), spacing)
    with pytest.raises(ValueError, match="knot_spacing_s: expected a positive number"):
        CumulativeBSpline(0, spacing, Motor.identity((6,)))


def test_too_few_poses_or_controls_are_refused() -> None:
    with pytest.raises(ValueError, match="expected two poses or more"):
        CumulativeBSpline.fit(sampled()[:1], 0.1)
    with pytest.raises(ValueError, match=r"expected shape .* n >= 6"):
        CumulativeBSpline(0, 0.1, Motor.identity((5,)))


def test_times_outside_the_span_are_refused(spline: CumulativeBSpline) -> None:
    for time_s in (-1e-6, spline.duration_s + 1e-6):
        with pytest.raises(ValueError, match="expected times in"):
            spline.evaluate(time_s)
    with pytest.raises(ValueError, match="expected times in"):
        spline.at(START_NS - 10)
    with pytest.raises(ValueError, match="expected integer nanoseconds"):
        spline.at(1.5e18)
    with pytest.raises(ValueError, match="expected finite numbers"):
        spline.evaluate([0.1, np.nan])


def test_motion_too_fast_for_the_knots_is_refused() -> None:
    time_s = np.arange(0, 3, 0.01)
    spinning = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.outer(25.0 * time_s, [0, 0, 1.0])),
        np.stack([np.cos(25 * time_s), np.sin(25 * time_s), time_s], axis=-1),
    )
    trajectory = Trajectory((time_s * 1e9).astype(np.int64), spinning)
    with pytest.raises(ValueError, match="expected knots short enough for the motion"):
        CumulativeBSpline.fit(trajectory, 0.25)


def test_a_recorded_flight_agrees_with_its_velocity_and_imu(data_dir: Path) -> None:
    """V1_02: position derivatives against the estimator's velocity and the raw IMU."""
    folder = data_dir / "imu"
    truth = np.loadtxt(folder / "V1_02_medium.csv", delimiter=",")
    stamps = np.loadtxt(folder / "V1_02_medium.csv", delimiter=",", usecols=0, dtype=np.int64)
    wxyz = truth[:, 4:8] / np.linalg.norm(truth[:, 4:8], axis=1, keepdims=True)
    poses = Motor.from_quaternion_translation(wxyz, truth[:, 1:4])
    trajectory = Trajectory(stamps, poses, child="imu")
    fitted = CumulativeBSpline.fit(trajectory, 0.05)
    at_truth = fitted.evaluate(trajectory.time_s)
    assert np.std(at_truth.pose.translation_m - truth[:, 1:4]) < 2e-4
    assert np.std(at_truth.world_velocity_m_s - truth[:, 8:11]) < 5e-3

    imu = np.loadtxt(folder / "V102_imu.txt", delimiter=",")
    imu_ns = np.loadtxt(folder / "V102_imu.txt", delimiter=",", usecols=0, dtype=np.int64)
    inside = (imu_ns > stamps[0]) & (imu_ns < stamps[-1])
    offset_s = (imu_ns[inside] - stamps[0]) * 1e-9
    sample = fitted.evaluate(offset_s)
    biases = [np.interp(offset_s, trajectory.time_s, truth[:, column]) for column in range(11, 17)]
    rate = imu[inside, 1:4] - np.stack(biases[:3], axis=1)
    force = imu[inside, 4:7] - np.stack(biases[3:], axis=1)
    rate_error = rate - sample.body_angular_rate_rad_s
    assert np.all(np.abs(np.mean(rate_error, axis=0)) < 1e-4)
    assert np.all(np.std(rate_error, axis=0) < 0.06)  # the airframe's vibration
    gravity = np.array([0.0, 0.0, 9.81])
    felt = sample.pose.rotor.inverse().apply(sample.world_acceleration_m_s2 + gravity)
    whole = len(felt) // 400 * 400
    over_2_s = (force - felt)[:whole].reshape(-1, 400, 3).mean(axis=1)
    assert np.all(np.std(over_2_s, axis=0) < 0.04)


def test_plainly_wrong_poses_do_not_keep_a_fit_from_settling(rng: np.random.Generator) -> None:
    """Undamped steps leap to and fro between them."""
    time_s = np.arange(0, 6, 1 / 30)
    path = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.sin(np.outer(time_s, [1.0, 1.3, 0.7]))),
        np.cos(np.outer(time_s, [0.8, 0.5, 1.1])),
    )
    coefficients = np.array(path.coefficients)
    wrong = rng.choice(len(time_s), 9, replace=False)
    coefficients[wrong] = (path[wrong] @ Motor.random(rng, (9,))).coefficients
    degraded = Trajectory((time_s * 1e9).astype(np.int64), Motor(coefficients))
    for spacing in (0.12, 0.3, 0.6):
        fitted = CumulativeBSpline.fit(degraded, spacing)
        off = (fitted.at(degraded.time_ns).inverse() @ path).as_twist()
        assert np.median(np.abs(off)) < 0.5
