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
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.settings import VELOCITY_SIGMA_M_S, FilterSettings
from motorcade.fusion.filter.sourced import Judgement, rows_within
from motorcade.fusion.graph.kinds import KindFactor, PosesByUnknowns, kind_factor
from motorcade.fusion.graph.shared import SharedUnknowns, keys, lean
from motorcade.fusion.imu.noise import (
    ACCEL_BIAS_SIGMA_M_S2,
    GYRO_BIAS_SIGMA_RAD_S,
    ImuNoise,
)
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import (
    MOST_NUMBERS,
    OFFSET,
    TILT,
    Measurements,
    PredictedState,
    skew,
    turn,
)
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
        gates: by how many numbers a measurement has, squared deviations from which on it loses
            weight; infinite: none does.
        kinds: other measurements, as factors.
        also: those measurements as they were given.
        shared: what else is estimated.
    """

    time_ns: IntArray
    imu: ImuStream
    noise: ImuNoise
    gravity_m_s2: float
    measured: IntArray
    world_T_imu: Motor
    covariance: FloatArray
    gates: list[float]
    kinds: list[KindFactor]
    also: tuple[Measurements, ...]
    shared: SharedUnknowns

    @classmethod
    def of(
        cls,
        measurements: PoseMeasurements,
        imu: ImuStream,
        noise: ImuNoise,
        imu_T_camera: Motor,
        stamps_ns: IntArray,
        settings: FilterSettings,
        also: Sequence[Measurements] = (),
        time_offset_s: float = 0.0,
        pose_effect: FloatArray | None = None,
    ) -> InertialGraph:
        """Nodes at all measured stamps and at `stamps_ns`; `pose_effect` is ``(M, 6, p)``."""
        shift_ns = round(time_offset_s * 1e9)
        seen = measurements.trajectory.time_ns + shift_ns
        within = [rows_within(one, int(seen[0]), int(imu.time_ns[-1])) for one in also]
        others = [
            stamps[rows]
            for kind, rows in zip(also, within, strict=True)
            for stamps in (kind.time_ns, kind.since_ns)
            if stamps is not None
        ]
        nodes = np.unique(np.concatenate([seen, stamps_ns, *others])).astype(np.int64)
        data = imu.around(nodes) if len(nodes) > 1 else imu
        rows = np.full(len(nodes), -1)
        rows[np.searchsorted(nodes, seen)] = np.arange(len(seen))
        adjoint = imu_T_camera.adjoint()
        shared = SharedUnknowns(imu_T_camera, time_offset_s, *settings.known_sigmas)
        at = data.angular_rate_rad_s[np.searchsorted(data.time_ns, nodes)]
        factors = [
            kind_factor(kind, number, row, nodes, at, shared)
            for number, (kind, rows) in enumerate(zip(also, within, strict=True))
            for row in rows.tolist()
        ]
        if shared.keys or pose_effect is not None:
            path, common = measurements.trajectory, np.zeros(0)
            if pose_effect is not None:
                common = np.zeros(pose_effect.shape[-1])
            poses = PosesByUnknowns(
                seen, path.motors, measurements.covariance, 1e-9 * shift_ns, pose_effect, common
            )
            factors += [kind_factor(poses, -1, row, nodes, at, shared) for row in range(len(seen))]
        return cls(
            nodes,
            data,
            noise,
            settings.gravity_m_s2,
            rows,
            measurements.trajectory.motors @ imu_T_camera.inverse(),
            adjoint @ measurements.covariance @ adjoint.T,
            [settings.gate_limit(n) for n in range(1, MOST_NUMBERS + 1)],
            factors,
            tuple(also),
            shared,
        )

    @cached_property
    def poses_as_kinds(self) -> bool:
        """Whether the measured poses are among the kinds: where more than the motion is found."""
        return any(one.number < 0 for one in self.kinds)

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
        """Means of force and rate over each step, its length, and the nodes' places.

        gtsam takes a force to be in the axes of where its step begins, and so errs by half a step's
        rotation: 2 rad/s at 200 Hz turn gravity by 0.05 m/s². Forces are therefore turned to those
        axes from the middle of the step.
        """
        imu = self.imu
        force = 0.5 * (imu.specific_force_m_s2[1:] + imu.specific_force_m_s2[:-1])
        rate = 0.5 * (imu.angular_rate_rad_s[1:] + imu.angular_rate_rad_s[:-1])
        steps = np.diff(imu.time_ns) * 1e-9
        places = np.searchsorted(imu.time_ns, self.time_ns)
        halfway = Rotor.from_rotation_vector(0.5 * steps[:, None] * rate)
        return halfway.apply(force), rate, steps, places

    def summed(
        self, index: int, bias: gtsam.imuBias.ConstantBias
    ) -> gtsam.PreintegratedCombinedMeasurements:
        """The samples from node `index - 1` to node `index`."""
        import gtsam

        every_force, every_rate, every_step, places = self._samples
        preintegrated = gtsam.PreintegratedCombinedMeasurements(self._params, bias)
        rows = slice(places[index - 1], places[index])
        force, rate, steps = every_force[rows], every_rate[rows], every_step[rows]
        # The bias's part of the turn to the beginning of a step, to first order.
        force = force + 0.5 * steps[:, None] * (force @ skew(bias.gyroscope()))
        for sample in zip(force, rate, steps.tolist(), strict=True):
            preintegrated.integrateMeasurement(*sample)
        return preintegrated

    def motion(
        self, index: int, summed: gtsam.PreintegratedCombinedMeasurements
    ) -> gtsam.CombinedImuFactor:
        """The factor of the samples that lead to node `index`."""
        import gtsam

        a, b = keys(index - 1), keys(index)
        return gtsam.CombinedImuFactor(
            a.pose, a.velocity, b.pose, b.velocity, a.bias, b.bias, summed
        )

    def seen(self, index: int) -> list[gtsam.NonlinearFactor]:
        """The factors of what was measured at a node."""
        import gtsam

        factors = [one.factor(self.gate(one.measurements)) for one in self._at_nodes.get(index, [])]
        row = int(self.measured[index])
        if row < 0 or self.poses_as_kinds:
            return factors
        model: Any = gtsam.noiseModel.Gaussian.Covariance(self.covariance[row])
        if np.isfinite(self.gates[-1]):
            loss = gtsam.noiseModel.mEstimator.DCS.Create(self.gates[5])
            model = gtsam.noiseModel.Robust.Create(loss, model)
        return [gtsam.PriorFactorPose3(keys(index).pose, self.poses[row], model), *factors]

    @cached_property
    def _at_nodes(self) -> dict[int, list[KindFactor]]:
        by_node: dict[int, list[KindFactor]] = {}
        for factor in self.kinds:
            by_node.setdefault(factor.index, []).append(factor)
        return by_node

    def gate(self, kind: Measurements) -> float:
        """The squared deviations from which on a kind's measurements lose weight."""
        size: int = kind.covariance.shape[-1]
        return self.gates[size - 1]

    def priors(self) -> list[gtsam.NonlinearFactor]:
        """What is believed beforehand of the first node's velocity and biases: hardly anything;
        and of what all nodes share.
        """
        import gtsam

        first = keys(0)
        speed = gtsam.noiseModel.Isotropic.Sigma(3, VELOCITY_SIGMA_M_S)
        sigmas = np.repeat([ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S], 3)
        biases = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
        return [
            gtsam.PriorFactorVector(first.velocity, np.zeros(3), speed),
            gtsam.PriorFactorConstantBias(first.bias, gtsam.imuBias.ConstantBias(), biases),
            *self.shared.priors(),
        ]

    def accepted(self, states: GraphStates, outlier_threshold: float) -> NDArray[np.bool_]:
        """Whether each node's pose, if one was measured, has a weight to speak of."""
        accepted = np.ones(len(self.time_ns), dtype=np.bool_)
        for factor in self.kinds:
            if factor.number < 0:
                accepted[factor.index] = states.squared(factor) <= outlier_threshold * self.gates[5]
        if self.poses_as_kinds:
            return accepted
        nodes = np.flatnonzero(self.measured >= 0)
        rows = self.measured[nodes]
        apart = states.world_T_imu[nodes].local(self.world_T_imu[rows])
        solved = np.linalg.solve(self.covariance[rows], apart[..., None])[..., 0]
        accepted[nodes] = np.sum(apart * solved, axis=-1) <= outlier_threshold * self.gates[5]
        return accepted

    def judgements(self, states: GraphStates, outlier_threshold: float) -> tuple[Judgement, ...]:
        """What became of the other kinds."""
        accepted = [np.zeros(len(one), dtype=np.bool_) for one in self.also]
        for factor in self.kinds:
            if factor.number >= 0:
                limit = outlier_threshold * self.gate(factor.measurements)
                accepted[factor.number][factor.row] = states.squared(factor) <= limit
        return tuple(
            Judgement(kind.name, kind.time_ns, np.full(len(kind), np.nan), seen)
            for kind, seen in zip(self.also, accepted, strict=True)
        )


@dataclass(frozen=True, eq=False)
class GraphStates:
    """States at N nodes, seen in the world that poses are measured in.

    Fields:
        world_T_imu, velocity_m_s: Motor ``(N,)``, ``(N, 3)``.
        bias: ``(N, 6)``, gyroscope first.
        covariance: ``(N, 15, 15)`` or ``(N, 24, 24)``, as of `motorcade.fusion.filter.Fused`.
        world_R_up: ``(3, 3)``; turns z to where up is.
        imu_T_camera, time_offset_s: of the camera.
    """

    world_T_imu: Motor
    velocity_m_s: FloatArray
    bias: FloatArray
    covariance: FloatArray
    world_R_up: FloatArray
    imu_T_camera: Motor
    time_offset_s: float

    @classmethod
    def of(
        cls,
        poses: Motor,
        velocity_m_s: FloatArray,
        bias: FloatArray,
        covariance: FloatArray,
        shared: SharedUnknowns,
        values: gtsam.Values,
    ) -> GraphStates:
        """Of gtsam's poses, velocities and covariances ``(N, n, n)``, pose, velocity, bias first.

        gtsam's velocity is in the world of nodes and its accelerometer's bias comes first.
        """
        tilt, own = shared.tilt(values), shared.keys
        whole = 24 if own else 15
        change = np.zeros((len(covariance), whole, covariance.shape[-1]))
        turned = poses.rotor.inverse().as_matrix()
        change[:, range(6), range(6)] = 1.0
        change[:, 6:9, 6:9] = turned
        change[:, range(9, 15), [12, 13, 14, 9, 10, 11]] = 1.0
        first = 15
        for name in own:
            if name == "tilt":
                leaning = lean(tilt)
                across = poses.inverse().adjoint()[..., :3] @ leaning
                change[:, :6, first : first + 2] = across
                speeds = np.cross(velocity_m_s[:, :, None], leaning[None], axis=1)
                change[:, 6:9, first : first + 2] = -turned @ speeds
                change[:, TILT, first : first + 2] = leaning[:2]
                first += 2
            elif name == "camera":
                change[:, range(17, 23), range(first, first + 6)] = 1.0
                first += 6
            else:
                change[:, OFFSET, first] = 1.0
        spread: FloatArray = change @ covariance @ change.swapaxes(-1, -2)
        world_R_up = turn(tilt)
        world_T_up = Motor.from_rotor_translation(Rotor.from_matrix(world_R_up), np.zeros(3))
        return cls(
            world_T_up @ poses,
            velocity_m_s @ world_R_up.T,
            bias,
            0.5 * (spread + spread.swapaxes(-1, -2)),
            world_R_up,
            shared.camera(values),
            shared.offset_s(values),
        )

    def squared(self, of: KindFactor) -> float:
        """The square of a measurement's normalised residual."""
        row = of.index
        before = row if of.earlier is None else of.earlier
        poses, bias = self.world_T_imu, self.bias[row]
        state = PredictedState(
            poses[row].rotor.as_matrix(),
            poses[row].translation_m,
            poses[before].rotor.as_matrix(),
            poses[before].translation_m,
            self.velocity_m_s[row],
            of.reading_rad_s - bias[:3],
            bias[:3],
            bias[3:],
            self.world_R_up,
            self.imu_T_camera.coefficients,
            self.time_offset_s,
        )
        residual = of.measurements.residual(of.row, state)
        return float(residual @ np.linalg.solve(of.measurements.covariance[of.row], residual))
