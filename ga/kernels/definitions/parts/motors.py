"""Motors from rotors and translations, matrices and dual quaternions, and the parts of motors."""

from __future__ import annotations

from typing import Any

import casadi as ca

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.blends import projected
from motorcade.ga.kernels.definitions.conversions import matrix_rows
from motorcade.ga.kernels.definitions.parts import rotors

Numbers = list[Any]


def joined(r: Numbers, t: Numbers) -> Numbers:
    """The motor ``T R``, with ``T = 1 - ½ t∞``."""
    translator = on.MOTOR.of([1, 0, 0, 0, *(-0.5 * x for x in t), 0])
    return on.MOTOR.numbers(translator * on.ROTOR.of(r))


def off_bottom_row(m: Numbers) -> Any:
    """How far the last row of a 4×4 matrix is from 0 0 0 1, ten times that, all added up."""
    return 10 * sum(ca.fabs(m[k] - float(k == 15)) for k in range(12, 16))


def block(m: Numbers) -> Numbers:
    """The upper left 3×3 block of a 4×4 matrix, by rows."""
    return [m[4 * i + j] for i in range(3) for j in range(3)]


def _translation(precision: Precision, m: Numbers) -> list[Numbers]:
    """Where a motor takes the origin."""
    return [matrix_rows(m, unit=True)[3::4]]


def _of_translation(precision: Precision, t: Numbers) -> list[Numbers]:
    """The motor that moves by a translation and turns nothing."""
    return [joined([1, 0, 0, 0], t)]


def _of_rotor_translation(precision: Precision, r: Numbers, t: Numbers) -> list[Numbers]:
    """The motor that turns by a rotor, then moves by a translation."""
    return [joined(r, t)]


def _of_quaternion(precision: Precision, q: Numbers, t: Numbers) -> list[Numbers]:
    """The motor that turns by a unit quaternion, then moves by a translation."""
    return [[*joined(rotors.conjugate(q), t), rotors.off_unit(q)]]


def _of_matrix44(precision: Precision, m: Numbers) -> list[Numbers]:
    """Motor of a homogeneous matrix by rows; what its last row is off by counts ten times."""
    rotation = block(m)
    off = rotors.off_rotation(rotation) + off_bottom_row(m)
    return [[*joined(rotors.of_rotation(rotation), m[3:12:4]), off]]


def _of_dual_quaternion(precision: Precision, d: Numbers) -> list[Numbers]:
    """Motor of a unit Hamilton dual quaternion."""
    return _of_coefficients(precision, [d[0], -d[1], -d[2], -d[3], -d[5], -d[6], -d[7], -d[4]])


def _of_coefficients(precision: Precision, m: Numbers) -> list[Numbers]:
    """The same numbers, and how far they are from a motor's."""
    length = rotors.largest([1, *(ca.fabs(x) for x in m[4:])])
    study = ca.fabs(m[0] * m[7] - sum(m[k] * m[k + 3] for k in (1, 2, 3))) / length
    return [[*m, rotors.largest([rotors.off_unit(m[:4]), study])]]


def _project(precision: Precision, m: Numbers) -> list[Numbers]:
    """The motor nearest to an even element, divided by its largest rotor coefficient first."""
    size = rotors.largest([ca.fabs(x) for x in m[:4]])
    scaled = on.MOTOR.of([x / size for x in m])
    return [[*on.MOTOR.numbers(projected(scaled)), size]]


_M, _OUT, _T = on.MOTOR.operand("m"), on.MOTOR.operand("out"), on.VECTOR.operand("t")
_MATRIX = on.components("m", 4, 4)
_DUAL = Operand("d", on.DUAL_QUATERNION)
_GROUP = "motor_conversions"

KERNELS = (
    Kernel("translation", _GROUP, (_M,), (on.VECTOR.operand("out"),), _translation),
    Kernel("of_translation", _GROUP, (_T,), (_OUT,), _of_translation),
    Kernel("motor_of", _GROUP, (on.ROTOR.operand("r"), _T), (_OUT,), _of_rotor_translation),
    Kernel(
        "motor_of_quaternion",
        _GROUP,
        (rotors.QUATERNION, _T),
        (rotors.checked(_OUT),),
        _of_quaternion,
    ),
    Kernel("motor_of_matrix44", _GROUP, (_MATRIX,), (rotors.checked(_OUT),), _of_matrix44),
    Kernel(
        "motor_of_dual_quaternion", _GROUP, (_DUAL,), (rotors.checked(_OUT),), _of_dual_quaternion
    ),
    Kernel("of_coefficients", _GROUP, (_M,), (rotors.checked(_OUT),), _of_coefficients),
    Kernel("project", _GROUP, (_M,), (Operand("out", (*_OUT.components, "size")),), _project),
)
