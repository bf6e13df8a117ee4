"""Text that every target writes: the description of a program, and lines that fit the page."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from motorcade.ga.codegen.program import Program

__all__ = ["WIDTH", "call", "description", "wrapped"]

WIDTH = 100


def description(program: Program, target: str) -> list[str]:
    """Lines for the comment on top: inputs, outputs and blades in their order.

    They hold names that are checked identifiers, and nothing else from the script.
    """
    names, signature = " ".join(program.algebra.names), program.algebra.signature
    inputs = " ".join(operand.name for operand in program.tape.inputs)
    lines = [
        f"{program.name}: written by `motorcade generate --target {target}`.",
        "",
        f"Algebra: basis {names}, signature {signature}.",
        f"Inputs, in this order: {inputs or 'none'}.",
        "Outputs, in this order, each with its blades in this order:",
    ]
    for operand in program.tape.outputs:
        lines.append(f"    {operand.name}: {' '.join(operand.components) or 'none, it is zero'}")
    return [part for line in lines for part in wrapped(line, WIDTH - 4, "        ")]


def wrapped(text: str, width: int, continued: str = "    ") -> list[str]:
    """One line of text as lines no wider than `width`, where spaces allow."""
    first = text[: len(text) - len(text.lstrip())]
    return textwrap.wrap(
        text.strip(), width, initial_indent=first, subsequent_indent=continued,
        break_long_words=False, break_on_hyphens=False,
    ) or [""]  # fmt: skip


def call(before: str, items: Sequence[str], after: str) -> list[str]:
    """``before(item, …)after`` as lines that break between the items only."""
    kept = ", ".join(item.replace(" ", "\0") for item in items)
    line = before.replace(" ", "\0") + f"({kept}){after}"
    return [part.replace("\0", " ") for part in wrapped(line, WIDTH, " " * 8)]
