"""Stage `smoothed`: one zero-lag smoother, run on every representation of the fused path."""

from __future__ import annotations

from functools import partial

from motorcade.fusion.smoothing import automatic_window_s, smooth
from motorcade.replays.values.paths import FusedPath, SmoothedPaths


def smoothed(
    fused: FusedPath,
    *,
    representations: tuple[str, ...] = ("motor", "quaternion", "euler_unwrapped", "euler"),
    window_s: float | None = None,
    order: int = 2,
) -> SmoothedPaths:
    """Smooth the fused path by local polynomials of `order` over `window_s` seconds.

    `representations` names those to compare, of motor, similarity, rotor, dual_quaternion,
    quaternion, euler_unwrapped and euler; the first is what `overlay` draws along.
    Without `window_s` the widest window is taken that removes noise alone, judged by the path's
    own uncertainty (see `fusion.smoothing.automatic_window_s`). A path that was fused looking ahead
    is smooth already, as far as sensors tell it: what is rough in it was felt, and it is left as it
    is.
    """
    if not representations:
        raise ValueError("representations: expected at least one, got none")
    path = fused.trajectory
    chosen = window_s
    if window_s is None and not fused.looked_ahead:
        chosen = automatic_window_s(path, fused.covariance, order)
    if chosen is None:
        return SmoothedPaths(dict.fromkeys(representations, path), None, fused.held_out)
    by = partial(smooth, method="local_polynomial", window_s=chosen, order=order)
    held_out = fused.held_out and by(fused.held_out, representation=representations[0])
    paths = {name: by(path, representation=name) for name in representations}
    return SmoothedPaths(paths, chosen, held_out)
