"""Every peer on one case; those with a parameter are tuned on its ground truth.

What a peer is tuned over is searched for rotation and for position apart, each for the least error
of its own: by golden section on a log scale over twelve octaves, or by a grid where values are
whole. So a peer gets more than it would have in use.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.peers.columns import gcv_spline, savitzky_golay
from tests.bench.smoothing.peers.graph import gtsam_positions, gtsam_rotations
from tests.bench.smoothing.peers.kalman import filterpy_rts

__all__ = ["PEERS", "TUNED", "Case", "golden_section"]

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Densities of acceleration over noise, in 1/s^1.5: cut-offs of 0.3 to 60 rad/s at 20 Hz.
_DENSITIES, _EVALUATIONS = (0.2, 2e4), 8
_WINDOWS, _ORDERS = (5, 7, 9, 11, 15, 19, 25, 31, 41, 61, 91), (1, 2, 3, 4)
# Cut-offs at rest as shares of the sampling rate, below half of it.
_CUTOFFS, _BETAS = np.geomspace(0.005, 0.45, 8), (0.0, *np.geomspace(0.1, 300.0, 8))


@dataclass(frozen=True, eq=False)
class Case:
    """A measured path, and what is wrong with one like it.

    Fields:
        raw: as measured.
        errors: of a path at the same stamps: of rotation and of position, in any units.
        noise: typical deviations of rotation (rad) and position (m) an axis, by the ground truth.
        outliers: whether some poses are farther off than the others.
    """

    raw: Trajectory
    errors: Callable[[Trajectory], tuple[float, float]]
    noise: tuple[float, float]
    outliers: bool

    def parts(self) -> tuple[FloatArray, FloatArray]:
        """Quaternions with continuous signs, and positions."""
        turned, position = self.raw.motors.as_quaternion_translation()
        flips = np.sum(turned[1:] * turned[:-1], axis=1) < 0.0
        signs = np.cumprod(np.concatenate([[1.0], np.where(flips, -1.0, 1.0)]))
        return turned * signs[:, None], position

    def path(self, wxyz: FloatArray, position_m: FloatArray) -> Trajectory:
        """Parts put together again; quaternions of any length."""
        unit = wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)
        made = Motor.from_quaternion_translation(unit, position_m)
        return Trajectory(self.raw.time_ns, made, self.raw.parent, self.raw.child)

    def tuned(
        self, part: int, ways: Iterator[FloatArray] | Callable[[float], FloatArray]
    ) -> FloatArray:
        """Of the ways of smoothing a part, rotation (0) or position (1), that of least error."""
        parts = self.parts()

        def error(rows: FloatArray) -> float:
            pair = (rows, parts[1]) if part == 0 else (parts[0], rows)
            return self.errors(self.path(*pair))[part]

        if callable(ways):
            value = golden_section(lambda one: error(ways(one)), *_DENSITIES, _EVALUATIONS)
            return ways(value)
        return min(ways, key=error)


def golden_section(
    score: Callable[[float], float], low: float, high: float, evaluations: int
) -> float:
    """Where a score is least on a log scale, as far as so many evaluations tell."""
    ends = [float(np.log(low)), float(np.log(high))]
    inner = [ends[1] - _GOLDEN * (ends[1] - ends[0]), ends[0] + _GOLDEN * (ends[1] - ends[0])]
    scores = [score(float(np.exp(one))) for one in inner]
    for _ in range(evaluations - 2):
        if scores[0] <= scores[1]:
            ends[1] = inner[1]
            inner = [ends[1] - _GOLDEN * (ends[1] - ends[0]), inner[0]]
            scores = [score(float(np.exp(inner[0]))), scores[0]]
        else:
            ends[0] = inner[0]
            inner = [inner[1], ends[0] + _GOLDEN * (ends[1] - ends[0])]
            scores = [scores[1], score(float(np.exp(inner[1])))]
    return float(np.exp(inner[int(np.argmin(scores))]))


def _gcv(case: Case) -> Trajectory:
    return case.path(*(gcv_spline(case.raw.time_s, part) for part in case.parts()))


def _savitzky_golay(case: Case) -> Trajectory:
    return case.path(*(savitzky_golay(part, 9, 2) for part in case.parts()))


def _tuned_savitzky_golay(case: Case) -> Trajectory:
    return case.path(*(case.tuned(k, _windows(part)) for k, part in enumerate(case.parts())))


def _windows(part: FloatArray) -> Iterator[FloatArray]:
    for window in _WINDOWS:
        if window > len(part):
            return
        for order in _ORDERS:
            if order < window:
                yield savitzky_golay(part, window, order)


def _filterpy(case: Case) -> Trajectory:
    # filterpy's noise is 0.01 in both parts: densities over noise are told so.
    ways = [partial(_filtered, case.raw.time_s, part) for part in case.parts()]
    return case.path(*(case.tuned(k, way) for k, way in enumerate(ways)))


def _filtered(time_s: FloatArray, part: FloatArray, density: float) -> FloatArray:
    return filterpy_rts(time_s, part, 0.01 * density)


def _gtsam(case: Case) -> Trajectory:
    ways = (gtsam_rotations, gtsam_positions)
    made = []
    for k, (part, way, noise) in enumerate(zip(case.parts(), ways, case.noise, strict=True)):
        found = []
        for robust in (False, True) if case.outliers else (False,):
            solved = partial(_solved, way, case.raw.time_s, part, noise, robust)
            found.append(case.tuned(k, solved))
        made.append(case.tuned(k, iter(found)))
    return case.path(*made)


def _solved(
    way: Callable[..., FloatArray],
    time_s: FloatArray,
    part: FloatArray,
    noise: float,
    robust: bool,
    density: float,
) -> FloatArray:
    return way(time_s, part, noise * density, noise, robust)


def _one_euro(case: Case) -> Trajectory:
    """Cut-offs at rest and slopes, of rotation and of position apart."""
    best: list[tuple[float, FloatArray]] = [(np.inf, part) for part in case.parts()]
    rate_hz = 1.0 / float(np.median(np.diff(case.raw.time_s)))
    for cutoff_hz in rate_hz * _CUTOFFS:
        for beta in _BETAS:
            path = smooth(
                case.raw,
                "one_euro",
                "rotor",
                min_cutoff_hz=cutoff_hz,
                beta_per_rad=beta,
                beta_per_m=beta,
            )
            parts = path.motors.as_quaternion_translation()
            for k, error in enumerate(case.errors(path)):
                if error < best[k][0]:
                    best[k] = error, parts[k]
    return case.path(best[0][1], best[1][1])


PEERS: Mapping[str, Callable[[Case], Trajectory]] = {
    "auto": lambda case: smooth(case.raw),
    "scipy spline, GCV": _gcv,
    "Savitzky-Golay 9, 2": _savitzky_golay,
    "1€, defaults": lambda case: smooth(case.raw, "one_euro"),
    "Savitzky-Golay, tuned": _tuned_savitzky_golay,
    "filterpy RTS, tuned": _filterpy,
    "gtsam, tuned": _gtsam,
    "1€, tuned": _one_euro,
}
"""By name; `auto` comes first."""

TUNED = tuple(name for name in PEERS if name.endswith("tuned"))
"""Peers that ground truth is told to."""
