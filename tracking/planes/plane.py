"""A bounded plane: where it lies, how far it reaches, and how well it is known.

Points of the plane satisfy ``normal . x = distance_m``; in the conformal model that is the vector
``normal + distance_m e∞``. "World" is the frame of the points that the plane was found in.

A plane is fitted to points by orthogonal regression. The covariance takes the points' noise as
independent and of the relative sizes given; its scale comes from the residuals. Depth images have
noise that neighbours share, so there it is too small.

Sources: Pearson 1901; its covariance: Kanatani 1996, ch. 10.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen

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
        if outline.ndim != 2 or len(outline) < 3 or _signed_area(outline) <= 0.0:
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


def _signed_area(outline: FloatArray) -> float:
    """Area of a polygon ``(k, 2)``, negative if it runs clockwise."""
    x, y = outline.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


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
