"""Faults of inertial streams that every number passes: wrong units, saturation, gaps.

NaN and stamps that do not increase are refused by `ImuStream` itself. Units are told by physics: a
sensor at rest feels one gravity, and while it turns slowly gravity turns the other way in its axes.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.stream import GRAVITY_SHARE, STANDARD_GRAVITY_M_S2, ImuStream
from motorcade.ga.arrays import FloatArray

# Windows this long whose readings scatter by less than this share of their mean are quiet.
_WINDOW_S = 0.5
_QUIET_SHARE = 0.02
_FEWEST_QUIET = 2
# Size of gravity, what a unit that gives it is called, and what one of it is in m/s².
_GRAVITY_UNITS = ((1.0, "g", 9.80665), (1000.0, "milli-g", 9.80665e-3), (32.174, "ft/s²", 0.3048))
# Rates and forces are compared in means of this length.
_TURN_WINDOW_S = 0.1
# Deviations that the regression's slope must be from chance.
_TURN_DEVIATIONS = 6.0
_FEWEST_TURNS = 30
_GAP_MEDIANS = 1.75
# Means of windows that differ from the next by more are those of a sensor that moves: drift of the
# biases is far slower. Noise may add so many deviations of such a difference.
_TURNS_RAD_S = 0.05
_PUSHED_M_S2 = 0.3
_NOISE_DEVIATIONS = 6.0
_REPEATED = 8


def screen_imu(imu: ImuStream) -> tuple[str, ...]:
    """What is doubtful about a stream, one line each; nothing where all is well.

    A stream that is never quiet for a second says nothing of its force's unit, and one that hardly
    turns nothing of its rate's.

    Raises:
        ValueError: specific force in g, milli-g or ft/s², or angular rate in degrees.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream, screen_imu
        >>> in_g = np.tile([0.0, 0.0, 1.0], (400, 1))
        >>> screen_imu(ImuStream(5_000_000 * np.arange(400), np.zeros((400, 3)), in_g))
        Traceback (most recent call last):
        ...
        ValueError: ...
    """
    felt, share = refuse_units_of_force(imu), _turned_share(imu)
    if share is not None and 0.5 < share / np.deg2rad(1.0) < 2.0:
        raise ValueError(
            "angular_rate_rad_s: expected radians a second, got readings by which gravity turns "
            f"{share:.4f} times as far, as in degrees a second; multiply by {np.deg2rad(1.0):.8g}"
        )
    return (*_gravity(felt), *saturated_axes(imu), *_gaps(imu))


def refuse_units_of_force(imu: ImuStream) -> float | None:
    """Size of specific force at rest; None where the sensor never is.

    Raises:
        ValueError: naming the unit in which it is gravity's, and the factor that mends it.
    """
    felt = _felt_at_rest(imu)
    if felt is not None and (named := gravity_in_unit(felt)):
        raise ValueError(
            f"specific_force_m_s2: expected about {STANDARD_GRAVITY_M_S2} at rest, got "
            f"{felt:.4g}, {named}"
        )
    return felt


def gravity_in_unit(felt: float) -> str:
    """The unit in which a size is that of gravity, with its mend; "" where it is in none."""
    for size, unit, factor in _GRAVITY_UNITS:
        if abs(felt / size - 1.0) < GRAVITY_SHARE:
            return f"which is gravity in {unit}; multiply by {factor:g}"
    return ""


def refuse_movement(imu: ImuStream) -> None:
    """Refuse a stream of a sensor that did not lie still.

    Means over half seconds are compared with the next. Vibration averages out in them and passes,
    as does what is slower than 0.05 rad/s or 0.3 m/s² in half a second, and turning evenly about
    the vertical, which looks like a bias.

    Raises:
        ValueError: with the largest of the differences, and when it was.
    """
    count = max(2, round(_WINDOW_S * imu.rate_hz))
    for name, values, limit, unit in (
        ("angular rate", imu.angular_rate_rad_s, _TURNS_RAD_S, "rad/s"),
        ("specific force", imu.specific_force_m_s2, _PUSHED_M_S2, "m/s²"),
    ):
        windows = _windows(values, count)
        if len(windows) < 2:
            return
        change = np.linalg.norm(np.diff(np.mean(windows, axis=1), axis=0), axis=-1)
        # White noise: the means differ by √count less than neighbouring samples.
        noise = np.sqrt(np.mean(np.sum(np.diff(windows, axis=1) ** 2, axis=-1)) / count)
        largest = int(np.argmax(change))
        if change[largest] > limit + _NOISE_DEVIATIONS * noise:
            raise ValueError(
                f"imu: expected a sensor at rest, got one that moves: its mean {name} over half a "
                f"second changes by {change[largest]:.3g} {unit} into the next, "
                f"{(largest + 1) * count / imu.rate_hz:.1f} s after its first sample"
            )


def _felt_at_rest(imu: ImuStream) -> float | None:
    """Median size of specific force over quiet windows; None where there are too few."""
    count = max(2, round(_WINDOW_S * imu.rate_hz))
    windows = _windows(imu.specific_force_m_s2, count)
    mean = np.mean(windows, axis=1)
    size = np.linalg.norm(mean, axis=-1)
    scatter = np.sqrt(np.sum(np.var(windows, axis=1), axis=-1))
    quiet = scatter < _QUIET_SHARE * size
    return float(np.median(size[quiet])) if np.sum(quiet) >= _FEWEST_QUIET else None


def _turned_share(imu: ImuStream) -> float | None:
    """How far gravity turns for one unit of the rate; None where the readings do not tell.

    By regression of the change of force on what the rate makes of it, f' = -ω × f.
    """
    count = max(1, round(_TURN_WINDOW_S * imu.rate_hz))
    rate = np.mean(_windows(imu.angular_rate_rad_s, count), axis=1)
    force = np.mean(_windows(imu.specific_force_m_s2, count), axis=1)
    if len(rate) < _FEWEST_TURNS:
        return None
    change = np.diff(force, axis=0) * imu.rate_hz / count
    explained = -np.cross(0.5 * (rate[1:] + rate[:-1]), 0.5 * (force[1:] + force[:-1]))
    moment = float(np.sum(change * explained))
    power = float(np.sum(explained**2))
    chance = np.sqrt(power * float(np.sum(change**2)) / len(change))
    if power == 0.0 or moment < _TURN_DEVIATIONS * chance:
        return None
    return moment / power


def _gravity(felt: float | None) -> tuple[str, ...]:
    if felt is None or abs(felt / STANDARD_GRAVITY_M_S2 - 1.0) < GRAVITY_SHARE:
        return ()
    expected = f"expected about {STANDARD_GRAVITY_M_S2}"
    return (f"the accelerometer reads {felt:.4g} m/s² at rest, {expected}",)


def saturated_axes(imu: ImuStream) -> tuple[str, ...]:
    """A line for each axis that repeats its largest reading far more often than any other near it.

    A peak of the motion repeats its last digit as well, but so it does the digits just below: that
    of a parabola 2.4 times as often as the next, the flattest of fourth order 5.3 times.
    """
    lines = []
    for name, values in (
        ("angular rate", imu.angular_rate_rad_s),
        ("specific force", imu.specific_force_m_s2),
    ):
        for axis, column in zip("xyz", values.T, strict=True):
            for limit in (float(np.max(column)), float(np.min(column))):
                stuck = _stuck(column, limit)
                if stuck:
                    lines.append(
                        f"{name} {axis} reads exactly {limit:.6g} in {stuck} samples, as if "
                        "saturated; what moved faster is lost"
                    )
    return tuple(lines)


def _stuck(column: FloatArray, limit: float) -> int:
    """How many samples stick to a limit; 0 where they do not look saturated."""
    at = column == limit
    count = int(np.sum(at))
    coarse = len(np.unique(column)) < 50
    if count < 5 or coarse or 2 * count > column.size or abs(limit) < 0.5 * np.max(np.abs(column)):
        return 0
    runs = at[2:] & at[1:-1] & at[:-2]
    near = column[(np.abs(column - limit) < 0.05 * np.ptp(column)) & ~at]
    usual = int(np.max(np.unique(near, return_counts=True)[1], initial=1))
    return count if np.any(runs) and count > _REPEATED * usual else 0


def _gaps(imu: ImuStream) -> tuple[str, ...]:
    steps = np.diff(imu.time_ns)
    gaps = np.flatnonzero(steps > _GAP_MEDIANS * np.median(steps))
    if not gaps.size:
        return ()
    longest = gaps[np.argmax(steps[gaps])]
    return (
        f"{gaps.size} gap{'s' if gaps.size > 1 else ''} in the samples, the longest of "
        f"{steps[longest] * 1e-9:.4f} s after {int(imu.time_ns[longest])} ns",
    )


def _windows(values: FloatArray, count: int) -> FloatArray:
    """Values ``(N, 3)`` cut into ``(N // count, count, 3)``."""
    whole = len(values) // count
    return values[: whole * count].reshape(whole, count, 3)
