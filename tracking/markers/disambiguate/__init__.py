"""The true one of two planar poses, for every observation of every marker, over time.

A small or distant square looks almost the same tilted either way. One image cannot tell; the
motion of the camera over several, which all markers share, can.
"""

from __future__ import annotations

from motorcade.tracking.markers.disambiguate.observations import MarkerObservations, pose_stream
from motorcade.tracking.markers.disambiguate.resolving import (
    FixedLagResolver,
    Resolution,
    best_single,
    resolve,
)
from motorcade.tracking.markers.disambiguate.states import (
    chain_probabilities,
    forward_messages,
    most_probable,
)

__all__ = [
    "FixedLagResolver",
    "MarkerObservations",
    "Resolution",
    "best_single",
    "chain_probabilities",
    "forward_messages",
    "most_probable",
    "pose_stream",
    "resolve",
]
