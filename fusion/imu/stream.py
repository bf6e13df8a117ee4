"""Inertial data: angular rate and specific force of one sensor, stamped in integer nanoseconds.

Both are in the sensor's own axes. Specific force is what an accelerometer reads: at rest it points
up with the size of gravity (+g), in free fall it is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.ga.stamps import LONGEST_BRIDGE_S, checked_increasing, segments

_REACH = 1e9

MOST_CORRECTION = 0.5
"""Of an entry of a correction from the identity's: a sensor that is so far off is another one."""


@dataclass(frozen=True, eq=False)
class ImuStream:
    """Samples of a gyroscope and an accelerometer at strictly increasing stamps.

    Args:
        time_ns: ``(N,)`` integer nanoseconds, N at least 2.
        angular_rate_rad_s: ``(N, 3)``.
        specific_force_m_s2: ``(N, 3)``.

    Raises:
        ValueError: stamps that are no integers, do not increase or lie 146 years or more from
            zero, lengths that differ, NaN, infinity or readings beyond 1e9.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> at_rest = np.tile([0.0, 0.0, 9.81], (3, 1))  # +g, upwards
        >>> imu = ImuStream(5_000_000 * np.arange(3), np.zeros((3, 3)), at_rest)
        >>> imu
        ImuStream(3 samples, 200.0 Hz, 0.010 s)
        >>> imu.at(np.array([7_500_000])).time_ns  # at least two
        Traceback (most recent call last):
        ...
        ValueError: ImuStream.time_ns: expected shape (N,) with N >= 2, got (1,)
    """

    time_ns: IntArray
    angular_rate_rad_s: FloatArray
    specific_force_m_s2: FloatArray

    def __post_init__(self) -> None:
        stamps = checked_increasing(self.time_ns, "ImuStream.time_ns", 2)
        object.__setattr__(self, "time_ns", stamps)
        for name in ("angular_rate_rad_s", "specific_force_m_s2"):
            values = checked_floats(getattr(self, name), f"ImuStream.{name}", (3,))
            if values.shape != (stamps.size, 3):
                raise ValueError(
                    f"ImuStream.{name}: expected shape {(stamps.size, 3)}, got {values.shape}"
                )
            if np.abs(values).max() > _REACH:
                raise ValueError(
                    f"ImuStream.{name}: expected readings within {_REACH:g}, "
                    f"got {np.abs(values).max():g}"
                )
            object.__setattr__(self, name, frozen(values))

    def __len__(self) -> int:
        return int(self.time_ns.size)

    def __repr__(self) -> str:
        return f"ImuStream({len(self)} samples, {self.rate_hz:.1f} Hz, {self.duration_s:.3f} s)"

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild through the constructor, so copies sent to other processes stay read-only."""
        arrays = (self.time_ns, self.angular_rate_rad_s, self.specific_force_m_s2)
        return ImuStream, tuple(np.array(array) for array in arrays)

    @property
    def duration_s(self) -> float:
        """Seconds from the first sample to the last."""
        return float(self.time_ns[-1] - self.time_ns[0]) * 1e-9

    @property
    def rate_hz(self) -> float:
        """Sampling rate: one over the median interval."""
        return float(1e9 / np.median(np.diff(self.time_ns)))

    def segments(self) -> list[ImuStream]:
        """The stream without its gaps of more than ten seconds; segments have two samples or more.

        Raises:
            ValueError: samples that are farther apart than that without being gaps.
        """
        parts = [part for part in segments(self.time_ns) if part.stop - part.start > 1]
        longest_s = max(1e-9 * float(np.diff(self.time_ns[part]).max()) for part in parts)
        if longest_s > LONGEST_BRIDGE_S:
            raise ValueError(
                f"imu: expected samples at most {LONGEST_BRIDGE_S:g} s apart, got {longest_s:.6g} s"
            )
        if len(parts) == 1 and parts[0].stop - parts[0].start == len(self):
            return [self]
        rate, force = self.angular_rate_rad_s, self.specific_force_m_s2
        return [ImuStream(self.time_ns[part], rate[part], force[part]) for part in parts]

    def corrected(self, gyro: FloatArray, accel: FloatArray) -> ImuStream:
        """The stream at the same stamps, with each reading r replaced by ``correction @ r``.

        Args:
            gyro: ``(3, 3)``, without unit, for angular rates.
            accel: ``(3, 3)``, without unit, for specific forces.

        Raises:
            ValueError: corrections of another shape, with NaN or infinity, or that take readings
                beyond 1e9.
        """
        return ImuStream(
            self.time_ns, self.angular_rate_rad_s @ gyro.T, self.specific_force_m_s2 @ accel.T
        )

    def at(self, time_ns: IntArray) -> ImuStream:
        """The samples at other stamps ``(M,)``, interpolated linearly between neighbours.

        Raises:
            ValueError: stamps outside the stream, or that do not increase.
        """
        if time_ns.size and (time_ns[0] < self.time_ns[0] or time_ns[-1] > self.time_ns[-1]):
            raise ValueError(
                f"ImuStream.at(time_ns): expected stamps in [{self.time_ns[0]}, "
                f"{self.time_ns[-1]}], got {time_ns[0]} to {time_ns[-1]}"
            )
        near = slice(None)
        if time_ns.size:
            first, last = np.searchsorted(self.time_ns, time_ns[[0, -1]], side="right")
            near = slice(max(0, first - 1), last + 1)
        wanted = (time_ns - self.time_ns[0]).astype(np.float64)
        known = (self.time_ns[near] - self.time_ns[0]).astype(np.float64)
        rate, force = (
            np.stack([np.interp(wanted, known, column) for column in values[near].T], axis=-1)
            for values in (self.angular_rate_rad_s, self.specific_force_m_s2)
        )
        return ImuStream(time_ns, rate, force)

    def around(self, time_ns: IntArray) -> ImuStream:
        """Samples at stamps ``(M,)``, as of `at`, and all that lie between them."""
        first = np.searchsorted(self.time_ns, time_ns[0], side="right")
        own = self.time_ns[first : np.searchsorted(self.time_ns, time_ns[-1])]
        return self.at(np.union1d(time_ns, own).astype(np.int64))


STANDARD_GRAVITY_M_S2 = 9.81
GRAVITY_SIGMA_M_S2 = 0.02
"""At sea level it is 9.780 at the equator and 9.832 at the poles (WGS 84), a deviation of 0.015 for
a place anywhere between them; a kilometre of height takes 0.003 off, three of them 0.01."""
GRAVITY_SHARE = 0.07
"""An accelerometer's scale and the shape of the earth leave readings within this share of it."""


def upright(down: FloatArray) -> Rotor:
    """The shortest turn that takes a direction ``(3,)``, as of gravity, to -z.

    From straight up all are as short: it is the one about x.
    """
    down = down / np.linalg.norm(down)
    axis = np.cross(down, [0.0, 0.0, -1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(-down[2])
    if sine < 1e-12:
        return Rotor.from_rotation_vector([np.pi if cosine < 0.0 else 0.0, 0.0, 0.0])
    return Rotor.from_rotation_vector(np.arctan2(sine, cosine) / sine * axis)
