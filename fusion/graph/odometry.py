"""Poses that drift little but jump, joined with odometry that is smooth but drifts.

A pose graph: a node at every stamp of either, the odometry's step between neighbours, measured
poses on their nodes with the loss of dynamic covariance scaling (P. Agarwal et al., ICRA 2013), all
at once by gtsam. The odometry's own frame and origin do not matter, only its steps.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.graph.inertial import as_motor, as_poses, optimised
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.tracking.measurements import PoseMeasurements

if TYPE_CHECKING:
    import gtsam

_GATE = 27.86  # χ² with six degrees of freedom exceeds it once in 10,000 poses
_ITERATIONS = 100
_RELATIVE = 1e-5
_MOST = 50  # poses that the start looks at


@dataclass(frozen=True)
class OdometryNoise:
    """How steps of odometry err, the same on every axis; independent from step to step.

    Fields:
        rotation_rad_rts: deviation of the rotation that a second adds, rad/√s.
        translation_m_rts: of the position, m/√s.

    Raises:
        ValueError: a number that is not above zero.

    Examples:
        >>> from motorcade.fusion.graph.odometry import OdometryNoise
        >>> OdometryNoise(translation_m_rts=0.0)
        Traceback (most recent call last):
        ...
        ValueError: OdometryNoise.translation_m_rts: expected a number above 0, got 0.0
    """

    rotation_rad_rts: float = 4e-3
    translation_m_rts: float = 4e-3

    def __post_init__(self) -> None:
        for field in fields(self):
            checked_positive(getattr(self, field.name), f"OdometryNoise.{field.name}")


def fuse_odometry(
    measurements: PoseMeasurements,
    odometry: Trajectory,
    odometry_T_camera: Motor,
    noise: OdometryNoise | None = None,
) -> PoseMeasurements:
    """Poses at every stamp of the odometry and of the measurements within its span.

    Args:
        measurements: ``world_T_camera`` with covariances.
        odometry: poses of what it tracks, in any world.
        odometry_T_camera: pose of the camera on what the odometry tracks.
        noise: of the odometry; by default that of a good visual-inertial one.

    Returns:
        ``world_T_camera`` and its covariance by all the data.

    Raises:
        ValueError: no measurement within the odometry's span.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import evaluate, fuse_odometry
        >>> from motorcade.ga import Motor
        >>> joined = fuse_odometry(measured, sensor.path, odometry_T_camera=Motor.identity())
        >>> for found in (measured.trajectory, joined.trajectory):
        ...     print(f"{1e3 * evaluate(found, sensor.path).ape_m.rmse:.0f} mm")
        17 mm
        2 mm
    """
    import gtsam

    seen = measurements.trajectory.time_ns
    inside = (seen >= odometry.time_ns[0]) & (seen <= odometry.time_ns[-1])
    if not np.any(inside):
        raise ValueError(
            "measurements and odometry: expected spans that overlap, got "
            f"{seen[0]} to {seen[-1]} ns and {odometry.time_ns[0]} to {odometry.time_ns[-1]} ns"
        )
    seen, covariance = seen[inside], measurements.covariance[inside]
    measured = measurements.trajectory.motors[inside]
    stamps = np.union1d(odometry.time_ns, seen).astype(np.int64)
    path = odometry.motors_at(stamps) @ odometry_T_camera
    nodes = np.searchsorted(stamps, seen)
    factors = gtsam.NonlinearFactorGraph()
    _add_steps(factors, path, np.diff(stamps) * 1e-9, noise or OdometryNoise())
    for node, pose, spread in zip(nodes.tolist(), as_poses(measured), covariance, strict=True):
        loss = gtsam.noiseModel.mEstimator.DCS.Create(_GATE)
        robust = gtsam.noiseModel.Robust.Create(loss, gtsam.noiseModel.Gaussian.Covariance(spread))
        factors.push_back(gtsam.PriorFactorPose3(node, pose, robust))
    values = optimised(factors, _start(path, nodes, measured), _ITERATIONS, _RELATIVE)
    marginals = gtsam.Marginals(factors, values)
    count = len(stamps)
    spreads: FloatArray = np.array([marginals.marginalCovariance(k) for k in range(count)])
    poses = as_motor([values.atPose3(k) for k in range(count)])
    names = measurements.trajectory.parent, measurements.trajectory.child
    return PoseMeasurements(
        Trajectory(stamps, poses, *names), 0.5 * (spreads + spreads.swapaxes(-1, -2))
    )


def _add_steps(
    factors: gtsam.NonlinearFactorGraph, path: Motor, dt_s: FloatArray, noise: OdometryNoise
) -> None:
    """What the odometry says of each node and the next."""
    import gtsam

    steps = as_poses(path[:-1].inverse() @ path[1:])
    densities = np.repeat([noise.rotation_rad_rts, noise.translation_m_rts], 3)
    for k, (step, dt) in enumerate(zip(steps, dt_s.tolist(), strict=True)):
        model = gtsam.noiseModel.Diagonal.Sigmas(densities * np.sqrt(dt))
        factors.push_back(gtsam.BetweenFactorPose3(k, k + 1, step, model))


def _start(path: Motor, nodes: IntArray, measured: Motor) -> gtsam.Values:
    """The odometry's path as a whole, moved to where most measured poses have it."""
    import gtsam

    some = np.linspace(0, len(nodes) - 1, min(len(nodes), _MOST)).astype(np.int64)
    world_T_odometry = measured[some] @ path[nodes[some]].inverse()
    # The one that is nearest to the others where the path is: no mean, so wrong poses do not pull.
    places = world_T_odometry[:, None].apply(path[nodes[some]].translation_m[None])
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1).mean(axis=-1)
    best = int(np.argmin(np.median(apart, axis=-1)))
    values = gtsam.Values()
    for k, pose in enumerate(as_poses(world_T_odometry[best] @ path)):
        values.insert(k, pose)
    return values
