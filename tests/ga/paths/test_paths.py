"""Paths and their twists: screws from pose to pose, splines through motors and similarities."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.linalg import expm

from motorcade.ga import (
    CumulativeBSpline,
    Motor,
    Rotor,
    ScrewPath,
    Similarity,
    SimilaritySpline,
    Trajectory,
    TwistSample,
)
from motorcade.ga.motion import twist_bracket

START_NS = 1_403_715_273_262_142_976
STEP_S = 1e-4
Spline = CumulativeBSpline | SimilaritySpline


def worst(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.max(np.abs(a - b)))


@pytest.fixture(params=[CumulativeBSpline, SimilaritySpline])
def spline(request: pytest.FixtureRequest, rng: np.random.Generator) -> Spline:
    make = Motor if request.param is CumulativeBSpline else Similarity
    size = make.identity().log().size
    controls = [make.random(rng)]
    for _ in range(14):
        controls.append(controls[-1] @ make.from_twist(rng.uniform(-0.6, 0.6, size)))
    spline: Spline = request.param(START_NS, 0.1, make.stack(controls), "map", "imu")
    return spline


@pytest.fixture
def screws(rng: np.random.Generator) -> ScrewPath:
    time_ns = START_NS + np.array([0, 100, 180, 400, 401]) * 1_000_000
    steps = Motor.from_twist(rng.uniform(-0.8, 0.8, (5, 6)))
    return ScrewPath(Trajectory(time_ns, steps, "map", "imu"))


def generator(twist: np.ndarray) -> np.ndarray:
    """The 4x4 matrix that a twist stands for."""
    wx, wy, wz = twist[:3]
    matrix = np.zeros((4, 4))
    growth = twist[6] if twist.size == 7 else 0.0
    matrix[:3, :3] = [[growth, -wz, wy], [wz, growth, -wx], [-wy, wx, growth]]
    matrix[:3, 3] = twist[3:6]
    return matrix


def test_twist_is_the_derivative_of_the_pose(spline: Spline) -> None:
    time_s = np.linspace(2.1 * STEP_S, spline.duration_s - 2.1 * STEP_S, 60)
    around = [spline.twists(time_s + k * STEP_S).pose.as_matrix() for k in (-2, -1, 1, 2)]
    slope = (around[0] - 8 * around[1] + 8 * around[2] - around[3]) / (12 * STEP_S)
    middle = spline.twists(time_s)
    for matrix, change, twist in zip(
        middle.pose.as_matrix(), slope, middle.body_twist, strict=True
    ):
        np.testing.assert_allclose(matrix @ generator(twist), change, rtol=0, atol=1e-7)
    assert np.max(np.abs(middle.body_twist[:, -1])) > 1.0


def test_twist_rate_is_the_derivative_of_the_twist(spline: Spline) -> None:
    time_s = np.linspace(2.1 * STEP_S, spline.duration_s - 2.1 * STEP_S, 60)
    around = [spline.twists(time_s + k * STEP_S).body_twist for k in (-2, -1, 1, 2)]
    slope = (around[0] - 8 * around[1] + 8 * around[2] - around[3]) / (12 * STEP_S)
    middle = spline.twists(time_s)
    np.testing.assert_allclose(middle.body_twist_rate, slope, rtol=0, atol=1e-5)
    assert np.max(np.abs(middle.body_twist_rate[:, -1])) > 10.0


def test_moving_the_world_leaves_body_twists(spline: Spline, rng: np.random.Generator) -> None:
    make = type(spline.controls)
    time_s = np.linspace(0, spline.duration_s, 30)
    here = spline.twists(time_s)
    left = make.random(rng)
    moved = type(spline)(START_NS, 0.1, left @ spline.controls)
    there = moved.twists(time_s)
    assert worst(there.body_twist, here.body_twist) < 1e-10
    assert worst(there.body_twist_rate, here.body_twist_rate) < 1e-8
    assert worst(there.pose.as_matrix(), (left @ here.pose).as_matrix()) < 1e-12


def test_poses_by_stamp_and_by_seconds_are_the_same(spline: Spline) -> None:
    stamps = START_NS + np.array([0, 123_456_789, 512_345_678])
    by_stamp = spline.at(stamps)
    by_seconds = spline.twists((stamps - START_NS) * 1e-9).pose
    assert worst(by_stamp.as_matrix(), by_seconds.as_matrix()) < 1e-12


def test_pure_growth_is_scipys_bspline(rng: np.random.Generator) -> None:
    log_scale = rng.standard_normal(12)
    spline = SimilaritySpline(
        0, 0.25, Similarity.from_motor_scale(Motor.identity((12,)), np.exp(log_scale))
    )
    witness = BSpline((np.arange(12 + 6) - 5) * 0.25, log_scale, 5)
    time_s = np.linspace(0, spline.duration_s, 41)
    sample = spline.twists(time_s)
    assert worst(np.log(sample.pose.scale), witness(time_s)) < 1e-13
    assert worst(sample.body_twist[:, 6], witness(time_s, nu=1)) < 1e-12
    assert worst(sample.body_twist_rate[:, 6], witness(time_s, nu=2)) < 1e-10


def test_a_similarity_spline_without_growth_is_the_motors(rng: np.random.Generator) -> None:
    motors = Motor.random(rng) @ Motor.from_twist(rng.uniform(-0.3, 0.3, (9, 6)))
    plain = CumulativeBSpline(0, 0.1, motors)
    grown = SimilaritySpline(0, 0.1, Similarity.from_motor_scale(motors))
    time_s = np.linspace(0, plain.duration_s, 31)
    one, two = plain.twists(time_s), grown.twists(time_s)
    assert worst(one.pose.as_matrix(), two.pose.as_matrix()) < 1e-13
    assert worst(one.body_twist, two.body_twist[:, :6]) < 1e-12
    assert worst(one.body_twist_rate, two.body_twist_rate[:, :6]) < 1e-10
    assert worst(two.body_twist[:, 6], np.zeros(31)) < 1e-12


def test_too_few_controls_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"SimilaritySpline.controls: expected shape \(n,\)"):
        SimilaritySpline(0, 0.1, Similarity.identity((5,)))


@pytest.mark.parametrize("make", [Motor, Similarity])
def test_adjoint_and_bracket_are_those_of_matrices(
    make: type[Motor] | type[Similarity], rng: np.random.Generator
) -> None:
    one = make.random(rng)
    a, b = rng.standard_normal((2, one.log().size))
    matrix, inverse = one.as_matrix(), np.linalg.inv(one.as_matrix())
    carried = matrix @ generator(a) @ inverse
    np.testing.assert_allclose(generator(one.transform_twist(a)), carried, rtol=0, atol=1e-13)
    both = generator(a) @ generator(b) - generator(b) @ generator(a)
    np.testing.assert_allclose(generator(twist_bracket(a, b)), both, rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        (one @ make.from_twist(a) @ one.inverse()).as_matrix(), expm(carried), atol=1e-11
    )


# Screws from pose to pose ----------------------------------------------------------------------


def test_the_screw_path_meets_every_pose_and_is_the_trajectory(screws: ScrewPath) -> None:
    given = screws.trajectory
    sample = screws.twists(given.time_s)
    assert worst(sample.pose.as_matrix(), given.poses.as_matrix()) < 1e-13
    stamps = START_NS + np.arange(0, 401, 7) * 1_000_000
    between = screws.twists((stamps - START_NS) * 1e-9).pose
    assert worst(between.as_matrix(), screws.at(stamps).as_matrix()) < 1e-12
    assert (screws.start_ns, screws.parent, screws.child) == (START_NS, "map", "imu")
    assert screws.duration_s == pytest.approx(0.401)


def test_screw_twists_are_constant_and_the_derivative_of_the_pose(screws: ScrewPath) -> None:
    time_s = np.linspace(0.11, 0.17, 20)
    sample = screws.twists(time_s)
    assert worst(sample.body_twist, sample.body_twist[:1]) == 0.0
    assert worst(sample.body_twist_rate, np.zeros(6)) == 0.0
    ahead, behind = (screws.twists(time_s + d).pose.as_matrix() for d in (1e-6, -1e-6))
    change = (ahead - behind) / 2e-6
    for matrix, slope in zip(sample.pose.as_matrix(), change, strict=True):
        expected = matrix @ generator(sample.body_twist[0])
        np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-7)


def test_a_turning_screw_accelerates_towards_its_axis(screws: ScrewPath) -> None:
    time_s = np.linspace(0.11, 0.17, 20)
    sample = screws.evaluate(time_s)
    place = [screws.evaluate(time_s + d).pose.translation_m for d in (-1e-4, 0.0, 1e-4)]
    bend = (place[0] - 2 * place[1] + place[2]) / 1e-8
    np.testing.assert_allclose(sample.world_acceleration_m_s2, bend, rtol=0, atol=1e-4)
    assert np.max(np.abs(bend)) > 1.0


def test_ends_are_met_where_rounding_leads_past_them(screws: ScrewPath, spline: Spline) -> None:
    for path in (screws, spline):
        ends = np.array([0.0, path.duration_s])
        exact = path.twists(ends).pose.coefficients
        past = path.twists(ends + np.array([-0.9e-9, 0.9e-9])).pose.coefficients
        np.testing.assert_array_equal(past, exact)
    np.testing.assert_allclose(
        screws.twists(screws.duration_s).pose.as_matrix(),
        screws.trajectory.poses[-1].as_matrix(),
        rtol=0,
        atol=1e-14,
    )


def test_the_screw_path_refuses_what_lies_outside(screws: ScrewPath) -> None:
    for bad in (-0.01, 0.5):
        with pytest.raises(ValueError, match=r"ScrewPath: expected times in \[0, 0.401"):
            screws.twists(bad)
    with pytest.raises(ValueError, match="expected finite numbers"):
        screws.evaluate(np.nan)
    single = Trajectory(np.array([5]), Motor.identity((1,)))
    with pytest.raises(ValueError, match="expected two poses or more"):
        ScrewPath(single)


def test_samples_of_nothing_are_empty(screws: ScrewPath, spline: Spline) -> None:
    for path in (screws, spline):
        sample = path.twists(np.zeros((0, 3)))
        assert isinstance(sample, TwistSample)
        assert sample.body_twist.shape[:2] == sample.pose.shape == (0, 3)


def test_both_paths_agree_on_a_steady_screw(rng: np.random.Generator) -> None:
    twist = rng.uniform(-0.5, 0.5, 6)
    time_ns = np.arange(20) * 100_000_000
    poses = Motor.from_rotor_translation(Rotor.random(rng), np.ones(3)) @ Motor.from_twist(
        (time_ns * 1e-9)[:, None] * twist
    )
    trajectory = Trajectory(time_ns, poses)
    time_s = np.linspace(0, 1.9, 40)
    for path in (ScrewPath(trajectory), CumulativeBSpline.fit(trajectory, 0.2)):
        sample = path.twists(time_s)
        assert worst(sample.body_twist, twist) < 1e-8
