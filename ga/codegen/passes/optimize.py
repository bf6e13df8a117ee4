"""The optimiser: all passes in their order, each measured."""

from __future__ import annotations

import time
from collections.abc import Callable

from motorcade.ga.codegen.passes.divisions import as_reciprocals, with_quotients
from motorcade.ga.codegen.passes.expand import expanded
from motorcade.ga.codegen.passes.factor import factored
from motorcade.ga.codegen.passes.merge import merged
from motorcade.ga.codegen.passes.rebuild import folded_tape
from motorcade.ga.codegen.passes.stats import PassStats, count_operations
from motorcade.ga.codegen.passes.zeros import without_zeros
from motorcade.ga.codegen.tape import Tape

__all__ = ["PASSES", "optimized"]

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
)


def optimized(tape: Tape) -> tuple[Tape, tuple[PassStats, ...]]:
    """A tape of the same values with fewer operations, and what each pass did.

    Values agree to rounding wherever those of the given tape are real numbers. Components that are
    zero are left out of the outputs.

    Raises:
        ValueError: a divisor is zero whatever the inputs are.
    """
    done = []
    settled: dict[Callable[[Tape], Tape], Tape] = {}
    for name, apply in PASSES:
        start = time.perf_counter()
        # A pass leaves nothing to do for itself: where no other one changed the tape it is skipped.
        made = tape if settled.get(apply) is tape else apply(tape)
        settled[apply] = made
        milliseconds = 1e3 * (time.perf_counter() - start)
        done.append(PassStats(name, count_operations(tape), count_operations(made), milliseconds))
        tape = made
    return tape, tuple(done)
