"""What a pass did: operations before and after it, by kind, and the time it took."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from motorcade.ga.codegen.tape import Tape

_KINDS = {"add": 0, "sub": 0, "mul": 1, "div": 2} | dict.fromkeys(
    ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2"), 3
)


_DIVISION = 4


@dataclass(frozen=True)
class Operations:
    """How many operations a tape has; `transcendental` counts square roots too."""

    additions: int
    multiplications: int
    divisions: int
    transcendental: int


@dataclass(frozen=True)
class PassStats:
    """One pass: its name, the operations before and after it, and its milliseconds.

    `skipped` where it was left out because the tape is too long for it.
    """

    name: str
    before: Operations
    after: Operations
    milliseconds: float
    skipped: bool = False


def count_operations(tape: Tape) -> Operations:
    """The operations of a tape. Signs, choices, comparisons and roundings are not counted."""
    counts = [0, 0, 0, 0]
    for node in tape.nodes:
        kind = _KINDS.get(node.op)
        if kind is not None:
            counts[kind] += 1
    return Operations(*counts)


def cost_of(tape: Tape) -> int:
    """What passes weigh tapes by: operations, a division counted as much as four of the others."""
    counts = count_operations(tape)
    return counts.additions + counts.multiplications + _DIVISION * counts.divisions


def table_of_passes(passes: Sequence[PassStats]) -> str:
    """The passes as lines of text: operations after each, first those it all began with."""
    lines = [f"{'pass':<24}{'add':>7}{'mul':>7}{'div':>7}{'func':>7}{'ms':>9}"]
    if passes:
        lines.append(_row("traced", passes[0].before) + f"{'':>9}")
    for done in passes:
        spent = "skipped" if done.skipped else f"{done.milliseconds:.2f}"
        lines.append(_row(done.name, done.after) + f"{spent:>9}")
    if any(done.skipped for done in passes):
        lines.append("skipped: too many operations for this pass")
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _row(name: str, counts: Operations) -> str:
    return (
        f"{name:<24}{counts.additions:>7}{counts.multiplications:>7}"
        f"{counts.divisions:>7}{counts.transcendental:>7}"
    )
