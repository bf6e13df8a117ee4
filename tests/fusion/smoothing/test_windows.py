"""Moving Gaussian and Savitzky-Golay: SciPy's on Euclidean data, frame-blind on motors."""

from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import REPRESENTATIONS, smooth
from motorcade.ga import Motor, Rotor, Trajectory, mean
from motorcade.ga.arrays import FloatArray, IntArray

STEP_NS = 33_333_333
SCREW = np.array([0.3, 1.0, 0.5, 0.1, 0.2, -0.4])


def even(count: int) -> IntArray:
    return np.arange(count, dtype=np.int64) * STEP_NS


def uneven(rng: np.random.Generator, count: int) -> IntArray:
    return np.cumsum(rng.integers(5_000_000, 60_000_000, count)).astype(np.int64)


def shifts(positions: FloatArray, time_ns: IntArray) -> Trajectory:
    """Positions without rotation, on which every representation is Euclidean."""
    return Trajectory(time_ns, Motor.from_translation(positions))


def noisy_path(rng: np.random.Generator, time_ns: IntArray) -> Trajectory:
    """A fast wandering path: 4 rad/s and 2 m/s, noise of 0.05 rad and m, far from the origin."""
    seconds = (time_ns * 1e-9)[:, None]
    wave = np.sin(seconds * np.array([2.0, 1.5, 2.5, 1.0, 0.7, 0.9]) + np.arange(6))
    motion = Motor.random(rng, extent_m=3.0) @ Motor.from_twist(2.0 * wave)
    noise = Motor.from_twist(0.05 * rng.standard_normal((len(time_ns), 6)))
    return Trajectory(time_ns, motion @ noise)


def apart(a: Trajectory, b: Trajectory) -> float:
    return float(np.abs((a.poses.inverse() @ b.poses).as_twist()).max())


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("samples", [0.8, 2.4, 5.0])
@pytest.mark.parametrize("order", [0, 1])
def test_gaussian_is_scipys_away_from_the_ends(
    representation: str, samples: float, order: int, rng: np.random.Generator
) -> None:
    positions = rng.standard_normal((200, 3))
    path = shifts(positions, even(200))
    found = smooth(path, "gaussian", representation, sigma_s=samples * STEP_NS * 1e-9, order=order)
    expected = gaussian_filter1d(positions, samples, axis=0, truncate=4.0, radius=int(4 * samples))
    inner = slice(20, -20)
    np.testing.assert_allclose(
        found.poses.translation_m[inner], expected[inner], rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize(("count", "order"), [(5, 2), (9, 3), (21, 4), (7, 0), (3, 1)])
def test_savitzky_golay_is_scipys_up_to_the_ends(
    representation: str, count: int, order: int, rng: np.random.Generator
) -> None:
    positions = rng.standard_normal((90, 3))
    window_s = count * STEP_NS * 1e-9
    path = shifts(positions, even(90))
    found = smooth(path, "savitzky_golay", representation, window_s=window_s, order=order)
    expected = savgol_filter(positions, count, order, axis=0, mode="interp")
    np.testing.assert_allclose(found.poses.translation_m, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_gaussian_on_uneven_stamps_is_numpys_weighted_polynomial(
    order: int, rng: np.random.Generator
) -> None:
    time_ns = uneven(rng, 80)
    positions = rng.standard_normal((80, 3))
    found = smooth(shifts(positions, time_ns), "gaussian", sigma_s=0.1, order=order)
    for i in (0, 1, 40, 79):
        t = (time_ns - time_ns[i]) / 0.1e9
        near = np.abs(t) <= 4.0
        weight = np.exp(-0.25 * t[near] ** 2)  # polyfit squares its weights
        for axis in range(3):
            fitted = np.polyfit(t[near], positions[near, axis], order, w=weight)[-1]
            assert found.poses.translation_m[i, axis] == pytest.approx(fitted, abs=1e-10)


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        ("gaussian", {"sigma_s": 0.1}),
        ("gaussian", {"sigma_s": 0.1, "order": 0}),
        ("savitzky_golay", {"window_s": 0.3, "order": 3}),
        ("local_polynomial", {"window_s": 0.3}),
    ],
)
@pytest.mark.parametrize("stamps", [even, None], ids=["even", "uneven"])
def test_motors_do_not_notice_in_which_frames_they_are_written(
    method: str, parameters: dict[str, Any], stamps: Any, rng: np.random.Generator
) -> None:
    path = noisy_path(rng, even(300) if stamps is not None else uneven(rng, 300))
    found = smooth(path, method, **parameters)
    assert apart(found, path) > 0.01
    for change in ({"left": Motor.random(rng)}, {"right": Motor.random(rng)}):
        moved_first = smooth(path.transformed_by(**change), method, **parameters)
        assert apart(moved_first, found.transformed_by(**change)) < 1e-10
        euler = smooth(path.transformed_by(**change), method, "euler_unwrapped", **parameters)
        euler_after = smooth(path, method, "euler_unwrapped", **parameters)
        assert apart(euler, euler_after.transformed_by(**change)) > 1e-3, "the test can tell"


@pytest.mark.parametrize("method", ["gaussian", "savitzky_golay"])
def test_a_constant_screw_stays_as_it_is_at_any_stamps(
    method: str, rng: np.random.Generator
) -> None:
    time_ns = uneven(rng, 200)
    path = Trajectory(time_ns, Motor.from_twist(SCREW * (time_ns * 1e-9)[:, None]))
    assert apart(smooth(path, method), path) < 1e-12
    if method == "gaussian":
        assert apart(smooth(path, method, order=0), path) > 1e-3, "a plain mean is drawn aside"


@pytest.mark.parametrize("method", ["gaussian", "savitzky_golay"])
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_short_paths_are_smoothed_or_refused(
    method: str, count: int, rng: np.random.Generator
) -> None:
    path = noisy_path(rng, uneven(rng, count))
    if method == "savitzky_golay" and count < 3:
        with pytest.raises(ValueError, match=f"at least 3 poses, got {count}"):
            smooth(path, method)
    else:
        assert len(smooth(path, method)) == count


def test_a_pose_alone_in_its_window_stays(rng: np.random.Generator) -> None:
    time_ns = np.array([0, 1, 2, 3, 400, 401, 900], dtype=np.int64) * STEP_NS
    path = Trajectory(time_ns, Motor.random(rng, (7,)))
    found = smooth(path, "gaussian", sigma_s=0.1)
    assert np.abs((found.poses[6].inverse() @ path.poses[6]).as_twist()).max() < 1e-9


def test_long_windows_and_long_paths_agree_with_short_segments(rng: np.random.Generator) -> None:
    """Segments of different lengths are computed in different batches; poses do not notice."""
    path = noisy_path(rng, uneven(rng, 5000))
    whole = smooth(path, "gaussian", sigma_s=0.05)
    part = smooth(path[1500:2600], "gaussian", sigma_s=0.05)
    inner = Trajectory(part.time_ns[100:-100], part.poses[100:-100])
    assert apart(inner, whole[1600:2500]) < 1e-14


@pytest.mark.parametrize(
    ("method", "parameters", "message"),
    [
        ("gaussian", {"sigma_s": 0.0}, "sigma_s: expected a positive number of seconds, got 0"),
        ("gaussian", {"sigma_s": float("nan")}, "sigma_s"),
        ("gaussian", {"truncate": 9.0}, "truncate: expected above 0 and at most 8, got 9"),
        ("gaussian", {"order": 1.5}, "order: expected 0 to 5, got 1.5"),
        ("savitzky_golay", {"window_s": -1.0}, "window_s: expected a positive number"),
        ("savitzky_golay", {"order": 6}, "order: expected 0 to 5, got 6"),
        ("gaussian", {"sigma": 1.0}, "gaussian sigma_s, truncate, order, got 'sigma'"),
        ("spline9", {}, r"method: expected one of .*gaussian.*got 'spline9'"),
    ],
)
def test_bad_settings_are_refused(
    method: str, parameters: dict[str, Any], message: str, rng: np.random.Generator
) -> None:
    path = noisy_path(rng, even(20))
    with pytest.raises(ValueError, match=message):
        smooth(path, method, **parameters)


def test_an_order_beyond_all_bounds_is_refused(rng: np.random.Generator) -> None:
    path = Trajectory(np.arange(9) * 33_333_333, Motor.random(rng, (9,)))
    with pytest.raises(ValueError, match="order: expected 0 to 5, got inf"):
        smooth(path, "gaussian", order=float("inf"))


@pytest.mark.parametrize("representation", ["motor", "rotor", "similarity"])
def test_averages_are_karcher_means(representation: str, rng: np.random.Generator) -> None:
    """Where they end the weighted vectors to the poses cancel, wherever they were begun."""
    path = noisy_path(rng, even(60))
    found = smooth(path, "gaussian", representation, sigma_s=0.15, order=0)
    one = REPRESENTATIONS[representation]
    x, centres = (one.coordinates(p.poses) for p in (path, found))
    offset_s = (path.time_ns[None] - path.time_ns[:, None]) * 1e-9
    weight = np.where(np.abs(offset_s) <= 0.6, np.exp(-0.5 * (offset_s / 0.15) ** 2), 0.0)
    weight /= weight.sum(axis=1, keepdims=True)
    vectors = one.local(x[None], centres[:, None])
    assert np.abs(np.einsum("ij,ijd->id", weight, vectors)).max() < 1e-10
    if representation == "motor":
        witness = mean(path.motors[12:49], weight[30, 12:49])
        assert np.abs((found.motors[30].inverse() @ witness).as_twist()).max() < 1e-10


def test_means_of_rotations_are_scipys_where_these_are_close(rng: np.random.Generator) -> None:
    """SciPy's is the chordal mean: the same up to the cube of the spread."""
    turns = 0.02 * rng.standard_normal((9, 3))
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turns), np.zeros(3))
    found = smooth(Trajectory(even(9), poses), "gaussian", "rotor", sigma_s=0.1, order=0)
    weight = np.exp(-0.5 * ((even(9) - even(9)[4]) * 1e-9 / 0.1) ** 2)
    witness = Rotation.from_rotvec(turns).mean(weights=weight).as_rotvec()
    assert np.abs(found.motors[4].rotor.as_rotation_vector() - witness).max() < 0.02**3


def test_twists_do_not_keep_the_noise_of_the_pose_they_were_begun_from() -> None:
    """One step from the noisy pose left twice the jitter that components leave on a screw."""
    true = MOTIONS["screw"].sampled(rate_hz=30.0, duration_s=12.0)
    noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, np.random.default_rng(0))
    left = {}
    for name in ("motor", "dual_quaternion"):
        jitter = evaluate(smooth(noisy, "gaussian", name, sigma_s=0.2), true).jitter
        assert jitter is not None
        left[name] = np.array([jitter.linear_m_s2, jitter.angular_rad_s2])
    np.testing.assert_allclose(left["motor"], left["dual_quaternion"], rtol=0.02)
    assert np.all(left["motor"] < left["dual_quaternion"])


def test_poses_too_far_apart_for_a_mean_stay_finite(rng: np.random.Generator) -> None:
    path = Trajectory(even(50), Motor.random(rng, (50,)))
    for method in ("gaussian", "savitzky_golay", "local_polynomial"):
        assert np.all(np.isfinite(smooth(path, method).poses.coefficients))
