"""Joint tree of the mannequin: names, parents and rest offsets for a figure of 1.75 m.

The figure faces +x with z up, its soles at z = 0, its left side towards +y. Every joint's rest
axes are the world's, except below the shoulders: the arm hangs along its own −z and is spread by
`ARM_SPREAD_RAD`, so that in every limb x points forward, −z along the bone, and a turn about y is
the hinge of elbow, knee and ankle.
"""

import math

REFERENCE_HEIGHT_M = 1.75
ARM_SPREAD_RAD = math.radians(38.0)

HIPS_HEIGHT_M = 0.955
THIGH_M = 0.435
SHIN_M = 0.42
ANKLE_HEIGHT_M = 0.075
TOE_FORWARD_M = 0.118
TOE_DOWN_M = 0.055
HEEL_BACK_M = 0.0435
HIP_HALF_WIDTH_M = 0.088
UPPER_ARM_M = 0.285
FOREARM_M = 0.250
PALM_M = 0.088

SIDES: tuple[tuple[str, float], ...] = (("left", 1.0), ("right", -1.0))

# finger: forward place on the palm, distance of its root below the wrist, three bone lengths
FINGERS: dict[str, tuple[float, float, tuple[float, float, float]]] = {
    "index": (0.0300, PALM_M - 0.002, (0.036, 0.023, 0.019)),
    "middle": (0.0100, PALM_M + 0.003, (0.040, 0.026, 0.020)),
    "ring": (-0.0100, PALM_M, (0.036, 0.024, 0.019)),
    "little": (-0.0290, PALM_M - 0.009, (0.028, 0.018, 0.016)),
}
THUMB_ROOT_M = (0.026, 0.030)
THUMB_M = (0.038, 0.028, 0.023)
THUMB_SPREAD_RAD = math.radians(38.0)

Row = tuple[str, str, tuple[float, float, float]]


def joint_rows() -> list[Row]:
    """All joints as (name, parent's name or "", offset from the parent in the parent's axes, m)."""
    rows: list[Row] = [
        ("hips", "", (0.0, 0.0, HIPS_HEIGHT_M)),
        ("spine_lower", "hips", (-0.004, 0.0, 0.075)),
        ("spine_upper", "spine_lower", (0.000, 0.0, 0.105)),
        ("chest", "spine_upper", (0.004, 0.0, 0.105)),
        ("neck", "chest", (-0.012, 0.0, 0.245)),
        ("head", "neck", (0.012, 0.0, 0.075)),
    ]
    for side, sign in SIDES:
        rows += _arm_rows(side, sign) + _leg_rows(side, sign)
    return rows


def _arm_rows(side: str, sign: float) -> list[Row]:
    """Clavicle to fingertips of one side."""
    rows: list[Row] = [
        (f"clavicle_{side}", "chest", (0.004, sign * 0.035, 0.205)),
        (f"upper_arm_{side}", f"clavicle_{side}", (-0.012, sign * 0.142, -0.012)),
        (f"forearm_{side}", f"upper_arm_{side}", (0.0, 0.0, -UPPER_ARM_M)),
        (f"hand_{side}", f"forearm_{side}", (0.0, 0.0, -FOREARM_M)),
    ]
    forward, down = THUMB_ROOT_M
    chain: list[tuple[str, tuple[float, float, float], tuple[float, float, float]]] = [
        ("thumb", (forward, -sign * 0.006, -down), THUMB_M)
    ]
    chain += [(name, (x, 0.0, -z), bones) for name, (x, z, bones) in FINGERS.items()]
    for finger, root, bones in chain:
        parent, offset = f"hand_{side}", root
        for k in range(3):
            name = f"{finger}_{k + 1}_{side}"
            rows.append((name, parent, offset))
            parent, offset = name, (0.0, 0.0, -bones[k])
    return rows


def _leg_rows(side: str, sign: float) -> list[Row]:
    """Thigh to toes of one side."""
    hip = (0.0, sign * HIP_HALF_WIDTH_M, ANKLE_HEIGHT_M + SHIN_M + THIGH_M - HIPS_HEIGHT_M)
    return [
        (f"thigh_{side}", "hips", hip),
        (f"calf_{side}", f"thigh_{side}", (0.0, 0.0, -THIGH_M)),
        (f"foot_{side}", f"calf_{side}", (0.0, 0.0, -SHIN_M)),
        (f"toes_{side}", f"foot_{side}", (TOE_FORWARD_M, 0.0, -TOE_DOWN_M)),
    ]
