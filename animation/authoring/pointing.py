"""Pointing at a scene: rays of fingers, what they move, turn and grow, and joints they drag.

All of it is in one frame of the caller's choice, in metres. In an object's parent frame a drag is
the same wherever the parent goes meanwhile: `Ray.seen_from` takes a ray there.

Each says what took place since the drag began, from the rays of then and of now: what a `Drag`
takes as its amount. `moved` and `pinched` give similarities that act in the frame of the rays, so
that what was grabbed is under the fingers again.

The limb starts from the pose in which it was grabbed, and only its own joints turn: elbows and
knees as hinges in the plane in which they are bent, all others freely. Nothing jumps when it is
touched, and the same finger always gives the same pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.authoring.poses import checked_vector
from motorcade.animation.ik.chain import Ball, Hinge, JointKind, checked_direction
from motorcade.animation.ik.solver import IkSolver, PoseGoal
from motorcade.animation.retarget import body_of
from motorcade.animation.retarget.reference import ancestors
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import perpendicular, unit
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, frozen

__all__ = [
    "DragPlane",
    "JointDrag",
    "OutOfReach",
    "Ray",
    "TurnedJoints",
    "moved",
    "pinched",
    "slid",
    "turned",
    "unwound",
]


# A ray meets a plane at its horizon where it does so this many times farther away, or nearer, than
# what was grabbed: there a pixel is more than the whole scene.
HORIZON = 1000.0


class OutOfReach(ValueError):
    """A ray leads to no point that something could be dragged to: above a horizon, or behind."""


@dataclass(frozen=True, eq=False)
class Ray:
    """What lies under a pixel.

    Args:
        origin_m: ``(3,)``, where the camera is.
        direction: ``(3,)`` of any length but 0.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, no direction.

    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray
    >>> down = Ray([0.0, 0.0, 2.0], [1.0, 0.0, -1.0])
    >>> DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]).met_by(down).round(12) + 0.0
    array([2., 0., 0.])
    """

    origin_m: FloatArray
    direction: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin_m", frozen(checked_vector(self.origin_m, "Ray.origin_m")))
        direction = frozen(checked_direction(self.direction, "Ray.direction"))
        object.__setattr__(self, "direction", direction)

    def seen_from(self, frame_T_here: Similarity) -> Ray:
        """The same ray in another frame."""
        rotor = frame_T_here.rotor
        return Ray(frame_T_here.apply(self.origin_m), rotor.apply(self.direction))


@dataclass(frozen=True, eq=False)
class DragPlane:
    """The plane in which a grabbed point is dragged.

    Args:
        point_m: ``(3,)``, what was grabbed.
        normal: ``(3,)`` of any length but 0: that of the ground, or along the camera's axis for
            what follows the finger in a plane parallel to the image.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, no direction.
    """

    point_m: FloatArray
    normal: FloatArray

    def __post_init__(self) -> None:
        point = frozen(checked_vector(self.point_m, "DragPlane.point_m"))
        object.__setattr__(self, "point_m", point)
        normal = frozen(checked_direction(self.normal, "DragPlane.normal"))
        object.__setattr__(self, "normal", normal)

    def met_by(self, ray: Ray) -> FloatArray:
        """Where a ray meets the plane, ``(3,)``.

        Raises:
            OutOfReach: above the horizon, along the plane, or behind the camera.
        """
        away = self.point_m - ray.origin_m
        height, slope = float(self.normal @ away), float(self.normal @ ray.direction)
        size = float(np.linalg.norm(away))
        # By products, as quotients of nearly nothing are no numbers.
        if not abs(slope) * size < HORIZON * abs(height) or not height * slope > 0.0:
            raise OutOfReach("the finger points past the plane: expected at a place in it")
        if not abs(height) < HORIZON * size * abs(slope):
            raise OutOfReach("the finger points above the horizon of the plane: expected below it")
        return ray.origin_m + (height / slope) * ray.direction


# The sine of an angle between ray and axis below which a pixel is no longer a place on the axis.
_ALONG = 0.01
# Fingers or hands this near, as a share of how far away they are, say no direction.
_APART = 1e-6


def moved(plane: DragPlane, start: Ray, now: Ray) -> Similarity:
    """One finger: the shift in the plane that brings what was under it under it again.

    Args:
        plane: through what was grabbed.
        start: the finger when the drag began.
        now: the finger.

    Raises:
        OutOfReach: see `DragPlane.met_by`.

    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray, moved
    >>> ground = DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    >>> start, now = (Ray([0.0, 0.0, 2.0], [x, 0.0, -1.0]) for x in (0.0, 0.25))
    >>> moved(ground, start, now).translation_m.round(12) + 0.0
    array([0.5, 0. , 0. ])
    """
    way = plane.met_by(now) - plane.met_by(start)
    return Similarity.from_motor_scale(Motor.from_translation(way))


def pinched(plane: DragPlane, start: tuple[Ray, Ray], now: tuple[Ray, Ray]) -> Similarity:
    """Two fingers: the one similarity of the plane that brings both points under them again.

    It shifts, turns about the plane's normal, and grows.

    Args:
        plane: through what was grabbed.
        start: the fingers when the drag began.
        now: the same fingers.

    Raises:
        OutOfReach: see `DragPlane.met_by`; fingers at one place.

    >>> import numpy as np
    >>> from motorcade.animation.authoring.pointing import DragPlane, Ray, pinched
    >>> ground = DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    >>> start = tuple(Ray([0.0, 0.0, 2.0], [x, 0.0, -1.0]) for x in (-0.1, 0.1))
    >>> now = tuple(Ray([0.0, 0.0, 2.0], [0.0, y, -1.0]) for y in (-0.2, 0.2))
    >>> made = pinched(ground, start, now)
    >>> float(made.scale.round(12)), float(np.degrees(made.rotor.angle()).round(9))
    (2.0, 90.0)
    """
    first, second = ([plane.met_by(ray) for ray in pair] for pair in (start, now))
    ways = [pair[1] - pair[0] for pair in (first, second)]
    for way, pair in zip(ways, (start, now), strict=True):
        away = float(np.linalg.norm(plane.point_m - pair[0].origin_m))
        if not float(np.linalg.norm(way)) > _APART * away:
            raise OutOfReach("the fingers are at one place: expected two apart")
    across = perpendicular(plane.normal)
    aside = np.cross(plane.normal, across)
    before, after = (complex(way @ across, way @ aside) for way in ways)
    growth = after / before
    rotor = Rotor.from_rotation_vector(np.angle(growth) * plane.normal)
    still = Similarity.from_rotor_translation_scale(rotor, np.zeros(3), abs(growth))
    shift = second[0] - still.apply(first[0])
    return Similarity.from_rotor_translation_scale(rotor, shift, abs(growth))


def slid(point_m: ArrayLike, axis: ArrayLike, start: Ray, now: Ray) -> float:
    """One finger along an axis through what was grabbed: how far, in metres.

    The point of the axis nearest to the ray is taken.

    Args:
        point_m: ``(3,)``, what was grabbed.
        axis: ``(3,)`` direction.
        start: the finger when the drag began.
        now: the finger.

    Raises:
        OutOfReach: a ray along the axis, or one that passes it behind the camera.
        ValueError: an axis without direction.

    >>> from motorcade.animation.authoring.pointing import Ray, slid
    >>> start, now = (Ray([-2.0, 0.0, 0.0], [1.0, 0.0, slope]) for slope in (0.0, 0.25))
    >>> slid([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], start, now)
    0.5
    """
    point = checked_vector(point_m, "slid(point_m)")
    along = checked_direction(axis, "slid(axis)")
    return _at_m(point, along, now) - _at_m(point, along, start)


def _at_m(point: FloatArray, along: FloatArray, ray: Ray) -> float:
    """How far along an axis from a point the place is that is nearest to a ray."""
    across = np.cross(along, ray.direction)
    sine = float(np.linalg.norm(across))
    if sine < _ALONG:
        raise OutOfReach("the finger points along the axis: expected it to point across")
    away = point - ray.origin_m
    depth = float(np.cross(away, along) @ -across) / sine**2
    if not 0.0 < depth < HORIZON * float(np.linalg.norm(away)):
        raise OutOfReach("the finger points beyond the axis: expected a place on it")
    return float(np.cross(away, ray.direction) @ -across) / sine**2


def turned(point_m: ArrayLike, axis: ArrayLike, start: Ray, now: Ray) -> float:
    """One finger on a ring about an axis: by what angle, right-handed, within ±π.

    Args:
        point_m: ``(3,)``, the ring's centre.
        axis: ``(3,)`` direction, across the ring.
        start: the finger when the drag began.
        now: the finger; see `unwound` for more than half a turn.

    Raises:
        OutOfReach: see `DragPlane.met_by`, of the ring's plane; a finger at its centre.
        ValueError: an axis without direction.

    >>> import numpy as np
    >>> from motorcade.animation.authoring.pointing import Ray, turned
    >>> start, now = (Ray([0.0, 0.0, 2.0], [*at, -2.0]) for at in ([1.0, 0.0], [0.0, 1.0]))
    >>> float(np.degrees(turned([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], start, now)).round(9))
    90.0
    """
    ring = DragPlane(checked_vector(point_m, "turned(point_m)"), np.asarray(axis))
    ways = [ring.met_by(ray) - ring.point_m for ray in (start, now)]
    for way, ray in zip(ways, (start, now), strict=True):
        away = float(np.linalg.norm(ring.point_m - ray.origin_m))
        if not float(np.linalg.norm(way)) > _APART * away:
            raise OutOfReach("the finger is at the centre of the ring: expected it beside")
    return float(np.arctan2(np.cross(ways[0], ways[1]) @ ring.normal, ways[0] @ ways[1]))


def unwound(angle_rad: float, near_rad: float) -> float:
    """The angle, some whole turns on, that is nearest to another: the last one of a drag.

    >>> from motorcade.animation.authoring.pointing import unwound
    >>> round(unwound(-3.0, 3.1), 6)
    3.283185
    """
    return angle_rad + 2.0 * np.pi * round((near_rad - angle_rad) / (2.0 * np.pi))


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
        depth = min((along - half, along + half), key=lambda depth_m: abs(depth_m - wanted))
        point: FloatArray = ray.origin_m + depth * ray.direction
        return point


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
    kinds: dict[str, JointKind] = {}
    for number_above in limb:
        bend = _BENDS.get(roles.get(number_above, "").partition("_")[2])
        below = next((k for k in (number, *above) if skeleton.parents[k] == number_above), number)
        hinge = None if bend is None else _hinge(skeleton, at, number_above, below, bend)
        kinds[skeleton.names[number_above]] = hinge or Ball()
    return kinds


def _hinge(skeleton: Skeleton, at: Motor, joint: int, below: int, bend: float) -> Hinge | None:
    """An elbow or a knee in the plane in which it is bent; None where none is to be told."""
    parent = int(skeleton.parents[joint])
    rest = skeleton.rest_world
    upper = unit(at.translation_m[joint] - at.translation_m[parent])
    lower = unit(at.translation_m[below] - at.translation_m[joint])
    across = np.cross(upper, lower)
    bent = float(np.arctan2(np.linalg.norm(across), upper @ lower))
    rotor = at[joint].rotor
    if np.linalg.norm(across) < _STRAIGHT:
        resting = unit(rest.translation_m[below] - rest.translation_m[joint])
        across, rotor = np.cross(resting, [bend, 0.0, 0.0]), rest[joint].rotor
        if np.linalg.norm(across) < _STRAIGHT:
            return None
        bent = 0.0
    axis = rotor.inverse().apply(unit(across))
    return Hinge(axis, -bent, max(_FULL_BEND_RAD - bent, 0.0))
