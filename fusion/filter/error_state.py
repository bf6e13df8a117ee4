"""Camera poses fused with an IMU: an invariant error-state Kalman filter, forwards.

State: pose `world_T_imu`, velocity in the world, biases of gyroscope and accelerometer. The error
of pose and velocity stands on the left (world axes) and is retracted by the exponential of SE₂(3),
so that its dynamics do not depend on the estimate and a start that is degrees wrong converges.
A camera pose is compared in the camera's own axes, where its covariance lives. The world's z is up.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motorcade.fusion.filter.extended_pose import ExtendedPose, skew
from motorcade.fusion.filter.propagate import ERROR_SIZE, Samples, Step, propagate
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import FloatArray, IntArray, Motor, Rotor
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["Estimate", "FilterSettings", "Node", "filter_forwards", "start_estimate"]

_POSE = (0, 1, 2, 6, 7, 8)
_CONSECUTIVE_REJECTIONS = 5
_GYRO_BIAS_SIGMA_RAD_S = 0.1
_ACCEL_BIAS_SIGMA_M_S2 = 0.3
_VELOCITY_SIGMA_M_S = 2.0


@dataclass(frozen=True)
class FilterSettings:
    """What the filter assumes beyond its data.

    Fields:
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        gate: probability that a good measurement passes the χ² test (1 switches it off).
        initial_tilt_error_rad: turn the first orientation by this much about the world's x, and
            start with that uncertainty, to watch the filter converge.
    """

    gravity_m_s2: float = 9.81
    gate: float = 0.9999
    initial_tilt_error_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class Estimate:
    """State and covariance (15, 15) of its error (φ, ν, ρ, δb_g, δb_a)."""

    motion: ExtendedPose
    gyro_bias: FloatArray
    accel_bias: FloatArray
    covariance: FloatArray

    def corrected(self, xi: FloatArray, covariance: FloatArray) -> Estimate:
        """The estimate moved by an error (15,), with a new covariance."""
        return Estimate(
            self.motion.moved(xi[:9]),
            self.gyro_bias + xi[9:12],
            self.accel_bias + xi[12:15],
            covariance,
        )


@dataclass(frozen=True, eq=False)
class Node:
    """One stamp of the filter: how it was reached, what was predicted, what is known after it.

    `nis` is the normalised innovation squared (6 degrees of freedom), None without a measurement.
    """

    time_ns: int
    transition: FloatArray
    predicted: Estimate
    updated: Estimate
    nis: float | None
    accepted: bool


def filter_forwards(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray,
    settings: FilterSettings,
) -> list[Node]:
    """Run over `stamps_ns` (rising, starting at the first measurement; measured or not)."""
    gravity = np.array([0.0, 0.0, -settings.gravity_m_s2])
    measured = {int(t): i for i, t in enumerate(measurements.trajectory.time_ns)}
    poses = measurements.trajectory.poses
    limit = _gate_limit(settings.gate)
    estimate = start_estimate(measurements, imu_T_camera, settings)
    nodes = [Node(int(stamps_ns[0]), np.eye(ERROR_SIZE), estimate, estimate, None, True)]
    rejected = 0
    for time_ns, samples in _steps(imu, stamps_ns):
        step = propagate(
            estimate.motion, estimate.gyro_bias, estimate.accel_bias, samples, noise, gravity
        )
        predicted = _after(estimate, step)
        index = measured.get(time_ns)
        if index is None:
            estimate = predicted
            nodes.append(Node(time_ns, step.transition, predicted, estimate, None, True))
            continue
        camera_noise = measurements.covariance[index]
        innovation, jacobian = _innovation(predicted, poses[index], imu_T_camera)
        spread = jacobian @ predicted.covariance @ jacobian.T + camera_noise
        nis = float(innovation @ np.linalg.solve(spread, innovation))
        rejected = 0 if nis <= limit else rejected + 1
        accepted = rejected == 0
        if rejected > _CONSECUTIVE_REJECTIONS:
            # So many in a row are no outliers: the prediction has drifted. Believe the camera.
            predicted = replace(predicted, covariance=predicted.covariance * max(1.0, nis / 6.0))
            rejected, accepted = 0, True
        estimate = _update(predicted, innovation, jacobian, camera_noise) if accepted else predicted
        nodes.append(Node(time_ns, step.transition, predicted, estimate, nis, accepted))
    return nodes


def start_estimate(
    measurements: PoseMeasurements, imu_T_camera: Motor, settings: FilterSettings
) -> Estimate:
    """The first measurement as a state: at rest, biases zero, with room for both to be wrong."""
    world_T_imu = measurements.trajectory.poses[0] @ imu_T_camera.inverse()
    tilt = settings.initial_tilt_error_rad
    wrong = Rotor.from_rotation_vector([tilt, 0.0, 0.0])
    motion = ExtendedPose(
        (wrong @ world_T_imu.rotor).as_matrix(), np.zeros(3), world_T_imu.translation_m
    )
    adjoint = _adjoint((world_T_imu @ imu_T_camera).as_matrix())
    # A turn about the IMU itself: errors stand on the left, so the position turns with it.
    about_itself = np.vstack([np.eye(3), skew(motion.p)])[:, :2]
    pose = adjoint @ measurements.covariance[0] @ adjoint.T
    pose += tilt**2 * about_itself @ about_itself.T
    covariance = np.zeros((ERROR_SIZE, ERROR_SIZE))
    covariance[np.ix_(_POSE, _POSE)] = pose
    for place, sigma in (
        (3, _VELOCITY_SIGMA_M_S), (9, _GYRO_BIAS_SIGMA_RAD_S), (12, _ACCEL_BIAS_SIGMA_M_S2)
    ):  # fmt: skip
        covariance[place : place + 3, place : place + 3] = sigma**2 * np.eye(3)
    return Estimate(motion, np.zeros(3), np.zeros(3), covariance)


def _after(estimate: Estimate, step: Step) -> Estimate:
    spread = step.transition @ estimate.covariance @ step.transition.T + step.noise
    return Estimate(step.predicted, estimate.gyro_bias, estimate.accel_bias, _symmetric(spread))


def _innovation(
    predicted: Estimate, measured: Motor, imu_T_camera: Motor
) -> tuple[FloatArray, FloatArray]:
    """Twist (6,) from the predicted camera to the measured one, and its Jacobian (6, 15)."""
    motion = predicted.motion
    rotor = Rotor.from_matrix(motion.R)
    world_T_camera = Motor.from_rotor_translation(rotor, motion.p) @ imu_T_camera
    R, t = world_T_camera.rotor.as_matrix(), world_T_camera.translation_m
    jacobian = np.zeros((6, ERROR_SIZE))
    jacobian[0:3, 0:3] = jacobian[3:6, 6:9] = R.T
    jacobian[3:6, 0:3] = -R.T @ skew(t)
    return (world_T_camera.inverse() @ measured).as_twist(), jacobian


def _update(
    predicted: Estimate, innovation: FloatArray, jacobian: FloatArray, camera_noise: FloatArray
) -> Estimate:
    """Kalman's update, with the covariance in Joseph's form."""
    spread = jacobian @ predicted.covariance @ jacobian.T + camera_noise
    gain = np.linalg.solve(spread, jacobian @ predicted.covariance).T
    rest = np.eye(ERROR_SIZE) - gain @ jacobian
    covariance = rest @ predicted.covariance @ rest.T + gain @ camera_noise @ gain.T
    return predicted.corrected(gain @ innovation, _symmetric(covariance))


def _steps(imu: ImuStream, stamps_ns: IntArray) -> Iterator[tuple[int, Samples]]:
    """The inertial data between consecutive stamps; samples at the stamps are interpolated."""
    inside = (imu.time_ns > stamps_ns[0]) & (imu.time_ns < stamps_ns[-1])
    nodes = np.union1d(imu.time_ns[inside], stamps_ns)
    data = imu.at(nodes)
    interval_s = np.diff(nodes) * 1e-9
    rate = 0.5 * (data.angular_rate_rad_s[1:] + data.angular_rate_rad_s[:-1])
    force = 0.5 * (data.specific_force_m_s2[1:] + data.specific_force_m_s2[:-1])
    ends = np.searchsorted(nodes, stamps_ns)
    for first, last in pairwise(ends):
        part = slice(int(first), int(last))
        yield int(nodes[last]), Samples(interval_s[part], rate[part], force[part])


def _adjoint(pose: FloatArray) -> FloatArray:
    """Adjoint (6, 6) of a pose (4, 4) on twists, rotation first."""
    R, t = pose[:3, :3], pose[:3, 3]
    adjoint = np.zeros((6, 6))
    adjoint[:3, :3] = adjoint[3:, 3:] = R
    adjoint[3:, :3] = skew(t) @ R
    return adjoint


def _symmetric(matrix: FloatArray) -> FloatArray:
    return 0.5 * (matrix + matrix.T)


def _gate_limit(gate: float) -> float:
    """Largest normalised innovation squared that passes, χ² with 6 degrees of freedom."""
    from scipy.stats import chi2

    return float(chi2.ppf(gate, 6))
