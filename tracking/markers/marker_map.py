"""Markers of known size at known places, in any arrangement: a board that need not be flat.

Written to and read from JSON, lengths in metres, so that one recording's map serves the next.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.ga.files import read_bounded
from motorcade.tracking.markers.families import marker_points_m

_FORMAT = "motorcade marker map 1"
_UNITS = {"side_m": "metres", "translation_m": "metres", "quaternion_wxyz": "1"}
MAX_FILE_BYTES = 16 << 20
_MOST_MARKERS = 100_000


@dataclass(frozen=True, eq=False)
class MarkerMap:
    """Where markers stand.

    A marker's frame has its origin at its printed top-left corner, x right and y up as printed, z
    out of its face.

    Args:
        marker_ids: ``(M,)`` rising.
        side_m: ``(M,)`` sides of the black squares, metres.
        world_R_marker: Rotor ``(M,)``.
        origin_m: ``(M, 3)`` the markers' top-left corners in the world, metres.

    Raises:
        ValueError: shapes that do not agree, ids that do not rise, sides that are not above zero,
            numbers that are not finite.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import MarkerMap
    >>> turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.0], [0.0, np.pi / 2, 0.0]])
    >>> room = MarkerMap([4, 9], [0.1, 0.1], turns, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    >>> world_T_marker = room.world_T_marker[1]
    >>> world_T_marker.apply([0.1, 0.0, 0.0]).round(3)  # its top-right corner in the world
    array([ 1. ,  0. , -0.1])
    >>> room.points_m.shape
    (8, 3)
    """

    marker_ids: IntArray
    side_m: FloatArray
    world_R_marker: Rotor
    origin_m: FloatArray

    def __post_init__(self) -> None:
        ids = np.array(self.marker_ids)
        if ids.ndim != 1 or (ids.size and ids.dtype.kind not in "iu") or np.any(np.diff(ids) <= 0):
            raise ValueError("MarkerMap.marker_ids: expected (M,) whole numbers that rise")
        ids = ids.astype(np.int64)
        ids.setflags(write=False)
        sides = frozen(checked_floats(self.side_m, "MarkerMap.side_m", ()))
        origins = frozen(checked_floats(self.origin_m, "MarkerMap.origin_m", (3,)))
        count = len(ids)
        shapes = (sides.shape, self.world_R_marker.shape, origins.shape)
        if shapes != ((count,), (count,), (count, 3)):
            raise ValueError(
                f"MarkerMap.side_m, world_R_marker, origin_m: expected {count} of each, "
                f"got {shapes}"
            )
        if np.any(sides <= 0.0):
            raise ValueError(f"MarkerMap.side_m: expected metres above 0, got {sides.min()}")
        object.__setattr__(self, "marker_ids", ids)
        object.__setattr__(self, "side_m", sides)
        object.__setattr__(self, "origin_m", origins)

    def __len__(self) -> int:
        """Number of markers."""
        return len(self.marker_ids)

    @property
    def world_T_marker(self) -> Motor:
        """Motor ``(M,)``."""
        return Motor.from_rotor_translation(self.world_R_marker, self.origin_m)

    @property
    def points_m(self) -> FloatArray:
        """Corners ``(4 M, 3)`` in the world, four a marker, clockwise from its printed top left."""
        return self.world_T_marker[:, None].apply(marker_points_m(self.side_m)).reshape(-1, 3)

    @property
    def sides(self) -> dict[int, float]:
        """Side of each marker by id, metres."""
        return dict(zip(self.marker_ids.tolist(), self.side_m.tolist(), strict=True))

    def save(self, path: Path) -> None:
        """Write JSON; the same map gives the same bytes, also after it was read back.

        Raises:
            OSError: a file that cannot be written.
        """
        markers = [
            {
                "id": int(self.marker_ids[row]),
                "side_m": float(self.side_m[row]),
                "quaternion_wxyz": self.world_R_marker[row].as_quaternion().tolist(),
                "translation_m": self.origin_m[row].tolist(),
            }
            for row in range(len(self))
        ]
        content = {"format": _FORMAT, "units": _UNITS, "pose": "world_T_marker", "markers": markers}
        path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> MarkerMap:
        """Read what `save` wrote.

        Raises:
            FileError: a file that cannot be read, or is too large.
            ValueError: a file of another format, or values that are refused.
        """
        data = read_bounded(path, MAX_FILE_BYTES)
        try:
            content = json.loads(data.decode("utf-8"))
            return _parsed(content)
        except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as fault:
            raise ValueError(f"{path}: not a marker map: {fault}") from fault


def _parsed(content: object) -> MarkerMap:
    if not isinstance(content, Mapping) or content.get("format") != _FORMAT:
        raise ValueError(f"expected the format '{_FORMAT}'")
    if content.get("units") != _UNITS:
        raise ValueError(f"expected the units {_UNITS}, got {content.get('units')}")
    markers = content["markers"]
    if not isinstance(markers, list) or len(markers) > _MOST_MARKERS:
        raise ValueError(f"expected a list of at most {_MOST_MARKERS} markers")
    ids = [one["id"] for one in markers]
    if not all(isinstance(one, int) and not isinstance(one, bool) for one in ids):
        raise ValueError("expected ids that are whole numbers")
    columns = [
        np.array([one[name] for one in markers], np.float64).reshape(-1, *shape)
        for name, shape in (("side_m", ()), ("quaternion_wxyz", (4,)), ("translation_m", (3,)))
    ]
    if any(len(column) != len(ids) for column in columns):
        raise ValueError(
            "expected one number of side_m, four of quaternion_wxyz, three of the rest"
        )
    side_m, wxyz, origin_m = columns
    return MarkerMap(np.array(ids, np.int64), side_m, Rotor.from_quaternion(wxyz), origin_m)
