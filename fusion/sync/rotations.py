"""The time offset by orientations alone, and an uncertainty that believes little.

Orientations that the gyroscope sums up, and those that the camera measured, run apart where the
clocks do: by the offset times the angular rate. Positions and forces would tell the offset too, but
an accelerometer's scale, axes and vibration, and poses whose positions come later than their
orientations, move it by far more than they claim: by 3 to 5 ms on EuRoC's flights MH_05 and V1_01.

The recording is cut into blocks. Within each, what the gyroscope drifts is free: a constant, a rate
and its change, of which no more is asked than that a bias does not turn within seconds. So nothing
but what happens within a block tells, and blocks that contradict each other show how wrong the
model is: errors of a path that last for seconds, a gyroscope's scale and axes. The deviation is
the larger of what the residuals' size and what the blocks' scatter say.

Source: J. MacKinnon and H. White, Some heteroskedasticity-consistent covariance matrix estimators
with improved finite sample properties, Journal of Econometrics 29(3), 1985: the jackknife, here
over blocks, within which everything may correlate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration import preintegrate
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# A hand or a vehicle turns to and fro within a second or two, so that most of its rates remain; a
# MEMS gyroscope's bias changes over minutes.
_BLOCK_S = 4.0
_DRIFT = 3  # unknowns an axis: constant, rate, change of it
_FEWEST = 8  # poses a block: more than twice its unknowns an axis
_FEWEST_BLOCKS = 5  # below, their scatter says nothing of itself
_ITERATIONS = 20
_SETTLED_S = 1e-6
_LARGEST_STEP_S = 0.02
_CAUCHY = 11.3  # χ² with three degrees of freedom exceeds it in one of a hundred orientations
_MEDIAN_CHI2 = 2.366  # its median
_HELD = 1e-9  # of the information: an axis about which nothing turns stays where it is
_RATE_S = 0.02  # over which the rate is taken
_SILENT = ImuNoise(1e-9, 1e-9, 1e-9, 1e-9)  # covariances are not asked


@dataclass(frozen=True, eq=False)
class RotationOffset:
    """What orientations tell.

    Fields:
        offset_s: IMU's clock minus the camera's.
        sigma_s: deviation of it.
        white_s: the same, if all errors were independent of each other.
    """

    offset_s: float
    sigma_s: float
    white_s: float


def offset_by_rotations(
    camera: Trajectory,
    imu: ImuStream,
    offset_s: float,
    imu_R_camera: Rotor,
    gyro_bias_rad_s: FloatArray,
) -> RotationOffset | None:
    """The offset near one that is known to some milliseconds; None where no block has poses enough.

    Args:
        camera: measured poses, which the IMU covers with room to shift.
        imu: the stream.
        offset_s: where to start.
        imu_R_camera: the extrinsics' rotation, to a few degrees.
        gyro_bias_rad_s: ``(3,)`` to some hundredths.
    """
    blocks = _blocks(camera.time_ns)
    if not blocks:
        return None
    weights = [np.ones(len(block)) for block in blocks]
    for _ in range(_ITERATIONS):
        steps, rate = _gyroscope(imu, camera.time_ns + round(offset_s * 1e9), gyro_bias_rad_s)
        measured = (camera.motors.rotor @ imu_R_camera.inverse()).as_matrix()
        rows = [
            (*_rows(camera.time_ns[k], measured[k], steps[k[:-1]], rate[k], weight), weight)
            for k, weight in zip(blocks, weights, strict=True)
        ]
        step, white_s, scattered_s, weights = _solved(rows)
        step_s = float(np.clip(step[0], -_LARGEST_STEP_S, _LARGEST_STEP_S))
        offset_s += step_s
        imu_R_camera = Rotor.from_rotation_vector(step[1:]) @ imu_R_camera
        if abs(step_s) < _SETTLED_S:
            break
    return RotationOffset(offset_s, max(white_s, scattered_s), white_s)


def _blocks(time_ns: IntArray) -> list[IntArray]:
    """Rows of poses that belong together."""
    number = (time_ns - time_ns[0]) // round(_BLOCK_S * 1e9)
    blocks = np.split(np.arange(len(time_ns)), np.flatnonzero(np.diff(number)) + 1)
    return [rows for rows in blocks if len(rows) >= _FEWEST]


def _rows(
    stamps: IntArray,
    measured: FloatArray,
    steps: FloatArray,
    rate: FloatArray,
    weight: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """What a block of N poses tells, less what its drift explains.

    Residuals ``(N, 3)``, rad from the gyroscope's orientations to the measured ones, and how they
    fall with the offset and the extrinsics' rotation ``(N, 3, 4)``.
    """
    block_R_imu = _chained(steps)
    apart = measured @ block_R_imu.swapaxes(-1, -2)
    u, _, vt = np.linalg.svd(np.einsum("n,nij->ij", weight, apart))
    mean = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    left = Rotor.from_matrix(mean.T @ apart).as_rotation_vector()
    columns = left[..., None], block_R_imu @ rate[..., None], block_R_imu
    values = np.concatenate(columns, axis=-1).reshape(len(stamps), -1)
    drift = _drift(stamps)
    weighted = drift.T * weight
    fitted = drift @ np.linalg.solve(weighted @ drift, weighted @ values)
    free = (values - fitted).reshape(len(stamps), 3, -1)
    return free[..., 0], free[..., 1:]


def _gyroscope(imu: ImuStream, stamps: IntArray, bias: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations ``(N - 1, 3, 3)`` from stamps to the next, and rates ``(N, 3)`` at them."""
    summed = preintegrate(imu, stamps, _SILENT, bias, np.zeros(3))
    half = round(0.5 * _RATE_S * 1e9)
    rates = [imu.at(stamps + shift).angular_rate_rad_s for shift in (-half, 0, half)]
    return summed.motion[:, 0].rotor.as_matrix(), np.mean(rates, axis=0) - bias


def _drift(stamps: IntArray) -> FloatArray:
    """Legendre's polynomials over a block's time ``(N, 3)``."""
    time = 2.0 * (stamps - stamps[0]) / float(np.ptp(stamps)) - 1.0
    return np.polynomial.legendre.legvander(time, _DRIFT - 1)


def _chained(steps: FloatArray) -> FloatArray:
    """Products ``(N + 1, 3, 3)`` of N rotations from the identity on."""
    chained = [np.eye(3)]
    for step in steps:
        chained.append(chained[-1] @ step)
    return np.array(chained)


def _solved(
    rows: list[tuple[FloatArray, FloatArray, FloatArray]],
) -> tuple[FloatArray, float, float, list[FloatArray]]:
    """Least squares over blocks of residuals, slopes and weights.

    The step of offset and rotation; two deviations of the offset, were errors independent and by
    what blocks differ by; new weights.
    """
    matrices = np.array([np.einsum("n,nij,nik->jk", w, a, a) for _, a, w in rows])
    total = np.sum(matrices, axis=0)
    total += np.diag([0.0, *[_HELD * float(np.trace(total))] * 3])
    inverse = np.linalg.inv(total)
    step = inverse @ np.sum([np.einsum("n,nij,ni->j", w, a, r) for r, a, w in rows], axis=0)
    left = [r - a @ step for r, a, _ in rows]
    squares = [np.sum(residuals**2, axis=-1) for residuals in left]
    together = np.concatenate(squares)
    # Of N poses, a block's drift takes three.
    kept = 1.0 - _DRIFT * len(rows) / len(together)
    scale = max(float(np.median(together)) / _MEDIAN_CHI2 / kept, np.finfo(float).tiny)
    scores = np.array(
        [np.einsum("n,nij,ni->j", w, a, e) for (_, a, w), e in zip(rows, left, strict=True)]
    )
    return (
        step,
        float(np.sqrt(scale * inverse[0, 0])),
        _jackknife(total, matrices, scores),
        [1.0 / (1.0 + square / (_CAUCHY * scale)) for square in squares],
    )


def _jackknife(total: FloatArray, matrices: FloatArray, scores: FloatArray) -> float:
    """Deviation of the offset by leaving out each block in turn; 0 where that leaves too few."""
    count = len(scores)
    if count < _FEWEST_BLOCKS:
        return 0.0
    moved = np.linalg.solve(total - matrices, scores[..., None])[:, 0, 0]
    return float(np.sqrt((count - 1.0) / count * np.sum(moved**2)))
