"""Steps of inverse kinematics on chains of points: spheres and lines of CGA, met.

Everything is shifted so that the joint that stays is the origin ``e0``; what can be zero is then
zero in the multivectors, and the code that is left is short.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on

Numbers = list[Any]

_ORIGIN = CGA3.multivector({"e0": 1})
_INFINITY = CGA3.multivector({"einf": 1})


def _point(x: Numbers) -> Multivector:
    """``x + ½ x² e∞ + e0``."""
    return _ORIGIN + on.VECTOR.of(x) + on.scaled(_INFINITY, 0.5 * sum(a * a for a in x))


def _reach(precision: Precision, p: Numbers, q: Numbers, length: Numbers) -> list[Numbers]:
    """The point of the ray from p towards q that lies a length from p.

    The line through both points and the sphere around the first meet in a pair of points; of
    these the one on the side of q is ``(B - √B²) / (e∞ · B)``.
    """
    away = [b - a for a, b in zip(p, q, strict=True)]
    line = _ORIGIN ^ _point(away) ^ _INFINITY
    sphere = _ORIGIN - on.scaled(_INFINITY, 0.5 * length[0] * length[0])
    pair = sphere | line
    root = ca.sqrt((pair * pair).coefficient("1"))
    weight = _INFINITY | pair
    size = (weight * weight).coefficient("1")
    met = (pair - root) * weight * (1 / size)
    scale = met.coefficient("e0")
    return [[a + b / scale for a, b in zip(p, on.VECTOR.numbers(met), strict=True)]]


_RAY = on.VECTOR.operand("p"), on.VECTOR.operand("q"), on.numbers("length")

KERNELS = (Kernel("reach", "chains", _RAY, (on.VECTOR.operand("out"),), _reach),)
