"""The editor: drags with snapping, composed from where each began, undone and done again.

Drags may be recorded as lines of JSON, and replayed. A line is a drag, with the amounts that it
went through since it began, or a step back or forth::

    {"object": "cup", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1, 0.3]}
    {"object": "cup", "do": "translate", "axis": [1, 0, 0], "frame": "global", "amounts_m": [0.2]}
    {"object": "cup", "do": "scale", "factors": [1.1, 1.3]}
    {"do": "undo"}
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.animation.authoring.fields import number, read_json_lines, vector
from motorcade.animation.authoring.poses import Frame, ObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, checked_floats, frozen

Kind = Literal["rotate", "translate", "scale"]
MOST_GESTURES = 1_000_000
_AMOUNTS = {"rotate": "amounts_rad", "translate": "amounts_m", "scale": "factors"}


@dataclass(frozen=True, eq=False)
class Drag:
    """What a drag does to which object.

    Args:
        object_name: which.
        kind: rotate (amounts in rad), translate (m) or scale (factors, above zero).
        axis: ``(3,)`` direction in the frame, of any length; scaling needs none.
        frame: the object's own axes, its parent's, or the world's.

    Raises:
        ValueError: an unknown kind or frame, an axis without direction.

    >>> from motorcade.animation.authoring import Drag, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> table_T_cup = VersorObjectPose(Similarity.identity())
    >>> lift = Drag("cup", "translate", axis=[0.0, 0.0, 1.0], frame="parent")
    >>> world_T_table = Similarity.identity()
    >>> lift.applied(table_T_cup, 0.2, world_T_table).parent_T_object.translation_m
    array([0. , 0. , 0.2])
    """

    object_name: str
    kind: Kind
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    frame: Frame = "local"

    def __post_init__(self) -> None:
        if self.kind not in ("rotate", "translate", "scale"):
            raise ValueError(f"Drag.kind: expected rotate, translate or scale, got {self.kind!r}")
        if self.frame not in ("local", "parent", "global"):
            raise ValueError(f"Drag.frame: expected local, parent or global, got {self.frame!r}")
        axis = checked_floats(self.axis, "Drag.axis", (3,))
        length = float(np.linalg.norm(axis))
        if axis.shape != (3,) or length < 1e-9:
            raise ValueError(f"Drag.axis: expected a direction (3,), got {self.axis}")
        object.__setattr__(self, "axis", frozen(axis / length))

    def applied(self, pose: ObjectPose, amount: float, world_T_parent: Similarity) -> ObjectPose:
        """A pose after the whole drag."""
        if self.kind == "rotate":
            return pose.rotated(self.axis, amount, self.frame, world_T_parent)
        if self.kind == "translate":
            return pose.translated(amount * self.axis, self.frame, world_T_parent)
        return pose.scaled(amount)


@dataclass(frozen=True)
class Snapping:
    """Steps that amounts of a drag are rounded to; 0 for none.

    Args:
        angle_rad: of turns.
        distance_m: of shifts.
        scale: of factors, in steps from 1 (0.1: …, 0.9, 1, 1.1, …).

    Raises:
        ValueError: a step that is negative or not finite.

    >>> from motorcade.animation.authoring import Snapping
    >>> snapping = Snapping(distance_m=0.25, scale=0.1)
    >>> snapping.rounded("translate", 0.6), round(snapping.rounded("scale", 1.28), 6)
    (0.5, 1.3)
    """

    angle_rad: float = 0.0
    distance_m: float = 0.0
    scale: float = 0.0

    def __post_init__(self) -> None:
        for name in ("angle_rad", "distance_m", "scale"):
            step = getattr(self, name)
            if not (np.isfinite(step) and step >= 0.0):
                raise ValueError(f"Snapping.{name}: expected 0 or a step above 0, got {step}")

    def rounded(self, kind: Kind, amount: float) -> float:
        """The amount on the nearest step; factors stay above zero."""
        if kind == "scale":
            step = self.scale
            return max(step, 1.0 + step * round((amount - 1.0) / step)) if step else amount
        step = self.angle_rad if kind == "rotate" else self.distance_m
        return step * round(amount / step) if step else amount


class SceneEditor:
    """Edits a scene by drags.

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
        self._past: list[Scene] = []
        self._future: list[Scene] = []
        self._drag: Drag | None = None
        self._before = scene

    @property
    def scene(self) -> Scene:
        """The scene as it is now, in the middle of a drag too."""
        return self._scene

    def begin(self, drag: Drag) -> None:
        """Take hold of an object.

        Raises:
            ValueError: no such object.
            RuntimeError: a drag is going on.
        """
        if self._drag is not None:
            raise RuntimeError("SceneEditor.begin: end or cancel the drag that is going on first")
        self._scene.pose(drag.object_name)
        self._drag, self._before = drag, self._scene

    def drag_to(self, amount: float) -> Scene:
        """Move on to an amount since the drag began: rad, m, or a factor.

        Raises:
            ValueError: an amount that is not finite, a factor that is not positive.
            RuntimeError: no drag is going on.
        """
        drag = self._going_on("drag_to")
        if not np.isfinite(amount) or (drag.kind == "scale" and amount <= 0.0):
            expected = "a factor above 0" if drag.kind == "scale" else "a finite amount"
            raise ValueError(f"SceneEditor.drag_to(amount): expected {expected}, got {amount}")
        name = drag.object_name
        world_T_parent = self._before.world_T_parent(name)
        snapped = self.snapping.rounded(drag.kind, amount)
        pose = drag.applied(self._before.pose(name), snapped, world_T_parent)
        self._scene = self._before.with_pose(name, pose)
        return self._scene

    def end(self) -> Scene:
        """Let go: the drag becomes one step that can be undone.

        Raises:
            RuntimeError: no drag is going on.
        """
        self._going_on("end")
        self._drag = None
        self._past.append(self._before)
        self._future.clear()
        return self._scene

    def cancel(self) -> Scene:
        """Put the object back where the drag found it.

        Raises:
            RuntimeError: no drag is going on.
        """
        self._going_on("cancel")
        self._drag, self._scene = None, self._before
        return self._scene

    def apply(self, drag: Drag, amount: float) -> Scene:
        """A whole drag at once."""
        self.begin(drag)
        try:
            self.drag_to(amount)
        except ValueError:
            self.cancel()
            raise
        return self.end()

    def undo(self) -> Scene:
        """The scene before the last drag; without one, the scene as it is."""
        return self._step(self._past, self._future)

    def redo(self) -> Scene:
        """Takes an undo back; without one, the scene as it is."""
        return self._step(self._future, self._past)

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

    def _going_on(self, verb: str) -> Drag:
        if self._drag is None:
            raise RuntimeError(f"SceneEditor.{verb}: begin a drag first")
        return self._drag

    def _step(self, source: list[Scene], target: list[Scene]) -> Scene:
        if self._drag is not None:
            raise RuntimeError("SceneEditor: end or cancel the drag that is going on first")
        if source:
            target.append(self._scene)
            self._scene = source.pop()
        return self._scene


@dataclass(frozen=True, eq=False)
class Gesture:
    """A drag with its amounts, or a step back or forth.

    Args:
        drag: what is done; None for a step.
        amounts: since the drag began, in the order in which it went through them.
        step: which way through the history, where there is no drag.
    """

    drag: Drag | None
    amounts: tuple[float, ...] = ()
    step: Literal["undo", "redo"] = "undo"


def read_gestures(path: Path) -> list[Gesture]:
    """Read a file of gestures.

    Raises:
        ValueError: a file that cannot be read, a line that is no gesture; the message names file,
            line and field.
    """
    lines = read_json_lines(path)
    if len(lines) > MOST_GESTURES:
        raise ValueError(f"{path}: expected at most {MOST_GESTURES} gestures, got {len(lines)}")
    return [_gesture(given, f"{path}:{at}") for at, given in lines]


def replay(editor: SceneEditor, gestures: Iterable[Gesture]) -> Scene:
    """Do what was recorded, amount by amount; returns the scene at the end.

    Raises:
        ValueError: an object that is not there, an amount that the drag refuses.
    """
    for gesture in gestures:
        if gesture.drag is None:
            editor.undo() if gesture.step == "undo" else editor.redo()
            continue
        editor.begin(gesture.drag)
        for amount in gesture.amounts:
            editor.drag_to(amount)
        editor.end()
    return editor.scene


def _gesture(given: Any, where: str) -> Gesture:
    if not isinstance(given, dict):
        raise ValueError(f"{where}: expected an object of JSON, got {type(given).__name__}")
    kind = given.get("do")
    if kind in ("undo", "redo"):
        _only(given, {"do"}, where)
        return Gesture(None, step=kind)
    if kind not in tuple(_AMOUNTS):  # whatever JSON holds, lists too
        raise ValueError(f"{where}: do: expected {', '.join(_AMOUNTS)}, undo or redo, got {kind!r}")
    _only(given, {"object", "do", "axis", "frame", _AMOUNTS[kind]}, where)
    name = given.get("object")
    if not isinstance(name, str):
        raise ValueError(f"{where}: object: expected a name, got {name!r}")
    axis = vector(given.get("axis", [0, 0, 1]), f"{where}: axis", 3)
    amounts = _amounts(given.get(_AMOUNTS[kind]), f"{where}: {_AMOUNTS[kind]}")
    try:
        drag = Drag(name, kind, axis, given.get("frame", "local"))
    except (ValueError, TypeError) as fault:
        raise ValueError(f"{where}: {fault}") from fault
    return Gesture(drag, amounts)


def _amounts(given: object, where: str) -> tuple[float, ...]:
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise ValueError(f"{where}: expected a list of one number or more, got {given!r}")
    return tuple(number(one, where) for one in given)


def _only(given: dict[str, Any], known: set[str], where: str) -> None:
    unknown = sorted(set(given) - known)
    if unknown:
        raise ValueError(
            f"{where}: expected fields of {', '.join(sorted(known))}, got {unknown[0]!r}"
        )
