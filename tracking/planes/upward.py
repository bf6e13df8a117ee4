"""Which way is up, where nothing measured gravity: a density over all directions, and how sure.

Every piece of evidence is a density over the sphere relative to a uniform one; they multiply, and
each is a mixture with "tells nothing", so that none can rule out what the others say:

- how a camera is held: hardly rolled, looking down at things as often as around. The x axes of
  images taken upright lie in one level plane (Brown & Lowe 2007, section 5);
- the path: a camera that is carried along moves level half of the time;
- surfaces: of flat ones four in ten are level and seen from above, four in ten upright, of which
  half are walls and half lean;
- lines in the images, whose strongest vanishing point near up is up's half of the time
  (Coughlan & Yuille 1999);
- gravity, where it was measured.

The answer is the direction with the most probability around it; what lies elsewhere is its doubt.
Slopes, and images that are turned on purpose, mislead it.

Source of the detector of line segments: LSD, Grompone von Gioi et al. 2010.

Random samples find planes in leaves as well: any band through a cloud of points holds some. Five
shares tell a surface, and multiply: its points keep to the middle of the band that was searched
and are most at its very middle,
there are hardly any just behind that band, they hang together in one patch, and nothing
is seen through it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.planes.plane import INLIER, Plane

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
_MOST_BELIEF = 0.98
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
    return float(_MOST_BELIEF * np.prod(np.clip(shares, 0.0, 1.0)))


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


# Degrees. Steps of the sphere are 2 degrees apart.
_DIRECTIONS = 10_000
_ROLL, _LEVEL_PATH, _GRAVITY, _LINE = 6.0, 5.0, 3.0, 2.0
_SURFACE, _LEANING, _FACING = 4.0, 15.0, 30.0
_AROUND, _AROUND_SPREAD, _THINGS, _SOFT = 10.0, 12.0, (20.0, 90.0), 3.0
# Of mixtures: an image turned on purpose; a path that is level; surfaces that are level, upright
# and ceilings; lines of an image that are upright, and that its strongest direction is up.
_TURNED, _WALKED, _FLOORS, _WALLS, _CEILINGS = 0.05, 0.5, 0.4, 0.4, 0.05
_UPRIGHT_LINES, _LINES_TELL = 0.2, 0.5
# Lines of many images are the same edges, and lenses bend them: they count by this power.
_REPEATED = 0.3
NEAR_DEG, _SAME, _LEANS = 10.0, 8.0, 30.0
_SHORTEST_PATH = 0.02
_LIKELY = 4.0
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class FlatSurface:
    """A flat thing in view, as far as it tells up.

    Fields:
        normal: ``(3,)`` unit, towards the camera.
        belief: the probability that it is a surface at all.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.planes import FlatSurface, estimate_up
    >>> table = FlatSurface(np.array([0.0, -0.1736, -0.9848]), belief=0.9)
    >>> up = estimate_up(Motor.identity().reshape(1), depth_m=1.0, surfaces=[table])
    >>> bool(up.direction @ table.normal > 0.99), up.share < 0.95  # a wall from below, else
    (True, True)
    """

    normal: FloatArray
    belief: float


@dataclass(frozen=True, eq=False)
class UpEstimate:
    """Up, and how the probability of it is spread.

    Fields:
        direction: ``(3,)`` unit, where most probability lies.
        share: of the probability within 10 degrees of it.
        sigma_rad: root mean square angle of that part.
        directions: ``(g, 3)`` all over the sphere.
        mass: ``(g,)`` probability of each.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking.planes import estimate_up
    >>> ahead = Motor.from_translation(np.linspace([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], 20))
    >>> up = estimate_up(ahead, depth_m=3.0)  # carried along the optical axis
    >>> up.direction.round(1) + 0.0
    array([ 0., -1.,  0.])
    >>> 0.5 < up.share < 1.0
    True
    """

    direction: FloatArray
    share: float
    sigma_rad: float
    directions: FloatArray
    mass: FloatArray

    def probability(self, direction: FloatArray, within_deg: float = NEAR_DEG) -> float:
        """That up lies so near a direction ``(3,)``."""
        return float(self.mass[self.directions @ direction > np.cos(np.deg2rad(within_deg))].sum())

    def probability_across(self, normal: FloatArray, within_deg: float = NEAR_DEG) -> float:
        """That a surface with this normal ``(3,)`` stands upright."""
        across = np.abs(self.directions @ normal) < np.sin(np.deg2rad(within_deg))
        return float(self.mass[across].sum())

    def across(self, normal: FloatArray) -> FloatArray:
        """Up ``(3,)`` if a surface with this normal ``(3,)`` stands upright."""
        facing = self.directions @ normal
        mean = (self.mass * (np.abs(facing) < np.sin(np.deg2rad(_LEANS)))) @ self.directions
        return np.asarray(mean / max(float(np.linalg.norm(mean)), _TINY))


def estimate_up(
    world_T_camera: Motor,
    *,
    depth_m: float,
    surfaces: Sequence[FlatSurface] = (),
    lines: FloatArray | None = None,
    gravity_up: FloatArray | None = None,
) -> UpEstimate:
    """Weigh what tells up.

    Args:
        world_T_camera: Motor ``(N,)`` of images that are shown upright.
        depth_m: how far what is seen lies, in the unit of the path.
        surfaces: flat ones that were found.
        lines: ``(s, 2, 3)`` unit rays to the ends of segments, in the world; or None. Those on a
            surface lie in it whichever way up it is, and are better left out.
        gravity_up: ``(3,)`` against gravity, where that was measured.

    Raises:
        ValueError: no pose.
    """
    if len(world_T_camera) == 0:
        raise ValueError("estimate_up(world_T_camera): expected one or more poses, got none")
    up = _sphere()
    density = _held(up, world_T_camera) + _walked(up, world_T_camera.translation_m, depth_m)
    for surface in surfaces:
        level_or_not = _of_surface(up, surface.normal, _head_on(surface.normal, world_T_camera))
        density += np.log(1.0 - surface.belief + surface.belief * level_or_not)
    if gravity_up is not None:
        density += _spot(up @ gravity_up, _GRAVITY, log=True)
    if lines is not None and len(lines):
        density += _of_lines(up, density, lines)
    mass = np.exp(density - density.max())
    return _estimate(up, mass / mass.sum(), surfaces)


def _estimate(up: FloatArray, mass: FloatArray, surfaces: Sequence[FlatSurface]) -> UpEstimate:
    """The direction with most around it, of those that hold some themselves.

    A surface that is turned nearly like it is level, and tells it better.
    """
    some = np.flatnonzero(mass > 1e-3 * mass.max())
    around = (up[some] @ up.T > np.cos(np.deg2rad(_SAME))) @ mass
    best = up[some[int(np.argmax(around))]]
    for _ in range(3):
        near = up @ best > np.cos(np.deg2rad(_SAME))
        best = mass[near] @ up[near]
        best = best / np.linalg.norm(best)
    best = max(
        (one.normal for one in surfaces if one.normal @ best > np.cos(np.deg2rad(_SAME))),
        key=lambda normal: float(normal @ best),
        default=best,
    )
    near = up @ best > np.cos(np.deg2rad(NEAR_DEG))
    angle = np.arccos(np.clip(up[near] @ best, -1.0, 1.0))
    share = float(mass[near].sum())
    sigma = float(np.sqrt(mass[near] @ angle**2 / share))
    return UpEstimate(frozen(best), share, sigma, up, frozen(mass))


@lru_cache(maxsize=1)
def _sphere() -> FloatArray:
    """Directions ``(g, 3)`` evenly over the sphere: Fibonacci's spiral (Gonzalez 2010)."""
    row = np.arange(_DIRECTIONS) + 0.5
    z, turn = 1.0 - 2.0 * row / _DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * row
    ring = np.sqrt(1.0 - z**2)
    return frozen(np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=-1))


def _held(up: FloatArray, world_T_camera: Motor) -> FloatArray:
    """Log density by roll and pitch, the mean over the images, which are one person's."""
    few = np.unique(np.linspace(0, len(world_T_camera) - 1, 20).round().astype(int))
    from scipy.special import ndtr

    axes = world_T_camera[few].as_matrix()[:, :3, :3]
    total = np.zeros(len(up))
    for x, y, z in np.swapaxes(axes, 1, 2):
        roll = np.rad2deg(np.arcsin(np.clip(up @ x, -1.0, 1.0)))
        down = np.rad2deg(np.arctan2(-(up @ z), -(up @ y)))
        upright = (1.0 - _TURNED) * _normal(roll, _ROLL) + _TURNED / 180.0
        low, high = _THINGS
        things = (ndtr((down - low) / _SOFT) - ndtr((down - high) / _SOFT)) / (high - low)
        looking = 0.5 * things + 0.5 * _normal(down - _AROUND, _AROUND_SPREAD)
        total += np.log(upright) + np.log(np.maximum(looking, 1e-6))
    return np.asarray(total / len(few))


def _walked(up: FloatArray, places_m: FloatArray, depth_m: float) -> FloatArray:
    """Log density by how far the path climbs, against its length."""
    away = places_m - places_m.mean(axis=0)
    length = float(np.sqrt(np.mean(np.sum(away**2, axis=1))))
    if length < _SHORTEST_PATH * depth_m:
        return np.zeros(len(up))
    climb = np.sqrt(np.mean((away @ up.T) ** 2, axis=0)) / length
    climb_deg = np.rad2deg(np.arcsin(np.clip(climb, 0.0, 1.0)))
    level = 2.0 * _normal(climb_deg, _LEVEL_PATH) * 90.0
    return np.asarray(np.log(1.0 - _WALKED + _WALKED * level))


def _head_on(normal: FloatArray, world_T_camera: Motor) -> float:
    """How much likelier a wall is turned to the camera like this than in any way."""
    x, _, z = world_T_camera.as_matrix()[:, :3, :3].mean(axis=0).T
    aside = np.rad2deg(np.arctan2(normal @ x, -(normal @ z)))
    return float(360.0 * _normal(aside, _FACING))


def _of_surface(up: FloatArray, normal: FloatArray, head_on: float) -> FloatArray:
    """Density of up where there is a flat surface: its normal, across it, or anywhere."""
    facing = up @ normal
    across = np.rad2deg(np.arcsin(np.clip(facing, -1.0, 1.0)))
    built, leaned = (_normal(across, sigma) for sigma in (_SURFACE, _LEANING))
    wall = head_on * (built + leaned) * np.rad2deg(1.0)
    anywhere = 1.0 - _FLOORS - _WALLS - _CEILINGS
    return np.asarray(
        _FLOORS * _spot(facing, _SURFACE)
        + _CEILINGS * _spot(-facing, _SURFACE)
        + _WALLS * wall
        + anywhere
    )


def _of_lines(up: FloatArray, density: FloatArray, lines: FloatArray) -> FloatArray:
    """Log density by segments that point to or from up, among directions that are likely so far."""
    likely = np.flatnonzero(density > density.max() - _LIKELY)
    middle = lines.sum(axis=1)
    middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
    across = np.cross(lines[:, 0], lines[:, 1])
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), _TINY)
    beside = np.linalg.norm(np.cross(up[likely, None], middle[None]), axis=-1)
    sine = np.abs(up[likely] @ across.T) / np.maximum(beside, _TINY)
    off_deg = np.rad2deg(np.arcsin(np.clip(sine, 0.0, 1.0)))
    ratio = np.where(beside > 0.25, 2.0 * _normal(off_deg, _LINE) * 90.0, 1.0)
    likelihood = _REPEATED * np.log(1.0 - _UPRIGHT_LINES + _UPRIGHT_LINES * ratio).sum(axis=1)
    likelihood = np.exp(likelihood - likelihood.max())
    before = np.exp(density[likely] - density[likely].max())
    likelihood *= before.sum() / (before @ likelihood)
    result = np.full(len(up), np.log(1.0 - _LINES_TELL))
    result[likely] = np.log(1.0 - _LINES_TELL + _LINES_TELL * likelihood)
    return result


def _normal(value_deg: FloatArray, sigma_deg: float) -> FloatArray:
    """A normal density a degree."""
    return np.asarray(
        np.exp(-0.5 * (value_deg / sigma_deg) ** 2) / (sigma_deg * np.sqrt(2.0 * np.pi))
    )


def _spot(cosine: FloatArray, sigma_deg: float, log: bool = False) -> FloatArray:
    """Fisher's density about a direction, relative to a uniform one."""
    concentration = 1.0 / np.deg2rad(sigma_deg) ** 2
    exponent = np.log(2.0 * concentration) + concentration * (cosine - 1.0)
    return np.asarray(exponent if log else np.exp(exponent))


# Images are searched at this width; segments below a share of it have no sure direction.
_WIDTH_PX, _LONG, _MOST = 640, 0.06, 120


def segment_rays(image: GrayImage, camera: Camera, world_T_camera: Motor) -> FloatArray:
    """The longest straight segments of an image.

    Args:
        image: ``(height, width)`` uint8, of the camera's size.
        camera: which took it, distortion and all.
        world_T_camera: its pose.

    Returns:
        ``(s, 2, 3)`` unit rays to the ends of at most 120 segments, in the world's axes; those
        that the lens has no ray for are left out. Curves and textures give segments as well.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.planes import segment_rays
    >>> image = np.zeros((480, 640), np.uint8)
    >>> image[:, 320:] = 200  # an edge from top to bottom
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> rays = segment_rays(image, camera, Motor.identity())
    >>> rays.shape, bool(np.abs(rays[..., 0]).max() < 0.01)
    ((1, 2, 3), True)
    """
    shrink = min(1.0, _WIDTH_PX / max(image.shape))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    segments = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(small)[0]
    if segments is None:
        return np.zeros((0, 2, 3))
    ends = (segments.reshape(-1, 2, 2).astype(np.float64) + 0.5) / shrink - 0.5
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1)
    order = np.argsort(-length, kind="stable")[:_MOST]
    ends = ends[order[length[order] >= _LONG * max(image.shape)]]
    rays = camera.bearings(ends.reshape(-1, 2)).reshape(-1, 2, 3)
    rays = rays[np.isfinite(rays).all(axis=(1, 2))]
    return np.asarray(world_T_camera.rotor.apply(rays))
