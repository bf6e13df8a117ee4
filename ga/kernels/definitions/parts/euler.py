"""Rotors from Euler angles of any sequence and back.

Which sequence is an operand: its three axes as unit vectors; and, to read angles, its first two
axes and the third direction, and 1 where these are in cyclic order, -1 where they are not.
"""

from __future__ import annotations

from math import pi
from typing import Any

import casadi as ca
import mpmath as mp

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import cosine_sinc, polynomial, select
from motorcade.ga.kernels.definitions.parts.motors import joined
from motorcade.ga.kernels.definitions.parts.rotors import conjugate

Numbers = list[Any]
# Where the lever arm of the first angle is below this, the angle is noise: gimbal lock.
LOCKED = 4e-15
_LOCKED_ROUNDINGS = LOCKED / 2.0**-52
_TINY = 1e-30


def _arctangent_over_root(y: Any) -> Any:
    root = mp.sqrt(y)
    return mp.atan(root) / root


def arctangent(precision: Precision, y: Any, x: Any) -> Any:
    """``atan2(y, x)`` without a branch; 0 where both are 0."""
    high, wide = ca.fabs(y), ca.fabs(x)
    ratio = ca.fmin(high, wide) / (ca.fmax(high, wide) + _TINY)
    angle = ratio * polynomial(precision, _arctangent_over_root, 1.0, ratio * ratio)
    steep, behind = _flag(wide - high < 0), _flag(x < 0)
    angle = angle * (1 - 2 * steep) + 0.5 * pi * steep
    angle = angle * (1 - 2 * behind) + pi * behind
    return angle * (1 - 2 * _flag(y < 0))


def _flag(condition: Any) -> Any:
    """1 or 0 as a number: compilers do not vectorise loops in which choices decide later ones."""
    return select(condition, 1.5, 0.5) - 0.5


def _of_euler(precision: Precision, angles: Numbers, axes: Numbers) -> list[Numbers]:
    """Rotor of three turns about three axes, the first outermost.

    Of the two signs it has the one by which the largest coefficient of the quaternion is positive.
    """
    turns = []
    for k, angle in enumerate(angles):
        half = 0.5 * angle
        cosine, sinc, _ = cosine_sinc(precision, half * half)
        turns.append(on.ROTOR.of([cosine, *(-half * sinc * x for x in axes[3 * k : 3 * k + 3])]))
    rotor = on.ROTOR.numbers(turns[0] * turns[1] * turns[2])
    quaternion = conjugate(rotor)
    longest = quaternion[0]
    for x in quaternion[1:]:
        longest = select(ca.fabs(x) > ca.fabs(longest), x, longest)
    sign = select(longest < 0, -1, 1)
    return [[sign * x for x in rotor]]


def _motor_of_euler(
    precision: Precision, angles: Numbers, axes: Numbers, t: Numbers
) -> list[Numbers]:
    """Motor of three turns about three axes, the first outermost, then of a translation."""
    return [joined(_of_euler(precision, angles, axes)[0], t)]


class _Turned:
    """Entries of the rotation matrix on the sequence's own axes ``i, j, k``."""

    def __init__(self, r: Numbers, sequence: Numbers) -> None:
        w, *v = conjugate(r)
        self.cyclic = sequence[9]
        self._w = self.cyclic * w
        self._x = [
            sum(a * b for a, b in zip(v, sequence[3 * k : 3 * k + 3], strict=True))
            for k in range(3)
        ]

    def __call__(self, row: int, column: int) -> Any:
        x = self._x
        if row == column:
            a, b = (x[k] for k in range(3) if k != row)
            return 1 - 2 * (a * a + b * b)
        third = self._w * x[3 - row - column]
        sign = 1 if (row - column) % 3 == 1 else -1
        return 2 * (x[row] * x[column] + sign * third)


def _first(precision: Precision, opposite: Any, adjacent: Any) -> tuple[Any, Any, Any, Any]:
    """The first angle, its cosine and sine, and the lever arm that they are read from."""
    lever = ca.sqrt(opposite * opposite + adjacent * adjacent)
    free = _flag(-lever < -_LOCKED_ROUNDINGS * precision.epsilon)
    scale = 1 / (lever + _TINY)
    angle = free * arctangent(precision, opposite, adjacent)
    scale = free * scale
    return angle, scale * adjacent + (1 - free), scale * opposite, lever


def _tait_bryan(precision: Precision, r: Numbers, sequence: Numbers) -> list[Numbers]:
    """Angles of a rotor about three different axes."""
    m = _Turned(r, sequence)
    first, cosine, sine, lever = _first(precision, -m.cyclic * m(1, 2), m(2, 2))
    middle = arctangent(precision, m.cyclic * m(0, 2), lever)
    # What the first angle leaves over has the third in two entries of its second row.
    rest = [cosine * m(1, k) + m.cyclic * sine * m(2, k) for k in (0, 1)]
    return [[first, middle, arctangent(precision, m.cyclic * rest[0], rest[1])]]


def _proper(precision: Precision, r: Numbers, sequence: Numbers) -> list[Numbers]:
    """Angles of a rotor about two axes, the first of them twice."""
    m = _Turned(r, sequence)
    first, cosine, sine, lever = _first(precision, m(1, 0), -m.cyclic * m(2, 0))
    middle = arctangent(precision, lever, m(0, 0))
    rest = [cosine * m(1, k) + m.cyclic * sine * m(2, k) for k in (2, 1)]
    return [[first, middle, arctangent(precision, -m.cyclic * rest[0], rest[1])]]


_ANGLES = Operand("angles", ("first", "middle", "third"))
_AXES = Operand("axes", tuple(f"{name}{axis}" for name in "abc" for axis in "xyz"))
_SEQUENCE = Operand("s", (*_AXES.components, "cyclic"))
_R, _READ = on.ROTOR.operand("r"), Operand("out", _ANGLES.components)
_GROUP = "euler_angles"

KERNELS = (
    Kernel("rotor_of_euler", _GROUP, (_ANGLES, _AXES), (on.ROTOR.operand("out"),), _of_euler),
    Kernel(
        "motor_of_euler",
        _GROUP,
        (_ANGLES, _AXES, on.VECTOR.operand("t")),
        (on.MOTOR.operand("out"),),
        _motor_of_euler,
    ),
    Kernel("rotor_tait_bryan", _GROUP, (_R, _SEQUENCE), (_READ,), _tait_bryan),
    Kernel("rotor_proper_euler", _GROUP, (_R, _SEQUENCE), (_READ,), _proper),
)
