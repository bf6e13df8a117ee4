"""Shadows that things throw on the ground, found in the images: from where, and how dark.

Around everything that stands on the ground (`GroundMap`) the light that is gone from it is compared
with what a post in its place would take, thrown every way, as long and as soft as may be, beside
what standing there hides of the sky: the way that explains it best tells. How far the thing's top
reaches in the images, over the shadow's length, tells how high the light is. One thing may be a
dark one that lies, or stand on the edge of a sheet of paper; several that say the same are
believed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.render.light.ground import GroundMap
from motorcade.render.light.sides import DARK, LARGEST, SMALLEST, CastShadow, sided_shadows

LARGEST_INSIDE = 0.01
"""Of the map: the inside of a thing that looks alike from everywhere."""
OWN_RIM, REACH = 1.5, (3.0, 16.0, 40.0)
"""Cells beside a thing that blur mixes with it; and how far from it its shadow is looked for, in
its radii, and at least, and at most, so many cells."""
FEWEST_CELLS, MOST_CELLS = 100, 1200
TURNS = 48
LENGTHS, SOFTNESSES = np.geomspace(0.7, 8.0, 9), (0.02, 0.05, 0.09, 0.14, 0.2, 0.3)
"""Of shadows that are tried: their ways, their lengths in the thing's radii, and by how much they
grow softer, as a standard deviation over the distance from the thing."""
RESOLVED = 0.7
"""Cells: the standard deviation of a sharp rim, by the blur of images and map."""
SCALES = (0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.05)
"""In the logarithm of light: Cauchy's weights, step by step, of the fit of the ground's own."""
DARKER = 3.0
"""What lies darker than the fit is so many times as far from it: shadows do not count."""
BRIGHTER, BLACKEST = 0.12, 0.08
"""Of the ground's light: what is brighter than its own by the first is other ground, what is darker
than the second is black paint."""
HIDDEN_SKY = 0.5
"""Of the light from all sides: what a thing takes from the ground close beside it by standing
there, at most."""
FAINT, EXPLAINED = 0.15, 0.5
"""A shadow takes more than the first of the light, and explains the second of what is gone."""
TOGETHER_RAD = np.deg2rad(45.0)
"""Things whose shadows fall farther apart are not all things with shadows."""
AT_45 = 1.2
"""A lamp's apparent radius over the softness of its shadows, for light at 45°: a disc of radius R
spreads the shadow of a height h by a standard deviation of R h / 2 sin(45°)^-1.5."""
REACHES = 0.8
"""Of how far a thing's top is seen beyond its foot, by what scatters over cameras that stand at an
angle of 40 to 80° to each other, as drawn rooms have it: only what most of them see scatters."""
BEGINS = 0.5
"""Of a thing's radius: so far before its middle begins what scatters, for cameras that stand 60°
apart, whose lines of sight leave a round foot at the sine of half that angle. Its foot itself is
seen alike by all."""
BLACK = 0.1
"""Of the brightest ground: what is darker beside what scatters is a black thing."""
FEWEST = 2
"""Where fewer shadows are fitted, the side that is dark is asked."""


def cast_shadows(ground: GroundMap) -> list[CastShadow]:
    """Find shadows beside the things that stand on the ground.

    Args:
        ground: as several images show it.

    Returns:
        One for each thing that has a shadow which falls about as the others do; none where nothing
        stands there, where light comes from straight above or from all sides.
    """
    fitted = _fitted(ground)
    if len(fitted) >= FEWEST:
        return fitted
    sided = sided_shadows(ground, _standing(ground))
    return sided if len(sided) > len(fitted) else fitted


def _fitted(ground: GroundMap) -> list[CastShadow]:
    """Shadows as posts throw them, which fall about one way."""
    tried = [(thing, *_tried(thing)) for thing in _things(ground)]
    tried = [
        fit for fit in tried if fit[2][..., 0].min() < (1.0 - EXPLAINED) * fit[1] and fit[1] > 0.0
    ]
    if not tried:
        return []
    # Each has as much to say as the others, however many cells it has.
    likelihoods = [
        -np.log(np.maximum(left[..., 0].min(axis=(1, 2)) / all_, 0.05)) for _, all_, left in tried
    ]
    common = int(np.argmax(np.sum(likelihoods, axis=0)))
    shadows = [_shadow(ground, *one, common) for one in tried]
    return [shadow for shadow in shadows if shadow is not None]


def things_seen(ground: GroundMap) -> int:
    """How many things stand on the ground, such that the ground beside them is seen.

    Where there are several and none has a shadow (`cast_shadows`), light comes from all sides.
    """
    return sum(
        len(np.unique(np.floor(np.arctan2(*thing.at.T) / np.pi * 12))) >= 12
        for thing in _things(ground)
    )


@dataclass(frozen=True, eq=False)
class _Thing:
    """A thing and the ground around it, in cells: where its foot's middle is (2,), its radius, how
    high it is over how high the cameras are; of each cell (N,) of the ground its place (N, 2) from
    the foot, and the share of light that is gone by the ground's own light there.
    """

    foot: FloatArray
    radius: float
    height: float
    at: FloatArray
    lost: FloatArray


def _things(ground: GroundMap) -> Iterator[_Thing]:
    """What stands on the ground, where enough of it is seen around."""
    solid = _standing(ground)
    count, label, stats, _ = cv2.connectedComponentsWithStats(solid)
    bright = np.nanquantile(ground.light, 0.9) * DARK
    for k in range(1, count):
        area = int(stats[k, cv2.CC_STAT_AREA])
        own = label == k
        cut = sum(np.count_nonzero(edge) for edge in (own[0], own[-1], own[:, 0], own[:, -1]))
        # What lies along the map's edge is no thing; one may reach over it.
        if cut < 2.0 * np.sqrt(area) and SMALLEST <= area <= LARGEST * label.size:
            thing = _around(ground, own, solid > 0, bright)
            if thing is not None:
                yield thing


def _around(
    ground: GroundMap, thing: NDArray[np.bool_], anything: NDArray[np.bool_], bright: float
) -> _Thing | None:
    """A thing and the ground around it; None where too little of that is seen.

    What is higher than the ground is seen farther from the cameras: it stands where it begins.
    """
    eye = ground.eye_m / ground.cell_m + 0.5 * len(thing) - 0.5
    from_eye = np.argwhere(thing)[:, ::-1] - eye
    away = from_eye.mean(axis=0)
    away /= max(float(np.linalg.norm(away)), 1e-9)
    along, across = from_eye @ away, from_eye @ [-away[1], away[0]]
    first, last = np.quantile(along, [0.03, 0.97])
    radius = _radius(across)
    for _ in range(2):  # what stands is seen wider, the farther behind its foot
        radius = _radius(across[along < first + 2.0 * radius])
    middle = float(across[along < first + 2.0 * radius].mean())
    from_eye_to_foot = first + BEGINS * radius
    foot = eye + from_eye_to_foot * away + middle * np.array([-away[1], away[0]])
    beyond = max(last - from_eye_to_foot - radius, 0.0) / REACHES
    apart = cv2.distanceTransform((~thing).astype(np.uint8), cv2.DIST_L2, 5)
    around = ground.flat & ~ground.printed & ~anything & (ground.light > 0.0)
    around &= (apart > OWN_RIM) & (apart <= np.clip(REACH[0] * radius, *REACH[1:]))
    rows, columns = np.nonzero(around)
    light = ground.light[rows, columns]
    if np.count_nonzero(light > bright) < FEWEST_CELLS:
        return None
    at = np.stack([columns, rows], axis=1) - foot
    lost = 1.0 - light / _own_light(at, light, light > bright)
    beside = np.hypot(*at.T) > radius + OWN_RIM  # where all see the thing, nothing scatters
    kept = np.flatnonzero(beside & (lost > -BRIGHTER) & (lost < 1.0 - BLACKEST))
    if len(kept) < FEWEST_CELLS:
        return None
    kept = kept[:: 1 + len(kept) // MOST_CELLS]
    beyond = beyond if beyond > radius else 0.0  # else its top is not seen, or it has none
    height = beyond / (max(from_eye_to_foot, 0.0) + radius + beyond)
    return _Thing(foot, radius, height, at[kept], lost[kept])


def _radius(across: FloatArray) -> float:
    return max(0.525 * float(np.ptp(np.quantile(across, [0.05, 0.95]))), 2.0)


def _own_light(at: FloatArray, light: FloatArray, counts: NDArray[np.bool_]) -> FloatArray:
    """The ground's light (N,) without shadows: a slope of its logarithm, as most of it has it that
    is not darker than the rest.
    """
    basis = np.column_stack([at / np.abs(at).max(), np.ones(len(at))])
    level = np.log(light)
    fitted = np.array([0.0, 0.0, float(np.median(level[counts]))])
    for scale in SCALES:
        off = (level - basis @ fitted) / scale
        weight = counts / np.hypot(1.0, np.where(off < 0.0, DARKER * off, off))
        fitted = np.linalg.lstsq(basis * weight[:, None], level * weight, rcond=None)[0]
    return np.asarray(np.exp(basis @ fitted))


def _tried(thing: _Thing) -> tuple[float, FloatArray]:
    """Sum of squares that hidden sky leaves of what is gone; and for each way, length and softness
    of a shadow beside it what both leave, and what hidden sky then takes: (TURNS, LENGTHS,
    SOFTNESSES, 2).
    """
    radius, apart = thing.radius, np.hypot(*thing.at.T)
    counts = 1.0 / np.maximum(1.0, apart / (3.0 * radius))
    lost, sky = thing.lost * counts, counts * np.exp(np.minimum(radius - apart, 0.0) / radius)
    of_sky, by_sky = sky @ sky, sky @ lost
    rest = lost - np.clip(by_sky / of_sky, 0.0, HIDDEN_SKY) * sky
    tried = np.empty((TURNS, len(LENGTHS), len(SOFTNESSES), 2))
    for k, turn in enumerate(2.0 * np.pi * np.arange(TURNS) / TURNS):
        along, across = (
            thing.at @ [np.cos(turn), np.sin(turn)],
            thing.at @ [-np.sin(turn), np.cos(turn)],
        )
        begins = counts * _step((along + 0.3 * radius) / RESOLVED)
        for j, softness in enumerate(SOFTNESSES):
            sigma = RESOLVED + softness * np.maximum(along, 0.0)
            wide = begins * (_step((radius - across) / sigma) - _step((-radius - across) / sigma))
            ends = (LENGTHS[:, None] + 0.8) * radius - along
            shadow = wide * _step(ends / sigma)
            square, common, by = np.sum(shadow**2, axis=1), shadow @ sky, shadow @ lost
            hidden = (by_sky * square - by * common) / np.maximum(of_sky * square - common**2, 1e-9)
            hidden = np.clip(hidden, 0.0, HIDDEN_SKY)
            dark = np.clip((by - hidden * common) / np.maximum(square, 1e-9), 0.0, 1.0)
            left = lost - dark[:, None] * shadow - hidden[:, None] * sky
            tried[k, :, j] = np.stack([np.sum(left**2, axis=1), hidden], axis=1)
    return float(rest @ rest), tried


def _darkening(thing: _Thing, turn: int, length: float, hidden: float) -> float:
    """What a shadow takes about its middle, beside what hidden sky does; 0 where that is unseen."""
    way = np.exp(-2j * np.pi * turn / TURNS) * (thing.at @ [1.0, 1j]) / thing.radius
    core = (np.abs(way.imag) < 0.6) & (way.real > 0.8) & (way.real < 0.6 * (length + 0.8))
    if np.count_nonzero(core) < 3:
        core = (np.abs(way.imag) < 1.2) & (way.real > -0.3) & (way.real < length + 0.8)
    if not core.any():
        return 0.0
    sky = hidden * np.exp(np.minimum(1.0 - np.abs(way[core]), 0.0))
    return float(np.clip(np.median(thing.lost[core] - sky), 0.0, 1.0))


def _step(x: FloatArray) -> FloatArray:
    """From 0 to 1 as the integral of a Gaussian, nearly."""
    return np.asarray(1.0 / (1.0 + np.exp(np.clip(-1.702 * x, -40.0, 40.0))))


def _shadow(
    ground: GroundMap, thing: _Thing, unexplained: float, tried: FloatArray, common: int
) -> CastShadow | None:
    """The best that was tried, about the way that all have in common; None where it is none."""
    off = (np.arange(TURNS) - common + TURNS // 2) % TURNS - TURNS // 2
    left = np.where(np.abs(off) <= TOGETHER_RAD / (2.0 * np.pi) * TURNS, tried[..., 0].T, np.inf).T
    turn, length, softness = map(int, np.unravel_index(int(np.argmin(left)), left.shape))
    dark, weight = (
        _darkening(thing, turn, LENGTHS[length], float(tried[turn, length, softness, 1])),
        1.0 - float(left.min()) / unexplained,
    )
    if dark < FAINT or weight < EXPLAINED:
        return None
    before, own, after = tried[[turn - 1, turn, (turn + 1) % TURNS], ..., 0].min(axis=(1, 2))
    fine = 0.5 * (before - after) / max(before - 2.0 * own + after, 1e-12)
    angle = 2.0 * np.pi * (float(turn) + float(np.clip(fine, -0.5, 0.5))) / TURNS
    elevation = None
    if ground.eye_high_m > 0.0 and thing.height > 0.0:
        high = thing.height * ground.eye_high_m / ground.cell_m
        elevation = float(np.arctan2(high, LENGTHS[length] * thing.radius))
    return CastShadow(
        (thing.foot + 0.5 - 0.5 * len(ground.light)) * ground.cell_m,
        -np.array([np.cos(angle), np.sin(angle)]),
        dark,
        weight,
        float(AT_45 * SOFTNESSES[softness]) if softness else 0.0,
        elevation,
    )


def _standing(ground: GroundMap) -> NDArray[np.uint8]:
    """Where things stand; what is printed lies, though its edges scatter."""
    with np.errstate(invalid="ignore"):
        scatters = np.isfinite(ground.light) & (ground.scatter > ground.bound) & ~ground.printed
        scatters = _with_black(scatters, ground)
    wide, five = (cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (k, k)) for k in (7, 5))
    solid = cv2.morphologyEx(scatters.astype(np.uint8), cv2.MORPH_CLOSE, wide)
    return np.asarray(cv2.morphologyEx(_filled(solid), cv2.MORPH_OPEN, five), np.uint8)


def _with_black(scatters: NDArray[np.bool_], ground: GroundMap) -> NDArray[np.bool_]:
    """What scatters, and what is black beside it: no shadow is, and a black thing looks alike from
    everywhere.
    """
    black = (ground.light < BLACK * np.nanquantile(ground.light, 0.9)) & ~ground.printed
    count, label, stats, _ = cv2.connectedComponentsWithStats(black.astype(np.uint8))
    beside = np.zeros(count, bool)
    wide = cv2.dilate(scatters.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    beside[np.unique(label[wide & black])] = True
    beside &= stats[:, cv2.CC_STAT_AREA] <= LARGEST * label.size
    beside[0] = False
    return np.asarray(scatters | beside[label])


def _filled(mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A mask without holes of a thing's size."""
    count, label, stats, _ = cv2.connectedComponentsWithStats(1 - mask, connectivity=4)
    small = np.arange(count) > 0
    small &= stats[:, cv2.CC_STAT_AREA] < LARGEST_INSIDE * mask.size
    return np.asarray(mask | small[label], np.uint8)
