"""Whether a plane among points is a surface, and where the foot of a scene lies where none is.

Random samples find planes in leaves as well: any band through a cloud of points holds some. Five
shares tell a surface, and multiply: its points keep to the middle of the band that was searched
and are most at its very middle,
there are hardly any just behind that band, they hang together in one patch, and nothing
is seen through it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.tracking.planes.finding import INLIER
from motorcade.tracking.planes.plane import Plane

# Deviations of points in units of the noise that was searched with: 1.73 where a band is filled
# evenly, 1.2 to 1.7 in what is picked from drawn leaves, trunks and boxes of points, 0.6 to 1.1 in
# drawn floors of less noise than was searched with.
_CLUTTER, _SMOOTH = 1.4, 0.9
# Share of a surface's points in its largest patch; sparse ones fall apart.
_TOGETHER = 0.6
# Deviation over median: 1.15 where a band is filled evenly, as leaves and steps do, 1.48 by normal
# noise; it has no shape to tell where it is much less than was searched with.
_FLAT, _NORMAL, _SHAPED = 1.15, 1.4, 0.5
# Nothing is quite sure.
_MOST = 0.98
_FOOT = 0.05


def belief_in(plane: Plane, points_m: ArrayLike, sigma_m: float, seen_from_m: ArrayLike) -> float:
    """The probability that a plane is a surface.

    Args:
        plane: as `find_planes` gave it.
        points_m: ``(n, 3)`` all points, its own among them.
        sigma_m: with which it was searched for.
        seen_from_m: ``(e, 3)`` places of the camera; a point counts as seen through the plane that
            lies behind its outline from all of them.

    >>> import numpy as np
    >>> from motorcade.tracking.planes import belief_in, find_planes
    >>> rng = np.random.default_rng(0)
    >>> eye = np.array([[0.0, 0.0, 2.0]])
    >>> table = rng.uniform([-1.0, -1.0, 0.0], [1.0, 1.0, 0.01], (300, 3))
    >>> bush = rng.uniform(-1.0, 1.0, (300, 3))
    >>> for points in (table, bush):
    ...     plane = find_planes(points, 0.03, rng, seen_from_m=eye[0]).planes[0]
    ...     print(round(belief_in(plane, points, 0.03, eye), 1))
    1.0
    0.0
    """
    points = checked_floats(points_m, "belief_in(points_m)", (3,))
    above = plane.distances_m(points) / (INLIER * sigma_m)
    within = plane.holds(points)
    off = np.abs(above[within & (np.abs(above) < 1.0)])
    own = len(off)
    below = int(np.count_nonzero(within & (above < -1.0) & (above > -3.0)))
    thin = (_CLUTTER - plane.rms_m / sigma_m) / (_CLUTTER - _SMOOTH)
    apart = (own - below) / max(own + below, 1)
    behind = np.flatnonzero(above < -2.0)
    for eye in np.atleast_2d(checked_floats(seen_from_m, "belief_in(seen_from_m)", (3,))):
        height, depth = plane.distances_m(eye), -plane.distances_m(points[behind])
        if height > 0.0:
            crossing = eye + (height / (height + depth))[:, None] * (points[behind] - eye)
            behind = behind[plane.holds(crossing)]
    opaque = 1.0 - 2.0 * len(behind) / (len(behind) + plane.support)
    shares = [thin, apart, opaque, own / (_TOGETHER * plane.support)]
    if plane.rms_m > _SHAPED * sigma_m and own:
        peak = float(np.sqrt(np.mean(off**2)) / max(float(np.median(off)), 1e-12))
        shares.append((peak - _FLAT) / (_NORMAL - _FLAT))
    return float(_MOST * np.prod(np.clip(shares, 0.0, 1.0)))


def foot_level(points_m: FloatArray, up: FloatArray, below_m: float) -> float:
    """How high along `up` the foot of a scene lies: what hardly any point is beneath.

    Args:
        points_m: ``(n, 3)``.
        up: ``(3,)`` unit.
        below_m: points at this height and above are no foot, where there are others: the camera's.
    """
    height = points_m @ up
    lower = height[height < below_m]
    return float(np.quantile(lower if len(lower) else height, _FOOT))
