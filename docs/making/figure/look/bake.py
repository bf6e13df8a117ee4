"""What lies at each pixel of the image: places and normals of the surface, light kept off.

A pixel takes the place that its triangle has there; those beyond a chart's border take the nearest
one's, so that no filter draws in what lies beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from docs.making.figure.look.atlas import Chart
from docs.making.figure.shape.fields import BodyField
from docs.making.figure.shape.pieces import Piece
from motorcade.ga.arrays import FloatArray, IntArray

CELL_M = 0.010
SPREADS_M = (0.012, 0.03, 0.075)
"""How far off something is that keeps light off, in three steps."""


@dataclass(frozen=True, eq=False)
class Texels:
    """Pixels of the image.

    Attributes:
        chart: (H, W) number of the chart.
        points: (H, W, 3) metres.
        normals: (H, W, 3) unit.
        flat_m: (H, W, 2) in the chart's unrolled form.
    """

    chart: IntArray
    points: FloatArray
    normals: FloatArray
    flat_m: FloatArray


def texels_of(
    charts: list[Chart],
    pixels: list[FloatArray],
    surfaces: list[tuple[FloatArray, FloatArray]],
    size: int,
) -> Texels:
    """Fill a square image.

    Args:
        charts: as packed.
        pixels: (N, 2) of each.
        surfaces: vertices and normals (N, 3) of each.
        size: of the image.
    """
    from scipy.ndimage import distance_transform_edt

    owner = np.full((size, size), -1)
    values = np.zeros((size, size, 8))
    for number, (chart, at) in enumerate(zip(charts, pixels, strict=True)):
        known = np.concatenate([*surfaces[number], chart.flat_m], axis=1)
        for corners in chart.triangles:
            _fill(owner, values, number, at[corners], known[corners])
    rows = distance_transform_edt(owner < 0, return_distances=False, return_indices=True)
    owner, values = owner[tuple(rows)], values[tuple(rows)]
    normals = values[..., 3:6]
    normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
    return Texels(owner, values[..., :3], normals, values[..., 6:])


def _fill(
    owner: IntArray, values: FloatArray, number: int, at: FloatArray, known: FloatArray
) -> None:
    """Write one triangle of pixels (3, 2) with values (3, 8), half a pixel beyond its edges."""
    low = np.maximum(np.floor(at.min(axis=0) - 0.5).astype(int), 0)
    high = np.minimum(np.ceil(at.max(axis=0) + 0.5).astype(int), len(owner))
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    edge = np.stack([at[1] - at[0], at[2] - at[0]], axis=1)
    area = float(edge[0, 0] * edge[1, 1] - edge[0, 1] * edge[1, 0])
    if abs(area) < 1e-9 or not x.size:
        return
    dx, dy = x + 0.5 - at[0, 0], y + 0.5 - at[0, 1]
    second = (dx * edge[1, 1] - dy * edge[0, 1]) / area
    third = (dy * edge[0, 0] - dx * edge[1, 0]) / area
    share = np.stack([1.0 - second - third, second, third], axis=-1)
    slack = 0.6 * np.sqrt(2.0 / abs(area))
    inside = share.min(axis=-1) >= -min(slack, 0.5)
    strict = share.min(axis=-1) >= 0.0
    here_owner = owner[low[1] : high[1], low[0] : high[0]]
    write = strict | (inside & (here_owner < 0))
    here_owner[write] = number
    values[low[1] : high[1], low[0] : high[0]][write] = share[write] @ known


def openness(texels: Texels, field: BodyField, all_pieces: list[Piece]) -> FloatArray:
    """Share (H, W) of light from all around that reaches each pixel.

    What is solid is smeared out at three widths; how much of it lies above a surface at that
    distance, beyond what a plane has there, keeps light off.
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    low, high = np.array([-0.32, -0.62, -0.10]), np.array([0.32, 0.62, 1.84])
    counts = np.ceil((high - low) / CELL_M).astype(int)
    nodes = np.moveaxis(np.indices(counts), 0, -1).reshape(-1, 3) * CELL_M + low
    solid = np.clip(0.5 - field.distance_m(nodes, 2 * CELL_M) / CELL_M, 0.0, 1.0).reshape(counts)
    solid[:, :, : int(-low[2] / CELL_M)] *= 0.0  # the ground is the scene's own
    for piece in all_pieces:
        for side in (1.0, -1.0) if piece.mirrored else (1.0,):
            inside = piece.vertices - 0.006 * piece.normals
            corners = inside[piece.triangles]
            points = np.concatenate([inside, corners.mean(axis=1)]) * [1.0, side, 1.0]
            cells = np.round((points - low) / CELL_M).astype(int)
            solid[tuple(cells.T)] = 1.0
    free = np.ones(texels.chart.shape)
    for spread, weight in zip(SPREADS_M, (0.55, 0.75, 0.9), strict=True):
        smeared = gaussian_filter(solid, spread / CELL_M)
        at = (texels.points + spread * texels.normals - low) / CELL_M
        above = map_coordinates(smeared, np.moveaxis(at, -1, 0), order=1, mode="nearest")
        free *= 1.0 - weight * np.clip((above - 0.159) / 0.841, 0.0, 1.0)
    return np.asarray(free)
