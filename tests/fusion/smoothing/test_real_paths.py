"""Real paths, smoothed as `auto` picks: no farther from the ground truth, and smoother."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.metrics import Align, evaluate, match, rotation_rad
from motorcade.fusion.smoothing import choose, smooth
from motorcade.fusion.smoothing.results import changes
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.replays.stages.camera.board_poses import board_poses

MANIFESTS = Path(__file__).parents[3] / "docs" / "manifests"
XYZ, DESK = "freiburg1_xyz-groundtruth.txt", "fr2_desk_groundtruth.txt"


@pytest.mark.parametrize(
    ("estimate", "truth", "align", "jitter_ratios"),
    [
        ("freiburg1_xyz-rgbdslam.txt", XYZ, "se3", (0.6, 0.98)),
        # Its turns fill the band that would tell their noise.
        ("fr2_desk_ORB.txt", DESK, "sim3", (0.25, 1.001)),
        # Keyframes at 5 Hz are left as they are.
        ("freiburg1_xyz-ORB_kf_mono.txt", XYZ, "sim3", (1.001, 1.001)),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_trajectories_of_slam_come_no_farther_from_the_truth_and_jitter_less(
    estimate: str, truth: str, align: Align, jitter_ratios: tuple[float, float], data_dir: Path
) -> None:
    folder = data_dir / "trajectories"
    raw, reference = read_trajectory(folder / estimate), read_trajectory(folder / truth)
    choice = choose(raw)
    smoothed = choice.smooth(raw)
    # What cannot be told of the noise is not named, and nothing is at a floor of the search.
    assert all(one.noise > 3e-4 for one in choice.models if not one.unobservable)
    assert all(np.isnan(one.noise) for one in choice.models if one.unobservable)
    before, after = (evaluate(path, reference, align, 0.02) for path in (raw, smoothed))
    assert after.ape_m.rmse < 1.001 * before.ape_m.rmse
    # Smoothed positions align the world otherwise, which counts for more than turns do here.
    matched = match(raw, reference, align, max_difference_s=0.02)
    turns = (
        rotation_rad(
            matched.alignment.apply(path.motors[matched.pairs.estimate_index]),
            matched.pairs.reference,
        )
        for path in (smoothed, raw)
    )
    left, there = (np.sqrt(np.mean(turn**2)) for turn in turns)
    assert left < 1.01 * there
    assert before.jitter is not None
    assert after.jitter is not None
    assert after.jitter.linear_m_s2 < jitter_ratios[0] * before.jitter.linear_m_s2
    assert after.jitter.angular_rad_s2 < jitter_ratios[1] * before.jitter.angular_rad_s2


@pytest.mark.slow
@pytest.mark.parametrize("estimate", ["KITTI_00_ORB.txt", "KITTI_00_SPTAM.txt"])
def test_a_car_turns_from_pose_to_pose_as_it_was_estimated(estimate: str, data_dir: Path) -> None:
    """Its body shakes faster than images at 10 Hz resolve."""
    raw, reference = _kitti(data_dir, estimate), _kitti(data_dir, "KITTI_00_gt.txt")
    before, after = (evaluate(path, reference, "se3") for path in (raw, choose(raw).smooth(raw)))
    for kind in ("rpe_rot_deg", "rpe_trans_m", "ape_m", "rotation_deg"):
        assert getattr(after, kind).rmse < 1.001 * getattr(before, kind).rmse


@pytest.mark.slow
def test_what_looks_like_noise_of_s_ptam_is_an_image_that_it_runs_ahead(data_dir: Path) -> None:
    """Its rows are an image early: the lag says so, and put right they turn to 0.12° as they are.

    Against the early stamps an average over five poses seems to help, for it flattens turns that do
    not match; at the right ones it takes away what the car did.
    """
    raw, reference = _kitti(data_dir, "KITTI_00_SPTAM.txt"), _kitti(data_dir, "KITTI_00_gt.txt")
    averaged = smooth(raw, "savitzky_golay", "rotor", window_s=0.5, order=1)
    paths = {"raw": raw, "auto": smooth(raw), "averaged": averaged}
    early = {name: evaluate(path, reference, "se3") for name, path in paths.items()}
    interval_ms = 1e3 * float(np.median(np.diff(raw.time_s)))
    lag_ms = early["raw"].angular_rate_lag_ms
    assert lag_ms is not None
    assert round(lag_ms / interval_ms) == -1
    right = {
        name: evaluate(
            Trajectory(raw.time_ns[1:], path.motors[:-1], raw.parent, raw.child), reference, "se3"
        ).rpe_rot_deg.rmse
        for name, path in paths.items()
    }
    assert early["averaged"].rpe_rot_deg.rmse < 0.9 * early["raw"].rpe_rot_deg.rmse
    assert right["raw"] < 0.12
    assert right["auto"] < 1.001 * right["raw"]
    assert right["averaged"] > 1.5 * right["raw"]


def _kitti(data_dir: Path, file: str) -> Trajectory:
    folder = data_dir / "trajectories"
    return read_trajectory(folder / file, times=folder / "KITTI_00_gt_times.txt")


@pytest.mark.slow
def test_a_tracked_board_is_left_where_it_is_and_jitters_less(data_dir: Path) -> None:
    """The reference was measured from the same images and jitters as they do: jitter is told
    without it, and what leaves that jitter out lies farther from it, here by 5 of 1,212 µm.
    """
    recording = open_recording(data_dir / "replays" / "vamr_board", MANIFESTS / "vamr_board.toml")
    raw = board_poses(recording).measurements.trajectory
    assert recording.truth is not None
    smoothed = choose(raw).smooth(raw)
    before, after = (evaluate(path, recording.truth) for path in (raw, smoothed))
    assert after.ape_m.rmse < 1.01 * before.ape_m.rmse
    figures = changes(raw, smoothed)
    for kind in ("linear_jitter_m_s2", "angular_jitter_rad_s2"):
        jitter, raw_jitter = figures[f"smoothed_{kind}"], figures[f"raw_{kind}"]
        assert jitter is not None
        assert raw_jitter is not None
        assert jitter < raw_jitter
    assert isinstance(smoothed.poses, Motor)
    assert np.isfinite(smoothed.poses.coefficients).all()
