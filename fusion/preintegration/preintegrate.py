"""`preintegrate`: inertial samples summed up between keyframes.

Single steps are worked out all at once, then neighbours are joined two by two, four by four, … in
every interval at the same time: intervals are a group's elements, so the order of joining is free.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration.preintegrated import Preintegrated, joined
from motorcade.fusion.preintegration.steps import single_steps
from motorcade.ga import FloatArray, IntArray, Motor, checked_floats

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

    Keyframes need not coincide with samples: the stream is interpolated linearly at them. Holes in
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
    """
    if rule not in ("mean", "held"):
        raise ValueError(f"rule: expected 'mean' or 'held', got {rule!r}")
    keys = _checked_keyframes(keyframes_ns, imu)
    count = len(keys) - 1
    biases = [
        np.broadcast_to(_checked_bias(value, name, count), (count, 3))
        for value, name in (
            (gyro_bias_rad_s, "gyro_bias_rad_s"), (accel_bias_m_s2, "accel_bias_m_s2"),
        )
    ]  # fmt: skip
    own = imu.time_ns[(imu.time_ns > keys[0]) & (imu.time_ns < keys[-1])]
    stamps = np.union1d(keys, own).astype(np.int64)
    interval = np.searchsorted(keys, stamps[:-1], side="right") - 1
    steps = single_steps(
        imu.at(stamps), noise, biases[0][interval], biases[1][interval], held=rule == "held"
    )
    return _reduced(steps, interval)


def _reduced(steps: Preintegrated, interval: IntArray) -> Preintegrated:
    """Steps ``(M,)`` joined within each interval, whose numbers ``(M,)`` never fall."""
    while len(interval) > interval[-1] + 1:
        start = np.searchsorted(interval, interval)
        even = (np.arange(len(interval)) - start) % 2 == 0
        paired = even & np.append(interval[1:] == interval[:-1], False)
        first = np.flatnonzero(paired)
        pairs = joined(steps[first], steps[first + 1])
        kept = np.flatnonzero(even)
        steps, interval = _replaced(steps[kept], paired[kept], pairs), interval[kept]
    return steps


def _replaced(steps: Preintegrated, which: NDArray[np.bool_], by: Preintegrated) -> Preintegrated:
    """The steps with those of a mask replaced."""
    arrays = []
    for name in ("duration_s", "motion", "transition", "covariance"):
        old, new = getattr(steps, name), getattr(by, name)
        if isinstance(old, Motor):
            old, new = old.coefficients, new.coefficients
        array = np.array(old)
        array[which] = new
        arrays.append(array)
    duration, motion, transition, covariance = arrays
    biases = steps.gyro_bias_rad_s, steps.accel_bias_m_s2
    return Preintegrated(duration, Motor(motion), *biases, transition, covariance)


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
