"""`fuse_by_graph`: what `motorcade.fusion.filter.fuse` does, by a factor graph instead."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.filter.fuse import by_stretch, camera_covariance, covered, wanted_stamps
from motorcade.fusion.graph.inertial import InertialGraph
from motorcade.fusion.graph.smoothers import smooth_all, smooth_with_lag
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray, checked_positive
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements


def fuse_by_graph(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    settings: FilterSettings | None = None,
    lag_s: float | None = None,
) -> Fused:
    """Fuse measured camera poses with an IMU by gtsam: all at once, or with a lag.

    Every stamp, measured or wanted, is a node of 15 unknowns with its own covariance: the graph is
    for frames, not for the IMU's own rate. Of `settings` it takes gravity and the gate: a
    measurement beyond it loses its weight smoothly, and where the result leaves it
    `outlier_threshold` gates away it counts as not accepted. `nis` is NaN: a graph has no
    innovations.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. Gaps are
            bridged linearly, which nothing accounts for; those of more than ten seconds split the
            stream, as for `fuse`.
        noise: the IMU's densities and bias walks.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: as for `fuse`.
        settings: as for `fuse`.
        lag_s: None: every estimate knows all the data. Otherwise it knows those up to so many
            seconds later, as a tracker that may wait; `state_covariance` then lacks what pose,
            velocity and biases have in common.

    Raises:
        ValueError: as `fuse`; settings that estimate more than the motion, or look for rest; a lag
            that is not above zero; gaps in the stream that leave the graph singular.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import fuse_by_graph
        >>> from motorcade.ga import Motor
        >>> fused = fuse_by_graph(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> fused.trajectory
        Trajectory(world_T_imu, 61 poses, 3.000 s)
    """
    chosen = settings or FilterSettings()
    if chosen.error_size != 15 or chosen.rest is not None:
        raise ValueError("settings: expected only motion and biases to estimate, got more")
    if lag_s is not None:
        checked_span_ns(checked_positive(lag_s, "lag_s", "seconds"), "lag_s")

    def one(given: PoseMeasurements, stream: ImuStream, stamps: IntArray | None) -> Fused:
        return _fused(given, stream, noise, imu_T_camera, stamps, chosen, lag_s)

    return by_stretch(one, measurements, imu, stamps_ns)


def _fused(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None,
    chosen: FilterSettings,
    lag_s: float | None,
) -> Fused:
    """Fuse along one stretch of the stream."""
    used = covered(measurements, imu)
    wanted = wanted_stamps(used.trajectory.time_ns, imu, stamps_ns)
    graph = InertialGraph.of(
        used, imu, noise, imu_T_camera, wanted, chosen.gravity_m_s2, chosen.gate_limit(6)
    )
    try:
        found = smooth_all(graph) if lag_s is None else smooth_with_lag(graph, lag_s)
    except RuntimeError as fault:
        if "Indeterminate" not in str(fault):
            raise
        raise ValueError(
            "measurements and imu: expected data that determine the path, got a graph that is "
            "singular in float64, as gaps of a second in the imu leave it; `fuse` bridges them"
        ) from fault
    rows = np.searchsorted(graph.time_ns, wanted)
    path, count = measurements.trajectory, len(wanted)
    poses = found.world_T_imu[rows] @ imu_T_camera
    spread = found.covariance[rows]
    fall = np.array([0.0, 0.0, -chosen.gravity_m_s2])
    return Fused(
        trajectory=Trajectory(wanted, poses, path.parent, path.child),
        velocity_m_s=found.velocity_m_s[rows],
        gyro_bias_rad_s=found.bias[rows, :3],
        accel_bias_m_s2=found.bias[rows, 3:],
        covariance=camera_covariance(spread, imu_T_camera),
        state_covariance=spread,
        nis=np.full(count, np.nan),
        accepted=graph.accepted(found.world_T_imu, chosen.outlier_threshold)[rows],
        gravity_m_s2=np.tile(fall, (count, 1)),
        imu_T_camera=Motor.stack([imu_T_camera] * count),
        time_offset_s=np.zeros(count),
    )
