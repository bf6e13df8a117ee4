"""Time a sample takes, on one core, and an hour of samples through the filter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import median
from time import process_time
from typing import Any

import numpy as np

from motorcade.fusion.filter import PoseFilter, fuse
from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions import gimbal_crossing
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.timing import on_one_core

__all__ = ["bench_speed", "recorded_hour", "speed_table", "symmetry_and_least_eigenvalue"]

_HOUR_S = 3600.0
_STREAMED = 20_000
_ROUNDS = 3


def bench_speed() -> dict[str, Any]:
    """An hour at 200 Hz in batch, twenty thousand samples one by one, and gtsam's preintegration.

    Seconds are the processor's, medians of three.
    """
    imu, poses = _recorded(_HOUR_S)
    rare = PoseMeasurements(poses.trajectory[::20], poses.covariance[::20])
    wanted = rare.trajectory.time_ns
    with on_one_core():
        batch = {
            "20 Hz": _seconds(lambda: _fused(imu, poses, wanted, smoothed=False)),
            "20 Hz, backwards too": _seconds(lambda: _fused(imu, poses, wanted, smoothed=True)),
            "1 Hz": _seconds(lambda: _fused(imu, rare, wanted, smoothed=False)),
        }
        samples, both = (
            median(_streamed(imu, poses, every) for _ in range(_ROUNDS)) / _STREAMED
            for every in (0, 10)
        )
        rival = _gtsam(imu)
    skew, least = symmetry_and_least_eigenvalue(recorded_hour())
    return {
        "samples": len(imu),
        "batch_samples_per_s": {name: len(imu) / seconds for name, seconds in batch.items()},
        "streaming_us": 1e6 * samples,
        "streaming_with_poses_us": 1e6 * both,
        "gtsam_preintegration_us": rival,
        "covariance_asymmetry": skew,
        "covariance_least_eigenvalue": least,
    }


def _recorded(duration_s: float) -> tuple[ImuStream, PoseMeasurements]:
    rng = np.random.default_rng(0)
    path = ContinuousPath.along(gimbal_crossing(), duration_s)
    made = simulate_imu(path, 200.0, ADIS16448, rng)
    return made.stream, simulate_camera_poses(made.path, 20.0, 0.01, np.deg2rad(0.5), rng)


def _fused(imu: ImuStream, poses: PoseMeasurements, wanted: Any, smoothed: bool) -> FloatArray:
    return fuse(poses, imu, ADIS16448, Motor.identity(), wanted, smoothed=smoothed).state_covariance


def recorded_hour() -> FloatArray:
    """Covariances of the state, one a second, of the hour filtered with poses at 20 Hz."""
    imu, poses = _recorded(_HOUR_S)
    return _fused(imu, poses, poses.trajectory.time_ns[::20], smoothed=False)


def _streamed(imu: ImuStream, poses: PoseMeasurements, every: int) -> float:
    """Seconds for samples one by one, and a pose after each `every`; 0: only one, at the start."""
    live = PoseFilter(ADIS16448)
    stamps = imu.time_ns[:_STREAMED].tolist()
    rates, forces = _rows(imu)
    measured = list(poses.trajectory.motors[: _STREAMED // 10])
    covariance = poses.covariance[0]
    start = process_time()
    for k, stamp in enumerate(stamps):
        live.imu(stamp, rates[k], forces[k])
        if k == 0 or (every and k % every == 0):
            live.pose(stamp, measured[k // 10], covariance)
    return process_time() - start


def _rows(imu: ImuStream) -> tuple[list[FloatArray], list[FloatArray]]:
    """Rates and forces of the samples that are fed one by one."""
    return list(imu.angular_rate_rad_s[:_STREAMED]), list(imu.specific_force_m_s2[:_STREAMED])


def _gtsam(imu: ImuStream) -> float | None:
    """Microseconds a sample of gtsam's preintegration alone; None where it is not installed."""
    try:
        import gtsam
    except ModuleNotFoundError:
        return None
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)
    rates, forces = _rows(imu)

    def summed() -> None:
        total = gtsam.PreintegratedCombinedMeasurements(params, gtsam.imuBias.ConstantBias())
        for rate, force in zip(rates, forces, strict=True):
            total.integrateMeasurement(force, rate, 0.005)

    return 1e6 * _seconds(summed) / _STREAMED


def _seconds(call: Callable[[], object]) -> float:
    spent = []
    for _ in range(_ROUNDS):
        start = process_time()
        call()
        spent.append(process_time() - start)
    return median(spent)


def symmetry_and_least_eigenvalue(covariances: FloatArray) -> tuple[float, float]:
    """Largest asymmetry and least eigenvalue of covariances ``(N, d, d)`` as correlations."""
    sigma = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    correlation = covariances / (sigma[:, :, None] * sigma[:, None])
    skew = np.max(np.abs(correlation - correlation.swapaxes(1, 2)))
    return float(skew), float(np.linalg.eigvalsh(correlation)[:, 0].min())


def speed_table(found: Mapping[str, Any]) -> str:
    """A line a figure."""
    lines = [f"{'speed on one core':<48}"]
    for name, rate in found["batch_samples_per_s"].items():
        told = f"batch of {found['samples']:,} samples, poses at {name}"
        lines.append(f"{told:<54}{rate:>12,.0f} samples/s")
    singles = {
        "one sample from Python": found["streaming_us"],
        "one sample from Python, its tenth of a pose too": found["streaming_with_poses_us"],
        "one sample of gtsam, preintegration alone": found["gtsam_preintegration_us"],
    }
    lines += [f"{name:<54}{us:>12.2f} µs" for name, us in singles.items() if us is not None]
    lines.append(
        f"{'covariance over the hour: asymmetry, least eigenvalue':<54}"
        f"{found['covariance_asymmetry']:>12.1g}{found['covariance_least_eigenvalue']:>10.1g}"
        "   (as correlations)"
    )
    return "\n".join(lines)
