"""Python modules of one function around the statements: NumPy, torch and CasADi."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import Reserved, check_names
from motorcade.ga.codegen.targets.shared.expressions import Statement, statements
from motorcade.ga.codegen.targets.shared.text import (
    COMPARISONS,
    WIDTH,
    Templates,
    call,
    description,
    variables,
    wrapped,
)

_LITERAL = re.compile(r"-?[0-9.]+(e[+-]?[0-9]+)?")


class ArrayTemplates(Templates):
    """Numbers among the arguments of functions become arrays of the type computed in.

    In sums and products plain numbers take the type of the other side; functions of numbers alone
    would give float64. `number` makes the arrays, for the operations `typed` or, if None, for all.
    """

    def __init__(
        self,
        templates: Mapping[str, str],
        calls: Mapping[str, str],
        precision: Precision | None,
        *,
        prefix: str,
        number: str = "_number",
        typed: Sequence[str] | None = None,
    ) -> None:
        super().__init__(templates, calls, precision, prefix=prefix)
        self._number = number
        self._typed = typed

    def call(self, op: str, args: list[str]) -> str:
        """The operation's template with its arguments, or the call of its function."""
        if self._typed is None or op in self._typed:
            args = [f"{self._number}({a})" if _LITERAL.fullmatch(a) else a for a in args]
        return super().call(op, args)


@dataclass(frozen=True)
class ArrayLibrary:
    """A library of arrays as a target: what it calls the operations, and names that a module uses.

    `opening` gives the first lines of a function from its name, its variables and a precision;
    they define ``_number`` and ``_full``. The lines after them stand in the block `within`.
    """

    target: str
    imported: str
    prefix: str
    functions: Mapping[str, str]
    names: Reserved
    summary: str
    opening: Callable[[str, list[str], Precision | None], list[str]]
    within: str = ""


def array_module(
    program: Program, precision: Precision | None, library: ArrayLibrary
) -> dict[str, str]:
    """The module of a program in terms of a library."""
    check_names(program, library.names)
    dialect = ArrayTemplates(COMPARISONS, library.functions, precision, prefix=library.prefix)
    written = statements(program.tape, dialect, library.names.words)
    parameters = variables(program)
    opening = library.opening(program.name, parameters, precision)
    body = [*assignments(written.body), *nested_results(program, written.results)]
    if library.within:
        body = [library.within, *(f"    {line}" for line in body)]
    option = f" --precision {precision.numpy}" if precision else ""
    described = description(program, library.target + option)
    return module(
        program, described, library.imported, parameters, library.summary, [*opening, *body]
    )


def module(
    program: Program,
    described: Sequence[str],
    imported: str,
    parameters: Sequence[str],
    summary: str,
    body: Sequence[str],
) -> dict[str, str]:
    """A module that imports one package and has one function, by its file's name."""
    lines = [f'"""{described[0]}', *described[1:], '"""', "# fmt: off", "", imported, ""]
    lines += [f'__all__ = ["{program.name}"]', "", ""]
    lines += [*call(f"def {program.name}", parameters, ":"), f'    """{summary}"""']
    lines += [f"    {line}" for line in body]
    text = "\n".join(lines) + "\n"
    ast.parse(text)  # what is handed out is Python, whatever names and lengths did to its lines
    return {f"{program.name}.py": text}


def assignments(body: Iterable[Statement], lead: int = 8) -> list[str]:
    """The statements as assignments `lead` spaces deep; long ones stand in brackets."""
    lines: list[str] = []
    for statement in body:
        name, expression = statement.name, statement.expression
        if len(name) + len(expression) + 3 <= WIDTH - lead:
            lines.append(f"{name} = {expression}")
        else:
            parts = wrapped(expression, WIDTH - lead - 4)
            lines += [f"{name} = (", *(f"    {part}" for part in parts), ")"]
    return lines


def listed(line: str) -> list[str]:
    """A statement with a list, as lines that break within its brackets only: else it would end."""
    before, bracket, rest = line.partition("[")
    inside, closing, after = rest.rpartition("]")
    kept = before.replace(" ", "\0") + bracket + inside + closing + after.replace(" ", "\0")
    return [part.replace("\0", " ") for part in wrapped(kept, WIDTH - 8)]


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
