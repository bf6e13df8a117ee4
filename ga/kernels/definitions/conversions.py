"""Motors applied to points, and motors as matrices and dual quaternions."""

from __future__ import annotations

from typing import Any

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on

Numbers = list[Any]


def matrix_rows(m: Numbers, unit: bool) -> Numbers:
    """The 3×4 matrix by rows: images of e1, e2, e3, and the translation.

    Columns are ``R e ~R``; ``M ~R`` is the translator ``1 - ½ t∞``. Of an element that is not
    unit they come out ``R ~R`` times as long, and what is off the motors falls away with the
    scalar part of the dual half, so dividing is all the projection that a matrix needs.
    """
    rotor, motor = on.ROTOR.of(m[:4]), on.MOTOR.of(m)
    axes = [on.VECTOR.of([float(i == k) for i in range(3)]) for k in range(3)]
    columns = [on.VECTOR.numbers(rotor * axis * ~rotor) for axis in axes]
    columns.append(on.translation_numbers(motor * ~rotor))
    if not unit:
        scale = 1 / (rotor * ~rotor).coefficient("1")
        columns = [[scale * value for value in column] for column in columns]
    return [columns[j][i] for i in range(3) for j in range(4)]


def _apply(precision: Precision, m: Numbers, x: Numbers) -> list[Numbers]:
    """Points moved by motors."""
    rotor, motor = on.ROTOR.of(m[:4]), on.MOTOR.of(m)
    turned = on.VECTOR.numbers(rotor * on.VECTOR.of(x) * ~rotor)
    moved = on.translation_numbers(motor * ~rotor)
    return [[a + b for a, b in zip(turned, moved, strict=True)]]


def _matrix34(precision: Precision, m: Numbers) -> list[Numbers]:
    """3×4 matrix of a motor, by rows."""
    return [matrix_rows(m, unit=True)]


def _matrix44(precision: Precision, m: Numbers) -> list[Numbers]:
    """4×4 matrix of a motor, by rows."""
    return [[*matrix_rows(m, unit=True), 0.0, 0.0, 0.0, 1.0]]


def _transform(precision: Precision, m: Numbers, x: Numbers) -> list[Numbers]:
    """Points moved by 3×4 matrices, given by rows."""
    rows = [m[4 * i : 4 * i + 4] for i in range(3)]
    return [[row[3] + row[0] * x[0] + row[1] * x[1] + row[2] * x[2] for row in rows]]


def _dual_quaternion(precision: Precision, m: Numbers) -> list[Numbers]:
    # Hamilton's i, j, k are -e23, -e31, -e12, and his ε times them e1∞ …, in this order.
    """Unit Hamilton dual quaternion: real wxyz, dual wxyz."""
    return [[m[0], -m[1], -m[2], -m[3], -m[7], -m[4], -m[5], -m[6]]]


_M, _ROWS = on.MOTOR.operand("m"), on.components("out", 3, 4)
_POINTS, _MOVED = on.VECTOR.operand("x"), on.VECTOR.operand("out")

KERNELS = (
    Kernel("apply", "products", (_M, _POINTS), (_MOVED,), _apply),
    Kernel("matrix34", "conversions", (_M,), (_ROWS,), _matrix34),
    Kernel("matrix44", "conversions", (_M,), (on.components("out", 4, 4),), _matrix44),
    Kernel("transform", "conversions", (on.components("m", 3, 4), _POINTS), (_MOVED,), _transform),
    Kernel(
        "dual_quaternion",
        "conversions",
        (_M,),
        (Operand("out", on.DUAL_QUATERNION),),
        _dual_quaternion,
    ),
)
