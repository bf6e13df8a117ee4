"""Markers read again: does the picture inside a quad look like the marker that it is said to be?

Libraries accept some wrong bits and never look at the whole print, so texture passes for a marker
now and then. Here every cell, black border included, is compared with the print of the id, after a
linear change of the light across the marker has been taken out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.families import marker_cells

__all__ = ["Reading", "read_markers"]

# Places in a cell that are sampled, each way, as shares of its side: its inner part.
_INSIDE = np.array([0.3, 0.5, 0.7])


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
    white = np.stack([marker_cells(family, int(one)) for one in marker_ids])
    levels = _cell_levels(image, corners_px, white.shape[-1])
    flat, known = levels.reshape(len(white), -1), white.reshape(len(white), -1)
    light, print_ = _without_plane(flat), _without_plane(known.astype(np.float64))
    power = (print_ * print_).sum(axis=-1)
    contrast = (light * print_).sum(axis=-1) / power
    total = np.sqrt((light * light).sum(axis=-1) * power)
    agreement = contrast * power / np.maximum(total, 1e-9)
    # The brightness half-way between black and white at each cell, light's slope included.
    rest = light - contrast[:, None] * print_
    distance = rest + contrast[:, None] * (known - 0.5)
    wrong = ((distance > 0.0) != known).sum(axis=-1)
    return Reading(wrong.astype(np.int64), agreement, contrast)


def _cell_levels(image: GrayImage, corners_px: FloatArray, side: int) -> FloatArray:
    """Mean brightness ``(m, side, side)`` of the inner part of each cell."""
    places = (np.arange(side)[:, None] + _INSIDE).ravel() / side
    grid = np.stack(np.meshgrid(places, places), axis=-1)
    count = len(places)
    mapped = _map_squares(corners_px, grid.reshape(-1, 2)).astype(np.float32)
    levels = cv2.remap(image, mapped, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    blocks = levels.reshape(len(corners_px), side, count // side, side, count // side)
    return cast("FloatArray", blocks.mean(axis=(2, 4), dtype=np.float64))


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
    side = int(np.sqrt(values.shape[-1]))
    ramp = np.linspace(-1.0, 1.0, side)
    plane = [np.ones(side * side), np.tile(ramp, side), np.repeat(ramp, side)]
    basis: NDArray[np.float64] = np.stack([part / np.linalg.norm(part) for part in plane])
    less: FloatArray = values - (values @ basis.T) @ basis
    return less
