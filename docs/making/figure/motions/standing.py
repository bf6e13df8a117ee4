"""The figure at ease: it breathes, shifts its weight, looks about; its feet stay where they are.

Every curve is a sum of whole harmonics of one period, so the loop closes in all derivatives. Out
of standing at ease it greets: the right arm rises, waves, and sinks again.

It also turns on the spot by a quarter to its left, in two steps. It starts and ends at ease: its
last pose is its first, turned by 90° about the vertical through the character's origin. Head and
chest lead, the left foot opens, the weight goes over, the right foot follows. A foot that stands
does not move.
"""

from __future__ import annotations

import math

import numpy as np

from docs.making.figure.motions.posing import assembled, ease, reach, relaxed_hand, wave
from docs.making.figure.proportions import ANKLE_HEIGHT_M, HIPS_HEIGHT_M, SIDES
from motorcade.animation.clip import Clip
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y, turn_z
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

PERIOD_S = 7.2
FRAMES = 73
BREATHS = 2
HIPS_M = HIPS_HEIGHT_M - 0.012
# ankle ahead, aside and toes out (m, m, rad): the left leg carries, the right stands open
STANCE = {"left": (-0.006, 0.100, math.radians(9.0)), "right": (0.026, 0.118, math.radians(20.0))}
TURN_S, TURN_FRAMES = 1.3, 40
ANGLE_RAD = 0.5 * math.pi
# shares of the clip in which each foot is in the air, and the hips turn
SWING = {"left": (0.16, 0.46), "right": (0.52, 0.84)}
HIPS = (0.08, 0.88)
LIFT_M, DIP_M, SWAY_M = 0.055, 0.010, 0.026


def idle(skeleton: Skeleton) -> Clip:
    """The looped clip "idle", PERIOD_S long, for a figure of the reference height."""
    phase = np.linspace(0.0, 1.0, FRAMES)
    hips, rotors = standing(skeleton, phase)
    poses = assembled(skeleton, hips.translation_m, rotors, FRAMES)
    return Clip("idle", phase * PERIOD_S, poses, looped=True)


def standing(skeleton: Skeleton, phase: FloatArray) -> tuple[Motor, dict[str, Rotor]]:
    """Hips, Motor (F,), and local rotors by joint name at phases (F,) of standing at ease."""
    hips = hips_at_ease(phase)
    rotors: dict[str, Rotor] = {"hips": hips.rotor} | trunk_at_ease(phase)
    for side, sign in SIDES:
        rotors |= _leg(skeleton, phase, hips, side, sign) | arm_at_ease(phase, side, sign)
    return hips, rotors


def hips_at_ease(phase: FloatArray) -> Motor:
    """Hips, Motor (F,), at phases (F,)."""
    return Motor.from_rotor_translation(_hips_rotor(phase), _hips_m(phase))


def _hips_m(phase: FloatArray) -> FloatArray:
    """Hips over the left leg, swaying."""
    x = 0.003 + 0.004 * wave(phase, 0.15) + 0.001 * wave(phase, 0.4, 3)
    y = 0.016 + 0.011 * wave(phase, 0.55) + 0.003 * wave(phase, 0.1, 2)
    z = HIPS_M - 0.0016 * wave(phase, 0.05) + 0.0012 * wave(phase, 0.02, BREATHS)
    return np.stack([x, y, z], axis=-1)


def _hips_rotor(phase: FloatArray) -> Rotor:
    """Hips raised on the carrying side and turned a little open."""
    turn = turn_z(math.radians(-5.0) + math.radians(1.6) * wave(phase, 0.3))
    drop = turn_x(math.radians(3.2) + math.radians(0.8) * wave(phase, 0.55))
    return turn @ drop @ turn_y(math.radians(1.5) + math.radians(0.5) * wave(phase, 0.7))


def trunk_at_ease(phase: FloatArray) -> dict[str, Rotor]:
    """Spine back over the feet, the chest rising with the breath, the head looking about."""
    breath = wave(phase, 0.12, BREATHS)
    side = -math.radians(1.9) - math.radians(0.4) * wave(phase, 0.55)
    twist = math.radians(1.6) - math.radians(0.7) * wave(phase, 0.36)
    look = math.radians(12.0) * wave(phase, 0.30) + math.radians(6.0) * wave(phase, 0.62, 2)
    tilt = math.radians(2.4) * wave(phase, 0.18)
    nod = math.radians(2.0) + math.radians(2.2) * wave(phase, 0.80) + math.radians(0.5) * breath
    base = turn_z(twist) @ turn_x(side)
    return {
        "waist": base @ turn_y(math.radians(-1.4) - math.radians(0.25) * breath),
        "spine": base @ turn_y(math.radians(0.6) - math.radians(0.55) * breath),
        "chest": base @ turn_y(math.radians(-0.4) - math.radians(1.1) * breath),
        "neck": turn_z(0.4 * look) @ turn_y(0.4 * nod + math.radians(0.9) * breath),
        "head": turn_z(0.6 * look) @ turn_x(tilt) @ turn_y(0.6 * nod + math.radians(0.7) * breath),
    }


def _leg(
    skeleton: Skeleton, phase: FloatArray, hips: Motor, side: str, sign: float
) -> dict[str, Rotor]:
    """One leg with its foot flat on the ground."""
    ahead, aside, out = STANCE[side]
    ankle = np.broadcast_to(np.array([ahead, sign * aside, ANKLE_HEIGHT_M]), (len(phase), 3))
    offset = skeleton.rest[skeleton.index(f"{side}_thigh")].translation_m
    leg = reach(hips, offset, ankle, turn_z(np.full_like(phase, sign * out)))
    return {f"{side}_thigh": leg.thigh, f"{side}_calf": leg.calf, f"{side}_foot": leg.foot}


def arm_at_ease(phase: FloatArray, side: str, sign: float) -> dict[str, Rotor]:
    """One arm hanging at ease, lifted a little by every breath."""
    breath = wave(phase, 0.15, BREATHS)
    later = 0.08 if sign > 0.0 else 0.33
    hang = math.radians(19.0) + math.radians(0.9) * breath + math.radians(0.8) * wave(phase, later)
    swing = math.radians(2.0) + math.radians(1.8) * wave(phase, later + 0.2)
    elbow = math.radians(16.0) + math.radians(2.5) * wave(phase, later + 0.3)
    return {
        f"{side}_clavicle": turn_x(sign * (math.radians(-3.0) + math.radians(1.3) * breath)),
        f"{side}_upper_arm": turn_y(-swing)
        @ turn_x(sign * hang)
        @ turn_z(np.full_like(phase, -sign * math.radians(14.0))),
        f"{side}_forearm": turn_y(-elbow) @ turn_z(np.full_like(phase, -sign * 0.22)),
        f"{side}_hand": turn_x(np.full_like(phase, -sign * 0.08)) @ turn_y(-0.3 * elbow + 0.1),
    } | relaxed_hand(side, sign, 1.0 + 0.10 * wave(phase, later + 0.1))


WAVE_PERIOD_S = 3.6
WAVE_FRAMES = 61
STROKES = 4
RISE, SINK = (0.03, 0.26), (0.70, 0.97)
STROKE_FROM, STROKE_UNTIL = 0.20, 0.76
# how far standing at ease goes on while the arm is up, in its phase
EASE_SHARE = 0.12


def waving(skeleton: Skeleton) -> Clip:
    """The looped clip "wave"; it begins and ends, at rest, in the first pose of "idle"."""
    time = np.linspace(0.0, 1.0, WAVE_FRAMES)
    raised = ease(time, *RISE) - ease(time, *SINK)
    hips, rotors = standing(skeleton, EASE_SHARE * np.sin(np.pi * time) ** 2)
    rotors |= {name: _between(rotors[name], turn, raised) for name, turn in _arm(time).items()}
    rotors["chest"] = rotors["chest"] @ turn_z(0.06 * raised) @ turn_x(0.05 * raised)
    rotors["head"] = rotors["head"] @ turn_z(-0.10 * raised) @ turn_x(0.07 * raised)
    poses = assembled(skeleton, hips.translation_m, rotors, WAVE_FRAMES)
    coefficients = poses.coefficients.copy()
    coefficients[-1] = coefficients[0]
    return Clip("wave", time * WAVE_PERIOD_S, type(poses)(coefficients), looped=True)


def _arm(time: FloatArray) -> dict[str, Rotor]:
    """The raised right arm: upper arm out, forearm up, hand to and fro with the palm ahead."""
    span = STROKE_UNTIL - STROKE_FROM
    share = ease(time, STROKE_FROM, STROKE_FROM + 0.1) - ease(
        time, STROKE_UNTIL - 0.1, STROKE_UNTIL
    )
    swing = share * np.sin(2.0 * np.pi * STROKES * (time - STROKE_FROM) / span)
    later = share * np.sin(2.0 * np.pi * STROKES * (time - STROKE_FROM) / span - 0.8)
    still = np.ones_like(time)
    return {
        "right_clavicle": turn_x(-0.16 * still),
        "right_upper_arm": turn_z(0.30 * still) @ turn_x(-1.12 * still) @ turn_z(-1.35 * still),
        "right_forearm": turn_y(-(1.22 + 0.36 * swing)) @ turn_z(0.15 * still),
        "right_hand": turn_y(-0.22 * later),
    } | relaxed_hand("right", -1.0, 0.35 * still)


def _between(first: Rotor, second: Rotor, share: FloatArray) -> Rotor:
    """Rotors (F,) on the way from one to another."""
    spread = Rotor(np.broadcast_to(first.coefficients, (len(share), 4)))
    return spread.interpolate(Rotor(np.broadcast_to(second.coefficients, (len(share), 4))), share)


def turning(skeleton: Skeleton) -> Clip:
    """The clip "turn": TURN_S long, not looped, 90° to the left."""
    time = np.linspace(0.0, 1.0, TURN_FRAMES)
    still = np.zeros_like(time)
    heading = ANGLE_RAD * ease(time, *HIPS)
    hips = _hips(time, heading)
    rotors: dict[str, Rotor] = {"hips": hips.rotor} | _trunk(time)
    swing = np.sin(math.pi * ease(time, 0.05, 0.95)) ** 2
    for side, sign in SIDES:
        arm = arm_at_ease(still, side, sign)
        arm[f"{side}_upper_arm"] = turn_y(0.16 * sign * swing) @ arm[f"{side}_upper_arm"]
        arm[f"{side}_forearm"] = turn_y(-0.14 * swing) @ arm[f"{side}_forearm"]
        rotors |= arm | _turning_leg(skeleton, time, heading, hips, side, sign)
    return Clip("turn", time * TURN_S, assembled(skeleton, hips.translation_m, rotors, TURN_FRAMES))


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
    late = 0.2 * (end - begin)  # a foot is off the ground before it moves along it
    share = ease(time, begin + late, end - late)
    u = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    start = np.array([ahead, sign * aside, ANKLE_HEIGHT_M])
    angle = ANGLE_RAD * share
    # round the origin, so that the feet keep clear of each other
    ankle = turn_z(angle).apply(np.broadcast_to(start, (len(time), 3))).copy()
    ankle[:, 2] += LIFT_M * 64.0 * (u * (1.0 - u)) ** 3
    return ankle, angle + sign * out, -0.04 * 64.0 * (u * (1.0 - u)) ** 3 * (1.0 - u)


def _turning_leg(
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
