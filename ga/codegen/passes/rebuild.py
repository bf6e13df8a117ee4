"""Rebuilding a tape node by node, in the builder's simplest form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from motorcade.ga.codegen.tape import Tape, TapeBuilder


def copied(tape: Tape, index: int, args: tuple[int, ...], builder: TapeBuilder) -> int:
    """A node of a tape on new arguments, in a builder."""
    node = tape.nodes[index]
    if node.op == "const":
        return builder.constant(node.value)
    if node.op == "input":
        return builder.input(*node.source)
    return builder.operation(node.op, *args)


def folded_tape(tape: Tape) -> Tape:
    """The tape with operations on numbers worked out, and nothing added or multiplied in vain."""
    builder = TapeBuilder()
    place: list[int] = []
    for index, node in enumerate(tape.nodes):
        place.append(copied(tape, index, tuple(place[k] for k in node.args), builder))
    results = [[place[k] for k in row] for row in tape.results]
    return builder.finished(tape.inputs, tape.outputs, results)


def product_of(factors: Sequence[int], builder: TapeBuilder) -> int:
    """The product of nodes of a builder, 1 of none; powers by squaring."""
    product = builder.constant(1.0)
    for factor, count in Counter(factors).items():
        power = factor
        while count:
            if count & 1:
                product = builder.operation("mul", product, power)
            count >>= 1
            if count:
                power = builder.operation("mul", power, power)
    return product


def with_single_differences(tape: Tape) -> Tape:
    """The tape with ``b - a`` written ``-(a - b)`` where that difference is there as well."""
    builder = TapeBuilder()
    place: list[int] = []
    known: dict[tuple[int, int], int] = {}
    for index, node in enumerate(tape.nodes):
        args = tuple(place[k] for k in node.args)
        opposite = known.get((args[1], args[0])) if node.op == "sub" else None
        if opposite is None:
            copy = copied(tape, index, args, builder)
            if node.op == "sub":
                known[args[0], args[1]] = copy
        else:
            copy = builder.negative(opposite)
        place.append(copy)
    results = [[place[k] for k in row] for row in tape.results]
    return builder.finished(tape.inputs, tape.outputs, results)
