"""Parameters of every method, chosen the same way for every representation.

A method has a grid of values for each parameter, in physical units. One grid is searched at a time,
with the other parameters at their start or at what was found before; the value with the lowest
objective is taken, the first of equals. Where there are several grids, each is searched twice.
Values, objective and number of trials are the same for every representation, and the seeds are not
those that are judged. The objective is the mean over the tuning seeds of

    mean of (position error, rotation error, linear jitter, angular jitter), each over the raw one,

and of the error of the scale where there is one: 1 is no better than the raw poses. So a method
gains nothing by trading error for jitter. Parameters are chosen for each motion and degradation
separately, so no representation is judged with another motion's parameters. On rigid motions
`similarity` takes what was found for `motor`, which is nearly the same there (see `ties`).

Methods without a grid run with their defaults, and the results say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.compare.cells import Setting, inputs_of
from motorcade.replays.compare.measure.evaluator import PathEvaluator

NOISE = (("noise_m", 0.005), ("noise_rad", float(np.deg2rad(0.5))))
"""The noise that filters are told. Only its ratio to the process noise counts, which their grids
change; but `robust_map` recognises outliers by it."""

# How often the grids of a method are searched, where it has more than one.
_ROUNDS = 2


@dataclass(frozen=True)
class ParameterGrid:
    """Values of one parameter to try, and where it stands while others are tried."""

    parameter: str
    start: float
    values: tuple[float, ...]


def _grid(parameter: str, start: float, low: float, high: float, count: int) -> ParameterGrid:
    values = np.geomspace(low, high, count)
    return ParameterGrid(parameter, start, tuple(float(f"{value:.4g}") for value in values))


_VELOCITY = (
    _grid("angular_acceleration_rad_s2", 3.0, 0.01, 1000.0, 11),
    _grid("acceleration_m_s2", 1.0, 0.005, 50.0, 9),
)
_ACCELERATION = (
    _grid("angular_jerk_rad_s3", 10.0, 0.01, 10000.0, 13),
    _grid("jerk_m_s3", 5.0, 0.005, 500.0, 11),
)

GRIDS: Mapping[str, tuple[ParameterGrid, ...]] = MappingProxyType({
    "exponential": (_grid("cutoff_hz", 2.0, 0.5, 14.0, 12),),
    "double_exponential": (
        _grid("cutoff_hz", 2.0, 0.5, 14.0, 8),
        _grid("trend_cutoff_hz", 0.5, 0.05, 14.0, 8),
    ),
    "one_euro": (
        _grid("min_cutoff_hz", 2.0, 0.25, 14.0, 8),
        _grid("beta_per_rad", 3.0, 0.1, 100.0, 7),
        _grid("beta_per_m", 3.0, 0.1, 100.0, 7),
    ),
    "constant_velocity": _VELOCITY,
    "constant_acceleration": _ACCELERATION,
    "rts_constant_velocity": _VELOCITY,
    "rts_constant_acceleration": _ACCELERATION,
    "gaussian": (_grid("sigma_s", 0.1, 0.02, 1.0, 12),),
    "savitzky_golay": (_grid("window_s", 0.3, 0.12, 4.0, 12),),
    "local_polynomial": (_grid("window_s", 0.3, 0.12, 4.0, 12),),
    "spline": (_grid("knot_spacing_s", 0.2, 0.075, 0.6, 7),),
})  # fmt: skip
"""What is tried, in order. Cut-offs end below half the rate of the standard plan, 15 Hz."""

FIXED: Mapping[str, tuple[tuple[str, Any], ...]] = MappingProxyType(
    {
        "constant_velocity": NOISE,
        "constant_acceleration": NOISE,
        "rts_constant_velocity": NOISE,
        "rts_constant_acceleration": NOISE,
        "robust_map": NOISE,
    }
)
"""Parameters that are told and not tuned."""

BORROWS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "robust_map": ("rts_constant_velocity", "gaussian"),
    }
)
"""Methods too slow for a search take what was found for another one with the same parameters, on
the same motion under this degradation."""


@dataclass(frozen=True)
class Tuning:
    """One search: for a method and its representations, on a motion and a degradation."""

    motion: str
    degradation: str
    seeds: tuple[int, ...]
    rate_hz: float
    duration_s: float
    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Tuned:
    """What a search found.

    Fields:
        setting: the method, its representation, and all parameters that are given to it.
        how: "grid", "defaults" (no grid, or no value that the method did not refuse) or
            "borrowed".
        objective: of the best value; None where nothing was tried.
        trials: how many values were tried.
    """

    setting: Setting
    how: str
    objective: float | None
    trials: int


def run_tuning(tuning: Tuning) -> tuple[Tuned, ...]:
    """Every search of a motion and a degradation."""
    inputs = [
        inputs_of(tuning.motion, tuning.degradation, seed, tuning.rate_hz, tuning.duration_s)
        for seed in tuning.seeds
    ]
    raw = [evaluator.errors([degraded])[0] for degraded, evaluator in inputs]
    return tuple(tuned(*pair, inputs, raw) for pair in tuning.pairs)


def tuned(
    method: str,
    representation: str,
    inputs: Sequence[tuple[Trajectory, PathEvaluator]],
    raw: Sequence[FloatArray],
) -> Tuned:
    """Climb a method's grids on paths, given the errors of the raw poses of each."""
    grids = GRIDS.get(method, ())
    chosen: dict[str, Any] = dict(FIXED.get(method, ()))
    if not grids:
        return Tuned(Setting(method, representation, tuple(chosen.items())), "defaults", None, 0)
    chosen |= {grid.parameter: grid.start for grid in grids}
    best, known = np.inf, dict[Setting, float]()
    for grid in grids * (_ROUNDS if len(grids) > 1 else 1):
        tried = [
            Setting(method, representation, tuple((chosen | {grid.parameter: value}).items()))
            for value in grid.values
        ]
        new = [one for one in tried if one not in known]
        known |= zip(new, _objectives(new, inputs, raw), strict=True)
        found = [known[one] for one in tried]
        if np.isfinite(np.min(found)):
            best = float(np.min(found))
            chosen[grid.parameter] = grid.values[int(np.argmin(found))]
    setting = Setting(method, representation, tuple(chosen.items()))
    if not np.isfinite(best):
        return Tuned(setting, "defaults", None, len(known))
    return Tuned(setting, "grid", float(f"{best:.9g}"), len(known))


def borrowed(method: str, representation: str, found: Tuned) -> Tuned:
    """What was found for another method or representation, for this one."""
    parameters = dict(found.setting.parameters) | dict(FIXED.get(method, ()))
    setting = Setting(method, representation, tuple(parameters.items()))
    return Tuned(setting, "borrowed", None, 0)


def _objectives(
    tried: Sequence[Setting],
    inputs: Sequence[tuple[Trajectory, PathEvaluator]],
    raw: Sequence[FloatArray],
) -> FloatArray:
    """The objective of each setting; infinite where it is refused on one of the paths."""
    ratios = np.full((len(inputs), len(tried)), np.inf)
    for row, ((degraded, evaluator), base) in enumerate(zip(inputs, raw, strict=True)):
        made = [(i, path) for i, one in enumerate(tried) if (path := _smoothed(one, degraded))]
        if made:
            errors = evaluator.errors([path for _, path in made])
            ratios[row, [i for i, _ in made]] = np.nanmean(errors / base, axis=1)
    return np.asarray(np.mean(ratios, axis=0), dtype=np.float64)


def _smoothed(setting: Setting, degraded: Trajectory) -> Trajectory | None:
    try:
        return setting.smooth(degraded)
    except Exception:  # what a method refuses is no candidate; a cell's row says why
        return None
