"""Whole runs on real recordings, judged by their own truths."""

import json
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.cli import main

MANIFESTS = Path(__file__).resolve().parents[2] / "docs" / "manifests"

pytestmark = pytest.mark.slow


def report(out: Path, *arguments: object) -> dict[str, Any]:
    assert main(["run", *map(str, arguments), "--out", str(out), "--until", "report"]) == 0
    found: dict[str, Any] = json.loads((out / "report.json").read_text())
    return found


def test_a_handheld_checkerboard_is_tracked_throughout(data_dir: Path, tmp_path: Path) -> None:
    found = report(
        tmp_path, data_dir / "replays" / "vamr_board", "--manifest", MANIFESTS / "vamr_board.toml"
    )
    assert found["camera_poses"]["measured"] == found["camera_poses"]["frames"] == 250
    assert found["integrity"]["doubts"] == []
    motor, measured = found["errors"]["motor"], found["errors"]["measured"]
    assert motor["ape_rmse_m"] <= 0.8e-3
    assert motor["rotation_rmse_deg"] <= 0.25
    assert motor["registration_rmse_px"] < 1.2 * measured["registration_rmse_px"]


@pytest.mark.parametrize("look_ahead", ["true", "false"])
def test_a_flight_is_held_through_a_blackout(
    look_ahead: str, data_dir: Path, tmp_path: Path
) -> None:
    found = report(
        tmp_path,
        data_dir / "replays" / "euroc_V1_01",
        "--manifest",
        MANIFESTS / "euroc_v1_01.toml",
        "--set",
        "camera_poses.blackouts_s=60,61",
        "--set",
        f"fused.look_ahead={look_ahead}",
    )
    assert found["imu"]["origin"] == "recorded"
    assert found["integrity"]["doubts"] == []
    measured, fused = found["errors"]["measured"], found["errors"]["fused"]
    for figure in ("ape_rmse_m", "rotation_rmse_deg"):
        assert fused[figure] < 0.5 * measured[figure]
    (blackout,) = found["unmeasured_spans"]
    assert blackout["fused_worst_m"] < 0.05
    assert found["convergence"]["judged_by"] == "truth"
    assert found["convergence"]["settled_s"] < 5.0


@pytest.mark.parametrize(("look_ahead", "left"), [("true", 0.55), ("false", 0.9)])
def test_a_flight_without_its_imu_is_smoothed_with_no_more_lag_than_it_may_have(
    look_ahead: str, left: float, data_dir: Path, tmp_path: Path
) -> None:
    found = report(
        tmp_path,
        data_dir / "replays" / "euroc_V1_01",
        "--manifest",
        MANIFESTS / "euroc_v1_01.toml",
        "--set",
        "fused.by=nothing",
        "--set",
        f"fused.look_ahead={look_ahead}",
    )
    lag = {} if look_ahead == "true" else {"lag_s": 0.0}
    assert found["smoothed"] == {"method": "auto"} | lag
    measured, smoothed = found["errors"]["measured"], found["errors"]["motor"]
    for figure in ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2"):
        assert smoothed[figure] < left * measured[figure]
