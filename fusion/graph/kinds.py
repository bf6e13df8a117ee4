"""Measurements as factors: what a kind says of a node, and of what all nodes share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from motorcade.fusion.graph.shared import SharedUnknowns, keys, lean, lean_velocity, leans
from motorcade.fusion.measurements.interface import (
    ACCEL_BIAS,
    EARLIER,
    ERROR_NUMBERS,
    EXTRINSICS,
    GYRO_BIAS,
    OFFSET,
    ROTATION,
    TILT,
    VELOCITY,
    Measurements,
    PredictedState,
    skew,
    turn,
)
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    import gtsam


@dataclass(frozen=True, eq=False)
class PosesByUnknowns(Measurements):
    """The camera's poses where more than the motion is estimated.

    Fields:
        time_ns: as stamped, and `shift_s` later.
        world_T_camera, covariance: as measured.
        shift_s: ``(N,)`` what was added to the camera's stamps.
        effect: ``(N, 6, p)`` how numbers that all poses share move each, as a right perturbation.
        common: ``(p,)`` those numbers, of unit normal distribution.
    """

    name: ClassVar[str] = "camera_pose"
    time_ns: IntArray
    world_T_camera: Motor
    covariance: FloatArray
    shift_s: float
    effect: FloatArray | None = None
    common: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def parameters(self) -> FloatArray:
        """What all poses share."""
        return self.common

    @property
    def parameter_sigma(self) -> FloatArray:
        """Of unit normal distribution."""
        return np.ones(len(self.common))

    def with_parameters(self, parameters: FloatArray) -> PosesByUnknowns:
        """The poses as these numbers move them."""
        return replace(self, common=parameters)

    def parameter_jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, p)`` of the residual by what the poses share."""
        assert self.effect is not None
        right: FloatArray = Motor.left_jacobian_inverse(-self._residual(row, state)[0])
        moved: FloatArray = right @ self.effect[row]
        return moved

    def _going(self, state: PredictedState) -> FloatArray:
        """How the pose goes on, as a twist a second in the IMU's axes."""
        own = state.velocity_m_s @ state.world_R_imu
        return np.concatenate([state.angular_rate_rad_s, own])

    @cached_property
    def _poses(self) -> list[gtsam.Pose3]:
        import gtsam

        poses = self.world_T_camera
        if self.effect is not None:
            poses = poses.retract(self.effect @ self.common)
        return [gtsam.Pose3(matrix) for matrix in poses.as_matrix()]

    def _residual(
        self, row: int, state: PredictedState
    ) -> tuple[FloatArray, gtsam.Pose3, gtsam.Pose3]:
        """The residual, what the pose does until the stamp, and the camera on the IMU: by gtsam,
        which is quicker than arrays where there is one of each.
        """
        import gtsam

        ahead = gtsam.Pose3.Expmap((state.time_offset_s - self.shift_s) * self._going(state))
        pose = gtsam.Pose3(gtsam.Rot3(state.world_R_imu), state.position_m)
        camera = _pose(state.imu_T_camera.tobytes())
        seen = pose.compose(ahead).compose(camera)
        residual: FloatArray = seen.localCoordinates(self._poses[row])
        return residual, ahead, camera

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """The twist ``(6,)`` from the predicted pose to the measured one."""
        return self._residual(row, state)[0]

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, 30)`` of that, to first order in the time offset's change."""
        late_s = state.time_offset_s - self.shift_s
        residual, ahead, camera = self._residual(row, state)
        back = Motor.left_jacobian_inverse(residual)
        seen = -back @ camera.inverse().AdjointMap()
        going = self._going(state)
        jacobian = np.zeros((6, ERROR_NUMBERS))
        jacobian[:, :6] = seen @ ahead.inverse().AdjointMap()
        jacobian[:, ROTATION] += late_s * seen[:, 3:] @ skew(going[3:])
        jacobian[:, VELOCITY] = late_s * seen[:, 3:]
        jacobian[:, GYRO_BIAS] = -late_s * seen[:, :3]
        jacobian[:, EXTRINSICS] = -back
        jacobian[:, OFFSET] = seen @ going
        return jacobian


@dataclass(frozen=True, eq=False)
class KindFactor:
    """A row of a kind of measurements, on its node and on what is shared.

    Fields:
        measurements, number, row: the kind, its number (-1: the camera's poses), and which row.
        index, earlier: the node at its stamp, and at the moment that it refers to, if it does.
        reading_rad_s: ``(3,)`` of the gyroscope there.
        calibrated: whether the sensor's own parameters are unknowns too.
    """

    measurements: Measurements
    number: int
    row: int
    index: int
    earlier: int | None
    reading_rad_s: FloatArray
    shared: SharedUnknowns
    calibrated: bool = False

    def state(self, values: gtsam.Values) -> PredictedState:
        """The state that gtsam's values hold for the node."""
        node = keys(self.index)
        pose, speed = values.atPose3(node.pose), values.atVector(node.velocity)
        before = self._before(values) or pose
        bias = values.atConstantBias(node.bias)
        world_R_up = turn(self.shared.tilt(values))
        return PredictedState(
            world_R_up @ pose.rotation().matrix(),
            world_R_up @ pose.translation(),
            world_R_up @ before.rotation().matrix(),
            world_R_up @ before.translation(),
            world_R_up @ speed,
            self.reading_rad_s - bias.gyroscope(),
            bias.gyroscope(),
            bias.accelerometer(),
            world_R_up,
            self.shared.camera(values).coefficients,
            self.shared.offset_s(values),
        )

    def factor(self, gate: float) -> gtsam.NonlinearFactor:
        """For gtsam, with the loss of dynamic covariance scaling where the gate is finite."""
        import gtsam

        model: Any = gtsam.noiseModel.Gaussian.Covariance(self.measurements.covariance[self.row])
        if np.isfinite(gate):
            loss = gtsam.noiseModel.mEstimator.DCS.Create(gate)
            model = gtsam.noiseModel.Robust.Create(loss, model)
        node = keys(self.index)
        names = [node.pose, node.velocity, node.bias]
        if self.earlier is not None:
            names.append(keys(self.earlier).pose)
        names += self.shared.keys.values()
        if self.calibrated:
            names.append(parameter_key(self.number))

        def error(_: Any, values: gtsam.Values, jacobians: list[FloatArray] | None) -> FloatArray:
            state = self.state(values)
            if jacobians is not None:
                for k, block in enumerate(self.blocks(values, state)):
                    jacobians[k] = np.asfortranarray(block)
            return self.kind(values).residual(self.row, state)

        return gtsam.CustomFactor(model, names, error)

    def blocks(self, values: gtsam.Values, state: PredictedState) -> list[FloatArray]:
        """The residual's derivatives by gtsam's own errors, variable by variable."""
        kind, node = self.kind(values), keys(self.index)
        whole = kind.jacobian(self.row, state)
        pose = values.atPose3(node.pose)
        own = pose.rotation().matrix()
        blocks = [
            whole[:, :6],
            whole[:, VELOCITY] @ own.T,
            np.hstack([whole[:, ACCEL_BIAS], whole[:, GYRO_BIAS]]),
        ]
        before = self._before(values)
        if before is not None:
            blocks.append(whole[:, EARLIER])
        for name in self.shared.keys:
            if name == "camera":
                blocks.append(whole[:, EXTRINSICS])
            elif name == "offset":
                blocks.append(whole[:, OFFSET : OFFSET + 1])
            else:
                leaning = lean(self.shared.tilt(values))
                part = whole[:, :6] @ leans(pose, leaning)
                part += whole[:, VELOCITY] @ lean_velocity(
                    pose, values.atVector(node.velocity), leaning
                )
                part += whole[:, TILT] @ leaning[:2]
                if before is not None:
                    part += whole[:, EARLIER] @ leans(before, leaning)
                blocks.append(part)
        if self.calibrated:
            blocks.append(kind.parameter_jacobian(self.row, state))
        return blocks

    def kind(self, values: gtsam.Values) -> Measurements:
        """The measurements, by a sensor as gtsam's values have it."""
        if not self.calibrated:
            return self.measurements
        return _calibrated(self.measurements, values.atVector(parameter_key(self.number)).tobytes())

    def _before(self, values: gtsam.Values) -> gtsam.Pose3 | None:
        return None if self.earlier is None else values.atPose3(keys(self.earlier).pose)


@lru_cache(maxsize=8)
def _pose(coefficients: bytes) -> gtsam.Pose3:
    """Every row asks for the same, many times a step."""
    import gtsam

    return gtsam.Pose3(Motor(np.frombuffer(coefficients)).as_matrix())


@lru_cache(maxsize=8)
def _calibrated(kind: Measurements, parameters: bytes) -> Measurements:
    """Every row of a kind asks for the same."""
    return kind.with_parameters(np.frombuffer(parameters))


def parameter_key(number: int) -> int:
    """Gtsam's key of the parameters of a kind; -1: of the camera's poses."""
    import gtsam

    return int(gtsam.symbol("q", 0) if number < 0 else gtsam.symbol("p", number))


def kind_factor(
    kind: Measurements,
    number: int,
    row: int,
    nodes: IntArray,
    readings_rad_s: FloatArray,
    shared: SharedUnknowns,
) -> KindFactor:
    """The factor of a row, where nodes have these stamps and the gyroscope read that there."""
    index, since = int(np.searchsorted(nodes, kind.time_ns[row])), kind.since_ns
    earlier = None if since is None else int(np.searchsorted(nodes, since[row]))
    return KindFactor(kind, number, row, index, earlier, readings_rad_s[index], shared)
