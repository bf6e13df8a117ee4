"""The figure's proportions and its skeleton, at the reference height."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y
from motorcade.ga import Motor, Rotor

REFERENCE_HEIGHT_M = 1.75
ARM_SPREAD_RAD = math.radians(40.0)

HIPS_HEIGHT_M = 0.690
THIGH_M = 0.270
SHIN_M = 0.270
ANKLE_HEIGHT_M = 0.105
HIP_DROP_M = HIPS_HEIGHT_M - ANKLE_HEIGHT_M - SHIN_M - THIGH_M
TOE_FORWARD_M = 0.105
TOE_DOWN_M = 0.076
TOE_LENGTH_M = 0.086
HEEL_BACK_M = 0.083
HIP_HALF_WIDTH_M = 0.104
UPPER_ARM_M = 0.205
FOREARM_M = 0.185
PALM_M = 0.090

LEG_SHARE = (THIGH_M + SHIN_M) / 0.855
"""Legs as a share of those of the people whose gaits were measured: lengths of a step go with it,
times and speeds with its root, as pendulums do (Alexander 1976)."""

SIDES: tuple[tuple[str, float], ...] = (("left", 1.0), ("right", -1.0))

# finger: forward place on the palm, distance of its root below the wrist, three bone lengths, fan
FINGERS: dict[str, tuple[float, float, tuple[float, float, float], float]] = {
    "index": (0.0410, PALM_M - 0.006, (0.036, 0.028, 0.026), math.radians(12.0)),
    "middle": (0.0000, PALM_M + 0.000, (0.040, 0.030, 0.026), math.radians(0.0)),
    "little": (-0.0405, PALM_M - 0.012, (0.034, 0.026, 0.024), math.radians(-13.0)),
}
THUMB_ROOT_M = (0.026, 0.020)
THUMB_M = (0.044, 0.033, 0.028)
THUMB_SPREAD_RAD = math.radians(48.0)

Row = tuple[str, str, tuple[float, float, float]]


def joint_rows() -> list[Row]:
    """All joints as (name, parent's name or "", offset from the parent in the parent's axes, m)."""
    rows: list[Row] = [
        ("hips", "", (0.0, 0.0, HIPS_HEIGHT_M)),
        ("waist", "hips", (-0.004, 0.0, 0.075)),
        ("spine", "waist", (0.000, 0.0, 0.090)),
        ("chest", "spine", (0.002, 0.0, 0.100)),
        ("neck", "chest", (-0.008, 0.0, 0.255)),
        ("head", "neck", (0.006, 0.0, 0.060)),
    ]
    for side, sign in SIDES:
        rows += _arm_rows(side, sign) + _leg_rows(side, sign)
    return rows


def _arm_rows(side: str, sign: float) -> list[Row]:
    """Clavicle to fingertips of one side."""
    rows: list[Row] = [
        (f"{side}_clavicle", "chest", (0.002, sign * 0.040, 0.205)),
        (f"{side}_upper_arm", f"{side}_clavicle", (-0.010, sign * 0.118, -0.020)),
        (f"{side}_forearm", f"{side}_upper_arm", (0.0, 0.0, -UPPER_ARM_M)),
        (f"{side}_hand", f"{side}_forearm", (0.0, 0.0, -FOREARM_M)),
    ]
    forward, down = THUMB_ROOT_M
    chain: list[tuple[str, tuple[float, float, float], tuple[float, float, float]]] = [
        ("thumb", (forward, -sign * 0.006, -down), THUMB_M)
    ]
    chain += [(name, (x, 0.0, -z), bones) for name, (x, z, bones, _) in FINGERS.items()]
    for finger, root, bones in chain:
        parent, offset = f"{side}_hand", root
        for k in range(3):
            name = f"{side}_{finger}_{k + 1}"
            rows.append((name, parent, offset))
            parent, offset = name, (0.0, 0.0, -bones[k])
    return rows


def _leg_rows(side: str, sign: float) -> list[Row]:
    """Thigh to toes of one side."""
    hip = (0.0, sign * HIP_HALF_WIDTH_M, ANKLE_HEIGHT_M + SHIN_M + THIGH_M - HIPS_HEIGHT_M)
    return [
        (f"{side}_thigh", "hips", hip),
        (f"{side}_calf", f"{side}_thigh", (0.0, 0.0, -THIGH_M)),
        (f"{side}_foot", f"{side}_calf", (0.0, 0.0, -SHIN_M)),
        (f"{side}_toes", f"{side}_foot", (TOE_FORWARD_M, 0.0, -TOE_DOWN_M)),
    ]


@lru_cache(maxsize=1)
def figure_skeleton() -> Skeleton:
    """The 46 joints in the rest pose: arms spread, fingers fanned."""
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
