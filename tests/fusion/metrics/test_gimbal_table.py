"""The table of gimbal lock: what interpolating Euler angles costs, and rotors do not.

Intrinsic x-y′-z″ angles in degrees, interpolated without wrapping over 1000 steps.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.metrics import gimbal_index
from motorcade.fusion.metrics.artifacts import path_over_geodesic
from motorcade.fusion.motions import gimbal_crossing
from motorcade.ga import Motor, Rotor, Trajectory

STEPS = 1000
TABLE = [
    ((10, 85, 10), (-170, 85, -160), "24.7"),
    ((0, 89.9, 0), (170, 89.9, 170), "17.0"),
    ((0, 45, 0), (180, 45, -180), "1.53"),
    ((0, 89, 0), (90, 89, 0), "1.00"),
]


def ways(start, end):
    """Both interpolations between two sets of angles: rotors ``(1001,)`` each."""
    fraction = np.linspace(0.0, 1.0, STEPS + 1)
    first, last = np.deg2rad(start), np.deg2rad(end)
    angles = first + fraction[:, None] * (last - first)
    rotors = Rotor.from_euler(first).interpolate(Rotor.from_euler(last), fraction)
    return Rotor.from_euler(angles), rotors, angles


@pytest.mark.parametrize(("start", "end", "ratio"), TABLE)
def test_the_path_of_euler_angles_over_the_geodesic(start, end, ratio):
    euler, rotors, angles = ways(start, end)
    decimals = len(ratio.partition(".")[2])
    assert f"{path_over_geodesic(euler):.{decimals}f}" == ratio
    assert f"{path_over_geodesic(rotors):.6f}" == "1.000000"
    turned = Rotation.from_euler("XYZ", angles)
    steps = (turned[:-1].inv() * turned[1:]).magnitude()
    scipys = steps.sum() / (turned[0].inv() * turned[-1]).magnitude()
    assert path_over_geodesic(euler) == pytest.approx(scipys, rel=1e-9)


@pytest.mark.parametrize(
    ("start", "end", "turns"), [(*row[:2], n) for row, n in zip(TABLE, (1, 1, 0, 0), strict=True)]
)
def test_the_long_detours_are_whole_turns(start, end, turns):
    euler, rotors, _ = ways(start, end)
    stamps = np.arange(STEPS + 1, dtype=np.int64) * 10_000_000
    estimate, truth = (
        Trajectory(stamps, Motor.from_rotor_translation(r, np.zeros(3))) for r in (euler, rotors)
    )
    found = gimbal_index(estimate, truth)
    assert found.spurious_turns == turns
    assert found.path_ratio == pytest.approx(path_over_geodesic(euler), rel=1e-9)
    assert gimbal_index(truth, truth).spurious_turns == 0


@pytest.mark.parametrize(("pitch_deg", "ratio"), [(80.0, "5.8"), (89.0, "57.3"), (89.9, "573")])
def test_the_peak_rate_of_euler_angles_over_the_true_rate(pitch_deg, ratio):
    """Swinging past the pole at a pitch of that many degrees, as 1 / cos(pitch)."""
    motion = gimbal_crossing(1.0, np.deg2rad(90.0 - pitch_deg))
    # The passage is where the swing is fastest; look closely there.
    coarse = np.linspace(0.0, 10.0, 10_001)
    speed = np.hypot(*motion.at(coarse).body_twist[:, :2].T)
    centre = coarse[np.argmax(speed)]
    times = centre + np.linspace(-0.01, 0.01, 20_001)
    sample = motion.at(times)
    roll = np.unwrap(sample.pose.rotor.as_euler()[:, 0])  # the last angle turns by itself too
    rate = np.abs(np.gradient(roll, times)).max()
    true = np.linalg.norm(sample.body_twist[:, :2], axis=1).max()
    decimals = len(ratio.partition(".")[2])
    assert f"{rate / true:.{decimals}f}" == ratio
    assert rate / true == pytest.approx(1.0 / np.cos(np.deg2rad(pitch_deg)), rel=1e-3)
