"""Kalman filters across gaps of hours and months: each half is what it is by itself."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Trajectory

GAPS_S = (100.0, 1e3, 1e4, 1e6, 1e8)
POSES, BEFORE = 400, 250


def parted(gap_s: float) -> Trajectory:
    """A noisy path with wrong poses, and nothing measured for a while in its middle."""
    rng = np.random.default_rng(5)
    true = MOTIONS["handheld"].sampled(30.0, (POSES - 1) / 30.0)
    noisy = Outliers(0.01, 0.3, 0.5).apply(Gaussian(0.005, 0.01).apply(true, rng), rng)
    time_ns = noisy.time_ns.copy()
    time_ns[BEFORE:] += int(1e9 * gap_s)
    return Trajectory(time_ns, noisy.poses)


def far(one: Trajectory, other: Trajectory) -> float:
    difference = one.motors.as_matrix() - other.motors.as_matrix()
    return float(np.max(np.abs(difference)))


@pytest.mark.parametrize("gap_s", GAPS_S)
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("representation", ["motor", "rotor", "similarity", "quaternion"])
def test_halves_apart_by_a_long_gap_know_nothing_of_each_other(
    representation: str, order: str, gap_s: float
) -> None:
    path = parted(gap_s)
    before, behind = path[:BEFORE], path[BEFORE:]
    together = smooth(path, f"rts_constant_{order}", representation)
    alone = [smooth(one, f"rts_constant_{order}", representation) for one in (before, behind)]
    # A tenth of the noise: what is left of the prior of the rates behind the gap.
    assert far(together[:BEFORE], alone[0]) < 1e-3
    assert far(together[BEFORE + 60 :], alone[1][60:]) < 1e-8
    filtered = smooth(path, f"constant_{order}", representation)
    assert far(filtered[BEFORE : BEFORE + 1], behind[:1]) < 1e-6
