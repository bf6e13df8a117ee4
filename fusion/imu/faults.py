"""What is wrong with a simulated IMU besides its white noise and the walks of its biases."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.ga.stamps import checked_span_ns


@dataclass(frozen=True, eq=False)
class ImuFaults:
    """What is wrong with an IMU besides its noise; nothing by default.

    Scale and misalignment form Kalibr's lower triangular matrix, by which the true vector is
    multiplied: scale ``(x, y, z)`` on the diagonal, misalignment ``(yx, zx, zy)`` below it, the
    small angles by which the y axis leans to x and the z axis to x and y. The true axes are those
    of the accelerometer; the gyroscope's may be turned against them, and feel force, as there
    (github.com/ethz-asl/kalibr/wiki/Multi-IMU-and-IMU-intrinsic-calibration).

    Args:
        gyro_scale, accel_scale: ``(3,)`` or one for all axes, above 0; 1 is right.
        gyro_misalignment_rad, accel_misalignment_rad: ``(3,)``.
        gyro_turn_rad: ``(3,)``, the rotation vector that takes the accelerometer's axes to the
            gyroscope's.
        gyro_g_sensitivity_rad_s_m: angular rate read for specific force, (rad/s)/(m/s²): one
            number or ``(3,)`` for force along each axis itself, or ``(3, 3)``.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)``, the biases that the walks start from.
        gyro_flicker_rad_s, accel_flicker_m_s2: ``(3,)``, bias instability B: the bias wanders with
            a spectrum of 1/f, and the Allan deviation lies flat at 0.664 B (IEEE Std 952).
        warming_k, warming_time_s: the sensor gets warmer by so many kelvins, and by 63 % of them
            within the time.
        gyro_bias_rad_s_k, accel_bias_m_s2_k: ``(3,)``, bias for each kelvin.
        gyro_scale_k, accel_scale_k: ``(3,)``, growth of the scale for each kelvin.
        gyro_lowpass_hz, accel_lowpass_hz: where the sensor's own filter, a Butterworth of second
            order, halves the power; below half the rate, or infinite for no filter.
        gyro_delay_s, accel_delay_s: by how much a reading is older than its stamp, besides the
            filter's own delay.
        stamp_jitter_s: deviation of stamps from when samples are taken, at most a quarter of the
            interval; normal, but cut at 0.4 intervals, so that stamps keep their order.
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
    gyro_turn_rad: ArrayLike = 0.0
    gyro_g_sensitivity_rad_s_m: ArrayLike = 0.0
    gyro_bias_rad_s: ArrayLike = 0.0
    accel_bias_m_s2: ArrayLike = 0.0
    gyro_flicker_rad_s: ArrayLike = 0.0
    accel_flicker_m_s2: ArrayLike = 0.0
    warming_k: float = 0.0
    warming_time_s: float = 600.0
    gyro_bias_rad_s_k: ArrayLike = 0.0
    accel_bias_m_s2_k: ArrayLike = 0.0
    gyro_scale_k: ArrayLike = 0.0
    accel_scale_k: ArrayLike = 0.0
    gyro_lowpass_hz: float = np.inf
    accel_lowpass_hz: float = np.inf
    gyro_delay_s: float = 0.0
    accel_delay_s: float = 0.0
    stamp_jitter_s: float = 0.0
    gyro_range_rad_s: float = np.inf
    accel_range_m_s2: float = np.inf
    gyro_step_rad_s: float = 0.0
    accel_step_m_s2: float = 0.0
    dropped_share: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name = f"ImuFaults.{field.name}"
            value = getattr(self, field.name)
            checked: float | FloatArray
            if field.type == "float":
                checked = _checked_number(float(value), name)
            elif field.name == "gyro_g_sensitivity_rad_s_m":
                checked = _checked_matrix(value, name)
            else:
                checked = _checked_axes(value, name)
            object.__setattr__(self, field.name, checked)

    @property
    def gyro_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true angular rate to that read, before bias and noise."""
        turn = Rotor.from_rotation_vector(self.gyro_turn_rad).inverse().as_matrix()
        return _lower_triangular(self.gyro_scale, self.gyro_misalignment_rad) @ turn

    @property
    def accel_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true specific force to that read, before bias and noise."""
        return _lower_triangular(self.accel_scale, self.accel_misalignment_rad)

    def warmed_k(self, seconds: FloatArray) -> FloatArray:
        """Kelvins above the first temperature ``(*)``, seconds after the start ``(*)``."""
        return -self.warming_k * np.expm1(-seconds / self.warming_time_s)

    def converted_rate(self, rate_rad_s: FloatArray) -> FloatArray:
        """Angular rates ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(rate_rad_s, self.gyro_range_rad_s, self.gyro_step_rad_s)

    def converted_force(self, force_m_s2: FloatArray) -> FloatArray:
        """Specific forces ``(*, 3)`` as they come out of the converter: cut off, then rounded."""
        return _converted(force_m_s2, self.accel_range_m_s2, self.accel_step_m_s2)


def _checked_axes(value: ArrayLike, name: str) -> FloatArray:
    values = np.asarray(value, dtype=np.float64)
    if values.shape not in ((), (3,)):
        raise ValueError(f"{name}: expected one number or three, got shape {values.shape}")
    axes: FloatArray = checked_floats(np.broadcast_to(values, (3,)).copy(), name, (3,))
    if name.endswith("_scale") and np.any(axes <= 0.0):
        raise ValueError(f"{name}: expected numbers above 0, got {axes.tolist()}")
    # An angle at a time: squares of what is out of range overflow.
    if name.endswith("_turn_rad") and not np.all(np.abs(axes) <= np.pi):
        raise ValueError(f"{name}: expected angles within π, got {axes.tolist()}")
    if "_flicker_" in name and np.any(axes < 0.0):
        raise ValueError(f"{name}: expected numbers of at least 0, got {axes.tolist()}")
    return frozen(axes)


def _checked_matrix(value: ArrayLike, name: str) -> FloatArray:
    values = np.asarray(value, dtype=np.float64)
    if values.shape not in ((), (3,), (3, 3)):
        raise ValueError(f"{name}: expected one number, three or 3 x 3, got shape {values.shape}")
    matrix = values.copy() if values.ndim == 2 else np.diag(np.broadcast_to(values, (3,)))
    return frozen(checked_floats(matrix, name, (3, 3)))


_ABOVE_ZERO = ("_range_", "_lowpass_", "warming_time_s")


def _checked_number(value: float, name: str) -> float:
    if name.endswith("dropped_share"):
        if not 0.0 <= value < 1.0:
            raise ValueError(f"{name}: expected a share in [0, 1), got {value}")
    elif name.endswith("warming_k"):
        if not np.isfinite(value):
            raise ValueError(f"{name}: expected a finite number, got {value}")
    elif any(part in name for part in _ABOVE_ZERO):
        if not value > 0.0:
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    elif "_delay_" in name and value > 0.0:
        checked_span_ns(value, name)
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
    return np.clip(values, -limit, limit)


PERFECT = ImuFaults()
"""A sensor without faults; it may still be noisy."""
