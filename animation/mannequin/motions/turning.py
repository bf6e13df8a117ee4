"""The mannequin turns on the spot by a quarter to its left, in two steps.

It starts and ends at ease: its last pose is its first, turned by 90° about the vertical through the
character's origin. Head and chest lead, the left foot opens, the weight goes over, the right foot
follows. A foot that stands does not move.
"""

from __future__ import annotations

import math

import numpy as np

from motorcade.animation.clip import Clip
from motorcade.animation.mannequin.motions.idle import (
    STANCE,
    arm_at_ease,
    hips_at_ease,
    trunk_at_ease,
)
from motorcade.animation.mannequin.motions.posing import assembled, ease, reach
from motorcade.animation.mannequin.proportions import ANKLE_HEIGHT_M, SIDES
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_y, turn_z
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["turning"]

DURATION_S, FRAMES = 1.5, 91
ANGLE_RAD = 0.5 * math.pi
# shares of the clip in which each foot is in the air, and the hips turn
SWING = {"left": (0.16, 0.46), "right": (0.52, 0.84)}
HIPS = (0.08, 0.88)
LIFT_M, DIP_M, SWAY_M = 0.050, 0.016, 0.035


def turning(skeleton: Skeleton) -> Clip:
    """The clip "turn": DURATION_S long, not looped, 90° to the left."""
    time = np.linspace(0.0, 1.0, FRAMES)
    still = np.zeros_like(time)
    heading = ANGLE_RAD * ease(time, *HIPS)
    hips = _hips(time, heading)
    rotors: dict[str, Rotor] = {"hips": hips.rotor} | _trunk(time)
    swing = np.sin(math.pi * ease(time, 0.05, 0.95)) ** 2
    for side, sign in SIDES:
        arm = arm_at_ease(still, side, sign)
        arm[f"{side}_upper_arm"] = turn_y(0.16 * sign * swing) @ arm[f"{side}_upper_arm"]
        arm[f"{side}_forearm"] = turn_y(-0.14 * swing) @ arm[f"{side}_forearm"]
        rotors |= arm | _leg(skeleton, time, heading, hips, side, sign)
    return Clip("turn", time * DURATION_S, assembled(skeleton, hips.translation_m, rotors, FRAMES))


def _hips(time: FloatArray, heading: FloatArray) -> Motor:
    """Hips turned, over the foot that stands, a little lower on the way."""
    start = hips_at_ease(np.zeros_like(time))
    turned = Motor.from_rotor_translation(turn_z(heading), np.zeros((len(time), 3))) @ start
    over = {side: _bump(time, SWING[side]) for side, _ in SIDES}
    aside = np.zeros((len(time), 3))
    for side, other in (("left", "right"), ("right", "left")):
        foot = _foot(time, other)[0]
        aside += over[side][:, None] * (foot - turned.translation_m)
    aside[:, 2] = -DIP_M * np.sin(math.pi * ease(time, 0.05, 0.95)) ** 2
    reach_m = np.linalg.norm(aside[:, :2], axis=1, keepdims=True)
    aside[:, :2] *= np.minimum(1.0, SWAY_M / np.maximum(reach_m, 1e-9))
    return Motor.from_rotor_translation(turned.rotor, turned.translation_m + aside)


def _trunk(time: FloatArray) -> dict[str, Rotor]:
    """Head and chest ahead of the hips."""
    trunk = trunk_at_ease(np.zeros_like(time))
    lead = ease(time, 0.0, 0.30) - ease(time, 0.42, 0.92)
    for name, share in (("waist", 0.10), ("spine", 0.12), ("chest", 0.14), ("neck", 0.16)):
        trunk[name] = turn_z(share * lead) @ trunk[name]
    trunk["head"] = turn_z(0.26 * lead) @ turn_y(0.06 * lead) @ trunk["head"]
    return trunk


def _bump(time: FloatArray, span: tuple[float, float]) -> FloatArray:
    """0, then 1 in the middle of a span a little wider than the given one, then 0."""
    u = np.clip((time - span[0] + 0.10) / (span[1] - span[0] + 0.16), 0.0, 1.0)
    return np.asarray(np.sin(math.pi * u) ** 2)


def _foot(time: FloatArray, side: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ankle (F, 3), heading (F,) and pitch (F,) of a foot, toes up positive."""
    ahead, aside, out = STANCE[side]
    sign = dict(SIDES)[side]
    begin, end = SWING[side]
    late = 0.12 * (end - begin)  # a foot is off the ground before it moves along it
    share = ease(time, begin + late, end - late)
    u = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    start = np.array([ahead, sign * aside, ANKLE_HEIGHT_M])
    angle = ANGLE_RAD * share
    # round the origin, so that the feet keep clear of each other
    ankle = turn_z(angle).apply(np.broadcast_to(start, (len(time), 3))).copy()
    ankle[:, 2] += LIFT_M * 64.0 * (u * (1.0 - u)) ** 3
    return ankle, angle + sign * out, -0.12 * 64.0 * (u * (1.0 - u)) ** 3 * (1.0 - u)


def _leg(
    skeleton: Skeleton, time: FloatArray, heading: FloatArray, hips: Motor, side: str, sign: float
) -> dict[str, Rotor]:
    """One leg; its knee points between the hips' front and the foot's."""
    ankle, foot_heading, pitch = _foot(time, side)
    offset = skeleton.rest[skeleton.index(f"{side}_thigh")].translation_m
    knee = 0.6 * (foot_heading - heading)
    leg = reach(hips, offset, ankle, turn_z(foot_heading) @ turn_y(-pitch), knee)
    return {
        f"{side}_thigh": leg.thigh,
        f"{side}_calf": leg.calf,
        f"{side}_foot": leg.foot,
        f"{side}_toes": turn_y(0.5 * pitch),
    }
