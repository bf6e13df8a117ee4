"""Kinds that measure poses of a body that carries the IMU, steps of it, and corners in pixels."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.measurements.interface import (
    ERROR_NUMBERS,
    EXTRINSICS,
    GYRO_BIAS,
    OFFSET,
    ROTATION,
    VELOCITY,
    Measurements,
    PredictedState,
    by_error,
    set_checked,
    skew,
    spread,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.stamps import checked_stamps
from motorcade.tracking.cameras.camera import Camera, by_twist


def _checked_poses(poses: Motor, name: str, count: int, body: Motor) -> None:
    if poses.shape != (count,):
        raise ValueError(f"{name}: expected {(count,)} motors, got {poses.shape}")
    if body.shape != ():
        raise ValueError(f"imu_T_body: expected one motor, got {body.shape}")


@dataclass(frozen=True, eq=False, kw_only=True)
class BodyPoseMeasurements(Measurements):
    """Poses of a body fixed to the IMU, as of motion capture or of a second tracker.

    Args:
        time_ns: ``(N,)`` of the IMU's clock.
        world_T_body: Motor ``(N,)``.
        covariance: ``(6, 6)`` or ``(N, 6, 6)`` of the right perturbation, in the body's axes,
            rotation (rad) first.
        imu_T_body: where the body's frame is on the IMU.

    Raises:
        ValueError: shapes that do not agree.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements.poses import BodyPoseMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.ga import Motor
        >>> imu_T_body = Motor.from_translation([0.1, 0.0, 0.0])
        >>> seen = BodyPoseMeasurements(
        ...     time_ns=np.array([0]), world_T_body=Motor.identity((1,)), covariance=np.eye(6),
        ...     imu_T_body=imu_T_body,
        ... )
        >>> seen.residual(0, PredictedState.at(imu_T_body.inverse(), np.zeros(3))) + 0.0
        array([0., 0., 0., 0., 0., 0.])
    """

    name: ClassVar[str] = "pose"
    time_ns: IntArray
    world_T_body: Motor
    covariance: FloatArray
    imu_T_body: Motor = field(default_factory=Motor.identity)

    def __post_init__(self) -> None:
        count = set_checked(self, 6)
        _checked_poses(self.world_T_body, "world_T_body", count, self.imu_T_body)

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """The twist ``(6,)`` from the predicted pose to the measured one."""
        return (state.world_T_imu @ self.imu_T_body).local(self.world_T_body[row])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, 30)`` of that."""
        back = Motor.left_jacobian_inverse(self.residual(row, state))
        return by_error(6, pose=-back @ self.imu_T_body.inverse().adjoint())


@dataclass(frozen=True, eq=False, kw_only=True)
class RelativePoseMeasurements(Measurements):
    """How a body moved from earlier moments to later ones: odometry, or a scan matched to another.

    The filter keeps one earlier pose beside the state, with its covariance (stochastic cloning), so
    that nothing is approximated; steps must not overlap there: each starts where the last one
    ended, or later, or with it. The factor graph takes any.

    Args:
        earlier_ns, time_ns: ``(N,)`` of the IMU's clock, between which each step was measured.
        earlier_T_body: Motor ``(N,)``: the later pose of the body in its earlier frame.
        covariance: ``(6, 6)`` or ``(N, 6, 6)`` of the right perturbation, in the body's axes at
            the later moment, rotation (rad) first; steps err independently.
        imu_T_body: where the body's frame is on the IMU.

    Raises:
        ValueError: shapes that do not agree.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import RelativePoseMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.ga import Motor
        >>> step = Motor.from_translation([[0.0, 0.3, 0.0]])
        >>> moved = RelativePoseMeasurements(
        ...     earlier_ns=np.array([0]), time_ns=np.array([100]), earlier_T_body=step,
        ...     covariance=1e-4 * np.eye(6),
        ... )
        >>> state = PredictedState.at(Motor.identity(), np.zeros(3))  # which did not move
        >>> moved.residual(0, state) + 0.0
        array([0. , 0. , 0. , 0. , 0.3, 0. ])
    """

    name: ClassVar[str] = "relative_pose"
    earlier_ns: IntArray
    time_ns: IntArray
    earlier_T_body: Motor
    covariance: FloatArray
    imu_T_body: Motor = field(default_factory=Motor.identity)

    def __post_init__(self) -> None:
        count, earlier = set_checked(self, 6), checked_stamps(self.earlier_ns, "earlier_ns")
        if earlier.shape != (count,):
            raise ValueError(f"earlier_ns: expected shape {(count,)}, got {earlier.shape}")
        _checked_poses(self.earlier_T_body, "earlier_T_body", count, self.imu_T_body)
        object.__setattr__(self, "earlier_ns", earlier)

    @classmethod
    def along(
        cls, odometry: Trajectory, covariance: ArrayLike, imu_T_body: Motor | None = None
    ) -> RelativePoseMeasurements:
        """The steps of an odometry's path; its own frame and origin do not matter.

        Args:
            odometry: N + 1 poses of the body, in any world.
            covariance: ``(6, 6)`` or ``(N, 6, 6)`` of a step.
            imu_T_body: where the body's frame is on the IMU; by default its own.
        """
        path, stamps = odometry.motors, odometry.time_ns
        return cls(
            earlier_ns=stamps[:-1],
            time_ns=stamps[1:],
            earlier_T_body=path[:-1].inverse() @ path[1:],
            covariance=spread(covariance, "covariance", len(stamps) - 1, 6),
            imu_T_body=Motor.identity() if imu_T_body is None else imu_T_body,
        )

    @property
    def since_ns(self) -> IntArray:
        """The earlier moments."""
        return self.earlier_ns

    def _predicted(self, state: PredictedState) -> Motor:
        earlier = state.earlier_world_T_imu @ self.imu_T_body
        return earlier.inverse() @ state.world_T_imu @ self.imu_T_body

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """The twist ``(6,)`` from the predicted step to the measured one."""
        return self._predicted(state).local(self.earlier_T_body[row])

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(6, 30)`` of that."""
        step, body = self._predicted(state), self.imu_T_body.inverse()
        back = Motor.left_jacobian_inverse(step.local(self.earlier_T_body[row]))
        earlier = back @ (step.inverse() @ body).adjoint()
        return by_error(6, pose=-back @ body.adjoint(), earlier_pose=earlier)


_MOST = 4  # points of a row: eight numbers
_STEP = 1e-6  # of differences by the intrinsics, relative where they are large


@dataclass(frozen=True, eq=False, kw_only=True)
class CornerMeasurements(Measurements):
    """Known points in images, as of a calibration board, by a camera that may be known roughly.

    `calibrate_by_graph` finds the intrinsics where they have deviations; elsewhere they are known.
    Points must lie before the camera: the state must be good enough for that.

    Args:
        time_ns: ``(N,)`` of the IMU's clock; an image with many points takes several rows.
        pixels: ``(N, k, 2)``, k from 1 to 4 in every row.
        points_m: ``(N, k, 3)`` in the world.
        camera: its intrinsics, a first guess where they have deviations.
        sigma_px: deviation of a pixel, an axis.
        shift_s: what was added to the camera's stamps to make `time_ns`.
        pinhole_sigma_px: deviation of each of fx, fy, cx, cy.
        distortion_sigma: deviation of each coefficient of distortion.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity, deviations out of their range.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements.poses import CornerMeasurements
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.ga import Motor
        >>> from motorcade.tracking import Camera
        >>> seen = CornerMeasurements(
        ...     time_ns=np.array([0]), pixels=np.array([[[320.0, 242.0]]]),
        ...     points_m=np.array([[[0.0, 0.0, 2.0]]]), sigma_px=0.5,
        ...     camera=Camera(640, 480, 500.0, 500.0, 319.5, 239.5),
        ... )
        >>> seen.residual(0, PredictedState.at(Motor.identity(), np.zeros(3)))
        array([0.5, 2.5])
    """

    name: ClassVar[str] = "corners"
    time_ns: IntArray
    pixels: FloatArray
    points_m: FloatArray
    camera: Camera
    sigma_px: float
    shift_s: float = 0.0
    pinhole_sigma_px: float = 0.0
    distortion_sigma: float = 0.0
    covariance: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        count = self.pixels.shape[1] if np.ndim(self.pixels) == 3 else 0
        if not 1 <= count <= _MOST:
            raise ValueError(
                f"pixels: expected (N, k, 2) with k from 1 to {_MOST}, got {np.shape(self.pixels)}"
            )
        checked_positive(self.sigma_px, "sigma_px")
        for name in ("pinhole_sigma_px", "distortion_sigma"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name}: expected a number from 0 on, got {getattr(self, name)}")
        of_row = self.sigma_px**2 * np.eye(2 * count)  # of independent pixels
        rows = set_checked(self, 0, pixels=(count, 2), points_m=(count, 3))
        every = np.broadcast_to(of_row, (rows, 2 * count, 2 * count))
        object.__setattr__(self, "covariance", every)

    @property
    def parameters(self) -> FloatArray:
        """fx, fy, cx, cy and the coefficients of distortion."""
        own = self.camera
        return np.array([own.fx, own.fy, own.cx, own.cy, *own.distortion])

    @property
    def parameter_sigma(self) -> FloatArray:
        """Their deviations; none where they are known."""
        if self.pinhole_sigma_px == self.distortion_sigma == 0.0:
            return np.zeros(0)
        count = len(self.camera.distortion)
        return np.append(np.full(4, self.pinhole_sigma_px), np.full(count, self.distortion_sigma))

    def with_parameters(self, parameters: FloatArray) -> CornerMeasurements:
        """The same images by a camera of other intrinsics."""
        return replace(self, camera=with_intrinsics(self.camera, parameters))

    def _going(self, state: PredictedState) -> FloatArray:
        own = state.velocity_m_s @ state.world_R_imu
        return np.concatenate([state.angular_rate_rad_s, own])

    def _ahead(self, state: PredictedState) -> Motor:
        return Motor.from_twist((state.time_offset_s - self.shift_s) * self._going(state))

    def _in_camera(self, row: int, state: PredictedState) -> FloatArray:
        pose = state.world_T_imu @ self._ahead(state) @ Motor(state.imu_T_camera)
        return pose.inverse().apply(self.points_m[row])

    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted pixels ``(2k,)``, x and y in turn."""
        seen = self.camera.project(self._in_camera(row, state))
        apart: FloatArray = (self.pixels[row] - seen).ravel()
        return apart

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(2k, 30)`` of that, to first order in the time offset's change."""
        points = self._in_camera(row, state)
        by_camera = -by_twist(points, self.camera.project_jacobian(points)[1]).reshape(-1, 6)
        late_s, going = state.time_offset_s - self.shift_s, self._going(state)
        by_pose = by_camera @ Motor(state.imu_T_camera).inverse().adjoint()
        jacobian = np.zeros((len(by_camera), ERROR_NUMBERS))
        jacobian[:, :6] = by_pose @ self._ahead(state).inverse().adjoint()
        jacobian[:, ROTATION] += late_s * by_pose[:, 3:] @ skew(going[3:])
        jacobian[:, VELOCITY] = late_s * by_pose[:, 3:]
        jacobian[:, GYRO_BIAS] = -late_s * by_pose[:, :3]
        jacobian[:, EXTRINSICS] = by_camera
        jacobian[:, OFFSET] = by_pose @ going
        return jacobian

    def parameter_jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(2k, 4 + n)`` by the intrinsics, by central differences."""
        points, own = self._in_camera(row, state), self.parameters
        columns = []
        for k, value in enumerate(own):
            step = _STEP * max(1.0, abs(value))
            ahead, behind = (
                with_intrinsics(self.camera, own + side * step * (np.arange(len(own)) == k))
                for side in (1.0, -1.0)
            )
            moved = (behind.project(points) - ahead.project(points)) / (2.0 * step)
            columns.append(moved.ravel())
        return np.stack(columns, axis=-1)


def with_intrinsics(camera: Camera, parameters: FloatArray) -> Camera:
    """A camera with other fx, fy, cx, cy and coefficients."""
    fx, fy, cx, cy, *distortion = parameters.tolist()
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(distortion))
