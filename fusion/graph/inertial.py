"""The graph of a camera that carries an IMU: factors between nodes, and on them.

A node is a pose ``x`` of the IMU, its velocity ``v`` in the world and its biases ``b``. Between
neighbours stands gtsam's CombinedImuFactor: preintegrated samples with walking biases (Forster et
al., IEEE TRO 2017; L. Carlone et al., Eliminating conditionally independent sets, ICRA 2014). On
measured nodes stands the pose, with the loss of dynamic covariance scaling: least squares within
the gate, next to no pull from far outside (P. Agarwal et al., Robust map optimization using dynamic
covariance scaling, ICRA 2013).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.settings import (
    ACCEL_BIAS_SIGMA_M_S2,
    GYRO_BIAS_SIGMA_RAD_S,
    VELOCITY_SIGMA_M_S,
)
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements

if TYPE_CHECKING:
    import gtsam


def as_pose(motor: Motor) -> gtsam.Pose3:
    """One motor as a Pose3."""
    import gtsam

    return gtsam.Pose3(motor.as_matrix())


def as_poses(motors: Motor) -> list[gtsam.Pose3]:
    """Motor ``(N,)`` as a list of Pose3."""
    import gtsam

    return [gtsam.Pose3(matrix) for matrix in motors.as_matrix()]


def optimised(
    factors: gtsam.NonlinearFactorGraph, start: gtsam.Values, iterations: int, relative: float
) -> gtsam.Values:
    """The most probable values, by Levenberg and Marquardt, until the error falls no more."""
    import gtsam

    params = gtsam.LevenbergMarquardtParams()
    params.setMaxIterations(iterations)
    params.setRelativeErrorTol(relative)
    return gtsam.LevenbergMarquardtOptimizer(factors, start, params).optimize()


def as_motor(poses: Sequence[gtsam.Pose3]) -> Motor:
    """Motor ``(N,)`` of N poses."""
    turns: FloatArray = np.array([pose.rotation().matrix() for pose in poses])
    places = np.array([pose.translation() for pose in poses])
    return Motor.from_rotor_translation(Rotor.from_matrix(turns), places)


# An interval of a single sample has no position noise of its own, and would be singular.
_POSITION_DENSITY = 1e-7


@dataclass(frozen=True)
class NodeKeys:
    """gtsam's keys of a node."""

    pose: int
    velocity: int
    bias: int


def keys(index: int) -> NodeKeys:
    """Keys of the node of that number."""
    import gtsam

    return NodeKeys(*(gtsam.symbol(letter, index) for letter in "xvb"))


@dataclass(frozen=True, eq=False)
class InertialGraph:
    """All that the graph is made of; nodes at N stamps.

    Fields:
        time_ns: ``(N,)`` of the nodes, the first of them measured.
        imu: the samples at the nodes' stamps and their own between them.
        noise: densities and walks.
        gravity_m_s2: its size, along -z of the world.
        measured: ``(N,)`` row of the measurement at each node, -1 where there is none.
        world_T_imu: Motor ``(M,)``, as measured.
        covariance: ``(M, 6, 6)`` of it, right perturbation.
        gate: squared deviations from which on measurements lose weight; infinite: none does.
    """

    time_ns: IntArray
    imu: ImuStream
    noise: ImuNoise
    gravity_m_s2: float
    measured: IntArray
    world_T_imu: Motor
    covariance: FloatArray
    gate: float

    @classmethod
    def of(
        cls,
        measurements: PoseMeasurements,
        imu: ImuStream,
        noise: ImuNoise,
        imu_T_camera: Motor,
        stamps_ns: IntArray,
        gravity_m_s2: float,
        gate: float,
    ) -> InertialGraph:
        """Nodes at all measured stamps and at `stamps_ns`."""
        seen = measurements.trajectory.time_ns
        nodes = np.union1d(seen, stamps_ns).astype(np.int64)
        data = imu.around(nodes) if len(nodes) > 1 else imu
        rows = np.full(len(nodes), -1)
        rows[np.searchsorted(nodes, seen)] = np.arange(len(seen))
        adjoint = imu_T_camera.adjoint()
        return cls(
            nodes,
            data,
            noise,
            gravity_m_s2,
            rows,
            measurements.trajectory.motors @ imu_T_camera.inverse(),
            adjoint @ measurements.covariance @ adjoint.T,
            gate,
        )

    @cached_property
    def poses(self) -> list[gtsam.Pose3]:
        """The measurements as gtsam has them."""
        return as_poses(self.world_T_imu)

    @cached_property
    def _params(self) -> gtsam.PreintegrationCombinedParams:
        import gtsam

        params = gtsam.PreintegrationCombinedParams.MakeSharedU(self.gravity_m_s2)
        noise, identity = self.noise, np.eye(3)
        params.setGyroscopeCovariance(noise.gyro_density_rad_s_rthz**2 * identity)
        params.setAccelerometerCovariance(noise.accel_density_m_s2_rthz**2 * identity)
        params.setBiasOmegaCovariance(noise.gyro_walk_rad_s2_rthz**2 * identity)
        params.setBiasAccCovariance(noise.accel_walk_m_s3_rthz**2 * identity)
        params.setIntegrationCovariance(_POSITION_DENSITY**2 * identity)
        return params

    @cached_property
    def _samples(self) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
        """Means of force and rate over each step, its length, and the nodes' places."""
        force, rate = self.imu.specific_force_m_s2, self.imu.angular_rate_rad_s
        steps = np.diff(self.imu.time_ns) * 1e-9
        places = np.searchsorted(self.imu.time_ns, self.time_ns)
        return 0.5 * (force[1:] + force[:-1]), 0.5 * (rate[1:] + rate[:-1]), steps, places

    def summed(
        self, index: int, bias: gtsam.imuBias.ConstantBias
    ) -> gtsam.PreintegratedCombinedMeasurements:
        """The samples from node `index - 1` to node `index`."""
        import gtsam

        force, rate, steps, places = self._samples
        made = gtsam.PreintegratedCombinedMeasurements(self._params, bias)
        for k in range(places[index - 1], places[index]):
            made.integrateMeasurement(force[k], rate[k], steps[k])
        return made

    def motion(
        self, index: int, summed: gtsam.PreintegratedCombinedMeasurements
    ) -> gtsam.CombinedImuFactor:
        """The factor of the samples that lead to node `index`."""
        import gtsam

        a, b = keys(index - 1), keys(index)
        return gtsam.CombinedImuFactor(
            a.pose, a.velocity, b.pose, b.velocity, a.bias, b.bias, summed
        )

    def seen(self, index: int) -> gtsam.PriorFactorPose3 | None:
        """The factor of the pose measured at a node, if there is one."""
        import gtsam

        row = int(self.measured[index])
        if row < 0:
            return None
        plain = gtsam.noiseModel.Gaussian.Covariance(self.covariance[row])
        if not np.isfinite(self.gate):
            return gtsam.PriorFactorPose3(keys(index).pose, self.poses[row], plain)
        loss = gtsam.noiseModel.mEstimator.DCS.Create(self.gate)
        robust = gtsam.noiseModel.Robust.Create(loss, plain)
        return gtsam.PriorFactorPose3(keys(index).pose, self.poses[row], robust)

    def priors(self) -> list[gtsam.NonlinearFactor]:
        """What is believed of velocity and biases at the first node: hardly anything."""
        import gtsam

        first = keys(0)
        speed = gtsam.noiseModel.Isotropic.Sigma(3, VELOCITY_SIGMA_M_S)
        sigmas = np.repeat([ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S], 3)
        biases = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
        return [
            gtsam.PriorFactorVector(first.velocity, np.zeros(3), speed),
            gtsam.PriorFactorConstantBias(first.bias, gtsam.imuBias.ConstantBias(), biases),
        ]

    def accepted(self, poses: Motor, outlier_threshold: float) -> NDArray[np.bool_]:
        """Whether each node's measurement, if any, has a weight to speak of."""
        accepted = np.ones(len(self.time_ns), dtype=np.bool_)
        nodes = np.flatnonzero(self.measured >= 0)
        rows = self.measured[nodes]
        apart = poses[nodes].local(self.world_T_imu[rows])
        solved = np.linalg.solve(self.covariance[rows], apart[..., None])[..., 0]
        accepted[nodes] = np.sum(apart * solved, axis=-1) <= outlier_threshold * self.gate
        return accepted


def state_covariance(covariance: FloatArray, world_T_imu: Motor) -> FloatArray:
    """Covariances ``(N, 15, 15)`` of pose, velocity and biases by gtsam, as `Fused` has them.

    gtsam's velocity is in the world and its accelerometer's bias comes first.
    """
    change = np.zeros((len(covariance), 15, 15))
    change[:, range(6), range(6)] = 1.0
    change[:, 6:9, 6:9] = world_T_imu.rotor.inverse().as_matrix()
    change[:, range(9, 15), [12, 13, 14, 9, 10, 11]] = 1.0
    spread: FloatArray = change @ covariance @ change.swapaxes(-1, -2)
    return 0.5 * (spread + spread.swapaxes(-1, -2))
