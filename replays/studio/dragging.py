"""What fingers on the image do to an object: rays of the tracked camera to amounts of a drag.

A gesture is told by the pixels of its fingers, then and now. Rays go through them; planes and lines
stand where the object was grabbed, and the drag's amount is counted since the gesture began.

A hand, a foot or the head of a character in somebody's hand: its limb follows the finger.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from motorcade.animation.authoring import Drag, Dragged, Edit, Scene, Snapping
from motorcade.animation.authoring.drags import Kind, dragged
from motorcade.animation.authoring.pointing import (
    DragPlane,
    JointDrag,
    OutOfReach,
    Ray,
    TurnedJoints,
    moved,
    pinched,
    slid,
    turned,
    unwound,
)
from motorcade.animation.authoring.poses import Frame
from motorcade.animation.retarget import body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.studio.filmed import PlayedScene

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

    Raises ValueError: an unknown gesture, another number of fingers.
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


class ObjectDrag:
    """An object in somebody's hand: what it was when it was taken, and how far it has come.

    Args:
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

        Raises ValueError: a gesture that cannot follow on the one before; OutOfReach: a finger that
        points past what it is to move.
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

        Raises ValueError: no such amount, another number of fingers; OutOfReach: a finger that
        points past what it moves.
        """
        assert self.drag is not None  # it was taken
        if self._grab.gesture in BY_AMOUNT:
            if amount is None:
                raise ValueError("amount: expected a number")
            dragged_by: Amount = amount
        elif len(rays) != len(self._grab.rays):
            raise ValueError("pixels: expected as many as there were at the beginning")
        else:
            dragged_by = self._by_rays(rays)
        scene = dragged(self.before, self.drag, self._snapped(dragged_by), self.anchors)
        self.amount = self._snapped(dragged_by)
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

    def shown_amount(self) -> str:
        """How far it has come, for people."""
        if self.drag is None or self.amount is None:
            return ""
        if isinstance(self.amount, Similarity):
            rotor, _, scale = self.amount.as_rotor_translation_scale()
            way = self.amount.apply(self._parent_T_object.translation_m)
            far = float(np.linalg.norm(way - self._parent_T_object.translation_m))
            angle, grown = float(rotor.angle()), float(scale)
            text = f"{100 * far:.1f} cm"
            text += f", {np.degrees(angle):.0f}°" if angle > 1e-6 else ""
            return text + (f", × {grown:.2f}" if abs(grown - 1.0) > 1e-6 else "")
        if self.drag.kind == "rotate":
            return f"{np.degrees(self.amount):.1f}°"
        moves = self.drag.kind == "translate"
        return f"{100 * self.amount:.1f} cm" if moves else f"× {self.amount:.2f}"


def _pointed_at(plane: DragPlane, rays: Sequence[Ray]) -> DragPlane:
    """The plane, where every finger points at it; raises `OutOfReach` where one does not."""
    for ray in rays:
        plane.met_by(ray)
    return plane


def on_ray(ray: Ray, point_m: FloatArray) -> FloatArray:
    """The place on a ray nearest to a point, so that what is grabbed is under the finger."""
    along = float((point_m - ray.origin_m) @ ray.direction)
    return ray.origin_m + along * ray.direction


HELD_BY = ("head", "left_hand", "right_hand", "left_foot", "right_foot")
"""Parts of a body that a pose is dragged by."""


def joints_held_by(skeleton: Skeleton) -> dict[str, int]:
    """The joints that a pose is dragged by: numbers in the skeleton by the part of the body."""
    body = body_of(skeleton)
    return {part: body[part] for part in HELD_BY if part in body}


class LimbDrag:
    """A joint that is held: the pose in which it was taken, and how its limb is turned now.

    It is dragged in the plane through it that is parallel to the image.

    Args:
        frame: the image on which it is taken.
        ray: of the finger.
        joint: its name; None takes the nearest of those that a pose is dragged by.

    Raises ValueError: no character, no such joint, or one above which none may turn; OutOfReach: a
    finger that points past it.
    """

    def __init__(
        self,
        played: PlayedScene,
        scene: Scene,
        name: str,
        frame: int,
        ray: Ray,
        joint: str | None = None,
    ) -> None:
        if scene.part(name).kind != "character":
            raise ValueError("joint: expected a character")
        self.name, self.time_s = name, float(played.filmed.time_s[frame])
        acted = played.acted(scene, name)[1]
        skeleton = acted.character.skeleton
        poses = played.local_poses(acted)
        pose = poses[min(frame, poses.shape[0] - 1)]
        at = skeleton.world(pose).translation_m
        stands = played.world_T_object(scene, name)
        rigid, scale = stands[min(frame, stands.shape[0] - 1)].as_motor_scale()
        world_T_character = Similarity.from_motor_scale(rigid, scale * acted.size)
        self._character_T_world = world_T_character.inverse()
        self.skeleton = skeleton
        ray = self._inside(ray)
        if joint is None:
            joint = _nearest(skeleton, at, ray)
        self.joint = joint
        held = on_ray(ray, at[skeleton.index(joint)])
        ahead = played.filmed.world_T_camera[frame].rotor.apply([0.0, 0.0, 1.0])
        plane = DragPlane(held, self._character_T_world.rotor.apply(ahead))
        plane.met_by(ray)
        self._drag = JointDrag(skeleton, pose, joint, plane)
        self._turned: TurnedJoints | None = None

    def move(self, rays: Sequence[Ray]) -> Motor:
        """The joints ``(J,)`` in the character's space, with what is held under the finger.

        Raises ValueError: not one ray; OutOfReach: a finger that points past the character.
        """
        if len(rays) != 1:
            raise ValueError("pixels: expected those of one finger")
        self._turned = self._drag.to(self._inside(rays[0]))
        return self.skeleton.world(self._turned.local_pose)

    def gesture(self) -> Edit | None:
        """What was done with it, as one step; None where it was not moved."""
        if self._turned is None:
            return None
        turns: Mapping[str, list[float]] = {
            joint: rotor.as_quaternion().tolist() for joint, rotor in self._turned.rotors.items()
        }
        line = {"do": "joints", "object": self.name, "time_s": self.time_s, "joints": turns}
        return Edit(line)

    def _inside(self, ray: Ray) -> Ray:
        return ray.seen_from(self._character_T_world)


def _nearest(skeleton: Skeleton, at: FloatArray, ray: Ray) -> str:
    """Of the joints that a pose is dragged by, the one that a ray passes nearest in the image.

    Raises ValueError: there is none.
    """
    numbers = list(joints_held_by(skeleton).values())
    if not numbers:
        raise ValueError("joint: expected a character whose hands, feet or head are known")
    away = at[numbers] - ray.origin_m
    along = away @ ray.direction / np.linalg.norm(away, axis=-1)
    return skeleton.names[numbers[int(np.argmax(along))]]
