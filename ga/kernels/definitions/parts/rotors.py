"""Rotors from quaternions and rotation matrices and back, and rotors applied to vectors."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import Any

import casadi as ca

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import select

Numbers = list[Any]
OFF = "off"
# What a reflection is off by, more than any tolerance.
_REFLECTION = 4.0


def checked(operand: Operand) -> Operand:
    """An output with how far off the input is as its last component."""
    return Operand(operand.name, (*operand.components, OFF))


def largest(values: Numbers) -> Any:
    """The largest of several numbers."""
    greatest = values[0]
    for value in values[1:]:
        greatest = ca.fmax(greatest, value)
    return greatest


def conjugate(q: Numbers) -> Numbers:
    """The rotor of a quaternion wxyz, and the quaternion of a rotor."""
    return [q[0], *(-x for x in q[1:])]


def off_unit(numbers: Numbers) -> Any:
    """How far the norm is from 1."""
    return ca.fabs(ca.sqrt(sum(x * x for x in numbers)) - 1)


def unit(numbers: Numbers) -> Numbers:
    """Numbers divided by their norm."""
    scale = 1 / ca.sqrt(sum(x * x for x in numbers))
    return [scale * x for x in numbers]


def off_rotation(m: Numbers) -> Any:
    """Entries of ``|R^T R - 1|`` of a matrix by rows, added up, or a large number if it mirrors."""
    columns = [m[k::3] for k in range(3)]
    off = sum(
        ca.fabs(sum(x * y for x, y in zip(a, b, strict=True)) - float(a is b))
        for a, b in combinations_with_replacement(columns, 2)
    )
    a, b, c = columns
    determinant = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return select(determinant < 0, _REFLECTION, off)


def of_rotation(m: Numbers) -> Numbers:
    """The rotor of a rotation matrix by rows.

    The longest column of ``4 q q^T`` is never near zero, so no angle is special (Bar-Itzhack, "New
    method for extracting the quaternion from a rotation matrix", 2000, and others).
    """
    d0, d1, d2 = m[0], m[4], m[8]
    wx, wy, wz = m[7] - m[5], m[2] - m[6], m[3] - m[1]
    xy, xz, yz = m[3] + m[1], m[6] + m[2], m[7] + m[5]
    columns = [
        [1 + d0 + d1 + d2, wx, wy, wz],
        [wx, 1 + d0 - d1 - d2, xy, xz],
        [wy, xy, 1 - d0 + d1 - d2, yz],
        [wz, xz, yz, 1 - d0 - d1 + d2],
    ]
    squares = [columns[k][k] for k in range(4)]
    first, first_square = _longer(columns[0], squares[0], columns[1], squares[1])
    second, second_square = _longer(columns[2], squares[2], columns[3], squares[3])
    column, _ = _longer(first, first_square, second, second_square)
    return conjugate(unit(column))


def _longer(a: Numbers, a_square: Any, b: Numbers, b_square: Any) -> tuple[Numbers, Any]:
    chosen = a_square >= b_square
    longer = [select(chosen, x, y) for x, y in zip(a, b, strict=True)]
    return longer, select(chosen, a_square, b_square)


def _apply(precision: Precision, r: Numbers, x: Numbers) -> list[Numbers]:
    """Vectors turned by rotors: ``x + 2 v×(v×x) - 2 w v×x``, whose small turns lose nothing."""
    w, v = r[0], r[1:]
    turned = _cross(v, x)
    again = _cross(v, turned)
    return [[a + 2 * (c - w * b) for a, b, c in zip(x, turned, again, strict=True)]]


def _cross(a: Numbers, b: Numbers) -> Numbers:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def _matrix33(precision: Precision, r: Numbers) -> list[Numbers]:
    """3×3 matrix of a rotor, by rows."""
    w, x, y, z = conjugate(r)
    return [[
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]]  # fmt: skip


def _of_matrix33(precision: Precision, m: Numbers) -> list[Numbers]:
    """Rotor of a rotation matrix by rows."""
    return [[*of_rotation(m), off_rotation(m)]]


def _of_quaternion(precision: Precision, q: Numbers) -> list[Numbers]:
    """Rotor of a unit quaternion."""
    return [[*conjugate(q), off_unit(q)]]


def _of_coefficients(precision: Precision, r: Numbers) -> list[Numbers]:
    """The same numbers, and how far they are from a rotor's."""
    return [[*r, off_unit(r)]]


def _normalize(precision: Precision, r: Numbers) -> list[Numbers]:
    """The rotor nearest to an even element, divided by its largest coefficient first."""
    size = largest([ca.fabs(x) for x in r])
    return [[*unit([x / size for x in r]), size]]


QUATERNION = Operand("q", ("w", "x", "y", "z"))
_R, _OUT = on.ROTOR.operand("r"), on.ROTOR.operand("out")
_X, _MATRIX = on.VECTOR.operand("x"), on.components("m", 3, 3)
_GROUP = "rotor_conversions"

KERNELS = (
    Kernel(
        "rotor_apply", _GROUP, (_R, on.VECTOR.operand("x")), (on.VECTOR.operand("out"),), _apply
    ),
    Kernel("rotor_matrix33", _GROUP, (_R,), (on.components("out", 3, 3),), _matrix33),
    Kernel("rotor_of_matrix33", _GROUP, (_MATRIX,), (checked(_OUT),), _of_matrix33),
    Kernel("rotor_of_coefficients", _GROUP, (_R,), (checked(_OUT),), _of_coefficients),
    Kernel("rotor_of_quaternion", _GROUP, (QUATERNION,), (checked(_OUT),), _of_quaternion),
    Kernel(
        "rotor_normalize", _GROUP, (_R,), (Operand("out", (*_OUT.components, "size")),), _normalize
    ),
)
