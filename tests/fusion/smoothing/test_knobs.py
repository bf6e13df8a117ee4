"""What is asked of `auto`: smoother or less so, known noise, and no more than a lag's future."""

from typing import Any

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers
from motorcade.fusion.smoothing import choose, smooth, smoothed_automatically
from motorcade.fusion.smoothing.batch.columns import ColumnModel
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.cells import cell

TRUE = MOTIONS["handheld"].sampled(30.0, 6.0)


@pytest.fixture
def noisy(rng: np.random.Generator) -> Trajectory:
    return Outliers(0.03, 0.3, 0.5).apply(Gaussian(0.005, 0.01).apply(TRUE, rng), rng)


def rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def test_the_smoother_the_farther_from_what_was_measured_and_the_less_rough(
    noisy: Trajectory,
) -> None:
    off, rough, weights = [], [], []
    for smoothness in (-10.0, -1.0, 0.0, 1.0, 10.0):
        found = smoothed_automatically(noisy, smoothness=smoothness)
        position = found.trajectory.motors.translation_m
        kept = found.weights > 0.0
        off.append(rms((position - noisy.motors.translation_m)[kept]))
        rough.append(rms(np.diff(position, n=3, axis=0)))
        weights.append(found.weights)
    assert np.all(np.diff(off) > 0.0)
    assert np.all(np.diff(rough) < 0.0)
    assert off[0] < 1e-6
    # What counts as a wrong pose does not depend on it.
    assert all(np.array_equal(one, weights[0]) for one in weights)


def test_smoothness_zero_is_as_found(noisy: Trajectory) -> None:
    assert np.array_equal(
        smooth(noisy, smoothness=0.0).motors.coefficients, smooth(noisy).motors.coefficients
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_unit_of_smoothness_is_twice_the_time(order: int) -> None:
    """The rate at which process and noise are as strong halves; a ratio goes with its power."""
    model = ColumnModel(order, 3.0, 0.1)
    assert model.smoother(1.0, 0.05).ratio == pytest.approx(3.0 / 2.0 ** (order + 1))
    assert model.smoother(-1.0, 0.05).ratio == pytest.approx(3.0 * 2.0 ** (order + 1))


def test_a_path_too_coarse_to_tell_is_smoothed_where_that_is_asked_for(
    rng: np.random.Generator,
) -> None:
    true = MOTIONS["handheld"].sampled(5.0, 30.0)
    noisy = Gaussian(0.005, 0.01).apply(true, rng)
    left = rms(smooth(noisy).motors.translation_m - noisy.motors.translation_m)
    asked = rms(smooth(noisy, smoothness=1.0).motors.translation_m - noisy.motors.translation_m)
    assert left < 1e-5
    assert asked > 1e-3


def test_known_noise_is_used_and_not_searched_for(noisy: Trajectory) -> None:
    found = smoothed_automatically(noisy, noise_m=0.005, noise_rad=0.01)
    assert found.choice.noise_m == pytest.approx(0.005, rel=1e-12)
    assert found.choice.noise_rad == pytest.approx(0.01, rel=1e-12)
    assert "noise_m given" in str(found.choice)
    error = rms(found.trajectory.motors.translation_m - TRUE.motors.translation_m)
    assert error < 0.6 * 0.005
    moved = []
    for noise_m in (5e-4, 5e-3, 5e-2):
        path = smoothed_automatically(noisy, noise_m=noise_m)
        kept = path.weights > 0.0
        off = path.trajectory.motors.translation_m - noisy.motors.translation_m
        moved.append(rms(off[kept]))
    assert moved[0] < 0.5 * moved[1]
    assert moved[1] < moved[2]


@pytest.mark.parametrize("smoothness", [-10.0, -3.0, 0.0])
def test_deviations_are_those_of_the_noise_however_little_is_smoothed(
    smoothness: float, rng: np.random.Generator
) -> None:
    true = MOTIONS["handheld"].sampled(30.0, 3.0)
    made = Gaussian(0.005, np.deg2rad(0.5)).apply(true, rng)
    found = smoothed_automatically(made, "rotor", smoothness=smoothness)
    turn = (true.motors.inverse() @ found.trajectory.motors).rotor.as_rotation_vector()
    shift = found.trajectory.motors.translation_m - true.motors.translation_m
    claimed = rms(found.deviations[:, :3]), rms(found.deviations[:, 3:])
    assert 1 / 1.5 < claimed[0] / rms(turn) < 1.5
    assert 1 / 1.5 < claimed[1] / rms(shift) < 1.5


def test_deviations_are_at_most_those_of_the_noise_however_much_is_smoothed(
    rng: np.random.Generator,
) -> None:
    made = Gaussian(0.005, 0.01).apply(MOTIONS["handheld"].sampled(30.0, 3.0), rng)
    found = smoothed_automatically(made, smoothness=3.0)
    assert found.choice.noise_rad is not None
    assert found.choice.noise_m is not None
    assert rms(found.deviations[:, :3]) < found.choice.noise_rad
    assert rms(found.deviations[:, 3:]) < found.choice.noise_m


@pytest.mark.parametrize("smoothness", [0.0, -2.0])
def test_known_noise_is_in_the_deviations_of_a_choice_too(
    smoothness: float, noisy: Trajectory
) -> None:
    known = smoothed_automatically(noisy, smoothness=smoothness, noise_m=0.05, noise_rad=0.05)
    again = smoothed_automatically(noisy, choice=known.choice)
    assert rms(known.deviations) > 0.01
    np.testing.assert_allclose(again.deviations, known.deviations, rtol=0.05)


def test_known_noise_tells_what_stamps_alone_do_not(rng: np.random.Generator) -> None:
    """At 5 Hz motion cannot be told from noise, unless the noise is known."""
    true = MOTIONS["handheld"].sampled(5.0, 60.0)
    noisy = Gaussian(0.02, 0.02).apply(true, rng)
    found = smooth(noisy, noise_m=0.02, noise_rad=0.02)
    error, before = (
        rms(p.motors.translation_m - true.motors.translation_m) for p in (found, noisy)
    )
    assert error < 0.95 * before


@pytest.mark.parametrize("lag_s", [0.0, 0.2])
def test_a_pose_knows_nothing_from_beyond_the_lag(lag_s: float, noisy: Trajectory) -> None:
    whole, rows = smooth(noisy, lag_s=lag_s), 100
    cut = smooth(noisy[:rows], lag_s=lag_s)
    due = noisy.time_s[:rows] <= noisy.time_s[rows - 1] - lag_s
    same = whole.motors.coefficients[:rows][due] == cut.motors.coefficients[due]
    assert np.all(same)
    changed = Trajectory(
        noisy.time_ns,
        Motor(np.concatenate([noisy.motors.coefficients[:-1], TRUE.motors.coefficients[:1]])),
    )
    other = smooth(changed, lag_s=lag_s)
    assert np.array_equal(other.motors.coefficients[:100], whole.motors.coefficients[:100])


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"smoothness": 11.0}, "smoothness: expected -10 to 10"),
        ({"smoothness": float("nan")}, "smoothness: expected -10 to 10"),
        ({"noise_m": 0.0}, "noise_m: expected"),
        ({"noise_rad": -1.0}, "noise_rad: expected"),
        ({"noise_m": 1e-31}, "noise_m: expected 1e-30 to 1e"),
        ({"noise_rad": 1e31}, "noise_rad: expected 1e-30 to 1e"),
        ({"lag_s": -0.1}, "lag_s: expected 0 or more"),
        ({"lag_s": 0.1, "smoothness": 1.0}, "lag_s: expected none beside"),
        ({"lag_s": 0.1, "noise_m": 0.01}, "lag_s: expected none beside"),
        ({"lag_s": 0.1, "representation": "quaternion"}, "lag_s: expected rotor or no"),
        ({"noise_m": 0.01, "representation": "quaternion"}, "expected none with quaternion"),
    ],
)
def test_what_cannot_be_is_refused(knobs: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        smooth(TRUE, **knobs)


@pytest.mark.parametrize(
    "name", ["smoothness", "noise_m", "noise_rad", "max_move_m", "max_move_rad", "lag_s"]
)
@pytest.mark.parametrize("value", ["x", np.array([1, 2]), True, np.bool_(True), 1j])
def test_what_is_no_number_is_refused_by_name(name: str, value: Any) -> None:
    with pytest.raises(TypeError, match=f"{name}: expected a number, got "):
        smooth(TRUE, **{name: value})


def test_no_smoothness_and_no_method_are_refused_by_name() -> None:
    with pytest.raises(TypeError, match="smoothness: expected a number, got NoneType"):
        smooth(TRUE, smoothness=None)
    with pytest.raises(TypeError, match="method: expected a name of METHODS, got NoneType"):
        smooth(TRUE, None)  # type: ignore[call-overload]


def test_a_choice_keeps_its_knobs_and_takes_no_others(noisy: Trajectory) -> None:
    choice = choose(noisy, smoothness=1.0)
    assert "smoothness +1" in str(choice)
    plain = choose(noisy)
    off = [
        rms(one.smooth(noisy).motors.translation_m - noisy.motors.translation_m)
        for one in (plain, choice)
    ]
    assert off[0] < off[1]
    with pytest.raises(ValueError, match="choice: expected none beside knobs"):
        smoothed_automatically(noisy, choice=choice, smoothness=2.0)


@pytest.mark.parametrize("flipped", [False, True])
def test_no_pose_is_moved_farther_than_it_may(noisy: Trajectory, flipped: bool) -> None:
    """Wrong poses, which `auto` moves by decimetres, go as far as they may on the way to there.

    So do runs that it mirrors back, which went all of it where they were found late.
    """
    if flipped:
        hover = MOTIONS["gimbal_hover"].sampled(20.0, 199 / 20.0)
        noisy = cell("gimbal_hover", "flips", hover, 4242).raw

    def moved(path: Trajectory) -> FloatArray:
        turn = (noisy.motors.rotor.inverse() @ path.motors.rotor).angle()
        shift = path.motors.translation_m - noisy.motors.translation_m
        return np.column_stack([turn, np.linalg.norm(shift, axis=1)])

    free, most = moved(smooth(noisy)), np.array([0.02, 0.03])
    assert np.all(free.max(axis=0) > 3.0 * most)
    bound = smooth(noisy, max_move_rad=most[0], max_move_m=most[1])
    np.testing.assert_allclose(moved(bound), np.minimum(free, most), atol=1e-9)
    again = choose(noisy, max_move_rad=most[0], max_move_m=most[1]).smooth(noisy)
    assert np.all(moved(again) < most + 1e-9)
