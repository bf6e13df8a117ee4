"""The curve through smoothed poses: it meets them, its rates are its derivatives, and scipy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.smoothing import PathCurve
from motorcade.ga import Motor, Trajectory

NS = 1_000_000_000


def uneven(seed: int, count: int = 30) -> np.ndarray:
    """Stamps whose steps differ by up to a factor of two, which leaves no gap."""
    steps = np.random.default_rng(seed).uniform(0.03, 0.06, count - 1)
    return np.concatenate([[0], np.cumsum(np.round(1e9 * steps).astype(np.int64))])


@pytest.mark.parametrize("name", MOTIONS)
def test_it_meets_poses_and_rates_are_its_derivatives(name: str) -> None:
    motion = MOTIONS[name]
    path = motion.sampled(30.0, 2.0)
    curve = PathCurve(path)
    met = curve.twists(path.time_ns)
    np.testing.assert_allclose(met.pose.coefficients, path.poses.coefficients, atol=1e-12)
    np.testing.assert_allclose(met.body_twist, curve.body_twist, atol=1e-9)
    between = np.arange(NS // 10, 19 * NS // 10, 17_000_001)
    step = 10_000
    by_differences = curve.at(between - step).local(curve.at(between + step)) / (2e-9 * step)
    found = curve.twists(between)
    np.testing.assert_allclose(found.body_twist, by_differences, atol=1e-6)
    true = motion.at(1e-9 * between)
    scale = np.abs(true.body_twist).max()
    np.testing.assert_allclose(found.body_twist, true.body_twist, atol=1e-3 * scale)


def test_the_derivative_of_the_rates_is_told_within_a_step() -> None:
    curve = PathCurve(MOTIONS["fast_spin"].sampled(20.0, 2.0))
    middles = np.arange(NS // 2 + 25_000_000, 3 * NS // 2, 50_000_000)
    step = 10_000
    later, earlier = (curve.twists(middles + one).body_twist for one in (step, -step))
    rate = curve.twists(middles).body_twist_rate
    np.testing.assert_allclose(rate, (later - earlier) / (2e-9 * step), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_positions_follow_scipys_natural_spline(seed: int) -> None:
    time_ns = uneven(seed)
    position_m = np.cumsum(np.random.default_rng(seed).normal(size=(len(time_ns), 3)), axis=0)
    curve = PathCurve(Trajectory(time_ns, Motor.from_translation(position_m)))
    witness = CubicSpline(1e-9 * time_ns, position_m, bc_type="natural")
    between = np.arange(0, time_ns[-1], 9_999_999)
    found = curve.twists(between)
    np.testing.assert_allclose(found.pose.translation_m, witness(1e-9 * between), atol=1e-9)
    np.testing.assert_allclose(found.body_twist[:, 3:], witness(1e-9 * between, 1), atol=1e-8)
    np.testing.assert_allclose(found.body_twist_rate[:, 3:], witness(1e-9 * between, 2), atol=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_rotations_follow_scipys_spline(seed: int) -> None:
    """Steps turn by some degrees; scipy solves for an acceleration without any leap."""
    time_ns = uneven(seed)
    motors = MOTIONS["tumble"].at(1e-9 * time_ns).pose
    xyzw = motors.as_quaternion_translation()[0][:, [1, 2, 3, 0]]
    witness = RotationSpline(1e-9 * time_ns, Rotation.from_quat(xyzw))
    between = np.arange(time_ns[3], time_ns[-3], 9_999_999)
    found = PathCurve(Trajectory(time_ns, motors)).twists(between)
    off = Rotation.from_matrix(found.pose.as_matrix()[:, :3, :3]).inv() * witness(1e-9 * between)
    assert off.magnitude().max() < 5e-5
    true = MOTIONS["tumble"].at(1e-9 * between).body_twist[:, :3]
    ours, theirs = (
        np.abs(one - true).max() for one in (found.body_twist[:, :3], witness(1e-9 * between, 1))
    )
    assert ours < 1.05 * theirs
    np.testing.assert_allclose(found.body_twist[:, :3], witness(1e-9 * between, 1), atol=2e-3)


@given(st.lists(st.sampled_from([1, 1, 1, 5, 60]), min_size=1, max_size=12), st.integers(0, 99))
def test_across_gaps_it_is_the_screw(steps: list[int], seed: int) -> None:
    """Single poses too; elsewhere one segment knows nothing of the other."""
    time_ns = np.concatenate([[0], np.cumsum(steps)]) * (NS // 10)
    twists = 0.3 * np.random.default_rng(seed).normal(size=(len(time_ns), 6))
    path = Trajectory(time_ns, Motor.from_twist(twists))
    curve = PathCurve(path)
    middles = (time_ns[:-1] + time_ns[1:]) // 2
    gaps = np.diff(time_ns) > 3.0 * np.median(np.diff(time_ns))
    found = curve.at(middles)
    assert np.all(np.isfinite(curve.body_twist))
    assert np.all(np.isfinite(found.coefficients))
    straight = path.at(middles)
    np.testing.assert_allclose(
        found.local(straight)[gaps], np.zeros((np.count_nonzero(gaps), 6)), atol=1e-12
    )
    if len(steps) > 1 and gaps[-1]:
        moved = np.concatenate([path.motors.coefficients[:-1], Motor.identity().coefficients[None]])
        other = PathCurve(Trajectory(time_ns, Motor(moved))).at(middles[:-1])
        np.testing.assert_allclose(found[:-1].local(other), 0.0, atol=1e-12)


def test_a_jump_leaves_no_ripple_beside_it() -> None:
    true = MOTIONS["handheld"].sampled(30.0, 2.0)
    shifts = np.zeros((len(true), 3))
    shifts[30:] = [0.5, 0.0, 0.2]
    moved = Trajectory(true.time_ns, Motor.from_translation(shifts) @ true.motors)
    curve = PathCurve(moved, np.array([30]))
    for part in (slice(0, 30), slice(30, None)):
        alone = PathCurve(true[part])
        np.testing.assert_allclose(curve.body_twist[part], alone.body_twist, atol=1e-9)
    with pytest.raises(ValueError, match=r"expected rows from 1 to 60, got \[61\]"):
        PathCurve(moved, np.array([61]))


def test_a_frame_of_the_world_changes_nothing_in_the_body(rng: np.random.Generator) -> None:
    path = MOTIONS["handheld"].sampled(30.0, 2.0)
    left = Motor.random(rng)
    moved = PathCurve(path.transformed_by(left=left))
    curve, between = PathCurve(path), np.arange(0, 2 * NS, 12_345_678)
    np.testing.assert_allclose(moved.body_twist, curve.body_twist, atol=1e-10)
    off = (left @ curve.at(between)).local(moved.at(between))
    np.testing.assert_allclose(off, 0.0, atol=1e-11)


def test_what_is_no_place_on_the_curve_is_refused() -> None:
    path = MOTIONS["screw"].sampled(30.0, 1.0)
    with pytest.raises(ValueError, match="expected two poses or more"):
        PathCurve(path[:1])
    with pytest.raises(
        ValueError, match=r"expected stamps in \[0, 1000000000\], got -1 and 1 more"
    ):
        PathCurve(path).at([-1, 5, NS + 1])
    with pytest.raises(ValueError, match="expected integer nanoseconds"):
        PathCurve(path).at([0.5])
