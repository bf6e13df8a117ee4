"""A bounded plane, how well it is known, and dominant planes found among points or in depth.

Points of the plane satisfy ``normal . x = distance_m``; in the conformal model that is the vector
``normal + distance_m e∞``. "World" is the frame of the points that the plane was found in.

A plane is fitted to points by orthogonal regression. The covariance takes the points' noise as
independent and of the relative sizes given; its scale comes from the residuals. Depth images have
noise that neighbours share, so there it is too small.

Sources: Pearson 1901; its covariance: Kanatani 1996, ch. 10.

Half of the samples take their points close together, which finds small planes; half take them
anywhere, which finds large ones exactly. The best samples are refined before the winner is chosen
(locally optimised RANSAC), and the winner's points are taken out before the next search.

It finds planes that hold a good share of the points; random clutter holds such shares too where
noise is a good part of the scene's size. Two parallel planes closer than 6 sigma become one.

Sources: Fischler & Bolles 1981; MSAC, Torr & Zisserman 2000; LO-RANSAC, Chum et al. 2003.

The noise of a depth is that of a structured-light camera, 0.0012 + 0.0019 (z - 0.4)^2 m
(Nguyen, Izadi & Lovell 2012): right for the recordings with real depth, generous for exact ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera

_INSIDE_M = 1e-9
# Rays that climb less than this over their own length are taken as parallel to the plane.
_PARALLEL = 1e-9
# Points that spread less than this many times their noise across a line fix no plane.
LEAST_SPREAD = 3.0
_CELLS = 40


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane with its own frame: z is the normal, x its longest direction, the origin its middle.

    Fields:
        world_T_plane: the frame; the plane is its z = 0.
        outline: ``(k, 2)`` x and y of a convex outline in that frame, metres, anticlockwise seen
            from where the normal points.
        support: how many points it was fitted to.
        rms_m: root mean square distance of these from it.
        covariance: ``(3, 3)`` of tilt about the frame's x (rad), about its y (rad), and shift along
            its z (m).

    Raises:
        ValueError: a batch of frames, fewer than three corners, corners that run clockwise, a
            negative error, or a covariance that is not symmetric.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking.planes import fit_plane
    >>> x, y = np.meshgrid(np.linspace(0.0, 1.0, 5), np.linspace(0.0, 2.0, 5))
    >>> points_m = np.stack([x, y, 0.0 * x], axis=-1).reshape(-1, 3)
    >>> floor = fit_plane(points_m, towards_m=[0.0, 0.0, 1.5])  # the normal points to the camera
    >>> floor.normal.round(6) + 0.0, floor.support
    (array([0., 0., 1.]), 25)
    >>> other_T_world = Motor.from_rotor_translation(Rotor.identity(), [0.0, 0.0, 0.5])
    >>> round(floor.transformed_by(other_T_world).distance_m, 6)
    0.5
    """

    world_T_plane: Motor
    outline: FloatArray
    support: int
    rms_m: float
    covariance: FloatArray

    def __post_init__(self) -> None:
        if self.world_T_plane.shape != ():
            raise ValueError(
                f"Plane.world_T_plane: expected one pose, got shape {self.world_T_plane.shape}"
            )
        outline = frozen(checked_floats(self.outline, "Plane.outline", (2,)))
        x, y = outline.T if outline.ndim == 2 else np.zeros((2, 1))
        if len(outline) < 3 or x @ np.roll(y, -1) - y @ np.roll(x, -1) <= 0.0:  # twice its area
            raise ValueError(
                "Plane.outline: expected three or more corners anticlockwise, "
                f"got shape {outline.shape}"
            )
        covariance = frozen(checked_floats(self.covariance, "Plane.covariance", (3, 3)))
        if covariance.shape != (3, 3) or not np.allclose(covariance, covariance.T):
            raise ValueError("Plane.covariance: expected one symmetric 3 by 3 matrix")
        if self.support < 3 or not (np.isfinite(self.rms_m) and self.rms_m >= 0.0):
            raise ValueError(
                "Plane: expected 3 or more points and an error from 0 on, "
                f"got support={self.support}, rms_m={self.rms_m}"
            )
        object.__setattr__(self, "outline", outline)
        object.__setattr__(self, "covariance", covariance)

    @property
    def normal(self) -> FloatArray:
        """Unit normal ``(3,)``."""
        return self.world_T_plane.rotor.apply([0.0, 0.0, 1.0])

    @property
    def centre_m(self) -> FloatArray:
        """The frame's origin ``(3,)``: mean of the points it was fitted to."""
        return self.world_T_plane.translation_m

    @property
    def distance_m(self) -> float:
        """Distance from the world's origin along the normal; negative if it lies behind."""
        return float(self.normal @ self.centre_m)

    @property
    def outline_m(self) -> FloatArray:
        """The outline ``(k, 3)`` in the world."""
        return self.world_T_plane.apply(np.pad(self.outline, ((0, 0), (0, 1))))

    @property
    def size_m(self) -> tuple[float, float]:
        """Extent along the frame's x and y."""
        along, across = np.ptp(self.outline, axis=0)
        return float(along), float(across)

    def distances_m(self, points_m: ArrayLike) -> FloatArray:
        """Signed distances ``(*)`` of points ``(*, 3)``, above zero where the normal points."""
        points = checked_floats(points_m, "Plane.distances_m(points_m)", (3,))
        return np.asarray(points @ self.normal - self.distance_m)

    def holds(self, points_m: ArrayLike) -> NDArray[np.bool_]:
        """Whether points ``(*, 3)``, dropped onto the plane, lie inside the outline."""
        points = checked_floats(points_m, "Plane.holds(points_m)", (3,))
        local = self.world_T_plane.inverse().apply(points)[..., None, :2] - self.outline
        edge = np.roll(self.outline, -1, axis=0) - self.outline
        side = edge[:, 0] * local[..., 1] - edge[:, 1] * local[..., 0]
        return np.asarray(np.all(side >= -_INSIDE_M, axis=-1))

    def met_by(self, origin_m: FloatArray, directions: FloatArray) -> FloatArray:
        """Where ``(*, 3)`` rays meet the unbounded plane, from either side; NaN where never.

        Args:
            origin_m: ``(3,)`` where they start.
            directions: ``(*, 3)`` unit; NaN for those that there are not.
        """
        climb = directions @ self.normal
        with np.errstate(divide="ignore", invalid="ignore"):
            reach_m = -self.distances_m(origin_m) / climb
        meets = (np.abs(climb) > _PARALLEL) & (reach_m >= 0.0)
        return np.asarray(origin_m + np.where(meets, reach_m, np.nan)[..., None] * directions)

    def transformed_by(self, motion: Motor) -> Plane:
        """The same plane after a rigid motion, or in another frame: ``other_T_world``."""
        return replace(self, world_T_plane=motion @ self.world_T_plane)


def fit_plane(
    points_m: ArrayLike,
    sigma_m: ArrayLike | None = None,
    *,
    towards_m: ArrayLike = (0.0, 0.0, 0.0),
) -> Plane:
    """Fit a plane to points that all belong to it.

    Args:
        points_m: ``(n, 3)``.
        sigma_m: noise of the points, one number or ``(n,)``; None weighs all alike.
        towards_m: a point on the side that the normal points to.

    Raises:
        ValueError: fewer than three points, NaN, noise that is not above zero, points on one line
            (exactly, or within their noise).
    """
    points = checked_points(points_m, "fit_plane(points_m)", 3)
    eye = checked_floats(towards_m, "fit_plane(towards_m)", (3,))
    weight = np.ones(len(points))
    if sigma_m is not None:
        weight = checked_sigma(sigma_m, len(points), "fit_plane(sigma_m)") ** -2.0
    centre, spread, axes = spread_axes(points, weight)
    noise = 0.0 if sigma_m is None else LEAST_SPREAD**2 * len(points)
    if spread[1] <= max(1e-12 * spread[2], noise):
        raise ValueError("fit_plane(points_m): expected points that do not lie on one line")
    normal, along = axes[:, 0], axes[:, 2]
    if normal @ (eye - centre) < 0.0:
        normal = -normal
    along = along * np.sign(along[np.argmax(np.abs(along))])
    turn = np.stack([along, np.cross(normal, along), normal], axis=-1)
    distances = (points - centre) @ normal
    variance = float(weight @ distances**2) / max(len(points) - 3, 1)
    # Tilt about x moves points by their y, tilt about y by their x.
    known = np.array([spread[1], spread[2], weight.sum()])
    return Plane(
        Motor.from_rotor_translation(Rotor.from_matrix(turn), centre),
        _outline((points - centre) @ turn[:, :2]),
        len(points),
        float(np.sqrt(np.mean(distances**2))),
        np.diag(variance / known),
    )


def spread_axes(
    points: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weighted mean ``(3,)``, sums of squares along the principal axes ``(3,)`` rising, the axes.

    The axes ``(3, 3)`` are the columns.
    """
    centre = weight @ points / weight.sum()
    offset = points - centre
    spread, axes = np.linalg.eigh((offset.T * weight) @ offset)
    return np.asarray(centre), np.maximum(spread, 0.0), axes


def checked_points(value: ArrayLike, name: str, fewest: int) -> FloatArray:
    """Refuse anything but `fewest` or more finite points ``(n, 3)``.

    Raises:
        ValueError: naming the argument.
    """
    points = checked_floats(value, name, (3,))
    if points.ndim != 2 or len(points) < fewest:
        raise ValueError(
            f"{name}: expected {fewest} or more points (n, 3), got shape {points.shape}"
        )
    return points


def checked_sigma(value: ArrayLike, count: int, name: str) -> FloatArray:
    """Noise a point ``(count,)``, from one number or as many.

    Raises:
        ValueError: another count, or noise that is not above zero.
    """
    sigma = checked_floats(value, name, ())
    if sigma.shape not in ((), (count,)) or np.any(sigma <= 0.0):
        raise ValueError(
            f"{name}: expected metres above 0, one or {count}, got shape {sigma.shape} "
            f"from {float(np.min(sigma, initial=np.inf))} on"
        )
    return np.broadcast_to(sigma, (count,))


def _outline(local: FloatArray) -> FloatArray:
    """Convex outline ``(k, 2)``, anticlockwise, of the largest patch that hangs together.

    Points far from the patch would otherwise stretch the outline over what is not there.
    """
    low, extent = local.min(axis=0), np.ptp(local, axis=0)
    cell = np.minimum((local - low) / extent * _CELLS, _CELLS - 1).astype(int)
    taken = np.zeros((_CELLS, _CELLS), dtype=np.uint8)
    taken[cell[:, 0], cell[:, 1]] = 1
    # One empty cell between points is no gap.
    _, patches = cv2.connectedComponents(cv2.dilate(taken, np.ones((3, 3), np.uint8)))
    patch = patches[cell[:, 0], cell[:, 1]]
    kept = local[patch == np.argmax(np.bincount(patch))]
    if len(kept) < 3 or np.linalg.matrix_rank(kept - kept.mean(axis=0), tol=1e-9) < 2:
        kept = local  # so sparse that no patch spans an area
    from scipy.spatial import ConvexHull

    return np.asarray(kept[ConvexHull(kept).vertices])  # anticlockwise, as Qhull has them in 2D


FEWEST = 12
INLIER = 3.0  # sigma
_ASIDE = 6.0  # sigma: nearer points are not searched again, so that no plane is found twice
_AGREEING = np.cos(np.deg2rad(25.0))
_SAMPLES, _POOL, _NEAR = 300, 60, 6
_SCORED = 1500
_REFINED, _ROUNDS = 10, 3
_FINAL_ROUNDS = 10


@dataclass(frozen=True, eq=False)
class FoundPlanes:
    """Planes and the points that belong to them.

    Fields:
        planes: the one with most points first.
        labels: index of each point's plane, ``(n,)`` or the shape of a depth image; -1 for none.

    >>> import numpy as np
    >>> from motorcade.tracking.planes import fit_plane
    >>> from motorcade.tracking.planes.plane import FoundPlanes
    >>> points_m = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 3.0]])
    >>> found = FoundPlanes((fit_plane(points_m[:4]),), labels=np.array([0, 0, 0, 0, -1]))
    >>> points_m[found.labels == 0].shape  # those of the first plane
    (4, 3)
    """

    planes: tuple[Plane, ...]
    labels: IntArray


@dataclass(frozen=True, eq=False)
class _Cloud:
    points: FloatArray
    sigma: FloatArray
    normals: FloatArray | None

    def __len__(self) -> int:
        return len(self.points)

    def part(self, chosen: NDArray[np.generic]) -> _Cloud:
        normals = None if self.normals is None else self.normals[chosen]
        return _Cloud(self.points[chosen], self.sigma[chosen], normals)

    def residuals(self, normals: FloatArray, distances: FloatArray) -> FloatArray:
        """Distances ``(h, n)`` from h planes in units of the noise; infinite across the normals."""
        off = normals @ self.points.T
        off -= distances[:, None]
        off /= self.sigma
        np.abs(off, out=off)
        if self.normals is not None:
            off[np.abs(normals @ self.normals.T) < _AGREEING] = np.inf
        return off


def find_planes(
    points_m: ArrayLike,
    sigma_m: ArrayLike,
    rng: np.random.Generator,
    *,
    seen_from_m: ArrayLike = (0.0, 0.0, 0.0),
    normals: ArrayLike | None = None,
    most: int = 6,
    least_share: float = 0.04,
) -> FoundPlanes:
    """Find the planes that hold most points.

    Args:
        points_m: ``(n, 3)``, 12 or more.
        sigma_m: noise of a point across a plane, one number or ``(n,)``; a point belongs to a plane
            within 3 of it.
        rng: of the samples; the same state finds the same planes.
        seen_from_m: where the camera was; normals point to its side.
        normals: ``(n, 3)`` unit normals of the surface at the points, of either sign; with them a
            point belongs to a plane only if it is turned like it, within 25 degrees.
        most: how many planes to look for.
        least_share: of all points, that a plane must hold.

    Returns:
        Planes by falling support, none where none holds enough points.

    Raises:
        ValueError: too few points, NaN, points on one line, noise that is not above zero, counts
            or shares out of range.

    >>> import numpy as np
    >>> from motorcade.tracking import find_planes
    >>> rng = np.random.default_rng(0)
    >>> floor = rng.uniform([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], (200, 3))
    >>> wall = rng.uniform([1.0, -1.0, 0.0], [1.0, 1.0, 1.0], (100, 3))
    >>> points = np.concatenate([floor, wall]) + rng.normal(0.0, 0.002, (300, 3))
    >>> found = find_planes(points, 0.002, rng, seen_from_m=[0.0, 0.0, 1.0])
    >>> [(plane.normal.round(1) + 0.0).tolist() for plane in found.planes]
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
    """
    points = checked_points(points_m, "find_planes(points_m)", FEWEST)
    sigma = checked_sigma(sigma_m, len(points), "find_planes(sigma_m)")
    if most < 1 or not 0.0 < least_share <= 1.0:
        raise ValueError(
            f"find_planes: expected most >= 1 and 0 < least_share <= 1, got {most}, {least_share}"
        )
    eye = checked_floats(seen_from_m, "find_planes(seen_from_m)", (3,))
    if not _spanning(points, sigma):
        raise ValueError("find_planes(points_m): expected points that do not lie on one line")
    cloud = _Cloud(points, sigma, _checked_normals(normals, len(points)))
    least = max(FEWEST, int(np.ceil(least_share * len(points))))
    planes: list[Plane] = []
    members: list[IntArray] = []
    left = np.arange(len(points))
    while len(planes) < most and len(left) >= least:
        rest = cloud.part(left)
        plane = _dominant(rest, eye, rng)
        if plane is None:
            break
        off = rest.residuals(plane.normal[None], np.array([plane.distance_m]))[0]
        if np.count_nonzero(off < INLIER) < least:
            break
        planes.append(plane)
        members.append(left[off < INLIER])
        left = left[off >= _ASIDE]
    order = np.argsort([-len(own) for own in members], kind="stable")
    labels = np.full(len(points), -1, dtype=np.int64)
    for rank, which in enumerate(order):
        labels[members[which]] = rank
    return FoundPlanes(tuple(planes[which] for which in order), labels)


def _dominant(cloud: _Cloud, eye: FloatArray, rng: np.random.Generator) -> Plane | None:
    """The plane with the best score, refined on all points; None where no sample gives one."""
    scored = cloud
    if len(cloud) > _SCORED:
        scored = cloud.part(rng.choice(len(cloud), _SCORED, replace=False))
    normals, distances = _sampled(scored.points, rng)
    if len(normals) == 0:
        return None
    order = np.argsort(_score(scored.residuals(normals, distances)), kind="stable")[:_REFINED]
    best, best_score = None, np.inf
    for which in order:
        form = _refined(scored, (normals[which], float(distances[which])), _ROUNDS)
        if form is not None:
            score = float(_score(scored.residuals(form[0][None], np.array([form[1]])))[0])
            if score < best_score:
                best, best_score = form, score
    if best is not None:
        best = _refined(cloud, best, _FINAL_ROUNDS)
    if best is None:
        return None
    inside = cloud.residuals(best[0][None], np.array([best[1]]))[0] < INLIER
    own = cloud.part(inside)
    return fit_plane(own.points, own.sigma, towards_m=eye) if _usable(own) else None


def _sampled(points: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Planes through three points each: normals ``(h, 3)`` and distances ``(h,)``."""
    drawn = rng.integers(0, len(points), (_SAMPLES, _POOL))
    near = drawn[: _SAMPLES // 2]
    reach = np.sum((points[near] - points[near[:, :1]]) ** 2, axis=-1)
    nearest = np.argsort(reach, axis=1, kind="stable")[:, 1 : _NEAR + 1]
    near = np.take_along_axis(near, nearest, axis=1)[:, [0, _NEAR // 2, _NEAR - 1]]
    corners = points[np.concatenate([near, drawn[_SAMPLES // 2 :, :3]])]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=-1)
    reach = np.max(np.abs(corners[:, 1:] - corners[:, :1]), axis=(1, 2))
    good = length > 1e-9 * reach**2
    good &= length > 0.0
    normals = normals[good] / length[good, None]
    return normals, np.sum(normals * corners[good, 0], axis=-1)


def _score(residuals: FloatArray) -> FloatArray:
    """Truncated sums of squares ``(h,)``; lower is better."""
    return np.asarray(np.sum(np.minimum(residuals, INLIER) ** 2, axis=1))


def _refined(
    cloud: _Cloud, form: tuple[FloatArray, float], rounds: int
) -> tuple[FloatArray, float] | None:
    """Fit to the points within reach, again and again; None where these fix no plane."""
    inside = None
    for _ in range(rounds):
        now = cloud.residuals(form[0][None], np.array([form[1]]))[0] < INLIER
        if inside is not None and np.array_equal(now, inside):
            break
        inside = now
        own = cloud.part(inside)
        if not _usable(own):
            return None
        centre, _, axes = spread_axes(own.points, own.sigma**-2.0)
        form = (axes[:, 0], float(axes[:, 0] @ centre))
    return form


def _usable(cloud: _Cloud) -> bool:
    return len(cloud) >= 3 and _spanning(cloud.points, cloud.sigma)


def _spanning(points: FloatArray, sigma: FloatArray) -> bool:
    """Whether points spread across a line by more than their noise."""
    spread = spread_axes(points, sigma**-2.0)[1]
    return bool(spread[1] > LEAST_SPREAD**2 * len(points))


def _checked_normals(normals: ArrayLike | None, count: int) -> FloatArray | None:
    if normals is None:
        return None
    unit = checked_floats(normals, "find_planes(normals)", (3,))
    length = np.linalg.norm(unit, axis=-1)
    if unit.shape != (count, 3) or np.any(np.abs(length - 1.0) > 1e-6):
        raise ValueError(
            f"find_planes(normals): expected {count} unit vectors, got shape {unit.shape}"
        )
    return unit


STRIDE = 4
# Slopes are taken over so many steps of the grid to each side.
_STEPS = 2


def find_planes_in_depth(
    depth_m: NDArray[np.floating], camera: Camera, rng: np.random.Generator, *, most: int = 6
) -> FoundPlanes:
    """Find the planes of a depth image, in the camera's frame.

    Args:
        depth_m: ``(height, width)`` along the optical axis; NaN, zero and below where unknown.
        camera: whose image it is.
        rng: of the samples.
        most: how many planes to look for.

    Returns:
        Planes whose normals point to the camera; labels of every fourth pixel of every fourth row,
        ``depth_m[::4, ::4]``.

    Raises:
        ValueError: not of the camera's size, or hardly any depth known.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera, find_planes_in_depth
    >>> camera = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
    >>> wall = np.full((120, 160), 1.5, np.float32)  # 1.5 m before the camera
    >>> [plane] = find_planes_in_depth(wall, camera, np.random.default_rng(0)).planes
    >>> plane.normal.round(3) + 0.0, round(plane.distance_m, 3)  # it faces the camera
    (array([ 0.,  0., -1.]), -1.5)
    """
    if depth_m.shape != (camera.height, camera.width):
        raise ValueError(
            f"depth_m: expected shape {(camera.height, camera.width)}, got {depth_m.shape}"
        )
    depth = np.asarray(depth_m[::STRIDE, ::STRIDE], dtype=np.float64)
    rows, columns = np.mgrid[0 : camera.height : STRIDE, 0 : camera.width : STRIDE]
    with np.errstate(invalid="ignore"):
        depth = np.where(np.isfinite(depth) & (depth > 0.0), depth, np.nan)
    points = camera.unproject(np.stack([columns, rows], axis=-1)) * depth[..., None]
    normals = _normals(points)
    known = np.isfinite(normals[..., 0])
    if np.count_nonzero(known) < FEWEST:
        raise ValueError(
            f"depth_m: expected surfaces to see, got {np.count_nonzero(np.isfinite(depth))} "
            f"pixels with depth among {depth.size}"
        )
    planes = find_planes(
        points[known],
        depth_sigma_m(depth[known]),
        rng,
        normals=normals[known],
        most=most,
    )
    labels = np.full(depth.shape, -1, dtype=np.int64)
    labels[known] = planes.labels
    return FoundPlanes(planes.planes, labels)


def depth_sigma_m(depth_m: FloatArray) -> FloatArray:
    """Noise of depths, metres."""
    return np.asarray(0.0012 + 0.0019 * (depth_m - 0.4) ** 2)


def _normals(points: FloatArray) -> FloatArray:
    """Unit normals ``(h, w, 3)`` of a grid of points; NaN at its rim, beside gaps and at points.

    Where the surface jumps, the slope between its sides is no plane's nearby.
    """
    normals = np.full(points.shape, np.nan)
    step = _STEPS
    if min(points.shape[:2]) <= 2 * step:
        return normals
    along = points[step:-step, 2 * step :] - points[step:-step, : -2 * step]
    down = points[2 * step :, step:-step] - points[: -2 * step, step:-step]
    normal = np.cross(along, down)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / length
    own = np.isfinite(points[step:-step, step:-step])
    normals[step:-step, step:-step] = np.where(own & np.isfinite(normal), normal, np.nan)
    return normals
