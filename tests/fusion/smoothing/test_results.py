"""What a smoothed path carries: the same poses, covariances that hold, rates, and other times."""

import datetime

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers
from motorcade.fusion.smoothing import (
    METHODS,
    REPRESENTATIONS,
    ConstantVelocityFilter,
    LiveSmoother,
    SmoothingResult,
    smooth,
)
from motorcade.fusion.smoothing.auto import smoothed_automatically
from motorcade.fusion.smoothing.causal import smoothed_states
from motorcade.fusion.smoothing.results import _covariance
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

NS = 1_000_000_000
KNOWN = {"auto", "robust_map", "rts_constant_velocity", "rts_constant_acceleration"}
MODEL = {
    "robust_map": {"noise_m": 0.01, "noise_rad": 0.02, "angular_acceleration_rad_s2": 2.0},
    "rts_constant_velocity": {"noise_m": 0.01, "noise_rad": 0.02},
    "rts_constant_acceleration": {"noise_m": 0.01, "noise_rad": 0.02},
}


def true_and_noisy(seconds: float = 2.0) -> tuple[Trajectory, Trajectory]:
    true = MOTIONS["handheld"].sampled(30.0, seconds)
    return true, Gaussian(0.01, 0.02).apply(true, np.random.default_rng(3))


def rows_of(path: Trajectory) -> FloatArray:
    wxyz, position_m = path.motors.as_quaternion_translation()
    return np.concatenate([position_m, wxyz[:, 1:], wxyz[:, :1]], axis=-1)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_tells_what_it_knows(method: str) -> None:
    _, noisy = true_and_noisy()
    found = smooth(noisy, method, "rotor", full=True)
    assert isinstance(found, SmoothingResult)
    assert (found.method, found.representation) == (method, "rotor")
    same = smooth(noisy, method, "rotor")
    np.testing.assert_array_equal(found.trajectory.poses.coefficients, same.poses.coefficients)
    assert found.poses is found.trajectory
    assert found.weights.shape == (61,)
    assert found.body_twist.shape == (61, 6)
    assert (found.choice is not None) == (method == "auto")
    assert (found.covariance is not None) == (method in KNOWN)
    if found.covariance is not None:
        np.testing.assert_allclose(found.covariance, np.swapaxes(found.covariance, 1, 2))
        assert np.linalg.eigvalsh(found.covariance).min() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("method", sorted(KNOWN))
def test_errors_are_as_large_as_their_covariances_say(method: str) -> None:
    true, noisy = true_and_noisy(60.0)
    found = smooth(noisy, method, full=True, **MODEL.get(method, {}))
    off = found.trajectory.motors.local(true.motors)
    squares = np.einsum("ni,ni->n", off, np.linalg.solve(found.covariance, off[..., None])[..., 0])
    assert 0.6 < np.mean(squares) / 6.0 < 1.7


@pytest.mark.parametrize("method", ["auto", "robust_map"])
def test_wrong_poses_weigh_nothing_and_leave_what_lies_there_less_certain(method: str) -> None:
    _, noisy = true_and_noisy(4.0)
    rows = np.arange(60, 66)
    shifts = np.zeros((len(noisy), 3))
    shifts[rows] = [0.5, -0.3, 0.8]
    wrong = Trajectory(noisy.time_ns, Motor.from_translation(shifts) @ noisy.motors)
    found = smooth(wrong, method, full=True, **MODEL.get(method, {}))
    assert np.all(found.weights[rows] < 0.1)
    assert np.median(found.weights) > 0.7
    position_m = np.sqrt(np.einsum("nii->n", found.covariance[:, 3:, 3:]))
    assert position_m[62] > 1.3 * np.median(position_m)


@pytest.mark.parametrize("name", ["motor", "rotor", "quaternion", "dual_quaternion", "euler"])
def test_covariances_stand_in_the_moving_frame_whatever_was_averaged(name: str) -> None:
    """Against draws of what was averaged, a thousandth of its deviations off."""
    _, noisy = true_and_noisy(seconds=4.0)
    found = smooth(noisy, "auto", name, full=True)
    taken, rng = REPRESENTATIONS[name], np.random.default_rng(5)
    deviations = smoothed_automatically(noisy, name).deviations
    known = np.isfinite(deviations).all(axis=1)
    # What Euler angles leave out near their gimbal stays as measured.
    assert np.mean(known | (found.weights == 0.0)) > 0.98
    path, deviations = found.trajectory[known], deviations[known]
    base = taken.coordinates(path.poses)
    draws = [
        path.poses.local(
            taken.poses(taken.retract(base, 1e-3 * deviations * rng.normal(size=deviations.shape)))
        )
        for _ in range(200)
    ]
    drawn = 1e6 * np.einsum("kni,knj->nij", draws, draws) / len(draws)
    expected = np.sqrt(np.einsum("nii->ni", found.covariance[known]))
    ratio = np.sqrt(np.einsum("nii->ni", drawn)) / expected
    np.testing.assert_allclose(ratio.mean(axis=0), 1.0, atol=0.04)


def test_a_lag_of_auto_is_that_of_the_live_smoother() -> None:
    _, noisy = true_and_noisy()
    found = smooth(noisy, lag_s=0.1, full=True)
    expected = LiveSmoother(0.1).smooth(noisy)
    np.testing.assert_array_equal(found.trajectory.poses.coefficients, expected.poses.coefficients)
    assert found.choice is None
    assert found.covariance is None
    assert found.representation == "rotor"


def test_jumps_of_level_are_told_and_no_speed() -> None:
    true, noisy = true_and_noisy(10.0)
    shifts = np.zeros((len(noisy), 3))
    shifts[150:] = [1.0, -0.5, 0.3]
    jumped = Trajectory(noisy.time_ns, Motor.from_translation(shifts) @ noisy.motors)
    found = smooth(jumped, full=True)
    np.testing.assert_array_equal(found.jumps, [150])
    fastest = np.linalg.norm(smooth(true, full=True).world_velocity_m_s, axis=1).max()
    assert np.linalg.norm(found.world_velocity_m_s, axis=1).max() < 2.0 * fastest


def test_similarities_have_seven() -> None:
    true = MOTIONS["zoom"].sampled(30.0, 2.0)
    for name in ("similarity", "rotor"):
        noisy = Gaussian(0.01, 0.02).apply(true, np.random.default_rng(0))
        found = smooth(noisy, "auto", name, full=True)
        assert found.covariance.shape == (61, 7, 7)
        assert found.body_twist.shape == (61, 7)
        velocity = np.gradient(found.trajectory.poses.translation_m, 1 / 30, axis=0)[5:-5]
        np.testing.assert_allclose(found.world_velocity_m_s[5:-5], velocity, atol=0.02)


def test_what_cannot_be_told_is_nan_where_it_reaches() -> None:
    path, _ = true_and_noisy()
    variance = np.full((len(path), 6), 1e-6)
    variance[:, 4] = np.nan
    made = _covariance(path, REPRESENTATIONS["motor"], variance)
    assert np.all(np.isnan(made[:, 4, :]))
    assert np.all(np.isnan(made[:, :, 4]))
    rest = [0, 1, 2, 3, 5]
    np.testing.assert_allclose(made[10][np.ix_(rest, rest)], 1e-6 * np.eye(5), atol=1e-12)
    turned = _covariance(path, REPRESENTATIONS["rotor"], variance)
    np.testing.assert_allclose(turned[10][:3, :3], 1e-6 * np.eye(3), atol=1e-12)
    assert np.any(np.isnan(turned[10][3:, 3:]))


def test_rates_are_near_the_true_ones() -> None:
    motion = MOTIONS["handheld"]
    _, noisy = true_and_noisy(6.0)
    found = smooth(noisy, full=True)
    inside = slice(15, -15)
    true = motion.at(noisy.time_s[inside]).body_twist
    off = np.sqrt(np.mean((found.body_twist[inside] - true) ** 2, axis=0))
    by_differences = smooth(noisy, "gaussian", sigma_s=1e-3, full=True).body_twist[inside]
    raw = np.sqrt(np.mean((by_differences - true) ** 2, axis=0))
    assert np.all(off < 0.25 * raw)


def test_rates_are_those_that_the_filter_estimates() -> None:
    """Of a constant velocity both are the natural spline's, but for what turns do to each other."""
    _, noisy = true_and_noisy(4.0)
    found = smooth(noisy, "rts_constant_velocity", full=True)
    expected = smoothed_states(noisy, ConstantVelocityFilter()).rates[:, 0]
    np.testing.assert_allclose(found.body_twist, expected, atol=0.01 * np.abs(expected).max())


def test_other_times_come_as_the_poses_did() -> None:
    pandas = pytest.importorskip("pandas")
    _, path = true_and_noisy()
    rows, times_s = rows_of(path), np.array([0.0, 0.011, 1.2345])
    expected = smooth(path, "gaussian", full=True).at(np.round(1e9 * times_s).astype(np.int64))
    assert isinstance(expected, Trajectory)
    want = rows_of(expected)
    options = {"method": "gaussian", "full": True}

    def alike(made: FloatArray) -> None:
        signs = np.sign(np.sum(made[:, 3:] * want[:, 3:], axis=1, keepdims=True))
        np.testing.assert_allclose(made[:, :3], want[:, :3], atol=1e-9)
        np.testing.assert_allclose(made[:, 3:] * signs, want[:, 3:], atol=1e-9)

    by_rows = smooth(rows, time_s=path.time_s, **options)
    alike(by_rows.at(times_s))
    stamped = smooth(np.column_stack([path.time_s, rows]), **options).at(times_s)
    np.testing.assert_array_equal(stamped[:, 0], times_s)
    alike(stamped[:, 1:])
    matrices = smooth(path.motors.as_matrix(), time_s=path.time_s, **options).at(times_s)
    np.testing.assert_allclose(matrices, expected.motors.as_matrix(), atol=1e-9)
    rigid = RigidTransform.from_matrix(path.motors.as_matrix())
    assert isinstance(smooth(rigid, time_s=path.time_s, **options).at(times_s), RigidTransform)
    turned = smooth(Rotation.from_quat(rows[:, 3:]), time_s=path.time_s, **options).at(times_s)
    assert isinstance(turned, Rotation)
    start = datetime.datetime(2026, 5, 4, 12, tzinfo=datetime.UTC)
    moments = [start + datetime.timedelta(seconds=float(one)) for one in path.time_s]
    asked = [start + datetime.timedelta(seconds=float(one)) for one in times_s]
    np.testing.assert_allclose(
        smooth(rows, time_s=moments, **options).at(asked), by_rows.at(times_s), atol=2e-4
    )
    columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
    table = pandas.DataFrame(rows, columns=columns, index=pandas.to_datetime(moments, utc=True))
    index = pandas.to_datetime(asked, utc=True)
    made = smooth(table.assign(note="left out"), **options).at(index)
    assert made.index.equals(index)
    assert list(made.columns) == columns
    by_column = table.reset_index(drop=True).assign(t=path.time_s)
    again = smooth(by_column, **options).at(times_s)
    assert list(again.columns) == ["t", *columns]
    alike(again[columns].to_numpy())
    np.testing.assert_array_equal(again["t"], times_s)
    by_name = smooth({"hand": path.motors, "head": rows}, time_s=path.time_s, **options)
    assert isinstance(by_name["hand"].at(times_s), Motor)
    alike(by_name["head"].at(times_s))
    two = smooth(np.stack([rows, rows]), time_s=path.time_s, **options)
    assert len(two) == 2
    alike(two[1].at(times_s))


def test_other_times_of_evo_and_gtsam() -> None:
    trajectory = pytest.importorskip("evo.core.trajectory")
    gtsam = pytest.importorskip("gtsam")
    _, path = true_and_noisy()
    rows, times_s = rows_of(path), np.array([0.5, 0.75])
    theirs = trajectory.PoseTrajectory3D(rows[:, :3], rows[:, [6, 3, 4, 5]], path.time_s)
    made = smooth(theirs, "gaussian", full=True).at(times_s)
    np.testing.assert_array_equal(made.timestamps, times_s)
    poses = [gtsam.Pose3(matrix) for matrix in path.motors.as_matrix()]
    others = smooth(poses, "gaussian", time_s=path.time_s, full=True).at(times_s)
    np.testing.assert_allclose([one.translation() for one in others], made.positions_xyz, atol=1e-9)


def test_signs_go_on_between_given_ones() -> None:
    _, path = true_and_noisy()
    rows = rows_of(path)
    rows[30:, 3:] *= -1.0
    found = smooth(rows, "gaussian", time_s=path.time_s, full=True)
    times_s = path.time_s[:-1] + 0.4 / 30
    made = found.at(times_s)
    assert np.all(np.sum(made[:, 3:] * rows[:-1, 3:], axis=1) > 0.9)


@pytest.mark.parametrize(
    ("times", "says"),
    [
        ([0.0, 3.0], "expected stamps in"),
        ([1.0, 0.5], "strictly increasing"),
        (["2026-01-01"], "expected seconds or datetimes, got text"),
        ([np.nan], "finite"),
        (None, "expected"),
    ],
)
def test_no_times_are_refused(times: object, says: str) -> None:
    _, path = true_and_noisy()
    with pytest.raises(ValueError, match=says):
        smooth(rows_of(path), "gaussian", time_s=path.time_s, full=True).at(times)
    if times is not None and isinstance(times[0], float):
        with pytest.raises(ValueError, match="expected integer nanoseconds"):
            smooth(path, "gaussian", full=True).at(times)


def test_outliers_of_a_stream_of_them_are_told() -> None:
    _, noisy = true_and_noisy(10.0)
    wild = Outliers(0.05, 0.5, 1.0).apply(noisy, np.random.default_rng(1))
    far = np.linalg.norm(wild.motors.local(noisy.motors)[:, 3:], axis=1) > 0.2
    found = smooth(wild, full=True)
    assert np.all(found.weights[far] < 0.1)
    assert found.choice.outliers == pytest.approx(np.mean(found.weights == 0.0))
