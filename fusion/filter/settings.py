"""What the filter assumes beyond its data, and the compiled filter that is made from it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from motorcade.fusion.filter.native import _filter
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.ga import Motor

__all__ = ["FilterSettings", "RestDetection", "engine"]

_GYRO_BIAS_SIGMA_RAD_S = 0.1
_ACCEL_BIAS_SIGMA_M_S2 = 0.5
# Wide on purpose: the error's dynamics do not depend on the velocity, so it costs nothing.
_VELOCITY_SIGMA_M_S = 20.0
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
    """

    window_s: float = 0.5
    rate_rad_s: float = 0.05
    force_m_s2: float = 0.5
    sigma_m_s: float = 0.01
    period_s: float = 0.1

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(
                    f"RestDetection.{field.name}: expected a number above 0, got {value}"
                )


@dataclass(frozen=True)
class FilterSettings:
    """What the filter assumes beyond its data.

    Fields:
        gravity_m_s2: size of gravity, which pulls along -z of the world.
        gate: probability that a good measurement passes the χ² test (1 switches it off). One
            beyond it is weighed down so that its pull stays that of one at the gate, and one that
            is `gross` gates away is left out.
        gross: gates beyond which a measurement is left out; 1 weighs none down.
        patience: after so many left out in a row the filter asks whether they would agree with
            each other had the prediction been given up at the first of them: its covariance
            widened by that one's innovation. If most pass the gate then, it is given up there.
        initial_tilt_error_rad: turn the first orientation by this much about the world's x, and
            start with that uncertainty, to watch the filter converge.
        gravity_sigma_rad: how far the world's z may be from up, about x and about y; above zero,
            the direction of gravity is estimated.
        mount_sigma_rad, mount_sigma_m: how far the camera's pose on the IMU may be off, an axis;
            above zero, it is estimated.
        time_offset_sigma_s: the same of what is added to a camera's stamps to be the IMU's time.
        hole_s: where samples stand farther apart than this, data are missing.
        hole_rate_rad_s, hole_force_m_s2: deviation, an axis, of what was not felt there from the
            line between the samples on both sides.
        rest: when to measure a velocity of zero; None: never.

    Raises:
        ValueError: a number that is out of range, named by its field.
    """

    gravity_m_s2: float = 9.81
    gate: float = 0.9999
    gross: float = 10.0
    patience: int = 5
    initial_tilt_error_rad: float = 0.0
    gravity_sigma_rad: float = 0.0
    mount_sigma_rad: float = 0.0
    mount_sigma_m: float = 0.0
    time_offset_sigma_s: float = 0.0
    hole_s: float = 0.1
    hole_rate_rad_s: float = 1.0
    hole_force_m_s2: float = 3.0
    rest: RestDetection | None = None

    def __post_init__(self) -> None:
        positive = ("gravity_m_s2", "hole_s")
        not_negative = (
            "gravity_sigma_rad", "mount_sigma_rad", "mount_sigma_m", "time_offset_sigma_s",
            "hole_rate_rad_s", "hole_force_m_s2",
        )  # fmt: skip
        for name, good, expected in (
            *((name, 0.0 < getattr(self, name) < np.inf, "a number above 0") for name in positive),
            *((n, 0.0 <= getattr(self, n) < np.inf, "a number from 0 on") for n in not_negative),
            ("gate", 0.0 < self.gate <= 1.0, "a probability above 0 and up to 1"),
            ("gross", 1.0 <= self.gross < np.inf, "a number from 1 on"),
            ("patience", self.patience >= 2, "a whole number from 2 on"),
            ("initial_tilt_error_rad", np.isfinite(self.initial_tilt_error_rad), "a finite angle"),
        ):
            if not good:
                raise ValueError(
                    f"FilterSettings.{name}: expected {expected}, got {getattr(self, name)}"
                )

    @property
    def known_sigmas(self) -> tuple[float, float, float, float]:
        """Deviations of what most runs know: gravity, the mount's turn and place, the offset."""
        return (
            self.gravity_sigma_rad, self.mount_sigma_rad, self.mount_sigma_m,
            self.time_offset_sigma_s,
        )  # fmt: skip

    @property
    def error_size(self) -> int:
        """Numbers in the filter's error: 15, and 24 where more than the motion is estimated."""
        return 24 if any(self.known_sigmas) else 15


def engine(
    settings: FilterSettings,
    noise: ImuNoise,
    imu_T_camera: Motor,
    time_offset_s: float = 0.0,
    history_s: float | None = None,
) -> _filter.Engine:
    """The compiled filter; without `history_s` it keeps all, for the backward pass."""
    rest = settings.rest
    return _filter.engine(
        model=(
            settings.gravity_m_s2, noise.gyro_density_rad_s_rthz, noise.gyro_walk_rad_s2_rthz,
            noise.accel_density_m_s2_rthz, noise.accel_walk_m_s3_rthz,
        ),
        start=(
            0.0, 0.0, _VELOCITY_SIGMA_M_S, _GYRO_BIAS_SIGMA_RAD_S, _ACCEL_BIAS_SIGMA_M_S2,
            settings.initial_tilt_error_rad,
        ),
        known=settings.known_sigmas,
        gate=_limits(settings.gate),
        gross=settings.gross,
        patience=settings.patience,
        hole=(settings.hole_s, settings.hole_rate_rad_s, settings.hole_force_m_s2),
        history_s=np.inf if history_s is None else history_s,
        check_every=0 if history_s is None else _CHECK_EVERY,
        mount=tuple(imu_T_camera.coefficients),
        delay_s=time_offset_s,
        rest=(0.0,) * 5
        if rest is None
        else (rest.window_s, rest.rate_rad_s, rest.force_m_s2, rest.sigma_m_s, rest.period_s),
    )  # fmt: skip


def _limits(gate: float) -> tuple[float, ...]:
    """χ² that a good measurement stays below, for 0 to 8 degrees of freedom."""
    from scipy.special import gammaincinv

    # χ² with n degrees of freedom is a gamma distribution of shape n/2 and scale 2.
    freedoms = np.arange(1, _MOST_FREEDOM + 1)
    return (0.0, *(2.0 * gammaincinv(freedoms / 2.0, gate)).tolist())
