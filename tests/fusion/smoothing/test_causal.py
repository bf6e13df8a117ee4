"""Causal filters: streams are scans, published formulas on one axis, frames, refusals."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import (
    REPRESENTATIONS,
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    OneEuro,
    smooth,
)
from motorcade.fusion.smoothing.causal import DoubleExponential, Exponential
from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

FILTERS: tuple[type[CausalFilter], ...] = (
    Exponential,
    DoubleExponential,
    OneEuro,
    ConstantVelocityFilter,
    ConstantAccelerationFilter,
)


def noisy(name: str, rng: np.random.Generator) -> Trajectory:
    """A standard motion with noise, at uneven stamps with a gap."""
    seconds = np.cumsum(rng.uniform(0.01, 0.05, 150))
    seconds[80:] += 0.7
    stamps = np.round(seconds * 1e9).astype(np.int64)
    motion = MOTIONS[name]
    truth = Trajectory(stamps, motion.at(stamps * 1e-9).pose)
    return Gaussian(0.005, 0.01).apply(truth, rng)


def fed(chosen: CausalFilter, trajectory: Trajectory) -> FloatArray:
    stamps = trajectory.time_ns.tolist()
    made = [chosen.update(pose, at) for pose, at in zip(trajectory.poses, stamps, strict=True)]
    return np.stack([pose.coefficients for pose in made])


@pytest.mark.parametrize("motion", ["handheld", "zoom"])
@pytest.mark.parametrize("name", REPRESENTATIONS)
@pytest.mark.parametrize("kind", FILTERS)
def test_the_batch_is_the_stream_to_the_last_bit(
    kind: type[CausalFilter], name: str, motion: str, rng: np.random.Generator
) -> None:
    trajectory = noisy(motion, rng)
    chosen = kind(representation=name)
    half = Trajectory(trajectory.time_ns[:70], trajectory.poses[:70])
    fed(chosen, half)
    batch = chosen.smooth(trajectory)
    assert type(batch.poses) is type(trajectory.poses)
    assert np.isfinite(batch.poses.coefficients).all()
    rest = fed(chosen, trajectory[70:])
    np.testing.assert_array_equal(rest, batch.poses.coefficients[70:])
    chosen.reset()
    np.testing.assert_array_equal(fed(chosen, trajectory), batch.poses.coefficients)


# Published formulas, on one axis ---------------------------------------------------------------


def exponential(x: FloatArray, dt: FloatArray, cutoff_hz: float) -> FloatArray:
    made = [x[0]]
    for value, step in zip(x[1:], dt, strict=True):
        keep = np.exp(-2.0 * np.pi * cutoff_hz * step)
        made.append(keep * made[-1] + (1.0 - keep) * value)
    return np.array(made)


def holt(x: FloatArray, dt: FloatArray, cutoff_hz: float, trend_hz: float) -> FloatArray:
    level, trend, made = x[0], 0.0, [x[0]]
    for value, step in zip(x[1:], dt, strict=True):
        alpha, gamma = 1.0 - np.exp(-2.0 * np.pi * np.array([cutoff_hz, trend_hz]) * step)
        before = level
        level = alpha * value + (1.0 - alpha) * (level + step * trend)
        trend = gamma * (level - before) / step + (1.0 - gamma) * trend
        made.append(level)
    return np.array(made)


class LowPass:
    """Algorithm 2 of the 1€ paper."""

    def __init__(self) -> None:
        self.first_time = True
        self.hat_x_prev = 0.0

    def filter(self, x: float, alpha: float) -> float:
        if self.first_time:
            self.first_time = False
            self.hat_x_prev = x
        hat_x = alpha * x + (1.0 - alpha) * self.hat_x_prev
        self.hat_x_prev = hat_x
        return hat_x


def alpha_of(rate: float, cutoff: float) -> float:
    """Algorithm 3."""
    tau, te = 1.0 / (2.0 * np.pi * cutoff), 1.0 / rate
    return 1.0 / (1.0 + tau / te)


def one_euro(
    x: FloatArray, dt: FloatArray, mincutoff: float, beta: float, dcutoff: float
) -> FloatArray:
    """Algorithm 1, with the rate of every step."""
    xfilt, dxfilt, made = LowPass(), LowPass(), []
    for value, step in itertools.zip_longest(x, np.concatenate([[1.0], dt])):
        rate = 1.0 / step
        dx = 0.0 if xfilt.first_time else (value - xfilt.hat_x_prev) * rate
        edx = dxfilt.filter(dx, alpha_of(rate, dcutoff))
        cutoff = mincutoff + beta * abs(edx)
        made.append(xfilt.filter(value, alpha_of(rate, cutoff)))
    return np.array(made)


def uneven(rng: np.random.Generator) -> tuple[IntArray, FloatArray, FloatArray]:
    stamps = np.cumsum(rng.integers(8_000_000, 60_000_000, 200))
    x = np.sin(stamps * 2e-9) + 0.02 * rng.standard_normal(200)
    return stamps, np.diff(stamps) * 1e-9, x


def cases(x: FloatArray, dt: FloatArray) -> list[tuple[CausalFilter, FloatArray]]:
    return [
        (Exponential(1.3), exponential(x, dt, 1.3)),
        (DoubleExponential(2.1, 0.7), holt(x, dt, 2.1, 0.7)),
        (OneEuro(0.8, 2.5, 2.5, 2.5, 1.4), one_euro(x, dt, 0.8, 2.5, 1.4)),
    ]


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_on_a_line_the_published_formulas_hold(name: str, rng: np.random.Generator) -> None:
    stamps, dt, x = uneven(rng)
    way = np.stack([np.zeros(200), x, np.zeros(200)], axis=-1)
    poses = Motor.from_rotor_translation(Rotor.identity((200,)), way)
    for chosen, expected in cases(x, dt):
        chosen.representation = name
        made = chosen.smooth(Trajectory(stamps, poses)).poses.translation_m
        np.testing.assert_allclose(made[:, 1], expected, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(made[:, [0, 2]], 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["motor", "similarity", "rotor", "euler", "euler_unwrapped"])
def test_about_one_axis_the_published_formulas_hold(name: str, rng: np.random.Generator) -> None:
    stamps, dt, x = uneven(rng)
    turn = np.stack([x, np.zeros(200), np.zeros(200)], axis=-1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), np.zeros(3))
    for chosen, expected in cases(x, dt):
        chosen.representation = name
        made = chosen.smooth(Trajectory(stamps, poses)).poses.rotor.as_rotation_vector()
        np.testing.assert_allclose(made[:, 0], expected, rtol=0.0, atol=1e-12)


# Frames ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["handheld", "fast_spin", "zoom"])
@pytest.mark.parametrize("kind", FILTERS)
def test_another_world_changes_nothing(
    kind: type[CausalFilter], motion: str, rng: np.random.Generator
) -> None:
    trajectory = noisy(motion, rng)
    if isinstance(trajectory.poses, Similarity):
        name, left = "similarity", Similarity.random(rng)
    else:
        name, left = "motor", Motor.random(rng, extent_m=3.0)
    chosen = kind(representation=name)
    moved = chosen.smooth(Trajectory(trajectory.time_ns, left @ trajectory.poses)).poses
    expected = left @ chosen.smooth(trajectory).poses
    assert np.abs(moved.as_matrix() - expected.as_matrix()).max() < 1e-10


@pytest.mark.parametrize("name", ["motor", "similarity"])
def test_another_body_changes_nothing_of_the_exponential_filter(
    name: str, rng: np.random.Generator
) -> None:
    trajectory, right = noisy("handheld", rng), Motor.random(rng, extent_m=3.0)
    chosen = Exponential(representation=name)
    moved = chosen.smooth(trajectory.transformed_by(right=right)).poses
    expected = chosen.smooth(trajectory).poses @ right
    assert np.abs(moved.as_matrix() - expected.as_matrix()).max() < 1e-10


@pytest.mark.parametrize("kind", [DoubleExponential, ConstantVelocityFilter])
def test_a_steady_screw_is_followed_without_error(kind: type[CausalFilter]) -> None:
    truth = MOTIONS["screw"].sampled(30.0, 30.0)
    made = kind().smooth(truth).poses[-10:]
    assert np.abs((truth.poses[-10:].inverse() @ made).as_twist()).max() < 1e-6


@pytest.mark.parametrize("name", sorted(MOTIONS))
def test_one_euro_adds_less_by_its_lag_than_it_takes_by_default(name: str) -> None:
    """At 30 Hz with 5 mm and 0.01 rad, whatever moves: rotation and translation together."""
    true = MOTIONS[name].sampled(30.0, 6.0).rigid
    raw = Gaussian(0.005, 0.01).apply(true, np.random.default_rng(0))

    def error(path: Trajectory) -> float:
        rest = true.motors.local(path.motors) / ([0.01] * 3 + [0.005] * 3)
        return float(np.sqrt(np.mean(rest**2)))

    assert error(OneEuro().smooth(raw)) < error(raw)


def test_float32_and_strided_poses_are_taken_as_they_are(rng: np.random.Generator) -> None:
    trajectory = noisy("handheld", rng)
    turned = Motor._trusted(np.asfortranarray(trajectory.poses.coefficients))
    np.testing.assert_array_equal(
        fed(OneEuro(), Trajectory(trajectory.time_ns, turned)), fed(OneEuro(), trajectory)
    )
    single = Trajectory(trajectory.time_ns, trajectory.poses.astype(np.float32))
    double = Trajectory(trajectory.time_ns, single.poses.astype(np.float64))
    np.testing.assert_array_equal(fed(OneEuro(), single), fed(OneEuro(), double))
    assert OneEuro().update(single.poses[0], 0).dtype == np.float64


# Refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", FILTERS)
def test_stamps_that_do_not_increase_are_refused_and_change_nothing(
    kind: type[CausalFilter], rng: np.random.Generator
) -> None:
    poses = Motor.random(rng, (4,))
    chosen, untouched = kind(), kind()
    for one in (chosen, untouched):
        one.update(poses[0], 10_000_000)
        one.update(poses[1], 40_000_000)
    for stamp in (40_000_000, 39_999_999, -5):
        with pytest.raises(
            ValueError, match=f"time_ns: expected a stamp after 40000000, got {stamp}"
        ):
            chosen.update(poses[2], stamp)
    expected = untouched.update(poses[3], 70_000_000).coefficients
    np.testing.assert_array_equal(chosen.update(poses[3], 70_000_000).coefficients, expected)


def test_what_is_no_pose_and_no_stamp_is_refused(rng: np.random.Generator) -> None:
    chosen = OneEuro()
    with pytest.raises(ValueError, match=r"pose: expected one pose, got a batch of shape \(3,\)"):
        chosen.update(Motor.random(rng, (3,)), 0)
    with pytest.raises(TypeError, match="pose: expected a Motor or Similarity, got ndarray"):
        chosen.update(np.zeros(8), 0)  # type: ignore[type-var]
    with pytest.raises(ValueError, match="time_ns: expected integer nanoseconds, got float"):
        chosen.update(Motor.identity(), 0.5)  # type: ignore[arg-type]
    chosen.update(Motor.identity(), np.int64(3))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected a Motor like those before, got Similarity"):
        chosen.update(Similarity.identity(), 4)
    with pytest.raises(ValueError, match="pose: expected one pose of 8 coefficients"):
        chosen.update(Motor.random(rng, (3,)), 5)
    chosen.reset()
    chosen.update(Similarity.identity(), 0)


def test_a_result_beyond_float64_is_refused() -> None:
    chosen = DoubleExponential()
    far = [Motor.from_translation([x, 0.0, 0.0]) for x in (0.0, 1.7e308)]
    chosen.update(far[0], 0)
    chosen.update(far[1], 1_000)
    with pytest.raises(ValueError, match="pose: expected a finite result"):
        chosen.update(far[1], 2**62)
    assert np.isfinite(chosen.update(far[1], 2_000).coefficients).all()


@pytest.mark.parametrize(
    ("method", "parameters", "message"),
    [
        ("exponential", {"cutoff_hz": 0.0}, "cutoff_hz: expected a positive number of Hz, got 0"),
        ("exponential", {"cutoff_hz": 15.1}, "cutoff_hz: expected below half the sampling rate"),
        ("double_exponential", {"trend_cutoff_hz": 16.0}, "trend_cutoff_hz: expected below half"),
        ("one_euro", {"min_cutoff_hz": 16.0}, "min_cutoff_hz: expected below half"),
        ("one_euro", {"derivative_cutoff_hz": np.nan}, "derivative_cutoff_hz: expected a positive"),
        ("one_euro", {"beta_per_m": -1.0}, "beta_per_m: expected a number of at least 0, got -1"),
        ("constant_velocity", {"noise_m": 0.0}, "noise_m: expected a positive deviation"),
        ("constant_velocity", {"noise_m": [[0.1]]}, "noise_m: expected a positive deviation or"),
        (
            "constant_velocity",
            {"noise_m": [0.1, 0.2], "noise_rad": [0.1] * 3},
            r"noise: expected equal numbers of deviations, got \[2, 3\]",
        ),
        ("constant_velocity", {"noise_m": [0.1, 0.2]}, "noise: expected one deviation or one for"),
        (
            "constant_velocity",
            {"acceleration_m_s2": -1.0},
            "acceleration_m_s2: expected a positive",
        ),
        ("rts_constant_acceleration", {"noise_rad": np.inf}, "noise_rad"),
    ],
)
def test_parameters_out_of_range_are_named(
    method: str, parameters: dict[str, float], message: str
) -> None:
    trajectory = MOTIONS["screw"].sampled(30.0, 1.0)
    with pytest.raises(ValueError, match=message):
        smooth(trajectory, method, **parameters)
