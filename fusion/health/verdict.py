"""What is wrong with an inertial recording, a line each, and what cannot be told; and the lines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from motorcade.fusion.health.accelerometer import ForceVerdict
from motorcade.fusion.health.gyroscope import LONGEST_STEP_S, RateVerdict
from motorcade.fusion.health.models import AxesVerdict, order_of
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S
from motorcade.fusion.imu.stream import GRAVITY_SHARE
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

FaultName = Literal[
    "measurements_refused",
    "stamp_unit",
    "stuck",
    "poses_inverted",
    "unrelated",
    "rate_unit",
    "position_unit",
    "force_unit",
    "rate_scale",
    "force_scale",
    "extrinsics_inverted",
    "extrinsics_turned",
    "rate_axes",
    "force_axes",
    "rate_sign",
    "force_sign",
    "clock_drift",
    "delay",
    "axes",
    "gravity",
    "lean",
    "saturated",
    "attitude_unknown",
    "rate_unexplained",
    "force_unexplained",
    "rate_bias",
    "force_bias",
    "deviations_modelled",
]
"""Worst first: the first says that the path is wrong, the last only what deviations leave out."""

_ORDER: tuple[FaultName, ...] = get_args(FaultName)
Sensor = Literal["gyroscope", "accelerometer"]


@dataclass(frozen=True)
class HealthFinding:
    """A fault: its name, and one line that says what was found and what mends it.

    Fields:
        fault: its name.
        summary: the line.
        instead: name of another fault that every measurement would show alike; None where there is
            none. The line then names both.

    Examples:
        >>> from motorcade.fusion.health import HealthFinding
        >>> HealthFinding("delay", "the IMU's stamps are 0.5 s late: time_offset_s=0.5").fault
        'delay'
    """

    fault: FaultName
    summary: str
    instead: FaultName | None = None


@dataclass(frozen=True)
class Health:
    """What a check of an IMU beside a path has found.

    Fields:
        findings: what is wrong, worst first; empty where nothing is.
        unknown: what the motion does not tell, one line each: no fault, but no proof either.

    Examples:
        >>> from motorcade.fusion.health import HealthFinding, Health
        >>> Health((HealthFinding("delay", "the IMU's stamps are 0.5 s late"),), ()).sound
        False
    """

    findings: tuple[HealthFinding, ...] = ()
    unknown: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        ordered = sorted(self.findings, key=lambda finding: _ORDER.index(finding.fault))
        object.__setattr__(self, "findings", tuple(ordered))

    @property
    def sound(self) -> bool:
        """Whether nothing was found but what deviations leave out."""
        return not set(self.faults) - {"deviations_modelled"}

    @property
    def failed(self) -> bool:
        """Whether more poses were refused than accepted: no path then, only an opinion."""
        return "measurements_refused" in self.faults

    @property
    def faults(self) -> tuple[FaultName, ...]:
        """Names of what was found."""
        return tuple(one.fault for one in self.findings)

    @property
    def summary(self) -> str:
        """All in one line."""
        if self.findings:
            return "; ".join(one.summary for one in self.findings)
        if self.unknown:
            return "; ".join(self.unknown)
        return "the IMU agrees with the path"

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "sound": self.sound,
            "failed": self.failed,
            "findings": [asdict(one) for one in self.findings],
            "unknown": list(self.unknown),
        }


# One line a fault: what was found, and what mends it.

_LENGTHS = {
    "centimetres": 100.0,
    "millimetres": 1e3,
    "inches": 1.0 / 0.0254,
    "feet": 1.0 / 0.3048,
    "kilometres": 1e-3,
}  # of a metre
_EXPECTED = {"gyroscope": "radians a second", "accelerometer": "m/s²"}
_UNTOLD = 1.5  # times: an axis must read more of the rates to be named
_BEYOND = 4.0  # deviations of what is known of a bias


POSES_INVERTED = HealthFinding(
    "poses_inverted",
    "the poses are the wrong way round: those of the world seen from the camera agree with the "
    "gyroscope; give the camera's in the world, which are their inverses",
)
EXTRINSICS_INVERTED = HealthFinding(
    "extrinsics_inverted", "imu_T_camera is the wrong way round (transposed): give its inverse"
)


def clock_drift(share: float) -> HealthFinding:
    """A clock that runs at another rate, by the change of the offset a second."""
    return HealthFinding(
        "clock_drift",
        f"the IMU's clock runs {abs(100.0 * share):.2g} % {'fast' if share > 0.0 else 'slow'} "
        "beside the poses': stamp both by one clock, or scale its stamps about the first",
    )


def bias_step(step_rad_s: FloatArray) -> HealthFinding:
    """A bias in the second half of a recording that is not that of the first."""
    return HealthFinding(
        "rate_bias",
        f"the gyroscope's bias changes by {_three(step_rad_s)} rad/s from the recording's first "
        "half to its second: leave one of them out, or record anew once it is warm",
    )


def unit(sensor: Sensor, multiple: float, units: Mapping[float, str]) -> HealthFinding:
    """Readings in another unit."""
    called = f"reads {units[multiple]}" if multiple in units else "has another unit or scale"
    return HealthFinding(
        "rate_unit" if sensor == "gyroscope" else "force_unit",
        f"the {sensor} {called}, where {_EXPECTED[sensor]} are expected: multiply its readings by "
        f"{multiple:.6g}",
    )


def position_unit(scale: float) -> HealthFinding:
    """Positions that are no metres."""
    unit = next((name for name, size in _LENGTHS.items() if abs(scale / size - 1.0) < 0.1), None)
    what = f"are in {unit}" if unit else f"are {scale:.3g} times as large as metres"
    mend = 1.0 / (_LENGTHS[unit] if unit else scale)
    line = f"positions {what} by the accelerometer: multiply them by {mend:.4g}"
    return HealthFinding("position_unit", line)


def rate_scale(scales: tuple[float, float, float]) -> HealthFinding:
    """A gyroscope's axes whose scale is not that of the others."""
    lines = [
        f"the gyroscope's {axis} reads {1.0 / scale:.3g} times what the camera turns: multiply "
        f"it by {scale:.3g}"
        for axis, scale in zip("xyz", scales, strict=True)
        if scale != 1.0
    ]
    return HealthFinding("rate_scale", "; ".join(lines))


def force_scale(share: float, gravity_m_s2: float) -> HealthFinding:
    """An accelerometer that reads another gravity, by its scale or a bias."""
    return HealthFinding(
        "force_scale",
        f"the accelerometer reads {share:.3g} times gravity throughout: multiply it by "
        f"{1.0 / share:.3g}, or subtract the bias of {(share - 1.0) * gravity_m_s2:.2g} m/s² along "
        "gravity that looks the same here; at rest on all six sides it tells which",
    )


def mirrored_axes(of_rates: AxesVerdict, of_forces: AxesVerdict) -> HealthFinding:
    """A left-handed frame, in which rates turn the other way round."""
    return HealthFinding(
        "axes",
        "the IMU's axes are left-handed: put the accelerometer's readings as "
        f"{order_of(of_forces.permutation)} and the gyroscope's as {order_of(of_rates.permutation)}"
        " for (x, y, z)",
    )


def shared_axes(axes: AxesVerdict) -> list[HealthFinding]:
    """What both sensors have in common: the order of the axes, or a turn of the extrinsics."""
    turned = not np.allclose(axes.turn, np.eye(3))
    if turned and np.linalg.det(axes.permutation) < 0.0:
        line = (
            "the IMU's axes are left-handed: negate all three of each sensor, or the one that is "
            "wrong, or swap two"
        )
        return [HealthFinding("axes", line)]
    findings = []
    if not np.allclose(axes.permutation, np.eye(3)):
        findings.append(HealthFinding("axes", _order("the IMU's axes are", axes)))
    if turned:
        # True readings, in the axes that the extrinsics speak of, are turn @ readings.
        vector = Rotor.from_matrix(axes.turn).inverse().as_rotation_vector()
        line = (
            f"imu_T_camera is turned by {np.rad2deg(axes.turn_rad):.0f}°: put the rotation vector "
            f"{_degrees(vector)}, in the IMU's axes, before its rotation, or estimate it anew"
        )
        findings.append(HealthFinding("extrinsics_turned", line))
    return findings


def own_axes(sensor: Sensor, axes: AxesVerdict) -> HealthFinding:
    """One sensor whose axes are not those that the other, or the extrinsics, have."""
    fault: FaultName = "rate_axes" if sensor == "gyroscope" else "force_axes"
    if np.allclose(axes.turn, np.eye(3)):
        if not np.array_equal(axes.permutation, -np.eye(3)):
            return HealthFinding(fault, _order(f"the {sensor}'s axes are", axes))
        fault = "rate_sign" if sensor == "gyroscope" else "force_sign"
        return HealthFinding(fault, f"the {sensor}'s sign is wrong: negate its three axes")
    if np.linalg.det(axes.permutation) < 0.0:
        line = "axes are left-handed: negate all three, or the one that is wrong, or swap two"
        return HealthFinding(fault, f"the {sensor}'s {line}")
    vector = Rotor.from_matrix(axes.turn).as_rotation_vector()
    line = (
        f"the {sensor}'s axes are turned by {np.rad2deg(axes.turn_rad):.0f}° from the other "
        f"sensor's: turn its readings by the rotation vector {_degrees(vector)}"
    )
    return HealthFinding(fault, line)


def both(hypotheses: list[list[HealthFinding]]) -> list[HealthFinding]:
    """What is wrong with axes, in one line where a second hypothesis explains all as well."""
    if len(hypotheses) == 1 or not all(hypotheses):
        return hypotheses[0]
    lines = [" and ".join(finding.summary for finding in findings) for findings in hypotheses]
    line = "either " + ", or ".join(lines) + " (no measurement tells which)"
    return [HealthFinding(hypotheses[0][0].fault, line, instead=hypotheses[1][0].fault)]


def delay(rates: RateVerdict) -> HealthFinding:
    """Stamps that are off."""
    late = "late" if rates.lag_s > 0.0 else "early"
    return HealthFinding(
        "delay",
        f"the IMU's stamps are {abs(rates.lag_s):.3f} s {late} beside the poses': add "
        f"{rates.lag_s:.3f} s to time_offset_s (± {rates.lag_sigma_s:.3f} s)",
    )


def gravity(forces: ForceVerdict, stated_m_s2: float) -> HealthFinding:
    """Another gravity, or a world that leans."""
    vector = forces.gravity_m_s2
    size = float(np.linalg.norm(vector))
    if abs(size / stated_m_s2 - 1.0) > GRAVITY_SHARE:
        return HealthFinding(
            "gravity",
            f"gravity is {size:.2f} m/s² here, where {stated_m_s2:g} was stated: set gravity_m_s2 "
            "to it, or scale the accelerometer",
        )
    lean = float(np.rad2deg(np.arccos(np.clip(-vector[2] / size, -1.0, 1.0))))
    return HealthFinding(
        "lean",
        f"the world's z is {lean:.0f}° from up: level the poses, or set gravity_sigma_rad to at "
        "least that",
    )


def unrelated(rates: RateVerdict, search_s: float) -> HealthFinding:
    """An IMU that moved otherwise than the camera."""
    return HealthFinding(
        "unrelated",
        f"the IMU did not move with the camera: it turns by {rates.read_rad_s:.2g} rad/s an axis, "
        f"the camera by {rates.turned_rad_s:.2g}, but not together at any offset within "
        f"{search_s:g} s: give the IMU of the same recording",
    )


def unexplained(rates: RateVerdict, forces: ForceVerdict) -> list[HealthFinding]:
    """Biases far beyond what is known of them, and readings that nothing explains."""
    findings = []
    if rates.state == "unexplained":
        if np.max(np.abs(rates.bias_rad_s)) > _BEYOND * GYRO_BIAS_SIGMA_RAD_S:
            line = f"the gyroscope reads {_three(rates.bias_rad_s)} rad/s at rest: subtract it"
            findings.append(HealthFinding("rate_bias", line))
        else:
            line = (
                "the gyroscope agrees with the camera only in part, and no unit, sign, order of "
                "axes, rotation or offset mends it"
            )
            findings.append(HealthFinding("rate_unexplained", line))
    if forces.state == "unexplained":
        if np.max(np.abs(forces.bias_m_s2)) > _BEYOND * ACCEL_BIAS_SIGMA_M_S2:
            line = (
                f"the accelerometer is off by {_three(forces.bias_m_s2)} m/s² in the camera's axes,"
                f" where {ACCEL_BIAS_SIGMA_M_S2:g} are usual: calibrate it"
            )
            findings.append(HealthFinding("force_bias", line))
        else:
            line = (
                "the accelerometer contradicts the path, and no unit, sign, order of axes, "
                "rotation or gravity mends it"
            )
            findings.append(HealthFinding("force_unexplained", line))
    return findings


def unknown(rates: RateVerdict, forces: ForceVerdict) -> tuple[str, ...]:
    """What the motion does not tell."""
    lines = []
    if rates.state == "unknown":
        few = f"too few poses less than {LONGEST_STEP_S:g} s apart"
        why = few if rates.axes is None else "the camera turns too little"
        lines.append(f"cannot tell the gyroscope's unit, sign and axes: {why}")
    elif rates.axes is not None and rates.explained and rates.axes.blurred:
        axes = " and ".join(rates.axes.blurred)
        lines.append(f"cannot tell the gyroscope's {axes}: the camera hardly turns about it")
    elif rates.axes is not None and rates.explained:
        scales = zip("xyz", rates.axes.least_scales, strict=True)
        least = [f"{axis} below {one:.2f} times" for axis, one in scales if one > _UNTOLD]
        if least:
            line = f"cannot tell the gyroscope's scale of {' and of '.join(least)} the true rates"
            lines.append(f"{line}: the camera turns too little about it")
    if forces.state == "unknown":
        lines.append(
            "cannot tell the accelerometer's unit, sign and axes: too few seconds of poses less "
            f"than {LONGEST_STEP_S:g} s apart"
        )
    elif forces.axes is not None and forces.state != "unexplained" and forces.axes.blurred:
        axes = " and ".join(forces.axes.blurred)
        lines.append(f"cannot tell the accelerometer's {axes}: the motion hardly changes them")
    return tuple(lines)


def _order(opening: str, axes: AxesVerdict) -> str:
    handed = "left-handed" if np.linalg.det(axes.permutation) < 0.0 else "in another order"
    return (
        f"{opening} {handed} as they come: put the readings as {order_of(axes.permutation)} for "
        "(x, y, z)"
    )


def _degrees(vector_rad: FloatArray) -> str:
    return _three(np.rad2deg(vector_rad)) + "°"


def _three(values: FloatArray) -> str:
    return "(" + ", ".join(f"{one:.3g}" for one in values) + ")"
