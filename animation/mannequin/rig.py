"""The mannequin's skeleton at the reference height."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from motorcade.animation.mannequin.proportions import (
    ARM_SPREAD_RAD,
    FINGERS,
    SIDES,
    THUMB_SPREAD_RAD,
    joint_rows,
)
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y
from motorcade.ga import Motor, Rotor

__all__ = ["mannequin_skeleton"]


@lru_cache(maxsize=1)
def mannequin_skeleton() -> Skeleton:
    """The 52 joints in the rest pose: arms spread, fingers fanned."""
    rows = joint_rows()
    names = tuple(name for name, _, _ in rows)
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in rows])
    turned: dict[str, Rotor] = {}
    for side, sign in SIDES:
        turned[f"{side}_upper_arm"] = turn_x(sign * ARM_SPREAD_RAD)
        turned[f"{side}_thumb_1"] = turn_y(-THUMB_SPREAD_RAD)
        for finger, (_, _, _, fan) in FINGERS.items():
            turned[f"{side}_{finger}_1"] = turn_y(-fan)
    rotors = Rotor.stack([turned.get(name, Rotor.identity()) for name in names])
    offsets = np.array([offset for _, _, offset in rows])
    return Skeleton(names, parents, Motor.from_rotor_translation(rotors, offsets))
