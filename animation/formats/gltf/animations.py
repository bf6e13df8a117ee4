"""Nodes of a glTF document, parents first, and its animations as clips.

Channels with the same path, keys and interpolation are evaluated together: exporters write
hundreds a clip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.gltf.document import (
    Accessors,
    Document,
    floats,
    integer,
    listed,
    table,
    widened,
)
from motorcade.animation.formats.limits import (
    MAX_CLIPS,
    MAX_NODES,
    MAX_POSES,
    FormatError,
    check_count,
    expected,
)
from motorcade.animation.formats.rig.joints import HELPER
from motorcade.animation.formats.rig.sampling import divided
from motorcade.animation.formats.rig.values import (
    NodeTree,
    RigClip,
    Transforms,
    great_arc,
    hermite,
    key_times,
    stepped,
    with_times,
)
from motorcade.animation.skeleton import at_or_below
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
    last = len(nodes.number) - 1
    roots = [
        nodes.number[integer(entry, "scene.nodes", 0, last)]
        for entry in listed(scene.get("nodes", []), "scene.nodes")
    ]
    return at_or_below(nodes.tree.parents, roots)


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


PATHS = {"rotation": "VEC4", "translation": "VEC3", "scale": "VEC3"}
KINDS = PATHS | {"weights": "SCALAR"}
CUBIC_PARTS = 16
"""Straight lines for each piece of a cubic of weights: off by a 256th of its bulge at most."""
INTERPOLATIONS = ("LINEAR", "STEP", "CUBICSPLINE")


@dataclass(frozen=True, eq=False)
class _Group:
    """Channels C that share path, keys (K,) and interpolation."""

    path: str
    interpolation: str
    keys: FloatArray
    nodes: IntArray
    values: FloatArray
    """(K, C, 3 or 4), or (K, 3, C, 3 or 4) with the slopes of cubic splines around."""

    def at(self, times: FloatArray) -> FloatArray:
        """Values (n, C, 3 or 4); quaternions as xyzw, those of splines not of length 1."""
        if self.interpolation == "STEP":
            return stepped(self.keys, self.values, times)
        if self.interpolation == "CUBICSPLINE":
            into, values, out = (self.values[:, part] for part in range(3))
            return hermite(self.keys, values, into, out, times)
        if self.path == "rotation":
            return great_arc(self.keys, self.values, times)
        return with_times(self.keys, self.values, times)


@dataclass(frozen=True, eq=False)
class _Weights:
    """Morph weights of one node: keys (K,), and values (K, M) or (K, 3, M) as of `_Group`."""

    interpolation: str
    keys: FloatArray
    node: int
    values: FloatArray

    def track(self) -> tuple[FloatArray, FloatArray]:
        """Times and weights (n, M) between which straight lines do."""
        times = key_times([self.keys], [self.interpolation == "STEP"])
        if self.interpolation == "CUBICSPLINE":
            times = divided(self.keys, np.full(len(self.keys) - 1, CUBIC_PARTS))
            into, values, out = (self.values[:, part] for part in range(3))
            return times, hermite(self.keys, values, into, out, times)
        if self.interpolation == "STEP":
            return times, stepped(self.keys, self.values, times)
        return times, self.values


def read_animations(
    document: Document, accessors: Accessors, nodes: Nodes, targets: dict[int, int]
) -> tuple[tuple[RigClip, ...], list[str]]:
    """Clips of a document, and what was left out; `targets` counts nodes' morph targets.

    Raises:
        FormatError: keys that do not increase, NaN, or outputs that do not fit their inputs.
    """
    entries = document.entries("animations")
    check_count("animations", len(entries), MAX_CLIPS)
    reader = _ChannelReader(accessors, nodes, targets)
    clips = []
    for number, entry in enumerate(entries):
        fields = table(entry, f"animations[{number}]")
        groups, weights = reader.groups(fields, f"animations[{number}]")
        if groups or weights:
            clips.append(_clip(fields, groups, weights, nodes))
    notices = []
    if reader.left_out:
        notices.append(f"{reader.left_out} channels that move no joint are left out")
    return tuple(clips), notices


def _clip(
    fields: dict[str, Any], groups: list[_Group], weights: list[_Weights], nodes: Nodes
) -> RigClip:
    channels: list[_Group | _Weights] = [*groups, *weights]
    steps = [one.interpolation == "STEP" for one in channels]
    times = key_times([one.keys for one in channels], steps)
    none = np.zeros(0, dtype=np.int64)
    moving = np.unique(np.concatenate([none, *(group.nodes for group in groups)]))
    extras = fields.get("extras")
    return RigClip(
        str(fields.get("name", ""))[:200],
        times,
        partial(_transforms, groups, nodes, moving, _replaced_helpers(nodes.tree, moving)),
        moving,
        straight=all(group.interpolation == "LINEAR" for group in groups),
        looped=isinstance(extras, dict) and extras.get("looped") is True,
        key_count=max(len(one.keys) for one in channels),
        weights={one.node: one.track() for one in weights},
    )


def _transforms(
    groups: list[_Group], nodes: Nodes, moving: IntArray, dropped: IntArray, times: FloatArray
) -> Transforms:
    """Transforms (n, N) of all nodes at times (n,); those dropped move nothing."""
    wxyz, places, scales = (np.repeat(part[None], len(times), axis=0) for part in nodes.parts)
    parts = {"rotation": wxyz, "translation": places, "scale": scales}
    for group in groups:
        values = group.at(times)
        if group.path == "rotation":
            values = values[..., [3, 0, 1, 2]]
        parts[group.path][:, group.nodes] = values
    wxyz[:, dropped] = (1.0, 0.0, 0.0, 0.0)
    places[:, dropped] = 0.0
    scales[:, dropped] = 1.0
    transforms = Transforms.from_parts(wxyz, places, scales)
    blocks = nodes.tree.rest.blocks
    if blocks is None:
        return transforms
    own = np.array(transforms.as_blocks())
    still = np.setdiff1d(np.arange(len(blocks)), np.union1d(moving, dropped))
    own[:, still] = blocks[still]
    return Transforms(transforms.wxyz, transforms.translation, transforms.scale, own)


def _replaced_helpers(tree: NodeTree, targets: IntArray) -> IntArray:
    """Helper nodes whose transforms an animation of their joint already contains.

    Files made from FBX put a joint's pivots and rotations into helper nodes above it. An animation
    then moves these helpers, or else the joint itself by all that they and it do together.
    """
    parents, moving = tree.parents.tolist(), set(targets.tolist())
    dropped: list[int] = []
    for node in moving:
        helpers = []
        above = parents[node]
        while above >= 0 and tree.names[above].startswith(tree.names[node] + HELPER):
            helpers.append(above)
            above = parents[above]
        if helpers and not moving.intersection(helpers):
            dropped += helpers
    return np.array(sorted(dropped), dtype=np.int64)


class _ChannelReader:
    """Reads the channels of one document; counts what they unpack to.

    Args:
        targets: how many morph targets nodes have, by the file's numbers.
    """

    def __init__(self, accessors: Accessors, nodes: Nodes, targets: dict[int, int]) -> None:
        self._targets = targets
        self._accessors = accessors
        self._number = nodes.number
        self._keys: dict[int, tuple[FloatArray, bytes]] = {}
        self._total = 0
        self.left_out = 0

    def groups(self, fields: dict[str, Any], field: str) -> tuple[list[_Group], list[_Weights]]:
        """Channels of an animation by path, keys and interpolation; those of weights by node."""
        weights: dict[int, _Weights] = {}
        samplers = listed(fields.get("samplers"), f"{field}.samplers")
        gathered: dict[tuple[str, str, bytes], tuple[FloatArray, list[int], list[Any]]] = {}
        nodes = len(self._number) - 1
        for channel in listed(fields.get("channels"), f"{field}.channels"):
            if type(channel) is not dict or type(channel.get("target")) is not dict:
                raise expected(f"{field}.channels", "objects with a target", channel)
            target = channel["target"]
            path = target.get("path")
            known = type(path) is str and (path in PATHS or path == "weights")
            if not known or "node" not in target:
                self.left_out += 1
                continue
            node = integer(target["node"], "animation target.node", 0, nodes)
            which = integer(channel.get("sampler"), "animation sampler", 0, len(samplers) - 1)
            if path == "weights":
                if node not in self._targets:
                    self.left_out += 1
                    continue
                interpolation, times, _, output = self._sampler(
                    samplers[which], field, path, self._targets[node]
                )
                own = int(self._number[node])
                weights[own] = _weights(interpolation, times, own, output, field)
                continue
            interpolation, times, mark, output = self._sampler(samplers[which], field, path)
            group = gathered.setdefault((path, interpolation, mark), (times, [], []))
            group[1].append(node)
            group[2].append(output)
        return [
            _group(path, interpolation, times, self._number[held], values, field)
            for (path, interpolation, _), (times, held, values) in gathered.items()
        ], list(weights.values())

    def _sampler(
        self, value: object, field: str, path: str, each: int = 1
    ) -> tuple[str, FloatArray, bytes, NDArray[Any]]:
        """Interpolation, keys, the keys' bytes, and values of a sampler."""
        sampler = table(value, field)
        interpolation = sampler.get("interpolation", "LINEAR")
        if interpolation not in INTERPOLATIONS:
            raise expected(f"{field} sampler", "LINEAR, STEP or CUBICSPLINE", interpolation)
        source = integer(sampler.get("input"), "animation sampler.input", 0, 1 << 30)
        if source not in self._keys:
            times = _keys(self._accessors, source, f"{field} input")
            self._keys[source] = times, times.tobytes()
        times, mark = self._keys[source]
        output = self._accessors.unread(sampler.get("output"), field, KINDS[path])
        if output.dtype.kind != "f":
            output = self._accessors.floats(sampler.get("output"), field, KINDS[path])
        if len(output) != each * len(times) * (3 if interpolation == "CUBICSPLINE" else 1):
            raise expected(f"{field} {path}", f"{len(times)} keys", len(output))
        self._total += len(output)
        if self._total > MAX_POSES:  # many channels may share one array
            raise expected("animations", f"at most {MAX_POSES} keys in all", "more")
        return interpolation, times, mark, output


def _weights(
    interpolation: str, keys: FloatArray, node: int, output: NDArray[Any], field: str
) -> _Weights:
    values = widened(output)
    if not (values.max() <= 1e6 and values.min() >= -1e6):  # NaN fails both
        raise expected(f"{field} weights", "finite keys up to 1e6", "others")
    shape = (len(keys), 3, -1) if interpolation == "CUBICSPLINE" else (len(keys), -1)
    return _Weights(interpolation, keys, node, values.reshape(shape))


def _group(
    path: str,
    interpolation: str,
    keys: FloatArray,
    nodes: IntArray,
    values: list[Any],
    field: str,
) -> _Group:
    stacked = widened(np.stack(values, axis=1))
    # NaN fails both comparisons.
    if not (stacked.max() <= 1e9 and stacked.min() >= -1e9):
        raise expected(f"{field} {path}", "finite keys up to 1e9", "others")
    if interpolation == "CUBICSPLINE":
        stacked = stacked.reshape(len(keys), 3, len(values), -1)
    elif path == "rotation":
        length = np.linalg.norm(stacked, axis=-1, keepdims=True)
        if not np.all(length > 1e-6):
            raise expected(f"{field} rotation", "quaternions", "one of length zero")
        stacked /= length
    return _Group(path, interpolation, keys, nodes, stacked)


def _keys(accessors: Accessors, source: int, field: str) -> FloatArray:
    """Key times in seconds."""
    times = accessors.floats(source, field, "SCALAR")
    if np.any(np.diff(times) <= 0.0) or np.abs(times).max() > 1e6:
        raise FormatError(f"{field}: expected increasing seconds up to 1e6, got others")
    return times
