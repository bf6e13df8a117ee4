"""One camera and an IMU in a drawn room, with a second of darkness."""

from __future__ import annotations

import pytest

from tests.bench.fusion.inertial_slam import bench_inertial_slam, inertial_slam_table
from tests.bench.fusion.visual_inertial import (
    bench_visual_inertial,
    visual_inertial_table,
)
from tests.textured_room.scenarios import scenario


@pytest.mark.slow
def test_the_path_is_metric_and_goes_on_through_black_frames():
    found = bench_visual_inertial(scenario("covered"))
    assert found["states"]["lost"] >= 25
    assert found["frames_posed"] >= found["frames"] - 10
    assert abs(found["scale_error"]) < 0.01
    assert found["ape_rmse_m"] < 0.01
    assert found["rotation_rmse_deg"] < 0.5
    assert "scale" in visual_inertial_table(found)


@pytest.mark.slow
def test_slam_with_an_imu_inside_has_metres_and_bridges_darkness_as_frames_come_in():
    [found] = bench_inertial_slam(("handheld",)).values()
    assert found["states"]["inertial"] >= 28
    assert found["states"].get("lost", 0) == 0
    assert abs(found["scale_error_after_10_s"]) < 0.005
    assert found["dark_max_m"] < 0.03
    assert found["final_ape_rmse_m"] < 1.2 * found["adjustment_ape_rmse_m"]
    assert "darkness" in inertial_slam_table({"handheld": found})
