"""Whether the lens zooms within a clip: the focal lengths that its parts tell, each by itself.

One focal length for a clip that zooms fits no part of it, and what is left is shared out among
distances, distortion and the lens's centre, so that the fit of all may look sure. Parts of it are
short enough to have nearly one focal length each. A part that does not tell one (a print head on,
no parallax) has a wide deviation, and says nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motorcade.ga.arrays import IntArray

PARTS, FEWEST_VIEWS = 5, 5
_SIGMAS, _LEAST, _WORSE = 5.0, 0.15, 3.0
"""Parts differ where they do by so many deviations and this share, which is more than focus does to
a lens; fits' deviations are taken so many times, since corners of a part err alike."""


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
