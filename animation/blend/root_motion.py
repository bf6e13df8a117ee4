"""Root motion: the way a clip travels, taken out of its root joint and put into the character.

A clip in place can be blended, looped and retargeted; what it travelled moves the character, along
with its weight. Split off is motion on the ground: along x and y, and the turn about z.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.blend.layers import additive
from motorcade.animation.clip import LOOP_TOLERANCE, Clip
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen


@dataclass(frozen=True, eq=False)
class RootMotion:
    """How far a clip has travelled since its start.

    Args:
        time_s: ``(F,)`` strictly increasing seconds on the clip's clock, F at least 2.
        start_T_now: Motor ``(F,)``, motions on the ground; the first is the identity.
        repeated: whether the way goes on from its end with every cycle, as a loop's does.

    Raises:
        ValueError: times that do not increase, shapes that do not fit.

    >>> import numpy as np
    >>> from motorcade.animation.blend import RootMotion
    >>> from motorcade.ga import Motor
    >>> start_T_now = Motor.from_translation([[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
    >>> walk = RootMotion(np.array([0.0, 1.0]), start_T_now, repeated=True)
    >>> walk.at(2.5).translation_m  # two cycles and a half
    array([3., 0., 0.])
    """

    time_s: FloatArray
    start_T_now: Motor
    repeated: bool

    def __post_init__(self) -> None:
        times = checked_floats(self.time_s, "RootMotion.time_s", ())
        if times.ndim != 1 or times.size < 2 or np.any(np.diff(times) <= 0.0):
            raise ValueError("RootMotion.time_s: expected (F,) strictly increasing, F at least 2")
        if self.start_T_now.shape != times.shape:
            raise ValueError(
                f"RootMotion.start_T_now: expected shape {times.shape}, got "
                f"{self.start_T_now.shape}"
            )
        object.__setattr__(self, "time_s", frozen(times))

    @property
    def speed_m_s(self) -> float:
        """Length of the way over the clip's seconds."""
        steps = np.diff(self.start_T_now.translation_m, axis=0)
        return float(np.linalg.norm(steps, axis=1).sum() / (self.time_s[-1] - self.time_s[0]))

    def at(self, time_s: ArrayLike) -> Motor:
        """``start_T_now`` ``(*)`` at times ``(*)``: whole cycles, then the part of one."""
        wanted = checked_floats(time_s, "RootMotion.at(time_s)", ())
        first, last = self.time_s[0], self.time_s[-1]
        cycles = np.floor((wanted - first) / (last - first)) if self.repeated else 0.0 * wanted
        clock = np.clip(wanted - cycles * (last - first), first, last)
        before = np.clip(np.searchsorted(self.time_s, clock, "right") - 1, 0, len(self.time_s) - 2)
        fraction = (clock - self.time_s[before]) / np.diff(self.time_s)[before]
        way = self.start_T_now
        within = way[before].interpolate(way[before + 1], fraction)
        return Motor.exp(cycles[..., None] * way[-1].log()) @ within


def split_root_motion(
    clip: Clip, skeleton: Skeleton, joint: str | None = None
) -> tuple[Clip, RootMotion]:
    """A clip without its way over the ground, and that way.

    The heading is the joint's turn about z since the clip's start (swing-twist), so that leaning
    stays in the clip. A clip whose ends are alike but for the way becomes a loop.

    Args:
        clip: of the skeleton; its poses are rigid.
        skeleton: with the joint.
        joint: whose motion over the ground is the way; by default the first root.

    Raises:
        ValueError: no such joint, one that is no root, or a clip of a single pose.

    >>> import numpy as np
    >>> from motorcade.animation import Clip, Skeleton
    >>> from motorcade.animation.blend import split_root_motion
    >>> from motorcade.ga import Motor
    >>> one = Skeleton(("root",), np.array([-1]), Motor.identity((1,)))
    >>> parent_T_joint = Motor.from_translation([[[0, 0, 1.0]], [[2.0, 0, 1.0]]])
    >>> ahead = Clip("walk", np.array([0.0, 1.0]), parent_T_joint)
    >>> in_place, way = split_root_motion(ahead, one)
    >>> in_place.at(1.0).translation_m + 0.0, way.speed_m_s
    (array([[0., 0., 1.]]), 2.0)
    """
    number = skeleton.index(joint) if joint else skeleton.root
    if skeleton.parents[number] >= 0 or len(clip.time_s) < 2:
        raise ValueError(
            f"split_root_motion: expected a root joint and a clip of two poses or more, got joint "
            f"'{skeleton.names[number]}' and {len(clip.time_s)} poses"
        )
    root = clip.poses.rigid[:, number]
    heading = np.unwrap(heading_of(root @ root[0].inverse()))
    rotor, at = turn_z(heading), root.translation_m * [1.0, 1.0, 0.0]
    way = Motor.from_rotor_translation(rotor, at - rotor.apply(at[0]))
    inside = without_way(clip, skeleton, way)
    return inside, RootMotion(clip.time_s, way, inside.looped)


def heading_of(pose: Motor) -> FloatArray:
    """Turns ``(*)`` about z, in radians, of poses ``(*)``; leaning is left aside (swing-twist)."""
    w, _, _, e12 = np.moveaxis(pose.rotor.coefficients, -1, 0)
    return np.asarray(-2.0 * np.arctan2(e12, w))


def without_way(clip: Clip, skeleton: Skeleton, way: Motor) -> Clip:
    """A clip with motions ``(F,)`` of the whole figure taken back; a loop if its ends are alike."""
    inside = skeleton.moved(clip.poses, way.inverse())
    looped = bool(np.max(np.abs(additive(inside[-1], inside[0]).as_twist())) <= LOOP_TOLERANCE)
    return replace(clip, poses=inside, looped=looped)
