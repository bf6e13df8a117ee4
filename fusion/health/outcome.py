"""What became of a fusion, besides what its inputs say: refused poses, biases beyond belief."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.verdict import Health, HealthFinding
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S
from motorcade.ga.arrays import FloatArray

# Where more is refused than accepted, what was accepted is no more than an opinion.
_MOST_REFUSED = 0.5
_BEYOND = 4.0  # deviations of what is known of a bias


def with_outcome(
    health: Health,
    accepted: NDArray[np.bool_],
    gyro_bias_rad_s: FloatArray,
    accel_bias_m_s2: FloatArray,
) -> Health:
    """The verdict with what the estimate shows, where nothing that explains it was found.

    Args:
        health: what inputs showed.
        accepted: ``(M,)`` of the measured poses.
        gyro_bias_rad_s: ``(N, 3)`` as estimated.
        accel_bias_m_s2: the same.
    """
    if health.findings:
        return health
    found = []
    refused = int(np.count_nonzero(~accepted))
    if refused > _MOST_REFUSED * len(accepted):
        line = (
            f"{refused} of {len(accepted)} poses were refused: check their covariances and the "
            "IMU's noise densities"
        )
        found.append(HealthFinding("measurements_refused", line))
    gyro, accel = (
        float(np.median(np.linalg.norm(bias, axis=-1)))
        for bias in (gyro_bias_rad_s, accel_bias_m_s2)
    )
    if gyro > _BEYOND * GYRO_BIAS_SIGMA_RAD_S:
        line = (
            f"the gyroscope's bias came out as {gyro:.2g} rad/s, where {GYRO_BIAS_SIGMA_RAD_S:g} "
            "are usual: check its unit, the extrinsics and the stamps"
        )
        found.append(HealthFinding("rate_bias", line))
    if accel > _BEYOND * ACCEL_BIAS_SIGMA_M_S2:
        line = (
            f"the accelerometer's bias came out as {accel:.2g} m/s², where "
            f"{ACCEL_BIAS_SIGMA_M_S2:g} are usual: check its unit, gravity and the extrinsics"
        )
        found.append(HealthFinding("force_bias", line))
    return Health(tuple(found), health.unknown)
