"""The optimiser: all passes in their order, each measured."""

from __future__ import annotations

import time
from collections.abc import Callable

from motorcade.ga.codegen.passes.divisions import as_reciprocals, with_quotients
from motorcade.ga.codegen.passes.expand import expanded
from motorcade.ga.codegen.passes.factor import factored
from motorcade.ga.codegen.passes.merge import merged
from motorcade.ga.codegen.passes.rebuild import folded_tape, with_single_differences
from motorcade.ga.codegen.passes.stats import PassStats, count_operations
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder

# Passes that search, and in more than linear time: tapes of more nodes go past them.
_SEARCHES = frozenset({expanded, factored})
LONGEST_SEARCHED = 20_000


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


PASSES: tuple[tuple[str, Callable[[Tape], Tape]], ...] = (
    ("fold constants", folded_tape),
    ("share reciprocals", as_reciprocals),
    ("merge equal nodes", merged),
    ("drop zeros", without_zeros),
    ("collect like terms", expanded),
    ("merge equal nodes", merged),
    ("drop zeros", without_zeros),
    ("factor", factored),
    ("single quotients", with_quotients),
    ("single differences", with_single_differences),
)


def optimized(tape: Tape) -> tuple[Tape, tuple[PassStats, ...]]:
    """A tape of the same values with fewer operations, and what each pass did.

    Values agree to rounding wherever those of the given tape are real numbers. Components that are
    zero are left out of the outputs. Tapes of more than `LONGEST_SEARCHED` nodes are not searched
    for like terms and common factors.

    Raises ValueError: a divisor is zero whatever the inputs are.
    """
    done = []
    settled: dict[Callable[[Tape], Tape], Tape] = {}
    for name, apply in PASSES:
        start = time.perf_counter()
        skipped = apply in _SEARCHES and len(tape.nodes) > LONGEST_SEARCHED
        # A pass leaves nothing to do for itself where no other one changed the tape.
        improved = tape if skipped or settled.get(apply) is tape else apply(tape)
        settled[apply] = improved
        spent = 1e3 * (time.perf_counter() - start)
        counts = count_operations(tape), count_operations(improved)
        done.append(PassStats(name, *counts, spent, skipped))
        tape = improved
    return tape, tuple(done)
