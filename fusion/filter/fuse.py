"""`fuse`: camera poses and an IMU in, one trajectory with its uncertainty out."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.fitting import fit_noise
from motorcade.fusion.filter.fused import Fused
from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.filter.unjudged import fuse_unjudged
from motorcade.fusion.health.check import check_health
from motorcade.fusion.health.verdict import Health, HealthFinding
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S, ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import Measurements
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements

log = logging.getLogger("motorcade.fuse")

# Where more is refused than accepted, what was accepted is no more than an opinion.
_MOST_REFUSED = 0.5
_BEYOND = 4.0  # deviations of what is known of a bias
_KNOWN_TURN_RAD = 0.6
"""A turn to the second order, as the filter has it, is off by a third of its cube: a fourteenth of
a radian here. From there on a Gaussian of an attitude is no longer one of the place that it turns:
with only an altitude after one pose, squared errors of the smoothed path are 0.1 of what is stated
where the attitude is known to 33°, 2 to 5 times it at 50°, 24 times at 75°."""
_EXTRINSICS_AND_OFFSET = slice(17, 24)


def fuse(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    smoothed: bool = True,
    lag_s: float = np.inf,
    time_offset_s: float = 0.0,
    state_covariances: bool = True,
    fits_noise: bool = True,
) -> Fused:
    """Fuse measured camera poses with an IMU, by the code of `PoseFilter`.

    Inertial data are integrated at their full rate. Memory: about 0.3 kB a measurement, 0.9 kB a
    stamp asked for, and 1.8 or 4.6 kB more for its `state_covariance`; what the backward pass needs
    besides is made again, piece by piece. Where the world's z is not up the accelerometer
    contradicts the camera, and the tilt ends up in its bias as far as the motion allows, unless
    `FilterSettings.gravity_sigma_rad` is set.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. A gap in
            it is bridged by the line between the samples on both sides, with the uncertainty that
            `FilterSettings` states; a gap of more than ten seconds splits the stream, and each
            segment is fused for itself: stamps between them are left out.
        noise: the IMU's densities and bias walks. Those of a data sheet are too small for a
            sensor in the hand or in flight: where the recording shows that, densities that fit it
            take their place (`fit_noise`); `learn_noise` finds walks besides, in longer time.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: rising stamps of the IMU's clock at which the path is wanted, measured there or
            not; by default those of the measurements. Stamps before the first measurement or
            outside the IMU's span are left out.
        also: other kinds of measurements (`motorcade.fusion.measurements`), from the first pose on.
            Python predicts each, in about 50 µs, twice where `smoothed`.
        settings: gravity, gate, initial tilt error, what else to estimate.
        smoothed: look ahead as well (backward pass); without it every estimate knows only its
            past, as if it ran live, and `nis` and `accepted` are as judged live.
        lag_s: how far to look ahead at most. With 0 as without `smoothed`; with a recording's
            length or more to its end. Between these every estimate is that of a filter that runs
            live and answers so much later: measurements are weighed by what all others up to then
            say of them, and what was answered is not taken back. A burst of wrong poses, or a map
            that was relocated, is seen through only where it ends, with some poses after it,
            within the lag.
        time_offset_s: what is added to the measurements' stamps to be the IMU's time; a first
            guess where `FilterSettings.time_offset_sigma_s` is above zero.
        state_covariances: without them the result's `state_covariance` has no rows.
        fits_noise: whether densities may be fitted; the result's `noise` says what was used.

    Raises:
        ValueError: the IMU and the measurements do not overlap in time, or `stamps_ns` are no
            rising integers or none of them can be served; samples more than ten seconds apart; an
            offset of more than thirty years; a lag below zero, or without `smoothed`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import evaluate, fuse
        >>> from motorcade.ga import Motor
        >>> fused = fuse(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> for found in (measured.trajectory, fused.trajectory):
        ...     print(f"{evaluate(found, sensor.path).rotation_deg.rmse:.1f}°")
        1.0°
        0.2°
    """
    chosen, lag_s = settings or FilterSettings(), checked_lag(lag_s, smoothed)
    if fits_noise:
        noise = fit_noise(
            measurements, imu, noise, imu_T_camera, settings=chosen, time_offset_s=time_offset_s
        )
    fused = fuse_unjudged(
        measurements,
        imu,
        noise,
        imu_T_camera,
        stamps_ns,
        also=also,
        settings=chosen,
        lag_s=lag_s,
        time_offset_s=time_offset_s,
        state_covariances=state_covariances,
    )
    inputs = measurements.trajectory, imu, imu_T_camera, time_offset_s, chosen
    return replace(fused, health=_fused_health(*inputs, fused), noise=noise)


def checked_lag(lag_s: float, smoothed: bool) -> float:
    """How far to look ahead, in seconds.

    Raises:
        ValueError: a lag that is not a number from zero on, or one without looking ahead.
    """
    if not lag_s >= 0.0:
        raise ValueError(f"lag_s: expected seconds from 0 on, got {lag_s}")
    if not smoothed and 0.0 < lag_s < np.inf:
        raise ValueError(f"lag_s: expected none where nothing looks ahead, got {lag_s}")
    return lag_s if smoothed else 0.0


def _fused_health(
    camera: Trajectory,
    imu: ImuStream,
    imu_T_camera: Motor,
    time_offset_s: float,
    settings: FilterSettings,
    fused: Fused,
) -> Health:
    """Whether inputs agree, then what came of them; it logs what is wrong. See `check_health`."""
    of_inputs = check_health(
        camera,
        imu,
        imu_T_camera,
        time_offset_s=time_offset_s,
        gravity_m_s2=settings.gravity_m_s2,
        lean_sigma_rad=settings.gravity_sigma_rad,
        extrinsics_sigma_rad=settings.extrinsics_sigma_rad,
        time_offset_sigma_s=settings.time_offset_sigma_s,
    )
    covered = _covariance_findings(
        fused.trajectory.time_ns, fused.covariance, fused.state_covariance
    )
    accepted = fused.accepted[np.isfinite(fused.nis)]
    biases = fused.gyro_bias_rad_s, fused.accel_bias_m_s2
    health = _with_outcome(of_inputs, accepted, *biases, covered)
    for finding in health.findings:
        if finding.fault != "deviations_modelled":
            log.warning("%s", finding.summary)
    return health


def _with_outcome(
    health: Health,
    accepted: NDArray[np.bool_],
    gyro_bias_rad_s: FloatArray,
    accel_bias_m_s2: FloatArray,
    covered: list[HealthFinding],
) -> Health:
    """The verdict with what the estimate shows; biases, where nothing that explains them was found,
    and more than half of the measured poses ``(M,)`` refused.
    """
    biases = [] if health.findings else _biases(gyro_bias_rad_s, accel_bias_m_s2)
    findings = [*health.findings, *biases, *covered]
    refused = int(np.count_nonzero(~accepted))
    if refused > _MOST_REFUSED * len(accepted):
        advice = "" if findings else ": check their covariances and the IMU's noise densities"
        line = f"{refused} of {len(accepted)} poses were refused{advice}"
        findings.append(HealthFinding("measurements_refused", line))
    return Health(tuple(findings), health.unknown)


def _biases(gyro_bias_rad_s: FloatArray, accel_bias_m_s2: FloatArray) -> list[HealthFinding]:
    findings = []
    gyro, accel = (
        float(np.median(np.linalg.norm(bias, axis=-1)))
        for bias in (gyro_bias_rad_s, accel_bias_m_s2)
    )
    if gyro > _BEYOND * GYRO_BIAS_SIGMA_RAD_S:
        line = (
            f"the gyroscope's bias came out as {gyro:.2g} rad/s, where {GYRO_BIAS_SIGMA_RAD_S:g} "
            "are usual: check its unit, the extrinsics and the stamps"
        )
        findings.append(HealthFinding("rate_bias", line))
    if accel > _BEYOND * ACCEL_BIAS_SIGMA_M_S2:
        line = (
            f"the accelerometer's bias came out as {accel:.2g} m/s², where "
            f"{ACCEL_BIAS_SIGMA_M_S2:g} are usual: check its unit, gravity and the extrinsics"
        )
        findings.append(HealthFinding("force_bias", line))
    return findings


def _covariance_findings(
    time_ns: IntArray, covariance: FloatArray, state_covariance: FloatArray
) -> list[HealthFinding]:
    """What covariances of a path's poses and states, where there are some, do not cover."""
    findings = []
    variances = np.einsum("nii->ni", covariance[:, :3, :3])
    turn_rad = np.sqrt(variances.max(axis=1, initial=0.0))
    lost = np.flatnonzero(turn_rad > _KNOWN_TURN_RAD)
    if lost.size:
        first_s, last_s = (time_ns[lost[[0, -1]]] - time_ns[0]) * 1e-9
        line = (
            f"from {first_s:.1f} to {last_s:.1f} s the attitude is known to "
            f"{np.rad2deg(turn_rad.max()):.0f}° only: poses and covariances cannot be relied on "
            "there, nor before where they look ahead; measure poses or directions too"
        )
        findings.append(HealthFinding("attitude_unknown", line))
    estimated = np.einsum("nii->ni", state_covariance)[:, _EXTRINSICS_AND_OFFSET]
    if np.any(estimated > 0.0):
        line = (
            "deviations of extrinsics and offset hold for a sensor that errs by noise and biases "
            "alone: on recorded flights squared errors were 4 to 79 times theirs; those of "
            "synchronise cover axes and clocks that differ"
        )
        findings.append(HealthFinding("deviations_modelled", line))
    return findings
