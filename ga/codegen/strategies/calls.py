"""C that does one call an operation on multivectors: what `table` and `product` have in common.

Numbers are C numbers in both, and functions of numbers are C's: a step whose operands and result
are scalars is an expression. Everything else is a call of what the strategy defines.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

from motorcade.ga.algebra.products import Masks
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.record import Record, Step, record
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.c import c_dialect, c_files
from motorcade.ga.codegen.targets.names import C_NAMES, check_names
from motorcade.ga.codegen.targets.shared import c_family
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
