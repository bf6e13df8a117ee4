"""Similarities applied to points, as matrices, and as rotor, translation and scale."""

from __future__ import annotations

from typing import Any

import casadi as ca

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import select
from motorcade.ga.kernels.definitions.similarities import Parts, joined, scalar, split

Numbers = list[Any]


def grown_rotor(s: Parts) -> Multivector:
    """``√ρ R``: A + B or, where these cancel, the inverse of ``~(A - B)``."""
    shrunk = s.turned - s.grown
    small = scalar(s.turned * ~s.grown) < 0
    inverse = shrunk * (1 / scalar(shrunk * ~shrunk))
    pairs = zip(on.ROTOR.numbers(inverse), on.ROTOR.numbers(s.turned + s.grown), strict=True)
    return on.ROTOR.of([select(small, one, other) for one, other in pairs])


def _translation(s: Parts, grown_rotor: Multivector) -> Numbers:
    return on.translation_numbers(s.moved * ~grown_rotor)


def _matrix_rows(m: Numbers) -> Numbers:
    """The 3×4 matrix by rows: images of e1, e2, e3, and the translation."""
    s = split(m)
    rotor = grown_rotor(s)
    axes = [on.VECTOR.of([float(i == k) for i in range(3)]) for k in range(3)]
    columns = [on.VECTOR.numbers(rotor * axis * ~rotor) for axis in axes]
    columns.append(_translation(s, rotor))
    return [columns[j][i] for i in range(3) for j in range(4)]


def _apply(precision: Precision, m: Numbers, x: Numbers) -> list[Numbers]:
    """Points moved by similarities."""
    s = split(m)
    rotor = grown_rotor(s)
    turned = on.VECTOR.numbers(rotor * on.VECTOR.of(x) * ~rotor)
    return [[a + b for a, b in zip(turned, _translation(s, rotor), strict=True)]]


def _matrix34(precision: Precision, m: Numbers) -> list[Numbers]:
    """3×4 matrix of a similarity, by rows."""
    return [_matrix_rows(m)]


def _matrix44(precision: Precision, m: Numbers) -> list[Numbers]:
    """4×4 matrix of a similarity, by rows."""
    return [[*_matrix_rows(m), 0.0, 0.0, 0.0, 1.0]]


def parts_of(m: Numbers) -> tuple[Numbers, Numbers, Any]:
    """Rotor, translation and scale of a similarity."""
    s = split(m)
    grown = grown_rotor(s)
    rotor = s.turned * (1 / ca.sqrt(scalar(s.turned * ~s.turned)))
    return on.ROTOR.numbers(rotor), _translation(s, grown), scalar(grown * ~grown)


def _rotor_translation_scale(precision: Precision, m: Numbers) -> list[Numbers]:
    """Rotor, translation and scale of a similarity."""
    rotor, translation, scale = parts_of(m)
    return [[*rotor, *translation, scale]]


def grown(m: Numbers, scale: Any) -> Numbers:
    """A motor after growth about the origin by a scale."""
    root = 1 / ca.sqrt(scale)
    cosh, sinh = 0.5 * (scale + 1) * root, 0.5 * (scale - 1) * root
    rotor = on.ROTOR.of(m[:4])
    return joined(Parts(cosh * rotor, sinh * rotor, root * on.MOVED.of(m[4:])))


def _of_motor(precision: Precision, m: Numbers, scale: Numbers) -> list[Numbers]:
    """Motor after growth about the origin by a scale."""
    return [grown(m, scale[0])]


_M, _OUT = Operand("m", on.SIMILARITY), Operand("out", on.SIMILARITY)
_PRODUCTS, _CONVERSIONS = "similarity_products", "similarity_conversions"

KERNELS = (
    Kernel(
        "similarity_apply",
        _PRODUCTS,
        (_M, on.VECTOR.operand("x")),
        (on.VECTOR.operand("out"),),
        _apply,
    ),
    Kernel("similarity_matrix34", _CONVERSIONS, (_M,), (on.components("out", 3, 4),), _matrix34),
    Kernel("similarity_matrix44", _CONVERSIONS, (_M,), (on.components("out", 4, 4),), _matrix44),
    Kernel(
        "rotor_translation_scale",
        _CONVERSIONS,
        (_M,),
        (Operand("out", on.ROTOR_TRANSLATION_SCALE),),
        _rotor_translation_scale,
    ),
    Kernel(
        "similarity_of_motor",
        _CONVERSIONS,
        (on.MOTOR.operand("m"), on.numbers("scale")),
        (_OUT,),
        _of_motor,
    ),
)
