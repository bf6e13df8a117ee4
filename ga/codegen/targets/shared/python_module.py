"""Python modules of one function around the statements: NumPy, torch and CasADi."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from motorcade.ga.codegen.expressions import Statement
from motorcade.ga.codegen.program import Program
from motorcade.ga.codegen.targets.shared.templates import Templates
from motorcade.ga.codegen.targets.shared.text import WIDTH, call, wrapped

__all__ = ["ArrayTemplates", "assignments", "listed", "module", "nested_results"]

_LITERAL = re.compile(r"-?[0-9.]+(e[+-]?[0-9]+)?")


class ArrayTemplates(Templates):
    """Numbers among the arguments of functions become arrays of the type computed in.

    In sums and products plain numbers take the type of the other side; functions of numbers alone
    would give float64.
    """

    def call(self, op: str, args: list[str]) -> str:
        """The operation's template with its arguments, or the call of its function."""
        return super().call(op, [f"_number({a})" if _LITERAL.fullmatch(a) else a for a in args])


def module(
    program: Program,
    told: Sequence[str],
    imported: str,
    parameters: Sequence[str],
    summary: str,
    body: Sequence[str],
) -> str:
    """The text of a module that imports one package and has one function."""
    head = call(f"def {program.name}", parameters, ":")
    lines = [f'"""{told[0]}', *(line.rstrip() for line in told[1:]), '"""']
    lines += ["# fmt: off", "", imported, "", f'__all__ = ["{program.name}"]', "", ""]
    lines += [*head, f'    """{summary}"""']
    lines += [f"    {line}" for line in body]
    return "\n".join(lines) + "\n"


def assignments(body: Iterable[Statement]) -> list[str]:
    """The statements as assignments; long ones stand in brackets over several lines."""
    lines: list[str] = []
    for statement in body:
        lines += assigned(statement.name, statement.expression)
    return lines


def assigned(name: str, expression: str) -> list[str]:
    """One assignment."""
    line = f"{name} = {expression}"
    if len(line) <= WIDTH - 8:
        return [line]
    return [f"{name} = (", *(f"    {part}" for part in wrapped(expression, WIDTH - 12)), ")"]


def listed(line: str) -> list[str]:
    """A line that has a list in brackets."""
    return wrapped(line, WIDTH - 8)


def nested_results(program: Program, results: Sequence[Sequence[str]]) -> list[str]:
    """``return`` of a dictionary of dictionaries: outputs by name, their blades by name."""
    lines = ["return {"]
    for operand, row in zip(program.tape.outputs, results, strict=True):
        if not row:
            lines.append(f'    "{operand.name}": {{}},')
            continue
        lines.append(f'    "{operand.name}": {{')
        for blade, value in zip(operand.components, row, strict=True):
            entry = f'        "{blade}": _full({value}),'
            lines += wrapped(entry, WIDTH - 8, " " * 12)
        lines.append("    },")
    return [*lines, "}"]
