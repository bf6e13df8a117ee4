"""SLAM with an IMU inside on drawn rooms, as frames come in: scale, darkness, blur, the whole path.

A hand moves a camera and an IMU with EuRoC's noise for 20 s; for one second nothing is seen. What
was given of each frame at the time is compared with the ground truth, and so is the path in the
end; beside it stands the adjustment of a finished run of visual SLAM by gtsam.

    python -m tests.bench.fusion.inertial_slam [handheld] [blurred] [loop] [--seeds 0 1 2]
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from motorcade.fusion import fuse
from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.visual_inertial import InertialSlam, InertialSlamResult
from motorcade.fusion.visual_inertial.online import InertialFrame
from motorcade.fusion.visual_inertial.sequence import metric_map
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.slam import VisualSlam
from tests.textured_room.inertial import IMU_T_CAMERA, simulated_imu
from tests.textured_room.scenarios import RATE_HZ, Scenario, scenario

__all__ = ["ROOMS", "bench_inertial_slam", "feed", "inertial_slam_table"]

ROOMS: Mapping[str, Scenario] = {
    "handheld": replace(scenario("gap"), frames=600, covered=(450, 480)),
    "blurred": replace(scenario("blurred"), frames=450, covered=(360, 390)),
    "loop": replace(scenario("loop"), darkened=(0, 0), covered=(400, 430)),
}
_SCALE_AFTER_S = 10.0
_ALIGNED_S = 3.0


def bench_inertial_slam(
    names: tuple[str, ...] = ("handheld",), seeds: tuple[int, ...] = (0,), *, beside: bool = True
) -> dict[str, Any]:
    """Draw, track and judge each room; minutes each, most of them for drawing.

    Args:
        names: of `ROOMS`.
        seeds: of textures and noise.
        beside: whether the adjustment of a finished run is made too.
    """
    try:
        return {
            f"{name} {seed}": _measured(replace(ROOMS[name], seed=seed), beside)
            for name in names
            for seed in seeds
        }
    except ModuleNotFoundError as fault:
        return {"left_out": [f"drawn rooms: needs the Python package {fault.name}"]}


def _measured(room: Scenario, beside: bool) -> dict[str, Any]:
    truth, camera, imu = room.truth(), room.sensor.camera, simulated_imu(room)
    slam, plain = InertialSlam(camera, ADIS16448, IMU_T_CAMERA), VisualSlam(camera)
    frames: list[InertialFrame] = []
    mapped_s, scale_error, fed = np.inf, float("nan"), 0
    for number, view in enumerate(room.views()):
        time_ns = int(truth.time_ns[number])
        fed = feed(slam, imu, fed, time_ns)
        frames.append(slam.track(time_ns, view.gray))
        if beside:
            plain.track(time_ns, view.gray)
        now_s = time_ns * 1e-9
        if frames[-1].visual.world_T_camera is not None:
            mapped_s = min(mapped_s, now_s)
        if np.isnan(scale_error) and now_s >= mapped_s + _SCALE_AFTER_S:
            scale_error = _scale_error(slam, truth)
    found = slam.finish()
    judged = _judged(room, truth, frames, found) | {"scale_error_after_10_s": scale_error}
    if beside:
        result, sensor = plain.finish(), (imu, ADIS16448, IMU_T_CAMERA)
        measured, wanted = metric_map(result, camera, *sensor).measurements, result.time_ns
        path = fuse(measured, *sensor, np.asarray(wanted), fits_noise=False).trajectory
        judged["adjustment_ape_rmse_m"] = evaluate(path, truth, align="se3").ape_m.rmse
    return judged


def feed(slam: InertialSlam, imu: ImuStream, fed: int, time_ns: int) -> int:
    """Hand over samples until they reach a stamp; returns how many were given so far."""
    reached = int(np.searchsorted(imu.time_ns, time_ns)) + 2
    rows = slice(fed, reached)
    slam.imu(
        ImuStream(imu.time_ns[rows], imu.angular_rate_rad_s[rows], imu.specific_force_m_s2[rows])
    )
    return reached


def _scale_error(slam: InertialSlam, truth: Trajectory) -> float:
    """Of the map as it is now, by its keyframes."""
    snapshot = slam.snapshot()
    keyframes = Trajectory(snapshot.time_ns, snapshot.world_T_camera)
    return float(evaluate(keyframes, truth, align="sim3").scale - 1.0)


def _judged(
    room: Scenario, truth: Trajectory, frames: list[InertialFrame], found: InertialSlamResult
) -> dict[str, Any]:
    given = [(f.time_ns, f.world_T_camera) for f in frames if f.world_T_camera is not None]
    states = dict(Counter(frame.state for frame in frames))
    if found.fused is None or found.start is None or not given:
        return {"frames": len(truth), "states": states}
    online = Trajectory(np.array([t for t, _ in given]), Motor.stack([pose for _, pose in given]))
    live, final = (evaluate(path, truth, align="se3") for path in (online, found.fused.trajectory))
    return {
        "frames": len(truth),
        "states": states,
        "metric_from_s": 1e-9 * (found.metric_from_ns or 0),
        "start_log_scale_sigma": found.start.log_scale_sigma,
        "online_ape_rmse_m": live.ape_m.rmse,
        "online_ape_max_m": live.ape_m.max,
        "dark_max_m": _in_darkness(room, truth, online),
        "final_ape_rmse_m": final.ape_m.rmse,
        "final_scale_error": evaluate(found.fused.trajectory, truth, align="sim3").scale - 1.0,
        "final_rotation_rmse_deg": final.rotation_deg.rmse,
    }


def _in_darkness(room: Scenario, truth: Trajectory, online: Trajectory) -> float:
    """Farthest from the ground truth while nothing is seen, aligned by the seconds before."""
    first_s, after_s = (number / RATE_HZ for number in room.covered)
    time_s = online.time_ns * 1e-9
    before = (time_s > first_s - _ALIGNED_S) & (time_s < first_s - 0.5 / RATE_HZ)
    dark = (time_s > first_s - 0.5 / RATE_HZ) & (time_s < after_s + 0.5 / RATE_HZ)
    if np.count_nonzero(before) < 10 or not dark.any():
        return float("nan")
    exact = truth[np.searchsorted(truth.time_ns, online.time_ns)].motors.translation_m
    given = online.motors.translation_m
    middle, there = given[before].mean(axis=0), exact[before].mean(axis=0)
    u, _, vt = np.linalg.svd((given[before] - middle).T @ (exact[before] - there))
    turn = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    off = np.linalg.norm((given - middle) @ turn + there - exact, axis=-1)
    return float(off[dark].max())


def inertial_slam_table(found: Mapping[str, Any]) -> str:
    """One line of figures a room."""
    if "left_out" in found:
        return "\n".join(f"left out: {reason}" for reason in found["left_out"])
    lines = ["drawn rooms, SLAM with an IMU inside"]
    for name, one in found.items():
        if "final_ape_rmse_m" not in one:
            lines.append(f"  {name:12} no metres; {one['states']}")
            continue
        beside = one.get("adjustment_ape_rmse_m", float("nan"))
        lines.append(
            f"  {name:12} metres after {one['metric_from_s']:.1f} s; scale after 10 s "
            f"{100 * one['scale_error_after_10_s']:+.2f} %, in the end "
            f"{100 * one['final_scale_error']:+.2f} %; darkness {1e3 * one['dark_max_m']:.1f} mm; "
            f"APE online {1e3 * one['online_ape_rmse_m']:.2f} (max "
            f"{1e3 * one['online_ape_max_m']:.1f}), final {1e3 * one['final_ape_rmse_m']:.2f}, "
            f"gtsam's adjustment {1e3 * beside:.2f} mm; {one['states']}"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rooms", nargs="*", default=["handheld"], choices=sorted(ROOMS))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--alone", action="store_true", help="without the adjustment beside it")
    options = parser.parse_args()
    print(
        inertial_slam_table(
            bench_inertial_slam(
                tuple(options.rooms), tuple(options.seeds), beside=not options.alone
            )
        )
    )
