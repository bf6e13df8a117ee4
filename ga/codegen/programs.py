"""Programs: CLUScripts, traced to the scalar operations that every target is written from."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.codegen.passes.optimize import optimized
from motorcade.ga.codegen.passes.stats import PassStats
from motorcade.ga.codegen.recording import recorded_symbols, tape_of, tape_of_symbols
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.script import Script, evaluate
from motorcade.ga.script.meaning import algebra_of, free_variables

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")


@dataclass(frozen=True)
class Program:
    """A script or a function, traced: real variables in, named multivectors out.

    The tape's inputs are one operand ``(variable, ("1",))`` a free variable, in the order of first
    use; its outputs have one component a blade, by grade and then in the order of the basis. No
    component is identically zero: an output of which nothing is left keeps its name and has no
    components. `passes` tells what the optimiser did.

    >>> from motorcade.ga.codegen.programs import compile_script
    >>> from motorcade.ga.script import parse
    >>> square = compile_script(parse("a = x*e1 + 2*e2; ?b = a*a;"), "square")
    >>> square.tape.operations(), [operand.name for operand in square.tape.outputs]
    ({'add': 1, 'mul': 1}, ['b'])
    """

    name: str
    algebra: Algebra
    tape: Tape
    passes: tuple[PassStats, ...]


def compile_script(script: Script, name: str, algebra: Algebra | None = None) -> Program:
    """A script as a program.

    Args:
        script: from `motorcade.ga.script.parse`.
        name: of the program, an identifier; the file's name without its suffix.
        algebra: CGA3 unless given here or by the script's algebra pragma.

    Raises:
        ScriptError: what `evaluate` refuses.
        ValueError: a name that is no identifier, a script without outputs, values that are not
            finite whatever the variables are.

    >>> from motorcade.ga.codegen.programs import compile_script
    >>> from motorcade.ga.codegen.targets import TARGETS
    >>> from motorcade.ga.script import parse
    >>> square = compile_script(parse("a = x*e1 + 2*e2; ?b = a*a;"), "square")
    >>> files = TARGETS["c"](square, None)
    >>> print(files["square.c"].partition("{")[2])
    <BLANKLINE>
        out_b[0] = x * x + 4.0;
    }
    <BLANKLINE>
    """
    checked_identifier(name, "name")
    chosen = algebra_of(script, algebra)
    free = [checked_identifier(variable, "variable") for variable in free_variables(script, chosen)]
    inputs = tuple(Operand(variable, ("1",)) for variable in free)
    symbols = symbols_of(inputs)
    symbol_of = {variable: symbol[0] for variable, symbol in zip(free, symbols, strict=True)}
    outputs = evaluate(script, algebra, **symbol_of)
    if not outputs:
        raise ValueError(f"{name}: expected a script with outputs, got none: mark them with ?")
    return program_of(name, chosen, inputs, symbols, outputs)


def symbols_of(inputs: Sequence[Operand]) -> list[Any]:
    """A vector of symbols for each input: CasADi's, which know more rules of algebra, if it is
    installed, otherwise ours.
    """
    if find_spec("casadi") is None:
        return list(recorded_symbols(inputs))
    import casadi as ca

    return [ca.SX.sym(operand.name, operand.width) for operand in inputs]


def checked_identifier(name: str, field: str) -> str:
    """The name, if it is one that generated code can carry.

    Raises ValueError: no ASCII identifier.
    """
    if not isinstance(name, str) or not _IDENTIFIER.fullmatch(name):
        raise ValueError(f"{field}: expected an identifier, got {name!a}")
    return name


def program_of(
    name: str,
    algebra: Algebra,
    inputs: tuple[Operand, ...],
    symbols: Sequence[Any],
    outputs: Mapping[str, Multivector],
) -> Program:
    """The program of multivectors over symbols; `symbols` has one vector of them an input."""
    operands, rows = [], []
    for output, multivector in outputs.items():
        kept = [(blade, value) for blade, value in multivector.items() if not _is_zero(value)]
        operands.append(Operand(output, tuple(blade for blade, _ in kept)))
        rows.append([value for _, value in kept])
    # Without inputs nothing tells whose symbols they are, and there are numbers alone.
    if not symbols or isinstance(symbols[0], list):
        tape = tape_of_symbols(inputs, tuple(operands), rows)
    else:
        tape = tape_of(name, inputs, tuple(operands), symbols, rows)
    _check_finite(name, tape)
    try:
        tape, passes = optimized(tape)
    except ValueError as refused:
        raise ValueError(f"{name}: {refused}") from refused
    return Program(name, algebra, tape, passes)


def _is_zero(value: Any) -> bool:
    return bool(value.is_zero()) if hasattr(value, "is_zero") else bool(value == 0.0)


def _check_finite(name: str, tape: Tape) -> None:
    for node in tape.nodes:
        if node.op == "const" and not math.isfinite(node.value):
            raise ValueError(f"{name}: expected finite values, got {node.value} for any variables")
