"""A hand, a foot or the head of a character in somebody's hand: its limb follows the finger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorcade.animation.authoring import Edit, Scene
from motorcade.animation.authoring.pointing import DragPlane, JointDrag, Ray, TurnedJoints
from motorcade.animation.retarget import body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.studio.server.grip import on_ray
from motorcade.replays.studio.server.played import PlayedScene

HELD_BY = ("head", "left_hand", "right_hand", "left_foot", "right_foot")
"""Parts of a body that a pose is dragged by."""


def joints_held_by(skeleton: Skeleton) -> dict[str, int]:
    """The joints that a pose is dragged by: numbers in the skeleton by the part of the body."""
    body = body_of(skeleton)
    return {part: body[part] for part in HELD_BY if part in body}


class JointGrip:
    """A joint that is held: the pose in which it was taken, and how its limb is turned now.

    It is dragged in the plane through it that is parallel to the picture.

    Args:
        played: what objects do.
        scene: in which it is taken.
        name: of the character.
        frame: the picture on which it is taken.
        ray: of the finger.
        joint: its name; None takes the nearest of those that a pose is dragged by.

    Raises:
        ValueError: no character, no such joint, or one above which none may turn.
        OutOfReach: a finger that points past it.
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
        one = played.acted(scene, name)[1]
        skeleton = one.character.skeleton
        poses = played.local_poses(one)
        pose = poses[min(frame, poses.shape[0] - 1)]
        at = skeleton.world(pose).translation_m
        stands = played.world_T_object(scene, name)
        rigid, scale = stands[min(frame, stands.shape[0] - 1)].as_motor_scale()
        world_T_character = Similarity.from_motor_scale(rigid, scale * one.size)
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

        Raises:
            ValueError: not one ray.
            OutOfReach: a finger that points past the character.
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
    """Of the joints that a pose is dragged by, the one that a ray passes nearest in the picture.

    Raises:
        ValueError: there is none.
    """
    numbers = list(joints_held_by(skeleton).values())
    if not numbers:
        raise ValueError("joint: expected a character whose hands, feet or head are known")
    away = at[numbers] - ray.origin_m
    along = away @ ray.direction / np.linalg.norm(away, axis=-1)
    return skeleton.names[numbers[int(np.argmax(along))]]
