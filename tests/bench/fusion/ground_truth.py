"""How far the ground truth of recorded flights contradicts their IMU, by no filter of ours.

`python -m tests.bench.fusion.ground_truth --seeds 3`. Two witnesses, by NumPy and SciPy alone, from
ground truth and readings, without simulated poses:

- the vertical: over two seconds and a half, what positions bend is what the accelerometer felt,
  turned by the ground truth's orientations, plus gravity. Gravity is free as a vector, with a bias
  and a turn of the accelerometer; its angle from the world's z is how far the ground truth leans;
- the axes: turns of gyroscope and ground truth over 0.3 s, the rotation between them free.

Deviations are those of a jackknife over blocks of ten seconds. Then NEES/6 of the smoothed path, by
default settings, which believe world and axes: with the ground truth as it is, and set right by
these five angles. What that takes off was the ground truth's (or its axes against the IMU's).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation, Slerp

from motorcade.fusion.filter import fuse
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from tests.bench.fusion.offsets import summed_turns
from tests.bench.fusion.recorded import (
    BLACKOUTS,
    NOISE,
    Flight,
    flights_asked_for,
    measured,
    nees,
)

__all__ = ["GroundTruthFaults", "found_faults", "set_right", "smoothed_nees"]

_BEND_S = 2.5
_TURN_S = 0.3
_STEP_S = 0.05
_BLOCK_S = 10.0


@dataclass(frozen=True, eq=False)
class GroundTruthFaults:
    """What the two witnesses say, with deviations.

    Fields:
        lean_rad: ``(2,)`` rotation vector, about x and y, that sets the world upright.
        axes_rad: ``(3,)`` rotation vector of the ground truth's axes in the gyroscope's.
        lean_sigma_rad, axes_sigma_rad: of their lengths.
    """

    lean_rad: FloatArray
    axes_rad: FloatArray
    lean_sigma_rad: float
    axes_sigma_rad: float


def found_faults(one: Flight) -> GroundTruthFaults:
    """Both witnesses on one flight."""
    lean, lean_sigma = _jackknifed(*_bends(one), _lean)
    axes, axes_sigma = _jackknifed(*_turns(one), _axes)
    return GroundTruthFaults(lean, axes, lean_sigma, axes_sigma)


def _bends(one: Flight) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Starts of windows; rows of what positions bend; what gravity, bias and turn add to that."""
    zero = one.truth.time_ns[0]
    time_s, at_s = ((given - zero) * 1e-9 for given in (one.imu.time_ns, one.truth.time_ns))
    grid = np.arange(0.0, min(at_s[-1], time_s[-1]), _STEP_S / 10.0)
    held = Slerp(at_s, Rotation.from_matrix(one.truth.motors.rotor.as_matrix()))
    turned = held(grid).as_matrix()
    force = _interpolated(grid, time_s, one.imu.specific_force_m_s2)
    placed = _interpolated(grid, at_s, one.truth.motors.translation_m)
    # Of R (f - b + θ × f): by gravity, by the bias and by the turn.
    skew = np.cross(force[:, None, :], np.eye(3)).swapaxes(1, 2)
    columns = np.concatenate([turned @ force[:, :, None], turned, turned @ skew], axis=2)
    half = round(0.5 * _BEND_S / (_STEP_S / 10.0))
    step_s = grid[1] - grid[0]
    weights = (half - np.abs(np.arange(-half, half + 1))) * step_s**2
    first = np.arange(0, len(grid) - 2 * half, 10)
    bent = placed[first + 2 * half] - 2.0 * placed[first + half] + placed[first]
    sums = np.stack([np.einsum("k,kij->ij", weights, columns[a : a + 2 * half + 1]) for a in first])
    gravity = np.broadcast_to(np.eye(3) * weights.sum(), (len(first), 3, 3))
    rows = np.concatenate([gravity, -sums[:, :, 1:4], sums[:, :, 4:]], axis=2)
    return grid[first], (bent - sums[:, :, 0]) / weights.sum(), rows / weights.sum()


def _lean(left: FloatArray, rows: FloatArray) -> FloatArray:
    found = _robust(lambda x: rows @ x - left, np.array([0.0, 0.0, -9.8] + [0.0] * 6))
    up = -found[:3] / np.linalg.norm(found[:3])
    # The least turn that brings this to z.
    return np.array([up[1], -up[0]])


def _turns(one: Flight) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Starts of spans; turns of the ground truth and of the gyroscope, rad/s."""
    zero = one.imu.time_ns[0]
    time_s, at_s = ((given - zero) * 1e-9 for given in (one.imu.time_ns, one.truth.time_ns))
    first = np.arange(max(at_s[0], 0.0), min(at_s[-1], time_s[-1]) - _TURN_S, _STEP_S)
    held = Slerp(at_s, Rotation.from_matrix(one.truth.motors.rotor.as_matrix()))
    middle = np.median(one.imu.angular_rate_rad_s, axis=0)  # turns of a bias hardly mix with others
    read = summed_turns(time_s, one.imu.angular_rate_rad_s - middle)
    pair = [(way(first).inv() * way(first + _TURN_S)).as_rotvec() / _TURN_S for way in (held, read)]
    return first, pair[0], pair[1] + middle


def _axes(turned: FloatArray, read: FloatArray) -> FloatArray:
    def left(x: FloatArray) -> FloatArray:
        made: FloatArray = Rotation.from_rotvec(x[:3]).apply(turned) - read - x[3:]
        return made

    return _robust(left, np.zeros(6))[:3]


def _robust(left: Callable[[FloatArray], FloatArray], start: FloatArray) -> FloatArray:
    def flat(x: FloatArray) -> FloatArray:
        return left(x).ravel()

    plain = least_squares(flat, start).x
    scale = 3.0 * float(np.median(np.abs(flat(plain))))
    found: FloatArray = least_squares(flat, plain, loss="cauchy", f_scale=scale).x
    return found


def _jackknifed(
    at_s: FloatArray,
    left: FloatArray,
    rows: FloatArray,
    solved: Callable[[FloatArray, FloatArray], FloatArray],
) -> tuple[FloatArray, float]:
    """A figure of all rows, and the deviation of its length by leaving blocks out."""
    whole = solved(left, rows)
    block = (at_s / _BLOCK_S).astype(int)
    each = np.array([solved(left[block != k], rows[block != k]) for k in np.unique(block)])
    scatter = (len(each) - 1) / len(each) * np.sum((each - each.mean(axis=0)) ** 2)
    return whole, float(np.sqrt(scatter))


def _interpolated(at: FloatArray, given: FloatArray, values: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(at, given, column) for column in values.T])


def set_right(one: Flight, faults: GroundTruthFaults) -> Flight:
    """The flight with its ground truth upright, and in the gyroscope's axes."""
    lean = Motor.from_twist(np.concatenate([faults.lean_rad, np.zeros(4)]))
    axes = Motor.from_twist(np.concatenate([faults.axes_rad, np.zeros(3)]))
    poses = lean @ one.truth.motors @ axes.inverse()
    return replace(one, truth=replace(one.truth, poses=poses))


def smoothed_nees(one: Flight, seed: int) -> float:
    """NEES/6 of the smoothed path of one draw of poses, with the noise as it is stated.

    A fit of the noise would take up what a ground truth's own faults do.
    """
    poses = measured(one, seed, degraded=BLACKOUTS)
    return nees(one, fuse(poses, one.imu, NOISE, Motor.identity(), fits_noise=False))


def main() -> None:
    """Print a line a flight."""
    for one, seeds in flights_asked_for("tests.bench.fusion.ground_truth", 3):
        faults = found_faults(one)
        right = set_right(one, faults)
        before, after = (
            np.mean([smoothed_nees(each, seed) for seed in seeds]) for each in (one, right)
        )
        lean, axes = (np.rad2deg(np.linalg.norm(x)) for x in (faults.lean_rad, faults.axes_rad))
        print(
            f"{one.name}: leans {lean:.3f}° ± {np.rad2deg(faults.lean_sigma_rad):.3f}, axes turned "
            f"by {axes:.3f}° ± {np.rad2deg(faults.axes_sigma_rad):.3f} "
            f"({', '.join(f'{x:+.3f}' for x in np.rad2deg(faults.axes_rad))}); "
            f"NEES/6 {before:.2f}, set right {after:.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
