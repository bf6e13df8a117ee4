"""Joints dragged by a finger: a hand, a foot or a head that goes in a plane, its limb after it.

The limb starts from the pose in which it was grabbed, and only its own joints turn: elbows and
knees as hinges in the plane in which they are bent, all others freely. Nothing jumps when it is
touched, and the same finger always gives the same pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motorcade.animation.authoring.pointing.rays import DragPlane, Ray
from motorcade.animation.authoring.poses import checked_vector
from motorcade.animation.ik import Ball, Hinge, IkSolver, PoseGoal
from motorcade.animation.ik.joints import JointKind
from motorcade.animation.retarget import body_of
from motorcade.animation.retarget.roles import ancestors
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# Joints that a limb ends with towards the trunk, and those that only bend, with the way in which
# they do so in a figure that faces +x.
_TOPS = ("thigh", "upper_arm", "clavicle")
_BENDS = {"forearm": 1.0, "calf": -1.0}
_FULL_BEND_RAD = 2.6
# Less than this and a limb is straight: the bones' plane is not to be told.
_STRAIGHT = 0.05
# Of joints that no role is known of, so many turn above the one that is dragged.
_ABOVE = 2
_TOLERANCE = 1e-11
# Where the plane is out of reach, so many places at other depths are tried.
_DEPTHS, _SLACK = 4, 1e-6


@dataclass(frozen=True, eq=False)
class TurnedJoints:
    """How a limb was turned.

    Fields:
        rotors: ``parent_T_joint`` of the joints that turn, as a `JointKeyframe` has them.
        local_pose: Motor ``(J,)`` of the whole skeleton.
        error_m: how far what was grabbed is from the finger's ray; 0 within rounding where the
            limb reaches so far.
    """

    rotors: Mapping[str, Rotor]
    local_pose: Motor
    error_m: float


class JointDrag:
    """A joint that was grabbed, and follows a finger.

    All is in character space, at the size of the skeleton: see `Ray.seen_from`.

    Args:
        skeleton: with J joints.
        local_pose: Motor ``(J,)``, in which it was grabbed.
        joint: its name.
        plane: through what was grabbed, such as the camera's axis has it.

    Raises:
        ValueError: no such joint, or one above which none may turn; a pose that does not fit.

    >>> import numpy as np
    >>> from motorcade.animation import mannequin
    >>> from motorcade.animation.authoring.pointing import DragPlane, JointDrag, Ray
    >>> figure = mannequin()
    >>> rest = figure.skeleton.rest
    >>> hand = figure.skeleton.rest_world.translation_m[figure.skeleton.index("left_hand")]
    >>> drag = JointDrag(figure.skeleton, rest, "left_hand", DragPlane(hand, [1.0, 0, 0]))
    >>> eye = np.array([3.0, 0.0, 1.5])
    >>> made = drag.to(Ray(eye, hand + [0.0, -0.1, 0.2] - eye))
    >>> sorted(made.rotors), bool(made.error_m < 1e-9)
    (['left_forearm', 'left_upper_arm'], True)
    """

    def __init__(self, skeleton: Skeleton, local_pose: Motor, joint: str, plane: DragPlane) -> None:
        if local_pose.shape != (len(skeleton),):
            raise ValueError(
                f"JointDrag(local_pose): expected shape ({len(skeleton)},), got {local_pose.shape}"
            )
        self.skeleton, self.joint, self.plane = skeleton, joint, plane
        kinds = limb_above(skeleton, local_pose, joint)
        if not kinds:
            raise ValueError(f"JointDrag(joint): expected joints above '{joint}' that may turn")
        # Turns are counted from where each joint is now.
        here = Skeleton(skeleton.names, skeleton.parents, local_pose)
        self._turning = tuple(kinds)
        self._pose, self._solver = local_pose, IkSolver(here, kinds)
        self._number = skeleton.index(joint)
        top = min(skeleton.index(name) for name in kinds)  # parents come first
        self._top_m = here.rest_world.translation_m[top]
        at = here.rest_world[self._number]
        self._grabbed_m = at.inverse().apply(checked_vector(plane.point_m, "JointDrag(plane)"))

    def to(self, ray: Ray) -> TurnedJoints:
        """The limb with what was grabbed under a finger, or as near to it as it reaches: in the
        plane where it can, else nearer or farther.

        Raises:
            OutOfReach: see `DragPlane.met_by`.
        """
        place, pose = self.plane.met_by(ray), self._pose
        for _ in range(_DEPTHS):
            goal = PoseGoal(self.joint, place, point_m=self._grabbed_m)
            solved = self._solver.solve(pose, [goal], restarts=0, tolerance=_TOLERANCE)
            pose = solved.local_pose
            there = self.skeleton.world(pose)[self._number].apply(self._grabbed_m)
            if bool(solved.reached[0]):
                break
            place = self._within_reach(ray, place, there)
        error_m = float(np.linalg.norm(np.cross(there - ray.origin_m, ray.direction)))
        rotors = {name: pose[self.skeleton.index(name)].rotor for name in self._turning}
        return TurnedJoints(rotors, pose, error_m)

    def _within_reach(self, ray: Ray, place: FloatArray, there: FloatArray) -> FloatArray:
        """The place under the finger as far from the limb's top as the limb came: where a ray
        meets a sphere, or passes it.

        Args:
            ray: of the finger.
            place: ``(3,)``, where it could not come.
            there: ``(3,)``, how near it came.
        """
        radius = float(np.linalg.norm(there - self._top_m))
        if len(self._turning) > 1:  # a little less than stretched, or than folded
            far = float(np.linalg.norm(place - self._top_m)) > radius
            radius *= 1.0 - _SLACK if far else 1.0 + _SLACK
        away = self._top_m - ray.origin_m
        along = float(ray.direction @ away)
        aside = float(np.linalg.norm(np.cross(away, ray.direction)))
        half = np.sqrt(max(radius**2 - aside**2, 0.0))
        wanted = float(ray.direction @ (place - ray.origin_m))
        depth = min((along - half, along + half), key=lambda one: abs(one - wanted))
        made: FloatArray = ray.origin_m + depth * ray.direction
        return made


def limb_above(skeleton: Skeleton, local_pose: Motor, joint: str) -> dict[str, JointKind]:
    """The joints that turn when one is dragged, and how each does, counted from a pose.

    Raises:
        ValueError: no such joint.
    """
    number = skeleton.index(joint)
    roles = {one: role for role, one in body_of(skeleton).items()}
    above = [one for one in ancestors(skeleton, number) if skeleton.parents[one] >= 0]
    parts = [roles.get(one, "").partition("_")[2] for one in above]
    top = next((k for k, part in enumerate(parts) if part in _TOPS), None)
    limb = [one for one in above[: (top or 0) + 1] if one in roles]
    if top is None:
        limb = above[:_ABOVE]
    at = skeleton.world(local_pose)
    made: dict[str, JointKind] = {}
    for one in limb:
        bend = _BENDS.get(roles.get(one, "").partition("_")[2])
        below = next((k for k in (number, *above) if skeleton.parents[k] == one), number)
        hinge = None if bend is None else _hinge(skeleton, at, one, below, bend)
        made[skeleton.names[one]] = hinge or Ball()
    return made


def _hinge(skeleton: Skeleton, at: Motor, joint: int, below: int, bend: float) -> Hinge | None:
    """An elbow or a knee in the plane in which it is bent; None where none is to be told."""
    parent = int(skeleton.parents[joint])
    rest = skeleton.rest_world
    upper = _unit(at.translation_m[joint] - at.translation_m[parent])
    lower = _unit(at.translation_m[below] - at.translation_m[joint])
    across = np.cross(upper, lower)
    bent = float(np.arctan2(np.linalg.norm(across), upper @ lower))
    rotor = at[joint].rotor
    if np.linalg.norm(across) < _STRAIGHT:
        resting = _unit(rest.translation_m[below] - rest.translation_m[joint])
        across, rotor = np.cross(resting, [bend, 0.0, 0.0]), rest[joint].rotor
        if np.linalg.norm(across) < _STRAIGHT:
            return None
        bent = 0.0
    axis = rotor.inverse().apply(_unit(across))
    return Hinge(axis, -bent, max(_FULL_BEND_RAD - bent, 0.0))


def _unit(vector: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(vector))
    made: FloatArray = vector / length if length > 0.0 else vector
    return made
