"""What fingers on the picture do to an object: rays of the tracked camera to amounts of a drag.

A gesture is told by the pixels of its fingers, then and now. Rays go through them; planes and lines
stand where the object was grabbed, and the drag's amount is counted since the gesture began.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from motorcade.animation.authoring import Drag, Dragged, Scene, Snapping
from motorcade.animation.authoring.editing.drags import Kind, dragged
from motorcade.animation.authoring.pointing import (
    DragPlane,
    OutOfReach,
    Ray,
    moved,
    pinched,
    slid,
    turned,
    unwound,
)
from motorcade.animation.authoring.poses import Frame
from motorcade.ga import Rotor, Similarity
from motorcade.ga.arrays import FloatArray

BY_AMOUNT = ("scale", "turn")
"""Gestures of a wheel, which tell how far instead of where."""
GESTURES = ("move", "pinch", "axis", "ring", *BY_AMOUNT)
Amount = float | Similarity


@dataclass(frozen=True, eq=False)
class Grab:
    """How an object was taken.

    Args:
        gesture: one of `GESTURES`.
        rays: of the fingers: two to pinch, none for a wheel, else one.
        point_m: ``(3,)`` in the world, what was touched; None takes the object's own place.
        axis: ``(3,)`` of an axis or a ring, in `frame`.
        frame: whose axes: the object's own, its parent's or the world's.

    Raises:
        ValueError: an unknown gesture, another number of fingers.
    """

    gesture: str
    rays: tuple[Ray, ...]
    point_m: FloatArray | None = None
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    frame: Frame = "parent"

    def __post_init__(self) -> None:
        if self.gesture not in GESTURES:
            raise ValueError(f"gesture: expected one of {', '.join(GESTURES)}")
        if self.gesture not in BY_AMOUNT and len(self.rays) != (1 + (self.gesture == "pinch")):
            raise ValueError(f"pixels: expected another number of fingers to {self.gesture}")


class Grip:
    """An object in somebody's hand: what it was when it was taken, and how far it has come.

    Args:
        scene: in which the object is grabbed.
        name: of the object.
        time_s: when in the film.
        world_T_anchor: where the anchors are then.
        up: ``(3,)`` in the world, for what stands on nothing.
        snapping: steps of what is turned, moved and grown.
    """

    def __init__(
        self,
        scene: Scene,
        name: str,
        time_s: float,
        world_T_anchor: Mapping[str, Similarity],
        up: FloatArray,
        snapping: Snapping,
    ) -> None:
        self.before, self.name, self.anchors = scene, name, world_T_anchor
        self.time_s, self.snapping = time_s, snapping
        self._world_T_parent = scene.world_T_parent(name, time_s, world_T_anchor)
        self._parent_T_object = scene.pose_at(name, time_s)
        anchor = scene.anchor_of(name)
        self._up = up if anchor is None else world_T_anchor[anchor].rotor.apply([0.0, 0.0, 1.0])
        self._done = Similarity.identity()
        self._turned = 0.0
        self._origin = self._axis = np.zeros(3)
        self._metre = 1.0
        self.amount: Amount | None = None
        self.drag: Drag | None = None

    def take(self, grab: Grab) -> None:
        """Take hold, or take hold otherwise in the middle of it, as with a second finger.

        Raises:
            ValueError: a gesture that cannot follow on the one before.
            OutOfReach: a finger that points past what it is to move.
        """
        whole = grab.gesture in ("move", "pinch")
        if self.drag is not None and not (whole and self.drag.kind == "similarity"):
            raise ValueError("gesture: expected fingers to be lifted first")
        if whole:
            if isinstance(self.amount, Similarity):
                self._done = self.amount
            self._plane = self._plane_of(grab)
            self.drag = Drag(self.name, "similarity", frame="parent", time_s=self.time_s)
        else:
            self._take_handle(grab)
        self._grab = grab

    def move(self, rays: Sequence[Ray], amount: float | None) -> Scene:
        """The scene with the object where it is taken to; as many rays as it was taken by.

        Raises:
            ValueError: no such amount, another number of fingers.
            OutOfReach: a finger that points past what it moves.
        """
        assert self.drag is not None  # it was taken
        if self._grab.gesture in BY_AMOUNT:
            if amount is None:
                raise ValueError("amount: expected a number")
            found: Amount = amount
        elif len(rays) != len(self._grab.rays):
            raise ValueError("pixels: expected as many as there were at the beginning")
        else:
            found = self._by_rays(rays)
        scene = dragged(self.before, self.drag, self._snapped(found), self.anchors)
        self.amount = self._snapped(found)
        return scene

    def _by_rays(self, rays: Sequence[Ray]) -> Amount:
        first = self._grab.rays
        if self._grab.gesture == "axis":
            return slid(self._origin, self._axis, first[0], rays[0]) / self._metre
        if self._grab.gesture == "ring":
            angle = turned(self._origin, self._axis, first[0], rays[0])
            self._turned = unwound(angle, self._turned)
            return self._turned
        if self._grab.gesture == "pinch":
            motion = pinched(self._plane, (first[0], first[1]), (rays[0], rays[1]))
        else:
            motion = moved(self._plane, first[0], rays[0])
        inside = self._world_T_parent.inverse() @ motion @ self._world_T_parent
        return Similarity.normalize((inside @ self._done).coefficients)

    def _plane_of(self, grab: Grab) -> DragPlane:
        """The plane through what was touched; to pinch, that on which the object stands.

        So that it stays there while it grows. Fingers that do not point down to it, as on somebody
        as tall as the camera is high, are taken to hold the plane through what they touched.
        """
        now = self._world_T_parent @ self._done @ self._parent_T_object
        touched = now.translation_m if grab.point_m is None else on_ray(grab.rays[0], grab.point_m)
        if grab.gesture == "pinch":
            with suppress(OutOfReach):
                return _pointed_at(DragPlane(now.translation_m, self._up), grab.rays)
        return _pointed_at(DragPlane(touched, self._up), grab.rays)

    def _take_handle(self, grab: Grab) -> None:
        """An axis or a ring, or a wheel over the object."""
        kinds: dict[str, Kind] = {
            "axis": "translate",
            "ring": "rotate",
            "turn": "rotate",
            "scale": "scale",
        }
        world_T_object = self._world_T_parent @ self._parent_T_object
        frames = {"local": world_T_object, "parent": self._world_T_parent}
        frame = frames.get(grab.frame, Similarity.identity())
        axis = np.array(grab.axis, dtype=np.float64)
        self._origin, self._metre = world_T_object.translation_m, float(frame.scale)
        self.drag = Drag(self.name, kinds[grab.gesture], axis, grab.frame, self.time_s)
        self._axis = frame.rotor.apply(self.drag.axis)
        if grab.gesture == "ring":
            turned(self._origin, self._axis, grab.rays[0], grab.rays[0])

    def _snapped(self, amount: Amount) -> Amount:
        assert self.drag is not None  # it was taken
        return self.snapping.snapped(self.drag, amount, self._parent_T_object.translation_m)

    def gesture(self) -> Dragged | None:
        """What was done with it, as one step; None where it was not moved."""
        if self.drag is None or self.amount is None or self.drag.is_nothing(self.amount):
            return None
        return Dragged(self.drag, (self.amount,))

    def told(self) -> str:
        """How far it has come, for people."""
        if self.drag is None or self.amount is None:
            return ""
        if isinstance(self.amount, Similarity):
            rotor, _, scale = self.amount.as_rotor_translation_scale()
            way = self.amount.apply(self._parent_T_object.translation_m)
            far = float(np.linalg.norm(way - self._parent_T_object.translation_m))
            return ", ".join(
                [
                    f"{100 * far:.1f} cm",
                    *([f"{np.degrees(_angle(rotor)):.0f}°"] if _angle(rotor) > 1e-6 else []),
                    *([f"× {float(scale):.2f}"] if abs(float(scale) - 1.0) > 1e-6 else []),
                ]
            )
        if self.drag.kind == "rotate":
            return f"{np.degrees(self.amount):.1f}°"
        return (
            f"{100 * self.amount:.1f} cm"
            if self.drag.kind == "translate"
            else f"× {self.amount:.2f}"
        )


def _pointed_at(plane: DragPlane, rays: Sequence[Ray]) -> DragPlane:
    """The plane, where every finger points at it; raises `OutOfReach` where one does not."""
    for ray in rays:
        plane.met_by(ray)
    return plane


def on_ray(ray: Ray, point_m: FloatArray) -> FloatArray:
    """The place on a ray nearest to a point, so that what is grabbed is under the finger."""
    along = float((point_m - ray.origin_m) @ ray.direction)
    return ray.origin_m + along * ray.direction


def _angle(rotor: Rotor) -> float:
    return float(rotor.angle())
