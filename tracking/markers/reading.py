"""Markers read again: does the picture inside a quad look like the marker that it is said to be?

Libraries accept some wrong bits and never look at the whole print, so texture passes for a marker
now and then. Here every cell, black border included, is compared with the print of the id, after a
linear change of the light across the marker has been taken out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.families import marker_cells, side_cells
from motorcade.tracking.pictures import grey_levels

__all__ = ["Reading", "read_markers"]

# Places in a cell that are sampled, each way, as shares of its side: its inner part.
_INSIDE = np.array([0.35, 0.65])


@dataclass(frozen=True, eq=False)
class Reading:
    """How well the picture agrees with the print, for m markers.

    Fields:
        wrong_cells: ``(m,)`` cells whose colour is not the print's.
        agreement: ``(m,)`` correlation of the cells' brightness with the print, at most 1.
        contrast: ``(m,)`` grey levels from black to white.
    """

    wrong_cells: IntArray
    agreement: FloatArray
    contrast: FloatArray


def read_markers(
    image: GrayImage, corners_px: FloatArray, family: str, marker_ids: IntArray
) -> Reading:
    """Compare markers with their prints.

    Args:
        image: grey picture.
        corners_px: ``(m, 4, 2)`` clockwise from the printed top-left corner.
        family: of all of them.
        marker_ids: ``(m,)``.
    """
    if len(marker_ids) == 0:
        return Reading(np.empty(0, np.int64), np.empty(0), np.empty(0))
    prints = [_print(family, int(one)) for one in marker_ids]
    white = np.stack([one[0] for one in prints])
    print_ = np.stack([one[1] for one in prints])
    light = _without_plane(_cell_levels(image, corners_px, side_cells(family)))
    power = (print_ * print_).sum(axis=-1)
    contrast = (light * print_).sum(axis=-1) / power
    total = np.sqrt((light * light).sum(axis=-1) * power)
    agreement = contrast * power / np.maximum(total, 1e-9)
    # Brightness less half-way between black and white at each cell, the light's slope included.
    distance = light - contrast[:, None] * (print_ - white + 0.5)
    wrong = ((distance > 0.0) != white).sum(axis=-1)
    return Reading(wrong.astype(np.int64), agreement, contrast)


@cache
def _print(family: str, marker_id: int) -> tuple[NDArray[np.bool_], FloatArray]:
    """Whether each cell ``(side * side,)`` is white, and the same as numbers less their plane."""
    white = marker_cells(family, marker_id).ravel()
    return white, _without_plane(white[None].astype(np.float64))[0]


@cache
def _places(side: int) -> FloatArray:
    """The places sampled in the unit square, ``(side * side, samples, 2)``: x right, y down."""
    inside = np.stack(np.meshgrid(_INSIDE, _INSIDE), axis=-1).reshape(-1, 2)
    down, across = np.divmod(np.arange(side * side), side)
    places: FloatArray = (np.stack([across, down], axis=-1)[:, None] + inside) / side
    return places


def _cell_levels(image: GrayImage, corners_px: FloatArray, side: int) -> FloatArray:
    """Mean brightness ``(m, side * side)`` of the inner part of each cell."""
    places = _places(side)
    levels = grey_levels(image, _map_squares(corners_px, places.reshape(-1, 2)))
    mean: FloatArray = levels.reshape(len(corners_px), *places.shape[:2]).mean(axis=-1)
    return mean


def _map_squares(corners_px: FloatArray, places: FloatArray) -> FloatArray:
    """Map places ``(n, 2)`` of the unit square (y down) into quads ``(m, 4, 2)``: ``(m, n, 2)``.

    The homography of a square has a closed form (Heckbert 1989).
    """
    first, second, third, fourth = np.moveaxis(corners_px, 1, 0)
    to_second, to_fourth, gap = second - third, fourth - third, first - second + third - fourth
    area = _cross(to_second, to_fourth)
    area = np.where(np.abs(area) < 1e-12, 1e-12, area)
    along = (_cross(gap, to_fourth) / area)[:, None]
    down = (_cross(to_second, gap) / area)[:, None]
    x, y = places[:, 0, None], places[:, 1, None]
    across = second - first + along * second
    below = fourth - first + down * fourth
    above = across[:, None] * x + below[:, None] * y + first[:, None]
    scale = along[:, None] * x + down[:, None] * y + 1.0
    mapped: FloatArray = above / scale
    return mapped


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _without_plane(values: FloatArray) -> FloatArray:
    """Values ``(m, side * side)`` less the plane that fits them best."""
    basis = _plane(values.shape[-1])
    less: FloatArray = values - (values @ basis.T) @ basis
    return less


@cache
def _plane(cells: int) -> FloatArray:
    """Orthonormal basis ``(3, cells)`` of the planes over a square of cells."""
    side = math.isqrt(cells)
    ramp = np.linspace(-1.0, 1.0, side)
    rows = np.stack([np.ones(cells), np.tile(ramp, side), np.repeat(ramp, side)])
    basis: FloatArray = rows / np.linalg.norm(rows, axis=-1, keepdims=True)
    return basis
