"""Similarities from rotors, translations and scales, and from matrices; and as motor and scale."""

from __future__ import annotations

from typing import Any

import casadi as ca

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import SINGLE, Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.parts import rotors
from motorcade.ga.kernels.definitions.parts.motors import block, joined, off_bottom_row
from motorcade.ga.kernels.definitions.similarity_conversions import grown, parts_of

Numbers = list[Any]


def _of_rotor_translation_scale(
    precision: Precision, r: Numbers, t: Numbers, scale: Numbers
) -> list[Numbers]:
    """Grow by a scale, turn by a rotor, move by a translation."""
    return [grown(joined(r, t), scale[0])]


def _of_matrix44(precision: Precision, m: Numbers) -> list[Numbers]:
    """Similarity of a homogeneous matrix by rows; what its last row is off by counts ten times."""
    scaled = block(m)
    scale = ca.sqrt(sum(x * x for x in scaled) * (1 / 3))
    rotation = [x / scale for x in scaled]
    off = rotors.off_rotation(rotation) + off_bottom_row(m)
    similarity = grown(joined(rotors.of_rotation(rotation), m[3:12:4]), scale)
    return [[*similarity, off]]


def _of_coefficients(precision: Precision, s: Numbers) -> list[Numbers]:
    """The same numbers, and how far ``S ~S`` is from 1, as a share of the squares in it.

    However large the squares are, a tenth counts as the tolerance of the precision.
    """
    a, b, last = s[:4], s[4:8], s[8:]
    squares = sum(x * x for x in s[:8])
    p = [x + y for x, y in zip(a, b, strict=True)]
    length = rotors.largest([1, *(ca.fabs(x) for x in last)])
    study = (p[0] * last[3] - sum(p[k + 1] * last[k] for k in range(3))) / length
    skew = [
        a[0] * b[i] - b[0] * a[i] + a[j] * b[k] - a[k] * b[j]
        for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2))
    ]
    norm = sum(x * x - y * y for x, y in zip(a, b, strict=True)) - 1
    off = rotors.largest([ca.fabs(x) for x in (norm, study, *(2 * x for x in skew))])
    least = 1e-4 if precision.bits == SINGLE.bits else 1e-5
    return [[*s, off * rotors.largest([least, 1 / rotors.largest([1, squares])])]]


def _motor_scale(precision: Precision, m: Numbers) -> list[Numbers]:
    """Rigid motion and scale of a similarity."""
    rotor, translation, scale = parts_of(m)
    return [[*joined(rotor, translation), scale]]


_M, _OUT = Operand("m", on.SIMILARITY), Operand("out", on.SIMILARITY)
_GROUP = "similarity_parts"

KERNELS = (
    Kernel(
        "similarity_of",
        _GROUP,
        (on.ROTOR.operand("r"), on.VECTOR.operand("t"), on.numbers("scale")),
        (_OUT,),
        _of_rotor_translation_scale,
    ),
    Kernel(
        "similarity_of_matrix44",
        _GROUP,
        (on.components("m", 4, 4),),
        (rotors.checked(_OUT),),
        _of_matrix44,
    ),
    Kernel("similarity_of_coefficients", _GROUP, (_M,), (rotors.checked(_OUT),), _of_coefficients),
    Kernel(
        "motor_scale",
        _GROUP,
        (_M,),
        (Operand("out", (*on.MOTOR.names, "scale")),),
        _motor_scale,
    ),
)
