"""Nodes of a Collada scene, each a stack of transforms; the channels that move them, as one clip.

A node's matrix is the product of its `matrix`, `translate`, `rotate` and `scale` elements in the
order in which they stand. `lookat` and `skew` are refused. A channel moves one number of a
transform (`sid.X`, `sid(3)(0)`) or all of them (`sid`). Numbers follow lines, steps or Bézier
curves of time and value. Nodes whose matrices have keys are taken apart at these keys, and turned
and moved evenly between them: blends of matrices would shear.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np

from motorcade.animation.clip import between
from motorcade.animation.formats.collada.library import Element, Library, inputs_of
from motorcade.animation.formats.limits import (
    MAX_NODES,
    FormatError,
    check_count,
    expected,
    numbers_in,
)
from motorcade.animation.formats.rig.values import (
    NodeTree,
    RigClip,
    Transforms,
    great_arc,
    key_times,
    transforms_over,
    with_times,
)
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
    """The N nodes of the scene at rest, their elements and transforms, and what was left out."""

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
    waiting = [(one, -1) for one in _below(library, scene)]
    while waiting:
        element, parent = waiting.pop()
        check_count("nodes", len(elements) + 1, MAX_NODES)
        number, above = len(elements), parent
        while above >= 0:
            if elements[above] is element:
                raise expected(f"node '{element.get('id')}'", "no instance of itself", "one")
            above = parents[above]
        elements.append(element)
        parents.append(parent)
        waiting += [(one, number) for one in _below(library, element)]
    if not elements:
        raise FormatError("visual_scene: expected one node or more, got none")
    stacks = tuple(_stack(element) for element in elements)
    rest = np.stack([matrix_of_steps(stack) for stack in stacks])
    names = tuple((one.get("name") or one.get("id"))[:200] for one in elements)
    tree = NodeTree(names, np.array(parents), Transforms.from_matrices(rest))
    collada_scene = ColladaScene(tree, tuple(elements), stacks, ())
    for number, node_element in enumerate(elements):
        for key, known in (
            ("id", collada_scene.by_id),
            ("sid", collada_scene.by_sid),
            ("name", collada_scene.by_name),
        ):
            if node_element.get(key):
                known.setdefault(node_element.get(key), number)
    return collada_scene


def _below(library: Library, element: Element) -> list[Element]:
    """Nodes below an element, its own and instances of others, the last first."""
    below = element.all("node")
    for instance in element.all("instance_node"):
        below.append(library.named(instance.get("url"), "node", "instance_node"))
    return below[::-1]


def matrix_of_steps(
    stack: tuple[TransformStep, ...], values: dict[int, FloatArray] | None = None
) -> FloatArray:
    """The product (4, 4) of a stack, or (n, 4, 4) where some steps have values (n, size)."""
    product = np.eye(4)
    for number, step in enumerate(stack):
        numbers = step.values if values is None or number not in values else values[number]
        product = product @ _matrix(step.kind, numbers)
    return product


def _stack(element: Element) -> tuple[TransformStep, ...]:
    steps = []
    for child in element.children:
        if child.name in ("lookat", "skew"):
            raise expected(
                f"node '{element.get('id')}'", "matrix, translate, rotate or scale", child.name
            )
        if child.name in SIZES:
            steps.append(
                TransformStep(child.name, child.get("sid"), child.floats(SIZES[child.name]))
            )
    return tuple(steps)


def _matrix(kind: str, values: FloatArray) -> FloatArray:
    """Matrices (*, 4, 4) of one kind of step from its numbers (*, size)."""
    shape = values.shape[:-1]
    if kind == "matrix":
        return values.reshape(*shape, 4, 4)
    matrix = np.zeros((*shape, 4, 4))
    matrix[..., [0, 1, 2, 3], [0, 1, 2, 3]] = 1.0
    if kind == "translate":
        matrix[..., :3, 3] = values
    elif kind == "scale":
        matrix[..., [0, 1, 2], [0, 1, 2]] = values
    else:
        matrix[..., :3, :3] = _rotation(values)
    return matrix


def _rotation(values: FloatArray) -> FloatArray:
    """Rotation matrices (*, 3, 3) from axis and degrees (*, 4); of an axis of no length, none."""
    vector = np.radians(values[..., 3:]) * unit(values[..., :3])
    return Rotor.from_rotation_vector(vector).as_matrix()


MEMBERS = {"X": 0, "Y": 1, "Z": 2, "ANGLE": 3}
ELEMENTS = re.compile(r"\((\d{1,2})\)")
BISECTIONS = 40


@dataclass(frozen=True, eq=False)
class _Curve:
    """Numbers (K, width) over keys (K,), with how each step is filled in.

    Args:
        keys: seconds.
        values: at the keys.
        kinds: (K,) `LINEAR`, `STEP` or `BEZIER` from each key to the next.
        into: (K, width, 2) time and value of the handle before each key, or None.
        out: the same after each key.
    """

    keys: FloatArray
    values: FloatArray
    kinds: np.ndarray
    into: FloatArray | None
    out: FloatArray | None

    def at(self, times: FloatArray) -> FloatArray:
        """Values (n, width)."""
        results = with_times(self.keys, self.values, times)
        if len(self.keys) < 2:
            return results
        before, _, fraction = between(self.keys, times)
        kinds = self.kinds[before]
        hold = (kinds == "STEP") & (fraction < 1.0)
        results = np.where(hold[:, None], self.values[before], results)
        curved = np.flatnonzero(kinds == "BEZIER")
        if len(curved) and self.into is not None and self.out is not None:
            results = np.array(results)
            results[curved] = self._bezier(before[curved], times[curved])
        return results

    def _bezier(self, before: np.ndarray, times: FloatArray) -> FloatArray:
        """Values on Bézier curves, at the parameter where their time is the wanted one."""
        assert self.into is not None
        assert self.out is not None
        start, end = self.keys[before][:, None], self.keys[before + 1][:, None]
        first = np.clip(self.out[before, :, 0], start, end)
        second = np.clip(self.into[before + 1, :, 0], start, end)
        wanted = np.clip(times[:, None], start, end)
        low, high = np.zeros_like(first), np.ones_like(first)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            late = _cubic(start, first, second, end, middle) > wanted
            high, low = np.where(late, middle, high), np.where(late, low, middle)
        u = 0.5 * (low + high)
        return _cubic(
            self.values[before],
            self.out[before, :, 1],
            self.into[before + 1, :, 1],
            self.values[before + 1],
            u,
        )


_Moves = list[tuple[int, slice | int, _Curve]]
"""Steps of one node's stack, which of each step's numbers move, and how."""


def read_clips(library: Library, scene: ColladaScene) -> tuple[tuple[RigClip, ...], list[str]]:
    """Channels that move nodes of the scene: the animation clips of the document, or one of all.

    Raises:
        FormatError: sources that are missing or do not fit, times that do not increase, or a clip
            of an animation that is not there.
    """
    clips, notices = [], []
    for number, element in enumerate(library.root.every("animation_clip")):
        instances = element.all("instance_animation")
        urls = [one.get("url") for one in instances]
        parts = [library.named(url, "animation", "instance_animation") for url in urls]
        moves, _ = _moves(library, scene, parts)
        if moves:
            name = element.get("name") or element.get("id") or f"clip {number}"
            clips.append(_within(_clip(scene, moves, name), element))
    moves, left_out = _moves(library, scene, library.root.all("library_animations"))
    if left_out:
        notices.append(f"{left_out} channels that move no transform of the scene are left out")
    if moves and not clips:
        titled = library.root.first("library_animation_clips", "animation_clip")
        title = "" if titled is None else titled.get("name") or titled.get("id")
        clips.append(_clip(scene, moves, title or "animation"))
    return tuple(clips), notices


def _within(clip: RigClip, element: Element) -> RigClip:
    """The part of a clip from an animation clip's start to its end, as a clip from 0 on."""
    span = [clip.key_times[0], clip.key_times[-1]]
    for side, key in enumerate(("start", "end")):
        if element.get(key).strip():
            value = float(numbers_in(element.get(key), f"animation_clip {key}")[0])
            span[side] = min(max(value, clip.key_times[0]), clip.key_times[-1])
    start, end = span
    inside = clip.key_times[(clip.key_times > start) & (clip.key_times < end)]
    times = np.concatenate([[start], inside, [end] if end > start else []]) - start
    return replace(clip, key_times=times, at=lambda wanted: clip.at(wanted + start), key_count=0)


def _moves(
    library: Library, scene: ColladaScene, parts: list[Element]
) -> tuple[dict[int, _Moves], int]:
    """What the channels below some elements move, and how many move no transform of the scene."""
    moves: dict[int, _Moves] = {}
    left_out = 0
    for animations in parts:
        for channel in animations.every("channel"):
            target = _target(scene, channel.get("target"))
            if target is None:
                left_out += 1
                continue
            node, step, where = target
            if where is None:
                continue  # the bottom row of a matrix, which moves nothing
            width = 1 if isinstance(where, int) else len(scene.stacks[node][step].values)
            curve = _curve(library, channel, width)
            moves.setdefault(node, []).append((step, where, curve))
    return moves, left_out


def _clip(scene: ColladaScene, moves: dict[int, _Moves], name: str) -> RigClip:
    curves = [curve for parts in moves.values() for _, _, curve in parts]
    steps = [bool(np.any(curve.kinds == "STEP")) for curve in curves]
    times = key_times([curve.keys for curve in curves], steps)
    keyed = {  # those that the keys of a matrix move
        node
        for node, parts in moves.items()
        if any(scene.stacks[node][step].kind == "matrix" for step, _, _ in parts)
    }

    def at(wanted: FloatArray) -> Transforms:
        whole = transforms_over(scene.tree.rest, len(wanted))
        parts = [
            _at_keys(scene, node, moves[node], wanted)
            if node in keyed
            else Transforms.from_matrices(_matrices(scene, node, moves[node], wanted))
            for node in moves
        ]
        sheared = whole.blocks is not None or any(part.blocks is not None for part in parts)
        blocks = np.array(whole.as_blocks()) if sheared else None
        for node, part in zip(moves, parts, strict=True):
            whole.wxyz[:, node], whole.translation[:, node] = part.wxyz, part.translation
            whole.scale[:, node] = part.scale
            if blocks is not None:
                blocks[:, node] = part.as_blocks()
        return Transforms(whole.wxyz, whole.translation, whole.scale, blocks)

    return RigClip(
        name,
        times,
        at,
        np.array(sorted(moves)),
        straight=keyed == set(moves) and not any(steps),
        key_count=max(len(curve.keys) for curve in curves),
    )


def _at_keys(scene: ColladaScene, node: int, parts: _Moves, wanted: FloatArray) -> Transforms:
    """Transforms (n,) between those that a node has at its own keys."""
    keys = np.unique(np.concatenate([curve.keys for _, _, curve in parts]))
    held = Transforms.from_matrices(_matrices(scene, node, parts, keys))
    return Transforms(
        great_arc(keys, held.wxyz, wanted),
        with_times(keys, held.translation, wanted),
        with_times(keys, held.scale, wanted),
        None if held.blocks is None else with_times(keys, held.blocks, wanted),
    )


def _matrices(scene: ColladaScene, node: int, parts: _Moves, times: FloatArray) -> FloatArray:
    """Matrices (n, 4, 4) of a node with its moving numbers put in."""
    stack = scene.stacks[node]
    values: dict[int, FloatArray] = {}
    for step, where, curve in parts:
        if step not in values:
            values[step] = np.repeat(stack[step].values[None], len(times), axis=0)
        played = curve.at(times)
        values[step][:, where] = played[:, 0] if isinstance(where, int) else played
    return np.broadcast_to(matrix_of_steps(stack, values), (len(times), 4, 4))


def _target(scene: ColladaScene, target: str) -> tuple[int, int, slice | int | None] | None:
    """Node, step of its stack, and which of the step's numbers; None for anything else."""
    name, slash, rest = target.partition("/")
    node = scene.by_id.get(name)
    if node is None or not slash:
        return None
    sid = re.split(r"[.(]", rest, maxsplit=1)[0]
    step = next((i for i, one in enumerate(scene.stacks[node]) if one.sid == sid and sid), None)
    if step is None:
        return None
    stack = scene.stacks[node][step]
    member = rest[len(sid) :]
    if not member:
        return node, step, slice(None)
    if member.startswith("."):
        index = MEMBERS.get(member[1:])
        if index is None or index >= len(stack.values) or stack.kind == "matrix":
            return None
        return node, step, index
    numbers = [int(text) for text in ELEMENTS.findall(member)]
    if stack.kind != "matrix":
        inside = len(numbers) == 1 and numbers[0] < len(stack.values)
        return (node, step, numbers[0]) if inside else None
    if len(numbers) != 2 or max(numbers) > 3:
        return None
    column, row = numbers
    return node, step, None if row == 3 else 4 * row + column


def _curve(library: Library, channel: Element, width: int) -> _Curve:
    """The curve of the sampler that a channel plays."""
    sampler = library.named(channel.get("source"), "sampler", "channel source")
    inputs = inputs_of(sampler)
    if "INPUT" not in inputs or "OUTPUT" not in inputs:
        raise expected(f"sampler '{sampler.get('id')}'", "INPUT and OUTPUT", sorted(inputs))
    keys = library.source(inputs["INPUT"].get("source"), "INPUT", 1)[:, 0]
    values = library.source(inputs["OUTPUT"].get("source"), "OUTPUT", width)
    if not len(keys) or len(values) != len(keys):
        raise expected(f"sampler '{sampler.get('id')}'", f"{len(keys)} keys", len(values))
    if np.any(np.diff(keys) <= 0.0) or np.abs(keys).max() > 1e6:
        raise expected(f"sampler '{sampler.get('id')}'", "increasing seconds up to 1e6", "others")
    kinds = np.full(len(keys), "LINEAR", dtype="<U8")
    if "INTERPOLATION" in inputs:
        named = library.names(inputs["INTERPOLATION"].get("source"), "INTERPOLATION")
        if len(named) != len(keys):
            raise expected(f"sampler '{sampler.get('id')}'", f"{len(keys)} kinds", len(named))
        kinds = np.array([name[:8] for name in named], dtype="<U8")
    into = _handles(library, inputs, "IN_TANGENT", len(keys), width)
    out = _handles(library, inputs, "OUT_TANGENT", len(keys), width)
    if into is None or out is None:
        kinds = np.where(kinds == "STEP", kinds, "LINEAR")
    return _Curve(keys, values, kinds, into, out)


def _handles(
    library: Library, inputs: dict[str, Element], semantic: str, keys: int, width: int
) -> FloatArray | None:
    """Handles (K, width, 2) of time and value, or None where there are none of that shape."""
    if semantic not in inputs:
        return None
    source = library.named(inputs[semantic].get("source"), "source", semantic)
    array = source.first("float_array")
    values = np.zeros(0) if array is None else array.floats()
    if len(values) != keys * width * 2:
        return None  # values without times: curves of another kind, taken as lines
    return values.reshape(keys, width, 2)


def _cubic(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray, u: FloatArray) -> FloatArray:
    """A Bézier cubic with these four control values."""
    v = 1.0 - u
    return v**3 * a + 3.0 * v**2 * u * b + 3.0 * v * u**2 * c + u**3 * d
