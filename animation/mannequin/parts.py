"""The turned pieces of the mannequin: profiles in metres, tones, and which joints carry them.

Each part is authored in the rest frame of one joint and swept along one of that frame's
directions. Along the sweep the carrying joint changes at stated stations, over a short smooth
blend, so that a part bends where a neighbour begins instead of cracking.
"""

from dataclasses import dataclass, replace

import numpy as np

from motorcade.animation.mannequin.lofts import Profile, profile
from motorcade.animation.mannequin.proportions import (
    FINGERS,
    FOREARM_M,
    SHIN_M,
    SIDES,
    THIGH_M,
    THUMB_M,
    UPPER_ARM_M,
)

MAPLE, WALNUT, BRASS = "maple", "walnut", "brass"
# sRGB, 0 to 1
TONES: dict[str, tuple[float, float, float]] = {
    MAPLE: (0.880, 0.785, 0.640),
    WALNUT: (0.270, 0.185, 0.140),
    BRASS: (0.790, 0.400, 0.210),
}


@dataclass(frozen=True)
class Part:
    """One closed piece of the body.

    Attributes:
        frame: the joint in whose rest frame the piece is authored.
        sweep: "up" (+z of that frame), "down" (−z) or "forward" (+x).
        shape: the profile along the sweep.
        tone: a key of `TONES`.
        joints: the joints that carry it, in the order along the sweep.
        changes_m: for each pair of neighbours in `joints`: the station where one hands over to
            the next, and half the length of the blend.
        sides: vertices around.
        rings: rings between the rounded ends.
        cap_rings: rings in each rounded end.
        ground: whether the piece is cut flat at the height of the ground.
    """

    frame: str
    sweep: str
    shape: Profile
    tone: str
    joints: tuple[str, ...]
    changes_m: tuple[tuple[float, float], ...] = ()
    sides: int = 14
    rings: int = 7
    cap_rings: int = 3
    ground: bool = False


def ball(frame: str, radius_m: float, carrier: str, at_m: tuple[float, float] = (0.0, 0.0)) -> Part:
    """A walnut ball at a joint, shifted by `at_m` = (along the sweep, along the frame's y)."""
    station, shift = at_m
    edge = 0.999 * radius_m
    shape = profile(
        (station - radius_m, radius_m, radius_m, 0.0, shift),
        (station + radius_m, radius_m, radius_m, 0.0, shift),
        caps_m=(edge, edge),
    )
    return Part(frame, "up", shape, WALNUT, (carrier,), sides=12, rings=1)


def ring(frame: str, sweep: str, at_m: float, half_m: tuple[float, float], shift_m: float) -> Part:
    """A narrow brass band around a limb or the neck."""
    a, b = half_m
    shape = profile(
        (at_m - 0.009, a, b, shift_m), (at_m + 0.009, a, b, shift_m), caps_m=(0.004, 0.004)
    )
    return Part(frame, sweep, shape, BRASS, (frame,), rings=2, cap_rings=2)


def all_parts() -> list[Part]:
    """Every piece of the body."""
    parts = _trunk() + _head()
    for side, sign in SIDES:
        parts += _arm(side, sign) + _hand(side, sign) + _leg(side)
    return parts


def _trunk() -> list[Part]:
    """Pelvis, the flexible waist and the ribcage."""
    pelvis = profile(
        (-0.100, 0.050, 0.075, 0.000),
        (-0.065, 0.085, 0.120, -0.006),
        (-0.010, 0.104, 0.150, -0.010),
        (0.040, 0.096, 0.141, -0.007),
        (0.080, 0.082, 0.121, -0.002),
        (0.102, 0.074, 0.104, 0.000),
        caps_m=(0.035, 0.016),
        exponent=2.25,
    )
    waist = profile(
        (0.030, 0.060, 0.080),
        (0.085, 0.078, 0.106),
        (0.130, 0.082, 0.110),
        (0.180, 0.079, 0.107),
        (0.235, 0.062, 0.085),
        caps_m=(0.02, 0.02),
        exponent=2.15,
    )
    ribs = profile(
        (-0.122, 0.076, 0.098, 0.000),
        (-0.100, 0.084, 0.108, 0.001),
        (-0.050, 0.096, 0.126, 0.004),
        (0.020, 0.106, 0.143, 0.008),
        (0.095, 0.107, 0.154, 0.009),
        (0.150, 0.094, 0.150, 0.002),
        (0.190, 0.075, 0.124, -0.006),
        (0.222, 0.062, 0.085, -0.012),
        (0.262, 0.054, 0.056, -0.013),
        caps_m=(0.020, 0.016),
        exponent=2.25,
    )
    return [
        Part("hips", "up", pelvis, MAPLE, ("hips",), sides=20, rings=11),
        Part(
            "hips",
            "up",
            waist,
            WALNUT,
            ("hips", "spine_lower", "spine_upper", "chest"),
            ((0.07, 0.05), (0.135, 0.06), (0.21, 0.06)),
            sides=20,
        ),
        Part(
            "chest",
            "up",
            ribs,
            MAPLE,
            ("spine_upper", "chest"),
            ((-0.10, 0.07),),
            sides=22,
            rings=14,
        ),
    ]


def _head() -> list[Part]:
    """Neck, its band, and the egg of the head."""
    neck = profile(
        (-0.040, 0.052, 0.054, -0.003),
        (0.010, 0.046, 0.047, 0.000),
        (0.095, 0.044, 0.045, 0.006),
        caps_m=(0.02, 0.02),
    )
    egg = profile(
        (-0.042, 0.036, 0.032, 0.040),
        (-0.012, 0.057, 0.047, 0.030),
        (0.030, 0.081, 0.063, 0.015),
        (0.080, 0.096, 0.073, 0.005),
        (0.120, 0.0985, 0.0755, 0.000),
        (0.190, 0.094, 0.072, -0.003),
        caps_m=(0.024, 0.085),
    )
    return [
        Part("neck", "up", neck, WALNUT, ("chest", "neck", "head"), ((-0.02, 0.03), (0.06, 0.04))),
        ring("neck", "up", 0.022, (0.0490, 0.0500), 0.001),
        Part("head", "up", egg, MAPLE, ("head",), sides=20, rings=9, cap_rings=5),
    ]


def _arm(side: str, sign: float) -> list[Part]:
    """Shoulder to wrist."""
    upper_arm, forearm, hand = f"upper_arm_{side}", f"forearm_{side}", f"hand_{side}"
    upper = profile(
        (-0.054, 0.048, 0.046),
        (-0.005, 0.055, 0.053),
        (0.060, 0.049, 0.047),
        (0.130, 0.044, 0.042),
        (0.210, 0.039, 0.037),
        (UPPER_ARM_M - 0.022, 0.033, 0.033),
        caps_m=(0.048, 0.016),
    )
    fore = profile(
        (0.022, 0.033, 0.034),
        (0.075, 0.042, 0.040),
        (0.150, 0.034, 0.032),
        (FOREARM_M - 0.016, 0.025, 0.022),
        caps_m=(0.016, 0.010),
    )
    return [
        ball(upper_arm, 0.050, f"clavicle_{side}", (0.004, -sign * 0.026)),
        Part(upper_arm, "down", upper, MAPLE, (upper_arm,), rings=9),
        ball(forearm, 0.0345, forearm),
        Part(forearm, "down", fore, MAPLE, (forearm,), rings=9),
        ring(forearm, "down", FOREARM_M - 0.030, (0.0275, 0.0245), 0.0),
        ball(hand, 0.0225, hand),
    ]


def _hand(side: str, sign: float) -> list[Part]:
    """Palm, four fingers and the thumb."""
    hand = f"hand_{side}"
    palm = profile(
        (0.008, 0.020, 0.0165),
        (0.035, 0.034, 0.0175),
        (0.075, 0.0425, 0.0150),
        (0.098, 0.0400, 0.0120),
        caps_m=(0.012, 0.010),
        exponent=2.5,
    )
    parts = [Part(hand, "down", palm, MAPLE, (hand,), sides=12, rings=4)]
    radii = {"index": 0.0092, "middle": 0.0095, "ring": 0.0090, "little": 0.0080}
    for finger, (_, _, bones) in FINGERS.items():
        parts.append(_finger(f"{finger}_{{}}_{side}", hand, bones, radii[finger]))
    parts.append(_finger(f"thumb_{{}}_{side}", hand, THUMB_M, 0.0108))
    return parts


def _finger(pattern: str, hand: str, bones: tuple[float, float, float], radius_m: float) -> Part:
    """One finger as a single tapered piece that bends at its two inner joints."""
    joints = tuple(pattern.format(k) for k in (1, 2, 3))
    first, second = bones[0], bones[0] + bones[1]
    shape = profile(
        (-0.012, 1.05 * radius_m, 1.02 * radius_m),
        (first, 0.98 * radius_m, 0.95 * radius_m),
        (second, 0.88 * radius_m, 0.86 * radius_m),
        (second + bones[2], 0.74 * radius_m, 0.72 * radius_m),
        caps_m=(0.008, 0.7 * radius_m),
    )
    changes = ((-0.004, 0.006), (first, 0.009), (second, 0.008))
    return Part(
        joints[0], "down", shape, MAPLE, (hand, *joints), changes, sides=7, rings=7, cap_rings=2
    )


def _leg(side: str) -> list[Part]:
    """Hip to toes."""
    thigh, calf, foot, toes = (f"{name}_{side}" for name in ("thigh", "calf", "foot", "toes"))
    upper = profile(
        (-0.030, 0.074, 0.066, -0.004),
        (0.060, 0.086, 0.077, -0.002),
        (0.170, 0.078, 0.071, 0.002),
        (0.300, 0.063, 0.058, 0.002),
        (THIGH_M - 0.026, 0.048, 0.047, 0.000),
        caps_m=(0.06, 0.022),
    )
    lower = profile(
        (0.026, 0.046, 0.045, 0.000),
        (0.110, 0.056, 0.052, -0.010),
        (0.210, 0.047, 0.044, -0.009),
        (0.320, 0.034, 0.033, -0.002),
        (SHIN_M - 0.020, 0.030, 0.029, 0.000),
        caps_m=(0.022, 0.012),
    )
    sole = profile(
        (-0.056, 0.036, 0.028, -0.046),
        (-0.020, 0.048, 0.035, -0.036),
        (0.030, 0.046, 0.037, -0.038),
        (0.080, 0.036, 0.043, -0.048),
        (0.128, 0.026, 0.045, -0.056),
        caps_m=(0.022, 0.012),
        exponent=2.3,
    )
    tip = profile(
        (-0.010, 0.024, 0.0445, -0.001),
        (0.030, 0.021, 0.0430, -0.004),
        (0.074, 0.015, 0.0330, -0.008),
        caps_m=(0.010, 0.026),
        exponent=2.3,
    )
    return [
        Part(thigh, "down", upper, MAPLE, ("hips", thigh), ((-0.03, 0.03),), sides=16, rings=10),
        ball(calf, 0.0475, calf),
        Part(calf, "down", lower, MAPLE, (calf,), sides=15, rings=10),
        ring(calf, "down", SHIN_M - 0.032, (0.0325, 0.0315), 0.0),
        ball(foot, 0.0305, foot),
        Part(foot, "forward", sole, MAPLE, (foot,), sides=18, rings=8, ground=True),
        replace(
            Part(toes, "forward", tip, MAPLE, (foot, toes), ((0.0, 0.012),), sides=18, rings=4),
            ground=True,
        ),
    ]


def sweep_axes(sweep: str) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The rotation (3, 3) that takes a loft's own axes to the frame of its part."""
    columns = {
        "up": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        "down": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
        "forward": ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)),
    }[sweep]
    return np.array(columns).T
