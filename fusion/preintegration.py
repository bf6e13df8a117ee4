"""The sum of inertial samples over intervals, with how it depends on the biases and how sure it is.

Source: C. Forster, L. Carlone, F. Dellaert, D. Scaramuzza, On-manifold preintegration for real-time
visual-inertial odometry, IEEE TRO 33(1), 2017; here rotation, position and velocity move together,
as a pair of motors (see `motorcade.fusion.filter.extended_pose`), so that intervals join by
composition and the error's transition does not depend on any state.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.fusion.filter.extended_pose import corrected, increments
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.ga.names import check_word
from motorcade.ga.stamps import LONGEST_BRIDGE_S

__all__ = ["Preintegrated", "preintegrate"]

_MOST_TURN_RAD, _MOST_BIAS = 1e3, 1e9


@dataclass(frozen=True, eq=False)
class Preintegrated:
    """Relative motion over K intervals, gravity and first velocity left out. All `*` is ``(K,)``.

    The error stands on the right: rotation (rad), position (m) and velocity (m/s) in the frame at
    the interval's end, then the biases of gyroscope and accelerometer; ``true = motion @ Exp(·)``.

    Fields:
        duration_s: ``(*)`` length.
        motion: Motor ``(*, 2)``: rotation with the position gained, rotation with the velocity
            gained, both in the frame at the interval's start.
        gyro_bias_rad_s, accel_bias_m_s2: ``(*, 3)``, taken off the samples.
        transition: ``(*, 15, 15)``, what an error at the start has become at the end. Its last six
            columns are the Jacobian of the motion by the biases.
        covariance: ``(*, 15, 15)`` of the error at the end where there was none at the start.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ImuStream, preintegrate
        >>> from motorcade.ga import Motor
        >>> time_ns = 5_000_000 * np.arange(201)
        >>> rate = np.tile([0.0, 0.0, np.pi / 2], (201, 1))
        >>> imu = ImuStream(time_ns, rate, np.tile([0.0, 0.0, 9.81], (201, 1)))
        >>> summed = preintegrate(imu, time_ns[[0, 100, 200]], ADIS16448)

        >>> world_T_imu, still, fall = Motor.identity(), np.zeros(3), (0.0, 0.0, -9.81)
        >>> end, velocity = summed[0].propagate(world_T_imu, still, fall)
        >>> float(np.degrees(end.rotor.angle()).round(6)), bool(np.abs(velocity).max() < 1e-12)
        (45.0, True)
    """

    duration_s: FloatArray
    motion: Motor
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    transition: FloatArray
    covariance: FloatArray

    def __len__(self) -> int:
        return len(self.duration_s)

    def __getitem__(self, index: slice | IntArray | NDArray[np.bool_]) -> Preintegrated:
        """Some of the intervals, by slice, mask or indices."""
        return Preintegrated(*(getattr(self, field.name)[index] for field in fields(self)))

    @property
    def bias_jacobian(self) -> FloatArray:
        """``(*, 9, 6)``: right perturbation of the motion by gyroscope and accelerometer bias."""
        return self.transition[..., :9, 9:]

    def with_biases(self, gyro_bias_rad_s: ArrayLike, accel_bias_m_s2: ArrayLike) -> Motor:
        """The motion ``(*, 2)`` had other biases ``(*, 3)`` been taken off, to first order.

        Good for changes as estimators make them: over 0.5 s and for 0.01 rad/s and 0.1 m/s² it is
        off by about 3e-5 (rad, m, m/s); the error grows with the square of the change.
        """
        gyro = np.asarray(gyro_bias_rad_s) - self.gyro_bias_rad_s
        accel = np.asarray(accel_bias_m_s2) - self.accel_bias_m_s2
        change = np.concatenate([gyro, accel], axis=-1)
        return corrected(self.motion, np.einsum("...ij,...j->...i", self.bias_jacobian, change))

    def propagate(
        self, world_T_imu: Motor, velocity_m_s: FloatArray, gravity_m_s2: ArrayLike
    ) -> tuple[Motor, FloatArray]:
        """Poses ``(*)`` and velocities ``(*, 3)`` at the ends, from those at the starts.

        Args:
            world_T_imu: Motor ``(*)`` at the starts.
            velocity_m_s: ``(*, 3)`` there, in the world.
            gravity_m_s2: ``(3,)`` in the world; (0, 0, -9.81) where z is up.
        """
        fall = np.asarray(gravity_m_s2, dtype=np.float64)
        dt = self.duration_s[..., None]
        rotor = world_T_imu.rotor
        gained = self.motion.translation_m
        position = world_T_imu.translation_m + velocity_m_s * dt + 0.5 * fall * dt**2
        position = position + rotor.apply(gained[..., 0, :])
        velocity = velocity_m_s + fall * dt + rotor.apply(gained[..., 1, :])
        return Motor.from_rotor_translation(rotor @ self.motion[..., 0].rotor, position), velocity


def preintegrate(
    imu: ImuStream,
    keyframes_ns: IntArray,
    noise: ImuNoise,
    gyro_bias_rad_s: ArrayLike = (0.0, 0.0, 0.0),
    accel_bias_m_s2: ArrayLike = (0.0, 0.0, 0.0),
    *,
    rule: Literal["mean", "held"] = "mean",
) -> Preintegrated:
    """Sum up the samples between each keyframe and the next.

    Keyframes need not coincide with samples: the stream is interpolated linearly at them. Gaps of
    up to ten seconds are bridged linearly too, which the covariance knows nothing of.

    Args:
        imu: must cover the keyframes.
        keyframes_ns: ``(K + 1,)`` rising stamps, K at least 1.
        noise: white noise and bias walks.
        gyro_bias_rad_s: ``(3,)`` or ``(K, 3)``, taken off the samples.
        accel_bias_m_s2: likewise.
        rule: "mean" holds the mean of the two samples at its ends over each step and integrates the
            turning frame exactly; its error falls fourfold with a halved step. "held" is gtsam's
            rule, on a manifold: the sample at the start is held, and the frame is that at the start
            for the whole step; its error only halves.

    Raises:
        ValueError: keyframes that are fewer than two, do not rise, are no integers or lie outside
            the stream; samples more than ten seconds apart, or between which the sensor turns by
            more than a thousand radians; biases of another shape, NaN or infinity; an unknown rule.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ImuStream, preintegrate
        >>> time_ns = 5_000_000 * np.arange(201)
        >>> rate = np.tile([0.0, 0.0, np.pi / 2], (201, 1))
        >>> imu = ImuStream(time_ns, rate, np.tile([0.0, 0.0, 9.81], (201, 1)))
        >>> summed = preintegrate(imu, time_ns[[0, 100, 200]], ADIS16448)

        >>> summed.duration_s
        array([0.5, 0.5])
        >>> np.degrees(summed.motion[:, 0].rotor.angle()).round(6)
        array([45., 45.])
    """
    check_word(rule, ("mean", "held"), "rule")
    keys = _checked_keyframes(keyframes_ns, imu)
    count = len(keys) - 1
    gyro = _checked_bias(gyro_bias_rad_s, "gyro_bias_rad_s", count)
    accel = _checked_bias(accel_bias_m_s2, "accel_bias_m_s2", count)
    biases = np.concatenate([gyro, accel], axis=-1)
    data = imu.around(keys)
    first = np.searchsorted(data.time_ns, keys)
    rate, force = (
        values[:-1] if rule == "held" else 0.5 * (values[1:] + values[:-1])
        for values in (data.angular_rate_rad_s, data.specific_force_m_s2)
    )
    steps_s = np.diff(data.time_ns) * 1e-9
    of_steps = np.repeat(biases, np.diff(first), axis=0)
    _check_steps(steps_s, rate - of_steps[:, :3])
    motion, transition, covariance = increments(
        first[:-1], steps_s, rate, force, of_steps, noise, held=rule == "held"
    )
    return Preintegrated(
        np.diff(keys) * 1e-9, motion, biases[:, :3], biases[:, 3:], transition, covariance
    )


def _check_steps(steps_s: FloatArray, rate_rad_s: FloatArray) -> None:
    """Refuse steps that nothing tells of, and those of too many parts to be integrated."""
    longest_s = float(steps_s.max())
    if longest_s > LONGEST_BRIDGE_S:
        raise ValueError(
            f"imu: expected samples at most {LONGEST_BRIDGE_S:g} s apart between keyframes, got a "
            f"gap of {longest_s:.6g} s; sum up each side of it for itself"
        )
    turn_rad = float(np.max(np.linalg.norm(rate_rad_s, axis=-1) * steps_s))
    if not turn_rad <= _MOST_TURN_RAD:
        raise ValueError(
            f"imu: expected turns up to {_MOST_TURN_RAD:g} rad between samples, got {turn_rad:.6g}"
        )


def _checked_keyframes(keyframes_ns: IntArray, imu: ImuStream) -> IntArray:
    at_ns = np.asarray(keyframes_ns)
    if at_ns.dtype.kind != "i" or at_ns.ndim != 1 or at_ns.size < 2 or np.any(np.diff(at_ns) <= 0):
        raise ValueError(
            "keyframes_ns: expected two or more rising integer nanoseconds (K + 1,), got "
            f"dtype {at_ns.dtype}, shape {at_ns.shape}"
        )
    if at_ns[0] < imu.time_ns[0] or at_ns[-1] > imu.time_ns[-1]:
        raise ValueError(
            f"keyframes_ns: expected stamps in [{imu.time_ns[0]}, {imu.time_ns[-1]}], where there "
            f"are samples, got {at_ns[0]} to {at_ns[-1]}"
        )
    return at_ns.astype(np.int64)


def _checked_bias(value: ArrayLike, name: str, count: int) -> FloatArray:
    checked = checked_floats(value, name, (3,))
    if np.abs(checked).max(initial=0.0) > _MOST_BIAS:
        raise ValueError(f"{name}: expected biases up to {_MOST_BIAS:g}, got {value!r}")
    if checked.shape not in ((3,), (count, 3)):
        raise ValueError(f"{name}: expected shape (3,) or {(count, 3)}, got {checked.shape}")
    return np.broadcast_to(checked, (count, 3))
