"""Each fault is named with its mend, sound recordings raise none, slow ones are not blamed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from motorcade.fusion.health import check_health
from motorcade.fusion.health.accelerometer import Pushes
from motorcade.fusion.health.check import check_stamps, count_faults
from motorcade.fusion.health.gyroscope import TurnedAngle
from motorcade.fusion.health.models import SIGNED_PERMUTATIONS, Prior, fit, order_of
from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Outliers
from motorcade.ga import Motor, Rotor, Trajectory
from tests.fusion.health.cases import (
    EXTRINSICS,
    FAULTS,
    FLIGHTS,
    Case,
    case,
    checked,
    flown,
    simulated,
)

# One of each kind; the slow test has them all.
QUICK = (
    "deg/s",
    "g",
    "lunar gravity",
    "left-handed",
    "extrinsics transposed",
    "stamps in µs from 0",
    "accelerometer frozen at half",
    "positions in inches",
    "accelerometer clipped",
    "poses inverted",
)
REST_NS = 5_000_000 * np.arange(6001)


@pytest.fixture(scope="module")
def handheld() -> Case:
    return simulated("handheld", duration_s=20.0)


@pytest.fixture(scope="module")
def walked() -> Case:
    return simulated("walk_and_look", duration_s=20.0)


@pytest.mark.parametrize("fault", ["none", *QUICK])
def test_every_fault_of_a_simulated_recording_is_named(fault, handheld, walked):
    found, right = checked(fault, handheld, walked)
    assert right, found.summary


@pytest.mark.parametrize(
    ("motion", "fault"),
    [
        ("stop_and_go", "gyroscope by 1.2"),
        ("stop_and_go", "gyroscope's z by 1.3"),
        ("stop_and_go", "gyroscope clipped"),
        ("tumble", "accelerometer clipped"),
        ("tumble", "1.5 s late"),
        ("gimbal_hover", "extrinsics off by 20°"),
        ("gimbal_hover", "accelerometer clipped"),
    ],
)
def test_faults_are_named_where_motion_stops_hovers_or_repeats(motion, fault):
    """Or are said to be below what the motion shows."""
    drawn = simulated(motion, seed=7)
    found, right = checked(fault, drawn, drawn)
    assert right, found.summary


def test_the_mend_mends(handheld):
    """What the lines say, done: the verdict is then that nothing is wrong."""
    late, _ = checked("half a second late", handheld, handheld)
    offset_s = float(late.summary.split("add ")[1].split(" s")[0])
    moved = ImuStream(
        handheld.imu.time_ns + 500_000_000,
        handheld.imu.angular_rate_rad_s,
        handheld.imu.specific_force_m_s2,
    )
    path = handheld.poses.trajectory
    assert check_health(path, moved, handheld.imu_T_camera, time_offset_s=offset_s).sound


QUARTER = Motor.from_euler_translation(np.array([0.0, 0.0, np.pi / 2]), np.zeros(3))
HALF = np.diag([-1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def looking_aside() -> Case:
    return simulated("handheld", "quarter", duration_s=20.0)


@pytest.mark.parametrize("fault", ["z negated", "left-handed", "extrinsics transposed"])
def test_both_sensors_tell_what_one_does_not(fault, looking_aside):
    """Under a quarter turn the inverse of extrinsics is the same as two axes negated."""
    found, right = checked(fault, looking_aside, looking_aside)
    assert right, found.summary


def test_a_fault_that_looks_like_another_is_told_by_both_names(looking_aside):
    found, _ = checked("extrinsics transposed", looking_aside, looking_aside)
    assert found.summary == (
        "either imu_T_camera is the wrong way round (transposed): give its inverse, or the IMU's "
        "axes are in another order as they come: put the readings as (-x, -y, z) for (x, y, z) "
        "(no measurement tells which)"
    )


def test_no_measurement_tells_an_inverse_from_two_negated_axes(handheld):
    """Either mend makes the same evidence, to the last digit: rates and forces at the camera."""
    camera, imu = handheld.poses.trajectory, handheld.imu
    negated = ImuStream(imu.time_ns, imu.angular_rate_rad_s @ HALF, imu.specific_force_m_s2 @ HALF)
    felt = [
        np.einsum(
            "kijl,jl->ki",
            Pushes.of(camera, stream, 0.0, 100).force,
            extrinsics.inverse().rotor.as_matrix(),
        )
        for stream, extrinsics in ((imu, QUARTER.inverse()), (negated, QUARTER))
    ]
    np.testing.assert_allclose(felt[0], felt[1], atol=1e-12)
    one, other = (
        TurnedAngle(stream).at(camera.time_ns[::20]) @ extrinsics.rotor.as_matrix()
        for stream, extrinsics in ((imu, QUARTER.inverse()), (negated, QUARTER))
    )
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_two_faults_at_once_are_both_named(handheld):
    imu = handheld.imu
    wrong = ImuStream(imu.time_ns, imu.angular_rate_rad_s, -imu.specific_force_m_s2)
    found = check_health(handheld.poses.trajectory, wrong, handheld.imu_T_camera.inverse())
    assert found.faults == ("extrinsics_inverted", "force_sign"), found.summary


def test_faults_are_counted_by_what_went_wrong():
    same, flip, swap = np.eye(3), np.diag([1.0, 1.0, -1.0]), np.eye(3)[[1, 0, 2]]
    assert count_faults(("stated", same), same) == 0
    assert count_faults(("inverted", same), same) == 1
    assert count_faults(("stated", flip), flip) == 1
    assert count_faults(("stated", -flip), flip) == 1  # left-handed
    assert count_faults(("stated", same), -same) == 1
    assert count_faults(("inverted", same), -same) == 2
    assert count_faults(("inverted", -same), -same) == 2
    assert count_faults(("stated", flip), swap) == 2


@pytest.mark.parametrize("rate_hz", [0.5, 1.0, 2.0, 3.0])
def test_rare_poses_raise_no_alarm(rng, rate_hz):
    path = ContinuousPath.along(MOTIONS["gimbal_crossing"], 240.0)
    sensor = simulate_imu(path, 200.0, ADIS16448, rng)
    poses = simulate_camera_poses(sensor.path, rate_hz, 0.01, np.deg2rad(0.5), rng)
    found = check_health(poses.trajectory, sensor.stream, Motor.identity())
    assert found.sound, found.summary
    if rate_hz < 2.5:
        assert any("cannot tell the gyroscope's unit" in line for line in found.unknown)


def at_rest(rng: np.random.Generator) -> tuple[Trajectory, ImuStream]:
    """A camera that lies still, its poses and readings noisy."""
    poses = Motor.from_twist(rng.standard_normal((600, 6)) * np.repeat([0.01, 0.01], 3))
    rate = 2e-3 * rng.standard_normal((len(REST_NS), 3))
    force = np.array([0.0, 0.0, 9.81]) + 0.02 * rng.standard_normal((len(REST_NS), 3))
    return Trajectory(50_000_000 * np.arange(600), poses), ImuStream(REST_NS, rate, force)


def test_a_camera_at_rest_is_not_blamed(rng):
    path, imu = at_rest(rng)
    found = check_health(path, imu, Motor.identity())
    assert found.sound
    assert any("cannot tell the gyroscope's unit" in line for line in found.unknown)


@pytest.mark.parametrize(("factor", "fault"), [(-1.0, "force_sign"), (1 / 9.80665, "force_unit")])
def test_gravity_alone_tells_sign_and_unit_where_up_is_known(rng, factor, fault):
    path, imu = at_rest(rng)
    wrong = ImuStream(imu.time_ns, imu.angular_rate_rad_s, factor * imu.specific_force_m_s2)
    assert check_health(path, wrong, Motor.identity()).faults == (fault,)


def test_outliers_raise_no_alarm(handheld):
    extrinsics = handheld.imu_T_camera
    for share in (0.1, 0.3):
        wild = case(handheld.truth, handheld.imu, extrinsics, 3, Outliers(share, 1.0, 0.8))
        found, _ = checked("none", wild, wild)
        assert found.sound, found.summary


@pytest.mark.parametrize("axis", range(3))
def test_a_scale_of_one_axis_is_named_with_its_mend(handheld, axis):
    sizes = np.where(np.arange(3) == axis, 1.5, 1.0)
    rates = handheld.imu.angular_rate_rad_s * sizes
    wrong = ImuStream(handheld.imu.time_ns, rates, handheld.imu.specific_force_m_s2)
    found = check_health(handheld.poses.trajectory, wrong, handheld.imu_T_camera)
    assert found.faults == ("rate_scale",)
    assert f"gyroscope's {'xyz'[axis]} reads 1." in found.summary
    mend = float(found.summary.rsplit(" ", 1)[1])
    assert abs(mend * 1.5 - 1.0) < 0.05


@pytest.mark.parametrize("scale", [0.85, 1.0, 1.15])
def test_a_scale_that_looks_like_a_bias_is_named_and_its_mend_mends(rng, scale):
    """Who keeps level cannot tell them apart; that it is either is said."""
    circling = MOTIONS["distant_circle"].sampled(100.0, 20.0)
    tilts = Rotor.from_rotation_vector(np.outer(np.sin(0.9 * circling.time_s), [0.05, -0.1, 0.3]))
    level = Motor.from_rotor_translation(tilts, circling.motors.translation_m)
    path = ContinuousPath.through(Trajectory(circling.time_ns, level, "world", "imu"))
    sensor = simulate_imu(path, 200.0, ADIS16448, rng)
    drawn = case(sensor.path, sensor.stream, EXTRINSICS["askew"], 0, None)
    stream = ImuStream(
        drawn.imu.time_ns, drawn.imu.angular_rate_rad_s, scale * drawn.imu.specific_force_m_s2
    )
    found = check_health(drawn.poses.trajectory, stream, drawn.imu_T_camera)
    assert found.faults == (() if scale == 1.0 else ("force_scale",))
    if scale != 1.0:
        mend = float(found.summary.split("multiply it by ")[1].split(",")[0])
        assert abs(mend * scale - 1.0) < 0.05


def test_readings_that_are_cut_off_are_named(handheld):
    rates = handheld.imu.angular_rate_rad_s
    most = np.quantile(np.abs(rates), 0.97)
    wrong = ImuStream(
        handheld.imu.time_ns, np.clip(rates, -most, most), handheld.imu.specific_force_m_s2
    )
    found = check_health(handheld.poses.trajectory, wrong, handheld.imu_T_camera)
    assert set(found.faults) == {"saturated"}


def test_axes_that_the_motion_leaves_at_zero_are_not_dead():
    """A turntable without noise: two of its rates are exactly zero."""
    stamps = 5_000_000 * np.arange(4001)
    seconds = 1e-9 * stamps
    angle = np.sin(seconds)
    poses = Motor.from_euler_translation(
        np.stack([np.zeros_like(angle), np.zeros_like(angle), angle], axis=-1), np.zeros(3)
    )
    rates = np.stack([0.0 * angle, 0.0 * angle, np.cos(seconds)], axis=-1)
    forces = np.tile([0.0, 0.0, 9.81], (len(stamps), 1))
    path = Trajectory(stamps[::10], poses[::10])
    found = check_health(path, ImuStream(stamps, rates, forces), Motor.identity())
    assert "stuck" not in found.faults, found.summary


def test_a_world_that_leans_is_said_to(handheld):
    lean = Motor.from_euler_translation(np.array([0.3, 0.0, 0.0]), np.zeros(3))
    path = handheld.poses.trajectory.transformed_by(left=lean)
    given = path, handheld.imu, handheld.imu_T_camera
    found = check_health(*given)
    assert found.faults == ("lean",)
    assert "17° from up" in found.summary
    assert check_health(*given, up=False).sound


def test_gravity_of_unknown_direction_has_a_size(handheld):
    given = handheld.poses.trajectory, handheld.imu, handheld.imu_T_camera
    assert check_health(*given, up=False).sound
    assert check_health(*given, up=False, gravity_m_s2=1.62).faults == ("gravity",)


def test_fits_are_the_most_likely_ones(rng):
    """Against a general optimiser on the same likelihood."""
    slope = rng.standard_normal((60, 3, 4))
    target = slope @ np.array([1.0, -2.0, 0.5, 3.0]) + 0.1 * rng.standard_cauchy((60, 1))
    target = target + 0.1 * rng.standard_normal((60, 3))
    prior = Prior(np.zeros(4), np.full(4, 5.0))

    def cost(given: np.ndarray) -> float:
        scale = np.exp(given[4])
        square = np.sum((target - slope @ given[:4]) ** 2, axis=-1)
        likelihood = 2.0 * np.sum(np.log1p(square / scale)) + 90.0 * np.log(scale)
        return float(likelihood + 0.5 * np.sum((given[:4] / 5.0) ** 2))

    found = fit(target, slope, prior, np.zeros(4))
    best = minimize(cost, np.append(found.values, 2.0 * np.log(found.sigma)), tol=1e-10)
    assert -found.score == pytest.approx(best.fun, abs=0.05)
    np.testing.assert_allclose(found.values, best.x[:4], atol=0.3 * found.deviations.max())


def test_deviations_are_those_of_the_errors():
    rng = np.random.default_rng(5)
    squares = []
    for _ in range(60):
        slope = rng.standard_normal((80, 3, 2))
        noise = rng.standard_normal((80, 3)) / np.sqrt(rng.chisquare(1, (80, 1)))
        target = slope @ np.array([1.0, 2.0]) + 0.1 * noise
        found = fit(target, slope, Prior(np.zeros(2), np.full(2, 1e3)), np.zeros(2))
        squares.append(((found.values - [1.0, 2.0]) / found.deviations) ** 2)
    assert 0.7 < np.mean(squares) < 1.4


def test_three_quarters_of_the_rows_may_be_wild(rng):
    slope = rng.standard_normal((400, 3, 2))
    target = slope @ np.array([1.0, 2.0]) + 0.01 * rng.standard_normal((400, 3))
    target[:280] += 50.0 * rng.standard_normal((280, 3))
    found = fit(target, slope, Prior(np.zeros(2), np.full(2, 1e3)), np.array([1.0, 1.9]))
    np.testing.assert_allclose(found.values, [1.0, 2.0], atol=0.02)


def test_there_are_forty_eight_orders_of_axes():
    made = np.array(SIGNED_PERMUTATIONS)
    assert len(np.unique(made.reshape(48, 9), axis=0)) == 48
    np.testing.assert_array_equal(made @ made.swapaxes(-1, -2), np.tile(np.eye(3), (48, 1, 1)))
    np.testing.assert_array_equal(made[0], np.eye(3))
    np.testing.assert_array_equal(made[1], -np.eye(3))
    assert order_of(np.array([[0, -1, 0], [0, 0, 1], [1, 0, 0]])) == "(-y, z, x)"


def test_windows_take_accelerations_exactly():
    """A perfect sensor along a perfect path leaves gravity, however it moves."""
    path = ContinuousPath.along(MOTIONS["walk_and_look"], 12.0, start_ns=10**18)
    tiny = ADIS16448.scaled(1e-6)
    sensor = simulate_imu(path, 400.0, tiny, np.random.default_rng(0))
    extrinsics = EXTRINSICS["askew"]
    camera = sensor.path.transformed_by(right=extrinsics)
    pushes = Pushes.of(camera, sensor.stream, 0.0, 100)
    camera_T_imu = extrinsics.inverse()
    felt = np.einsum("kijl,jl->ki", pushes.force, camera_T_imu.rotor.as_matrix())
    arm = pushes.lever @ camera_T_imu.translation_m
    left = pushes.acceleration_m_s2 + arm - felt - np.array([0.0, 0.0, -9.81])
    assert np.max(np.abs(left)) < 0.02


@pytest.mark.parametrize(
    ("poses", "imu", "line"),
    [
        (1, 1000, "the IMU's stamps are in µs"),
        (1000, 1, "the poses' stamps are in µs"),
        (10**6, 10**6, "the poses' stamps are in ms and the IMU's stamps are in ms"),
    ],
)
def test_units_of_stamps_are_told(poses, imu, line):
    start = 1_700_000_000_000_000_000
    given = start + 50_000_000 * np.arange(400), start + 5_000_000 * np.arange(4000)
    assert check_stamps(*given) is None
    found = check_stamps(given[0] // poses, given[1] // imu)
    assert found is not None
    assert found.summary.startswith(line)
    assert check_stamps(given[0] + 10**12, given[1]) is None  # clocks apart are no unit


@pytest.mark.slow
@pytest.mark.parametrize("name", FLIGHTS)
@pytest.mark.parametrize("extrinsics", EXTRINSICS)
def test_every_fault_of_a_flight_is_named(data_dir: Path, name, extrinsics):
    others = list(FLIGHTS)
    one = flown(name, data_dir, extrinsics)
    other = flown(others[others.index(name) - 1], data_dir, extrinsics)
    missed = {
        fault: found.summary
        for fault, (found, right) in (
            (fault, checked(fault, one, other)) for fault in ("none", *FAULTS)
        )
        if not right
    }
    assert not missed
