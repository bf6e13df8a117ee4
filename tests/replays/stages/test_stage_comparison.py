"""No stage makes a path worse than what it was given without the run saying so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli.runs import result
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.errors import errors
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.integrity import integrity
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import PathErrors
from tests.replays.stages.stamps import Stamps


def truth() -> Trajectory:
    return MOTIONS["handheld"].sampled(60.0, 12.0)


@pytest.fixture(scope="module")
def stream() -> ImuStream:
    path = MOTIONS["handheld"].sampled(200.0, 12.0, child="imu")
    return simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(1)).stream


def judged(stream: ImuStream | None, *, with_truth: bool, **knobs: Any) -> PathErrors:
    """The errors of a run whose poses are measured to 5 mm and 0.3° at 20 Hz."""
    rng = np.random.default_rng(3)
    found = simulate_camera_poses(truth(), 20.0, 0.005, 0.005, rng)
    poses = CameraPoses(
        found, found.trajectory.time_ns, np.full(len(found), np.nan), "board", "as given"
    )
    one = Recording(
        "made up",
        Path(),
        "images",
        Stamps(found.trajectory.time_ns),  # type: ignore[arg-type]
        imu=stream,
        imu_T_camera=Motor.identity(),
        truth=truth() if with_truth else None,
    )
    sensor = imu(one, poses)
    joined = fused(one, poses, sensor, noise_factor=1.0 if stream is not None else None)
    paths = smoothed(joined, representations=("motor",), **knobs)
    return errors(one, poses, joined, paths, integrity(one, poses, sensor, joined, paths))


def turned(stream: ImuStream) -> ImuStream:
    """Its readings with two axes swapped."""
    axes = [1, 0, 2]
    return ImuStream(
        stream.time_ns, stream.angular_rate_rad_s[:, axes], stream.specific_force_m_s2[:, axes]
    )


@pytest.mark.parametrize("with_truth", [True, False])
def test_stages_that_help_are_told_to(with_truth: bool, stream: ImuStream) -> None:
    found = judged(stream, with_truth=with_truth).stages
    assert found.judged_by == ("ground truth" if with_truth else "held-out poses")
    assert found.worse == ()
    assert found.position_rmse_m["fused"] < found.position_rmse_m["camera_poses"]
    assert found.poses > (200 if with_truth else 40)


@pytest.mark.parametrize("with_truth", [True, False])
def test_an_imu_that_harms_is_said_to(with_truth: bool, stream: ImuStream) -> None:
    found = judged(turned(stream), with_truth=with_truth)
    (worse,) = found.stages.worse
    judge = found.stages.judged_by
    assert worse.startswith(f"fused is farther from the {judge} than camera_poses (")
    assert "the IMU contradicts the measured poses (mean NIS " in worse


@pytest.mark.parametrize("with_truth", [True, False])
@pytest.mark.parametrize("inertial", [True, False])
def test_smoothing_that_takes_away_motion_is_said_to(
    with_truth: bool, inertial: bool, stream: ImuStream
) -> None:
    found = judged(stream if inertial else None, with_truth=with_truth, window_s=1.5).stages
    (worse,) = found.worse
    assert worse.startswith(f"smoothed is farther from the {found.judged_by} than fused (")
    assert worse.endswith(": what it took away was motion, or noise that both have")


@pytest.mark.parametrize("with_truth", [True, False])
def test_smoothing_that_takes_away_noise_helps_without_an_imu(with_truth: bool) -> None:
    found = judged(None, with_truth=with_truth).stages
    assert found.worse == ()
    assert found.position_rmse_m["fused"] == found.position_rmse_m["camera_poses"]
    assert found.position_rmse_m["smoothed"] < found.position_rmse_m["fused"]


def test_what_is_worse_stands_in_the_closing_line() -> None:
    compared = {"worse": ["fused is farther from home"]}
    assert "; fused is farther from home; look" in result(
        {"until": "errors", "stage_comparison": compared}, Path("out")
    )
    whole = {
        "camera_poses": {"measured": 3, "frames": 3, "origin": "board"},
        "errors": {"motor": {}},
        "stage_comparison": compared,
    }
    assert "; fused is farther from home; open" in result(whole, Path("out"))


def test_a_path_fused_looking_ahead_is_left_as_it_is(stream: ImuStream) -> None:
    found = judged(stream, with_truth=True).stages
    assert found.position_rmse_m["smoothed"] == found.position_rmse_m["fused"]


def test_a_ground_truth_too_short_to_align_by_ends_no_run() -> None:
    rng = np.random.default_rng(3)
    found = simulate_camera_poses(truth(), 20.0, 0.005, 0.005, rng)
    poses = CameraPoses(
        found, found.trajectory.time_ns, np.full(len(found), np.nan), "markers", "as given"
    )
    one = Recording(
        "made up",
        Path(),
        "images",
        Stamps(found.trajectory.time_ns),  # type: ignore[arg-type]
        truth=truth()[:2],
    )
    sensor = imu(one, poses)
    joined = fused(one, poses, sensor)
    paths = smoothed(joined, representations=("motor",))
    told = errors(one, poses, joined, paths, integrity(one, poses, sensor, joined, paths))
    assert "1 poses at stamps of the path, and 3 are needed" in told.unaligned
    assert told.against_truth == {}
    assert told.figures["motor"]["linear_jitter_m_s2"] is not None
