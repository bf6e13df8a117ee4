"""Real recordings with optical truth: tilt no worse than VQF's, run on the same samples."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.orientation import estimate_orientation
from motorcade.ga import Rotor
from motorcade.replays.files.imu import read_imu
from tests.bench.fusion.broad import orientation_rmse_deg, read_trial, trial_paths


@pytest.mark.slow
def test_tilt_on_the_trials_of_broad(smooth, by_vqf):
    """Fast and slow, by hand and by arm, with taps: the mean below VQF's, none above 1.25 times."""
    pytest.importorskip("h5py")
    if not trial_paths():
        pytest.skip("no trials of BROAD; set MOTORCADE_DATA")
    ours, rivals = [], []
    for path in trial_paths():
        trial = read_trial(path)
        found = estimate_orientation(trial.imu, smooth=smooth).world_R_imu
        ours.append(orientation_rmse_deg(found, trial)["inclination_deg"])
        rival = by_vqf(trial.imu, smooth)
        rivals.append(orientation_rmse_deg(rival, trial)["inclination_deg"])
        if trial.name == "02":  # the published package
            assert rivals[-1] == pytest.approx(0.312 if smooth else 0.429, abs=0.002)
    assert np.mean(ours) < np.mean(rivals)
    assert np.max(np.divide(ours, rivals)) < 1.25


def test_a_flight_of_euroc(data_dir, smooth, by_vqf, inclination_rms_deg):
    """V1_02, defaults: a bias of 4.5°/s, found in the moments before take-off."""
    folder = data_dir / "imu"
    imu = read_imu(folder / "V102_imu.txt")
    lines = (folder / "V1_02_medium.csv").read_text().splitlines()
    poses = [row.split(",") for row in lines if row[:1].isdigit()]
    # stamps of the ground truth are rounded otherwise, by less than 0.1 µs
    at = np.searchsorted(imu.time_ns, [int(row[0]) - 1000 for row in poses])
    assert np.max(np.abs(imu.time_ns[at] - [int(row[0]) for row in poses])) < 1000
    wxyz = np.array([row[4:8] for row in poses], dtype=np.float64)
    truth = Rotor.from_quaternion(wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True))
    found = estimate_orientation(imu, smooth=smooth)
    ours = inclination_rms_deg(found.world_R_imu[at], truth)
    assert ours < (0.65 if smooth else 1.4)
    assert ours < inclination_rms_deg(by_vqf(imu, smooth)[at], truth)
    recorded = np.array([row[11:14] for row in poses], dtype=np.float64)
    np.testing.assert_allclose(found.gyro_bias_rad_s[at[-1]], recorded[-1], atol=0.004)
