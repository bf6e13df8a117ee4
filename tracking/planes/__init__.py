"""Planes of a scene for placement: found in map points or depth, hit by rays, chosen as ground.

Also for whoever taps on a picture: `Rays.through_pixels`, then `hit_test`.
"""

from motorcade.tracking.planes.finding import FoundPlanes, find_planes, find_planes_in_depth
from motorcade.tracking.planes.plane import Plane, choose_floor, choose_stage, fit_plane
from motorcade.tracking.planes.rays import Hit, Rays, hit_test

__all__ = [
    "FoundPlanes",
    "Hit",
    "Plane",
    "Rays",
    "choose_floor",
    "choose_stage",
    "find_planes",
    "find_planes_in_depth",
    "fit_plane",
    "hit_test",
]
