"""What every target writes: operations from templates, a description on top, lines that fit."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.shared.expressions import Dialect, component_name

# Operations that most languages call by their name here.
SAME_NAMES = {
    name: name
    for name in ("sqrt", "floor", "ceil", "exp", "log", "sin", "cos", "tan", "asin", "acos",
                 "atan", "atan2")
}  # fmt: skip
COMPARISONS = {"lt": "({} < {})", "le": "({} <= {})", "eq": "({} == {})", "ne": "({} != {})"}
C_LOGIC = COMPARISONS | {
    "and": "({} && {})", "or": "({} || {})", "not": "(!{})", "select": "({} ? {} : {})",
}  # fmt: skip
WIDTH = 100


class Templates(Dialect):
    """A dialect of `calls`, names of functions, and `templates` for what is written otherwise.

    `prefix` and `suffix` stand around the functions' names, the suffix behind numbers too. Numbers
    are printed in the precision given, in float64 where there is none.
    """

    def __init__(
        self,
        templates: Mapping[str, str],
        calls: Mapping[str, str],
        precision: Precision | None = None,
        *,
        prefix: str = "",
        suffix: str = "",
    ) -> None:
        self._templates = templates
        self._calls = calls
        self._type = np.dtype(precision.numpy if precision else "float64").type
        self._prefix = prefix
        self._suffix = suffix

    def constant(self, value: float) -> str:
        """The number. Raises ValueError: it is too large for the precision."""
        with np.errstate(over="ignore"):
            rounded = self._type(value)
        if not np.isfinite(rounded):
            raise ValueError(
                f"expected numbers that {np.dtype(self._type)} can hold, got {value!r}; "
                "write the code in float64"
            )
        return str(rounded) + self._suffix

    def call(self, op: str, args: list[str]) -> str:
        """The operation's template with its arguments, or the call of its function."""
        if op == "keep":
            return self.call("select", [*args, self.constant(0.0)])
        if op in self._templates:
            return self._templates[op].format(*args)
        return f"{self._prefix}{self._calls[op]}{self._suffix}({', '.join(args)})"


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
