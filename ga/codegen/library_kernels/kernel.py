"""What a kernel is to the generator: its name, what it takes and gives, and its definition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from motorcade.ga.codegen.library_kernels.like_terms import collected
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.trace import casadi_function, trace

__all__ = ["NOTE", "Kernel"]

NOTE = "Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those."


@dataclass(frozen=True)
class Kernel:
    """A function of one row, applied to batches by the code that is written from it.

    `define` takes the precision and a list of scalars for each input, and returns a list of
    scalars for each output. `group` names the file that its code goes to. The first line of the
    docstring of `define` is the summary, unless another is given.

    >>> from motorcade.ga.codegen.library_kernels.kernel import Kernel
    >>> from motorcade.ga.codegen.precision import DOUBLE
    >>> from motorcade.ga.codegen.tape import Operand
    >>> def twice(precision, x):
    ...     'Twice the number.'
    ...     return [[2 * x[0]]]
    >>> kernel = Kernel("twice", "tests", (Operand("x", ("x",)),), (Operand("out", ("x",)),), twice)
    >>> kernel.summary, kernel.tape(DOUBLE).operations()
    ('Twice the number', {'mul': 1})
    """

    name: str
    group: str
    inputs: tuple[Operand, ...]
    outputs: tuple[Operand, ...]
    define: Callable[..., Sequence[Sequence[Any]]]
    summary: str = ""

    def __post_init__(self) -> None:
        if not self.summary:
            first = (self.define.__doc__ or "").partition("\n")[0]
            object.__setattr__(self, "summary", first.removesuffix("."))

    def tape(self, precision: Precision) -> Tape:
        """The operations of the kernel in a precision."""
        define = self._bound(precision)
        traced = trace(self.name, self.inputs, self.outputs, define, powers_of_two=True)
        return collected(traced)

    def casadi(self, precision: Precision) -> Any:
        """The kernel as a CasADi function, for derivatives and as a witness."""
        return casadi_function(self.name, self.inputs, self.outputs, self._bound(precision))

    def _bound(self, precision: Precision) -> Callable[..., Sequence[Sequence[Any]]]:
        return lambda *inputs: self.define(precision, *inputs)
