"""Whether an orientation can be relied on, by what gravity and the magnetic field say of it."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.gravity import GRAVITY_SHARE
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.orientation.estimate import Orientation, OrientationModel
from motorcade.ga.arrays import FloatArray

# Over windows of this length the acceleration of a hand, a limb or a small aircraft averages out,
# and gravity does not.
_WINDOW_S = 2.0
# What windows may leave of horizontal specific force. Clean trials of BROAD and flights of EuRoC
# have 0.01 to 0.08 of gravity; a gyro in degrees, with axes swapped or turned around 0.1 to 1.
_LEVEL_SHARE = 0.1
# A unit of specific force by what gravity is in it.
_UNITS = ((1.0, "g", 9.80665), (1000.0, "milli-g", 9.80665e-3), (32.174, "ft/s²", 0.3048))
# Beyond this the field is disturbed (20° of heading); for half of the time, and it is no use.
_DISTURBED_RAD, _DISTURBED_SHARE = 0.35, 0.5
# Tilt and heading are called unknown beyond these deviations.
_TILT_RAD, _HEADING_RAD = 0.1, 0.2


def orientation_doubts(
    imu: ImuStream,
    orientation: Orientation,
    model: OrientationModel | None = None,
    *,
    with_magnetometer: bool = False,
) -> tuple[str, ...]:
    """What speaks against an estimated orientation, a line each; nothing where all is well.

    A sensor that hardly turns shows no fault of its gyro or magnetometer, and one whose specific
    force is negative as a whole stands upside down without a sign of it.

    Args:
        imu: the stream.
        orientation: its orientation.
        model: the model that it was estimated with.
        with_magnetometer: whether a magnetic field was given.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream, estimate_orientation
        >>> from motorcade.fusion.orientation import orientation_doubts
        >>> still, up = np.zeros((2000, 3)), np.tile([0.0, 0.0, 1.0], (2000, 1))
        >>> in_g = ImuStream(5_000_000 * np.arange(2000), still, up)
        >>> orientation_doubts(in_g, estimate_orientation(in_g))
        ('specific force averages to 1 upwards, which is gravity in g; multiply by 9.80665',)
    """
    model = OrientationModel() if model is None else model
    gravity = model.gravity_m_s2
    world = orientation.world_R_imu.apply(imu.specific_force_m_s2)
    count = max(1, min(len(imu), round(_WINDOW_S * imu.rate_hz)))
    windows = world[: len(imu) // count * count].reshape(-1, count, 3).mean(axis=1)
    up = float(np.median(windows[:, 2]))
    level = float(np.sqrt(np.mean(np.sum(windows[:, :2] ** 2, axis=1))))
    warnings = []
    if level > _LEVEL_SHARE * max(abs(up), 0.1 * gravity):
        warnings.append(
            f"specific force averages to {level:.3g} m/s² sideways where gravity should stand "
            "upright: the gyroscope is in degrees a second, or its axes or signs are not the "
            "accelerometer's; or the sensor speeds up for seconds, as in a vehicle"
        )
    elif abs(up / gravity - 1.0) > GRAVITY_SHARE:
        warnings.append(_wrong_gravity(up, gravity))
    if np.median(orientation.tilt_deviation_rad) > _TILT_RAD:
        warnings.append(f"tilt is known to {_degrees(orientation.tilt_deviation_rad)} only")
    if with_magnetometer:
        warnings += _magnetic(orientation)
    return tuple(warnings)


def _wrong_gravity(up: float, gravity: float) -> str:
    for size, unit, factor in _UNITS:
        if abs(up / size - 1.0) < GRAVITY_SHARE:
            return (
                f"specific force averages to {up:.4g} upwards, which is gravity in {unit}; "
                f"multiply by {factor:g}"
            )
    return (
        f"specific force averages to {up:.3g} m/s² upwards, expected {gravity:g}: without gravity "
        "there is no tilt; give the accelerometer's readings as they are"
    )


def _magnetic(orientation: Orientation) -> list[str]:
    warnings = []
    disturbed = float(np.mean(orientation.field_deviation_rad > _DISTURBED_RAD))
    if disturbed > _DISTURBED_SHARE:
        warnings.append(
            f"the magnetic field is disturbed {disturbed:.0%} of the time: magnets or iron nearby, "
            "a magnetometer that is not calibrated, or axes that are not the gyroscope's"
        )
    if np.median(orientation.heading_deviation_rad) > _HEADING_RAD:
        warnings.append(f"heading is known to {_degrees(orientation.heading_deviation_rad)} only")
    return warnings


def _degrees(deviations_rad: FloatArray) -> str:
    return f"±{np.degrees(np.median(deviations_rad)):.0f}°"
