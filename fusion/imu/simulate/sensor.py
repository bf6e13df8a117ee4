"""Faults of a real sensor beyond its noise: scale, misalignment, biases, range, steps, losses.

Readings pass through them in the order of the hardware: the axes mix and scale the truth, biases
and noise are added, the amplifier saturates, the converter rounds, and the wire loses samples.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats, frozen

__all__ = ["PERFECT", "ImuFaults"]


@dataclass(frozen=True, eq=False)
class ImuFaults:
    """What is wrong with an IMU besides its noise; nothing by default.

    Scale and misalignment form Kalibr's lower triangular matrix, by which the true vector is
    multiplied: scale ``(x, y, z)`` on the diagonal, misalignment ``(yx, zx, zy)`` below it, the
    small angles by which the y axis leans to x and the z axis to x and y
    (github.com/ethz-asl/kalibr/wiki/Multi-IMU-and-IMU-intrinsic-calibration).

    Args:
        gyro_scale, accel_scale: ``(3,)`` or one for all axes, above 0; 1 is right.
        gyro_misalignment_rad, accel_misalignment_rad: ``(3,)``.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)``, the biases that the walks start from.
        gyro_range_rad_s, accel_range_m_s2: readings end at ± this; infinite by default.
        gyro_step_rad_s, accel_step_m_s2: readings are multiples of this; 0 for none.
        dropped_share: probability, in [0, 1), that a sample is lost, each for itself.

    Raises:
        ValueError: a number outside its bounds, named by its field.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)

        >>> from motorcade.fusion.imu import ImuFaults
        >>> faults = ImuFaults(gyro_range_rad_s=1.0, dropped_share=0.1)
        >>> faulty = simulate_imu(path, 100.0, ADIS16448, rng, faults=faults)
        >>> bool(np.abs(faulty.stream.angular_rate_rad_s).max() <= 1.0), len(faulty.stream) < 301
        (True, True)
    """

    gyro_scale: ArrayLike = 1.0
    accel_scale: ArrayLike = 1.0
    gyro_misalignment_rad: ArrayLike = 0.0
    accel_misalignment_rad: ArrayLike = 0.0
    gyro_bias_rad_s: ArrayLike = 0.0
    accel_bias_m_s2: ArrayLike = 0.0
    gyro_range_rad_s: float = np.inf
    accel_range_m_s2: float = np.inf
    gyro_step_rad_s: float = 0.0
    accel_step_m_s2: float = 0.0
    dropped_share: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name = f"ImuFaults.{field.name}"
            value = getattr(self, field.name)
            if field.type == "float":
                object.__setattr__(self, field.name, _checked_number(float(value), name))
            else:
                object.__setattr__(self, field.name, _checked_axes(value, name))

    @property
    def gyro_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true angular rate to that read, before bias and noise."""
        return _lower_triangular(self.gyro_scale, self.gyro_misalignment_rad)

    @property
    def accel_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true specific force to that read, before bias and noise."""
        return _lower_triangular(self.accel_scale, self.accel_misalignment_rad)

    def converted_rate(self, rate_rad_s: FloatArray) -> FloatArray:
        """Angular rates ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(rate_rad_s, self.gyro_range_rad_s, self.gyro_step_rad_s)

    def converted_force(self, force_m_s2: FloatArray) -> FloatArray:
        """Specific forces ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(force_m_s2, self.accel_range_m_s2, self.accel_step_m_s2)


def _checked_axes(value: ArrayLike, name: str) -> FloatArray:
    given = np.asarray(value, dtype=np.float64)
    if given.shape not in ((), (3,)):
        raise ValueError(f"{name}: expected one number or three, got shape {given.shape}")
    axes: FloatArray = checked_floats(np.broadcast_to(given, (3,)).copy(), name, (3,))
    if name.endswith("_scale") and np.any(axes <= 0.0):
        raise ValueError(f"{name}: expected numbers above 0, got {axes.tolist()}")
    return frozen(axes)


def _checked_number(value: float, name: str) -> float:
    if name.endswith("dropped_share"):
        if not 0.0 <= value < 1.0:
            raise ValueError(f"{name}: expected a share in [0, 1), got {value}")
    elif "_range_" in name:
        if not value > 0.0:
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    elif not 0.0 <= value < np.inf:
        raise ValueError(f"{name}: expected a number of at least 0, got {value}")
    return value


def _lower_triangular(scale: ArrayLike, misalignment_rad: ArrayLike) -> FloatArray:
    matrix: FloatArray = np.diag(np.asarray(scale, dtype=np.float64))
    matrix[[1, 2, 2], [0, 0, 1]] = misalignment_rad
    return matrix


def _converted(values: FloatArray, limit: float, step: float) -> FloatArray:
    if step > 0.0:
        # The last step that the range holds, so that saturated readings are multiples too.
        limit = np.floor(limit / step) * step if np.isfinite(limit) else limit
        values = np.round(values / step) * step
    cut: FloatArray = np.clip(values, -limit, limit)
    return cut


PERFECT = ImuFaults()
"""A sensor without faults; it may still be noisy."""
