"""Weighted averages of several versors, which take one of them after the other.

A blend is the sum of `add_weighted`, projected; a mean moves by the sum of `add_local` until that
vanishes. See ``ga/versors/averages.py``.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import casadi as ca

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import select
from motorcade.ga.kernels.definitions.parts.rotors import largest
from motorcade.ga.kernels.definitions.versors import Versors

Numbers = list[Any]

# How long the terms are together, beside which a sum that cancels is told.
BULK = "bulk"


def _add_weighted(
    precision: Precision, total: Numbers, pivot: Numbers, m: Numbers, weight: Numbers
) -> list[Numbers]:
    scalar = sum(x * y for x, y in zip(pivot[:4], m[:4], strict=True))
    signed = select(scalar < 0, -weight[0], weight[0])
    bulk = total[-1] + ca.fabs(weight[0]) * largest([ca.fabs(x) for x in m[:4]])
    return [[*(x + signed * y for x, y in zip(total[:-1], m, strict=True)), bulk]]


def _add_local(
    of: Versors, precision: Precision, total: Numbers, a: Numbers, b: Numbers, weight: Numbers
) -> list[Numbers]:
    twist = of.as_twist(of.log(precision, ~of.read(a) * of.read(b), True))
    return [[x + weight[0] * y for x, y in zip(total, twist, strict=True)]]


def average_kernels(of: Versors) -> tuple[Kernel, Kernel]:
    """The two of one kind of versor."""
    group, weight = f"{of.prefix}averages", on.numbers("weight")
    a, b, m, pivot = (Operand(name, of.versor) for name in ("a", "b", "m", "pivot"))
    total, out = (Operand(name, (*of.versor, BULK)) for name in ("s", "out"))
    return (
        Kernel(
            f"{of.prefix}add_weighted",
            group,
            (total, pivot, m, weight),
            (out,),
            _add_weighted,
            f"A sum of {of.plural} with one more, signed as it is beside the pivot",
        ),
        Kernel(
            f"{of.prefix}add_local",
            group,
            (on.twist("s", of.twist_size), a, b, weight),
            (on.twist("out", of.twist_size),),
            partial(_add_local, of),
            f"A sum of twists with that from {of.name} a to b, which turns by at most π",
        ),
    )
