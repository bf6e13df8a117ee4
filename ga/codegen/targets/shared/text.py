"""Text that every target writes: the description of a program, and lines that fit the page."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from motorcade.ga.codegen.expressions import component_name
from motorcade.ga.codegen.programs import Program

__all__ = ["WIDTH", "call", "description", "unread", "variables", "wrapped"]

WIDTH = 100


def description(program: Program, target: str) -> list[str]:
    """Lines for the comment on top: inputs, outputs and blades in their order.

    They hold names that are checked identifiers, and nothing else from the script.
    """
    names, signature = " ".join(program.algebra.names), program.algebra.signature
    lines = [
        f"{program.name}: written by `motorcade generate --target {target}`.",
        "",
        f"Algebra: basis {names}, signature {signature}.",
        f"Inputs, in this order: {' '.join(variables(program)) or 'none'}.",
        *(f"    {o.name}: {' '.join(o.components)}" for o in program.tape.inputs if o.width > 1),
        "Outputs, in this order, each with its blades in this order:",
    ]
    for operand in program.tape.outputs:
        lines.append(f"    {operand.name}: {' '.join(operand.components) or 'none, it is zero'}")
    return [part for line in lines for part in wrapped(line, WIDTH - 4, "        ")]


def variables(program: Program) -> list[str]:
    """The parameters: one for each component of each input, numbered where there are several."""
    return [name for _, _, name in _components(program)]


def unread(program: Program) -> list[str]:
    """The parameters that nothing depends on."""
    read = {o.name: program.tape.components_read(o.name) for o in program.tape.inputs}
    return [name for operand, k, name in _components(program) if k not in read[operand]]


def _components(program: Program) -> list[tuple[str, int, str]]:
    return [
        (operand.name, k, component_name(operand.name, k, operand.width))
        for operand in program.tape.inputs
        for k in range(operand.width)
    ]


def wrapped(text: str, width: int, continued: str = "    ") -> list[str]:
    """One line of text as lines no wider than `width`, where spaces allow."""
    first = text[: len(text) - len(text.lstrip())]
    return textwrap.wrap(
        text.strip(),
        width,
        initial_indent=first,
        subsequent_indent=continued,
        break_long_words=False,
        break_on_hyphens=False,
    ) or [""]


def call(before: str, items: Sequence[str], after: str) -> list[str]:
    """``before(item, …)after`` as lines that break between the items only."""
    kept = ", ".join(item.replace(" ", "\0") for item in items)
    line = before.replace(" ", "\0") + f"({kept}){after}"
    return [part.replace("\0", " ") for part in wrapped(line, WIDTH, " " * 8)]
