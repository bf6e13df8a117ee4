"""Monocular SLAM and an IMU on a drawn room, handheld, 30 s, one second of it black.

The IMU is simulated along the true path with EuRoC's noise. The path by both is compared with the
truth after a rigid alignment: its scale is the IMU's alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np

from motorcade.fusion import fuse
from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.visual_inertial.sequence import metric_map
from motorcade.tracking.slam import VisualSlam
from tests.textured_room.inertial import IMU_T_CAMERA, simulated_imu
from tests.textured_room.scenarios import Scenario, scenario

__all__ = ["bench_visual_inertial", "visual_inertial_table"]


def bench_visual_inertial(drawn: Scenario | None = None) -> dict[str, Any]:
    """Draw, track, fuse and judge; by default the scenario with a gap of one second.

    Takes minutes, most of them for drawing and tracking.
    """
    try:
        return _measured(scenario("gap") if drawn is None else drawn)
    except ModuleNotFoundError as fault:
        return {"left_out": [f"drawn room: needs the Python package {fault.name}"]}


def _measured(room: Scenario) -> dict[str, Any]:
    truth, camera = room.truth(), room.sensor.camera
    slam, start = VisualSlam(camera), perf_counter()
    for time_ns, view in zip(truth.time_ns.tolist(), room.views(), strict=True):
        slam.track(time_ns, view.gray)
    result = slam.finish()
    tracked = perf_counter()
    sensor = simulated_imu(room), ADIS16448, IMU_T_CAMERA
    found, wanted = metric_map(result, camera, *sensor), np.asarray(result.time_ns)
    path = fuse(found.measurements, *sensor, wanted, fits_noise=False).trajectory
    rigid = evaluate(path, truth, align="se3")
    return {
        "frames": len(truth),
        "frames_posed": len(path),
        "states": dict(Counter(result.states)),
        "keyframes": len(found.keyframes.trajectory),
        "start_log_scale_sigma": found.start.log_scale_sigma,
        "scale_error": evaluate(path, truth, align="sim3").scale - 1.0,
        "ape_rmse_m": rigid.ape_m.rmse,
        "ape_max_m": rigid.ape_m.max,
        "rotation_rmse_deg": rigid.rotation_deg.rmse,
        "drawing_and_slam_s": tracked - start,
        "fusing_s": perf_counter() - tracked,
    }


def visual_inertial_table(found: Mapping[str, Any]) -> str:
    """One line of figures under their names."""
    if "left_out" in found:
        return "\n".join(f"left out: {reason}" for reason in found["left_out"])
    lost = found["states"].get("lost", 0)
    return (
        "drawn room, one camera and IMU\n"
        f"  {found['frames_posed']} of {found['frames']} frames posed, {lost} not seen; "
        f"APE {1e3 * found['ape_rmse_m']:.2f} mm (max {1e3 * found['ape_max_m']:.2f}), "
        f"{found['rotation_rmse_deg']:.3f} deg, scale {100 * found['scale_error']:+.2f} %"
    )
