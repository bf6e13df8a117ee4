"""Stage `smoothed`: one smoother, run on every representation of the fused path."""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.fusion.smoothing import automatic_window_s, smooth
from motorcade.fusion.smoothing.methods import method_parameters, parsed_parameters
from motorcade.fusion.smoothing.window import mean_square_change
from motorcade.ga import Trajectory
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths

# `auto` learns noise and motion from the path itself, and needs so many poses for it.
_FEWEST = 16
# What smoothing takes away, in squared deviations of the poses: more than noise has (a few hundred
# poses estimate it to better than this factor) is motion; less than a tenth is not what the poses
# are uncertain by, but errors that neighbours share stay.
_LEAST_CHANGE, _MOST_CHANGE = 0.1, 1.5


def smoothed(
    fused: FusedPath,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler_unwrapped", "euler"),
    method: str | None = None,
    parameters: tuple[str, ...] = (),
    window_s: float | None = None,
    order: int | None = None,
) -> SmoothedPaths:
    """Smooth the fused path, on every representation by the same method.

    `representations` names those to compare, of motor, similarity, rotor, dual_quaternion,
    quaternion, euler_best, euler_unwrapped, euler and the orders of Euler angles (euler_zyx); the
    first is what `overlay` draws along.
    `method` is any that `motorcade smooth` knows: auto, robust_map, rts_constant_velocity, spline….
    `parameters` are those of the method as name=value, commas between them (cutoff_hz=3).
    `window_s` is the width of the window in seconds, of methods that have one.
    `order` is the degree of the polynomials, of methods that fit them; by default 2.
    Without any of these `auto` smooths, with no more lag than the fused path may have
    (`fused.look_ahead`, `fused.lag_s`), and the path is kept as it was where that is no gain: where
    it moves poses by more than their own uncertainty explains, or hardly at all, what looks like
    noise is motion, or errors that neighbours share; what is drawn would slide on the footage. A
    path that a filter or a graph made is smooth already, as far as sensors tell it, and is left as
    it is. A window or a degree alone are those of local polynomials, of which `local_polynomial`
    without a width takes the widest that removes noise alone, judged by the same uncertainty.
    """
    if not representations:
        raise ValueError("representations: expected at least one, got none")
    numbers = {"window_s": window_s, "order": order}
    numbers = {name: value for name, value in numbers.items() if value is not None}
    if method is None and not numbers and not parameters:
        return _automatically(fused, representations)
    named = method or ("local_polynomial" if numbers else "auto")
    parsed = parsed_parameters(named, parameters)
    known = method_parameters(named)
    for name, value in numbers.items():
        if name not in known:
            raise ValueError(f"{name}: expected none with {named}, which has no {name}")
        parsed[name] = value
    settings = _settings(fused, named, parsed)
    if settings is None:
        return _as_fused(fused, representations)
    paths = {
        as_what: smooth(fused.trajectory, named, as_what, **settings) for as_what in representations
    }
    return _with_held_out(fused, paths, named, settings)


def _automatically(fused: FusedPath, representations: tuple[str, ...]) -> SmoothedPaths:
    """By `auto`, where that is a gain."""
    path = fused.trajectory
    if fused.by != "nothing" or len(path) < _FEWEST:
        return _as_fused(fused, representations)
    settings: dict[str, Any] = {"lag_s": fused.lag_s} if np.isfinite(fused.lag_s) else {}
    first = smooth(path, "auto", None if settings else representations[0], **settings)
    change = mean_square_change(path, first, fused.covariance)
    if not _LEAST_CHANGE <= change <= _MOST_CHANGE:
        return _as_fused(fused, representations)
    paths = dict.fromkeys(representations, first)
    if not settings:
        paths |= {as_what: smooth(path, "auto", as_what) for as_what in representations[1:]}
    return _with_held_out(fused, paths, "auto", settings)


def _as_fused(fused: FusedPath, representations: tuple[str, ...]) -> SmoothedPaths:
    """The path as it was."""
    paths = dict.fromkeys(representations, fused.trajectory)
    return SmoothedPaths(paths, None, {}, fused.held_out)


def _with_held_out(
    fused: FusedPath, paths: dict[str, Trajectory], method: str, settings: dict[str, Any]
) -> SmoothedPaths:
    """The paths, and the first's like made without the measured poses that were held out."""
    held_out = fused.held_out
    if held_out is not None:
        live = settings.get("lag_s") is not None
        held_out = smooth(held_out, method, None if live else next(iter(paths)), **settings)
    return SmoothedPaths(paths, method, settings, held_out)


def _settings(fused: FusedPath, method: str, parsed: dict[str, Any]) -> dict[str, Any] | None:
    """The method's numbers; None where the path is to be left as it is."""
    if method == "auto":
        return None if len(fused.trajectory) < _FEWEST else parsed
    if method != "local_polynomial" or "window_s" in parsed:
        return parsed
    order = parsed.get("order", 2)
    window_s = automatic_window_s(fused.trajectory, fused.covariance, order)
    return None if window_s is None else {"window_s": window_s, "order": order}
