"""Which way is up, which way a figure faces, and how long a unit is.

Formats fix some of this and leave the rest to habit. Toes tell the facing of a figure, head and
feet tell its up, its height tells the unit; what is told so, or merely assumed, becomes a notice.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.rig.joints import Joints
from motorcade.animation.formats.rig.values import Rig
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

TOES = re.compile(r"toe|ball|foot.?thumb", re.IGNORECASE)
FEET = re.compile(r"foot|ankle", re.IGNORECASE)
HEAD = re.compile(r"head|neck", re.IGNORECASE)
CONTROLS = re.compile(r"ik\b|\bik|control|roll", re.IGNORECASE)

UNITS_M = {
    "metre": 1.0,
    "centimetre": 0.01,
    "inch": 0.0254,
    "CMU's 0.0564 m": 0.0254 / 0.45,
    "decimetre": 0.1,
}
USUAL_HEIGHT_M = 1.7
PLAUSIBLE_M = (0.05, 20.0)
# Toes that point this far from an axis of the file do not tell which one was meant.
CLEAR_COSINE = 0.8


@dataclass(frozen=True, eq=False)
class Axes:
    """How the file's frame lies in that of characters.

    Args:
        turn: Rotor from the file's frame to z up, facing +x.
        notices: what was assumed.
    """

    turn: Rotor
    notices: tuple[str, ...]


def axes_of(rig: Rig, joints: Joints, places: FloatArray) -> Axes:
    """Find the turn from the file's axes to those of characters.

    Args:
        rig: says what the format fixes.
        joints: the joints.
        places: (J, 3) rest positions of the joints in the file's frame.
    """
    notices = []
    if rig.up is not None:
        up = np.array(rig.up)
    else:
        up, by = _up(joints, places)
        notices.append(f"the file does not say which way is up: {_axis_name(up)} by {by}")
    usual = _usual_forward(up) if rig.forward is None else np.array(rig.forward)
    seen = _facing(joints, places, up)
    if seen is None:
        notices.append(f"no toes tell the facing: assumed {_axis_name(usual)}")
        forward = usual
    else:
        forward = seen
        if rig.forward is not None and seen @ usual < 0.9:
            notices.append(
                f"its toes point to {_axis_name(seen)} where the format says "
                f"{_axis_name(usual)}: turned by the toes"
            )
    rows = np.stack([forward, np.cross(up, forward), up])
    return Axes(Rotor.from_matrix(rows), tuple(notices))


def guessed_unit_m(height: float) -> tuple[float, str]:
    """The unit that brings a height nearest to that of a grown person, and a notice."""
    ratios = {
        name: abs(np.log(max(height, 1e-9) * unit / USUAL_HEIGHT_M))
        for name, unit in UNITS_M.items()
    }
    name = min(ratios, key=lambda unit: float(ratios[unit]))
    made = height * UNITS_M[name]
    return UNITS_M[name], (
        f"its unit is not known: taken as {name}, which makes it {made:.2f} m large"
    )


def is_plausible(height_m: float) -> bool:
    """Whether a figure may well be that tall."""
    return PLAUSIBLE_M[0] <= height_m <= PLAUSIBLE_M[1]


def _up(joints: Joints, places: FloatArray) -> tuple[FloatArray, str]:
    """The axis from the feet to the head, or the longest one, or +y; and how it was told."""
    head = [place for name, place in zip(joints.names, places, strict=True) if HEAD.search(name)]
    feet = [
        place
        for name, place in zip(joints.names, places, strict=True)
        if (FEET.search(name) or TOES.search(name))
    ]
    if head and feet:
        return _nearest_axis(np.mean(head, axis=0) - np.mean(feet, axis=0)), "head and feet"
    return np.array([0.0, 1.0, 0.0]), "habit"


def _facing(joints: Joints, places: FloatArray, up: FloatArray) -> FloatArray | None:
    """The axis along which the toes point, or None where they do not tell."""
    steps = []
    for joint, name in enumerate(joints.names):
        parent = int(joints.parents[joint])
        if parent < 0 or not TOES.search(name) or not FEET.search(joints.names[parent]):
            continue
        if CONTROLS.search(name) or CONTROLS.search(joints.names[parent]):
            continue
        step = places[joint] - places[parent]
        level = step - (step @ up) * up
        length = float(np.linalg.norm(level))
        if length > 1e-9:
            steps.append(level / length)
    if not steps:
        return None
    mean = np.mean(steps, axis=0)
    axis = _nearest_axis(mean)
    return axis if float(mean @ axis) > CLEAR_COSINE else None


def _usual_forward(up: FloatArray) -> FloatArray:
    """Where figures face by habit: −y where z is up, else +z, else +y."""
    if abs(up[2]) > 0.5:
        return np.array([0.0, -1.0, 0.0])
    return np.array([0.0, 0.0, 1.0])


def _nearest_axis(vector: FloatArray) -> FloatArray:
    axis = np.zeros(3)
    largest = int(np.argmax(np.abs(vector)))
    axis[largest] = 1.0 if vector[largest] >= 0.0 else -1.0
    return axis


def _axis_name(axis: FloatArray) -> str:
    largest = int(np.argmax(np.abs(axis)))
    return f"{'+' if axis[largest] > 0.0 else '-'}{'xyz'[largest]}"
