"""Nodes of a glTF document, brought into an order in which parents come first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.gltf.container import Document, floats, integer, listed, table
from motorcade.animation.formats.limits import MAX_NODES, FormatError, check_count, expected
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import NodeTree
from motorcade.ga.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Nodes:
    """The tree, and where the file's nodes stand in it.

    Args:
        tree: N nodes in the new order.
        number: (N,) new number of each of the file's nodes.
        fields: the JSON of the nodes in the new order.
        parts: rest rotations wxyz (N, 4), translations (N, 3) and scales (N, 3), as given.
    """

    tree: NodeTree
    number: IntArray
    fields: list[dict[str, Any]]
    parts: tuple[FloatArray, FloatArray, FloatArray]


def read_nodes(document: Document, names: Mapping[int, str]) -> Nodes:
    """All nodes of a document, by other names where they are given for the file's numbers.

    Raises:
        FormatError: a node that is its own ancestor, or has two parents; matrices or parts that
            are no transforms.
    """
    entries = [table(one, f"nodes[{i}]") for i, one in enumerate(document.entries("nodes"))]
    check_count("nodes", len(entries), MAX_NODES)
    if not entries:
        raise FormatError("nodes: expected one or more, got none")
    children = [
        [
            integer(child, f"nodes[{i}].children", 0, len(entries) - 1)
            for child in listed(entry.get("children", []), f"nodes[{i}].children")
        ]
        for i, entry in enumerate(entries)
    ]
    parent = [-1] * len(entries)
    for node, below in enumerate(children):
        for child in below:
            if parent[child] >= 0:
                raise expected(f"nodes[{child}]", "one parent", f"{parent[child]} and {node}")
            parent[child] = node
    order = _parents_first(parent, children)
    number = np.empty(len(entries), dtype=np.int64)
    number[order] = np.arange(len(order))
    parents = np.array([-1 if parent[node] < 0 else number[parent[node]] for node in order])
    fields = [entries[node] for node in order]
    called = tuple(names.get(node, str(entries[node].get("name", ""))[:200]) for node in order)
    parts, rest = _rest(fields)
    return Nodes(NodeTree(called, parents, rest), number, fields, parts)


def nodes_of_scene(document: Document, nodes: Nodes) -> NDArray[np.bool_]:
    """Which nodes (N,), in the new order, stand in the scene that is shown; all without any scene.

    Raises FormatError: a scene that is not there, or that names other nodes than there are.
    """
    if not document.entries("scenes"):
        return np.ones(len(nodes.number), dtype=bool)
    scene = document.entry("scenes", document.root.get("scene", 0), "scene")
    shown = np.zeros(len(nodes.number), dtype=bool)
    for entry in listed(scene.get("nodes", []), "scene.nodes"):
        node = integer(entry, "scene.nodes", 0, len(shown) - 1)
        shown[nodes.number[node]] = True
    for node, parent in enumerate(nodes.tree.parents.tolist()):
        shown[node] |= parent >= 0 and shown[parent]
    return shown


def _parents_first(parent: list[int], children: list[list[int]]) -> list[int]:
    """The file's own order where parents stand before their children, else one branch at a time."""
    if all(above < node for node, above in enumerate(parent)):
        return list(range(len(parent)))
    waiting = [node for node in range(len(parent)) if parent[node] < 0][::-1]
    ordered: list[int] = []
    while waiting:
        node = waiting.pop()
        ordered.append(node)
        waiting += children[node][::-1]
    if len(ordered) < len(parent):
        raise expected("nodes", "a hierarchy", f"a circle of {len(parent) - len(ordered)} nodes")
    return ordered


def _rest(
    fields: list[dict[str, Any]],
) -> tuple[tuple[FloatArray, FloatArray, FloatArray], Transforms]:
    """Rest transforms, in parts and whole."""
    count = len(fields)
    wxyz, places, scales = np.zeros((count, 4)), np.zeros((count, 3)), np.ones((count, 3))
    wxyz[:, 0] = 1.0
    matrices: dict[int, FloatArray] = {}
    for node, entry in enumerate(fields):
        if "matrix" in entry:
            matrices[node] = floats(entry["matrix"], f"node '{entry.get('name', '')}'.matrix", 16)
            continue
        if "rotation" in entry:
            wxyz[node] = floats(entry["rotation"], "node.rotation", 4)[[3, 0, 1, 2]]
        if "translation" in entry:
            places[node] = floats(entry["translation"], "node.translation", 3)
        if "scale" in entry:
            scales[node] = floats(entry["scale"], "node.scale", 3)
    rest = Transforms.from_parts(wxyz, places, scales)
    if not matrices:
        return (wxyz, places, scales), rest
    which = np.array(list(matrices))
    own = np.stack(list(matrices.values())).reshape(-1, 4, 4).swapaxes(1, 2)
    split = Transforms.from_matrices(own)
    wxyz[which], places[which], scales[which] = split.wxyz, split.translation, split.scale[:, None]
    if split.blocks is None and rest.blocks is None:
        return (wxyz, places, scales), Transforms.from_parts(wxyz, places, scales)
    whole = rest.as_matrices()
    whole[which] = own
    return (wxyz, places, scales), Transforms.from_matrices(whole)
