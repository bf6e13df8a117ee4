"""`preintegrate`: inertial samples summed up between keyframes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.filter.increments import increments
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration.preintegrated import Preintegrated
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats

__all__ = ["preintegrate"]


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

    Keyframes need not coincide with samples: the stream is interpolated linearly at them. Gaps in
    the stream are bridged linearly too, which the covariance knows nothing of.

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
            the stream; biases of another shape, NaN or infinity; an unknown rule.

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
    if rule not in ("mean", "held"):
        raise ValueError(f"rule: expected 'mean' or 'held', got {rule!r}")
    keys = _checked_keyframes(keyframes_ns, imu)
    count = len(keys) - 1
    biases = np.concatenate(
        [
            np.broadcast_to(_checked_bias(value, name, count), (count, 3))
            for value, name in (
                (gyro_bias_rad_s, "gyro_bias_rad_s"),
                (accel_bias_m_s2, "accel_bias_m_s2"),
            )
        ],
        axis=-1,
    )
    data = imu.around(keys)
    first = np.searchsorted(data.time_ns, keys)
    rate, force = (
        values[:-1] if rule == "held" else 0.5 * (values[1:] + values[:-1])
        for values in (data.angular_rate_rad_s, data.specific_force_m_s2)
    )
    motion, transition, covariance = increments(
        first[:-1],
        np.diff(data.time_ns) * 1e-9,
        rate,
        force,
        np.repeat(biases, np.diff(first), axis=0),
        noise,
        held=rule == "held",
    )
    return Preintegrated(
        np.diff(keys) * 1e-9, motion, biases[:, :3], biases[:, 3:], transition, covariance
    )


def _checked_keyframes(keyframes_ns: IntArray, imu: ImuStream) -> IntArray:
    given = np.asarray(keyframes_ns)
    if given.dtype.kind != "i" or given.ndim != 1 or given.size < 2 or np.any(np.diff(given) <= 0):
        raise ValueError(
            "keyframes_ns: expected two or more rising integer nanoseconds (K + 1,), got "
            f"dtype {given.dtype}, shape {given.shape}"
        )
    if given[0] < imu.time_ns[0] or given[-1] > imu.time_ns[-1]:
        raise ValueError(
            f"keyframes_ns: expected stamps in [{imu.time_ns[0]}, {imu.time_ns[-1]}], where there "
            f"are samples, got {given[0]} to {given[-1]}"
        )
    return given.astype(np.int64)


def _checked_bias(value: ArrayLike, name: str, count: int) -> FloatArray:
    checked = checked_floats(value, name, (3,))
    if checked.shape not in ((3,), (count, 3)):
        raise ValueError(f"{name}: expected shape (3,) or {(count, 3)}, got {checked.shape}")
    return checked
