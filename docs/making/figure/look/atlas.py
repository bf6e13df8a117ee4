"""Where a surface lies in the image: cut into charts, unrolled, and packed.

The body is cut where it turns away from the axes of its parts, so that no chart is seen too much
aslant; left and right share their place in the image. Pieces bring their own unrolled form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from docs.making.figure.shape.anatomy import arm_axes
from docs.making.figure.shape.pieces import Piece
from docs.making.figure.shape.surface import SymmetricMesh
from motorcade.ga.arrays import FloatArray, IntArray

PADDING_PX = 5
SHARPER = {"head": 1.45, "eye": 2.6, "mouth": 0.6, "brow": 0.6, "sole": 0.6, "lens": 1.2}
"""How much finer than the rest some parts are painted."""


@dataclass(frozen=True, eq=False)
class Chart:
    """A part of the surface that lies in the image in one piece.

    Attributes:
        name: "body" or that of a piece.
        piece: number of the piece, or -1.
        rows: (N,) vertices of the body or piece.
        triangles: (T, 3) among these rows.
        flat_m: (N, 2) unrolled, from 0 to the right and down.
        finer: how much finer it is painted.
    """

    name: str
    piece: int
    rows: IntArray
    triangles: IntArray
    flat_m: FloatArray
    finer: float


def charts_of(mesh: SymmetricMesh, parts: IntArray, all_pieces: list[Piece]) -> list[Chart]:
    """Charts of the body's left half, then of the pieces.

    Args:
        mesh: the body.
        parts: (V,) numbers of `PARTS`.
        all_pieces: what is put on it.
    """
    half = mesh.triangles[: len(mesh.triangles) // 2]
    made = _body_charts(mesh, half, parts)
    for number, piece in enumerate(all_pieces):
        rows = np.arange(len(piece.vertices))
        finer = SHARPER.get(piece.name, 0.8)
        made.append(Chart(piece.name, number, rows, piece.triangles, piece.flat_m, finer))
    return made


PARTS = ("trunk", "head", "arm", "leg")


def part_of(joint: str) -> int:
    """Number of the part that a joint belongs to."""
    for number, words in enumerate((("head",), ("thigh", "calf", "foot", "toes"))):
        if any(word in joint for word in words):
            return (1, 3)[number]
    if joint.startswith(("left", "right")) and "clavicle" not in joint:
        return 2
    return 0


def _body_charts(mesh: SymmetricMesh, half: IntArray, parts: IntArray) -> list[Chart]:
    corners = mesh.vertices[half]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    part = np.max(parts[half], axis=1)
    axes = np.stack([arm_axes() if name == "arm" else np.eye(3) for name in PARTS])
    ways = np.concatenate([axes, -axes], axis=1)
    seen = np.einsum("tki,ti->tk", ways[part], normal)
    label = part * 6 + np.argmax(seen, axis=1)
    pairs = _neighbours(half)
    label = _smoothed(label, pairs, part, seen)
    charts = []
    for group in _components(label, pairs, len(half)):
        rows, triangles = np.unique(half[group], return_inverse=True)
        way = ways[part[group[0]], label[group[0]] % 6]
        side = np.cross([0.0, 0.0, 1.0] if abs(way[2]) < 0.9 else [1.0, 0.0, 0.0], way)
        side /= np.linalg.norm(side)
        down = np.cross(side, way)
        flat = mesh.vertices[rows] @ np.stack([side, down], axis=1)
        finer = SHARPER.get(PARTS[part[group[0]]], 1.0)
        charts.append(
            Chart("body", -1, rows, triangles.reshape(-1, 3), flat - flat.min(axis=0), finer)
        )
    return charts


def _neighbours(triangles: IntArray) -> IntArray:
    """(P, 2) triangles that share an edge."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    same = np.all(edges[order[1:]] == edges[order[:-1]], axis=1)
    return np.stack([order[:-1][same] // 3, order[1:][same] // 3], axis=1)


def _smoothed(label: IntArray, pairs: IntArray, part: IntArray, seen: FloatArray) -> IntArray:
    """Ragged borders drawn straight: a triangle joins most of its neighbours if it is well seen."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    count = int(label.max()) + 1
    for least in (0.3, 0.3, 0.3, 0.3, 0.15, 0.15):
        votes = np.zeros((len(label), count))
        np.add.at(votes, (both[:, 0], label[both[:, 1]]), 1.0)
        wanted = np.argmax(votes, axis=1)
        enough = votes[np.arange(len(label)), wanted] >= 2
        fits = (wanted // 6 == part) & (seen[np.arange(len(label)), wanted % 6] > least)
        label = np.where(enough & fits, wanted, label)
    return label


def _components(label: IntArray, pairs: IntArray, count: int) -> list[IntArray]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    same = pairs[label[pairs[:, 0]] == label[pairs[:, 1]]]
    links = coo_array((np.ones(len(same)), (same[:, 0], same[:, 1])), (count, count))
    number, found = connected_components(links, directed=False)
    return [np.flatnonzero(found == k) for k in range(number)]


def packed(charts: list[Chart], size: int) -> tuple[list[FloatArray], float]:
    """Pixels (N, 2) of all charts in a square image, and how many pixels a metre has.

    Charts stand in rows, the tallest first; the largest scale at which all find a place is taken.
    """
    low, high = 50.0, 4000.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _rows(charts, size, middle) else (low, middle)
    places = _rows(charts, size, low)
    made = [
        chart.flat_m * low * chart.finer + place
        for chart, place in zip(charts, places, strict=True)
    ]
    return made, low


def _rows(charts: list[Chart], size: int, scale: float) -> list[FloatArray]:
    """Corners of the charts at a scale, or none where they do not fit."""
    boxes = np.array([chart.flat_m.max(axis=0) * scale * chart.finer for chart in charts])
    boxes = np.ceil(boxes) + 2 * PADDING_PX
    places = np.zeros_like(boxes)
    x = y = tall = 0.0
    for number in np.argsort(-boxes[:, 1], kind="stable"):
        wide, high = boxes[number]
        if x + wide > size:
            x, y, tall = 0.0, y + tall, 0.0
        if y + high > size or wide > size:
            return []
        places[number] = x, y
        x, tall = x + wide, max(tall, high)
    return list(places + PADDING_PX)
