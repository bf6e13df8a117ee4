"""The true one of two planar poses, for every observation of every marker, over time.

A small or distant square looks almost the same tilted either way. One image cannot tell; the
motion of the camera over several, which all markers share, can.
"""

from __future__ import annotations

from motorcade.tracking.markers.disambiguate.observations import MarkerObservations, pose_stream
from motorcade.tracking.markers.disambiguate.resolving import best_single, resolve

__all__ = [
    "MarkerObservations",
    "best_single",
    "pose_stream",
    "resolve",
]
