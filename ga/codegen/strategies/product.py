"""The strategy ``product``: one straight-line function a product and pair of operand types.

A type is a set of blades, as in libvsr, whose templates find the type and the terms of a product
from the types of its operands. Nothing is shared between the functions and no result is simplified
with what is known about another: that is left to the C compiler, as it is with templates.

`CallWriter` is what `table` shares: C that does one call an operation on multivectors. Numbers are
C numbers, and a step whose operands and result are scalars is an expression.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from motorcade.ga.algebra.basis import grade_of
from motorcade.ga.algebra.products import PRODUCTS, Masks
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.record import Record, Step, record
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.c import c_dialect, c_files
from motorcade.ga.codegen.targets.names import C_NAMES, check_names
from motorcade.ga.codegen.targets.shared import c_family
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.codegen.targets.shared.expressions import Dialect, statements
from motorcade.ga.codegen.targets.shared.text import description
from motorcade.ga.script import Script

# How C joins two scalars; of other operations on one nothing is left but its sign.
_INFIX = {"add": "+", "sub": "-"} | dict.fromkeys(("geometric", "outer", "left", "right"), "*")
# Signs of blades by their grade, for each operation that only changes signs.
SIGNS: dict[str, Callable[[int], int]] = {
    "negate": lambda grade: -1,
    "reverse": lambda grade: -1 if grade % 4 in (2, 3) else 1,
    "involute": lambda grade: -1 if grade % 2 else 1,
    "conjugate": lambda grade: -1 if grade % 4 in (1, 2) else 1,
}


def files(
    writer: type[CallWriter],
    strategy: str,
    script: Script,
    program: Program,
    precision: Precision | None,
) -> dict[str, str]:
    """Source and header; the function takes and gives what the script's program does."""
    real = precision or DOUBLE
    check_names(program, C_NAMES, c_family.array_slots(program))
    variables = [operand.name for operand in program.tape.inputs]
    call_writer = writer(
        record(script, program.algebra, variables), program.name, real, c_dialect(real)
    )
    parameters = [f"{real.c} {variable}" for variable in variables]
    head = c_family.function(
        program.name, [*parameters, *c_family.array_parameters(program, real.c)], "void"
    )
    described = description(program, f"c --strategy {strategy} --precision {real.numpy}")
    steps = _steps(program, call_writer)
    defined = "\n\n".join([*call_writer.definitions(), steps, head])
    return c_files(
        program.name, described, head, defined, c_family.indented([_call(program, call_writer)])
    )


def _inner(program: Program) -> str:
    """The name of the function with all steps: none of the variables may hide it."""
    taken = {operand.name for operand in program.tape.inputs}
    name = f"{program.name}_steps"
    while name in taken:
        name += "_"
    return name


def _steps(program: Program, call_writer: CallWriter) -> str:
    """All steps, in a function without any name of the script."""
    outputs = [operand for operand in program.tape.outputs if operand.components]
    body = [*call_writer.steps(), *call_writer.stores(outputs)]
    if not any("in[" in line for line in body):
        body.insert(0, "(void)in;")
    parameters = [
        f"const {call_writer.real} *in",
        *(f"{call_writer.real} *out{k}" for k in range(len(outputs))),
    ]
    head = f"static {c_family.function(_inner(program), parameters, 'void')}"
    return "\n".join([head, "{", *c_family.indented(body), "}"])


def _call(program: Program, call_writer: CallWriter) -> str:
    variables = ", ".join(operand.name for operand in program.tape.inputs) or "0"
    outputs = [f"out_{operand.name}" for operand in program.tape.outputs if operand.components]
    arguments = [f"(const {call_writer.real}[]){{{variables}}}", *outputs]
    return f"{_inner(program)}({', '.join(arguments)});"


class CallWriter(ABC):
    """Writes a record as C statements, and collects the definitions that these need.

    Every name at file scope begins with the program's own, and no name of the script occurs in the
    statements: nothing can collide with what a script calls its variables.
    """

    def __init__(self, record: Record, name: str, precision: Precision, dialect: Dialect) -> None:
        self.record = record
        self.algebra = record.algebra
        self.name = name
        self.real = precision.c
        self.dialect = dialect
        self._taken: set[str] = set()
        self._inputs = {variable: f"in[{k}]" for k, variable in enumerate(record.inputs)}

    @abstractmethod
    def definitions(self) -> list[str]:
        """Types, tables and functions that the statements written so far use."""

    @abstractmethod
    def given(self, masks: Masks, values: list[str]) -> str:
        """The initialiser of a multivector by its coefficients."""

    @abstractmethod
    def call(self, step: Step) -> str:
        """The expression of an operation on multivectors: a scalar where the step is one."""

    @abstractmethod
    def type_of(self, masks: Masks) -> str:
        """The type of multivectors with these blades."""

    @abstractmethod
    def coefficient(self, number: int, mask: int) -> str:
        """One coefficient of the result of a step that is no scalar."""

    def steps(self) -> list[str]:
        """The lines of all steps."""
        return [
            line for number, step in self.record.steps.items() for line in self._step(number, step)
        ]

    def stores(self, outputs: Sequence[Operand]) -> list[str]:
        """The lines that store the blades of the outputs in ``out0``, ``out1``, ….

        A record may know of a blade that it cancels where the program does not.
        """
        lines = []
        for k, output in enumerate(outputs):
            number = self.record.outputs[output.name]
            for i, blade in enumerate(output.components):
                ((mask, _),) = self.algebra.masks_of(blade)
                there = number is not None and mask in self.record.steps[number].masks
                value = self.read(number, mask) if number is not None and there else "0"
                lines.append(f"out{k}[{i}] = {value};")
        return lines

    def read(self, number: int, mask: int) -> str:
        """One coefficient of a step's result."""
        if self.record.steps[number].is_scalar:
            return f"s{number}"
        return self.coefficient(number, mask)

    def _step(self, number: int, step: Step) -> list[str]:
        if step.op == "given":
            return self._given(number, step)
        if step.is_scalar and all(self.record.steps[k].is_scalar for k in step.args):
            return [f"const {self.real} s{number} = {_scalar_expression(step)};"]
        return [self._declaration(number, step, self.call(step))]

    def _declaration(self, number: int, step: Step, value: str) -> str:
        if step.is_scalar:
            return f"const {self.real} s{number} = {value};"
        return f"const {self.type_of(step.masks)} v{number} = {value};"

    def _given(self, number: int, step: Step) -> list[str]:
        """A multivector by its coefficients; what they share has a name of its own."""
        texts = {
            name: self._inputs[name] if read is None else self.read(*read)
            for name, read in self.record.reads(step).items()
        }
        out = Operand("out", tuple(map(self.algebra.blade_name, step.masks)))
        tape = self.record.scalars.tape(step.scalars, out, texts)
        written = statements(tape, self.dialect, frozenset(self._taken))
        self._taken.update(statement.name for statement in written.body)
        lines = []
        for statement in written.body:
            kind = "_Bool" if statement.boolean else self.real
            lines.append(f"const {kind} {statement.name} = {statement.expression};")
        values = list(written.results[0])
        value = values[0] if step.is_scalar else self.given(step.masks, values)
        return [*lines, self._declaration(number, step, value)]


def _scalar_expression(step: Step) -> str:
    names = [f"s{number}" for number in step.args]
    if step.op in _INFIX:
        return f" {_INFIX[step.op]} ".join(names)
    return f"-{names[0]}" if step.op == "negate" else names[0]


def write(script: Script, program: Program, precision: Precision | None) -> dict[str, str]:
    """Names and texts of the source and the header of a script; `program` is what it compiles to.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    return files(_ProductWriter, "product", script, program, precision)


class _ProductWriter(CallWriter):
    """Writes calls of functions made for the types of their operands, which go by value."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._types: dict[Masks, str] = {}
        self._functions: dict[str, str] = {}

    def type_of(self, masks: Masks) -> str:
        """The type of a set of blades, defined when first asked for; scalars are numbers."""
        if masks == (0,):
            return self.real
        if masks not in self._types:
            self._types[masks] = f"{self.name}_mv{len(self._types) + 1}"
        return self._types[masks]

    def coefficient(self, number: int, mask: int) -> str:
        """By its place among the blades of the type."""
        return f"v{number}.c[{self.record.steps[number].masks.index(mask)}]"

    def given(self, masks: Masks, values: list[str]) -> str:
        """The coefficients in their order."""
        return f"{{{{{', '.join(values)}}}}}"

    def call(self, step: Step) -> str:
        """A call of the function of these types, which is written when first called."""
        sides = [self.record.steps[number].masks for number in step.args]
        types = [
            self.type_of(masks).removeprefix(f"{self.name}_") for masks in (*sides, step.masks)
        ]
        function = f"{self.name}_{step.op}_{'_'.join(types[:-1])}_to_{types[-1]}"
        if function not in self._functions:
            self._functions[function] = self._function(function, step, sides)
        operands = (f"s{k}" if self.record.steps[k].is_scalar else f"v{k}" for k in step.args)
        return f"{function}({', '.join(operands)})"

    def definitions(self) -> list[str]:
        """All types and functions."""
        types = [
            f"typedef struct {{ {self.real} c[{len(masks)}]; }} {name};"
            f" /* {' '.join(map(self.algebra.blade_name, masks))} */"
            for masks, name in self._types.items()
        ]
        return ["\n".join(types), *self._functions.values()]

    def _function(self, name: str, step: Step, sides: list[Masks]) -> str:
        letters = "ab"[: len(sides)]
        arguments = (
            f"const {self.type_of(masks)} {letter}"
            for letter, masks in zip(letters, sides, strict=True)
        )
        values = [self._value(step, sides, mask) for mask in step.masks]
        kind = self.type_of(step.masks)
        lines = [f"static inline {kind} {name}({', '.join(arguments)})", "{"]
        if step.is_scalar:
            lines += indented([f"return {values[0]};"])
        else:
            lines += [f"    return ({kind}){{{{"]
            lines += indented([f"{value}," for value in values], 2)
            lines += ["    }};"]
        return "\n".join([*lines, "}"])

    def _value(self, step: Step, sides: list[Masks], mask: int) -> str:
        """One coefficient of the result, as an expression of those of the operands."""
        if step.op in PRODUCTS:
            plan = self.algebra.plan(step.op, sides[0], sides[1])
            return self._sum_of_terms(plan.terms[plan.masks.index(mask)], sides)
        if step.op in ("add", "sub"):
            left, right = (
                _place(letter, masks, masks.index(mask)) if mask in masks else ""
                for letter, masks in zip("ab", sides, strict=True)
            )
            sign = "+" if step.op == "add" else "-"
            if left and right:
                return f"{left} {sign} {right}"
            return left or right if step.op == "add" or left else f"-{right}"
        place = _place("a", sides[0], sides[0].index(mask))
        negative = step.op != "part" and SIGNS[step.op](grade_of(mask)) < 0
        return f"-{place}" if negative else place

    def _sum_of_terms(self, terms: tuple[tuple[float, int, int], ...], sides: list[Masks]) -> str:
        text = ""
        for factor, i, j in terms:
            size = "" if abs(factor) == 1.0 else f"{self.dialect.constant(abs(factor))} * "
            term = f"{size}{_place('a', sides[0], i)} * {_place('b', sides[1], j)}"
            joint = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += joint + term
        return text


def _place(letter: str, masks: Masks, index: int) -> str:
    return letter if masks == (0,) else f"{letter}.c[{index}]"
