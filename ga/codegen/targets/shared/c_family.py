"""What C and GLSL have in common: comments, declarations and stores around the statements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from motorcade.ga.codegen.expressions import Statement, component_name
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.shared.text import WIDTH, call, wrapped

__all__ = [
    "array_parameters",
    "array_slots",
    "array_stores",
    "comment",
    "declarations",
    "function",
    "indented",
    "loads",
]


def comment(lines: Sequence[str]) -> str:
    """A comment of these lines."""
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */"])


def declarations(body: Iterable[Statement], number: str, boolean: str) -> list[str]:
    """The statements as variables of a type, which may be qualified."""
    return [
        f"{boolean if statement.boolean else number} {statement.name} = {statement.expression};"
        for statement in body
    ]


def loads(operand: Operand, tape: Tape, number: str) -> list[str]:
    """The components of an array that are read as variables of a type, as the statements name
    them; an operand of one number has its name already.
    """
    read = tape.components_read(operand.name)
    if operand.width == 1 or not read:
        return [] if read else [f"(void){operand.name};"]
    items = [
        f"{component_name(operand.name, i, operand.width)} = {operand.name}[{i}]" for i in read
    ]
    return [f"{number} {', '.join(items[i : i + 4])};" for i in range(0, len(items), 4)]


def array_slots(program: Program) -> list[tuple[str, str]]:
    """The outputs that have components, and the names of the arrays that they become."""
    outputs = program.tape.outputs
    return [(operand.name, f"out_{operand.name}") for operand in outputs if operand.components]


def array_parameters(program: Program, declared: str) -> list[str]:
    """One array for each output that has components; `declared` stands before its name."""
    outputs = program.tape.outputs
    return [f"{declared} out_{o.name}[{o.width}]" for o in outputs if o.components]


def array_stores(program: Program, results: Sequence[Sequence[str]]) -> list[str]:
    """The results into the arrays."""
    return [
        f"out_{operand.name}[{i}] = {value};"
        for operand, row in zip(program.tape.outputs, results, strict=True)
        for i, value in enumerate(row)
    ]


def function(name: str, parameters: Sequence[str], nothing: str) -> str:
    """The head of a function without result; `nothing` stands for no parameters."""
    return "\n".join(call(f"void {name}", parameters or [nothing], ""))


def indented(lines: Iterable[str], depth: int = 1) -> list[str]:
    """Lines inside `depth` blocks; what does not fit goes on deeper than its line begins."""
    lead = "    " * depth
    return [
        lead + part
        for line in lines
        for part in wrapped(line, WIDTH - len(lead), line[: -len(line.lstrip())] + "    ")
    ]
