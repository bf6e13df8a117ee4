"""Whether the lens zooms within a clip, and the focal length of each of its moments.

One focal length for a clip that zooms fits no part of it, and what is left is shared out among
distances, distortion and the lens's centre, so that the fit of all may look sure. `follow_zoom`
asks each view of a board or of markers for its own, its pose free, draws a smooth curve through
them, brings all corners to where one focal length shows them, and fits again, in turns. Of a scene
without a print only parts are asked (`focal_range`). A view or part that does not tell its focal
length (a print head on, no parallax) has a wide deviation, and says nothing.

Source: Wahba 1990 (smoothing splines; how smooth, by generalised cross validation).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import MOST_KNOTS, Zoom
from motorcade.tracking.self_calibration.bodies import BodyFit, BodyObservations, BodyState, fit

PARTS, FEWEST_VIEWS = 5, 5
_SIGMAS, _LEAST, _WORSE = 5.0, 0.15, 3.0
"""Parts differ where they do by so many deviations and this share, which is more than focus does to
a lens; fits' deviations are taken so many times, since corners of a part err alike."""

_ROUNDS, _SETTLED, _FARTHEST = 16, 1e-3, 0.3
_KNOTS_HZ = 25.0
_LEFT = 0.25
"""A curve through half of the views leaves less than this of what one focal length leaves of what
the others ask for."""


@dataclass(frozen=True, eq=False)
class FollowedZoom:
    """A clip whose lens zooms, brought to the shortest of its focal lengths.

    Fields:
        log_focal: ``(V,)`` logarithm of each view's focal length, pixels.
        zoom: the same over the shortest, by the clock of the views.
        seen: corners where the shortest shows them.
        state: what was fitted to them.
        sigma: the largest relative deviation between curves through halves of the views.
    """

    log_focal: FloatArray
    zoom: Zoom
    seen: BodyObservations
    state: BodyState
    sigma: float


def follow_zoom(
    seen: BodyObservations, start: BodyState, log_focal: FloatArray | None = None
) -> FollowedZoom | None:
    """The focal length of each moment; None where it hardly changes or the views do not tell.

    Args:
        seen: corners as they were taken.
        start: a state near, of one focal length, or of corners brought to one.
        log_focal: ``(V,)`` where to start from, of such corners.

    A curve is kept where it changes by more than 15 %, which is more than focus does to a lens, and
    one through every second view predicts what the others ask for. It breaks down where a print is
    head on for as long as a zoom lasts, and where that is faster than views follow one another.
    """
    from scipy.interpolate import make_smoothing_spline

    state = start
    curve = np.full(len(seen.time_s), np.log(start.numbers[0])) if log_focal is None else log_focal
    for _ in range(_ROUNDS):
        at_one = _brought(seen, state, curve, float(np.log(state.numbers[0])))
        body_fit = fit(at_one, state)
        curve = curve + np.log(body_fit.state.numbers[0] / state.numbers[0])
        state, focal = body_fit.state, float(body_fit.state.numbers[0])
        asked, weight = _asked(body_fit)
        asked += curve
        weight *= np.exp(2.0 * (curve - np.log(focal)))  # noise of pixels shrinks with them
        spline = make_smoothing_spline(seen.time_s, asked, w=weight)
        step, curve = float(np.abs(spline(seen.time_s) - curve).max()), spline(seen.time_s)
        if step < _SETTLED:
            break
    halves = [
        make_smoothing_spline(seen.time_s[k::2], asked[k::2], w=weight[k::2])(seen.time_s)
        for k in (0, 1)
    ]
    sigma = 0.5 * float(np.abs(halves[0] - halves[1]).max())
    left = weight[1::2] @ (asked - halves[0])[1::2] ** 2
    level = np.average(asked[::2], weights=weight[::2])
    if left > _LEFT * (weight[1::2] @ (asked - level)[1::2] ** 2) or np.ptp(curve) < max(
        _LEAST, _SIGMAS * sigma
    ):
        return None
    knots = 2 + min(int(_KNOTS_HZ * np.ptp(seen.time_s)), MOST_KNOTS - 2)
    time_s = np.linspace(seen.time_s[0], seen.time_s[-1], knots)
    shortest = float(np.min(spline(time_s)))
    brought = _brought(seen, state, curve, shortest)
    numbers = np.append(np.exp(shortest), state.numbers[1:])
    zoom = Zoom(time_s, np.exp(spline(time_s) - shortest))
    return FollowedZoom(curve, zoom, brought, replace(state, numbers=numbers), sigma)


def may_zoom(seen: BodyObservations, body_fit: BodyFit) -> bool:
    """Whether views of a fit with one focal length ask for quite different ones, in their order."""
    if len(seen.time_s) < PARTS * FEWEST_VIEWS:
        return False
    from scipy.interpolate import make_smoothing_spline

    asked, weight = _asked(body_fit)
    spline = make_smoothing_spline(seen.time_s, asked, w=weight)
    return bool(np.ptp(spline(seen.time_s)) > 0.5 * _LEAST)


def _asked(body_fit: BodyFit) -> tuple[FloatArray, FloatArray]:
    """Change of the focal length's logarithm that each view asks for, and its weight."""
    focal = body_fit.state.numbers[0]
    asked = np.clip(body_fit.focal_by_view / focal, -_FARTHEST, _FARTHEST)
    return asked, np.asarray((focal / body_fit.focal_sigma) ** 2)


def _brought(
    seen: BodyObservations, state: BodyState, log_focal: FloatArray, log_wanted: float
) -> BodyObservations:
    """Corners where another focal length shows them, about the centre of a state's lens."""
    ratio = np.exp(log_wanted - log_focal)[seen.view][:, None]
    centre = state.numbers[1:3]
    return replace(seen, px=centre + (seen.px - centre) * ratio, shown_px=seen.px)


def focal_range(
    views: int, focal_of: Callable[[IntArray], tuple[float, float] | None]
) -> tuple[float, float] | None:
    """The shortest and longest focal length of a clip's parts; None where they do not differ.

    Args:
        views: how many there are, in the order of time.
        focal_of: of some views the focal length and its standard deviation, pixels; None where
            they tell none.

    >>> from motorcade.tracking.self_calibration.zooming import focal_range
    >>> focal_range(40, lambda rows: (500.0 + 10.0 * float(rows.mean()), 2.0))
    (535.0, 855.0)
    >>> focal_range(40, lambda rows: (500.0 + float(rows[0] % 2), 2.0)) is None
    True
    """
    parts = np.array_split(np.arange(views), PARTS)
    if views < PARTS * FEWEST_VIEWS:
        return None
    focals = [focal for part in parts if (focal := focal_of(part)) is not None]
    least = min(focals, key=lambda part: part[0] + _SIGMAS * _WORSE * part[1], default=(0.0, 0.0))
    most = max(focals, key=lambda part: part[0] - _SIGMAS * _WORSE * part[1], default=(0.0, 0.0))
    apart = _SIGMAS * _WORSE * float(np.hypot(least[1], most[1]))
    if most[0] - least[0] <= max(apart, _LEAST * least[0]):
        return None
    return least[0], most[0]


def zoom_doubt(shortest: float, longest: float) -> str:
    """What to say of a clip whose lens zooms, focal lengths in pixels."""
    return (
        f"the focal length changes by {longest / shortest - 1.0:.0%} or more within the shot, from "
        f"about {shortest:.0f} to {longest:.0f} px: the lens zooms, and one camera is right in "
        "hardly any frame; take a part of the clip in which it does not"
    )
