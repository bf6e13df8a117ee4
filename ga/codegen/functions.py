"""Programs written in Python: functions of multivectors, traced as scripts are."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga.algebra import CGA3, Algebra, Multivector
from motorcade.ga.codegen.expressions import component_name
from motorcade.ga.codegen.interpret import run_tape
from motorcade.ga.codegen.programs import Program, checked_identifier, program_of
from motorcade.ga.codegen.tape import Operand

_HINT = "both ways can be computed and one be chosen: motorcade.ga.algebra.functions.elementary"


@dataclass(frozen=True)
class CompiledFunction:
    """A function of multivectors and the program that was traced from it.

    Calling it runs the program on numbers or batches, which broadcast.

    >>> from motorcade.ga.algebra import CGA3
    >>> from motorcade.ga.codegen import compile_function
    >>> def square(a):
    ...     return a * a
    >>> compiled = compile_function(square, a="e1 e2 e3")
    >>> compiled.program.tape.operations()
    {'add': 2, 'mul': 3}
    >>> compiled(CGA3.multivector({"e1": 3.0, "e2": 4.0})).coefficient("1").item()
    25.0
    """

    program: Program
    single: bool

    def __call__(self, *args: Any, **named: Any) -> Multivector | dict[str, Multivector]:
        """The multivector that the function returns, or all of them by their names.

        Parameters on blades take a multivector with no other blades, the rest real scalars.

        Raises:
            ValueError: arguments that do not fit, or values that are not finite.
        """
        tape, algebra = self.program.tape, self.program.algebra
        given = _bound(self.program, args, named)
        inputs = {
            (operand.name, k): value
            for operand in tape.inputs
            for k, value in enumerate(_components(operand, given[operand.name], algebra))
        }
        made = {
            operand.name: algebra.multivector(dict(zip(operand.components, row, strict=True)))
            for operand, row in zip(tape.outputs, run_tape(tape, inputs), strict=True)
        }
        return next(iter(made.values())) if self.single else made


def program(
    *, algebra: Algebra = CGA3, **blades: str
) -> Callable[[Callable[..., Any]], CompiledFunction]:
    """A decorator: `compile_function` with these arguments.

    ``@program(algebra=CGA3, motor="1 e2^e3 e3^e1 e1^e2")`` above ``def turned(motor, angle):``
    """
    return lambda function: compile_function(function, algebra=algebra, **blades)


def compile_function(
    function: Callable[..., Any], *, algebra: Algebra = CGA3, **blades: str
) -> CompiledFunction:
    """Trace a function of multivectors.

    It is called once, with symbols: each parameter is a multivector, a real scalar unless its
    blades are named here, separated by blanks. It returns a multivector, or a dict of several by
    their names; a single one is the output ``result``. Functions of scalars are those of
    `motorcade.ga.script.functions.FUNCTIONS`.

    Raises:
        ValueError: parameters that are optional or variadic, blades that are not in the algebra or
            not of a parameter, another return value, branches that depend on a parameter's value.
    """
    name = checked_identifier(function.__name__, "function")
    inputs = _inputs(name, function, blades)
    import casadi as ca

    symbols = [ca.SX.sym(operand.name, operand.width) for operand in inputs]
    made = _traced(
        name,
        function,
        [
            algebra.multivector({blade: symbol[k] for k, blade in enumerate(operand.components)})
            for operand, symbol in zip(inputs, symbols, strict=True)
        ],
    )
    single = not isinstance(made, Mapping)
    outputs = {
        checked_identifier(key, f"{name}: output"): _multivector(name, value, algebra)
        for key, value in ({"result": made} if single else made).items()
    }
    if not outputs:
        raise ValueError(f"{name}: expected a function with results, got an empty dict")
    return CompiledFunction(program_of(name, algebra, inputs, symbols, outputs), single)


def _inputs(
    name: str, function: Callable[..., Any], blades: Mapping[str, str]
) -> tuple[Operand, ...]:
    made = []
    for key, parameter in inspect.signature(function).parameters.items():
        plain = parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD)
        if not plain or parameter.default is not parameter.empty:
            raise ValueError(f"{name}: expected plain parameters without defaults, got {parameter}")
        checked_identifier(key, f"{name}: parameter")
        made.append(Operand(key, tuple(blades.get(key, "1").split())))
    for key in blades:
        if key not in [operand.name for operand in made]:
            raise ValueError(f"{name}: expected blades of a parameter, got some of {key}")
    names = [component_name(o.name, k, o.width) for o in made for k in range(o.width)]
    twice = sorted({component for component in names if names.count(component) > 1})
    if twice or any(not operand.components for operand in made):
        shown = f"two of the name {twice[0]}" if twice else "a parameter without any"
        raise ValueError(f"{name}: expected components with distinct names, got {shown}")
    return tuple(made)


def _traced(name: str, function: Callable[..., Any], arguments: list[Multivector]) -> Any:
    try:
        return function(*arguments)
    except (RuntimeError, TypeError) as refused:
        said = str(refused)
        if not any(one in said for one in ("truth value", "not supported between", "== is not")):
            raise
        raise ValueError(
            f"{name}: expected the same operations for all values, got a branch on one; {_HINT}"
        ) from refused


def _multivector(name: str, value: Any, algebra: Algebra) -> Multivector:
    if not isinstance(value, Multivector):
        try:
            return algebra.scalar(value)
        except ValueError as refused:
            raise ValueError(
                f"{name}: expected to return multivectors, got {type(value).__name__}"
            ) from refused
    if value.algebra != algebra:
        raise ValueError(f"{name}: expected results in {algebra}, got one in {value.algebra}")
    return value


def _bound(traced: Program, args: tuple[Any, ...], named: Mapping[str, Any]) -> dict[str, Any]:
    names = [operand.name for operand in traced.tape.inputs]
    given = dict(zip(names, args, strict=False)) | dict(named)
    if len(args) + len(named) != len(names) or set(given) != set(names):
        got = [*map(str, range(len(args))), *named]
        raise ValueError(
            f"{traced.name}: expected arguments {', '.join(names)}, got {', '.join(got) or 'none'}"
        )
    return given


def _components(operand: Operand, given: Any, algebra: Algebra) -> list[Any]:
    """The coefficients of an argument on the blades of its parameter."""
    value = given if isinstance(given, Multivector) else algebra.scalar(given)
    if value.algebra != algebra:
        raise ValueError(f"{operand.name}: expected a multivector of {algebra}")
    known = algebra.multivector(dict.fromkeys(operand.components, 1.0)).blades
    extra = [blade for blade in value.blades if blade not in known]
    if extra:
        raise ValueError(
            f"{operand.name}: expected blades {' '.join(known)}, got also {' '.join(extra)}"
        )
    return [np.asarray(value.coefficient(blade)) for blade in operand.components]
