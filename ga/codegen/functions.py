"""Programs written in Python: functions of multivectors, traced as scripts are; derivatives."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import Any, overload

from motorcade.ga.algebra import CGA3, Algebra, Multivector
from motorcade.ga.codegen.passes.optimize import optimized
from motorcade.ga.codegen.programs import (
    Program,
    checked_identifier,
    compile_script,
    program_of,
    symbols_of,
)
from motorcade.ga.codegen.recording import tape_of
from motorcade.ga.codegen.runtime.evaluator import Evaluator
from motorcade.ga.codegen.tape import Node, Operand, Tape, TapeBuilder
from motorcade.ga.codegen.targets.shared.expressions import component_name
from motorcade.ga.script import Script, parse

_HINT = "both ways can be computed and one be chosen: motorcade.ga.algebra.scalars"


class CompiledFunction:
    """A function of multivectors and the program that was traced from it.

    Calling it runs the program on numbers or batches, which broadcast; `arrays` does so on arrays
    of coefficients. It runs as NumPy source at once, and as compiled C where the machine has a C
    compiler: `backend` says which, and `wait` has the C ready before a first call. Results differ
    by rounding alone. Environment variables: MOTORCADE_PROGRAMS ("numpy": no C; "wait": the first
    call waits for it), CC (the compiler), MOTORCADE_PROGRAM_CACHE (the folder of compiled code).

    Attributes:
        program: what was traced.
        single: whether it has one result, without a name.

    >>> import numpy as np
    >>> from motorcade.ga.algebra import CGA3
    >>> from motorcade.ga.codegen.functions import compile_function
    >>> def square(a):
    ...     return a * a
    >>> compiled = compile_function(square, a="e1 e2 e3")
    >>> compiled.program.tape.operations()
    {'add': 2, 'mul': 3}
    >>> compiled(CGA3.multivector({"e1": 3.0, "e2": 4.0})).coefficient("1")
    25.0
    >>> compiled.arrays(np.array([[3.0, 4.0, 0.0], [1.0, 2.0, 2.0]]))
    array([25.,  9.])
    """

    def __init__(self, program: Program, single: bool) -> None:
        tape, algebra = program.tape, program.algebra
        self.program = program
        self.single = single
        self._reads = tuple(_Reader(operand, algebra) for operand in tape.inputs)
        negative = [minus for read in self._reads for minus in read.negative]
        self._runs = Evaluator(program.name, tape, single, negative)
        self._masks = tuple(_masks_of(operand, algebra) for operand in tape.outputs)

    def __repr__(self) -> str:
        return f"<CompiledFunction {self.program.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return CompiledFunction, (self.program, self.single)

    def __call__(self, *args: Any, **named: Any) -> Multivector | dict[str, Multivector]:
        """The multivector that the function returns, or all of them by their names.

        Parameters on blades take a multivector with no other blades, the rest real scalars. The
        coefficients of a result have the batch that all arguments broadcast to.

        Raises:
            ValueError: arguments that do not fit, or values that are not finite.
        """
        if named or len(args) != len(self._reads):
            args = _bound(self.program, args, named)
        values: list[Any] = []
        for read, arg in zip(self._reads, args, strict=True):
            values += read(arg)
        components = self._runs.components(*values)
        algebra = self.program.algebra
        if self.single:
            return Multivector._trusted(algebra, self._masks[0], components)
        left = iter(components)
        return {
            operand.name: Multivector._trusted(algebra, masks, [next(left) for _ in masks])
            for operand, masks in zip(self.program.tape.outputs, self._masks, strict=True)
        }

    def arrays(self, *args: Any, **named: Any) -> Any:
        """The same on arrays of coefficients, float32 or float64, whose batches broadcast.

        Parameters on ``n`` blades take an array ``(*, n)`` in the order of their blades, scalars an
        array ``(*)`` or a number. Results are arrays ``(*, n)`` in the order of the blades of
        ``program.tape.outputs``, ``(*)`` where that is the scalar alone: one of them, or a dict
        by names. Components lie one after the other where there are sixteen rows or more. Outside
        a function's domain results are NaN or infinite.

        Raises:
            TypeError: what is no array of real numbers.
            ValueError: arrays of another shape, batches that do not broadcast, another count.
        """
        if named or len(args) != len(self._reads):
            args = _bound(self.program, args, named)
        outputs = self._runs.arrays(*args)
        if self.single:
            return outputs
        names = [operand.name for operand in self.program.tape.outputs]
        return dict(zip(names, outputs, strict=True))

    def jacobian(self, parameter: str) -> Jacobian:
        """The derivatives of the results by the components of a parameter, a function of arrays.

        It takes what `arrays` takes and gives arrays ``(*, n, m)``: of `n` components of a result
        by `m` of the parameter. It is compiled as the function itself is. Derivatives are those of
        the formulas: at a branch they are those of the side that is taken.

        Raises:
            ValueError: no parameter of that name.
            ModuleNotFoundError: without CasADi, which differentiates.
        """
        return Jacobian(self.program, parameter, self.single)

    def backend(self, precision: str = "float64") -> str:
        """How calls in a precision run now: "c", or "numpy" and why, in one line."""
        return self._runs.backend(precision)

    def wait(self, precision: str = "float64") -> bool:
        """Have the C of a precision compiled; False where there is none, `backend` says why."""
        return self._runs.wait(precision)


@overload
def program(
    function: Callable[..., Any], /, *, algebra: Algebra = CGA3, **blades: str
) -> CompiledFunction: ...
@overload
def program(
    *, algebra: Algebra = CGA3, **blades: str
) -> Callable[[Callable[..., Any]], CompiledFunction]: ...
def program(
    function: Callable[..., Any] | None = None, /, *, algebra: Algebra = CGA3, **blades: str
) -> CompiledFunction | Callable[[Callable[..., Any]], CompiledFunction]:
    """A decorator: `compile_function` with these arguments.

    ``@program(algebra=CGA3, motor="1 e2^e3 e3^e1 e1^e2")`` above ``def turned(motor, angle):``, or
    ``@program`` alone above a function of scalars.
    """
    if function is not None:
        return compile_function(function, algebra=algebra, **blades)
    return lambda traced: compile_function(traced, algebra=algebra, **blades)


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
    symbols = symbols_of(inputs)
    result = _traced(
        name,
        function,
        [
            algebra.multivector({blade: symbol[k] for k, blade in enumerate(operand.components)})
            for operand, symbol in zip(inputs, symbols, strict=True)
        ],
    )
    single = not isinstance(result, Mapping)
    outputs = {
        checked_identifier(key, f"{name}: output"): _multivector(name, value, algebra)
        for key, value in ({"result": result} if single else result).items()
    }
    if not outputs:
        raise ValueError(f"{name}: expected a function with results, got an empty dict")
    return CompiledFunction(program_of(name, algebra, inputs, symbols, outputs), single)


def compile(
    source: Callable[..., Any] | Script | str,
    *,
    algebra: Algebra | None = None,
    name: str = "script",
    **blades: str,
) -> CompiledFunction:
    """A function that runs a program: as NumPy source at once, as compiled C when that is ready.

    Args:
        source: a function of multivectors, as `motorcade.ga.codegen.compile_function` takes it, or
            a CLUScript, whose free variables are the parameters in the order of first use and
            whose results come by their names.
        algebra: CGA3 unless given here or by the script's algebra pragma.
        name: of a script, an identifier; a function has its own.
        blades: of a function's parameters, separated by blanks; others are real scalars.

    Raises:
        ScriptError: what is wrong with the script, and where.
        ValueError: a function that cannot be traced, blades for a script.

    >>> from motorcade.ga import compile
    >>> area = compile("?area = (x*e1) ^ (y*e2);")
    >>> area(2.0, y=3.0)["area"]["e1^e2"]
    6.0
    """
    if callable(source):
        return compile_function(source, algebra=CGA3 if algebra is None else algebra, **blades)
    if blades:
        raise ValueError(
            f"{name}: expected blades of a function's parameters, got some of "
            f"{', '.join(blades)} for a script, whose variables are scalars"
        )
    script = parse(source, name) if isinstance(source, str) else source
    return CompiledFunction(compile_script(script, name, algebra), single=False)


class _Reader:
    """Takes the coefficients of an argument on the blades of its parameter, but for their signs.

    Attributes:
        negative: for each blade, whether it is the negative of the algebra's own.
    """

    def __init__(self, operand: Operand, algebra: Algebra) -> None:
        self._operand = operand
        self._algebra = algebra
        self._scalar = operand.components == ("1",)
        terms = [algebra.masks_of(blade)[0] for blade in operand.components]
        known = algebra.multivector(dict.fromkeys(operand.components, 1.0))
        self._masks, self._blades = known.masks, known.blades
        self.negative = [sign < 0 for _, sign in terms]
        self._places = [known.masks.index(mask) for mask, _ in terms]
        self._in_order = self._places == list(range(len(terms)))

    def __call__(self, argument: Any) -> Sequence[Any]:
        if type(argument) is Multivector and argument.masks == self._masks and self._in_order:
            if argument.algebra is self._algebra:
                return argument.values
        elif self._scalar and type(argument) is float and isfinite(argument):
            return (argument,)
        value = argument if isinstance(argument, Multivector) else self._algebra.scalar(argument)
        if value.algebra is not self._algebra and value.algebra != self._algebra:
            raise ValueError(f"{self._operand.name}: expected a multivector of {self._algebra}")
        if value.masks == self._masks:
            return [value.values[k] for k in self._places]
        extra = [blade for blade in value.blades if blade not in self._blades]
        if extra:
            raise ValueError(
                f"{self._operand.name}: expected blades {' '.join(self._blades)}, "
                f"got also {' '.join(extra)}"
            )
        own = dict(zip(value.masks, value.values, strict=True))
        return [own.get(self._masks[k], 0.0) for k in self._places]


def _masks_of(operand: Operand, algebra: Algebra) -> tuple[int, ...]:
    return tuple(algebra.masks_of(blade)[0][0] for blade in operand.components)


def _inputs(
    name: str, function: Callable[..., Any], blades: Mapping[str, str]
) -> tuple[Operand, ...]:
    operands = []
    for key, parameter in inspect.signature(function).parameters.items():
        plain = parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD)
        if not plain or parameter.default is not parameter.empty:
            raise ValueError(f"{name}: expected plain parameters without defaults, got {parameter}")
        checked_identifier(key, f"{name}: parameter")
        operands.append(Operand(key, tuple(blades.get(key, "1").split())))
    for key in blades:
        if key not in [operand.name for operand in operands]:
            raise ValueError(f"{name}: expected blades of a parameter, got some of {key}")
    names = [component_name(o.name, k, o.width) for o in operands for k in range(o.width)]
    twice = sorted({component for component in names if names.count(component) > 1})
    if twice or any(not operand.components for operand in operands):
        shown = f"two of the name {twice[0]}" if twice else "a parameter without any"
        raise ValueError(f"{name}: expected components with distinct names, got {shown}")
    return tuple(operands)


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


def _bound(traced: Program, args: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Any, ...]:
    """The arguments in the order of the parameters."""
    names = [operand.name for operand in traced.tape.inputs]
    bound = dict(zip(names, args, strict=False)) | dict(named)
    if len(args) + len(named) != len(names) or set(bound) != set(names):
        got = [*map(str, range(len(args))), *named]
        raise ValueError(
            f"{traced.name}: expected arguments {', '.join(names)}, got {', '.join(got) or 'none'}"
        )
    return tuple(bound[name] for name in names)


# What CasADi calls the operations that Python has no sign for.
_CALLED = {
    "abs": "fabs", "min": "fmin", "max": "fmax", "and": "logic_and", "or": "logic_or",
    "not": "logic_not", "select": "if_else", "lt": "lt", "le": "le",
    "eq": "eq", "ne": "ne", "add": "plus", "sub": "minus", "mul": "times", "div": "rdivide",
}  # fmt: skip


class Jacobian:
    """The derivatives of a program's results by one parameter; see `CompiledFunction.jacobian`.

    >>> import numpy as np
    >>> from motorcade.ga.algebra import EGA3
    >>> from motorcade.ga.codegen.functions import compile_function
    >>> def turned(v, angle):
    ...     return (-angle / 2 * EGA3.blade("e1^e2")).exp().sandwich(v)
    >>> by_angle = compile_function(turned, algebra=EGA3, v="e1 e2 e3").jacobian("angle")
    >>> by_angle(np.array([1.0, 0.0, 5.0]), 0.0).tolist()
    [[0.0], [1.0], [0.0]]
    """

    def __init__(self, program: Program, parameter: str, single: bool) -> None:
        width = next((o.width for o in program.tape.inputs if o.name == parameter), None)
        if width is None:
            names = ", ".join(operand.name for operand in program.tape.inputs)
            raise ValueError(f"{program.name}: parameter: expected one of {names}, got {parameter}")
        self._width = width
        self._single = single
        self._outputs = program.tape.outputs
        tape = jacobian_tape(program.name, program.tape, parameter)
        count = sum(operand.width for operand in tape.inputs)
        self._runs = Evaluator(f"{program.name}_by_{parameter}", tape, single, [False] * count)

    def __call__(self, *args: Any) -> Any:
        """Arrays ``(*, n, m)`` of the derivatives of `n` components by `m`, or a dict of them.

        Arguments and errors are those of `CompiledFunction.arrays`.
        """
        arrays = self._runs.arrays(*args)
        if self._single:
            return self._matrices(arrays, self._outputs[0])
        return {
            operand.name: self._matrices(array, operand)
            for operand, array in zip(self._outputs, arrays, strict=True)
        }

    def backend(self, precision: str = "float64") -> str:
        """How calls in a precision run now: see `CompiledFunction.backend`."""
        return self._runs.backend(precision)

    def wait(self, precision: str = "float64") -> bool:
        """Have the C of a precision compiled; whether it is there."""
        return self._runs.wait(precision)

    def _matrices(self, rows: Any, operand: Operand) -> Any:
        return rows.reshape(*rows.shape[:-1], operand.width, self._width)


def jacobian_tape(name: str, tape: Tape, parameter: str) -> Tape:
    """The tape whose outputs are the derivatives of each output by a parameter, in rows."""
    import casadi as ca

    symbols = {operand.name: ca.SX.sym(operand.name, operand.width) for operand in tape.inputs}
    values = _values(tape, lambda node: symbols[node.source[0]][node.source[1]])
    operands, rows = [], []
    for operand, row in zip(tape.outputs, tape.results, strict=True):
        column = ca.vertcat(ca.SX(0, 1), *(ca.SX(values[k]) for k in row))
        matrix = ca.densify(ca.jacobian(column, symbols[parameter]))
        places = [(i, j) for i in range(matrix.shape[0]) for j in range(matrix.shape[1])]
        operands.append(Operand(operand.name, tuple(f"{i} {j}" for i, j in places)))
        rows.append([matrix[i, j] for i, j in places])
    whole = tape_of(name, tape.inputs, operands, list(symbols.values()), rows)
    return _with_zeros(optimized(whole)[0], operands)


def _values(tape: Tape, value: Callable[[Node], Any]) -> list[Any]:
    """Each node's value in CasADi's symbols."""
    import casadi as ca

    values: list[Any] = []
    for node in tape.nodes:
        args = [values[k] for k in node.args]
        if node.op == "const":
            values.append(ca.SX(node.value))
        elif node.op == "input":
            values.append(value(node))
        elif node.op == "neg":
            values.append(-args[0])
        elif node.op == "keep":
            values.append(ca.if_else(args[0], args[1], 0.0))
        else:
            values.append(getattr(ca, _CALLED.get(node.op, node.op))(*args))
    return values


def _with_zeros(tape: Tape, wanted: Sequence[Operand]) -> Tape:
    """The tape with the components that the optimiser left out as zero."""
    builder = TapeBuilder()
    builder.nodes.extend(tape.nodes)
    zero = builder.constant(0.0)
    results = []
    for operand, output, row in zip(wanted, tape.outputs, tape.results, strict=True):
        own = dict(zip(output.components, row, strict=True))
        results.append([own.get(component, zero) for component in operand.components])
    return builder.finished(tape.inputs, tuple(wanted), results)
