"""IMU noise: white noise and a random walk of the bias, by Kalibr's model.

Densities are continuous: sampled at intervals Δt, white noise has deviation σ / √Δt and the bias
steps by σ_b √Δt (github.com/ethz-asl/kalibr/wiki/IMU-Noise-Model). Read from Kalibr's ``imu.yaml``
or EuRoC's ``sensor.yaml``, which name the four numbers alike.
"""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path

from motorcade.ga.files import read_bounded
from motorcade.ga.plain_yaml import YamlError, parse_yaml

MAX_FILE_BYTES = 1 << 18
_YAML_NAMES = {
    "gyro_density_rad_s_rthz": "gyroscope_noise_density",
    "gyro_walk_rad_s2_rthz": "gyroscope_random_walk",
    "accel_density_m_s2_rthz": "accelerometer_noise_density",
    "accel_walk_m_s3_rthz": "accelerometer_random_walk",
}

GYRO_BIAS_SIGMA_RAD_S = 0.1
ACCEL_BIAS_SIGMA_M_S2 = 0.5
"""What is known of a sensor's biases before its first sample: hardly anything."""

_MOST = 1e9  # the squares of densities are variances


@dataclass(frozen=True)
class ImuNoise:
    """Continuous noise densities of an IMU, the same on every axis; all above zero.

    Fields:
        gyro_density_rad_s_rthz: white noise of the angular rate, rad/s/√Hz.
        gyro_walk_rad_s2_rthz: random walk of its bias, rad/s²/√Hz.
        accel_density_m_s2_rthz: white noise of the specific force, m/s²/√Hz.
        accel_walk_m_s3_rthz: random walk of its bias, m/s³/√Hz.

    Raises:
        ValueError: a number that is not above zero or larger than 1e9, named by its field.

    Examples:
        >>> from motorcade.fusion import ImuNoise
        >>> noise = ImuNoise(1.7e-4, 2e-5, 2e-3, 3e-3)  # of a data sheet: too small in the hand
        >>> noise.scaled(3.0).accel_density_m_s2_rthz
        0.006
    """

    gyro_density_rad_s_rthz: float
    gyro_walk_rad_s2_rthz: float
    accel_density_m_s2_rthz: float
    accel_walk_m_s3_rthz: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not _is_positive(value):
                raise ValueError(f"ImuNoise.{field.name}: expected a number above 0, got {value!r}")
            if value > _MOST:
                raise ValueError(
                    f"ImuNoise.{field.name}: expected at most {_MOST:g}, got {value!r}"
                )
            object.__setattr__(self, field.name, float(value))

    @classmethod
    def load(cls, path: Path) -> ImuNoise:
        """Read Kalibr's ``imu.yaml`` (with or without its ``imu0:``) or EuRoC's ``sensor.yaml``.

        Raises:
            FileError: a file that cannot be read, or is too large.
            ValueError: no UTF-8 or no plain YAML mapping, or one of the four numbers missing, no
                number or not above zero; one line names file and field.
        """
        content = _yaml_mapping(path)
        nested = [part for part in content.values() if isinstance(part, Mapping)]
        if "gyroscope_noise_density" not in content and "imu0" in content and nested:
            content = nested[0]
        values = {field: _number(content, name, path) for field, name in _YAML_NAMES.items()}
        return cls(**values)

    def scaled(self, factor: float) -> ImuNoise:
        """The same sensor with all four densities multiplied, as on a vibrating vehicle."""
        return ImuNoise(*(factor * getattr(self, field.name) for field in fields(self)))


def _yaml_mapping(path: Path) -> Mapping[str, object]:
    try:
        content = parse_yaml(read_bounded(path, MAX_FILE_BYTES).decode("utf-8"))
    except UnicodeDecodeError as fault:
        raise ValueError(f"{path}: expected YAML in UTF-8, got other bytes") from fault
    except YamlError as fault:
        raise ValueError(f"{path}: {fault}") from fault
    if not isinstance(content, Mapping):
        raise ValueError(f"{path}: expected a YAML mapping, got {type(content).__name__}")
    return content


def _number(content: Mapping[str, object], name: str, path: Path) -> float:
    if name not in content:
        raise ValueError(f"{path}: expected the field {name}, got {', '.join(map(str, content))}")
    value = content[name]
    if isinstance(value, str):  # YAML 1.1 reads 1e-3, without a dot, as text
        with suppress(ValueError):
            value = float(value)
    if not _is_positive(value):
        shown = reprlib.repr(content[name])
        raise ValueError(f"{path}: {name}: expected a number above 0, got {shown}")
    return float(str(value))


def _is_positive(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return 0 < value <= sys.float_info.max


ADIS16448 = ImuNoise(1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-3)
"""The IMU of the EuRoC recordings, with the densities that their ``sensor.yaml`` states."""
