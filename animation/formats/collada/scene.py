"""Nodes of a Collada scene, each a stack of transforms that channels may move.

A node's matrix is the product of its `matrix`, `translate`, `rotate` and `scale` elements in the
order in which they stand. `lookat` and `skew` are refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from motorcade.animation.formats.collada.library import Element, Library
from motorcade.animation.formats.limits import MAX_NODES, FormatError, check_count, expected
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import NodeTree
from motorcade.animation.vectors import unit
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

SIZES = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3}


@dataclass(frozen=True, eq=False)
class TransformStep:
    """One transform of a stack.

    Args:
        kind: `matrix`, `translate`, `rotate` or `scale`.
        sid: by which channels name it.
        values: its numbers at rest; a matrix row by row, a rotation as axis and degrees.
    """

    kind: str
    sid: str
    values: FloatArray


@dataclass(frozen=True, eq=False)
class ColladaScene:
    """The nodes of the scene.

    Args:
        tree: N nodes at rest.
        elements: their elements.
        stacks: their transforms.
        notices: what was left out.
    """

    tree: NodeTree
    elements: tuple[Element, ...]
    stacks: tuple[tuple[TransformStep, ...], ...]
    notices: tuple[str, ...]
    by_id: dict[str, int] = field(default_factory=dict)
    by_sid: dict[str, int] = field(default_factory=dict)
    by_name: dict[str, int] = field(default_factory=dict)

    def joint(self, name: str) -> int | None:
        """The node that a skin calls so: by sid, id or name."""
        for names in (self.by_sid, self.by_id, self.by_name):
            if name in names:
                return names[name]
        return None


def read_scene(library: Library) -> ColladaScene:
    """The nodes of the scene that the document shows, or else of its first.

    Raises:
        FormatError: no scene, or transforms that are not understood.
    """
    shown = library.root.first("scene", "instance_visual_scene")
    scene = None if shown is None else library.find(shown.get("url"))
    if scene is None or scene.name != "visual_scene":
        scene = library.root.needed("library_visual_scenes", "visual_scene")
    elements: list[Element] = []
    parents: list[int] = []
    waiting = [(one, -1) for one in scene.all("node")[::-1]]
    left_out = 0
    while waiting:
        element, parent = waiting.pop()
        check_count("nodes", len(elements) + 1, MAX_NODES)
        left_out += len(element.all("instance_node"))
        number = len(elements)
        elements.append(element)
        parents.append(parent)
        waiting += [(one, number) for one in element.all("node")[::-1]]
    if not elements:
        raise FormatError("visual_scene: expected one node or more, got none")
    stacks = tuple(_stack(element) for element in elements)
    rest = np.stack([matrix_of_steps(stack) for stack in stacks])
    names = tuple((one.get("name") or one.get("id"))[:200] for one in elements)
    tree = NodeTree(names, np.array(parents), Transforms.from_matrices(rest))
    notices = (f"{left_out} instances of library nodes are left out",) if left_out else ()
    made = ColladaScene(tree, tuple(elements), stacks, notices)
    for number, one in enumerate(elements):
        for key, known in (("id", made.by_id), ("sid", made.by_sid), ("name", made.by_name)):
            if one.get(key):
                known.setdefault(one.get(key), number)
    return made


def matrix_of_steps(
    stack: tuple[TransformStep, ...], values: dict[int, FloatArray] | None = None
) -> FloatArray:
    """The product (4, 4) of a stack, or (n, 4, 4) where some steps have values (n, size)."""
    product = np.eye(4)
    for number, step in enumerate(stack):
        given = step.values if values is None or number not in values else values[number]
        product = product @ _matrix(step.kind, given)
    return product


def _stack(element: Element) -> tuple[TransformStep, ...]:
    steps = []
    for one in element.children:
        if one.name in ("lookat", "skew"):
            raise expected(
                f"node '{element.get('id')}'", "matrix, translate, rotate or scale", one.name
            )
        if one.name in SIZES:
            steps.append(TransformStep(one.name, one.get("sid"), one.floats(SIZES[one.name])))
    return tuple(steps)


def _matrix(kind: str, values: FloatArray) -> FloatArray:
    """Matrices (*, 4, 4) of one kind of step from its numbers (*, size)."""
    shape = values.shape[:-1]
    if kind == "matrix":
        return values.reshape(*shape, 4, 4)
    made = np.zeros((*shape, 4, 4))
    made[..., [0, 1, 2, 3], [0, 1, 2, 3]] = 1.0
    if kind == "translate":
        made[..., :3, 3] = values
    elif kind == "scale":
        made[..., [0, 1, 2], [0, 1, 2]] = values
    else:
        made[..., :3, :3] = _rotation(values)
    return made


def _rotation(values: FloatArray) -> FloatArray:
    """Rotation matrices (*, 3, 3) from axis and degrees (*, 4); of an axis of no length, none."""
    vector = np.radians(values[..., 3:]) * unit(values[..., :3])
    return Rotor.from_rotation_vector(vector).as_matrix()
