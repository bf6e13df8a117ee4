"""Planes of a scene for placement: found in map points or depth; up is weighed by them."""

from motorcade.tracking.planes.plane import Plane, find_planes, find_planes_in_depth, fit_plane
from motorcade.tracking.planes.upward import (
    FlatSurface,
    UpEstimate,
    belief_in,
    estimate_up,
    foot_level,
    segment_rays,
)

__all__ = [
    "FlatSurface",
    "Plane",
    "UpEstimate",
    "belief_in",
    "estimate_up",
    "find_planes",
    "find_planes_in_depth",
    "fit_plane",
    "foot_level",
    "segment_rays",
]
