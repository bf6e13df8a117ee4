"""Meshes of a Collada document: corners of polygons into vertices and triangles.

A corner names a position, a normal, a texture coordinate and a colour apart; each different
combination becomes a vertex. Polygons are cut into fans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.collada.library import Element, Library, inputs_of, number
from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.limits import MAX_VALUES
from motorcade.ga.arrays import FloatArray, IntArray

KINDS = ("triangles", "polylist", "polygons")
OTHERS = ("tristrips", "trifans", "lines", "linestrips")


@dataclass(frozen=True, eq=False)
class PolygonGroup:
    """Polygons of one material.

    Args:
        material: its symbol.
        positions: (V,) number of each vertex's position in the mesh.
        vertices: (V, 3).
        normals: (V, 3) or None.
        uv: (V, 2) or None.
        colors: (V, 3) or None.
        triangles: (T, 3).
    """

    material: str
    positions: IntArray
    vertices: FloatArray
    normals: FloatArray | None
    uv: FloatArray | None
    colors: FloatArray | None
    triangles: IntArray


def read_geometry(library: Library, geometry: Element) -> tuple[list[PolygonGroup], list[str]]:
    """Parts of a geometry, and what was left out.

    Raises:
        FormatError: no mesh, or numbers that do not fit its sources.
    """
    name = geometry.get("name") or geometry.get("id")
    mesh = geometry.first("mesh")
    if mesh is None:
        raise expected(f"geometry '{name}'", "a <mesh>", "another kind")
    vertices = inputs_of(mesh.needed("vertices"))
    if "POSITION" not in vertices:
        raise expected(f"geometry '{name}'", "positions", sorted(vertices))
    positions = library.source(vertices["POSITION"].get("source"), f"'{name}' POSITION", 3)
    if not len(positions):
        raise expected(f"geometry '{name}'", "positions", "none")
    parts, notices = [], []
    for one in mesh.children:
        if one.name in KINDS:
            part = _part(library, one, positions, vertices, name)
            if part is not None:
                parts.append(part)
        elif one.name in OTHERS:
            notices.append(f"<{one.name}> of '{name}' is left out")
    return parts, notices


def _part(
    library: Library,
    element: Element,
    positions: FloatArray,
    shared: dict[str, Element],
    name: str,
) -> PolygonGroup | None:
    inputs = inputs_of(element)
    if "VERTEX" not in inputs:
        raise expected(f"'{name}' <{element.name}>", "an input VERTEX", sorted(inputs))
    stride = 1 + max(_offset(one, name) for one in element.all("input"))
    corners, counts = _corners(element, stride, name)
    if not len(corners):
        return None
    column = corners[:, _offset(inputs["VERTEX"], name)]
    used = {"VERTEX": (_checked(column, positions, f"'{name}' VERTEX"), positions)}
    for semantic, width in (("NORMAL", 3), ("TEXCOORD", 2), ("COLOR", 3)):
        # What the vertices themselves bring goes by the number of the position.
        given = inputs.get(semantic) or shared.get(semantic)
        if given is None:
            continue
        values = library.source(given.get("source"), semantic, width)
        own = corners[:, _offset(given, name)] if semantic in inputs else column
        used[semantic] = _checked(own, values, f"'{name}' {semantic}"), values
    columns = np.stack([numbers for numbers, _ in used.values()], axis=1)
    unique, inverse = np.unique(columns, axis=0, return_inverse=True)
    taken = {
        semantic: values[unique[:, column_number]]
        for column_number, (semantic, (_, values)) in enumerate(used.items())
    }
    return PolygonGroup(
        element.get("material"),
        unique[:, 0],
        taken["VERTEX"],
        taken.get("NORMAL"),
        taken.get("TEXCOORD"),
        taken.get("COLOR"),
        inverse.reshape(-1)[_fans(counts)],
    )


def _offset(given: Element, name: str) -> int:
    return number(given.get("offset") or "0", f"'{name}' offset", 0, 63)


def _checked(numbers: IntArray, values: FloatArray, field: str) -> IntArray:
    if numbers.min() < 0 or numbers.max() >= len(values):
        raise expected(field, f"numbers below {len(values)}", numbers.max())
    return numbers


def _corners(element: Element, stride: int, name: str) -> tuple[IntArray, IntArray]:
    """Numbers (C, stride) of the corners, and how many corners (P,) each polygon has."""
    if element.name == "polygons":
        if element.first("ph") is not None:
            raise expected(f"'{name}' <polygons>", "polygons without holes", "some with holes")
        runs = [one.integers() for one in element.all("p")]
        if any(len(run) % stride for run in runs):
            raise expected(f"'{name}' <p>", f"a multiple of {stride} numbers", "others")
        counts = np.array([len(run) // stride for run in runs], dtype=np.int64)
        flat = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
        return flat.reshape(-1, stride), counts
    runs = [one.integers() for one in element.all("p")]
    flat = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
    if len(flat) % stride:
        raise expected(f"'{name}' <p>", f"a multiple of {stride} numbers", len(flat))
    corners = flat.reshape(-1, stride)
    if element.name == "triangles":
        if len(corners) % 3:
            raise expected(f"'{name}' <p>", "three corners a triangle", len(corners))
        return corners, np.full(len(corners) // 3, 3)
    counts = element.needed("vcount").integers()
    if counts.min(initial=0) < 0 or counts.sum() != len(corners):
        raise expected(f"'{name}' <vcount>", f"counts that sum to {len(corners)}", counts.sum())
    return corners, counts


def _fans(counts: IntArray) -> IntArray:
    """Corner numbers (T, 3) of polygons cut into fans from their first corners."""
    pieces = np.maximum(counts - 2, 0)
    total = int(pieces.sum())
    if total > MAX_VALUES // 3:
        raise FormatError(f"polygons: expected at most {MAX_VALUES // 3} triangles, got {total}")
    first = np.repeat(np.cumsum(counts) - counts, pieces)
    step = np.arange(total) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)
