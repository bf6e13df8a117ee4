"""Real recordings with optical truth: tilt no worse than VQF's, run on the same samples."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.orientation import estimate_orientation
from motorcade.ga import Rotor
from motorcade.replays.io.imu import read_imu
from tests.bench.fusion.broad import broad_errors, by_vqf, estimated, read_trial, trial_paths


@pytest.mark.slow
@pytest.mark.parametrize("magnetometer", [False, True], ids=["6 axes", "9 axes"])
def test_the_trials_of_broad(smooth, magnetometer):
    """Fast and slow, tapped, with magnets: means below VQF's, no tilt above 1.25 times its."""
    pytest.importorskip("h5py")
    if not trial_paths():
        pytest.skip("no trials of BROAD; set MOTORCADE_DATA")
    trials = [read_trial(path) for path in trial_paths()]
    ours = [broad_errors(trial, estimated(trial, smooth, magnetometer)) for trial in trials]
    rivals = [broad_errors(trial, by_vqf(trial, smooth, magnetometer)) for trial in trials]
    assert rivals[0]["inclination_deg"] == pytest.approx(0.312 if smooth else 0.429, abs=0.002)
    ratios = [
        a["inclination_deg"] / b["inclination_deg"] for a, b in zip(ours, rivals, strict=True)
    ]
    assert max(ratios) < 1.25
    for kind in ("inclination_deg", "heading_deg", "total_deg")[: 3 if magnetometer else 1]:
        assert np.mean([row[kind] for row in ours]) < np.mean([row[kind] for row in rivals])


def test_a_flight_of_euroc(data_dir, smooth, vqf_tilt, inclination_rms_deg):
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
    assert ours < inclination_rms_deg(vqf_tilt(imu, smooth)[at], truth)
    recorded = np.array([row[11:14] for row in poses], dtype=np.float64)
    np.testing.assert_allclose(found.gyro_bias_rad_s[at[-1]], recorded[-1], atol=0.004)
