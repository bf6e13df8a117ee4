"""`make bench SUITE=lag`: what smoothing costs in lag and brings in jitter and error.

Two questions on the standard motions at 30 Hz with noise of 5 mm and 0.5° an axis. How much jitter
does the constant-acceleration RTS smoother on motors take away, and does it lag? And how far does
the 1€ filter lag beside the exponential filter where both leave equal jitter? Parameters are tuned
on seeds of their own. Jitter, lag and error are those of `motorcade.fusion.metrics`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from motorcade.fusion.metrics import (
    NotObservableError,
    accelerations,
    angular_rate_lag_s,
    jitter,
    position_lag_s,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import OneEuro, smooth
from motorcade.fusion.smoothing.causal import Exponential
from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = ["bench_lag", "lag_table", "one_euro_row", "rts_row"]

RATE_HZ, DURATION_S = 30.0, 30.0
SIGMA_M, SIGMA_RAD = 0.005, float(np.deg2rad(0.5))
TUNING_SEEDS, TEST_SEEDS = (101, 102), (1, 2, 3)
DENSITIES = tuple(10.0 ** (0.5 * np.arange(-4, 7)))
CUTOFFS_HZ = tuple(np.geomspace(0.5, 14.0, 24))
QUANTITIES = ("position", "rotation")
# Shares of jitter and lag on tuning seeds differ a little from those on test seeds.
EQUAL = 0.99


class Case:
    """A motion, measured once for each seed."""

    def __init__(self, name: str, seeds: Iterable[int]) -> None:
        self.name = name
        self.truth = MOTIONS[name].sampled(RATE_HZ, DURATION_S)
        noise = Gaussian(SIGMA_M, SIGMA_RAD)
        self.measured = [noise.apply(self.truth, np.random.default_rng(seed)) for seed in seeds]
        self.rigid_truth = self.truth.rigid
        self.motors = self.truth.poses.rigid

    def errors(self, estimate: Trajectory) -> tuple[FloatArray, FloatArray]:
        """Errors of position ``(N, 3)`` in the world and of rotation ``(N, 3)`` in the body."""
        ours, true = estimate.poses.rigid, self.motors
        return (
            ours.translation_m - true.translation_m,
            (true.rotor.inverse() @ ours.rotor).as_rotation_vector(),
        )

    def excess(self, estimate: Trajectory) -> tuple[FloatArray, FloatArray]:
        """Accelerations that ground truth lacks, linear and angular: jitter is their RMS."""
        ours = accelerations(estimate.time_s, estimate.poses.rigid)
        true = accelerations(self.truth.time_s, self.motors)
        return ours[0] - true[0], ours[1] - true[1]


def rms(vectors: FloatArray) -> float:
    """Root of the mean square of the vectors' lengths."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))


# The smoother ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class RtsRow:
    """Medians over the test seeds; shares are smoothed over raw, lags those of the smoothed.

    Lags that cannot be told (nothing turns, or turns evenly) are None.
    """

    motion: str
    jerk_m_s3: float
    angular_jerk_rad_s3: float
    linear_jitter_cut: float
    angular_jitter_cut: float
    ape_share: float
    rotation_error_share: float
    position_lag_ms: float | None
    angular_rate_lag_ms: float | None


def rts_row(name: str) -> RtsRow:
    """Tune the two densities for least error, each for its own, and measure on other seeds."""
    tuning = Case(name, TUNING_SEEDS)
    jerk, angular = 10.0, 10.0
    for _ in range(2):
        jerk = min(DENSITIES, key=lambda q: _error(tuning, 0, q, angular))
        angular = min(DENSITIES, key=lambda q: _error(tuning, 1, jerk, q))
    test = Case(name, TEST_SEEDS)
    cuts, shares, lags = [], [], []
    for raw in test.measured:
        made = _smoothed(raw, jerk, angular)
        before, after = (jitter(one.rigid, test.rigid_truth) for one in (raw, made))
        cuts.append(
            [
                before.linear_m_s2 / after.linear_m_s2,
                before.angular_rad_s2 / after.angular_rad_s2,
            ]
        )
        errors = zip(test.errors(made), test.errors(raw), strict=True)
        shares.append([rms(ours) / rms(theirs) for ours, theirs in errors])
        lags.append([_lag_ms(kind, made.rigid, test.rigid_truth) for kind in QUANTITIES])
    cut, share = np.median(cuts, axis=0), np.median(shares, axis=0)
    told = [_median(column) for column in zip(*lags, strict=True)]
    return RtsRow(
        name, jerk, angular, float(cut[0]), float(cut[1]), float(share[0]), float(share[1]), *told
    )


def _smoothed(raw: Trajectory, jerk: float, angular: float) -> Trajectory:
    name = "similarity" if isinstance(raw.poses, Similarity) else "motor"
    return smooth(
        raw,
        "rts_constant_acceleration",
        name,
        jerk_m_s3=jerk,
        angular_jerk_rad_s3=angular,
        noise_m=SIGMA_M,
        noise_rad=SIGMA_RAD,
    )


def _error(case: Case, quantity: int, jerk: float, angular: float) -> float:
    return float(
        np.mean(
            [rms(case.errors(_smoothed(raw, jerk, angular))[quantity]) for raw in case.measured]
        )
    )


def _lag_ms(quantity: str, estimate: Trajectory, truth: Trajectory) -> float | None:
    lag = position_lag_s if quantity == "position" else angular_rate_lag_s
    try:
        return 1e3 * lag(estimate, truth)
    except NotObservableError:
        return None


def _median(values: Iterable[float | None]) -> float | None:
    told = [value for value in values if value is not None]
    return float(np.median(told)) if told else None


# The 1€ filter -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class OneEuroRow:
    """Both filters on the test seeds, means: jitter in m/s² or rad/s², lag in ms.

    Fields:
        cutoff_hz: of the exponential filter.
        parameters: of the 1€ filter: least cut-off, beta and cut-off of the derivative.
        lag_share: lag of the 1€ filter over that of the exponential one.
    """

    motion: str
    quantity: str
    cutoff_hz: float
    parameters: tuple[float, float, float]
    raw_jitter: float
    exponential_jitter: float
    one_euro_jitter: float
    exponential_lag_ms: float
    one_euro_lag_ms: float
    lag_share: float


def one_euro_row(name: str, quantity: str, cutoff_hz: float | None = None) -> OneEuroRow:
    """Compare where both leave equal jitter in a quantity, "position" or "rotation".

    The exponential filter has the cut-off of least error on the tuning seeds unless one is given;
    the 1€ filter the parameters of least lag among those that leave no more jitter there.
    """
    which, tuning = QUANTITIES.index(quantity), Case(name, TUNING_SEEDS)
    if cutoff_hz is None:
        cutoff_hz = min(CUTOFFS_HZ, key=lambda hz: _figures(tuning, Exponential(hz), which)[2])
    parameters = _tuned_one_euro(tuning, which, _figures(tuning, Exponential(cutoff_hz), which)[0])
    test = Case(name, TEST_SEEDS)
    filters = (Exponential(cutoff_hz), _one_euro(parameters, which))
    figures = [_figures(test, chosen, which) for chosen in filters]
    lags = [
        float(
            np.mean(
                [_known(_lag_ms(quantity, chosen.smooth(raw), test.truth)) for raw in test.measured]
            )
        )
        for chosen in filters
    ]
    raw = float(np.mean([rms(test.excess(one)[which]) for one in test.measured]))
    return OneEuroRow(
        name,
        quantity,
        float(cutoff_hz),
        parameters,
        raw,
        figures[0][0],
        figures[1][0],
        lags[0],
        lags[1],
        lags[1] / lags[0],
    )


def _known(lag_ms: float | None) -> float:
    return np.nan if lag_ms is None else lag_ms


def _one_euro(parameters: tuple[float, float, float], which: int) -> OneEuro:
    least, beta, derivative = parameters
    betas = (0.0, beta) if which == 0 else (beta, 0.0)
    return OneEuro(least, *betas, derivative_cutoff_hz=derivative)


def _figures(case: Case, chosen: CausalFilter, which: int) -> tuple[float, float, float]:
    """Jitter, lag in seconds (error along the motion, in least squares) and RMS error."""
    made = [chosen.smooth(raw) for raw in case.measured]
    errors = [case.errors(one)[which] for one in made]
    speed = RATE_HZ * _steps(case.motors)[which]
    lags = [-np.sum(error[:-1] * speed) / np.sum(speed**2) for error in errors]
    return (
        float(np.mean([rms(case.excess(one)[which]) for one in made])),
        float(np.mean(lags)),
        float(np.mean([rms(error) for error in errors])),
    )


def _steps(poses: Motor) -> tuple[FloatArray, FloatArray]:
    turns = (poses[:-1].rotor.inverse() @ poses[1:].rotor).as_rotation_vector()
    return np.diff(poses.translation_m, axis=0), turns


def _tuned_one_euro(case: Case, which: int, jitter_limit: float) -> tuple[float, float, float]:
    from scipy.optimize import Bounds, differential_evolution

    bounds = Bounds([-2.0, -1.5, -1.0], [1.0, 2.5, 1.1])

    def cost(powers: FloatArray) -> float:
        residual, lag, _ = _figures(case, _one_euro(_parameters(powers), which), which)
        return lag + max(0.0, residual / (EQUAL * jitter_limit) - 1.0)

    found = differential_evolution(cost, bounds, maxiter=12, popsize=10, rng=1, polish=False)
    return _parameters(found.x)


def _parameters(powers: FloatArray) -> tuple[float, float, float]:
    least, beta, derivative = 10.0 ** np.asarray(powers)
    return float(least), float(beta), float(derivative)


# The suite -------------------------------------------------------------------------------------


def bench_lag() -> dict[str, Any]:
    """Both tables, JSON-ready: `rts` (see `RtsRow`) and `one_euro` (see `OneEuroRow`)."""
    cutoffs: tuple[float | None, ...] = (None, 2.0, 4.0, 8.0)
    return {
        "rts": [asdict(rts_row(name)) for name in MOTIONS],
        "one_euro": [
            asdict(one_euro_row(name, quantity, cutoff))
            for name in ("walk_and_look", "stop_and_go")
            for quantity in QUANTITIES
            for cutoff in cutoffs
        ],
    }


def lag_table(found: Mapping[str, Any]) -> str:
    """A row a motion for the smoother, a row a comparison for the filters."""
    lines = [
        "RTS, constant acceleration, motors: raw over smoothed jitter, smoothed over raw error",
        f"{'motion':<24}{'linear':>9}{'angular':>9}{'APE':>7}{'turn':>7}{'lag ms':>9}{'rate':>9}",
    ]
    for row in found["rts"]:
        lines.append(
            f"{row['motion']:<24}{row['linear_jitter_cut']:>9.1f}{row['angular_jitter_cut']:>9.1f}"
            f"{row['ape_share']:>7.2f}{row['rotation_error_share']:>7.2f}"
            f"{_text(row['position_lag_ms'])}{_text(row['angular_rate_lag_ms'])}"
        )
    lines += [
        "",
        "1€ beside the exponential filter on motors at equal jitter: lag in ms",
        f"{'motion, quantity, cut-off':<40}{'jitter':>9}{'1€':>9}{'lag':>9}{'1€':>9}{'share':>8}",
    ]
    for row in found["one_euro"]:
        name = f"{row['motion']}, {row['quantity']}, {row['cutoff_hz']:.1f} Hz"
        lines.append(
            f"{name:<40}{row['exponential_jitter']:>9.2f}{row['one_euro_jitter']:>9.2f}"
            f"{row['exponential_lag_ms']:>9.1f}{row['one_euro_lag_ms']:>9.1f}{row['lag_share']:>8.2f}"
        )
    return "\n".join(lines)


def _text(lag_ms: float | None) -> str:
    return f"{'-' if lag_ms is None else f'{lag_ms:.2f}':>9}"
