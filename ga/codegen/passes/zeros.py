"""Components that are zero: no output keeps them."""

from __future__ import annotations

from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder

__all__ = ["without_zeros"]


def without_zeros(tape: Tape) -> Tape:
    """The tape without the components of outputs that are the number zero.

    An output of which nothing is left keeps its name.
    """
    kept = [[i for i, k in enumerate(row) if not _is_zero(tape, k)] for row in tape.results]
    if [len(places) for places in kept] == [len(row) for row in tape.results]:
        return tape
    outputs = tuple(
        Operand(operand.name, tuple(operand.components[i] for i in places))
        for operand, places in zip(tape.outputs, kept, strict=True)
    )
    results = [[row[i] for i in places] for row, places in zip(tape.results, kept, strict=True)]
    builder = TapeBuilder()
    builder.nodes.extend(tape.nodes)
    return builder.finished(tape.inputs, outputs, results)


def _is_zero(tape: Tape, index: int) -> bool:
    node = tape.nodes[index]
    return node.op == "const" and node.value == 0.0
