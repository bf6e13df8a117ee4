"""Hands and fingers of two skeletons laid alike: by knuckles, bones and the palm.

A hand is told by where its middle finger begins and across its knuckles; a finger by its bone and
by the hinge about which it bends, which in a straight finger is taken to lie across the knuckles,
and in a straight thumb to stand on the palm. Without that second direction fingers would point well
and yet be twisted about themselves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motorcade.animation.vectors import axes_along, unit
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

# How much the way in which a finger should bend counts beside how it is bent.
ASSUMED_BEND = 0.05
FINGERS = ("thumb", "index", "middle", "ring", "little")


@dataclass(frozen=True, eq=False)
class Seen:
    """Joints of a skeleton in some poses, by role.

    Fields:
        at_m: ``(F, J, 3)``.
        rotors: ``(F, J)``.
        joints: numbers by role.
    """

    at_m: FloatArray
    rotors: Rotor
    joints: Mapping[str, int]

    def bone(self, start: str, end: str) -> FloatArray:
        """From one joint to another, ``(F, 3)``."""
        made: FloatArray = self.at_m[:, self.joints[end]] - self.at_m[:, self.joints[start]]
        return made

    def inside(self, role: str, vectors: FloatArray) -> FloatArray:
        """Mean ``(3,)`` of vectors ``(F, 3)`` as a joint sees them."""
        seen = self.rotors[:, self.joints[role]].inverse().apply(vectors)
        made: FloatArray = np.mean(seen, axis=0)
        return made


def is_of_hand(role: str) -> bool:
    """Whether a joint is a hand, or of a finger."""
    part = role.partition("_")[2]
    return part == "hand" or part.startswith(FINGERS)


def hand_turn(role: str, target: Seen, source: Seen) -> Rotor | None:
    """The constant turn, in the source's joint frame, of a hand or a finger's joint.

    None where joints that tell it are missing.

    Args:
        role: such as "left_hand" or "right_index_2".
        target: at rest; both know the same roles.
        source: at rest or moving.
    """
    frames = [_hand_frame(role, seen) for seen in (target, source)]
    if frames[0] is None or frames[1] is None:
        return None
    return frames[1] @ frames[0].inverse()


def _hand_frame(role: str, seen: Seen) -> Rotor | None:
    side, _, part = role.partition("_")
    knuckles = {name: f"{side}_{name}_1" for name in FINGERS if f"{side}_{name}_1" in seen.joints}
    last = knuckles.get("ring", knuckles.get("little"))
    hand = f"{side}_hand"
    if last is None or not {"index", "middle"} <= set(knuckles) or hand not in seen.joints:
        return None
    ahead, across = seen.bone(hand, knuckles["middle"]), seen.bone(last, knuckles["index"])
    if part == "hand":
        return axes_along(seen.inside(role, ahead), seen.inside(role, across))
    finger, _, phalanx = part.partition("_")
    line = [f"{side}_{finger}_{number}" for number in (1, 2, 3)]
    line = [name for name in line if name in seen.joints]
    # A tip has no joint that follows: its bone lies in it as the one before does in its own joint.
    first = min(int(phalanx) - 1, len(line) - 2)
    if first < 0:
        return None
    second = _hinge(side, line, seen, ahead, across)
    return axes_along(
        seen.inside(line[first], seen.bone(*line[first : first + 2])), seen.inside(role, second)
    )


def _hinge(
    side: str, line: list[str], seen: Seen, ahead: FloatArray, across: FloatArray
) -> FloatArray:
    """About what a finger bends, ``(F, 3)``: across its bones, told by the hand where straight."""
    thumb = "_thumb_" in line[0]
    by_hand = unit(np.cross(ahead, across) if thumb else across)
    if len(line) < 3:
        return by_hand
    hinge = np.cross(unit(seen.bone(*line[:2])), unit(seen.bone(*line[1:])))
    hinge = hinge if side == "right" and not thumb else -hinge
    # One that is bent the other way, or sideways, does not tell how it would be closed.
    plausible = np.sum(hinge * by_hand, axis=-1, keepdims=True) > 0.0
    made: FloatArray = ASSUMED_BEND * by_hand + np.where(plausible, hinge, 0.0)
    return made
