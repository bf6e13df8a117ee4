"""Markers in view that make up no board: they stand anywhere, and the recording may map them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.tracking.checks import check_length
from motorcade.tracking.markers.families import check_family
from motorcade.tracking.markers.marker_map import MarkerMap


@dataclass(frozen=True, eq=False)
class LooseMarkers:
    """Markers of one family and size.

    Args:
        family: one of `tracking.FAMILIES`.
        side_m: side of the black squares, metres.
        marker_map: where they stand, if that is known; the world is then the map's.

    Raises:
        ValueError: an unknown family, or a side that is not above zero.
    """

    family: str
    side_m: float
    marker_map: MarkerMap | None = None

    def __post_init__(self) -> None:
        check_family(self.family)
        check_length(self.side_m, "LooseMarkers.side_m")

    def content(self) -> bytes:
        """Everything that a result can depend on."""
        facts = f"{self.family} {self.side_m!r}".encode()
        if self.marker_map is None:
            return facts
        known = self.marker_map
        arrays = (
            known.marker_ids,
            known.side_m,
            known.world_R_marker.coefficients,
            known.origin_m,
        )
        return facts + b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
