"""Walk, jog and run: one full cycle on the spot, from contacts with the ground and joint angles.

Phase 0 is the left foot's strike in all three, so that they blend by phase; the right leg runs half
a period later. While a foot stands, its contact moves backwards exactly with the ground, at the
gait's speed: first the heel, then the whole sole, then the ball, about which the foot rolls while
the toes stay flat. While it swings, the ankle follows a curve through a few postures of the leg
that joins both contacts in place and velocity. Legs are then bent to their ankles in closed form.

Sources of the postures, of the shares of stance and of the amplitudes of trunk and arms: Perry and
Burnfield, Gait Analysis (2010), chapters 4 to 8, and Winter, The Biomechanics and Motor Control of
Human Gait (1991), for the walk; Novacheck, "The biomechanics of running", Gait and Posture 7 (1998)
for jog and run. Their curves are followed by a few numbers, not digitised.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from docs.making.figure.motions.posing import (
    assembled,
    clamped_curve,
    ease,
    reach,
    relaxed_hand,
    wave,
)
from docs.making.figure.proportions import (
    ANKLE_HEIGHT_M,
    HEEL_BACK_M,
    HIP_DROP_M,
    HIPS_HEIGHT_M,
    LEG_SHARE,
    SHIN_M,
    SIDES,
    THIGH_M,
    TOE_DOWN_M,
    TOE_FORWARD_M,
    TOE_LENGTH_M,
)
from motorcade.animation.clip import Clip
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y, turn_z
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# How softly a swinging foot is lifted clear of the ground.
SOFT_M = 0.006
HEIGHT = 2  # among the curves of a step: ahead, out, height, pitch
Posture = tuple[float, float, float, float]


@dataclass(frozen=True)
class Gait:
    """A way of going of a person 1.75 m tall. Angles are in degrees, as its sources print them.

    Attributes:
        period_s: of one cycle, two steps.
        speed_m_s: of the ground under it.
        stance: share of the cycle that a foot stands.
        frames: samples of the clip.
        strike_ahead_m: ankle ahead of the hips at the strike, once the foot would lie flat.
        aside_m: ankle from the middle.
        toe_out_deg: turn of the feet.
        strike_deg, push_deg: pitch of the foot as it strikes, and as it leaves.
        flat: shares of stance between which the whole sole stands.
        swing: postures of the leg in swing: share of the swing, hip flexed, knee flexed, foot bent
            up against the shank.
        clear_m: height of the sole in the middle of the swing, at least.
        leave_m_s, land_m_s: how fast a foot leaves the ground, and meets it.
        hips_m: their mean height.
        bob_m: half the way up and down, and the phase of its crest, twice a cycle.
        sway_m: half the way to the sides.
        turn_deg, list_deg: of the pelvis, about z and x.
        lean_deg: of the trunk ahead.
        shoulder_deg: mean and half the swing of the arms.
        elbow_deg: the same of the elbows.
        fist: how far the fingers bend; 1 is at ease.
    """

    period_s: float
    speed_m_s: float
    stance: float
    frames: int
    strike_ahead_m: float
    aside_m: float
    toe_out_deg: float
    strike_deg: float
    push_deg: float
    flat: tuple[float, float]
    swing: tuple[Posture, ...]
    clear_m: float
    leave_m_s: float
    land_m_s: float
    hips_m: float
    bob_m: tuple[float, float]
    sway_m: float
    turn_deg: float
    list_deg: float
    lean_deg: float
    shoulder_deg: tuple[float, float]
    elbow_deg: tuple[float, float]
    fist: float


PEOPLE: Mapping[str, Gait] = {
    "walk": Gait(
        period_s=1.10,
        speed_m_s=1.25,
        stance=0.61,
        frames=34,
        strike_ahead_m=0.312,
        aside_m=0.070,
        toe_out_deg=6.0,
        strike_deg=20.0,
        push_deg=58.0,
        flat=(0.17, 0.52),
        swing=((0.30, 10.0, 64.0, 2.0), (0.60, 27.0, 50.0, 6.0), (0.84, 27.0, 20.0, 2.0)),
        clear_m=0.022,
        leave_m_s=0.42,
        land_m_s=0.40,
        hips_m=0.917,
        bob_m=(0.020, 0.30),
        sway_m=0.018,
        turn_deg=6.0,
        list_deg=3.6,
        lean_deg=2.0,
        shoulder_deg=(3.0, 22.0),
        elbow_deg=(22.0, 12.0),
        fist=1.0,
    ),
    "jog": Gait(
        period_s=0.72,
        speed_m_s=2.40,
        stance=0.39,
        frames=31,
        strike_ahead_m=0.245,
        aside_m=0.055,
        toe_out_deg=5.0,
        strike_deg=9.0,
        push_deg=62.0,
        flat=(0.18, 0.48),
        swing=((0.28, 4.0, 76.0, -10.0), (0.55, 32.0, 90.0, 2.0), (0.82, 37.0, 50.0, 4.0)),
        clear_m=0.040,
        leave_m_s=0.50,
        land_m_s=0.70,
        hips_m=0.882,
        bob_m=(0.032, 0.445),
        sway_m=0.012,
        turn_deg=7.0,
        list_deg=3.5,
        lean_deg=6.0,
        shoulder_deg=(-4.0, 24.0),
        elbow_deg=(80.0, 12.0),
        fist=1.7,
    ),
    "run": Gait(
        period_s=0.66,
        speed_m_s=3.60,
        stance=0.31,
        frames=31,
        strike_ahead_m=0.268,
        aside_m=0.045,
        toe_out_deg=4.0,
        strike_deg=5.0,
        push_deg=68.0,
        flat=(0.15, 0.42),
        swing=((0.25, 0.0, 84.0, -18.0), (0.50, 34.0, 108.0, -6.0), (0.80, 47.0, 68.0, 2.0)),
        clear_m=0.050,
        leave_m_s=0.60,
        land_m_s=0.80,
        hips_m=0.872,
        bob_m=(0.036, 0.405),
        sway_m=0.008,
        turn_deg=9.0,
        list_deg=4.0,
        lean_deg=10.0,
        shoulder_deg=(-6.0, 38.0),
        elbow_deg=(92.0, 16.0),
        fist=2.0,
    ),
}


def _shorter(gait: Gait, aside_m: float) -> Gait:
    """The same for the figure's legs and wide shoes: as lively as pendulums of its legs' length."""
    root = math.sqrt(LEG_SHARE)
    return replace(
        gait,
        period_s=root * gait.period_s,
        speed_m_s=root * gait.speed_m_s,
        strike_ahead_m=LEG_SHARE * gait.strike_ahead_m,
        aside_m=aside_m,
        clear_m=gait.clear_m,
        leave_m_s=gait.leave_m_s,
        land_m_s=root * gait.land_m_s,
        hips_m=HIPS_HEIGHT_M - LEG_SHARE * (PEOPLES_HIPS_M - gait.hips_m),
        bob_m=(LEG_SHARE * gait.bob_m[0], gait.bob_m[1]),
        sway_m=gait.sway_m,
        push_deg=0.95 * gait.push_deg,
    )


PEOPLES_HIPS_M = 0.955
GAITS: Mapping[str, Gait] = {
    "walk": _shorter(PEOPLE["walk"], 0.092),
    "jog": _shorter(PEOPLE["jog"], 0.086),
    "run": _shorter(PEOPLE["run"], 0.084),
}


@dataclass(frozen=True)
class FootPath:
    """One foot over the cycle, in the plane of its path.

    Attributes:
        ahead_m: (F,) ankle ahead of the hips.
        out_m: (F,) ankle aside of its line, outwards: a foot that is turned out rolls outwards.
        height_m: (F,) ankle above the ground.
        pitch_rad: (F,) of the foot, toes up positive.
        toes_rad: (F,) bend of the toes against the foot, up positive.
    """

    ahead_m: FloatArray
    out_m: FloatArray
    height_m: FloatArray
    pitch_rad: FloatArray
    toes_rad: FloatArray


def step(gait: Gait, phase: FloatArray) -> FootPath:
    """The foot at phases (F,) in [0, 1], where 0 and 1 are its own strikes."""
    curves = _contact(gait, np.minimum(phase, gait.stance))
    swinging = phase > gait.stance
    u = (phase[swinging] - gait.stance) / (1.0 - gait.stance)
    rows = np.array([_posture(gait, posture) for posture in gait.swing])
    knots = np.array([0.0, *(posture[0] for posture in gait.swing), 1.0])
    ends, small = np.array([gait.stance, 0.0]), 1e-6
    here = np.stack(_contact(gait, ends), axis=1)
    rates = (np.stack(_contact(gait, ends + small), axis=1) - here) / small
    rates[:, HEIGHT] += np.array([gait.leave_m_s, -gait.land_m_s]) * gait.period_s
    rates *= 1.0 - gait.stance
    for column, curve in enumerate(curves):
        values = np.array([here[0, column], *rows[:, column], here[1, column]])
        curve[swinging] = clamped_curve(knots, values, rates[0, column], rates[1, column], u)
    ahead, out, height, pitch = curves
    leaving = gait.stance * np.array([gait.flat[1], 1.12])
    unbending = gait.stance + (1.0 - gait.stance) * np.array([0.15, 0.75])
    bend = ease(phase, *leaving) - ease(phase, *unbending)
    toes = np.deg2rad(gait.push_deg) * bend
    height[swinging] += _lifted(gait, u, height[swinging], pitch[swinging], toes[swinging])
    return FootPath(ahead, out, height, pitch, toes)


def _lifted(
    gait: Gait, u: FloatArray, height: FloatArray, pitch: FloatArray, toes: FloatArray
) -> FloatArray:
    """How much higher a swinging foot must be (N,) for its sole to clear the ground."""
    ball = height + TOE_FORWARD_M * np.sin(pitch) - TOE_DOWN_M * np.cos(pitch)
    under = ANKLE_HEIGHT_M - TOE_DOWN_M
    tip = ball + TOE_LENGTH_M * np.sin(pitch + toes) - under * np.cos(pitch + toes)
    heel = height - HEEL_BACK_M * np.sin(pitch) - ANKLE_HEIGHT_M * np.cos(pitch)
    low = np.minimum(np.minimum(ball - under, tip), heel)
    lacks = gait.clear_m * np.sin(np.pi * u) - low
    smooth = 0.5 * (lacks + np.sqrt(lacks**2 + SOFT_M**2))
    return np.asarray(smooth * ease(u, 0.0, 0.10) * (1.0 - ease(u, 0.85, 1.0)))


def _contact(gait: Gait, phase: FloatArray) -> list[FloatArray]:
    """Ankle (ahead, out, up) and pitch while the heel (toes up) or the ball turns on the ground."""
    flat_from, flat_until = gait.stance * gait.flat[0], gait.stance * gait.flat[1]
    landing = gait.strike_deg * (1.0 - ease(phase, 0.0, flat_from))
    push = gait.push_deg * ease(phase, flat_until, 1.12 * gait.stance)
    pitch = np.deg2rad(landing - push)
    heel = pitch > 0.0
    pivot_x = np.where(heel, -HEEL_BACK_M, TOE_FORWARD_M)
    pivot_z = np.where(heel, -ANKLE_HEIGHT_M, -TOE_DOWN_M)
    cos, sin = np.cos(pitch), np.sin(pitch)
    rolled = pivot_x - (cos * pivot_x - sin * pivot_z)
    height = ANKLE_HEIGHT_M + pivot_z - (sin * pivot_x + cos * pivot_z)
    # on the spot the ground goes back
    ankle_m = gait.strike_ahead_m - gait.speed_m_s * gait.period_s * phase
    turned = math.radians(gait.toe_out_deg)
    return [ankle_m + math.cos(turned) * rolled, math.sin(turned) * rolled, height, pitch]


def _posture(gait: Gait, posture: Posture) -> tuple[float, float, float, float]:
    """Ankle (ahead, out, up) and pitch of the foot of a posture, the hips at their mean height."""
    _, hip, knee, foot = (math.radians(angle) for angle in posture)
    back = knee - hip
    ahead = THIGH_M * math.sin(hip) - SHIN_M * math.sin(back)
    down = THIGH_M * math.cos(hip) + SHIN_M * math.cos(back)
    return ahead, 0.0, gait.hips_m - HIP_DROP_M - down, foot - back


def gait_clip(name: str, skeleton: Skeleton) -> Clip:
    """One of the looped clips of `GAITS`, for a figure of the reference height."""
    gait = GAITS[name]
    phase = np.linspace(0.0, 1.0, gait.frames)
    hips = Motor.from_rotor_translation(_hips_rotor(gait, phase), _hips_m(gait, phase))
    rotors: dict[str, Rotor] = {"hips": hips.rotor} | _trunk(gait, phase)
    for side, sign in SIDES:
        own = phase if sign > 0.0 else np.mod(phase + 0.5, 1.0)
        rotors |= _leg(gait, skeleton, own, hips, side, sign) | _arm(gait, own, side, sign)
    poses = assembled(skeleton, hips.translation_m, rotors, gait.frames)
    return Clip(name, phase * gait.period_s, poses, looped=True)


def _hips_m(gait: Gait, phase: FloatArray) -> FloatArray:
    """Hips: two bobs a cycle, and one sway towards the standing leg."""
    middle = 0.5 * gait.stance
    x = 0.005 * wave(phase, middle - 0.18, 2)
    y = gait.sway_m * wave(phase, middle)
    z = gait.hips_m + gait.bob_m[0] * wave(phase, gait.bob_m[1], 2)
    return np.stack([x, y, z], axis=-1)


def _hips_rotor(gait: Gait, phase: FloatArray) -> Rotor:
    """Hips: turned with the leading leg, dropped on the swinging side, a little forward."""
    turn = turn_z(-math.radians(gait.turn_deg) * wave(phase, 0.98))
    drop = turn_x(math.radians(gait.list_deg) * wave(phase, 0.37 * gait.stance))
    tilt = math.radians(1.5 + 0.35 * gait.lean_deg)
    return turn @ drop @ turn_y(np.full_like(phase, tilt))


def _trunk(gait: Gait, phase: FloatArray) -> dict[str, Rotor]:
    """Spine against the hips, head steady."""
    counter = math.radians(0.7 * gait.turn_deg) * wave(phase, 0.0)
    side = -math.radians(0.36 * gait.list_deg) * wave(phase, 0.37 * gait.stance)
    nod = math.radians(0.9) * wave(phase, gait.bob_m[1] - 0.22, 2)
    lean = math.radians(0.65 * gait.lean_deg) / 3.0
    segment = turn_z(counter) @ turn_x(side) @ turn_y(np.full_like(phase, lean))
    upright = math.radians(0.40 * gait.lean_deg)
    neck = turn_z(-0.55 * counter) @ turn_y(nod - 0.5 * upright - math.radians(0.6))
    head = turn_z(-0.60 * counter) @ turn_x(-0.4 * side) @ turn_y(-nod - upright)
    return {"waist": segment, "spine": segment, "chest": segment, "neck": neck, "head": head}


def _leg(
    gait: Gait, skeleton: Skeleton, own: FloatArray, hips: Motor, side: str, sign: float
) -> dict[str, Rotor]:
    """One leg bent to its step."""
    path = step(gait, own)
    aside = sign * (gait.aside_m + path.out_m)
    ankle = np.stack([path.ahead_m, aside, path.height_m], axis=-1)
    out = np.full_like(own, sign * math.radians(gait.toe_out_deg))
    offset = skeleton.rest[skeleton.index(f"{side}_thigh")].translation_m
    leg = reach(hips, offset, ankle, turn_z(out) @ turn_y(-path.pitch_rad), 0.6 * out)
    return {
        f"{side}_thigh": leg.thigh,
        f"{side}_calf": leg.calf,
        f"{side}_foot": leg.foot,
        f"{side}_toes": turn_y(-path.toes_rad),
    }


def _arm(gait: Gait, own: FloatArray, side: str, sign: float) -> dict[str, Rotor]:
    """One arm: it swings with the other leg, the elbow bending on the way forward."""
    mean, swing = (math.radians(angle) for angle in gait.shoulder_deg)
    mean_elbow, more = (math.radians(angle) for angle in gait.elbow_deg)
    forward = mean - swing * wave(own, 0.02)
    elbow = mean_elbow - more * wave(own, 0.06) + math.radians(2.0) * wave(own, 0.3, 2)
    shrug = math.radians(2.0) * wave(own, 0.50)
    inward = math.radians(7.0) + math.radians(3.0) * wave(own, 0.5) + 0.08 * mean_elbow
    hang = turn_x(sign * np.full_like(own, math.radians(17.0)))
    palm = np.full_like(own, 0.25 + 0.25 * mean_elbow)
    return {
        f"{side}_clavicle": turn_x(-sign * 0.05) @ turn_z(sign * shrug),
        f"{side}_upper_arm": turn_y(-forward) @ hang @ turn_z(-sign * inward),
        f"{side}_forearm": turn_y(-elbow) @ turn_z(-sign * palm),
        f"{side}_hand": turn_x(-sign * np.full_like(own, 0.10)) @ turn_y(0.08 - 0.12 * elbow),
    } | relaxed_hand(side, sign, gait.fist + 0.12 * wave(own, 0.55))
