"""Maps of markers, estimated from recordings of one or several cameras; rigs tracked by a map."""

from __future__ import annotations

from motorcade.tracking.markers.mapping.estimate import MappedRecording, map_markers, track_rig

__all__ = ["MappedRecording", "map_markers", "track_rig"]
