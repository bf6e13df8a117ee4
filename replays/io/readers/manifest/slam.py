"""The table of a manifest that names a map of SLAM."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from motorcade.replays.io.errors import RecordingError
from motorcade.replays.io.readers.manifest.section import Section
from motorcade.tracking.slam import MapSnapshot

SLAM_KEYS = ("map_file",)


def section_slam(section: Section, file: Callable[[Section, str], Path]) -> MapSnapshot:
    """Read the map that a manifest's table names.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    try:
        return MapSnapshot.load(file(section, "map_file"))
    except RecordingError:
        raise
    except (ValueError, OSError) as fault:
        raise section.fault("map_file", str(fault)) from fault
