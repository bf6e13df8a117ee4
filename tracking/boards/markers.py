"""Boards of square markers, and single markers: ArUco and AprilTag families.

Corners of a marker run clockwise from the printed top-left one and are crossings of its fitted
sides (see `markers.detection`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import Board, BoardCorners, Pattern
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_count, check_length
from motorcade.tracking.markers.detection import detect_markers, readable
from motorcade.tracking.markers.edges import refine_quads
from motorcade.tracking.markers.families import (
    KALIBR_FAMILY,
    border_share,
    family_size,
    layout,
    marker_cells,
    marker_points_m,
)
from motorcade.tracking.markers.reading import read_markers

_READ = 4
"""Markers that are read again in a frame: no two stand in each other's place alone."""


class _MarkerBoard(Board):
    """What grids and single markers share; markers are numbered from the printed top left."""

    family: str
    turned_deg: int = 0

    @property
    @abstractmethod
    def marker_ids(self) -> IntArray:
        """Ids ``(m,)`` of the markers, in the board's order."""

    @property
    @abstractmethod
    def _first_corners_m(self) -> FloatArray:
        """Top-left corner ``(m, 2)`` of each marker, board frame."""

    @property
    @abstractmethod
    def _side_m(self) -> float: ...

    @property
    def _clear_share(self) -> float:
        """Width next to a marker's side where nothing else is printed, over the side."""
        return border_share(self.family)

    @cached_property
    def points_m(self) -> FloatArray:
        """Corners ``(4 m, 3)``: four a marker, clockwise from its own printed top-left one."""
        first = np.pad(self._first_corners_m, ((0, 0), (0, 1)))
        corners = np.roll(marker_points_m(self._side_m), -(self.turned_deg // 90), axis=0)
        points = (first[:, None] + corners).reshape(-1, 3)
        points.setflags(write=False)
        return points

    def detect(self, image: GrayImage, camera: Camera | None = None) -> BoardCorners | None:
        """Find the board's markers; None where there are none. Other ids are ignored.

        Where an id is seen more than once the larger marker counts.

        Raises:
            ValueError: not a grey uint8 image.
        """
        seen: dict[int, FloatArray] = {}
        for marker in detect_markers(image, self.family, camera):
            before = seen.get(marker.marker_id)
            larger = before is None or _size(marker.corners_px) > _size(before)
            if marker.sharp and larger:
                seen[marker.marker_id] = marker.corners_px
        present = [row for row, marker in enumerate(self.marker_ids) if marker in seen]
        if not present:
            return None
        corner_ids = (4 * np.array(present)[:, None] + np.arange(4)).ravel()
        corners_px = np.concatenate([seen[marker] for marker in self.marker_ids[present]])
        return BoardCorners(corner_ids, corners_px, self.points_m[corner_ids])

    def confirms(
        self, image: GrayImage, corners: BoardCorners, project: Callable[[FloatArray], FloatArray]
    ) -> bool:
        """Whether half of some markers that were tracked read as the ids they were taken for."""
        whole = self._whole(corners)
        count = len(whole) // 4
        some = np.unique(np.linspace(0, max(count - 1, 0), _READ, dtype=np.int64))[:count]
        ids, quads = self.marker_ids[whole.ids[::4] // 4], whole.corners_px.reshape(-1, 4, 2)
        reading = read_markers(image, quads[some], self.family, ids[some])
        return bool(2 * np.count_nonzero(readable(reading)) >= len(some))

    def refine_corners(
        self, image: GrayImage, corners: BoardCorners, camera: Camera | None = None
    ) -> BoardCorners:
        """Put the corners of markers onto the crossings of their sides.

        Markers that have lost a corner, or whose sides do not show, are left out.
        """
        whole = self._whole(corners)
        if len(whole) == 0:
            return whole
        quads = whole.corners_px.reshape(-1, 4, 2)
        sharp, good = refine_quads(
            image, quads, self._clear_share, camera, layout(self.family).white_inside
        )
        return whole.at(sharp.reshape(-1, 2)).keep(np.repeat(good, 4))

    def _whole(self, corners: BoardCorners) -> BoardCorners:
        """The corners of markers of which all four are there."""
        marker, count = np.unique(corners.ids // 4, return_counts=True)
        return corners.keep(np.isin(corners.ids // 4, marker[count == 4]))


@dataclass(frozen=True)
class MarkerGrid(_MarkerBoard):
    """Markers in rows and columns, ids rising row by row from the corner that is the origin.

    That is the printed top left; where ids rise upwards, the printed bottom left, as in Kalibr.

    Args:
        family: one of `families.FAMILIES`.
        columns, rows: markers across and down.
        marker_m: side of a marker, between its corners.
        gap_m: between the sides of neighbours; where bits stand outside of the side, room for them.
        first_id: the lowest id, at the left.
        order: whether ids rise from the top row "down", or from the bottom row "up" as Kalibr's.
        turned_deg: by how much each marker is turned clockwise in its place: 0, 90, 180 or 270.
        corner_squares: whether black squares fill the crossings of the gaps, as on Kalibr's
            AprilGrid.

    Raises:
        ValueError: an unknown family, order or turn, counts below 1, lengths not above zero, more
            markers than the family has, or prints that overlap.

    >>> from motorcade.tracking import MarkerGrid
    >>> board = MarkerGrid("tag36h11", columns=3, rows=2, marker_m=0.03, gap_m=0.009)
    >>> image, origin_px = board.draw(pixels_per_m=2000.0)
    >>> board.detect(image).ids.tolist() == list(range(24))  # four corners of each of six markers
    True
    """

    family: str
    columns: int
    rows: int
    marker_m: float
    gap_m: float
    first_id: int = 0
    order: Literal["down", "up"] = "down"
    turned_deg: int = 0
    corner_squares: bool = False

    def __post_init__(self) -> None:
        if self.order not in ("down", "up") or self.turned_deg not in (0, 90, 180, 270):
            raise ValueError(
                "MarkerGrid: expected order down or up, and turned_deg 0, 90, 180 or 270, "
                f"got {self.order!r} and {self.turned_deg!r}"
            )
        check_count(self.columns, "MarkerGrid.columns", 1)
        check_count(self.rows, "MarkerGrid.rows", 1)
        check_length(self.marker_m, "MarkerGrid.marker_m")
        check_length(self.gap_m, "MarkerGrid.gap_m")
        check_count(self.first_id, "MarkerGrid.first_id", 0)
        last, size = self.first_id + self.columns * self.rows - 1, family_size(self.family)
        if last >= size:
            raise ValueError(
                f"MarkerGrid.first_id: {self.family} has ids 0 to {size - 1}, "
                f"but this grid needs up to {last}"
            )
        least = 2.0 * self._margin_m
        if self.gap_m < least * (1.0 - 1e-9):
            raise ValueError(
                f"MarkerGrid.gap_m: {self.family} has bits outside of its side; expected at least "
                f"{least:g} m beside {self.marker_m:g} m, got {self.gap_m:g}"
            )

    @property
    def name(self) -> str:
        """For example ``tag36h11_6x4_30mm_gap_9mm_from_0``; Kalibr's begin with ``aprilgrid``."""
        stands = f"{self.columns}x{self.rows}_{self.marker_m * 1e3:g}mm_gap_{self.gap_m * 1e3:g}mm"
        kalibr = self.family == KALIBR_FAMILY and self.order == "up" and not self.turned_deg
        if kalibr and self.corner_squares:
            return f"aprilgrid_{stands}" + f"_from_{self.first_id}" * (self.first_id > 0)
        return (
            f"{self.family}_{stands}_from_{self.first_id}"
            + "_up" * (self.order == "up")
            + f"_turned_{self.turned_deg}" * (self.turned_deg > 0)
            + "_squares" * self.corner_squares
        )

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height over all markers, between outermost corners, metres."""
        pitch = self.marker_m + self.gap_m
        return self.columns * pitch - self.gap_m, self.rows * pitch - self.gap_m

    @property
    def marker_ids(self) -> IntArray:
        """Ids ``(columns * rows,)``, row by row as printed."""
        ids = self.first_id + np.arange(self.columns * self.rows).reshape(self.rows, -1)
        return (ids[::-1] if self.order == "up" else ids).ravel()

    @cached_property
    def pattern(self) -> Pattern:
        """Bits and gaps as cells; the quiet zone is two bits wide."""
        cells = layout(self.family).cells
        white = np.ones((self.rows * (cells + 1) + 1, self.columns * (cells + 1) + 1), bool)
        white[:: cells + 1, :: cells + 1] = not self.corner_squares
        for index, marker in enumerate(self.marker_ids):
            top, left = (1 + part * (cells + 1) for part in divmod(index, self.columns))
            printed = np.rot90(marker_cells(self.family, int(marker)), -(self.turned_deg // 90))
            white[top : top + cells, left : left + cells] = printed
        x_edges, y_edges = (
            np.concatenate([[edges[0] - self.gap_m], edges, [edges[-1] + self.gap_m]])
            for edges in (self._edges(self.columns), self._edges(self.rows) - self._origin_down_m)
        )
        if not self.corner_squares:
            white, x_edges, y_edges = white[1:-1, 1:-1], x_edges[1:-1], y_edges[1:-1]
        return Pattern(white, x_edges, y_edges, 2.0 * self._cell_m)

    @property
    def _origin_down_m(self) -> float:
        """How far below the topmost markers' sides the origin lies."""
        return self.size_m[1] if self.order == "up" else 0.0

    @property
    def _cell_m(self) -> float:
        return self.marker_m * border_share(self.family)

    @property
    def _margin_m(self) -> float:
        """What a print reaches beyond its marker's side."""
        return layout(self.family).margin * self._cell_m

    def _edges(self, count: int) -> FloatArray:
        shape = layout(self.family)
        first = np.arange(count)[:, None] * (self.marker_m + self.gap_m)
        within = (np.arange(shape.cells + 1) - shape.margin) * self._cell_m
        edges: FloatArray = (first + within).ravel()
        return edges

    @property
    def _first_corners_m(self) -> FloatArray:
        row, column = np.divmod(np.arange(self.columns * self.rows), self.columns)
        pitch_m = self.marker_m + self.gap_m
        return np.stack([column * pitch_m, self._origin_down_m - row * pitch_m], axis=-1)

    @property
    def _side_m(self) -> float:
        return self.marker_m

    @property
    def _clear_share(self) -> float:
        share = border_share(self.family)
        return share if self._margin_m else min(share, self.gap_m / self.marker_m)


@dataclass(frozen=True)
class SingleMarker(_MarkerBoard):
    """One marker; its frame's origin is its printed top-left corner.

    Args:
        family: one of `families.FAMILIES`.
        marker_id: its id.
        size_m: side of the square between its corners, metres (the file formats' "tag size").

    Raises:
        ValueError: an unknown family, an id it does not have, or a side that is not above zero.

    >>> from motorcade.tracking import SingleMarker
    >>> SingleMarker("tag36h11", marker_id=7, side_m=0.1).points_m[1]  # its top-right corner
    array([0.1, 0. , 0. ])
    """

    family: str
    marker_id: int
    side_m: float

    def __post_init__(self) -> None:
        check_count(self.marker_id, "SingleMarker.marker_id", 0)
        check_length(self.side_m, "SingleMarker.side_m")
        marker_cells(self.family, self.marker_id)

    @property
    def name(self) -> str:
        """For example ``tag36h11_id_7_65mm``."""
        return f"{self.family}_id_{self.marker_id}_{self.side_m * 1e3:g}mm"

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height between its corners, metres."""
        return self.side_m, self.side_m

    @property
    def marker_ids(self) -> IntArray:
        """The one id, ``(1,)``."""
        return np.array([self.marker_id])

    @cached_property
    def pattern(self) -> Pattern:
        """Bits as cells; the quiet zone is two bits wide."""
        shape, cell_m = layout(self.family), self.side_m * border_share(self.family)
        beyond_m = shape.margin * cell_m
        edges = np.linspace(-beyond_m, self.side_m + beyond_m, shape.cells + 1)
        return Pattern(marker_cells(self.family, self.marker_id), edges, edges, 2.0 * cell_m)

    @property
    def _first_corners_m(self) -> FloatArray:
        return np.zeros((1, 2))

    @property
    def _side_m(self) -> float:
        return self.side_m


def _size(corners_px: FloatArray) -> float:
    """Length of a marker's outline, pixels."""
    return float(np.linalg.norm(np.roll(corners_px, 1, axis=0) - corners_px, axis=-1).sum())
