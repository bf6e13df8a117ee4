"""Shadows that things throw on the ground, found in the images: from where, how dark, how soft.

Whatever stands on the ground (`GroundMap`) is taken for a post: a round one whose foot, radius and
height hide, in every image, what is not seen there as the other images show the ground. The ground
about it, by the images in which the post hides nothing, is compared with what the post's shadow
would take: away from the light by its height over the light's, as wide as the post, the softer the
higher the edge that throws it, beside what standing there hides of the sky. Least squares under
Cauchy's loss tell all of it, and how well: direction, height, darkness and width of the light.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.render.light.ground import VEIL, GroundMap
from motorcade.render.shadow import DISC

SMALLEST, LARGEST, LARGEST_INSIDE = 60, 0.12, 0.01
"""Of a thing: its cells at least, and its share of the map at most; of its inside that looks alike
from everywhere."""
DARK = 0.15
"""Of the brightest ground: what is darker farther out is other ground."""
OWN_RIM, REACH = 1.5, (3.0, 16.0, 40.0)
"""Cells beside a thing that blur mixes with it; and how far from it its shadow is looked for, in
its radii, and at least, and at most, so many cells, beyond its height."""
FEWEST_CELLS, MOST_CELLS, POST_CELLS = 100, 1200, 900
RESOLVED = 0.7
"""Cells: the standard deviation of a sharp rim, by the blur of images and map."""
SCALES = (0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.05)
"""In the logarithm of light: Cauchy's weights, step by step, of the fit of the ground's own."""
DARKER = 3.0
"""What lies darker than the fit is so many times as far from it: shadows do not count."""
BRIGHTER, BLACKEST = 0.25, 0.08
"""Of the ground's light: what is brighter than its own by the first is other ground, what is darker
than the second is black paint."""
FAINT, SURE, EXPLAINED = 0.15, 3.0, 0.1
"""A shadow takes more than the first of the light, and so many of its deviations, and explains the
last of what is gone."""
TURNED_RAD = np.deg2rad(25.0)
"""A shadow whose direction is less sure than this tells none."""
BLACK = 0.1
"""Of the brightest ground: what is darker beside what scatters is a black thing."""
HIDES, FAR_OFF, STANDS, WIDEST = 0.35, 9.0, 0.97, 0.12
"""Of a post: what a hidden cell of an image costs, where one that is off by three deviations, or
more, costs 1; the share of the cost without it that is left, or it is none; and its radius, as a
share of the map, at most."""
STEPS, STARTS = (0.6, 0.6, 0.3, 0.5), ((0.0, 0.0, 0.0), (-2.0, 0.0, 0.5), (0.7, 0.0, -1.0))
"""Of the search for a post: foot in radii, logarithms of radius and height; and where it starts,
towards the cameras and in both logarithms."""
TURNS, SLOPES, WIDTHS = 36, np.geomspace(0.35, 3.0, 6), (0.0, 0.04)
"""Ways, cotangents of the light's height and squares of its radius that a fit starts from."""
LEAST = np.array([0.0, -1.6, -0.04, 0.0, 0.0, -0.7, 0.0, -0.2])
MOST = np.array([0.0, 1.8, 0.4, 1.0, 0.6, 0.5, 0.0, 0.2])
"""Of what `_Thing.taken` asks, way and height aside."""
NOISE, ALIKE = 0.06, 9.0
"""Of what is gone: its scale; and so many cells are off together."""
USUAL = np.array([0.0, 0.2, 0.015, 0.0, 0.0, 0.0, 0.0, 0.0])
SPREAD = np.array([np.inf, 0.6, 0.1, np.inf, np.inf, 0.25, 0.12, 0.03]) / np.sqrt(ALIKE)
"""What is known before of what `_Thing.taken` asks, and how well: lights stand about 40° high and
are seldom wide, a shadow is as wide and as long as its post says, nearly."""


@dataclass(frozen=True, eq=False)
class CastShadow:
    """What one thing takes from the ground beside it.

    Attributes:
        middle_m: (2,) of the thing, in the ground's frame.
        towards: (2,) unit vector on the ground, against the shadow: where the light comes from.
        darkening: share of light that is gone where the lamp is hidden, beside what is gone
            because the thing hides sky.
        turn_sigma_rad: standard deviation of the direction.
        darkening_sigma: of the darkening.
        radius2: square of the light's apparent radius by how soft the shadow is, rad²; below 0
            where it is sharper than the map resolves.
        radius2_sigma: of that.
        elevation_rad: of the light, by the thing's height; None where that is not seen.
        elevation_sigma_rad: of that.

    >>> import numpy as np
    >>> from motorcade.render.light.cast import CastShadow
    >>> CastShadow(np.zeros(2), np.array([1.0, 0.0]), 0.6).darkening
    0.6
    """

    middle_m: FloatArray
    towards: FloatArray
    darkening: float
    turn_sigma_rad: float = 0.1
    darkening_sigma: float = 0.1
    radius2: float = 0.0
    radius2_sigma: float = 1.0
    elevation_rad: float | None = None
    elevation_sigma_rad: float = 0.15


def cast_shadows(ground: GroundMap) -> list[CastShadow]:
    """Find shadows beside the things that stand on the ground.

    Args:
        ground: as several images show it.

    Returns:
        One for each thing that has a shadow; none where nothing stands there, where light comes
        from straight above or from all sides.
    """
    fits = (_shadow(ground, thing) for thing in _things(ground))
    return [shadow for shadow in fits if shadow is not None]


def things_seen(ground: GroundMap) -> int:
    """How many things stand on the ground, such that the ground beside them is seen.

    Where there are several and none has a shadow (`cast_shadows`), light comes from all sides.
    """
    return sum(
        len(np.unique(np.floor(np.arctan2(*thing.at.T) / np.pi * 12))) >= 12
        for thing in _things(ground)
    )


@dataclass(frozen=True, eq=False)
class _Post:
    """A thing that stands, in cells: where its foot's middle is (2,), its radius and its height."""

    foot: FloatArray
    radius: float
    height: float

    def hides(self, at: FloatArray, eyes: FloatArray, wider: float = 0.0) -> NDArray[np.bool_]:
        """Whether it hides cells (N, 2) from cameras (K, 3): (K, N)."""
        ray = at - eyes[:, None, :2]
        apart = np.maximum(np.linalg.norm(ray, axis=2), 1e-9)
        to_foot = self.foot - eyes[:, None, :2]
        along = np.sum(ray * to_foot, axis=2) / apart
        across = (ray[..., 0] * to_foot[..., 1] - ray[..., 1] * to_foot[..., 0]) / apart
        half = np.sqrt(np.maximum((self.radius + wider) ** 2 - across**2, 0.0))
        above = np.maximum(eyes[:, 2:] - self.height - wider, 0.01 * eyes[:, 2:])
        beyond = (along + half) * eyes[:, 2:] / above
        return np.asarray((half > 0.0) & (apart > along - half) & (apart < beyond))


@dataclass(frozen=True, eq=False)
class _Thing:
    """A post and the ground around it: of each cell (N,) of the ground its place (N, 2) from the
    foot, and the share of light that is gone by the ground's own light there.
    """

    post: _Post
    at: FloatArray
    lost: FloatArray

    def taken(self, p: FloatArray) -> FloatArray:
        """Share of light (N,) that a shadow takes, by the way it falls, rad, the logarithm of the
        cotangent of the light's height, the square of its radius, how dark it is, how much of the
        sky is hidden beside the post, the logarithms of its width over the post's and of the
        height, and the share by which the ground is darker than its own light.
        """
        return np.asarray(p[3] * self.shadow(p) + p[4] * self.sky + p[7])

    def shadow(self, p: FloatArray) -> FloatArray:
        """How much (N,) of the lamp is hidden."""
        way = np.exp(-1j * p[0]) * (self.at @ [1.0, 1j])
        along, across = way.real, way.imag
        width, height, elevation = (
            self.post.radius * np.exp(p[5]),
            np.exp(p[6]),
            np.arctan(np.exp(-p[1])),
        )
        length = height * np.exp(p[1])
        reach = np.clip(along, 0.0, length) / np.cos(elevation) ** 2
        sides, end = (
            np.sqrt(np.maximum(RESOLVED**2 + DISC**2 * p[2] * far**2, 0.1))
            for far in (reach * np.cos(elevation), height / np.sin(elevation) ** 2)
        )
        tip = length + np.sqrt(np.maximum(width**2 - across**2, 0.1 * width**2))
        wide = _step((width - across) / sides) - _step((-width - across) / sides)
        return _step((along + 0.3 * width) / RESOLVED) * wide * _step((tip - along) / end)

    @property
    def sky(self) -> FloatArray:
        """How what standing there hides of the sky falls off (N,)."""
        apart = np.hypot(*self.at.T)
        return np.asarray(np.exp(np.minimum(self.post.radius - apart, 0.0) / self.post.radius))


def _things(ground: GroundMap) -> Iterator[_Thing]:
    """What stands on the ground, where enough of it is seen around."""
    solid = _standing(ground)
    count, label, stats, _ = cv2.connectedComponentsWithStats(solid)
    eyes = ground.eyes_m / ground.cell_m + np.array([0.5, 0.5, 0.0]) * (len(solid) - 1)
    for k in range(1, count):
        area = int(stats[k, cv2.CC_STAT_AREA])
        own = label == k
        cut = sum(np.count_nonzero(edge) for edge in (own[0], own[-1], own[:, 0], own[:, -1]))
        # What lies along the map's edge is no thing; one may reach over it.
        if cut < 2.0 * np.sqrt(area) and SMALLEST <= area <= LARGEST * label.size:
            free = (own | (solid == 0)) & np.isfinite(ground.light)
            post = _fitted(ground, own, free, eyes)
            thing = None if post is None else _around(ground, post, free, eyes)
            if thing is not None:
                yield thing


def _guessed(own: NDArray[np.bool_], eyes: FloatArray) -> _Post:
    """A post by where a thing scatters: what is higher than the ground is seen farther from the
    cameras, and it stands where it begins.
    """
    eye = eyes[:, :2].mean(axis=0)
    from_eye = np.argwhere(own)[:, ::-1] - eye
    away = from_eye.mean(axis=0)
    away /= max(float(np.linalg.norm(away)), 1e-9)
    along, across = from_eye @ away, from_eye @ [-away[1], away[0]]
    first = float(np.quantile(along, 0.03))
    radius = _radius(across)
    for _ in range(2):  # what stands is seen wider, the farther behind its foot
        radius = _radius(across[along < first + 2.0 * radius])
    middle = float(across[along < first + 2.0 * radius].mean())
    foot = eye + (first + 0.5 * radius) * away + middle * np.array([-away[1], away[0]])
    return _Post(foot, radius, radius)


def _radius(across: FloatArray) -> float:
    return max(0.525 * float(np.ptp(np.quantile(across, [0.05, 0.95]))), 2.0)


def _fitted(
    ground: GroundMap, own: NDArray[np.bool_], free: NDArray[np.bool_], eyes: FloatArray
) -> _Post | None:
    """The post that hides, in each image, what that does not show as the others do; None where none
    does. Cells (n, n) are its `own` that scatter, and `free` of other things.
    """
    from scipy.optimize import minimize

    guess = _guessed(own, eyes)
    wide = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(2.0 * guess.radius) + 7,) * 2)
    cells = np.argwhere((cv2.dilate(own.astype(np.uint8), wide) > 0) & free)
    cells = np.random.default_rng(0).permutation(cells)[:POST_CELLS]
    at = cells[:, ::-1].astype(np.float64)
    level = ground.levels[:, cells[:, 0], cells[:, 1]]
    known, scale = np.isfinite(level), 0.5 * ground.bound
    black = level < np.log(BLACK * np.nanquantile(ground.light, 0.9) + VEIL)
    black &= own[cells[:, 0], cells[:, 1]]
    away = guess.foot - eyes[:, :2].mean(axis=0)
    away /= max(float(np.linalg.norm(away)), 1e-9)
    axes = guess.radius * np.stack([away, [-away[1], away[0]]])
    highest = 0.9 * float(eyes[:, 2].mean())

    def post(p: FloatArray) -> _Post:
        height = min(guess.height * float(np.exp(p[3])), highest)
        return _Post(guess.foot + p[:2] @ axes, guess.radius * float(np.exp(p[2])), height)

    def cost(hidden: NDArray[np.bool_]) -> float:
        seen = known & ~hidden
        shown = np.where(seen, level, np.nan)
        seen &= np.count_nonzero(seen, axis=0) >= 2
        off = np.where(seen, np.where(black, FAR_OFF, (shown - _median(shown)) / scale), 0.0)
        left = np.minimum(off**2 / FAR_OFF, 1.0).sum() + HIDES * np.count_nonzero(known & ~seen)
        return float(left)

    def search(start: FloatArray, steps: FloatArray, most: int) -> tuple[float, FloatArray]:
        simplex = start + np.vstack([np.zeros(4), np.diag(steps)])
        ends = {"maxfev": most, "xatol": 0.01, "fatol": 1e-5 * level.size}
        fit: Any = minimize(  # type: ignore[call-overload]
            lambda p: cost(post(p).hides(at, eyes)),
            start,
            method="Nelder-Mead",
            options={"initial_simplex": simplex, **ends},
        )
        return float(fit.fun), fit.x

    starts = [np.array([towards, 0.0, radius, height]) for towards, radius, height in STARTS]
    tried = [search(start, np.array(STEPS), 60) for start in starts]
    least, best = search(min(tried, key=lambda ended: ended[0])[1], 0.5 * np.array(STEPS), 150)
    fitted, n = post(best), len(own)
    inside = np.all((fitted.foot > 0.0) & (fitted.foot < n)) and fitted.radius < WIDEST * n
    return fitted if inside and least < STANDS * cost(np.zeros_like(known)) else None


def _around(
    ground: GroundMap, post: _Post, free: NDArray[np.bool_], eyes: FloatArray
) -> _Thing | None:
    """A thing and the ground around it, by the images from which it hides nothing there; None where
    too little of that is seen.
    """
    rows, columns = np.indices(free.shape)
    apart = np.hypot(columns - post.foot[0], rows - post.foot[1]) - post.radius
    reach = np.clip(REACH[0] * post.radius, *REACH[1:]) + 1.5 * post.height
    cells = np.argwhere((apart > OWN_RIM) & (apart < reach) & free & ~ground.printed)
    at = cells[:, ::-1].astype(np.float64)
    level = ground.levels[:, cells[:, 0], cells[:, 1]]
    level = np.where(post.hides(at, eyes, wider=1.0), np.nan, level)
    middle = _median(level)
    light, scatter = np.exp(middle) - VEIL, 1.4826 * _median(np.abs(level - middle))
    often = np.count_nonzero(np.isfinite(level), axis=0) >= 2
    flat = often & (scatter < ground.bound) & (light > 0.0)
    at, light = at[flat] - post.foot, light[flat]
    bright = light > DARK * np.nanquantile(ground.light, 0.9)
    if np.count_nonzero(bright) < FEWEST_CELLS:
        return None
    lost = 1.0 - light / _own_light(at, light, bright)
    kept = np.flatnonzero((lost > -BRIGHTER) & (lost < 1.0 - BLACKEST))
    kept = np.random.default_rng(0).permutation(kept)[:MOST_CELLS]
    return _Thing(post, at[kept], lost[kept]) if len(kept) >= FEWEST_CELLS else None


def _median(level: NDArray[np.floating[Any]]) -> FloatArray:
    """Median (N,) of what is known of (K, N); NaN where nothing is."""
    ordered = np.sort(level, axis=0)  # NaN at the end
    count = np.count_nonzero(np.isfinite(level), axis=0)
    low, high = np.maximum((count - 1) // 2, 0), count // 2
    high = np.minimum(high, len(level) - 1)
    n = np.arange(level.shape[1])
    return np.asarray(0.5 * (ordered[low, n] + ordered[high, n]), np.float64)


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


def _started(thing: _Thing, counts: FloatArray) -> FloatArray:
    """What a fit starts from: the best of some ways, lengths and widths."""
    start = np.zeros(8)
    start[6] = np.log(thing.post.height)
    rest = np.column_stack([thing.sky, np.ones(len(counts))]) * counts[:, None]
    inverse = np.linalg.pinv(rest)
    lost = thing.lost * counts
    lost = lost - rest @ (inverse @ lost)
    best, most = start, -np.inf
    for turn in 2.0 * np.pi * np.arange(TURNS) / TURNS:
        for slope in np.log(SLOPES):
            for radius2 in WIDTHS:
                start[:3] = turn, slope, radius2
                shadow = thing.shadow(start) * counts
                own = shadow - rest @ (inverse @ shadow)
                dark = float(own @ lost) / max(float(own @ own), 1e-9)
                if dark > 0.0 and dark * float(own @ lost) > most:
                    best, most = start.copy(), dark * float(own @ lost)
                    best[3] = dark
                    best[[4, 7]] = inverse @ (thing.lost * counts - dark * shadow)
    return best


def _step(x: FloatArray) -> FloatArray:
    """From 0 to 1 as the integral of a Gaussian, nearly."""
    return np.asarray(1.0 / (1.0 + np.exp(np.clip(-1.702 * x, -40.0, 40.0))))


def _shadow(ground: GroundMap, thing: _Thing) -> CastShadow | None:
    """The shadow that explains best what is gone around a thing; None where it is none."""
    from scipy.optimize import least_squares

    post = thing.post
    counts = 1.0 / np.maximum(1.0, np.hypot(*thing.at.T) / (3.0 * post.radius))
    start = _started(thing, counts)
    usual = USUAL.copy()
    usual[6] = start[6]

    def robust(left: FloatArray) -> FloatArray:
        """Of which half the squares are Cauchy's loss."""
        left = counts * left / NOISE
        return np.asarray(np.sign(left) * 2.0 * np.sqrt(np.log1p(0.25 * left**2)))

    def off(p: FloatArray) -> FloatArray:
        return np.concatenate([robust(thing.taken(p) - thing.lost), (p - usual) / SPREAD])

    low, high = LEAST.copy(), MOST.copy()
    low[[0, 6]], high[[0, 6]] = start[[0, 6]] - [1.0, 2.0], start[[0, 6]] + [1.0, 2.0]
    fit = least_squares(off, np.clip(start, low, high), bounds=(low, high), max_nfev=40)
    p, slopes = fit.x, np.asarray(fit.jac)
    sigma = np.sqrt(ALIKE * np.diag(np.linalg.pinv(slopes.T @ slopes)))
    plain = np.column_stack([thing.sky, np.ones(len(counts))]) * counts[:, None]
    without = thing.lost - (plain / counts[:, None]) @ (
        np.linalg.pinv(plain) @ (thing.lost * counts)
    )
    turned = p + np.pi * (np.arange(len(p)) == 0)
    left, other, all_gone = (
        float(np.sum(robust(gone) ** 2))
        for gone in (thing.taken(p) - thing.lost, thing.taken(turned) - thing.lost, without)
    )
    dark, explained = p[3] / (1.0 - p[7]), 1.0 - left / all_gone
    if dark < max(FAINT, SURE * sigma[3]) or sigma[0] > TURNED_RAD or explained < EXPLAINED:
        return None
    # What is dark on the other side as well, or runs into a bound, is something else.
    if 1.0 - other / all_gone > 0.5 * explained or np.any(p[1:3] > 0.97 * MOST[1:3]):
        return None
    slope = np.exp(p[1])
    return CastShadow(
        (post.foot + 0.5 - 0.5 * len(ground.light)) * ground.cell_m,
        -np.array([np.cos(p[0]), np.sin(p[0])]),
        float(dark),
        float(sigma[0]),
        float(sigma[3]),
        float(p[2]),
        float(sigma[2]),
        float(np.arctan(1.0 / slope)),
        float(sigma[1] * slope / (1.0 + slope**2)),
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
