"""Rays through pixels, and which planes they meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.planes.plane import Plane

# Rays that climb less than this over their own length are taken as parallel to the plane.
_PARALLEL = 1e-9


@dataclass(frozen=True, eq=False)
class Rays:
    """Half lines from one point.

    Fields:
        origin_m: ``(3,)`` where they start.
        directions: ``(*, 3)`` of length 1; NaN for pixels that the lens has no ray for.

    Raises:
        ValueError: wrong shapes, an origin that is not finite, directions of another length.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.planes import Rays, fit_plane, hit_test
    >>> corners = np.array([[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]])
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> ray = Rays.through_pixels(camera, Motor.identity(), [419.5, 239.5])
    >>> [hit] = hit_test([fit_plane(corners)], ray)
    >>> hit.point_m.round(6) + 0.0, hit.inside
    (array([0.4, 0. , 2. ]), True)
    """

    origin_m: FloatArray
    directions: FloatArray

    def __post_init__(self) -> None:
        origin = checked_floats(self.origin_m, "Rays.origin_m", (3,))
        directions = np.asarray(self.directions, dtype=np.float64)
        if origin.shape != (3,) or directions.shape[-1:] != (3,):
            raise ValueError(
                f"Rays: expected an origin (3,) and directions (*, 3), got {origin.shape} and "
                f"{directions.shape}"
            )
        length = np.linalg.norm(directions, axis=-1)
        if np.any(np.abs(length - 1.0) > 1e-6):
            raise ValueError("Rays.directions: expected unit vectors")
        object.__setattr__(self, "origin_m", origin)
        object.__setattr__(self, "directions", directions)

    @classmethod
    def through_pixels(cls, camera: Camera, world_T_camera: Motor, pixels: ArrayLike) -> Rays:
        """Rays from the camera's centre through pixels ``(*, 2)``.

        Raises:
            ValueError: more than one pose, pixels that are not ``(*, 2)`` or not finite.
        """
        if world_T_camera.shape != ():
            raise ValueError(
                f"Rays.through_pixels: expected one pose, got shape {world_T_camera.shape}"
            )
        local = camera.unproject(pixels)
        local /= np.linalg.norm(local, axis=-1, keepdims=True)
        turn = world_T_camera.as_matrix()[:3, :3]
        return cls(world_T_camera.translation_m, local @ turn.T)

    def reach_m(self, plane: Plane) -> FloatArray:
        """How far ``(*)`` along each ray the unbounded plane lies; NaN where it never meets it."""
        climb = self.directions @ plane.normal
        height = float(plane.distances_m(self.origin_m))
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -height / climb
        meets = (np.abs(climb) > _PARALLEL) & (reach >= 0.0)
        return np.where(meets, reach, np.nan)

    def hits(self, plane: Plane) -> FloatArray:
        """Where ``(*, 3)`` the rays meet the unbounded plane, from either side; NaN where never."""
        return self.origin_m + self.reach_m(plane)[..., None] * self.directions


@dataclass(frozen=True, eq=False)
class Hit:
    """Where a ray meets a plane.

    Fields:
        plane: which one.
        point_m: ``(3,)`` in the world.
        distance_m: from the ray's origin.
        inside: whether that is within the plane's outline.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.planes import Rays, fit_plane, hit_test
    >>> wall = fit_plane(np.array([[-1.0, -1, 2], [1, -1, 2], [1, 1, 2], [-1, 1, 2]]))
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> [hit] = hit_test([wall], Rays.through_pixels(camera, Motor.identity(), [319.5, 239.5]))
    >>> round(hit.distance_m, 6), hit.inside
    (2.0, True)
    """

    plane: Plane
    point_m: FloatArray
    distance_m: float
    inside: bool


def hit_test(planes: Sequence[Plane], ray: Rays) -> tuple[Hit, ...]:
    """All planes that one ray meets, nearest first; nothing hides a plane from another.

    Outlines are convex and cover only what was seen: a hit beside one may still be on the surface.

    Raises:
        ValueError: not a single ray.
    """
    if ray.directions.shape != (3,):
        raise ValueError(f"hit_test: expected one ray, got shape {ray.directions.shape[:-1]}")
    hits = []
    for plane in planes:
        point = ray.hits(plane)
        if np.isfinite(point).all():
            distance = float(ray.reach_m(plane))
            hits.append(Hit(plane, point, distance, bool(plane.holds(point))))
    return tuple(sorted(hits, key=lambda hit: hit.distance_m))
