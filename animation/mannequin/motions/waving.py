"""The mannequin's greeting: out of standing at ease the right arm rises, waves, and sinks again."""

from __future__ import annotations

import numpy as np

from motorcade.animation.clip import Clip
from motorcade.animation.mannequin.motions.idle import standing
from motorcade.animation.mannequin.motions.posing import assembled, ease, relaxed_hand
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y, turn_z
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["waving"]

PERIOD_S = 3.6
FRAMES = 109
STROKES = 4
RISE, SINK = (0.03, 0.26), (0.70, 0.97)
STROKE_FROM, STROKE_UNTIL = 0.20, 0.76
# how far standing at ease goes on while the arm is up, in its phase
EASE_SHARE = 0.12


def waving(skeleton: Skeleton) -> Clip:
    """The looped clip "wave"; it begins and ends, at rest, in the first pose of "idle"."""
    time = np.linspace(0.0, 1.0, FRAMES)
    raised = ease(time, *RISE) - ease(time, *SINK)
    hips, rotors = standing(skeleton, EASE_SHARE * np.sin(np.pi * time) ** 2)
    rotors |= {name: _between(rotors[name], turn, raised) for name, turn in _arm(time).items()}
    rotors["chest"] = rotors["chest"] @ turn_z(0.06 * raised) @ turn_x(0.05 * raised)
    rotors["head"] = rotors["head"] @ turn_z(-0.10 * raised) @ turn_x(0.07 * raised)
    poses = assembled(skeleton, hips.translation_m, rotors, FRAMES)
    coefficients = poses.coefficients.copy()
    coefficients[-1] = coefficients[0]
    return Clip("wave", time * PERIOD_S, type(poses)(coefficients), looped=True)


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
        "right_upper_arm": turn_z(0.50 * still) @ turn_x(-1.20 * still) @ turn_z(-1.35 * still),
        "right_forearm": turn_y(-(1.85 + 0.34 * swing)) @ turn_z(0.15 * still),
        "right_hand": turn_y(-0.22 * later),
    } | relaxed_hand("right", -1.0, 0.35 * still)


def _between(first: Rotor, second: Rotor, share: FloatArray) -> Rotor:
    """Rotors (F,) on the way from one to another."""
    spread = Rotor(np.broadcast_to(first.coefficients, (len(share), 4)))
    return spread.interpolate(Rotor(np.broadcast_to(second.coefficients, (len(share), 4))), share)
