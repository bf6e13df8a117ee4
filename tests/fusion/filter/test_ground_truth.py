"""The witnesses of a ground truth's own faults: found where they were put, and on a flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.ga import Motor
from tests.bench.data import data_folder
from tests.bench.fusion.ground_truth import found_faults, set_right, smoothed_nees
from tests.bench.fusion.recorded import Flight, flight


def test_a_lean_and_a_turn_are_found_where_they_were_put(record, rng):
    run = record(rng, 40.0)
    path = run.camera
    placed = replace(path, poses=path.motors @ run.imu_T_camera.inverse())
    lean, axes = np.deg2rad([0.5, -0.3]), np.deg2rad([0.1, -0.2, 0.3])
    leant = Motor.from_twist(np.concatenate([-lean, np.zeros(4)]))
    turned = Motor.from_twist(np.concatenate([axes, np.zeros(3)]))
    right = Flight("drawn", run.imu, placed)
    wrong = Flight("drawn", run.imu, replace(placed, poses=leant @ placed.motors @ turned))
    for one, leans, turns in ((right, 0.0 * lean, 0.0 * axes), (wrong, lean, axes)):
        faults = found_faults(one)
        assert max(faults.lean_sigma_rad, faults.axes_sigma_rad) < np.deg2rad(0.12)
        assert np.linalg.norm(faults.lean_rad - leans) < 4.0 * faults.lean_sigma_rad
        assert np.linalg.norm(faults.axes_rad - turns) < 4.0 * faults.axes_sigma_rad
    back = set_right(wrong, found_faults(wrong)).truth.motors
    assert np.abs(back.local(placed.motors)[:, :3]).max() < np.deg2rad(0.1)


@pytest.mark.slow
def test_v2_02_contradicts_gravity_and_mh_05_does_not():
    """Nothing was chosen on either; the leaning explains most of what NEES says there."""
    leaning, upright = (flight(name, data_folder()) for name in ("V2_02", "MH_05"))
    if leaning is None or upright is None:
        pytest.skip("V2_02 and MH_05 are not here")
    faults = found_faults(leaning)
    assert np.linalg.norm(faults.lean_rad) > 5.0 * faults.lean_sigma_rad
    assert smoothed_nees(set_right(leaning, faults), 0) < 0.6 * smoothed_nees(leaning, 0)
    none = found_faults(upright)
    assert np.linalg.norm(none.lean_rad) < 3.0 * none.lean_sigma_rad
