"""Powers of two, which kernels take from the bits of a number instead of a library's functions.

A definition writes ``2^n`` of a whole n as a power and ``floor(log x / log 2)`` as just that, so
that CasADi can evaluate it (the latter may there be one off within rounding of a power of two).
The tracer reads both as one operation: ``exp2_of_integer`` and ``exponent``.
"""

from __future__ import annotations

from math import log
from typing import Any

from motorcade.ga.codegen.tape import TapeBuilder

_LOG_TWO = log(2.0)
_WHOLE_IF_ARGUMENTS_ARE = frozenset({"add", "sub", "mul", "neg", "min", "max"})


def power_of_two(n: Any) -> Any:
    """``2^n`` of a number that is whole by the way it is made, as by `floor`."""
    import casadi as ca

    return ca.power(2.0, n)


def exponent(x: Any) -> Any:
    """The greatest whole n with ``2^n <= x``."""
    import casadi as ca

    return ca.floor(ca.log(x) / _LOG_TWO)


def power_of_two_node(builder: TapeBuilder, spelled: str, args: list[int]) -> int | None:
    """The node of what `power_of_two` and `exponent` wrote; None for every other operation."""
    if spelled == "OP_POW" and _is(builder, args[0], 2.0) and _whole(builder, args[1]):
        return builder.operation("exp2_of_integer", args[1])
    if spelled == "OP_FLOOR":
        quotient = builder.nodes[args[0]]
        if quotient.op == "div" and _is(builder, quotient.args[1], _LOG_TWO):
            logarithm = builder.nodes[quotient.args[0]]
            if logarithm.op == "log":
                return builder.operation("exponent", logarithm.args[0])
    return None


def _is(builder: TapeBuilder, index: int, value: float) -> bool:
    node = builder.nodes[index]
    return node.op == "const" and node.value == value


def _whole(builder: TapeBuilder, index: int) -> bool:
    node = builder.nodes[index]
    if node.op == "const":
        return node.value.is_integer()
    if node.op in ("floor", "ceil", "exponent"):
        return True
    return node.op in _WHOLE_IF_ARGUMENTS_ARE and all(_whole(builder, k) for k in node.args)
