"""Which nodes of a rig become joints, what lies between them, and what they are called.

Nodes between a joint and the joint above it are folded into its local pose: exporters put helper
nodes there, and scenes hang skeletons under nodes that turn axes and change units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.errors import FormatError
from motorcade.animation.formats.limits import MAX_NODES, check_count
from motorcade.animation.formats.rig.values import NodeTree, Rig
from motorcade.ga.arrays import IntArray

__all__ = ["HELPER", "Joints", "joints_of", "nearest_joints"]

HELPER = "_$AssimpFbx$_"
"""Part of the names of nodes into which an FBX joint is taken apart on export."""


@dataclass(frozen=True, eq=False)
class Joints:
    """J joints chosen among the nodes, parents first.

    Args:
        nodes: (J,) node numbers, increasing.
        parents: (J,) joint numbers, −1 for roots.
        names: J different names.
        chains: for each joint the nodes from below the joint above it down to itself.
        renamed: how many names had to be made up or told apart.
    """

    nodes: IntArray
    parents: IntArray
    names: tuple[str, ...]
    chains: tuple[tuple[int, ...], ...]
    renamed: int


def joints_of(rig: Rig) -> Joints:
    """The joints that the file names, or else the nodes of its largest animated tree."""
    chosen = sorted(set(rig.joints)) or _moving_tree(rig)
    tree = rig.tree
    number = {node: joint for joint, node in enumerate(chosen)}
    above = tree.parents.tolist()
    parents, chains = [], []
    for node in chosen:
        chain = [node]
        parent = above[node]
        while parent >= 0 and parent not in number:
            chain.append(parent)
            parent = above[parent]
        parents.append(number[parent] if parent >= 0 else -1)
        chains.append(tuple(reversed(chain)))
    check_count("nodes between joints", sum(map(len, chains)), MAX_NODES)
    names, renamed = _names([tree.names[node] for node in chosen])
    return Joints(np.array(chosen), np.array(parents), names, tuple(chains), renamed)


def nearest_joints(tree: NodeTree, joints: Joints) -> IntArray:
    """For each node (N,) the joint that it is or hangs below, −1 for none."""
    nearest = np.full(len(tree.names), -1, dtype=np.int64)
    nearest[joints.nodes] = np.arange(len(joints.nodes))
    for node, parent in enumerate(tree.parents.tolist()):
        if nearest[node] < 0 <= parent:
            nearest[node] = nearest[parent]
    return nearest


def _moving_tree(rig: Rig) -> list[int]:
    """Nodes of the tree with most moving nodes; a node with surfaces counts as moving.

    Cameras and lights that move too stand in trees of their own, under a root that stands still.
    """
    tree = rig.tree
    moving = np.zeros(len(tree.names), dtype=bool)
    for clip in rig.clips:
        moving[clip.nodes] = True
    moving[[surface.node for surface in rig.surfaces]] = True
    if not moving.any():
        raise FormatError("nodes: expected joints, a skin or an animation, got none")
    top = np.arange(len(tree.names))
    still = ~moving
    for node, parent in enumerate(tree.parents.tolist()):
        if parent < 0:
            continue
        still[node] &= still[parent]
        if not still[parent]:
            top[node] = top[parent]
    largest = int(np.argmax(np.bincount(top[moving], minlength=len(top))))
    inside = np.flatnonzero((top == largest) & ~still)
    return [int(node) for node in inside if HELPER not in tree.names[node]] or [largest]


def _names(given: list[str]) -> tuple[tuple[str, ...], int]:
    """Different names that are not empty, and how many had to be changed."""
    taken: set[str] = set()
    names, renamed = [], 0
    counts: dict[str, int] = {}
    for joint, wanted in enumerate(given):
        name = wanted or f"joint_{joint}"
        while name in taken:
            counts[wanted] = counts.get(wanted, 1) + 1
            name = f"{wanted}#{counts[wanted]}"
        renamed += name != wanted
        taken.add(name)
        names.append(name)
    return tuple(names), renamed
