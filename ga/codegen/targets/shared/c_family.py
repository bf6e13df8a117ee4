"""What C and GLSL have in common: comments, declarations and stores around the statements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.shared.expressions import (
    Body,
    BranchStatement,
    Statement,
    component_name,
)
from motorcade.ga.codegen.targets.shared.text import WIDTH, call, wrapped


def comment(lines: Sequence[str]) -> str:
    """A comment of these lines."""
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */"])


def close_comment(lines: Sequence[str]) -> str:
    """The same without lines for its ends; lines are broken where they are too long."""
    return (
        "/* "
        + "\n * ".join(part for line in lines for part in wrapped(line, WIDTH - 3, ""))
        + " */"
    )


def operand_lines(kernel: Kernel) -> list[str]:
    """Which components the operands of a kernel have."""
    return [
        f"{side} {operand.name}: {' '.join(operand.components)}"
        for side, operands in (("in", kernel.inputs), ("out", kernel.outputs))
        for operand in operands
    ]


def declarations(body: Iterable[Statement], number: str, boolean: str) -> list[str]:
    """The statements as variables of a type, which may be qualified."""
    return [
        f"{boolean if statement.boolean else number} {statement.name} = {statement.expression};"
        for statement in body
    ]


def branching_declarations(
    body: Body, number: str, boolean: str, declared: tuple[str, ...] = ()
) -> list[str]:
    """The statements as constants of a type; values of choices are declared before the branch."""
    lines = []
    for item in body:
        if isinstance(item, BranchStatement):
            condition = item.condition.removeprefix("(").removesuffix(")")
            lines += [f"{number} {', '.join(item.names)};", f"if ({condition}) {{"]
            for part in (item.chosen, item.otherwise):
                inside = branching_declarations(part, number, boolean, item.names)
                lines += [f"    {line}" for line in inside]
                lines += ["} else {" if part is item.chosen else "}"]
        elif item.name in declared:
            lines.append(f"{item.name} = {item.expression};")
        else:
            lines += declarations([item], f"const {number}", f"const {boolean}")
    return lines


def loads(
    operand: Operand, tape: Tape, number: str, place: str = "{0}[{1}]", together: int = 4
) -> list[str]:
    """The components of an array that are read as variables of a type, as the statements name
    them, so many in a line; `place` says where one is, by the array's name and its index.
    """
    read = tape.components_read(operand.name)
    if not read:
        return [f"(void){operand.name};"]
    items = [
        f"{component_name(operand.name, i, operand.width)} = {place.format(operand.name, i)}"
        for i in read
    ]
    rows = [items[i : i + together] for i in range(0, len(items), together)]
    return [f"{number} {', '.join(row)};" for row in rows]


def array_slots(program: Program) -> list[tuple[str, str]]:
    """The outputs that have components, and the names of the arrays that they become."""
    outputs = program.tape.outputs
    return [(operand.name, f"out_{operand.name}") for operand in outputs if operand.components]


def array_parameters(program: Program, declared: str) -> list[str]:
    """One array for each output that has components; `declared` stands before its name."""
    outputs = program.tape.outputs
    return [f"{declared} out_{o.name}[{o.width}]" for o in outputs if o.components]


def array_stores(outputs: Sequence[Operand], results: Sequence[Sequence[str]]) -> list[str]:
    """The results into the arrays."""
    return [
        f"out_{operand.name}[{i}] = {value};"
        for operand, row in zip(outputs, results, strict=True)
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
