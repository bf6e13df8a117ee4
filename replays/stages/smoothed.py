"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from typing import Any

from motorcade.fusion.smoothing import automatic_window_s, smooth
from motorcade.fusion.smoothing.methods import method_parameters, parsed_parameters
from motorcade.replays.values.paths import FusedPath, SmoothedPaths

# `auto` learns noise and motion from the path itself, and needs so many poses for it.
_FEWEST = 16


def smoothed(
    fused: FusedPath,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler_unwrapped", "euler"),
    method: str = "local_polynomial",
    parameters: tuple[str, ...] = (),
    window_s: float | None = None,
    order: int | None = None,
) -> SmoothedPaths:
    """Smooth the fused path, on every representation by the same method.

    `representations` names those to compare, of motor, similarity, rotor, dual_quaternion,
    quaternion, euler_unwrapped and euler; the first is what `overlay` draws along.
    `method` is any that `motorcade smooth` knows: auto, robust_map, rts_constant_velocity, spline….
    `parameters` are those of the method as name=value, commas between them (cutoff_hz=3).
    `window_s` is the width of the window in seconds, of methods that have one.
    `order` is the degree of the polynomials, of methods that fit them; by default 2.
    Without a width local polynomials take the widest window that removes noise alone, judged by
    the path's own uncertainty (see `fusion.smoothing.automatic_window_s`). A path that was fused
    looking ahead is smooth already, as far as sensors tell it: what is rough in it was felt, and it
    is left as it is unless another method or a number is asked for.
    """
    if not representations:
        raise ValueError("representations: expected at least one, got none")
    given = parsed_parameters(method, parameters)
    known = method_parameters(method)
    for name, value in (("window_s", window_s), ("order", order)):
        if value is None:
            continue
        if name not in known:
            raise ValueError(f"{name}: expected none with {method}, which has no {name}")
        given[name] = value
    path = fused.trajectory
    settings = _settings(fused, method, given)
    if settings is None:
        return SmoothedPaths(dict.fromkeys(representations, path), None, {}, fused.held_out)
    held_out = fused.held_out and smooth(fused.held_out, method, representations[0], **settings)
    paths = {as_what: smooth(path, method, as_what, **settings) for as_what in representations}
    return SmoothedPaths(paths, method, settings, held_out)


def _settings(fused: FusedPath, method: str, given: dict[str, Any]) -> dict[str, Any] | None:
    """The method's numbers; None where the path is to be left as it is."""
    if method == "auto":
        return None if len(fused.trajectory) < _FEWEST else given
    if method != "local_polynomial" or "window_s" in given:
        return given
    if fused.looked_ahead and not given:
        return None
    order = given.get("order", 2)
    window_s = automatic_window_s(fused.trajectory, fused.covariance, order)
    return None if window_s is None else {"window_s": window_s, "order": order}
