"""Prints of markers read from images: which marker a quad holds, and how well it looks like it.

A quad's bits are told from its own border: planes of brightness are fitted to the white and to the
black cells along its sides, and a bit is white where it is nearer to the white plane. Small markers
are read a second time with each cell sharpened against its neighbours, since blur mixes them.

Libraries accept some wrong bits and never look at the whole print, so texture passes for a marker
now and then. `read_markers` compares every cell, borders included, with the print of the id, after
a linear change of the light across the marker has been taken out.

Sources: Olson 2011 (planes of light); Wang & Olson 2016 (sharpening).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import grey_levels
from motorcade.tracking.markers.families import layout, marker_cells, words_of
from motorcade.tracking.markers.native._quads import Words

# Places in a cell that are sampled, each way, as shares of its side: its inner part.
_INSIDE = np.array([0.35, 0.65])
_SHARPENING = 0.25  # as the AprilTag library does by default
_LEAST_BORDER = 0.75  # share of the border's cells that must have its colour
LEAST_CONTRAST = 5.0
"""Grey levels from black to white below which nothing counts as a marker."""


@dataclass(frozen=True, eq=False)
class Quads:
    """Markers found: ids ``(m,)`` and corners ``(m, 4, 2)``, clockwise from top left."""

    ids: IntArray
    corners_px: FloatArray


def decode_quads(image: GrayImage, corners_px: FloatArray, family: str) -> Quads:
    """Those of quads ``(m, 4, 2)``, clockwise from any corner, that hold markers of a family."""
    if len(corners_px) == 0:
        return Quads(np.empty(0, np.int64), np.empty((0, 4, 2)))
    shape, reader = layout(family), _reader(family)
    levels = _cell_levels(image, corners_px, reader.places)
    white, black = levels @ reader.to_white.T, levels @ reader.to_black.T
    contrast = white - black
    share = 2.0 * (levels - black) / np.maximum(contrast, 1e-3) - 1.0
    border = (share[:, reader.inside] > 0.0) == shape.white_inside
    legible = contrast.min(axis=1) >= LEAST_CONTRAST
    legible &= border.mean(axis=1) >= _LEAST_BORDER
    rows = np.flatnonzero(legible)
    size = reader.size
    plain = share[rows].reshape(-1, size, size)
    padded = np.pad(plain, ((0, 0), (1, 1), (1, 1)), mode="edge")
    around = padded[:, :-2, 1:-1] + padded[:, 2:, 1:-1] + padded[:, 1:-1, :-2] + padded[:, 1:-1, 2:]
    both = np.stack([plain, plain + _SHARPENING * (4.0 * plain - around)], axis=1)
    turned = np.stack([np.rot90(both, turn, axes=(2, 3)) for turn in range(4)], axis=2)
    pad = (size - shape.cells) // 2
    bits = turned[..., shape.bit_rows + pad, shape.bit_columns + pad] > 0.0
    ids, wrong = _words(family).match(words_of(bits).ravel(), shape.most_wrong)
    wrong = wrong.reshape(len(rows), 8)
    best = wrong.argmin(axis=1)
    each = np.arange(len(rows))
    known = wrong[each, best] <= shape.most_wrong
    rows, best, each = rows[known], best[known], each[known]
    order = (np.arange(4) + (best % 4)[:, None]) % 4
    return Quads(ids.reshape(-1, 8)[each, best], corners_px[rows[:, None], order])


@dataclass(frozen=True, eq=False)
class _Reader:
    """How a family's cells and the border beside its sides are sampled.

    Fields:
        size: cells across of what is sampled: the print, and a ring round it where it has none.
        places: ``(size * size, samples, 2)`` in the marker's unit square, x right, y down.
        inside: ``(k,)`` cells along the marker's side, within.
        to_white, to_black: ``(size * size, size * size)`` from cells to planes of light.
    """

    size: int
    places: FloatArray
    inside: IntArray
    to_white: FloatArray
    to_black: FloatArray


@cache
def _reader(family: str) -> _Reader:
    shape = layout(family)
    margin = max(shape.margin, 1)
    size = shape.side_cells + 2 * margin
    place = np.minimum(np.arange(size), np.arange(size)[::-1])
    depth = np.minimum.outer(place, place).ravel()
    planes = [_onto_plane(size, np.flatnonzero(depth == margin - part)) for part in (0, 1)]
    black, white = planes[::-1] if shape.white_inside else planes
    inside = np.flatnonzero(depth == margin)
    return _Reader(size, _places(size, margin), inside, white, black)


def _onto_plane(size: int, cells: IntArray) -> FloatArray:
    """The matrix from levels of all cells to the plane fitted to some, at all cells."""
    ramp = np.linspace(-1.0, 1.0, size)
    basis = np.stack([np.ones(size * size), np.tile(ramp, size), np.repeat(ramp, size)], axis=-1)
    onto = np.zeros((size * size, size * size))
    onto[:, cells] = basis @ np.linalg.pinv(basis[cells])
    return onto


@cache
def _words(family: str) -> Words:
    shape = layout(family)
    return Words(shape.words, len(shape.bit_rows))


@dataclass(frozen=True, eq=False)
class Reading:
    """How well the image agrees with the print, for m markers.

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
        image: grey image.
        corners_px: ``(m, 4, 2)`` clockwise from the printed top-left corner.
        family: of all of them.
        marker_ids: ``(m,)``.
    """
    if len(marker_ids) == 0:
        return Reading(np.empty(0, np.int64), np.empty(0), np.empty(0))
    shape = layout(family)
    prints = [_print(family, int(one)) for one in marker_ids]
    white = np.stack([one[0] for one in prints])
    print_ = np.stack([one[1] for one in prints])
    places = _places(shape.cells, shape.margin)[shape.known.ravel()]
    light = _without_plane(_cell_levels(image, corners_px, places), family)
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
    """Whether each known cell is white, and the same as numbers less their plane."""
    white = marker_cells(family, marker_id)[layout(family).known]
    return white, _without_plane(white[None].astype(np.float64), family)[0]


@cache
def _places(size: int, margin: int) -> FloatArray:
    """The places sampled of ``(size * size,)`` cells, ``(size * size, samples, 2)``.

    In the unit square that lies `margin` cells within: x right, y down.
    """
    inside = np.stack(np.meshgrid(_INSIDE, _INSIDE), axis=-1).reshape(-1, 2)
    down, across = np.divmod(np.arange(size * size), size)
    cell = np.stack([across, down], axis=-1)[:, None] - margin
    places: FloatArray = (cell + inside) / (size - 2 * margin)
    return places


def _cell_levels(image: GrayImage, corners_px: FloatArray, places: FloatArray) -> FloatArray:
    """Mean brightness ``(m, cells)`` over the places ``(cells, samples, 2)`` of each cell."""
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
    # Beyond the horizon of a quad at a slant there is nothing; the image's edge is read.
    mapped: FloatArray = above / np.maximum(scale, 1e-3)
    return mapped


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _without_plane(values: FloatArray, family: str) -> FloatArray:
    """Values ``(m, known cells)`` less the plane that fits them best."""
    basis = _plane(family)
    less: FloatArray = values - (values @ basis.T) @ basis
    return less


@cache
def _plane(family: str) -> FloatArray:
    """Orthonormal basis ``(3, known cells)`` of the planes over a family's known cells."""
    known = layout(family).known
    down, across = np.nonzero(known)
    rows = np.stack([np.ones(len(down)), across, down], axis=-1).astype(np.float64)
    basis: FloatArray = np.linalg.qr(rows)[0].T
    return basis
