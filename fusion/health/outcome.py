"""What became of a fusion, besides what its inputs say: refused poses, biases, unknown turns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.verdict import Health, HealthFinding
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S
from motorcade.ga.arrays import FloatArray, IntArray

# Where more is refused than accepted, what was accepted is no more than an opinion.
_MOST_REFUSED = 0.5
_BEYOND = 4.0  # deviations of what is known of a bias
_KNOWN_TURN_RAD = 0.6
"""A turn to the second order, as the filter has it, is off by a third of its cube: a fourteenth of
a radian here. From there on a Gaussian of an attitude is no longer one of the place that it turns:
with only an altitude after one pose, squared errors of the smoothed path are 0.1 of what is stated
where the attitude is known to 33°, 2 to 5 times it at 50°, 24 times at 75°."""
_EXTRINSICS_AND_OFFSET = slice(17, 24)


def with_outcome(
    health: Health,
    accepted: NDArray[np.bool_],
    gyro_bias_rad_s: FloatArray,
    accel_bias_m_s2: FloatArray,
    covered: list[HealthFinding],
) -> Health:
    """The verdict with what the estimate shows; biases, where nothing that explains them was found.

    Args:
        health: what inputs showed.
        accepted: ``(M,)`` of the measured poses.
        gyro_bias_rad_s: ``(N, 3)`` as estimated.
        accel_bias_m_s2: the same.
        covered: what `covariance_findings` says.
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


def covariance_findings(
    time_ns: IntArray, covariance: FloatArray, state_covariance: FloatArray
) -> list[HealthFinding]:
    """What a path's covariances do not cover.

    Args:
        time_ns: ``(N,)``.
        covariance: ``(N, 6, 6)`` of the poses.
        state_covariance: ``(N, M, M)`` of the states, or no rows.
    """
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
