"""Where a character stands: on a plane, or on an anchor that follows what tracking corrects.

A plane is given by `world_T_plane`: its ground is z = 0 of that frame, z points up. A placement is
`world_T_character` after a uniform scale: a point x of the character (metres of its own size,
soles at z = 0) appears at `world_T_character.apply(scale * x)`.

A tracker that closes a loop or sees its marker again moves a plane, a marker or a remembered pose
at once; a character that jumped along would give it away. The anchor shows the old place and lets
the difference die away along the screw between the two, whatever the frame rate.

A clip as it is read stays as its author made it, soles that hang over the ground or are below it
included. Where it is placed on something real, one constant height puts it on its soles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg
from motorcade.animation.ik.feet import sole_points
from motorcade.animation.retarget.reference import body_of
from motorcade.animation.vectors import UP, axes_along, turn_z, unit
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive

# What a hand turns no marker faster than, and how long it may be unseen and still count as seen.
_FASTEST_RAD_S, _UNSEEN_S = 12.0, 0.15


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a character stands and how large it is.

    Args:
        world_T_character: rigid pose, batch shape ().
        scale: uniform scale, applied before the pose.

    Raises:
        ValueError: a batch of poses, or a scale that is not positive and finite.

    >>> from motorcade.animation import Placement
    >>> from motorcade.ga import Motor
    >>> half_size = Placement(Motor.from_translation([1.0, 0, 0]), scale=0.5)
    >>> half_size.apply([0.0, 0, 1.8])  # the crown of a character 1.8 m tall
    array([1. , 0. , 0.9])
    """

    world_T_character: Motor
    scale: float

    def __post_init__(self) -> None:
        if self.world_T_character.shape != ():
            raise ValueError(
                "Placement.world_T_character: expected one pose, got a batch of shape "
                f"{self.world_T_character.shape}"
            )
        checked_positive(self.scale, "Placement.scale")

    @property
    def up(self) -> FloatArray:
        """(3,) unit vector in the world: the normal of what the character stands on."""
        return self.world_T_character.rotor.apply(UP)

    def as_matrix(self) -> FloatArray:
        """(4, 4) from character space to the world, the scale in it."""
        return self.world_T_character.as_matrix() @ np.diag([*[self.scale] * 3, 1.0])

    def apply(self, points: ArrayLike) -> FloatArray:
        """Points (*, 3) from character space into the world, metres."""
        own = checked_floats(points, "Placement.apply(points)", (3,))
        return self.world_T_character.apply(self.scale * own)


def place_on_plane(
    character: Character,
    position_m: ArrayLike = (0.0, 0.0),
    heading_rad: float = 0.0,
    *,
    height_m: float,
    world_T_plane: Motor | None = None,
) -> Placement:
    """Stand a character on a plane, upright, at a chosen height.

    Args:
        character: whose height in the rest pose sets the scale.
        position_m: (2,) where it stands, x and y of the plane's frame, metres.
        heading_rad: where it looks: 0 along the plane's x, turning towards its y.
        height_m: height of the placed character.
        world_T_plane: pose of the plane, batch shape (); without it the world's own ground, z = 0.

    Returns:
        The placement, with the soles in the plane.

    Raises:
        ValueError: a position that is not two finite numbers, a heading that is not finite, a
            height that is not positive, or a batch of planes.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton, place_on_plane
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> stands = place_on_plane(flag, (0.3, 0.1), heading_rad=np.pi / 2, height_m=1.0)
    >>> stands.scale, stands.apply([1.0, 0, 0]).round(3)  # its x points along the plane's y
    (0.5, array([0.3, 0.6, 0. ]))
    """
    position = checked_floats(position_m, "place_on_plane(position_m)", (2,))
    heading = checked_floats(heading_rad, "place_on_plane(heading_rad)", ())
    if position.shape != (2,) or heading.shape != ():
        raise ValueError(
            "place_on_plane: expected one position and one heading, got shapes "
            f"{position.shape} and {heading.shape}"
        )
    checked_positive(height_m, "place_on_plane(height_m)")
    plane_T_character = Motor.from_rotor_translation(
        turn_z(heading),
        np.array([position[0], position[1], 0.0]),
    )
    plane = Motor.identity() if world_T_plane is None else world_T_plane
    return Placement(plane @ plane_T_character, float(height_m) / character.height_m)


@dataclass(frozen=True, eq=False)
class Anchor:
    """A place that follows its corrections without popping; every verb returns a new anchor.

    Args:
        target: `world_T_anchor` as tracking knows it now, batch shape (); a pose, a marker's or a
            plane's (see `plane_anchor`), with a scale where characters shall grow with it.
        time_s: when that was.
        settle_s: the difference to what is shown falls to 1/e in this time; 0 follows at once.
        offset: what is shown as the target sees it; none at first.

    Raises:
        ValueError: a batch, a time that is not finite, a settling time that is negative.

    >>> from motorcade.animation.place import Anchor
    >>> from motorcade.ga import Motor, Similarity
    >>> def world_T_anchor(x_m):
    ...     return Similarity.from_motor_scale(Motor.from_translation([x_m, 0, 0]))
    >>> anchor = Anchor(world_T_anchor(0.0), settle_s=0.25).corrected(world_T_anchor(1.0), 10.0)
    >>> for time_s in (10.0, 10.25, 12.0):
    ...     print(anchor.at(time_s).translation_m.round(3) + 0.0)
    [0. 0. 0.]
    [0.632 0.    0.   ]
    [1. 0. 0.]
    """

    target: Similarity
    time_s: float = 0.0
    settle_s: float = 0.25
    offset: Similarity | None = None

    def __post_init__(self) -> None:
        if self.target.shape != ():
            raise ValueError(
                f"Anchor.target: expected one similarity, got a batch of shape {self.target.shape}"
            )
        if not np.isfinite(self.time_s):
            raise ValueError(f"Anchor.time_s: expected seconds, got {self.time_s}")
        if not (np.isfinite(self.settle_s) and self.settle_s >= 0.0):
            raise ValueError(f"Anchor.settle_s: expected 0 or more seconds, got {self.settle_s}")

    def at(self, time_s: float) -> Similarity:
        """`world_T_anchor` as it is shown at a time, not before the last correction.

        Raises:
            ValueError: a time before the last correction.
        """
        passed = time_s - self.time_s
        if not passed >= 0.0:
            raise ValueError(f"Anchor.at(time_s): expected {self.time_s} s or later, got {time_s}")
        if self.offset is None or self.settle_s == 0.0:
            return self.target
        left = float(np.exp(-passed / self.settle_s))
        return self.target @ Similarity.exp(left * self.offset.log())

    def corrected(self, target: Similarity, time_s: float) -> Anchor:
        """The anchor after tracking has moved it: what is shown does not change at that moment.

        Raises:
            ValueError: a batch, or a time before the last correction.
        """
        shown = self.at(time_s)
        offset = Similarity.normalize((target.inverse() @ shown).coefficients)
        return replace(self, target=target, time_s=time_s, offset=offset)

    def tracked(self, target: Similarity, time_s: float) -> Anchor:
        """The anchor after its target has moved of its own: what is shown moves along at once.

        Raises:
            ValueError: a batch, or a time before the last correction.
        """
        shown = self.at(time_s)
        offset = Similarity.normalize((self.target.inverse() @ shown).coefficients)
        return replace(self, target=target, time_s=time_s, offset=offset)


def followed(
    seen_s: FloatArray,
    world_T_target: Motor,
    time_s: FloatArray,
    *,
    fastest_m_s: float,
    settle_s: float = 0.25,
) -> Motor:
    """Where to show what hangs on a thing that moves and is not always seen.

    It moves along at once while the thing is seen to move. Where tracking leaps (faster than the
    thing can be), or finds the thing again, it glides there from where it was held.

    Args:
        seen_s: ``(S,)`` rising times at which it was seen, S at least 1.
        world_T_target: Motor ``(S,)``, where it was then.
        time_s: ``(F,)`` rising times to be shown; before the first observation it waits there.
        fastest_m_s: a faster step is a leap; so is a turn at more than 12 rad/s.
        settle_s: a glide's rest falls to 1/e in this time.

    Returns:
        Motor ``(F,)``.

    Raises:
        ValueError: nothing seen, or shapes that differ.
    """
    if not len(seen_s) or world_T_target.shape != (len(seen_s),):
        raise ValueError(
            f"followed(world_T_target): expected one pose for each of 1 or more times, got "
            f"{world_T_target.shape} for {len(seen_s)}"
        )
    targets = Similarity.from_motor_scale(world_T_target, np.ones(len(seen_s)))
    steps = (world_T_target[:-1].inverse() @ world_T_target[1:]).as_twist()
    passed = np.diff(seen_s)
    leaps = (
        (passed > _UNSEEN_S)
        | (
            np.linalg.norm(np.diff(world_T_target.translation_m, axis=0), axis=-1)
            > fastest_m_s * passed
        )
        | (np.linalg.norm(steps[:, :3], axis=-1) > _FASTEST_RAD_S * passed)
    )
    anchor, row, shown = Anchor(targets[0], float(seen_s[0]), settle_s), 0, []
    for moment in time_s:
        while row + 1 < len(seen_s) and seen_s[row + 1] <= moment:
            update = anchor.corrected if leaps[row] else anchor.tracked
            row += 1
            anchor = update(targets[row], float(seen_s[row]))
        shown.append(anchor.at(max(float(moment), float(seen_s[0]))).rigid)
    return Motor.stack(shown)


def plane_anchor(
    normal: FloatArray, point_m: FloatArray, ahead: FloatArray, scale: float = 1.0
) -> Similarity:
    """`world_T_anchor` on a plane: z along its normal, x as near to `ahead` as lies in it.

    Args:
        normal: ``(3,)`` out of the plane.
        point_m: ``(3,)`` of the plane, where the anchor stands.
        ahead: ``(3,)`` where the anchor's x looks.
        scale: of what hangs on it.

    Raises:
        ValueError: a normal of no length, or `ahead` along it.

    >>> import numpy as np
    >>> from motorcade.animation.place.anchors import plane_anchor
    >>> wall = plane_anchor(np.array([0, 1.0, 0]), np.array([0, 2.0, 0]), np.array([0, 0, 1.0]))
    >>> wall.apply([[1.0, 0, 0], [0, 0, 1.0]]).round(6) + 0.0  # its x points up, its z off the wall
    array([[0., 2., 1.],
           [0., 3., 0.]])
    """
    up, x = unit(np.asarray(normal, dtype=np.float64)), np.asarray(ahead, dtype=np.float64)
    if not np.any(up):
        raise ValueError("plane_anchor(normal): expected a direction, got none")
    level = x - (x @ up) * up
    if not np.linalg.norm(level) > 1e-9:
        raise ValueError(f"plane_anchor(ahead): expected a direction off the normal, got {ahead}")
    rotor = axes_along(level, np.cross(up, level))
    return Similarity.from_motor_scale(Motor.from_rotor_translation(rotor, point_m), scale)


# Soles that stand, in heights of the figure: how near to the ground, and how fast at the most up or
# down, and over the ground beside what it does on average (a walk on the spot slides evenly).
NEAR, FAST_UP, FAST_ALONG = 0.05, 0.1, 0.3
# What it stands on is at one height, within so many heights of the figure.
ONE_GROUND = 0.02
# A figure on its feet: its hips as a share of their height at rest, and how much the cosine of the
# trunk against up may differ from that at rest.
HIPS, TRUNK = 0.6, 0.5
# The share of its moments in which a clip stands that is to be called standing.
MOSTLY = 0.5
# Moments that are looked at, and between which speeds are taken.
RATE_HZ, MOST = 60.0, 1000


def standing_height_m(character: Character, legs: Sequence[Leg], clip: Clip) -> float | None:
    """Height of the lowest sole over z = 0 while a clip stands, its median; None if it does not.

    A moment stands if the lowest point of all soles is near the ground and nearly at rest, the hips
    are up and the trunk is upright; a clip does in which that holds, at one height, for half of the
    moments or more. What flies, lies, sits or falls does not, nor what runs
    in long leaps.

    Args:
        character: whose clip it is.
        legs: of it, with edges (`fitted_legs`).
        clip: of its skeleton.

    >>> from motorcade.animation import legs_of, mannequin
    >>> from motorcade.animation.ik import fitted_legs
    >>> from motorcade.animation.place.anchors import standing_height_m
    >>> figure = mannequin()
    >>> legs = fitted_legs(legs_of(figure.skeleton), figure)
    >>> round(standing_height_m(figure, legs, figure.clip("idle")), 2) + 0.0
    0.0
    """
    body = body_of(character.skeleton)
    if not legs or "hips" not in body:
        return None
    step_s = min(1.0 / RATE_HZ, clip.duration_s)
    count = min(int(np.ceil(clip.duration_s * RATE_HZ)) + 1, MOST)
    middle = np.linspace(clip.time_s[0], clip.time_s[-1], count)
    first = np.clip(middle - 0.5 * step_s, clip.time_s[0], clip.time_s[-1] - step_s)
    places = [_soles(character, legs, clip, at) for at in (first, middle, first + step_s)]
    lowest = np.argmin(places[1][..., 2], axis=1)
    before, at, after = (one[np.arange(count), lowest] for one in places)
    speed = (after - before) / step_s if step_s > 0.0 else np.zeros_like(at)
    stands = (np.abs(at[:, 2]) < NEAR) & (np.abs(speed[:, 2]) < FAST_UP)
    stands &= _upright(character, clip, middle)
    if np.any(stands):
        slides = np.median(speed[stands, :2], axis=0)
        stands &= np.linalg.norm(speed[:, :2] - slides, axis=1) < FAST_ALONG
    if np.any(stands):
        stands &= np.abs(at[:, 2] - np.median(at[stands, 2])) < ONE_GROUND
    if np.mean(stands) < MOSTLY:
        return None
    return float(np.median(at[stands, 2]) * character.height_m)


def on_its_soles(character: Character, legs: Sequence[Leg], clip: Clip) -> tuple[Clip, float]:
    """A clip raised or lowered as a whole so that it stands on z = 0, and by how many metres.

    One that does not stand stays as it is.

    Args:
        character: whose clip it is.
        legs: of it, with edges (`fitted_legs`).
        clip: of its skeleton.
    """
    height_m = standing_height_m(character, legs, clip)
    if height_m is None:
        return clip, 0.0
    lift = Motor.from_translation(-height_m * UP)
    return replace(clip, poses=character.skeleton.moved(clip.poses, lift)), -height_m


def _soles(character: Character, legs: Sequence[Leg], clip: Clip, time_s: FloatArray) -> FloatArray:
    """Points of all soles ``(F, P, 3)``, in heights of the figure."""
    skeleton = character.skeleton
    world = skeleton.world(clip.at(time_s).rigid)
    soles = []
    for leg in legs:
        ankle, ball = leg.foot(skeleton)
        soles.append(sole_points(skeleton, (world[:, ankle], world[:, ball]), leg.sole(skeleton)))
    return np.concatenate(soles, axis=1) / character.height_m


def _upright(character: Character, clip: Clip, time_s: FloatArray) -> NDArray[np.bool_]:
    """Whether the figure is on its feet ``(F,)``, by its hips and trunk."""
    skeleton = character.skeleton
    body, rest = body_of(skeleton), skeleton.rest_world.translation_m
    at = skeleton.world(clip.at(time_s).rigid).translation_m
    hips = body["hips"]
    up: NDArray[np.bool_] = at[:, hips, 2] > HIPS * rest[hips, 2]
    top = body.get("neck", body.get("head"))
    if top is not None:
        off = unit(at[:, top] - at[:, hips])[:, 2] - unit(rest[top] - rest[hips])[2]
        up &= np.abs(off) < TRUNK
    return up
