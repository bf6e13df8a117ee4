"""Measurements of every kind along a known path, with noise as their covariances say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.measurements import (
    Measurements,
    PositionMeasurements,
    RelativePoseMeasurements,
)
from motorcade.fusion.measurements.poses import BodyPoseMeasurements
from motorcade.fusion.measurements.positions import (
    AltitudeMeasurements,
    BodyVelocityMeasurements,
    HeadingMeasurements,
    MagneticFieldMeasurements,
    VelocityMeasurements,
)
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

ARM = np.array([0.3, -0.2, 0.5])
IMU_T_BODY = Motor.from_euler_translation(np.array([0.3, -0.5, 1.1]), np.array([0.2, 0.1, -0.3]))
IMU_R_BODY = IMU_T_BODY.rotor
FIELD = np.array([1.0, 21.0, -42.0])  # µT, about what it is in Zürich


@dataclass(frozen=True, eq=False)
class Along:
    """What is true at N stamps: ``world_T_imu``, velocity in the world, rate in the IMU's axes."""

    time_ns: IntArray
    poses: Motor
    velocity_m_s: FloatArray
    rate_rad_s: FloatArray

    def __getitem__(self, rows: slice) -> Along:
        return Along(
            self.time_ns[rows], self.poses[rows], self.velocity_m_s[rows], self.rate_rad_s[rows]
        )


def _noise(
    rng: np.random.Generator, count: int, sigma: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Correlated errors ``(N, m)`` and their covariance ``(m, m)``."""
    size = len(sigma)
    root = np.diag(sigma) @ (np.eye(size) + 0.2 * np.ones((size, size)))
    return rng.standard_normal((count, size)) @ root.T, root @ root.T


def _pose(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.repeat([0.01, 0.02], 3))
    return BodyPoseMeasurements(
        time_ns=path.time_ns,
        world_T_body=path.poses @ IMU_T_BODY @ Motor.from_twist(errors),
        covariance=own,
        imu_T_body=IMU_T_BODY,
    )


def _relative(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns) - 1, np.repeat([0.003, 0.005], 3))
    body = path.poses @ IMU_T_BODY
    return RelativePoseMeasurements(
        earlier_ns=path.time_ns[:-1],
        time_ns=path.time_ns[1:],
        earlier_T_body=body[:-1].inverse() @ body[1:] @ Motor.from_twist(errors),
        covariance=own,
        imu_T_body=IMU_T_BODY,
    )


def _position(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.full(3, 0.05))
    place = path.poses.apply(ARM) + errors
    return PositionMeasurements(time_ns=path.time_ns, position_m=place, covariance=own, arm_m=ARM)


def _altitude(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.array([0.03]))
    height = path.poses.apply(ARM)[:, 2] + errors[:, 0]
    return AltitudeMeasurements(time_ns=path.time_ns, altitude_m=height, covariance=own, arm_m=ARM)


def _of_arm(path: Along) -> FloatArray:
    """Velocity of the arm's end about the IMU, in the IMU's axes."""
    return np.cross(path.rate_rad_s, ARM)


def _velocity(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.full(3, 0.05))
    speed = path.velocity_m_s + path.poses.rotor.apply(_of_arm(path)) + errors
    return VelocityMeasurements(time_ns=path.time_ns, velocity_m_s=speed, covariance=own, arm_m=ARM)


def _body_velocity(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.array([0.05, 0.03, 0.03]))
    speed = path.poses.rotor.inverse().apply(path.velocity_m_s) + _of_arm(path)
    return BodyVelocityMeasurements(
        time_ns=path.time_ns,
        velocity_m_s=IMU_R_BODY.inverse().apply(speed) + errors,
        covariance=own,
        imu_R_body=IMU_R_BODY,
        arm_m=ARM,
    )


def _heading(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.array([0.02]))
    axis = np.array([0.8, 0.6, 0.0])
    x, y, _ = path.poses.rotor.apply(axis).T
    heading = np.arctan2(y, x) + errors[:, 0]
    return HeadingMeasurements(time_ns=path.time_ns, heading_rad=heading, covariance=own, axis=axis)


def _magnetic(path: Along, rng: np.random.Generator) -> Measurements:
    errors, own = _noise(rng, len(path.time_ns), np.full(3, 0.5))
    body: Rotor = path.poses.rotor @ IMU_R_BODY
    return MagneticFieldMeasurements(
        time_ns=path.time_ns,
        measured_field=body.inverse().apply(FIELD) + errors,
        world_field=FIELD,
        covariance=own,
        imu_R_sensor=IMU_R_BODY,
    )


_MAKERS = {
    "pose": _pose,
    "relative_pose": _relative,
    "position": _position,
    "altitude": _altitude,
    "velocity": _velocity,
    "body_velocity": _body_velocity,
    "heading": _heading,
    "magnetic_field": _magnetic,
}
KINDS = tuple(_MAKERS)


def measured_along(kind: str, path: Along, rng: np.random.Generator) -> Measurements:
    """Measurements of a kind at every stamp of a path."""
    return _MAKERS[kind](path, rng)
