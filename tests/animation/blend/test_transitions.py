"""Cross-fades and inertialised switches are smooth, end in the new motion, and chain."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.blend import CrossFade, Inertialized, Shifted
from motorcade.ga import Motor


def _positions(motion, time_s):
    return motion.at(time_s).translation_m


def _velocity_step(motion, at_s: float) -> float:
    """The largest change of any joint's velocity across an instant, m/s."""
    h = 1e-4
    before = _positions(motion, at_s - np.array([2 * h, h]))
    after = _positions(motion, at_s + np.array([h, 2 * h]))
    return float(np.abs(np.diff(after, axis=0) - np.diff(before, axis=0)).max() / h)


@pytest.mark.parametrize("kind", [CrossFade, Inertialized])
def test_a_transition_has_no_step_in_pose_or_velocity(kind, cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.7, phase=0.3, stride=0.5)
    joined = kind(walk, run, 0.5, 0.3)
    fine = 0.5 + np.linspace(-1e-6, 0.3 + 1e-6, 2001)
    steps = np.abs(np.diff(_positions(joined, fine), axis=0)).max()
    assert steps < 8.0 * np.diff(fine).max()
    # Clips are straight between keys, so velocities of the motions themselves step a little.
    allowed = 0.05 + 2.0 * max(_velocity_step(walk, 0.5), _velocity_step(run, 0.5))
    assert _velocity_step(joined, 0.5) < allowed
    assert _velocity_step(joined, 0.8) < allowed
    # The witness: a switch at once has a step of pose, so these bounds mean something.
    assert np.abs(_positions(walk, 0.5) - _positions(run, 0.5)).max() > 0.05


@pytest.mark.parametrize("kind", [CrossFade, Inertialized])
def test_outside_the_transition_the_motions_are_themselves(kind, cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.7, phase=0.3)
    joined = kind(walk, run, 0.5, 0.3)
    for times, motion in (([0.0, 0.3, 0.4999], walk), ([0.8, 0.9, 3.0], run)):
        np.testing.assert_allclose(
            joined.at(times).coefficients, motion.at(times).coefficients, atol=1e-12
        )


def test_inertia_never_swings_past(rng, cycle):
    still = cycle("still", 1.0, stride=0.0)

    class Fast:
        """A motion that rushes towards the other one."""

        def at(self, time_s):
            base = still.at(time_s)
            away = np.zeros((*np.shape(time_s), 4, 6))
            away[..., 3] = (0.2 - 10.0 * (np.asarray(time_s) - 0.5))[..., None]
            return base @ Motor.from_twist(away)

    joined = Inertialized(Fast(), still, 0.5, 0.4)
    times = np.linspace(0.5, 0.9, 101)
    offset = (_positions(joined, times) - _positions(still, times))[:, 0, 0]
    assert offset[0] == pytest.approx(0.2, abs=1e-9)
    assert np.all(offset > -1e-12)
    assert offset[-1] == pytest.approx(0.0, abs=1e-12)


def test_shifted_runs_on_its_own_clock(cycle):
    walk = cycle("walk", 1.2)
    shifted = Shifted(walk, start_s=2.0, into_s=0.3, rate=1.5)
    np.testing.assert_allclose(
        shifted.at([2.0, 2.2]).coefficients, walk.at([0.3, 0.6]).coefficients, atol=1e-12
    )
    twice = CrossFade(CrossFade(walk, shifted, 0.2, 0.2), walk, 0.6, 0.2)
    assert twice.at(np.linspace(0, 1, 7)).shape == (7, 4)


def test_refusals(cycle):
    walk = cycle("walk", 1.2)
    with pytest.raises(ValueError, match=r"CrossFade\.duration_s: expected a number above 0"):
        CrossFade(walk, walk, 0.0, 0.0)
    with pytest.raises(ValueError, match=r"Inertialized\.start_s"):
        Inertialized(walk, walk, np.nan)
    for into_s in (np.nan, np.inf):
        with pytest.raises(ValueError, match=r"Shifted\.into_s: expected seconds, got"):
            Shifted(walk, into_s=into_s)
    with pytest.raises(ValueError, match=r"Shifted\.rate"):
        Shifted(walk, rate=-1.0)
