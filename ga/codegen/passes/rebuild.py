"""Rebuilding a tape node by node, in the builder's simplest form."""

from __future__ import annotations

from motorcade.ga.codegen.tape import Tape, TapeBuilder

__all__ = ["copied", "folded_tape"]


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
