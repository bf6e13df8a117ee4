"""Which values are never negative, by the way they are made: squares, their sums, roots."""

from __future__ import annotations

from motorcade.ga.codegen.tape import Node, Tape

__all__ = ["nonnegative_nodes"]

_ALWAYS = frozenset({"abs", "sqrt", "exp", "acos", "lt", "le", "eq", "ne", "and", "or", "not"})


def nonnegative_nodes(tape: Tape) -> list[bool]:
    """For each node whether its value is at least 0 wherever it is a number, rounding included."""
    found: list[bool] = []
    for node in tape.nodes:
        found.append(_nonnegative(node, [found[k] for k in node.args], tape))
    return found


def _nonnegative(node: Node, args: list[bool], tape: Tape) -> bool:
    if node.op == "const":
        return node.value >= 0.0
    if node.op == "mul":
        return all(args) or _is_square(node, tape)
    if node.op in ("add", "div", "min", "floor", "ceil", "keep"):
        return all(args)
    if node.op == "max":
        return any(args)
    if node.op == "select":
        return all(args[1:])
    return node.op in _ALWAYS


def _is_square(node: Node, tape: Tape) -> bool:
    """``x x``, and ``(c x) x`` for a number c that is not negative."""
    left, right = node.args
    if left == right:
        return True
    for product, factor in ((left, right), (right, left)):
        inner = tape.nodes[product]
        if inner.op == "mul" and factor in inner.args:
            rest = inner.args[0] if inner.args[1] == factor else inner.args[1]
            if tape.nodes[rest].op == "const" and tape.nodes[rest].value >= 0.0:
                return True
    return False
