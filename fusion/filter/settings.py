"""What the filter assumes beyond its data, and the compiled filter that is made from it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from motorcade.fusion.filter.native import _filter
from motorcade.fusion.imu.noise import (
    ACCEL_BIAS_SIGMA_M_S2,
    GYRO_BIAS_SIGMA_RAD_S,
    ImuNoise,
)
from motorcade.ga import Motor
from motorcade.ga.arrays import checked_positive
from motorcade.ga.stamps import checked_span_ns

# Wide on purpose: the error's dynamics do not depend on the velocity, so that costs nothing.
VELOCITY_SIGMA_M_S = 20.0
# A measurement beyond the gate is given more noise, as much as brings it there. One that would need
# more than so many times its stated variance, three times its deviation, is wrong.
MOST_NOISE = 10.0
_MOST_FREEDOM = 8
_CHECK_EVERY = 32


@dataclass(frozen=True)
class RestDetection:
    """When the sensor is taken to rest, so that its velocity is measured as zero.

    Over `window_s` the rate less its bias and the force's size less gravity stay within the limits
    on the mean, and every sample within them of its mean. A sensor that moves on evenly, as in a
    car on a straight road, looks the same: leave this off where that can happen.

    Fields:
        window_s: length of the window.
        rate_rad_s, force_m_s2: the limits.
        sigma_m_s: deviation of the velocity that is measured, an axis.
        period_s: time between two such measurements.

    Raises:
        ValueError: a number that is not above zero.

    Examples:
        >>> from motorcade.fusion.filter import FilterSettings
        >>> from motorcade.fusion.filter.settings import RestDetection
        >>> FilterSettings(rest=RestDetection(window_s=1.0)).rest.window_s
        1.0
    """

    window_s: float = 0.5
    rate_rad_s: float = 0.05
    force_m_s2: float = 0.5
    sigma_m_s: float = 0.01
    period_s: float = 0.1

    def __post_init__(self) -> None:
        for field in fields(self):
            checked_positive(getattr(self, field.name), f"RestDetection.{field.name}")


@dataclass(frozen=True)
class FilterSettings:
    """What the filter assumes beyond its data.

    Fields:
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        gate: probability that a good measurement passes the χ² test (1 switches it off). One
            beyond it is weighed down so that its pull stays that of one at the gate; one that ten
            times its noise would not bring within it is refused.
        initial_tilt_error_rad: turn the first orientation by this much about the world's x, and
            start with that uncertainty, to watch the filter converge.
        gravity_sigma_rad: how far the world's z may be from up, about x and about y; above zero,
            the direction of gravity is estimated.
        extrinsics_sigma_rad, extrinsics_sigma_m: how far the camera's pose on the IMU may be off,
            an axis; above zero, it is estimated.
        time_offset_sigma_s: the same of what is added to a camera's stamps to be the IMU's time.
        gap_s: where samples stand farther apart than this, data are missing.
        gap_rate_rad_s, gap_force_m_s2: deviation, an axis, of what was not felt there from the
            line between the samples on both sides.
        rest: when to measure a velocity of zero; None: never.

    Raises:
        ValueError: a number that is out of range, named by its field.

    Examples:
        >>> from motorcade.fusion import FilterSettings
        >>> FilterSettings(gravity_sigma_rad=0.02, extrinsics_sigma_rad=0.01).error_size
        24
        >>> FilterSettings(gap_s=0.0)
        Traceback (most recent call last):
        ...
        ValueError: FilterSettings.gap_s: expected a number above 0, got 0.0
    """

    gravity_m_s2: float = 9.81
    gate: float = 0.9999
    initial_tilt_error_rad: float = 0.0
    gravity_sigma_rad: float = 0.0
    extrinsics_sigma_rad: float = 0.0
    extrinsics_sigma_m: float = 0.0
    time_offset_sigma_s: float = 0.0
    gap_s: float = 0.1
    gap_rate_rad_s: float = 1.0
    gap_force_m_s2: float = 3.0
    rest: RestDetection | None = None

    def __post_init__(self) -> None:
        checked_span_ns(self.gap_s, "FilterSettings.gap_s")
        positive = ("gravity_m_s2", "gap_s")
        not_negative = (
            "gravity_sigma_rad",
            "extrinsics_sigma_rad",
            "extrinsics_sigma_m",
            "time_offset_sigma_s",
            "gap_rate_rad_s",
            "gap_force_m_s2",
        )
        for name, good, expected in (
            *((name, 0.0 < getattr(self, name) < np.inf, "a number above 0") for name in positive),
            *((n, 0.0 <= getattr(self, n) < np.inf, "a number from 0 on") for n in not_negative),
            ("gate", 0.0 < self.gate <= 1.0, "a probability above 0 and up to 1"),
            ("initial_tilt_error_rad", np.isfinite(self.initial_tilt_error_rad), "a finite angle"),
        ):
            if not good:
                raise ValueError(
                    f"FilterSettings.{name}: expected {expected}, got {getattr(self, name)}"
                )

    @property
    def known_sigmas(self) -> tuple[float, float, float, float]:
        """Deviations of what most runs know: gravity, extrinsics' turn and place, offset."""
        return (
            self.gravity_sigma_rad,
            self.extrinsics_sigma_rad,
            self.extrinsics_sigma_m,
            self.time_offset_sigma_s,
        )

    @property
    def error_size(self) -> int:
        """Numbers in the filter's error: 15, and 24 where more than the motion is estimated."""
        return 24 if any(self.known_sigmas) else 15

    def gate_limit(self, freedom: int) -> float:
        """The χ² with so many degrees of freedom that a good measurement stays below.

        Examples:
            >>> from motorcade.fusion.filter import FilterSettings
            >>> round(FilterSettings(gate=0.99).gate_limit(6), 2)
            16.81
        """
        return _chi2_quantile(self.gate, freedom)


def _chi2_quantile(probability: float, freedom: int) -> float:
    from scipy.special import gammaincinv

    # χ² with n degrees of freedom is a gamma distribution of shape n/2 and scale 2.
    return float(2.0 * gammaincinv(freedom / 2.0, probability))


def engine(
    settings: FilterSettings,
    noise: ImuNoise,
    imu_T_camera: Motor,
    time_offset_s: float = 0.0,
    history_s: float | None = None,
    keeps_earlier: bool = False,
    lag_s: float = 0.0,
) -> _filter.Engine:
    """The compiled filter; without `history_s` it keeps all, for the backward pass.

    With `lag_s` above zero it settles what so much time has passed by, see `window.h`.

    With `keeps_earlier` its error has six numbers more, for measurements that relate two moments.
    """
    rest = settings.rest
    return _filter.engine(
        model=(
            settings.gravity_m_s2,
            noise.gyro_density_rad_s_rthz,
            noise.gyro_walk_rad_s2_rthz,
            noise.accel_density_m_s2_rthz,
            noise.accel_walk_m_s3_rthz,
        ),
        start=(
            0.0,
            0.0,
            VELOCITY_SIGMA_M_S,
            GYRO_BIAS_SIGMA_RAD_S,
            ACCEL_BIAS_SIGMA_M_S2,
            settings.initial_tilt_error_rad,
        ),
        known=settings.known_sigmas,
        gate=(0.0, *(settings.gate_limit(n) for n in range(1, _MOST_FREEDOM + 1))),
        middle=(0.0, *(_chi2_quantile(0.5, n) for n in range(1, _MOST_FREEDOM + 1))),
        most_noise=MOST_NOISE,
        gap=(settings.gap_s, settings.gap_rate_rad_s, settings.gap_force_m_s2),
        history_s=np.inf if history_s is None else history_s,
        lag_s=lag_s,
        check_every=0 if history_s is None else _CHECK_EVERY,
        imu_T_camera=tuple(imu_T_camera.coefficients),
        delay_s=time_offset_s,
        rest=(0.0,) * 5
        if rest is None
        else (rest.window_s, rest.rate_rad_s, rest.force_m_s2, rest.sigma_m_s, rest.period_s),
        keeps_earlier=keeps_earlier,
    )
