"""Shadows on one side of things, where the ground is too uneven to fit shadows to it.

Around everything that stands the ground is compared with itself: where a thing keeps the light
away, the ground close beside it is darker on one side, and comes back to its own brightness farther
out. A paint that ends there, or a dark thing that lies flat, does not come back, or is dark on all
sides. It needs no thing to have a form, and tells darkness and direction less well than what
`cast_shadows` fits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.render.light.ground import GroundMap

SMALLEST, LARGEST = 60, 0.12
"""Of a thing: its cells at least, and its share of the map at most."""
SECTORS = 24
FOOT, HIDDEN = 0.25, 0.3
"""A thing stands where the quarter of it nearest to the cameras is; behind it (cosine) it hides
the ground itself."""
BESIDE, OWN_RIM = (0.4, 5.0), 2.0
REACH = 2.5, 8.0, 30.0
"""How far from a thing its shadow is looked for, and the ground that it is compared with: in the
thing's radii, and at least, and at most, so many cells; nearer than the rim, blur mixes the thing
itself with the ground."""
STEPS, SHADED, COUNTS = 8, 0.07, 0.1
"""The ground's own light is fitted to what is around, where what lies darker by more than a share
hardly counts."""
SIDED = 0.5
"""Of a shadow: by what share the other sides are brighter, at least."""
HIDDEN_SKY = 0.25
"""Of the light from all sides: what a thing takes from the ground close beside it by standing
there, half at most; in light without a lamp there is no more."""
FAINT, BLACKEST = HIDDEN_SKY, 0.1
"""Of the ground's light: a shadow takes more than the first, which hidden sky may, and leaves more
than the second, or it is black paint."""
RIM = 0.8, 0.2
"""Of a shadow's darkness: its rim lies between."""
RESOLVED = 4.0
"""Cells: the rim that sharp shadows show, by the blur of images and map and corners of things; as
sharp ones of drawn rooms have it."""
AT_45 = 0.71
"""A lamp's apparent radius over (width of the rim / length of the shadow), for light at 45°: a disc
of radius R spreads the shadow of a height h by a standard deviation of R h / 2 sin(45°)^-1.5, and
1.68 of them lie between the two shares of `RIM`."""
DARK = 0.15
"""Of the brightest ground: what is darker farther out is other ground."""


@dataclass(frozen=True, eq=False)
class CastShadow:
    """What one thing takes from the ground beside it.

    Attributes:
        middle_m: (2,) of the thing, in the ground's frame.
        towards: (2,) unit vector on the ground, against the shadow: where the light comes from.
        darkening: share of light that is gone where the lamp is hidden, beside what is gone
            because the thing hides sky.
        weight: how much of what is gone the shadow explains, 0 to 1.
        lamp_radius_rad: apparent radius of the light by how soft the shadow is, were it 45° high.
        elevation_rad: of the light, by the thing's height; None where that is not seen.

    >>> import numpy as np
    >>> from motorcade.render.light.sides import CastShadow
    >>> CastShadow(np.zeros(2), np.array([1.0, 0.0]), 0.6, 0.9).darkening
    0.6
    """

    middle_m: FloatArray
    towards: FloatArray
    darkening: float
    weight: float
    lamp_radius_rad: float | None = None
    elevation_rad: float | None = None


def sided_shadows(ground: GroundMap, solid: NDArray[np.uint8]) -> list[CastShadow]:
    """Find shadows beside what stands on the ground (n, n), by which side of it is dark."""
    count, label, stats, _ = cv2.connectedComponentsWithStats(solid)
    bright = np.nanquantile(ground.light, 0.9) * DARK
    shadows = []
    for k in range(1, count):
        area = int(stats[k, cv2.CC_STAT_AREA])
        if SMALLEST <= area <= LARGEST * label.size:
            foot, away = _foot(label == k, ground.eye_m / ground.cell_m + 0.5 * len(label) - 0.5)
            around = _around(ground, label == k, solid > 0, foot, away, bright)
            middle_m = (foot + 0.5 - 0.5 * len(label)) * ground.cell_m
            shadow = None if around is None else _one_sided(around, middle_m)
            if shadow is not None and around is not None:
                own = max(shadow.darkening - HIDDEN_SKY, 0.0) / (1.0 - HIDDEN_SKY)
                rim = _lamp_radius(around, shadow)
                shadows.append(replace(shadow, darkening=own, lamp_radius_rad=rim))
    return shadows


def _foot(thing: NDArray[np.bool_], eye: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a thing stands, (2,) cells, and the direction (2,) away from the cameras: what is
    higher than the ground is seen farther that way.
    """
    rows, columns = np.nonzero(thing)
    at = np.stack([columns, rows], axis=1).astype(np.float64)
    away = at.mean(axis=0) - eye
    away /= max(float(np.linalg.norm(away)), 1e-9)
    along = at @ away
    return at[along <= np.quantile(along, FOOT)].mean(axis=0), away


@dataclass(frozen=True, eq=False)
class _Around:
    """The ground around a thing: of each cell (N,) the share of light that is gone by the ground's
    own light there, the distance to the thing in cells, and the direction from it, rad; of each
    sector close beside the thing (SECTORS,) the share that is gone from half the cells, and from
    the darker quarter, NaN where that is not seen; and the thing's radius in cells.
    """

    lost: FloatArray
    apart: FloatArray
    turn: FloatArray
    middle: FloatArray
    darker: FloatArray
    radius: float


def _around(
    ground: GroundMap,
    thing: NDArray[np.bool_],
    anything: NDArray[np.bool_],
    foot: FloatArray,
    away: FloatArray,
    bright: float,
) -> _Around | None:
    """The ground around a thing; None where too little of it is seen."""
    apart = cv2.distanceTransform((~thing).astype(np.uint8), cv2.DIST_L2, 5)
    radius = float(np.sqrt(np.count_nonzero(thing) / np.pi))
    reach = np.clip(REACH[0] * radius, *REACH[1:])
    around = ground.flat & ~anything & (apart <= reach) & (ground.light > 0.0)
    rows, columns = np.nonzero(around)
    light = ground.light[rows, columns]
    if np.count_nonzero(light > bright) < 3 * SECTORS:
        return None
    own = _own_light(np.stack([columns, rows], axis=1) - foot, light, light > bright)
    down, across = np.gradient(apart)  # from the nearest cell of the thing
    turn = np.arctan2(down[rows, columns], across[rows, columns])
    sector = ((turn + np.pi) / (2.0 * np.pi) * SECTORS).astype(int) % SECTORS
    off = apart[rows, columns]
    near = (off > OWN_RIM) & (off <= max(BESIDE[0] * radius, BESIDE[1]))
    near &= (
        (own > bright)
        & (light > BLACKEST * own)
        & (np.cos(turn - np.arctan2(away[1], away[0])) < HIDDEN)
    )
    middle, darker = (1.0 - _by_sector(light / own, sector, near, at) for at in (0.5, 0.25))
    lost = np.where(own > bright, 1.0 - light / own, np.nan)
    return _Around(lost, apart[rows, columns], turn, middle, darker, radius)


def _lamp_radius(around: _Around, shadow: CastShadow) -> float | None:
    """By how the shadow fades out along its middle, from where it is full to where it ends."""
    off = np.abs(np.angle(np.exp(1j * (around.turn - np.arctan2(*-shadow.towards[::-1])))))
    along = (off < np.pi / SECTORS * 2.0) & np.isfinite(around.lost) & (around.apart > OWN_RIM)
    steps = np.arange(1, int(around.apart.max(initial=0.0)) + 1)
    cells = [around.lost[along & (np.abs(around.apart - step) <= 0.7)] for step in steps]
    lost = np.array([np.median(one) if one.size >= 3 else np.nan for one in cells])
    if np.count_nonzero(np.isfinite(lost)) < 4:
        return None
    level = np.interp(steps, steps[np.isfinite(lost)], lost[np.isfinite(lost)])
    level = np.minimum.accumulate(level / level[:2].max())
    if level[-1] > RIM[1]:
        return None
    first, half, last = (float(steps[np.argmax(level <= at)]) for at in (RIM[0], 0.5, RIM[1]))
    width = np.sqrt(max((last - first) ** 2 - RESOLVED**2, 0.0))
    # What throws the shadow's end stands between the thing's side and its middle.
    return float(AT_45 * width / (half + 0.5 * around.radius))


def _own_light(at: FloatArray, light: FloatArray, counts: NDArray[np.bool_]) -> FloatArray:
    """The ground's light (N,) without shadows: a slope of its logarithm, fitted from above."""
    basis = np.column_stack([at, np.ones(len(at))])
    level, weight = np.log(light), counts.astype(np.float64)
    fitted = np.array([0.0, 0.0, float(np.median(level[counts]))])
    for _ in range(STEPS):
        weight = np.where(level < basis @ fitted - SHADED, COUNTS, 1.0) * counts
        fitted = np.linalg.lstsq(basis * weight[:, None], level * weight, rcond=None)[0]
    return np.asarray(np.exp(basis @ fitted))


def _one_sided(around: _Around, middle_m: FloatArray) -> CastShadow | None:
    """The shadow that a profile around a thing shows; None where it shows none on one side."""
    lost, most = around.middle, around.darker
    seen = np.isfinite(lost)
    level = np.maximum(np.nan_to_num(lost), 0.0)
    if np.count_nonzero(seen) < SECTORS // 3 or level.max() < FAINT:
        return None
    angle = (np.arange(SECTORS) + 0.5) / SECTORS * 2.0 * np.pi - np.pi
    closeness = np.cos(angle[:, None] - angle)
    about = np.where(closeness > 0.7, 1.0, 0.0) * seen
    peak = int(np.argmax(about @ level / np.maximum(about.sum(axis=1), 3.0)))
    inside, outside = seen & (closeness[peak] > 0.5), seen & (closeness[peak] < 0.3)
    if not outside.any():
        return None
    mean = float(level[inside].mean())
    sided = 1.0 - float(level[outside].mean()) / mean
    if sided < SIDED:
        return None
    vector = (level * inside) @ np.stack([np.cos(angle), np.sin(angle)], axis=1)
    dark = float(np.nanmax(np.where(inside, most, np.nan)))
    return CastShadow(middle_m, -vector / np.linalg.norm(vector), dark, min(sided, 1.0))


def _by_sector(
    values: FloatArray, sector: NDArray[np.int64], chosen: NDArray[np.bool_], at: float
) -> FloatArray:
    """Quantile of the chosen values of each sector, NaN where there are fewer than three."""
    by_sector = np.full(SECTORS, np.nan)
    for k in range(SECTORS):
        own = values[chosen & (sector == k)]
        if own.size >= 3:
            by_sector[k] = np.quantile(own, at)
    return by_sector
