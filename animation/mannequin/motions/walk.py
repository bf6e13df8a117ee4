"""The mannequin's walk: one full cycle in place, from closed-form curves of the phase.

Phase 0 is the left heel strike; the right leg runs half a period later. The ground moves backwards
at `SPEED_M_S`, and the contact of a standing foot moves exactly with it: first the heel, then the
whole sole, then the ball, about which the foot rolls while the toes stay flat. Between, the ankle
follows a blend of the path it leaves and the path it meets, so its velocity never jumps.
Amplitudes follow the textbook picture of level walking (Perry and Burnfield, Gait Analysis, 2010).
"""

import math
from dataclasses import dataclass

import numpy as np

from motorcade.animation.clip import Clip
from motorcade.animation.mannequin.motions.posing import (
    assembled,
    ease,
    reach,
    relaxed_hand,
    turn_x,
    turn_y,
    turn_z,
    wave,
)
from motorcade.animation.mannequin.proportions import (
    ANKLE_HEIGHT_M,
    HEEL_BACK_M,
    SIDES,
    TOE_DOWN_M,
    TOE_FORWARD_M,
)
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import FloatArray, Motor, Rotor

PERIOD_S = 1.10
SPEED_M_S = 1.12
FRAMES = 57
STANCE = 0.60
STRIKE_RAD, PUSH_RAD = math.radians(19.0), math.radians(46.0)
FLAT_FROM, FLAT_UNTIL, PUSH_UNTIL = 0.11, 0.33, 0.66
TOE_OUT_RAD = math.radians(6.0)
FOOT_ASIDE_M = 0.070
STRIKE_AHEAD_M = 0.312
CLEARANCE_M = 0.045
HIPS_M = (0.0, 0.0, 0.918)


@dataclass(frozen=True)
class Step:
    """One foot over the cycle, in the plane of its path.

    Attributes:
        ahead_m: (F,) ankle ahead of the hips.
        height_m: (F,) ankle above the ground.
        pitch_rad: (F,) of the foot, toes up positive.
        toes_rad: (F,) bend of the toes against the foot, up positive.
    """

    ahead_m: FloatArray
    height_m: FloatArray
    pitch_rad: FloatArray
    toes_rad: FloatArray


def step(phase: FloatArray) -> Step:
    """The foot at phases (F,) in [0, 1), where 0 is its own heel strike."""
    landing = STRIKE_RAD * (1.0 - ease(phase, 0.0, FLAT_FROM))
    push = -PUSH_RAD * ease(phase, FLAT_UNTIL, PUSH_UNTIL)
    recover = (PUSH_RAD + STRIKE_RAD) * ease(phase, STANCE + 0.02, 0.98)
    pitch = landing + push + recover
    bend = ease(phase, FLAT_UNTIL, PUSH_UNTIL) - ease(phase, STANCE, STANCE + 0.20)
    leave_x, leave_z = _contact(phase, pitch)
    meet_x, meet_z = _contact(phase - 1.0, np.full_like(phase, STRIKE_RAD))
    u = np.clip((phase - STANCE) / (1.0 - STANCE), 0.0, 1.0)
    share = u * u * (3.0 - 2.0 * u)
    ahead = leave_x + (meet_x - leave_x) * share
    # one early hump, level at both ends, that lifts the toes before they swing through
    lift = CLEARANCE_M * 28.935 * u**2 * (1.0 - u) ** 3
    height = leave_z + (meet_z - leave_z) * share + lift
    return Step(ahead, height, pitch, PUSH_RAD * bend)


def _contact(phase: FloatArray, pitch: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ankle (ahead, up) while the heel (toes up) or the ball (toes down) turns on the ground."""
    moved = STRIKE_AHEAD_M - SPEED_M_S * PERIOD_S * phase
    heel = pitch > 0.0
    pivot_x = np.where(heel, -HEEL_BACK_M, TOE_FORWARD_M)
    pivot_z = np.where(heel, -ANKLE_HEIGHT_M, -TOE_DOWN_M)
    cos, sin = np.cos(pitch), np.sin(pitch)
    ahead = moved + pivot_x - (cos * pivot_x - sin * pivot_z)
    height = ANKLE_HEIGHT_M + pivot_z - (sin * pivot_x + cos * pivot_z)
    return ahead, height


def walk(skeleton: Skeleton) -> Clip:
    """The looped clip "walk", PERIOD_S long, for a figure of the reference height."""
    phase = np.linspace(0.0, 1.0, FRAMES)
    hips = Motor.from_rotor_translation(_hips_rotor(phase), _hips_m(phase))
    rotors: dict[str, Rotor] = {"hips": hips.rotor} | _trunk(phase)
    for side, sign in SIDES:
        rotors |= _leg(skeleton, phase, hips, side, sign) | _arm(phase, side, sign)
    poses = assembled(skeleton, hips.translation_m, rotors, FRAMES)
    return Clip("walk", phase * PERIOD_S, poses, looped=True)


def _hips_m(phase: FloatArray) -> FloatArray:
    """Hips: two bobs a cycle, highest over the standing leg, and one sway towards it."""
    x = HIPS_M[0] + 0.008 * wave(phase, 0.12, 2)
    y = HIPS_M[1] + 0.018 * wave(phase, 0.30)
    z = HIPS_M[2] + 0.020 * wave(phase, 0.30, 2)
    return np.stack([x, y, z], axis=-1)


def _hips_rotor(phase: FloatArray) -> Rotor:
    """Hips: turned with the leading leg, dropped on the swinging side, a little forward."""
    turn = turn_z(-math.radians(6.0) * wave(phase, 0.98))
    drop = turn_x(math.radians(3.6) * wave(phase, 0.22))
    return turn @ drop @ turn_y(np.full_like(phase, math.radians(2.0)))


def _trunk(phase: FloatArray) -> dict[str, Rotor]:
    """Spine against the hips, head steady."""
    counter = math.radians(4.2) * wave(phase, 0.0)
    side = -math.radians(1.3) * wave(phase, 0.22)
    nod = math.radians(0.9) * wave(phase, 0.08, 2)
    segment = turn_z(counter) @ turn_x(side) @ turn_y(np.full_like(phase, math.radians(0.4)))
    neck = turn_z(-0.55 * counter) @ turn_y(nod - math.radians(1.0))
    head = turn_z(-0.60 * counter) @ turn_x(-0.4 * side) @ turn_y(-nod - math.radians(1.5))
    return {
        "waist": segment,
        "spine": segment,
        "chest": segment,
        "neck": neck,
        "head": head,
    }


def _leg(
    skeleton: Skeleton, phase: FloatArray, hips: Motor, side: str, sign: float
) -> dict[str, Rotor]:
    """One leg by inverse kinematics from its step."""
    own = np.mod(phase if sign > 0.0 else phase + 0.5, 1.0)
    path = step(own)
    ankle = np.stack(
        [path.ahead_m, np.full_like(phase, sign * FOOT_ASIDE_M), path.height_m], axis=-1
    )
    out = sign * TOE_OUT_RAD
    offset = skeleton.rest[skeleton.index(f"{side}_thigh")].translation_m
    foot = turn_z(np.full_like(phase, out)) @ turn_y(-path.pitch_rad)
    leg = reach(hips, offset, ankle, foot)
    return {
        f"{side}_thigh": leg.thigh,
        f"{side}_calf": leg.calf,
        f"{side}_foot": leg.foot,
        f"{side}_toes": turn_y(-path.toes_rad),
    }


def _arm(phase: FloatArray, side: str, sign: float) -> dict[str, Rotor]:
    """One arm: it swings with the other leg, the elbow bending on the way forward."""
    own = phase if sign > 0.0 else phase + 0.5
    forward = math.radians(3.0) - math.radians(21.0) * wave(own, 0.02)
    elbow = math.radians(21.0) - math.radians(12.0) * wave(own, 0.06)
    elbow += math.radians(2.0) * wave(own, 0.3, 2)
    shrug = math.radians(2.0) * wave(own, 0.50)
    inward = math.radians(7.0) + math.radians(3.0) * wave(own, 0.5)
    hang = turn_x(sign * np.full_like(phase, math.radians(9.5)))
    return {
        f"{side}_clavicle": turn_z(sign * shrug),
        f"{side}_upper_arm": turn_y(-forward) @ hang @ turn_z(-sign * inward),
        f"{side}_forearm": turn_y(-elbow) @ turn_z(-sign * np.full_like(phase, 0.25)),
        f"{side}_hand": turn_x(-sign * np.full_like(phase, 0.10)) @ turn_y(-0.25 * elbow + 0.08),
    } | relaxed_hand(side, sign, 1.0 + 0.12 * wave(own, 0.55))
