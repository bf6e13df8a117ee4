"""The live smoother: exact where nothing is to smooth, better than raw where there is, and bounded.

Its filters have a witness in plain NumPy, with textbook matrices.
"""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import LiveSmoother
from motorcade.fusion.smoothing.live import MEMORY_S
from motorcade.fusion.smoothing.native import _live
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

STILL = (1.0, 0.0, 0.0, 0.0)


def streamed(live: LiveSmoother, path: Trajectory) -> list[tuple[float, FloatArray, FloatArray]]:
    wxyz, position_m = path.motors.as_quaternion_translation()
    time_s = 1e-9 * (path.time_ns - path.time_ns[0])
    return [live.update(*one) for one in zip(time_s.tolist(), position_m, wxyz, strict=True)]


def noisy(name: str, rate_hz: float = 30.0, seconds: float = 6.0, seed: int = 0) -> Trajectory:
    true = MOTIONS[name].sampled(rate_hz, seconds).rigid
    return Gaussian(0.005, 0.01).apply(true, np.random.default_rng(seed))


def textbook(positions: FloatArray, interval_s: float) -> FloatArray:
    """The bank over positions at even stamps, written down with matrices; no outliers."""
    fading, estimates = np.exp(-interval_s / MEMORY_S), []
    filters = [(order, 4.0 / interval_s / 2.0**k) for order in range(3) for k in range(12)]
    states = []
    for order, cutoff_hz in filters:
        size = order + 1
        f = np.array(
            [
                [interval_s ** (j - i) / [1, 1, 2][j - i] if j >= i else 0.0 for j in range(size)]
                for i in range(size)
            ]
        )
        q = np.array(
            [
                [
                    interval_s ** (2 * order + 1 - i - j)
                    / ([1, 1, 2][order - i] * [1, 1, 2][order - j] * (2 * order + 1 - i - j))
                    for j in range(size)
                ]
                for i in range(size)
            ]
        )
        q *= (2.0 * np.pi * cutoff_hz) ** (2 * size) * interval_s
        x = np.zeros((size, 3))
        x[0] = positions[0]
        p = np.diag([1.0, *(1e6 * interval_s ** (-2.0 * i) for i in range(1, size))])
        states.append([f, q, x, p, 0.0, 0.0, 0.0])
    for k, z in enumerate(positions[1:], start=1):
        said, scores = [], []
        for one in states:
            f, q, x, p, count, squares, logs = one
            x, p = f @ x, f @ p @ f.T + q
            spread = p[0, 0] + 1.0
            v = z - x[0]
            gain = p[:, 0] / spread
            x = x + np.outer(gain, v)
            rest = np.eye(len(p)) - np.outer(gain, np.eye(len(p))[0])
            p = rest @ p @ rest.T + np.outer(gain, gain)
            if k > len(p):
                count = fading * count + 1.0
                squares = fading * squares + v @ v / (3.0 * spread)
                logs = fading * logs + np.log(spread)
            one[2:] = [x, p, count, squares, logs]
            said.append(x[0])
            scores.append(-1.5 * (count * np.log(squares / count) + logs) if count else 0.0)
        weights = np.exp(np.array(scores) - max(scores))
        weights[weights < np.exp(-4.0)] = 0.0
        weights /= weights.sum()
        weights[weights < 0.02] = 0.0
        estimates.append(weights / weights.sum() @ np.array(said))
    return np.array(estimates)


def test_filters_and_weights_are_those_of_the_textbook() -> None:
    """Independent: Joseph's form, whole matrices, weights from the likelihood as it is written."""
    rng = np.random.default_rng(3)
    k = np.arange(120)[:, None]
    positions = np.sin(0.05 * k + [0.0, 1.0, 2.0]) + 0.01 * rng.uniform(-1.0, 1.0, (120, 3))
    live, interval_s = LiveSmoother(), 1.0 / 32.0  # an interval without a rounding of its own
    ours = np.array([live.update(i * interval_s, z, STILL)[1] for i, z in enumerate(positions)])
    np.testing.assert_allclose(ours[5:], textbook(positions, interval_s)[4:], atol=1e-7)


@pytest.mark.parametrize("step_rad", [0.003, 0.3])
@pytest.mark.parametrize("lag_s", [0.0, 0.2])
def test_turns_about_one_axis_are_smoothed_as_numbers_are(step_rad: float, lag_s: float) -> None:
    """Their angles add up as positions along one axis do, small steps and large ones."""
    rng = np.random.default_rng(6)
    angles = np.cumsum(step_rad * (1.0 + rng.uniform(-0.1, 0.1, 90)))
    live = LiveSmoother(lag_s)
    for k, angle in enumerate(angles.tolist()):
        wxyz = [np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0]
        _, position, turned = live.update(k / 30.0, [angle, 0.0, 0.0], wxyz)
        expected = np.array([np.cos(position[0] / 2.0), np.sin(position[0] / 2.0), 0.0, 0.0])
        assert abs(abs(turned @ expected) - 1.0) < 1e-13


@pytest.mark.parametrize("lag_s", [0.0, 0.2])
def test_what_has_no_noise_is_left_as_it_is(lag_s: float) -> None:
    """A steady screw about an axis through the body is followed, and foretold, without error."""
    live = LiveSmoother(lag_s)
    for k in range(90):
        turned = Rotation.from_rotvec([0.0, 0.0, 0.02 * k]).as_quat(scalar_first=True)
        due = live.update(k / 30.0, [0.1 * k, 1.0, 0.0], turned)
    np.testing.assert_allclose(due[1], [3.0 * due[0], 1.0, 0.0], atol=1e-9)
    _, position, wxyz = live.predict(3.4)
    np.testing.assert_allclose(position, [10.2, 1.0, 0.0], atol=1e-6)
    expected = Rotation.from_rotvec([0.0, 0.0, 2.04]).as_quat(scalar_first=True)
    assert abs(abs(wxyz @ expected) - 1.0) < 1e-9


@pytest.mark.parametrize("lag_s", [0.0, 0.1, 0.5])
def test_a_trajectory_is_its_stream(lag_s: float) -> None:
    """What falls due while poses come in is what `smooth` gives for those stamps."""
    path = noisy("handheld")
    whole = LiveSmoother(lag_s).smooth(path)
    time_s = (path.time_s - path.time_s[0]).round(9).tolist()
    first = {}
    for due in streamed(LiveSmoother(lag_s), path):
        first.setdefault(round(due[0], 9), due[1])
    del first[0.0]  # given before it was due, while nothing was
    assert len(first) > 100
    for stamp, position_m in first.items():
        if stamp > 0.2:
            there = whole.motors.translation_m[time_s.index(stamp)]
            np.testing.assert_allclose(there, position_m, atol=1e-9)
    assert np.array_equal(whole.time_ns, path.time_ns)


@pytest.mark.parametrize("name", sorted(MOTIONS))
def test_smoothing_helps_and_lag_helps_more(name: str) -> None:
    """Position and rotation together, on motions that no constant was chosen for too."""
    true, raw = MOTIONS[name].sampled(30.0, 6.0).rigid, noisy(name)

    def error(path: Trajectory) -> float:
        rest = true.motors.local(path.motors)[15:]
        return float(np.sqrt(np.mean((rest / ([0.01] * 3 + [0.005] * 3)) ** 2)))

    now, later = (error(LiveSmoother(lag_s).smooth(raw)) for lag_s in (0.0, 0.3))
    assert later < now < error(raw)


@pytest.mark.parametrize("name", sorted(MOTIONS))
def test_prediction_beats_holding_the_last_pose(name: str) -> None:
    rate_hz, ahead = 30.0, 2
    true, raw = MOTIONS[name].sampled(rate_hz, 6.0).rigid, noisy(name)
    live, ours, held = LiveSmoother(), [], []
    wxyz, position_m = raw.motors.as_quaternion_translation()
    for k in range(len(raw) - ahead):
        live.update(k / rate_hz, position_m[k], wxyz[k])
        _, position, turned = live.predict((k + ahead) / rate_hz)
        ours.append(Motor.from_quaternion_translation(turned, position).coefficients)
        held.append(raw.motors[k].coefficients)
    expected = true.motors[ahead:]
    misses = [expected.local(Motor(np.array(made))) for made in (ours, held)]
    by_part = [
        [np.sqrt(np.mean(miss[:, part] ** 2)) for part in (slice(0, 3), slice(3, 6))]
        for miss in misses
    ]
    assert by_part[0][0] < by_part[1][0]
    assert by_part[0][1] < by_part[1][1]


def test_units_and_the_choice_of_world_do_not_matter() -> None:
    """Nothing inside has a size in metres."""
    path = noisy("handheld")
    world = Motor.from_euler_translation([0.3, -1.0, 2.0], [4.0, -2.0, 9.0])
    moved = Trajectory(path.time_ns, world @ path.motors)
    ours = LiveSmoother(0.2).smooth(moved).motors
    expected = world @ LiveSmoother(0.2).smooth(path).motors
    np.testing.assert_allclose(expected.local(ours), 0.0, atol=1e-9)
    small, large = LiveSmoother(), LiveSmoother()
    for k, position in enumerate(path.motors.translation_m):
        here = small.update(k / 30.0, position, STILL)[1]
        there = large.update(k / 30.0, 1000.0 * position, STILL)[1]
    np.testing.assert_allclose(1000.0 * here, there, rtol=1e-9)


def test_one_wrong_pose_is_hardly_heard_and_a_jump_is_followed() -> None:
    path = noisy("handheld", seconds=8.0)
    time_s = path.time_s - path.time_s[0]
    wxyz, position_m = path.motors.as_quaternion_translation()
    wrong, jumped = position_m.copy(), position_m.copy()
    wrong[150] += 0.5
    jumped[150:] += 0.5
    live, tried, level = LiveSmoother(), LiveSmoother(), LiveSmoother()
    made = []
    for k, t in enumerate(time_s.tolist()):
        rows = ((live, position_m), (tried, wrong), (level, jumped))
        made.append([one.update(t, at[k], wxyz[k])[1] for one, at in rows])
    off = np.array(made)
    assert np.abs(off[150, 1] - off[150, 0]).max() < 0.05
    assert np.abs(off[156:, 2] - off[156:, 0] - 0.5).max() < 0.02


def test_signs_of_quaternions_and_gaps() -> None:
    """The sign that comes in is free, and nothing is carried across a long gap."""
    path = noisy("tumble")
    wxyz, position_m = path.motors.as_quaternion_translation()
    signs = np.where(np.random.default_rng(5).random(len(path)) < 0.5, -1.0, 1.0)
    first, second = LiveSmoother(), LiveSmoother()
    last = np.array(STILL)
    for k in range(len(path)):
        a = first.update(k / 30.0, position_m[k], wxyz[k])[2]
        b = second.update(k / 30.0, position_m[k], signs[k] * wxyz[k])[2]
        assert abs(abs(a @ b) - 1.0) < 1e-12
        if k > 0:
            assert b @ last > 0.0
        last = b
    after = first.update(len(path) / 30.0 + 60.0, [100.0, 0.0, 0.0], STILL)
    np.testing.assert_allclose(after[1], [100.0, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((0.1, [0.0, 0.0, 0.0], STILL), "expected a stamp after"),
        ((np.nan, [0.0, 0.0, 0.0], STILL), "time_s: expected a finite number"),
        ((9.0, [0.0, np.inf, 0.0], STILL), "position_m: expected finite metres"),
        ((9.0, [0.0, 0.0], STILL), "position_m: expected 3 numbers"),
        ((9.0, np.zeros((3, 1)), STILL), "position_m: expected 3 numbers"),
        ((9.0, [0.0, 0.0, 0.0], [0.0] * 4), "wxyz: expected a quaternion"),
        ((9.0, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "wxyz: expected 4 numbers"),
        ((9.0, 1.0, STILL), "position_m: expected 3 numbers"),
    ],
)
def test_what_is_refused_changes_nothing(given: tuple, says: str) -> None:
    path = noisy("handheld", seconds=1.0)
    live, spared = LiveSmoother(0.1), LiveSmoother(0.1)
    streamed(live, path)
    streamed(spared, path)
    with pytest.raises((ValueError, TypeError), match=says):
        live.update(*given)
    here, there = (one.update(2.0, [1.0, 2.0, 3.0], STILL) for one in (live, spared))
    assert here[0] == there[0]
    np.testing.assert_array_equal(here[1], there[1])


def test_arguments_and_poses_that_do_not_fit() -> None:
    with pytest.raises(ValueError, match="lag_s: expected 0 or more"):
        LiveSmoother(-0.1)
    for short in (5e-324, 1e-300, 9e-10):
        with pytest.raises(ValueError, match="lag_s: expected 0, or 1e-09 seconds or more"):
            LiveSmoother(short)
    for odd in (True, "0.1", None, [0.1, 0.2]):
        with pytest.raises(TypeError, match="lag_s: expected a number"):
            LiveSmoother(odd)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="memory_s"):
        LiveSmoother(memory_s=0.0)
    with pytest.raises(ValueError, match="expected a pose before"):
        LiveSmoother().predict(0.0)
    live = LiveSmoother()
    live.update(0.0, [1.0, 2.0, 3.0], STILL)
    for late in (-5.0, np.nan, np.inf, 0.51, 1e9):
        with pytest.raises(ValueError, match=r"expected 0\.000000 to at most 0\.500000 s later"):
            live.predict(late)
    path = MOTIONS["zoom"].sampled(30.0, 1.0)
    assert isinstance(path.poses, Similarity)
    with pytest.raises(ValueError, match="expected rigid poses"):
        LiveSmoother().smooth(path)
    short = path.rigid[:3]
    assert LiveSmoother().smooth(short) is short


@pytest.mark.parametrize("lag_s", [5e-324, 1e-16, 1e-14])
def test_every_pose_comes_out_once_at_a_lag_that_stamps_cannot_tell(lag_s: float) -> None:
    """The newest stamp less such a lag is the newest stamp."""
    poses = noisy("handheld", seconds=3.0).motors
    given = np.concatenate([poses.translation_m, poses.rotor.coefficients], axis=-1)
    time_s = np.arange(len(given)) * 2.0
    room = np.full((3 * len(given), 7), np.nan)
    _live.smooth(lag_s, MEMORY_S, time_s, np.ascontiguousarray(given), room[: len(given)])
    assert np.all(np.isfinite(room[: len(given)]))
    assert np.all(np.isnan(room[len(given) :]))
    assert len(np.unique(room[: len(given)], axis=0)) == len(given)


@pytest.mark.parametrize(("unit", "says"), [(1e3, "milliseconds"), (1e6, None), (1e9, None)])
def test_stamps_in_other_units_are_told(
    unit: float, says: str | None, caplog: pytest.LogCaptureFixture
) -> None:
    live = LiveSmoother()
    with caplog.at_level("WARNING", "motorcade.smooth"):
        live.update(0.0, [0.0, 0.0, 0.0], STILL)
        if says is None:
            with pytest.raises(ValueError, match="divide nanoseconds by 1e9"):
                live.update(unit / 30.0, [0.0, 0.0, 0.0], STILL)
            live.update(1.0 / 30.0, [0.0, 0.0, 0.0], STILL)  # as if nothing had been
            return
        for k in range(1, 20):
            live.update(k * unit / 30.0, [0.0, 0.0, 0.0], STILL)
    assert caplog.text.count(says) == 1


def test_copies_go_their_own_way_and_fresh_ones_can_be_pickled() -> None:
    live = LiveSmoother(0.1, 1.0)
    assert vars(pickle.loads(pickle.dumps(live))).keys() == vars(live).keys()
    for k in range(20):
        live.update(k / 30.0, [0.1 * k, 0.0, 0.0], STILL)
    for other in (copy.copy(live), copy.deepcopy(live)):
        other.update(20 / 30.0, [5.0, 0.0, 0.0], STILL)
    due = live.update(20 / 30.0, [2.0, 0.0, 0.0], STILL)
    np.testing.assert_allclose(due[1], [3.0 * due[0], 0.0, 0.0], atol=1e-9)
    with pytest.raises(TypeError, match=r"use copy\.deepcopy"):
        pickle.dumps(live)
