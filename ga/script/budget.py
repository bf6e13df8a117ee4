"""How much an evaluation may cost: steps, and terms of all its products and sums.

What a step costs is estimated from the blades of its operands, before it is done.
"""

from __future__ import annotations

from motorcade.ga.algebra import Multivector
from motorcade.ga.algebra.functions.commuting import square_of, without_scalar
from motorcade.ga.script.reading.syntax import Binary, Call, Expression, Unary

MAX_STEPS = 100_000
MAX_TERMS = 200_000
_PRODUCTS = frozenset(["*", "^", ".", "&", "<<", ">>"])
# How many products the closed forms of functions take at most, and the series of `exp`.
_CLOSED = 12
_SERIES = 40


class Budget:
    """How much an evaluation has cost so far."""

    def __init__(self) -> None:
        self._steps = 0
        self._terms = 0

    def spend(self, node: Expression | None, operands: list[Multivector]) -> str:
        """Count a step that is about to be done: what is wrong if it is one too many, or ""."""
        self._steps += 1
        if self._steps > MAX_STEPS:
            return f"expected at most {MAX_STEPS} steps"
        self._terms += 0 if node is None else _terms(node, operands)
        if self._terms > MAX_TERMS:
            return f"expected products of at most {MAX_TERMS} terms in all"
        return ""


def _terms(node: Expression, operands: list[Multivector]) -> int:
    sizes = [len(x.masks) for x in operands]
    if isinstance(node, Binary) and node.operator in _PRODUCTS:
        return sizes[0] * sizes[1]
    if isinstance(node, Binary) and node.operator == "/":
        right = operands[1]
        whole = len(right.masks) if _has_scalar_size(right) else 1 << right.algebra.dimension
        return _of_inverse(right) + sizes[0] * whole
    if isinstance(node, Call) and len(operands) == 1:
        return _of_function(node.name.lower(), operands[0])
    return sum(sizes) if isinstance(node, Binary | Unary) else 0


def _of_inverse(x: Multivector) -> int:
    size, dimension = len(x.masks), x.algebra.dimension
    if _has_scalar_size(x):
        return size * size
    return size * size + (size << dimension + (dimension + 1) // 2)


def _has_scalar_size(x: Multivector) -> bool:
    """Whether ``x ~x`` is a scalar by structure; looked at only where that is cheap."""
    return len(x.masks) ** 2 <= MAX_TERMS and not any(x._reverse_plan().masks)


def _of_function(name: str, x: Multivector) -> int:
    size, whole = len(x.masks), 1 << x.algebra.dimension
    if size * size > MAX_TERMS or name == "invert":
        return _of_inverse(x)
    if name not in ("exp", "log", "sqrt", "versor"):
        return size * size
    if name != "exp" or square_of(without_scalar(x)) is not None:
        return _CLOSED * size * size
    return _SERIES * size * whole
