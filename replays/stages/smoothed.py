"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from typing import Any

from motorcade.fusion.smoothing import automatic_window_s, choose, method_parameters, smooth
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
    order: int = 2,
) -> SmoothedPaths:
    """Smooth the fused path, on every representation by the same method and numbers.

    `representations` names those to compare, of motor, similarity, rotor, dual_quaternion,
    quaternion, euler_unwrapped and euler; the first is what `overlay` draws along.
    `method` is any that `motorcade smooth` knows: auto, robust_map, rts_constant_velocity, spline….
    `parameters` are those of the method as name=value, commas between them (cutoff_hz=3).
    `window_s` and `order` are the width in seconds and the degree of local polynomials.
    Without `window_s` the widest window is taken that removes noise alone, judged by the path's
    own uncertainty (see `fusion.smoothing.automatic_window_s`). A path that was fused looking ahead
    is smooth already, as far as sensors tell it: what is rough in it was felt, and it is left as it
    is unless another method, parameters or a window are asked for.
    """
    if not representations:
        raise ValueError("representations: expected at least one, got none")
    given = _numbers(method, parameters)
    if method in ("local_polynomial", "savitzky_golay"):
        width = {} if window_s is None else {"window_s": window_s}
        given = {"order": order, **width, **given}
    elif window_s is not None:
        raise ValueError(f"window_s: expected none with {method}, which has no window")
    chosen = _chosen(fused, method, given, representations[0])
    path = fused.trajectory
    if chosen is None:
        return SmoothedPaths(dict.fromkeys(representations, path), None, {}, fused.held_out)
    name, settings = chosen
    held_out = fused.held_out and smooth(fused.held_out, name, representations[0], **settings)
    paths = {as_what: smooth(path, name, as_what, **settings) for as_what in representations}
    return SmoothedPaths(paths, name, settings, held_out)


def _chosen(
    fused: FusedPath, method: str, given: dict[str, Any], representation: str
) -> tuple[str, dict[str, Any]] | None:
    """The method with its numbers; None where the path is to be left as it is."""
    path = fused.trajectory
    asked_for = method != "local_polynomial" or bool(given.keys() - {"order"})
    if fused.looked_ahead and not asked_for:
        return None
    if method == "auto":
        if len(path) < _FEWEST:
            return None
        choice = choose(path, representation)
        return choice.method, choice.parameters
    if method == "local_polynomial" and "window_s" not in given:
        window_s = automatic_window_s(path, fused.covariance, given["order"])
        return None if window_s is None else (method, {**given, "window_s": window_s})
    return method, given


def _numbers(method: str, parameters: tuple[str, ...]) -> dict[str, Any]:
    """`("cutoff_hz=3",)` as {"cutoff_hz": 3.0}, each of the kind that its default is of."""
    defaults, made = method_parameters(method), dict[str, Any]()
    for one in parameters:
        name, equals, text = (part.strip() for part in one.partition("="))
        if not equals or not text:
            raise ValueError(f"parameters: expected name=value, got {one!r}")
        kind = type(defaults.get(name, 0.0))
        try:
            made[name] = kind(text)
        except ValueError:
            raise ValueError(
                f"parameters: {name}: expected {kind.__name__}, got {text!r}"
            ) from None
    return made
