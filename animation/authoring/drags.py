"""Drags: what moving a finger or a mouse does to an object, counted since the drag began."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from motorcade.animation.authoring.parts import SceneKeyframe, ScenePart, SceneWalk
from motorcade.animation.authoring.poses import EulerObjectPose, Frame, ObjectPose, pose_of
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import FARTHEST_M, MOST_KEYFRAMES, SCALES
from motorcade.ga import Rotor, Similarity
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number, frozen
from motorcade.ga.names import check_word

Kind = Literal["rotate", "translate", "scale", "similarity"]
Amount = float | Similarity
"""Rad, m, a factor above 0, or a similarity: since the drag began."""
KINDS = ("rotate", "translate", "scale", "similarity")
FRAMES = ("local", "parent", "global")
# Keyframes nearer than this are one: frames are not so close.
SAME_TIME_S = 1e-6


@dataclass(frozen=True, eq=False)
class Drag:
    """What a drag does to which object.

    Args:
        object_name: which.
        kind: rotate (amounts in rad), translate (m), scale (factors, above zero) or similarity
            (a `Similarity`: a turn, a shift and growth at once, as two fingers make them).
        axis: ``(3,)`` direction in the frame, of any length; for turns and shifts.
        frame: the object's own axes, its parent's, or the world's.
        time_s: when it takes place; an object with keyframes gets one there.

    Raises:
        ValueError: an unknown kind or frame, an axis without direction, a time that is not finite.

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
    time_s: float | None = None

    def __post_init__(self) -> None:
        check_word(self.kind, KINDS, "Drag.kind")
        if self.frame not in FRAMES:
            raise ValueError(f"Drag.frame: expected local, parent or global, got {self.frame!r}")
        axis = checked_floats(self.axis, "Drag.axis", (3,))
        length = float(np.linalg.norm(axis))
        if axis.shape != (3,) or length < 1e-9:
            raise ValueError(f"Drag.axis: expected a direction (3,), got {self.axis}")
        if abs(length - 1.0) > 1e-12:  # so that an axis that is read back stays bit for bit
            axis = axis / length
        object.__setattr__(self, "axis", frozen(axis))
        if self.time_s is not None and not np.isfinite(checked_number(self.time_s, "Drag.time_s")):
            raise ValueError(f"Drag.time_s: expected a finite time, got {self.time_s}")

    def checked(self, amount: Amount) -> Amount:
        """The amount, where it is one of this kind.

        Raises:
            ValueError: an amount that is not finite or of another kind, a factor that is not
                positive.
        """
        if self.kind == "similarity":
            if not isinstance(amount, Similarity) or amount.shape != ():
                raise ValueError(f"Drag(amount): expected one Similarity, got {amount!r:.80}")
            return amount
        low = 0.0 if self.kind == "scale" else -np.inf
        number = isinstance(amount, int | float) and not isinstance(amount, bool)
        if not (number and low < float(amount) < np.inf):  # type: ignore[arg-type]
            expected = "a factor above 0" if self.kind == "scale" else "a finite amount"
            raise ValueError(f"Drag(amount): expected {expected}, got {amount!r:.80}")
        return amount

    def is_nothing(self, amount: Amount) -> bool:
        """Whether an amount leaves everything where it was."""
        if isinstance(amount, Similarity):
            return np.array_equal(amount.coefficients, _STILL)
        return amount == (1.0 if self.kind == "scale" else 0.0)

    def applied(self, pose: ObjectPose, amount: Amount, world_T_parent: Similarity) -> ObjectPose:
        """A pose after the whole drag.

        Raises:
            ValueError: see `checked`; a pose that a scene file could not hold: 999,000 km away or
                more, or of a scale outside 1e-6 to 1e6.
        """
        checked_amount = self.checked(amount)
        if isinstance(checked_amount, Similarity):
            object_pose: ObjectPose = pose.moved(checked_amount, self.frame, world_T_parent)
        elif self.kind == "rotate":
            object_pose = pose.rotated(self.axis, checked_amount, self.frame, world_T_parent)
        elif self.kind == "translate":
            object_pose = pose.translated(checked_amount * self.axis, self.frame, world_T_parent)
        else:
            object_pose = pose.scaled(checked_amount)
        return checked_pose(object_pose)


_STILL = Similarity.identity().coefficients


def checked_pose(pose: ObjectPose) -> ObjectPose:
    """The pose, where a scene file can hold it.

    Raises ValueError: 999,000 km or more from its parent, or a scale outside 1e-6 to 1e6.
    """
    _, shift_m, scale = pose.as_similarity().as_rotor_translation_scale()
    low, high = SCALES
    if not low <= scale <= high:
        raise ValueError(f"scale: expected {low:g} to {high:g}, got {float(scale):.4g}")
    farthest = float(np.abs(shift_m).max())
    if not farthest < FARTHEST_M:
        raise ValueError(f"position_m: expected less than {FARTHEST_M:g}, got {farthest:.4g}")
    return pose


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

    def rounded_about(self, origin_m: FloatArray, motion: Similarity) -> Similarity:
        """A similarity on the nearest steps: its growth, its turn about its own axis, and along
        each axis of its frame the way that it takes an object's origin.

        Args:
            origin_m: ``(3,)`` of the object in the frame of the motion.
            motion: which is rounded.
        """
        if not (self.angle_rad or self.distance_m or self.scale):
            return motion
        rotor, _, scale = motion.as_rotor_translation_scale()
        turn = rotor.as_rotation_vector()
        angle = float(np.linalg.norm(turn))
        if angle > 0.0:
            turn = turn * (self.rounded("rotate", angle) / angle)
        way = motion.apply(origin_m) - origin_m
        shift = np.array([self.rounded("translate", float(one)) for one in way])
        still = pose_of(
            Rotor.from_rotation_vector(turn), np.zeros(3), self.rounded("scale", float(scale))
        )
        return pose_of(still.rotor, origin_m + shift - still.apply(origin_m), still.scale)

    def snapped(self, drag: Drag, amount: Amount, origin_m: FloatArray) -> Amount:
        """The amount of a drag on the nearest steps.

        Args:
            drag: whose.
            amount: since it began.
            origin_m: ``(3,)`` of the object in the frame of the drag.
        """
        if isinstance(amount, Similarity):
            return self.rounded_about(origin_m, amount)
        return self.rounded(drag.kind, amount)


def dragged(
    scene: Scene, drag: Drag, amount: Amount, world_T_anchor: Mapping[str, Similarity]
) -> Scene:
    """A scene after a whole drag.

    An object with keyframes gets one at the time of the drag; one that walks takes its way along.

    Args:
        scene: in which the drag began.
        drag: what is done.
        amount: since it began.
        world_T_anchor: where anchors stand at its time.

    Raises:
        ValueError: no such object, an amount that the drag refuses, a drag without a time of an
            object with keyframes.
    """
    name = drag.object_name
    world_T_parent = scene.world_T_parent(name, drag.time_s, world_T_anchor)
    return placed(scene, name, drag.time_s, drag.applied(held(scene, drag), amount, world_T_parent))


def held(scene: Scene, drag: Drag) -> ObjectPose:
    """The pose in which a drag finds its object. Raises ValueError: no such object."""
    pose, part = scene.pose(drag.object_name), scene.part(drag.object_name)
    if not part.keyframes and part.walk is None:
        return pose
    return type(pose).from_similarity(scene.pose_at(drag.object_name, drag.time_s))


def placed(scene: Scene, name: str, time_s: float | None, pose: ObjectPose) -> Scene:
    """The scene with an object in a pose: at a time where it has keyframes, else for good.

    Raises ValueError: no such object, no time for one with keyframes, too many keyframes.
    """
    part = scene.part(name)
    if part.walk is not None:
        was = scene.pose_at(name)
        walk = walked(part.walk, pose.as_similarity() @ was.inverse())
        return scene.with_part(name, replace(part, walk=walk)).with_pose(name, pose)
    if not part.keyframes:
        return scene.with_pose(name, pose)
    if time_s is None:
        raise ValueError(f"time_s: expected a time, as '{name}' has keyframes, got none")
    if all(abs(one.time_s - time_s) >= SAME_TIME_S for one in part.keyframes):
        room_for_keyframes(scene, 1)
    return scene.with_part(name, with_keyframe(part, time_s, pose))


def room_for_keyframes(scene: Scene, more: int) -> None:
    """Refuse more keyframes than a scene file may hold."""
    if more > 0 and scene.keyframe_count + more > MOST_KEYFRAMES:
        raise ValueError(f"keyframes: expected at most {MOST_KEYFRAMES} in all, got more")


def with_keyframe(part: ScenePart, time_s: float, pose: ObjectPose) -> ScenePart:
    """The part with a keyframe at a time, in place of one that is there."""
    angles = None
    if isinstance(pose, EulerObjectPose):
        x, y, z = np.degrees(pose.angles_rad).tolist()
        angles = x, y, z
    kept = [one for one in part.keyframes if abs(one.time_s - time_s) >= SAME_TIME_S]
    kept.append(SceneKeyframe(float(time_s), pose.as_similarity(), angles))
    return replace(part, keyframes=tuple(sorted(kept, key=lambda keyframe: keyframe.time_s)))


def walked(walk: SceneWalk, motion: Similarity) -> SceneWalk:
    """The walk moved with its plane; what leads out of the plane is left out."""
    flat = np.column_stack([walk.path_m, np.zeros(len(walk.path_m))])
    return replace(walk, path_m=motion.apply(flat)[:, :2])
