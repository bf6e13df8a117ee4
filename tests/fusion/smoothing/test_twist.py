"""Screws and spins are smoothed by one constant twist, and nothing that moves besides is."""

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS, Motion
from motorcade.fusion.motions.degradations import (
    Degradation,
    DroppedFrames,
    Gaussian,
    PlanarFlips,
    Quantised,
)
from motorcade.fusion.motions.motion import Factor, Polynomial, Sines
from motorcade.fusion.smoothing import smoothed_automatically
from motorcade.fusion.smoothing.batch.columns import turning_model
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

NOISE = Gaussian(0.005, np.deg2rad(0.5))
STRONG = Gaussian(0.02, np.deg2rad(2.0))


def turning(rng: np.random.Generator, *, screw: bool) -> Trajectory:
    """A constant twist about any axis, ten seconds at 20 Hz; a spin stays where it is."""
    twist = np.concatenate([rng.standard_normal(3), screw * rng.standard_normal(3)])
    twist *= rng.uniform(0.5, 3.0) / np.linalg.norm(twist[:3])
    path = Motion((Factor(twist, Polynomial((0.0, 1.0))),), Motor).sampled(20.0, 9.95)
    start = Motor.from_twist(rng.standard_normal(6))
    return Trajectory(path.time_ns, start @ path.motors, path.parent, path.child)


def sizes(path: Trajectory, true: Trajectory) -> FloatArray:
    """RMS of wrong rotations in rad and of wrong positions in m."""
    turn = (true.motors.rotor.inverse() @ path.motors.rotor).as_rotation_vector()
    shift = path.motors.translation_m - true.motors.translation_m
    return np.array([np.sqrt(np.mean(np.sum(one**2, axis=1))) for one in (turn, shift)])


@pytest.mark.parametrize(
    ("screw", "noise", "wrong", "most"),
    [
        (True, STRONG, None, (0.144, 0.144)),
        (True, NOISE, DroppedFrames(0.3, 3.0), (0.2, 0.2)),
        (False, NOISE, PlanarFlips(0.05), (0.12, 0.12)),
        (False, Quantised(0.01, float(np.deg2rad(1.0))), None, (0.2, 1.0)),
    ],
    ids=["screw, strong noise", "screw, dropouts", "spin, flips", "spin, quantised"],
)
def test_a_constant_twist_is_found(
    screw: bool,
    noise: Degradation,
    wrong: Degradation | None,
    most: tuple[float, float],
) -> None:
    left = []
    for seed in range(4):
        rng = np.random.default_rng([35, seed])
        true = turning(rng, screw=screw)
        raw = noise.apply(true, rng)
        raw = raw if wrong is None else wrong.apply(raw, rng)
        found = smoothed_automatically(raw)
        assert found.choice.by_twist
        assert "a constant" in str(found.choice)
        rows = np.searchsorted(true.time_ns, raw.time_ns)
        before, after = (sizes(path, true[rows]) for path in (raw, found.trajectory))
        left.append(after / np.maximum(before, 1e-9))
    assert np.all(np.sqrt(np.mean(np.square(left), axis=0)) < most)


def test_a_body_that_goes_anywhere_and_turns_evenly_keeps_its_way(
    rng: np.random.Generator,
) -> None:
    way = MOTIONS["handheld"].sampled(20.0, 9.95)
    turn = turning(rng, screw=False).motors.rotor
    poses = Motor.from_rotor_translation(turn, way.motors.translation_m)
    true = Trajectory(way.time_ns, poses, way.parent, way.child)
    raw = NOISE.apply(true, rng)
    found = smoothed_automatically(raw, "rotor")
    assert "a constant angular rate" in str(found.choice)
    left = sizes(found.trajectory, true) / sizes(raw, true)
    assert left[0] < 0.15
    assert left[1] < 0.7


@pytest.mark.parametrize("sway_deg", [1.0, 3.0])
def test_motion_beside_a_twist_is_kept(sway_deg: float, rng: np.random.Generator) -> None:
    plain = turning(rng, screw=True)
    sway = np.sin(2.0 * np.pi * 0.3 * plain.time_s)[:, None] * np.deg2rad(sway_deg)
    swayed = plain.motors @ Motor.from_twist(sway * [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    true = Trajectory(plain.time_ns, swayed, plain.parent, plain.child)
    raw = NOISE.apply(true, rng)
    found = smoothed_automatically(raw)
    assert not found.choice.by_twist
    assert np.all(sizes(found.trajectory, true) < 0.7 * sizes(raw, true))


def test_a_choice_of_a_twist_is_looked_at_again_on_another_path(rng: np.random.Generator) -> None:
    choice = smoothed_automatically(NOISE.apply(turning(rng, screw=True), rng)).choice
    assert choice.by_twist
    true = turning(rng, screw=True)
    other = NOISE.apply(true, rng)
    assert np.all(sizes(choice.smooth(other), true) < 0.3 * sizes(other, true))
    hand = MOTIONS["handheld"].sampled(20.0, 9.95)
    noisy = NOISE.apply(hand, rng)
    assert not smoothed_automatically(noisy, choice=choice).choice.by_twist


def test_a_body_at_rest_is_at_rest(rng: np.random.Generator) -> None:
    still = Trajectory(
        np.arange(200) * 50_000_000, Motor.from_rotor_translation(Rotor.identity((200,)), [1.0] * 3)
    )
    raw = NOISE.apply(still, rng)
    assert np.all(sizes(smoothed_automatically(raw).trajectory, still) < 0.2 * sizes(raw, still))


@pytest.mark.parametrize("wrong", [None, DroppedFrames(0.3, 3.0), PlanarFlips(0.05)])
def test_rotations_of_what_spins_at_a_changing_rate_are_smoothed_together(
    wrong: Degradation | None,
) -> None:
    """By axes apart these were left at 0.5 to 1.7 of the measured error."""
    left = []
    for seed in range(3):
        rng = np.random.default_rng([36, seed])
        axis = rng.standard_normal(3)
        axis *= rng.uniform(12.0, 20.0) / np.linalg.norm(axis)
        sway = Sines.single(rng.uniform(0.02, 0.05), rng.uniform(0.2, 0.5))
        turn = Motion((Factor(np.r_[axis, np.zeros(3)], Polynomial((0.0, 1.0))),
                       Factor(np.r_[axis, np.zeros(3)], sway)), Motor)  # fmt: skip
        true = turn.sampled(20.0, 9.95)
        raw = NOISE.apply(true, rng)
        raw = raw if wrong is None else wrong.apply(raw, rng)
        found = smoothed_automatically(raw, "rotor")
        assert "rotations smoothed together" in str(found.choice)
        again = found.choice.smooth(raw)
        rows = np.searchsorted(true.time_ns, raw.time_ns)
        before, after, twice = (
            sizes(path, true[rows])[0] for path in (raw, found.trajectory, again)
        )
        assert twice < 1.1 * after
        left.append(after / before)
    assert np.sqrt(np.mean(np.square(left))) < 0.45


@pytest.mark.parametrize("first", [20, 90, 185])
def test_a_burst_of_wrong_poses_in_a_spin_is_left_out_wherever_it_is(first: int) -> None:
    """One near an end was averaged in, or kept as two jumps of level."""
    rng = np.random.default_rng([37, first])
    true = MOTIONS["fast_spin"].sampled(20.0, 9.95).rigid
    raw = NOISE.apply(true, rng)
    burst = slice(first, first + 8)
    poses = raw.motors.coefficients.copy()
    off = Motor.from_twist([0.3, -0.2, 0.1, 0.0, 0.0, 0.0]), Motor.from_translation([0.3, 0.1, 0.2])
    poses[burst] = (off[1] @ raw.motors[burst] @ off[0]).coefficients
    wrong = Trajectory(raw.time_ns, Motor(poses), raw.parent, raw.child)
    found = smoothed_automatically(wrong)
    assert not np.any(found.weights[burst])
    assert np.count_nonzero(found.weights == 0.0) < 12
    assert np.all(sizes(found.trajectory, true) < 0.12 * sizes(wrong, true))


@pytest.mark.parametrize("run", [1, 2, 8])
def test_poses_left_out_next_to_an_end_of_a_spin_are_no_failure(run: int) -> None:
    """A filter that began with them lost all digits of its covariances, and `smooth` raised."""
    true = MOTIONS["fast_spin"].sampled(20.0, 4.95).rigid
    noisy, weights = NOISE.apply(true, np.random.default_rng([39, run])), np.ones(len(true))
    weights[1 : 1 + run] = weights[-1 - run : -1] = 0.0
    assert turning_model(noisy.time_s, noisy.motors, weights, NOISE.sigma_rad).joint


def test_errors_that_last_are_no_motion_beside_a_twist() -> None:
    """A spline follows them; the twist was refused and 0.65 of the error left."""
    left = []
    for seed in range(3):
        rng = np.random.default_rng([38, seed])
        true, error = turning(rng, screw=True), rng.standard_normal((200, 6))
        for k in range(1, 200):
            error[k] = 0.8 * error[k - 1] + 0.6 * error[k]
        errors = Motor.from_twist(error * np.repeat([np.deg2rad(0.5), 0.005], 3))
        raw = Trajectory(true.time_ns, true.motors @ errors, true.parent, true.child)
        found = smoothed_automatically(raw)
        assert found.choice.by_twist
        assert 0.1 < found.choice.memory_s < 0.5
        left.append(sizes(found.trajectory, true) / sizes(raw, true))
    assert np.all(np.sqrt(np.mean(np.square(left), axis=0)) < 0.6)


EXACT = {
    "line": [0.0, 0.0, 0.0, 0.3, 0.0, 0.0],
    "spin": [0.0, 0.0, 1.2, 0.0, 0.0, 0.0],
    "screw": [0.2, -0.5, 1.0, 0.1, 0.3, -0.2],
    "rest": [0.0] * 6,
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rounded_m", [0.0, 1e-15, 1e-9])
@pytest.mark.parametrize("name", EXACT)
def test_a_path_without_noise_stays_as_it_is(name: str, rounded_m: float) -> None:
    """Of rounding alone errors may seem to last, and then tell nearly all of one another."""
    time_ns = np.arange(100) * 33_000_000
    motors = Motor.from_twist(1e-9 * time_ns[:, None] * np.array(EXACT[name]))
    if rounded_m:
        at = rounded_m * np.rint(motors.translation_m / rounded_m)
        motors = Motor.from_rotor_translation(motors.rotor, at)
    path = Trajectory(time_ns, motors, "world", "camera")
    smoothed = smoothed_automatically(path).trajectory
    assert sizes(smoothed, path).max() < 1e-8
