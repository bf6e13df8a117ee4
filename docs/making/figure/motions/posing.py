"""Tools to write the figure's clips: turns about single axes, eased curves, legs that reach.

Curves are functions of the phase, 0 to 1 over one period, evaluated on whole arrays (F,) at once.
Limb frames have x forward, y to the left, −z along the bone: a positive turn about y swings a
hanging limb backwards and bends a knee; a positive turn about x lifts it to the left.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from docs.making.figure.proportions import FINGERS, SHIN_M, THIGH_M
from motorcade.animation.easing import smootherstep
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_x, turn_y, turn_z
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# How far fingers stay fanned where a hand is at ease; 1 as in the rest pose.
AT_EASE = 0.35


def wave(phase: FloatArray, peak: float, cycles: int = 1) -> FloatArray:
    """Cosine with its crest at phase `peak`, `cycles` times a period."""
    return np.asarray(np.cos(2.0 * np.pi * cycles * (phase - peak)))


def ease(phase: FloatArray, start: float, end: float) -> FloatArray:
    """0 before `start`, 1 after `end`, with two continuous derivatives between."""
    return smootherstep((phase - start) / (end - start))


def clamped_curve(
    knots: FloatArray, values: FloatArray, first_rate: float, last_rate: float, at: FloatArray
) -> FloatArray:
    """The cubic spline through values (K,) at rising knots (K,) with given slopes at its ends."""
    step, rise = np.diff(knots), np.diff(values) / np.diff(knots)
    system, wanted = np.eye(len(knots)), np.empty(len(knots))
    wanted[0], wanted[-1] = first_rate, last_rate
    for k in range(1, len(knots) - 1):
        before, after = step[k - 1], step[k]
        system[k, k - 1 : k + 2] = after, 2.0 * (before + after), before
        wanted[k] = 3.0 * (after * rise[k - 1] + before * rise[k])
    slope = np.linalg.solve(system, wanted)
    piece = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(step) - 1)
    u, after = (at - knots[piece]) / step[piece], piece + 1
    hold = values[piece] * (1 + 2 * u) * (1 - u) ** 2 + values[after] * (3 - 2 * u) * u**2
    bend = slope[piece] * u * (1 - u) ** 2 - slope[after] * u**2 * (1 - u)
    return np.asarray(hold + step[piece] * bend)


@dataclass(frozen=True)
class LegRotors:
    """Local rotors (F,) of one leg that put its ankle and foot where they were asked."""

    thigh: Rotor
    calf: Rotor
    foot: Rotor


def reach(
    world_T_hips: Motor,
    hip_offset_m: FloatArray,
    ankle_m: FloatArray,
    world_R_foot: Rotor,
    knee_out_rad: ArrayLike = 0.0,
) -> LegRotors:
    """Two-bone inverse kinematics of a leg in closed form, the knee a pure hinge.

    Args:
        world_T_hips: Motor (F,) of the hips.
        hip_offset_m: (3,) hip joint in the frame of the hips.
        ankle_m: (F, 3) where the ankle shall be.
        world_R_foot: Rotor (F,) of the foot.
        knee_out_rad: (*) where the knee points, from the front of the hips towards the left.

    Returns:
        The local rotors of thigh, calf and foot.

    Raises:
        ValueError: an ankle farther from the hip than the leg is long.
    """
    turned = turn_z(np.broadcast_to(np.asarray(knee_out_rad, dtype=np.float64), ankle_m.shape[:-1]))
    line = turned.inverse().apply(world_T_hips.inverse().apply(ankle_m) - hip_offset_m)
    distance = np.linalg.norm(line, axis=-1)
    longest = THIGH_M + SHIN_M
    if distance.max() > longest:
        raise ValueError(
            f"reach(ankle_m): expected ankles within {longest:.4g} m of the hip, got "
            f"{distance.max():.4g} m"
        )
    knee = np.pi - np.arccos(_cosine(THIGH_M, SHIN_M, distance))
    lead = np.arccos(_cosine(THIGH_M, distance, np.asarray(SHIN_M)))
    aside = np.arctan2(line[..., 1], -line[..., 2])
    back = np.arctan2(-line[..., 0], np.hypot(line[..., 1], line[..., 2]))
    thigh = turned @ turn_x(aside) @ turn_y(back - lead)
    calf = turn_y(knee)
    foot = (world_T_hips.rotor @ thigh @ calf).inverse() @ world_R_foot
    return LegRotors(thigh, calf, foot)


def _cosine(a: ArrayLike, b: ArrayLike, opposite: ArrayLike) -> FloatArray:
    """Cosine of a triangle's angle between sides a and b."""
    a, b, opposite = np.asarray(a), np.asarray(b), np.asarray(opposite)
    return np.asarray((a**2 + b**2 - opposite**2) / (2.0 * a * b))


def assembled(
    skeleton: Skeleton, hips_m: FloatArray, rotors: Mapping[str, Rotor], frames: int
) -> Motor:
    """Local poses (F, J): given rotors at the named joints, rest rotors at the others.

    Args:
        skeleton: of the figure.
        hips_m: (F, 3) where the hips are.
        rotors: Rotor (F,) by joint name; each replaces the rest rotor.
        frames: F.

    Returns:
        Motor (F, J); joints keep the offsets of the rest pose.
    """
    every: list[Motor] = []
    for joint, name in enumerate(skeleton.names):
        rest = skeleton.rest[joint]
        rotor = rotors.get(name, rest.rotor)
        offset = hips_m if name == "hips" else rest.translation_m
        spread = np.broadcast_to(rotor.coefficients, (frames, 4))
        every.append(
            Motor.from_rotor_translation(Rotor(spread), np.broadcast_to(offset, (frames, 3)))
        )
    return Motor(np.stack([motor.coefficients for motor in every], axis=1))


def relaxed_hand(side: str, sign: float, curl: ArrayLike = 1.0) -> dict[str, Rotor]:
    """Finger rotors of a hand at ease, more bent from the index to the little finger.

    Args:
        side: "left" or "right".
        sign: +1 for left, −1 for right.
        curl: how much the fingers bend, (*); 1 is at ease.

    Returns:
        Rotors by joint name, with the batch shape of `curl`.
    """
    amount = np.asarray(curl, dtype=np.float64)
    bends = {"index": 0.62, "middle": 0.76, "little": 0.88}
    rotors: dict[str, Rotor] = {}
    for finger, bend in bends.items():
        for k, share in ((1, 0.42), (2, 0.62), (3, 0.40)):
            rotors[f"{side}_{finger}_{k}"] = turn_x(-sign * bend * share * amount)
        fan = turn_y(-AT_EASE * FINGERS[finger][3])
        rotors[f"{side}_{finger}_1"] = fan @ rotors[f"{side}_{finger}_1"]
    rotors[f"{side}_thumb_2"] = turn_x(-sign * 0.15 * amount)
    rotors[f"{side}_thumb_3"] = turn_x(-sign * 0.22 * amount)
    return rotors
