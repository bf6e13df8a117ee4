"""C that does one call an operation on multivectors: what `table` and `product` have in common.

Numbers are C numbers in both, and functions of numbers are C's: a step whose operands and result
are scalars is an expression. Everything else is a call of what the strategy defines.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

from motorcade.ga.algebra.products import Masks
from motorcade.ga.codegen.expressions import Dialect, statements
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.strategies.record import Record, Step
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.trace import tape_of

__all__ = ["SIGNS", "CallWriter"]

_INFIX = {"add": "+", "sub": "-", "geometric": "*", "outer": "*"}
# Signs of blades by their grade, for each operation that only changes signs.
SIGNS: dict[str, Callable[[int], int]] = {
    "negate": lambda grade: -1,
    "reverse": lambda grade: -1 if grade % 4 in (2, 3) else 1,
    "involute": lambda grade: -1 if grade % 2 else 1,
    "conjugate": lambda grade: -1 if grade % 4 in (1, 2) else 1,
}


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
        """The lines that store the blades of the outputs in ``out0``, ``out1``, …."""
        lines = []
        for k, output in enumerate(outputs):
            number = self.record.outputs[output.name]
            for i, blade in enumerate(output.components):
                if number is None:
                    raise AssertionError(f"{output.name} vanishes, and has no {blade}")
                ((mask, _),) = self.algebra.masks_of(blade)
                lines.append(f"out{k}[{i}] = {self.read(number, mask)};")
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
        symbols = [symbol for symbol, _ in step.reads]
        texts = [
            self._inputs[symbol.name()] if read is None else self.read(*read)
            for symbol, read in step.reads
        ]
        operands = tuple(Operand(text, ("1",)) for text in texts)
        out = Operand("out", tuple(map(self.algebra.blade_name, step.masks)))
        tape = tape_of(self.name, operands, (out,), symbols, [step.scalars])
        written = statements(tape, self.dialect, frozenset(self._taken))
        self._taken.update(statement.name for statement in written.body)
        lines = []
        for statement in written.body:
            kind = "_Bool" if statement.boolean else self.real
            lines.append(f"const {kind} {statement.name} = {statement.expression};")
        values = list(written.results[0])
        made = values[0] if step.is_scalar else self.given(step.masks, values)
        return [*lines, self._declaration(number, step, made)]


def _scalar_expression(step: Step) -> str:
    names = [f"s{number}" for number in step.args]
    if step.op in _INFIX:
        return f" {_INFIX[step.op]} ".join(names)
    return f"-{names[0]}" if step.op == "negate" else names[0]
