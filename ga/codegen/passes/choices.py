"""Choices inside a choice by the same condition, which need not be made again.

``c ? f(c ? x : y) : z`` is ``c ? f(x) : z``. Definitions write the inner choice to keep what is
not chosen finite, which derivatives need; values do not. So code that is differentiated further
keeps it, and code that only runs does without.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorcade.ga.codegen.tape import BOOLEANS, Tape, TapeBuilder


def without_repeated_choices(tape: Tape) -> Tape:
    """The tape with each choice made once on a side that it decides about.

    Sides are written anew for that. A side that shares much with the rest, so that there would be
    more to compute than before, stays as it is.
    """
    sides = frozenset(
        (node.args[0], held)
        for node in tape.nodes
        if node.op in ("select", "keep")
        for held in (True, False)
    )
    best, least = tape, _cost(tape)
    candidate = _decided(tape, sides)
    if _cost(candidate) < least:
        best, least = candidate, _cost(candidate)
    if len(sides) > _MOST_SIDES or len(tape.nodes) > _LONGEST:
        return best
    kept = sides
    for side in sorted(sides):
        candidate = _decided(tape, kept - {side})
        if _cost(candidate) < least:
            best, least, kept = candidate, _cost(candidate), kept - {side}
    return best


# Sides that are left out one by one, and of how long tapes.
_MOST_SIDES = 40
_LONGEST = 4000
# What an operation costs beside a sum or product, of vectors of numbers.
_COSTS = {"input": 0, "const": 0, "div": 4, "sqrt": 4}
_FUNCTION = 12
_CHEAP = (
    frozenset({"add", "sub", "mul", "neg", "abs", "min", "max", "floor", "ceil", "select", "keep"})
    | BOOLEANS
)

# A condition, and whether it holds; a node, and what is known where it is needed.
_Side = tuple[int, bool]
_Known = frozenset[_Side]
_Place = tuple[int, _Known]


def _cost(tape: Tape) -> int:
    return sum(_COSTS.get(n.op, 1 if n.op in _CHEAP else _FUNCTION) for n in tape.nodes)


def _decided(tape: Tape, sides: frozenset[_Side]) -> Tape:
    """The tape with choices made on these sides."""
    writer = _Writer(tape, sides)
    results = writer.results(tape.results)
    return writer.builder.finished(tape.inputs, tape.outputs, results)


class _Writer:
    """Writes nodes as they are where some conditions are known to hold or not to hold."""

    def __init__(self, tape: Tape, sides: frozenset[_Side]) -> None:
        self.builder = TapeBuilder()
        self._nodes = tape.nodes
        self._sides = sides
        self._decided = _decided_below(tape)

    def results(self, wanted: Sequence[Sequence[int]]) -> list[list[int]]:
        """The results in the new tape, whose nodes keep their order."""
        needed = self._needed([(index, frozenset()) for row in wanted for index in row])
        written: dict[_Place, int] = {}
        for place in sorted(needed, key=lambda place: (place[0], sorted(place[1]))):
            written[place] = self._copied_node(place, [written[k] for k in needed[place]])
        return [[written[index, frozenset()] for index in row] for row in wanted]

    def _needed(self, waiting: list[_Place]) -> dict[_Place, list[_Place]]:
        """All nodes that these depend on, and what each of them needs."""
        needed: dict[_Place, list[_Place]] = {}
        while waiting:
            place = waiting.pop()
            if place not in needed:
                needed[place] = self._arguments(*place)
                waiting += needed[place]
        return needed

    def _relevant(self, index: int, facts: Mapping[int, bool]) -> _Known:
        """The facts that decide about choices which a node depends on."""
        below = self._decided[index]
        return frozenset((k, held) for k, held in facts.items() if k in below)

    def _arguments(self, index: int, known: _Known) -> list[_Place]:
        """The nodes that are needed for one, each with what is known there."""
        node, facts = self._nodes[index], dict(known)
        if node.op not in ("select", "keep"):
            return [(k, self._relevant(k, facts)) for k in node.args]
        condition = node.args[0]
        if condition in facts:
            if node.op == "keep" and not facts[condition]:
                return []
            chosen = node.args[1 if facts[condition] else 2]
            return [(chosen, self._relevant(chosen, facts))]
        sides = zip(node.args[1:], (True, False), strict=False)
        return [
            (condition, self._relevant(condition, facts)),
            *(
                (
                    k,
                    self._relevant(
                        k, facts | {condition: held} if self._allows(condition, held) else facts
                    ),
                )
                for k, held in sides
            ),
        ]

    def _allows(self, condition: int, held: bool) -> bool:
        return (condition, held) in self._sides

    def _copied_node(self, place: _Place, args: list[int]) -> int:
        index, known = place
        node = self._nodes[index]
        if node.op == "const":
            return self.builder.constant(node.value)
        if node.op == "input":
            return self.builder.input(*node.source)
        if node.op in ("select", "keep") and node.args[0] in dict(known):
            return args[0] if args else self.builder.constant(0.0)
        return self.builder.operation(node.op, *args)


def _decided_below(tape: Tape) -> list[frozenset[int]]:
    """For each node the conditions of the choices that it depends on, or is."""
    decided_below: list[frozenset[int]] = []
    for node in tape.nodes:
        below = frozenset[int]().union(*(decided_below[k] for k in node.args))
        if node.op in ("select", "keep"):
            below |= {node.args[0]}
        decided_below.append(below)
    return decided_below
