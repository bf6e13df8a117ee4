"""The editor: drags and edits of a scene, composed from where each began, undone and done again.

The history of a scene: steps that hold what they changed, not whole scenes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import is_
from typing import Any

import numpy as np

from motorcade.animation.authoring.drags import Amount, Drag, Snapping, dragged, held
from motorcade.animation.authoring.edits import Edit
from motorcade.animation.authoring.gestures import (
    AnchorsStand,
    Dragged,
    Gesture,
    HistoryStep,
    Together,
)
from motorcade.animation.authoring.poses import ObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray


class SceneEditor:
    """Edits a scene by drags and edits; one gesture is one step, and what changes nothing is none.

    While a drag goes on, every amount is applied to the pose in which the drag found the object,
    so neither small steps nor snapping add up errors. The scene's poses say whether it turns by
    rotors or by Euler angles (`Scene.on_euler_angles`).

    Args:
        scene: what is edited; it is not changed.
        snapping: steps for the amounts of drags.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import Drag, Scene, SceneEditor, Snapping
    >>> from motorcade.animation.authoring import VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> table = Scene({"cup": None}, {"cup": VersorObjectPose(Similarity.identity())})
    >>> editor = SceneEditor(table, Snapping(distance_m=0.1))
    >>> moved = editor.apply(Drag("cup", "translate", axis=[1.0, 0, 0]), 0.27)
    >>> moved.world_T_object("cup").translation_m.round(6) + 0.0
    array([0.3, 0. , 0. ])
    >>> editor.undo().world_T_object("cup").translation_m + 0.0
    array([0., 0., 0.])
    """

    def __init__(self, scene: Scene, snapping: Snapping | None = None) -> None:
        self.snapping = snapping or Snapping()
        self._scene = scene
        self._past: list[SceneStep] = []
        self._future: list[SceneStep] = []
        self._drag: Drag | None = None
        # Where the gesture began, and where the drag of it that is going on began.
        self._start = self._before = scene
        self._world_T_anchor: Mapping[str, Similarity] = {}

    @property
    def scene(self) -> Scene:
        """The scene as it is now, in the middle of a drag too."""
        return self._scene

    @property
    def world_T_anchor(self) -> Mapping[str, Similarity]:
        """Where anchors stand; see `stand`."""
        return self._world_T_anchor

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to take again."""
        return bool(self._future)

    def stand(self, world_T_anchor: Mapping[str, Similarity]) -> None:
        """Say where anchors stand from here on; global axes and new parents go by it.

        Raises:
            RuntimeError: a drag is going on.
        """
        self._idle()
        self._world_T_anchor = AnchorsStand(world_T_anchor).world_T_anchor

    def begin(self, drag: Drag) -> None:
        """Take hold of an object.

        Raises:
            ValueError: no such object.
            RuntimeError: a drag is going on.
        """
        if self._drag is not None:
            raise RuntimeError("SceneEditor.begin: end or cancel the drag that is going on first")
        self._scene.pose(drag.object_name)
        self._drag, self._start, self._before = drag, self._scene, self._scene

    def go_on(self, drag: Drag) -> None:
        """Go on within the gesture by another drag, from where the last one has come: about other
        axes, or of another object.

        Raises:
            ValueError: no such object.
            RuntimeError: no drag is going on.
        """
        self._going_on("go_on")
        self._scene.pose(drag.object_name)
        self._drag, self._before = drag, self._scene

    def drag_to(self, amount: Amount) -> Scene:
        """Move on to an amount since the drag began: rad, m, a factor, or a similarity.

        Raises:
            ValueError: see `Drag.applied`; the scene stays where the drag had brought it.
            RuntimeError: no drag is going on.
        """
        drag = self._going_on("drag_to")
        checked_amount = drag.checked(amount)
        if self.snapping != Snapping():
            checked_amount = self.snapping.snapped(drag, checked_amount, self._origin_m(drag))
        if drag.is_nothing(checked_amount):
            self._scene = self._before
        else:
            self._scene = dragged(self._before, drag, checked_amount, self._world_T_anchor)
        return self._scene

    def end(self) -> Scene:
        """Let go: the gesture becomes one step that can be undone, unless it changed nothing.

        Raises:
            RuntimeError: no drag is going on.
        """
        self._going_on("end")
        self._drag = None
        return self._step_to(self._start, self._scene)

    def cancel(self) -> Scene:
        """Put everything back where the gesture began.

        Raises:
            RuntimeError: no drag is going on.
        """
        self._going_on("cancel")
        self._drag, self._scene = None, self._start
        return self._scene

    def apply(self, drag: Drag, amount: Amount) -> Scene:
        """A whole drag at once; see `do`."""
        return self.do(Dragged(drag, (amount,)))

    def do(self, gesture: Gesture) -> Scene:
        """A whole gesture at once: one step, or none where it is refused.

        Raises:
            ValueError: what the scene does not have or may not have; all is then as it was.
            RuntimeError: a drag is going on.
        """
        self._idle()
        if isinstance(gesture, HistoryStep):
            return self.undo() if gesture.way == "undo" else self.redo()
        if isinstance(gesture, AnchorsStand):
            self.stand(gesture.world_T_anchor)
            return self._scene
        start = self._scene
        try:
            for single in gesture.gestures if isinstance(gesture, Together) else (gesture,):
                self._done(single)
        except ValueError:
            self._scene = start
            raise
        finally:
            self._drag = None
        return self._step_to(start, self._scene, _touched(gesture))

    def undo(self) -> Scene:
        """The scene before the last step; without one, the scene as it is."""
        return self._walk(self._past, self._future, back=True)

    def redo(self) -> Scene:
        """Takes an undo back; without one, the scene as it is."""
        return self._walk(self._future, self._past, back=False)

    def path(self, name: str, start: ObjectPose, end: ObjectPose, steps: int = 100) -> Similarity:
        """`parent_T_object` ``(steps + 1,)`` of an object animated from one pose to another.

        Both poses are of the scene's own kind; how they are interpolated is the kind's.

        Raises:
            ValueError: no such object, poses of another kind, fewer than one step.
        """
        kind = type(self._scene.pose(name))
        if type(start) is not kind or type(end) is not kind or steps < 1:
            raise ValueError(
                f"SceneEditor.path: expected two poses of type {kind.__name__} and a step or more, "
                f"got {type(start).__name__}, {type(end).__name__} and {steps}"
            )
        return start.towards(end, np.linspace(0.0, 1.0, steps + 1))

    def _done(self, value: Dragged | Edit) -> None:
        if isinstance(value, Edit):
            self._scene = value.applied(self._scene, self._world_T_anchor)
            return
        self._scene.pose(value.drag.object_name)
        self._drag, self._before = value.drag, self._scene
        for amount in value.amounts:
            self.drag_to(amount)

    def _origin_m(self, drag: Drag) -> FloatArray:
        """Where an object's origin is in the frame of a drag."""
        if drag.frame == "local":
            return np.zeros(3)
        origin = held(self._before, drag).as_similarity().translation_m
        if drag.frame == "parent":
            return origin
        name, anchors = drag.object_name, self._world_T_anchor
        return self._before.world_T_parent(name, drag.time_s, anchors).apply(origin)

    def _going_on(self, verb: str) -> Drag:
        if self._drag is None:
            raise RuntimeError(f"SceneEditor.{verb}: begin a drag first")
        return self._drag

    def _idle(self) -> None:
        if self._drag is not None:
            raise RuntimeError("SceneEditor: end or cancel the drag that is going on first")

    def _step_to(self, start: Scene, scene: Scene, names: Iterable[str] | None = None) -> Scene:
        """Where a gesture ends, put on record unless nothing has changed."""
        step = SceneStep.between(start, scene, names)
        self._scene = start if step is None else scene
        if step is not None:
            self._past.append(step)
            self._future.clear()
        return self._scene

    def _walk(self, source: list[SceneStep], target: list[SceneStep], *, back: bool) -> Scene:
        self._idle()
        if source:
            step = source.pop()
            target.append(step)
            self._scene = step.taken(self._scene, back)
        return self._scene


def replay(editor: SceneEditor, gestures: Iterable[Gesture]) -> Scene:
    """Do what was recorded, amount by amount; returns the scene at the end.

    Raises:
        ValueError: an object that is not there, an amount that the drag refuses.
    """
    for gesture in gestures:
        editor.do(gesture)
    return editor.scene


_FIELDS = ("parents", "poses", "parts", "anchors")
_ABSENT = object()
"""What stands for an entry on the side of a step on which it is not there."""
Item = tuple[str, Any]


@dataclass(frozen=True, eq=False)
class SceneStep:
    """What lies between two scenes, by field.

    Fields:
        entries: by name, the entry before and after; a new one stands at the end of its field.
        spans: where entries went or changed their order: the place of the first that differs, and
            all up to the last that does, before and after.
    """

    entries: Mapping[str, Mapping[str, tuple[Any, Any]]]
    spans: Mapping[str, tuple[int, tuple[Item, ...], tuple[Item, ...]]]

    @classmethod
    def between(
        cls, before: Scene, after: Scene, names: Iterable[str] | None = None
    ) -> SceneStep | None:
        """The step from one scene to another; None where a scene file of both is the same.

        Args:
            before: the scene on one side.
            after: the scene on the other.
            names: of the objects and anchors that can differ; None looks at all.
        """
        entries, spans = {}, {}
        touched: set[str] = set()
        in_place = True
        for field in _FIELDS if after is not before else ():
            old, new = getattr(before, field), getattr(after, field)
            if old is new:
                continue
            if names is None:
                span = _span(list(old.items()), list(new.items()))
                if span[1] or span[2]:
                    spans[field] = span
                    keys = [[name for name, _ in items] for items in span[1:]]
                    in_place &= keys[0] == keys[1]
                    touched.update(*keys)
                continue
            pairs = {name: (old.get(name, _ABSENT), new.get(name, _ABSENT)) for name in names}
            changed = {name: pair for name, pair in pairs.items() if pair[0] is not pair[1]}
            if changed:
                entries[field] = changed
                in_place &= not any(_ABSENT in pair for pair in changed.values())
                touched.update(changed)
        if in_place and all(_alike(before, after, name) for name in touched):
            return None
        return cls(entries, spans)

    def taken(self, scene: Scene, back: bool) -> Scene:
        """The scene on the other side of the step."""
        fields: dict[str, Mapping[str, Any]] = {}
        for field, (start, old_items, new_items) in self.spans.items():
            items = list(getattr(scene, field).items())
            gone, come = (new_items, old_items) if back else (old_items, new_items)
            items[start : start + len(gone)] = come
            fields[field] = dict(items)
        for field, entries in self.entries.items():
            changed = dict(getattr(scene, field))
            for name, pair in entries.items():
                if pair[0 if back else 1] is _ABSENT:
                    del changed[name]
                else:
                    changed[name] = pair[0 if back else 1]
            fields[field] = changed
        return scene.but(**fields)


def _span(old: list[Item], new: list[Item]) -> tuple[int, tuple[Item, ...], tuple[Item, ...]]:
    """From where two lists differ, and up to where, as they have it; the rest is theirs alike."""
    shorter = min(len(old), len(new))
    start = shorter
    if not _all_same(old[:shorter], new[:shorter]):
        start = next(k for k in range(shorter) if not _all_same(old[k : k + 1], new[k : k + 1]))
    end = 0
    while end < shorter - start and _all_same([old[-1 - end]], [new[-1 - end]]):
        end += 1
    return start, tuple(old[start : len(old) - end]), tuple(new[start : len(new) - end])


def _all_same(old: Sequence[Item], new: Sequence[Item]) -> bool:
    """Whether two lists of a length have the same names with the very same values."""
    return all(map(is_, chain(*old), chain(*new))) or (
        [name for name, _ in old] == [name for name, _ in new]
        and all(map(is_, (value for _, value in old), (value for _, value in new)))
    )


def _touched(gesture: Gesture) -> set[str] | None:
    """Names of all that a gesture can change; None where that is not told by its line."""
    if isinstance(gesture, Together):
        sets = [_touched(part) for part in gesture.gestures]
        return None if None in sets else set().union(*filter(None, sets))
    if isinstance(gesture, Dragged):
        return {gesture.drag.object_name}
    return gesture.touched if isinstance(gesture, Edit) else None


def _alike(before: Scene, after: Scene, name: str) -> bool:
    if name in before.anchors:
        return before.anchors[name] == after.anchors[name]
    return before.object_json(name) == after.object_json(name)
