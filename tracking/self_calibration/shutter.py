"""A rolling shutter told by points of a scene: the read-out with which they fit best.

How fast the camera moved is known from its path; corners are moved to where a shutter sees them
that reads at once (`tracking.rolling`), for a few read-outs along either axis, and all is fitted.
The squared noise that is left is a parabola in the read-out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.rolling import shift_px
from motorcade.tracking.self_calibration.points import (
    PointFit,
    PointSightings,
    PointState,
    fit_points,
)
from motorcade.tracking.self_calibration.result import ReadoutAxis, ShutterReadout

_TRIED_S = 0.012
_LONGEST_S = 0.04
_SURE_SIGMAS = 4.0
_ROUNDS = 2
_EVERY = 3
_NAMES: tuple[tuple[ReadoutAxis, ReadoutAxis], ...] = (("right", "left"), ("down", "up"))


def fit_with_shutter(
    seen: PointSightings, start: PointState, velocity: FloatArray
) -> tuple[PointSightings, PointFit, ShutterReadout | None]:
    """Fit points, lens and views, with the rolling shutter that they show, if they show one.

    Args:
        seen: corners as they were seen.
        start: a state that is near.
        velocity: twist ``(V, 6)`` per second of each view, in its own frame.

    Returns:
        the corners as a shutter sees them that reads at once, their fit, and the read-out.
    """
    straight, fit, best = seen, fit_points(seen, start), None
    for _ in range(_ROUNDS):
        readouts = [_told(seen, fit.state, velocity, axis) for axis in (0, 1)]
        # The two share what an axis alone explains: the surer one is taken.
        axis = int(np.argmax([abs(r) / max(sigma, 1e-12) for r, sigma in readouts]))
        seconds, sigma = readouts[axis]
        if not _SURE_SIGMAS * sigma < abs(seconds) < _LONGEST_S:
            break
        shutter_s = seconds * np.eye(2)[axis]
        moved = _unrolled(seen, fit.state, velocity, shutter_s)
        again = fit_points(moved, fit.state)
        if again.noise_px >= fit.noise_px:
            break
        straight, fit = moved, again
        best = ShutterReadout(abs(seconds), sigma, _NAMES[axis][int(seconds < 0.0)])
    return straight, fit, best


def _told(
    seen: PointSightings, state: PointState, velocity: FloatArray, axis: int
) -> tuple[float, float]:
    """Read-out along an axis, seconds, and its standard deviation; infinite where none is best.

    Every third point tells it well enough.
    """
    some = np.flatnonzero(seen.point % _EVERY == 0)
    if len(np.unique(seen.view[some])) == len(velocity):  # each view keeps some
        points, which = np.unique(seen.point[some], return_inverse=True)
        seen, state = (
            replace(seen.only(some), point=which),
            replace(state, points=state.points[points]),
        )
    tried = _TRIED_S * np.array([-1.0, 0.0, 1.0])
    squares = [
        fit_points(_unrolled(seen, state, velocity, seconds * np.eye(2)[axis]), state).noise_px ** 2
        for seconds in tried
    ]
    bend, slope, _ = np.polyfit(tried, squares, 2)
    if bend <= 0.0:
        return 0.0, np.inf
    seconds = float(-0.5 * slope / bend)
    least = max(float(np.polyval([bend, slope, squares[1]], seconds)), 0.1 * min(squares))
    return seconds, float(np.sqrt(least / (bend * len(seen.px))))


def _unrolled(
    seen: PointSightings, state: PointState, velocity: FloatArray, shutter_s: FloatArray
) -> PointSightings:
    camera = state.kind.camera(state.numbers, seen.size)
    in_camera = state.world_T_camera[seen.view].inverse().apply(state.points[seen.point])
    ahead = in_camera[:, 2] > 0.0
    shift = np.zeros_like(seen.px)
    shift[ahead] = shift_px(
        camera, in_camera[ahead], velocity[seen.view[ahead]], seen.px[ahead], shutter_s
    )
    return replace(seen, px=seen.px - np.nan_to_num(shift))
