"""What carries a vertex and its normal: a matrix, a dual quaternion, a motor or a similarity.

Skinning sums the weighted palette entries of the joints that hold a vertex; the sum is no unit
versor. Each kernel takes such a sum to the motion nearest to it, and gives the moved position and
the turned normal.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.similarities import projected, split
from motorcade.ga.kernels.definitions.similarity_conversions import grown_rotor

Numbers = list[Any]


def _unit(v: Numbers) -> Numbers:
    scale = 1 / ca.sqrt(sum(x * x for x in v))
    return [scale * x for x in v]


def _carry_motor(precision: Precision, m: Numbers, x: Numbers, n: Numbers) -> list[Numbers]:
    """A point and a normal carried by a sum of motors.

    ``M X ~M`` of a motor that is as long as ``α``: what is off the motors falls away, as in
    `conversions.matrix_rows`, and dividing by ``α`` is all the projection that is left.
    """
    rotor, motor = on.ROTOR.of(m[:4]), on.MOTOR.of(m)
    scale = 1 / (rotor * ~rotor).coefficient("1")
    moved = on.translation_numbers(motor * ~rotor)
    turned = on.VECTOR.numbers(rotor * on.VECTOR.of(x) * ~rotor)
    normal = on.VECTOR.numbers(rotor * on.VECTOR.of(n) * ~rotor)
    return [
        [scale * (a + b) for a, b in zip(turned, moved, strict=True)] + [scale * a for a in normal]
    ]


def _carry_similarity(precision: Precision, s: Numbers, x: Numbers, n: Numbers) -> list[Numbers]:
    """A point and a normal carried by a sum of similarities.

    ``S X ~S`` of the similarity nearest to the sum; the normal turns and keeps its length.
    """
    parts, _ = projected(precision, split(s))
    rotor = grown_rotor(parts)
    scale = 1 / (rotor * ~rotor).coefficient("1")
    moved = on.translation_numbers(parts.moved * ~rotor)
    turned = on.VECTOR.numbers(rotor * on.VECTOR.of(x) * ~rotor)
    normal = on.VECTOR.numbers(rotor * on.VECTOR.of(n) * ~rotor)
    return [[a + b for a, b in zip(turned, moved, strict=True)] + [scale * a for a in normal]]


def _cross(a: Numbers, b: Numbers) -> Numbers:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def _carry_dual_quaternion(
    precision: Precision, q: Numbers, x: Numbers, n: Numbers
) -> list[Numbers]:
    """A point and a normal carried by a sum of dual quaternions, real wxyz, dual wxyz.

    As Kavan et al. (2007) write it, in cross products: nothing of the algebra is used.
    """
    w, d, dual_w, e = q[0], q[1:4], q[4], q[5:8]
    scale = 1 / (w * w + sum(a * a for a in d))

    def turned(v: Numbers) -> Numbers:
        inner = [c + w * a for c, a in zip(_cross(d, v), v, strict=True)]
        return [a + 2 * scale * c for a, c in zip(v, _cross(d, inner), strict=True)]

    lever = _cross(d, e)
    moved = [2 * scale * (w * b - dual_w * a + c) for a, b, c in zip(d, e, lever, strict=True)]
    return [[a + b for a, b in zip(turned(x), moved, strict=True)] + turned(n)]


def _carry_matrix(precision: Precision, m: Numbers, x: Numbers, n: Numbers) -> list[Numbers]:
    """A point and a normal carried by a sum of 3×4 matrices.

    The upper left part moves the normal, which is brought back to unit length.
    """
    rows = [m[4 * i : 4 * i + 4] for i in range(3)]
    moved = [sum(a * b for a, b in zip(row, [*x, 1], strict=True)) for row in rows]
    return [moved + _unit([sum(a * b for a, b in zip(row[:3], n, strict=True)) for row in rows])]


_X, _N = on.VECTOR.operand("x"), on.VECTOR.operand("n")
_OUT = (Operand("out", ("x", "y", "z", "nx", "ny", "nz")),)

KERNELS = (
    Kernel("carry_motor", "skinning", (on.MOTOR.operand("m"), _X, _N), _OUT, _carry_motor),
    Kernel(
        "carry_dual_quaternion",
        "skinning",
        (Operand("q", on.DUAL_QUATERNION), _X, _N),
        _OUT,
        _carry_dual_quaternion,
    ),
    Kernel(
        "carry_similarity",
        "skinning",
        (Operand("s", on.SIMILARITY), _X, _N),
        _OUT,
        _carry_similarity,
    ),
    Kernel("carry_matrix", "skinning", (on.components("m", 3, 4), _X, _N), _OUT, _carry_matrix),
)
