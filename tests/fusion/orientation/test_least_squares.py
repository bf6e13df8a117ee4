"""The pass backwards against one dense least-squares problem of the same model, solved by numpy.

Near the identity the model is linear: tilt turns with rate less bias, velocity with force and tilt.
Every sample is then an interval of its own, every assumption of the model one weighted row.
"""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.imu import ImuNoise, ImuStream
from motorcade.fusion.orientation import OrientationModel, estimate_orientation
from motorcade.ga.arrays import FloatArray

STEP_S, GAP_S, COUNT, GRAVITY = 0.01, 0.5, 50, 9.81
NOISE = ImuNoise(3e-3, 2e-3, 5e-2, 1e-3)
MODEL = OrientationModel(
    noise=NOISE,
    gyro_wander_sqrt_rad=1e-9,
    gyro_matrix_deviation=1e-9,
    first_tilt_rad=0.05,
    interval_s=0.9 * STEP_S,
    rest_after_s=1e9,
    speed_m_s=0.05,
    readings="interval",
)
LEAN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # a small turn's horizontal share of "up"


class Rows:
    """Weighted equations ``a x = y ± deviation`` over 8 unknowns a node: turn, bias, velocity."""

    def __init__(self) -> None:
        self.left: list[FloatArray] = []
        self.right: list[FloatArray] = []

    def add(self, blocks: dict[tuple[int, int], FloatArray], y: FloatArray, sigma: float) -> None:
        size = np.size(y)
        rows = np.zeros((size, 8 * COUNT))
        for (node, first), block in blocks.items():
            start = 8 * node + first
            rows[:, start : start + block.shape[1]] += block
        self.left.append(rows / sigma)
        self.right.append(np.asarray(y) / sigma)

    def solved(self) -> FloatArray:
        left, right = np.concatenate(self.left), np.concatenate(self.right)
        return np.linalg.lstsq(left, right, rcond=None)[0].reshape(COUNT, 8)


def dense_solution(rate: FloatArray, force: FloatArray, hole: int | None) -> FloatArray:
    rows, eye3, eye2 = Rows(), np.eye(3), np.eye(2)
    first = np.array([force[0, 1], -force[0, 0]]) / GRAVITY
    rows.add({(0, 0): eye3[:2]}, first, MODEL.first_tilt_rad)
    rows.add({(0, 2): np.eye(1)}, np.zeros(1), 1e-7)
    rows.add({(0, 3): eye3}, np.zeros(3), MODEL.first_bias_rad_s)
    rows.add({(0, 6): eye2}, np.zeros(2), MODEL.speed_m_s)
    kept = np.exp(-STEP_S / MODEL.speed_time_s)
    white = NOISE.accel_density_m_s2_rthz * np.sqrt(STEP_S)
    unknown = np.hypot(MODEL.speed_m_s * np.sqrt(1.0 - kept**2), white)
    lean = GRAVITY * STEP_S * LEAN
    # readings hold for the middle of their interval, the tilt for its end
    pushes = STEP_S * force[:, :2] - 0.5 * STEP_S * rate @ lean.T
    for k in range(1, COUNT):
        if k == hole:  # no interval ends here: the next one spans the gap
            continue
        last, turn, span, lost = k - 1, STEP_S * rate[k], STEP_S, 0.0
        fresh = k - 1 == hole
        if fresh:
            last, turn, span = k - 2, turn + GAP_S * rate[hole], STEP_S + GAP_S
            lost = GAP_S**2 * (float(rate[hole] @ rate[hole]) + 0.25)
        turned = {(k, 0): eye3, (last, 0): -eye3, (last, 3): span * eye3}
        rows.add(turned, turn, np.sqrt(NOISE.gyro_density_rad_s_rthz**2 * STEP_S + lost))
        wandered = {(k, 3): eye3, (last, 3): -eye3}
        rows.add(wandered, np.zeros(3), NOISE.gyro_walk_rad_s2_rthz * np.sqrt(STEP_S))
        if fresh:
            rows.add({(k, 6): eye2}, np.zeros(2), MODEL.speed_m_s)
        else:
            moved = {(k, 6): eye2, (last, 6): -eye2} | ({(last, 0): -lean} if k > 1 else {})
            rows.add(moved, pushes[last] * (k > 1), white)
        pushed = {(k, 6): (1.0 - kept) * eye2, (k, 0): lean}
        rows.add(pushed, -pushes[k], unknown)
    return rows.solved()


@pytest.mark.parametrize("hole", [None, 30], ids=["even", "gap"])
def test_smoothing_solves_the_least_squares_problem_of_its_model(hole, rng):
    rate = 1e-4 * rng.standard_normal((COUNT, 3))
    force = np.array([0.0, 0.0, GRAVITY]) + 5e-3 * rng.standard_normal((COUNT, 3))
    force[:, 2] = GRAVITY
    stamps = np.arange(COUNT) * round(STEP_S * 1e9)
    if hole is not None:
        stamps[hole:] += round((GAP_S - STEP_S) * 1e9)
    known = [k for k in range(1, COUNT) if k != hole]
    found = estimate_orientation(ImuStream(stamps, rate, force), MODEL)
    wanted = dense_solution(rate, force, hole)
    online = estimate_orientation(ImuStream(stamps, rate, force), MODEL, smooth=False)
    turn = found.world_R_imu.as_rotation_vector()
    scale = np.max(np.abs(wanted[:, :2]))
    np.testing.assert_allclose(turn[known], wanted[known, :3], atol=1e-3 * scale)
    bias_scale = np.max(np.abs(wanted[:, 3:5]))
    np.testing.assert_allclose(
        found.gyro_bias_rad_s[known], wanted[known, 3:6], atol=1e-3 * bias_scale
    )
    # at the end both have seen all; before, the filter alone differs
    np.testing.assert_allclose(online.gyro_bias_rad_s[-1], wanted[-1, 3:6], atol=1e-3 * bias_scale)
    assert np.max(np.abs(online.gyro_bias_rad_s - wanted[:, 3:6])) > 0.1 * bias_scale
