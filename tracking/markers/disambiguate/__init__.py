"""The true one of two planar poses, for every sighting of every marker, over time.

A small or distant square looks almost the same tilted either way. One picture cannot tell; the
motion of the camera over several, which all markers share, can.
"""

from __future__ import annotations

from motorcade.tracking.markers.disambiguate.chains import (
    chain_probabilities,
    forward_messages,
    most_probable,
)
from motorcade.tracking.markers.disambiguate.online import FixedLagResolver, resolve_online
from motorcade.tracking.markers.disambiguate.resolving import Resolution, best_single, resolve
from motorcade.tracking.markers.disambiguate.sightings import Sightings, pose_stream

__all__ = [
    "FixedLagResolver",
    "Resolution",
    "Sightings",
    "best_single",
    "chain_probabilities",
    "forward_messages",
    "most_probable",
    "pose_stream",
    "resolve",
    "resolve_online",
]
