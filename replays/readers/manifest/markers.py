"""The `[markers]` table of a manifest: loose markers in view, and the map that places them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from motorcade.replays.errors import RecordingError
from motorcade.replays.markers.loose import LooseMarkers
from motorcade.replays.readers.manifest.section import Section
from motorcade.tracking.markers import FAMILIES
from motorcade.tracking.markers.marker_map import MarkerMap

__all__ = ["MARKERS_KEYS", "section_markers"]

MARKERS_KEYS = ("family", "side_m", "map_file")


def section_markers(section: Section, file: Callable[[Section, str], Path]) -> LooseMarkers:
    """Make the markers of a manifest's table.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key, or the map's file.
    """
    known = None
    if "map_file" in section:
        try:
            known = MarkerMap.load(file(section, "map_file"))
        except RecordingError:
            raise
        except (ValueError, OSError) as fault:
            raise section.fault("map_file", str(fault)) from fault
    family = section.text("family", tuple(FAMILIES))
    return LooseMarkers(family, section.number("side_m", 1e-6, 1e3), known)
