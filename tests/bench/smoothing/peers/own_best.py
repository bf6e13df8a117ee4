"""The best that this library has for a case: every other method of METHODS, tuned on ground truth.

Rotors and motors are tried, each parameter over a grid on a log scale, in search of the least error
(e2). Methods with one parameter for rotation and another for translation are searched for both at
once: on rotors each part's error follows its own parameter alone, and on motors nearly so. The
grids are for paths at 20 Hz; one at another rate is stamped so, which changes nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np

from motorcade.fusion.smoothing.methods import METHODS, smooth
from motorcade.ga import Trajectory
from motorcade.ga.arrays import IntArray
from tests.bench.smoothing.peers.tuned import Case

__all__ = ["OwnBest", "own_best"]

_RATE_HZ = 20.0
_REPRESENTATIONS = ("rotor", "motor")
# They take a hundred times as long as the others, so on rotors alone.
_SLOW = ("spline", "robust_map")


def _grid(low: float, high: float, count: int) -> list[float]:
    return [float(one) for one in np.geomspace(low, high, count)]


# One value serves rotation and translation.
_SHARED: dict[str, dict[str, list[float]]] = {
    "exponential": {"cutoff_hz": _grid(0.2, 9.9, 12)},
    "double_exponential": {"cutoff_hz": _grid(0.5, 9.9, 7), "trend_cutoff_hz": _grid(0.05, 9.9, 6)},
    "gaussian": {"sigma_s": _grid(0.02, 1.0, 16)},
    "savitzky_golay": {"window_s": _grid(0.2, 6.0, 16)},
    "local_polynomial": {"window_s": _grid(0.2, 6.0, 16)},
    "spline": {"knot_spacing_s": _grid(0.075, 0.8, 6)},
}
# Rotation has one, and translation another.
_VELOCITY = ("angular_acceleration_rad_s2", "acceleration_m_s2")
_ACCELERATION = ("angular_jerk_rad_s3", "jerk_m_s3")
_APART: dict[str, tuple[str, str]] = {
    "constant_velocity": _VELOCITY,
    "constant_acceleration": _ACCELERATION,
    "rts_constant_velocity": _VELOCITY,
    "rts_constant_acceleration": _ACCELERATION,
    "robust_map": _VELOCITY,
}
# Over the noise, in 1/s^1.5 and 1/s^2.5; the filters' noise is told by ground truth.
_DENSITIES = {
    _VELOCITY: _grid(0.2, 2e4, 21),
    _ACCELERATION: _grid(0.2, 2e6, 21),
}
# Outliers make the smoother of least error a stronger one than what their weights leave asks for.
_OVER_RTS = (1.0, 4.0, 16.0, 64.0)
SEARCHED = {*_SHARED, *_APART, "one_euro", "auto"}
"""Methods that this file searches, and `auto`, which it is the measure of."""
_CUTOFFS_HZ, _BETAS = _grid(0.1, 9.0, 6), [0.0, *_grid(0.1, 300.0, 6)]


@dataclass
class OwnBest:
    """The best setting found, and its path.

    Fields:
        e2: mean of rotation and position error as a share of the raw path's.
        setting: the method with its representation and parameters.
        trials: how many settings were tried.
    """

    e2: float = np.inf
    setting: str = "raw"
    path: Trajectory | None = None
    trials: int = 0
    skipped: list[str] = field(default_factory=list)


def own_best(case: Case) -> OwnBest:
    """Search all methods but `auto`; one that no search is written for is an error of this file."""
    if set(METHODS) != SEARCHED:
        raise ValueError(f"METHODS: no search of {sorted(set(METHODS) ^ SEARCHED)}")
    time_ns, raw = case.raw.time_ns, case.errors(case.raw)
    case = replace(case, raw=_restamped(case.raw, _stamps_at_rate(time_ns)))
    found = OwnBest()
    for method, representation in product(METHODS, _REPRESENTATIONS):
        if method == "auto" or (method in _SLOW and representation != _REPRESENTATIONS[0]):
            continue
        settings: Iterable[dict[str, Any]]
        if method in _SHARED:
            settings = _products(_SHARED[method])
        else:
            settings = _settings_apart(case, method, representation)
        for parameters in settings:
            path = _smoothed(case, method, representation, parameters, found)
            if path is None:
                continue
            e2 = _share(case.errors(path), raw)
            if e2 < found.e2:
                told = ", ".join(f"{name}={value:.4g}" for name, value in parameters.items())
                found.e2, found.path = e2, path
                found.setting = f"{method} on {representation}s, {told}"
    if found.path is not None:
        found.path = _restamped(found.path, time_ns)
    return found


def _stamps_at_rate(time_ns: IntArray) -> IntArray:
    """The same stamps, stretched so that the usual interval is that of the grids."""
    passed = (time_ns - time_ns[0]) / float(np.median(np.diff(time_ns)))
    return np.asarray(np.rint(passed * 1e9 / _RATE_HZ), dtype=np.int64)


def _restamped(path: Trajectory, time_ns: IntArray) -> Trajectory:
    return Trajectory(time_ns, path.poses, path.parent, path.child)


def _products(grids: dict[str, list[float]]) -> Iterator[dict[str, Any]]:
    for values in product(*grids.values()):
        yield dict(zip(grids, values, strict=True))


def _settings_apart(case: Case, method: str, representation: str) -> list[dict[str, Any]]:
    """The setting whose parameters are each the best for its own part."""
    best: list[tuple[float, dict[str, Any]]] = [(np.inf, {}), (np.inf, {})]
    for pair, common in _pairs(case, method, representation):
        path = _smoothed(case, method, representation, pair[0] | pair[1] | common, None)
        if path is None:
            continue
        for part, error in enumerate(case.errors(path)):
            if error < best[part][0]:
                best[part] = error, pair[part] | common
    return [best[0][1] | best[1][1]] if best[0][1] else []


def _pairs(
    case: Case, method: str, representation: str
) -> Iterator[tuple[tuple[dict[str, Any], dict[str, Any]], dict[str, Any]]]:
    """Parameters of rotation and of translation, and what they share."""
    if method == "one_euro":
        for cutoff_hz, beta in product(_CUTOFFS_HZ, _BETAS):
            yield ({"beta_per_rad": beta}, {"beta_per_m": beta}), {"min_cutoff_hz": cutoff_hz}
        return
    names = _APART[method]
    noise_rad, noise_m = (max(one, 1e-6) for one in case.noise)
    told = {"noise_rad": noise_rad, "noise_m": noise_m}
    if method == "robust_map":
        for best in _settings_apart(case, "rts_constant_velocity", representation):
            for factor in _OVER_RTS:
                yield (
                    ({names[0]: factor * best[names[0]]}, {names[1]: factor * best[names[1]]}),
                    told,
                )
        return
    for density in _DENSITIES[names]:
        yield ({names[0]: density * noise_rad}, {names[1]: density * noise_m}), told


def _smoothed(
    case: Case,
    method: str,
    representation: str,
    parameters: dict[str, Any],
    found: OwnBest | None,
) -> Trajectory | None:
    if found is not None:
        found.trials += 1
    try:
        made: Trajectory = smooth(case.raw, method, representation, **parameters)
    except ValueError as refused:  # windows or cut-offs that the path's rate does not allow
        if found is not None:
            found.skipped.append(f"{method}: {refused}")
        return None
    return made


def _share(errors: tuple[float, float], raw: tuple[float, float]) -> float:
    shares = [one / whole for one, whole in zip(errors, raw, strict=True) if whole > 0.0]
    return float(np.mean(shares))
