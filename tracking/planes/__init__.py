"""Planes of a scene for placement: found in map points or depth, hit by rays; up weighed by them.

Also for whoever taps on a picture: `Rays.through_pixels`, then `hit_test`.
"""

from motorcade.tracking.planes.believed import belief_in, foot_level
from motorcade.tracking.planes.finding import FoundPlanes, find_planes, find_planes_in_depth
from motorcade.tracking.planes.lines import segment_rays
from motorcade.tracking.planes.plane import Plane, fit_plane
from motorcade.tracking.planes.rays import Hit, Rays, hit_test
from motorcade.tracking.planes.upward import FlatSurface, UpEstimate, estimate_up

__all__ = [
    "FlatSurface",
    "FoundPlanes",
    "Hit",
    "Plane",
    "Rays",
    "UpEstimate",
    "belief_in",
    "estimate_up",
    "find_planes",
    "find_planes_in_depth",
    "fit_plane",
    "foot_level",
    "hit_test",
    "segment_rays",
]
