"""Trials of BROAD, an IMU under an optical system: nothing is wrong, and nothing is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.health import check_health
from motorcade.ga import Motor, Trajectory
from tests.bench.fusion.broad import read_trial, trial_paths

h5py = pytest.importorskip("h5py")


@pytest.mark.slow
@pytest.mark.parametrize("step", [1, 3, 6])
@pytest.mark.parametrize("path", trial_paths(), ids=lambda path: path.stem)
def test_clean_trials_raise_no_alarm(path: Path, step: int) -> None:
    """Poses at 285, 95 and 48 Hz; slower ones do not tell how a shaken sensor turned between."""
    trial = read_trial(path)
    with h5py.File(path) as file:
        places, wxyz = file["opt_pos"][:], file["opt_quat"][:]
    known = np.isfinite(places).all(axis=1) & np.isfinite(wxyz).all(axis=1)
    rows = np.flatnonzero(known)[::step]
    poses = Motor.from_rotor_translation(trial.world_R_imu[rows], places[rows])
    health = check_health(Trajectory(trial.imu.time_ns[rows], poses), trial.imu, Motor.identity())
    assert not health.findings
