"""Parameters of every method, chosen the same way for every representation.

A method has a range for each parameter, in physical units. One parameter is searched at a time on a
logarithmic scale, with the others at their start or at what was found before: five values from end
to end, then four steps of golden section between the neighbours of the best (J. Kiefer, Sequential
minimax search for a maximum, 1953). Where a method has several parameters all are searched once
more, by three steps near what was found. Ranges, objective and number of trials are the same for
every representation, and the seeds are not those that are judged. The objective is the mean over
the tuning seeds of

    mean of (position error, rotation error, linear jitter, angular jitter), each over the raw one,

and of the error of the scale where there is one: 1 is no better than the raw poses. So a method
gains nothing by trading error for jitter. Parameters are chosen for each motion and degradation
separately, so no representation is judged with another motion's parameters.

Where a representation adds rotations and positions up apart, what serves both in a method, such as
the width of a window, is searched for each of them, by its own half of the objective; in motors, in
similarities and in dual quaternions, whose dual parts mix both, there is one for all.

Two searches are spared. On rigid motions `similarity` takes what was found for `motor`, which is
nearly the same there (see `ties`). And `robust_map`, which has the motion model of
`rts_constant_velocity` and is told the noise of the good poses, takes the process noise that was
found for that one with plain noise: what that noise is worth depends on the motion, not on what
else is wrong.

`auto` alone has no range: it runs with its defaults, and the results say so.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.comparison.evaluator import PathEvaluator
from motorcade.replays.comparison.plan import FOR_POSITIONS, DegradedMotion, Setting


def _noise(sigma_m: float, sigma_deg: float) -> tuple[tuple[str, float], ...]:
    return ("noise_m", sigma_m), ("noise_rad", float(np.deg2rad(sigma_deg)))


NOISE = _noise(0.005, 0.5)
"""The noise that filters are told. Only its ratio to the process noise counts, which is searched;
but `robust_map` recognises outliers by it, and is told what it is."""

_NOISE_OF: Mapping[str, tuple[tuple[str, float], ...]] = MappingProxyType(
    {
        "gaussian_strong": _noise(0.02, 2.0),
        "quantised": _noise(0.01 / np.sqrt(12.0), 1.0 / np.sqrt(12.0)),
    }
)
# Which method and degradation the process noise of another method is taken from.
_LENDERS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {"robust_map": ("rts_constant_velocity", "gaussian")}
)

# Representations whose vectors mix rotations with positions.
_MIXED = ("motor", "similarity", "dual_quaternion")
# Which of the errors are of rotations, and which of positions and scale.
_ROTATION, _POSITION, _BOTH = [1, 3], [0, 2, 4], [0, 1, 2, 3, 4]
_COARSE = 5
_STEPS, _STEPS_AGAIN = 4, 3
# What a step of golden section takes of the longer side of its bracket.
_GOLDEN = 0.5 * (3.0 - 5.0**0.5)
_DIGITS = 4


@dataclass(frozen=True)
class ParameterRange:
    """Least and largest value of one parameter, and where it stands while others are searched."""

    parameter: str
    start: float
    low: float
    high: float


_VELOCITY = (
    ParameterRange("angular_acceleration_rad_s2", 3.0, 0.01, 1000.0),
    ParameterRange("acceleration_m_s2", 1.0, 0.005, 50.0),
)
_ACCELERATION = (
    ParameterRange("angular_jerk_rad_s3", 10.0, 0.01, 10000.0),
    ParameterRange("jerk_m_s3", 5.0, 0.005, 500.0),
)

RANGES: Mapping[str, tuple[ParameterRange, ...]] = MappingProxyType(
    {
        "exponential": (ParameterRange("cutoff_hz", 2.0, 0.5, 14.0),),
        "double_exponential": (
            ParameterRange("cutoff_hz", 2.0, 0.5, 14.0),
            ParameterRange("trend_cutoff_hz", 0.5, 0.05, 14.0),
        ),
        "one_euro": (
            ParameterRange("min_cutoff_hz", 2.0, 0.25, 14.0),
            ParameterRange("beta_per_rad", 3.0, 0.1, 100.0),
            ParameterRange("beta_per_m", 3.0, 0.1, 100.0),
        ),
        "constant_velocity": _VELOCITY,
        "constant_acceleration": _ACCELERATION,
        "rts_constant_velocity": _VELOCITY,
        "rts_constant_acceleration": _ACCELERATION,
        "gaussian": (ParameterRange("sigma_s", 0.1, 0.02, 1.0),),
        "savitzky_golay": (ParameterRange("window_s", 0.3, 0.12, 4.0),),
        "local_polynomial": (ParameterRange("window_s", 0.3, 0.12, 4.0),),
        "spline": (ParameterRange("knot_spacing_s", 0.2, 0.075, 0.6),),
        "robust_map": _VELOCITY,
    }
)
"""What is searched, in order. Cut-offs end below half the rate of the standard plan, 15 Hz."""

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


@dataclass(frozen=True)
class Tuning:
    """One search: for a method and its representations, on seeds of a motion and a degradation."""

    inputs: tuple[DegradedMotion, ...]
    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Tuned:
    """What a search found.

    Fields:
        how: "search", "defaults" (nothing to search, or no value that the method did not refuse)
            or "borrowed".
        objective: of the best value; None where nothing was tried.
        trials: how many values were tried, of rotations and of positions each where they are apart.
    """

    setting: Setting
    how: str
    objective: float | None
    trials: int


def run_tuning(tuning: Tuning) -> tuple[Tuned, ...]:
    """Every search of a motion and a degradation."""
    inputs = [each.drawn() for each in tuning.inputs]
    raw = [evaluator.errors([degraded])[0] for degraded, evaluator in inputs]
    return tuple(tuned(*pair, inputs, raw) for pair in tuning.pairs)


def tuned(
    method: str,
    representation: str,
    inputs: Sequence[tuple[Trajectory, PathEvaluator]],
    raw: Sequence[FloatArray],
) -> Tuned:
    """Search a method's parameters on paths, given the errors of the raw poses of each."""
    ratios = _Ratios(inputs, raw)
    apart = method not in FIXED and method in RANGES and representation not in _MIXED
    if not apart:
        return _searched_for(method, representation, ratios, _BOTH)
    parts = [_searched_for(method, representation, ratios, part) for part in (_ROTATION, _POSITION)]
    turned, moved = (one.setting.parameters for one in parts)
    setting = Setting(
        method,
        representation,
        turned + tuple((FOR_POSITIONS + name, value) for name, value in moved),
    )
    if any(one.objective is None for one in parts):
        return parts[0]
    least = float(ratios.objectives([setting], _BOTH)[0])
    return Tuned(setting, "search", float(f"{least:.9g}"), parts[0].trials)


def _searched_for(method: str, representation: str, ratios: _Ratios, errors: list[int]) -> Tuned:
    """The parameters by which some of the errors are least."""
    ranges = RANGES.get(method, ())
    chosen: dict[str, Any] = dict(FIXED.get(method, ()))
    chosen |= {one.parameter: one.start for one in ranges}
    least, trials = np.inf, 0

    def tried(parameter: str, logs: Sequence[float]) -> FloatArray:
        nonlocal trials
        trials += len(logs)
        settings = [
            Setting(method, representation, tuple((chosen | {parameter: _value(x)}).items()))
            for x in logs
        ]
        return ratios.objectives(settings, errors)

    for again in (False, True) if len(ranges) > 1 else (False,):
        for span in ranges:
            objective = functools.partial(tried, span.parameter)
            if again:
                best, least = _searched_again(objective, span, chosen[span.parameter], least)
            else:
                best, least = _searched(objective, span)
            if np.isfinite(least):
                chosen[span.parameter] = _value(best)
    setting = Setting(method, representation, tuple(chosen.items()))
    if not np.isfinite(least):
        return Tuned(setting, "defaults", None, trials)
    return Tuned(setting, "search", float(f"{least:.9g}"), trials)


_Objective = Callable[[Sequence[float]], FloatArray]


def _searched(objective: _Objective, within: ParameterRange) -> tuple[float, float]:
    """The logarithm of the best value of the whole range, the first of equals; its objective."""
    logs = np.linspace(np.log(within.low), np.log(within.high), _COARSE)
    scores = objective(logs.tolist())
    i = int(np.argmin(scores))
    ends = logs[max(i - 1, 0)], logs[min(i + 1, _COARSE - 1)]
    return _golden(objective, (float(logs[i]), float(scores[i])), ends, _STEPS)


def _searched_again(
    objective: _Objective, within: ParameterRange, value: float, least: float
) -> tuple[float, float]:
    """The same near what was found, half as far about it as the values of the first search lay."""
    low, high = np.log(within.low), np.log(within.high)
    apart, best = 0.5 * (high - low) / (_COARSE - 1), float(np.log(value))
    ends = max(best - apart, low), min(best + apart, high)
    return _golden(objective, (best, least), ends, _STEPS_AGAIN)


def _golden(
    objective: _Objective, known: tuple[float, float], ends: tuple[float, float], steps: int
) -> tuple[float, float]:
    """Narrow a bracket about its best point, trying the longer side of that each time."""
    (best, least), (low, high) = known, ends
    for _ in range(steps):
        above = high - best >= best - low
        probe = best + _GOLDEN * (high - best if above else low - best)
        score = float(objective([probe])[0])
        if score < least:
            low, high = (best, high) if above else (low, best)
            best, least = probe, score
        elif above:
            high = probe
        else:
            low = probe
    return best, least


def _value(log: float) -> float:
    return float(f"{np.exp(log):.{_DIGITS}g}")


@dataclass(frozen=True)
class SearchPlace:
    """Where parameters are searched: with a degradation, for a method in a representation."""

    degradation: str
    method: str
    representation: str

    def lender(self, rigid: bool) -> SearchPlace:
        """The place whose search serves this one too, on rigid motions or others; mostly itself."""
        method, degradation = _LENDERS.get(self.method, (self.method, self.degradation))
        spared = rigid and self.representation == "similarity"
        return SearchPlace(degradation, method, "motor" if spared else self.representation)

    def borrowed(self, tuned: Tuned) -> Tuned:
        """What was found for its lender, for this place."""
        parameters = dict(tuned.setting.parameters)
        if self.method in _LENDERS:
            parameters |= dict(_NOISE_OF.get(self.degradation, NOISE))
        setting = Setting(self.method, self.representation, tuple(parameters.items()))
        return Tuned(setting, "borrowed", None, 0)


class _Ratios:
    """What settings leave of the raw poses' errors on some paths, each setting tried once."""

    def __init__(
        self, inputs: Sequence[tuple[Trajectory, PathEvaluator]], raw: Sequence[FloatArray]
    ) -> None:
        self.inputs, self.raw = inputs, raw
        self.known: dict[Setting, FloatArray] = {}

    def objectives(self, settings: Sequence[Setting], errors: list[int]) -> FloatArray:
        """The objective of each setting by some of the errors; infinite where it is refused on one
        of the paths.
        """
        new = [one for one in dict.fromkeys(settings) if one not in self.known]
        ratios = np.full((len(new), len(self.inputs), len(_BOTH)), np.inf)
        for row, ((degraded, evaluator), base) in enumerate(
            zip(self.inputs, self.raw, strict=True)
        ):
            paths = [(i, path) for i, one in enumerate(new) if (path := _smoothed(one, degraded))]
            if paths:
                measured = evaluator.errors([path for _, path in paths])
                ratios[[i for i, _ in paths], row] = measured / base
        self.known.update(zip(new, ratios, strict=True))
        counted = np.array([self.known[one][:, errors] for one in settings])
        return np.asarray(np.mean(np.nanmean(counted, axis=2), axis=1), dtype=np.float64)


def _smoothed(setting: Setting, degraded: Trajectory) -> Trajectory | None:
    try:
        return setting.smooth(degraded)
    except Exception:  # what a method refuses is no candidate; a cell's row says why
        return None
