"""A program as a NumPy function: what runs until there is compiled C, and where there is none.

Long batches are computed in tiles, whose intermediate values stay in the cache. Arguments are
checked as the compiled way checks them, and results have the same shapes. Neither code, the C
function over blocks of rows nor NumPy's, has a name of the user's in it: components of inputs are
x0, x1, …, in their order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.codegen.passes.choices import without_repeated_choices
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.c_batch import BLOCK, WIDEST
from motorcade.ga.codegen.targets.c_elementary import functions_called, vector_dialect
from motorcade.ga.codegen.targets.numpy import library_dialect
from motorcade.ga.codegen.targets.shared.c_family import declarations
from motorcade.ga.codegen.targets.shared.expressions import component_name, statements
from motorcade.ga.codegen.targets.shared.python_module import assignments

Array = NDArray[Any]
# An operand's name and width, -1 for a scalar.
Widths = Sequence[tuple[str, int]]

_TILE = 8192
# Rows from which on components of results lie one after the other.
_BLOCK = 16
_MOST_DIMENSIONS = 16
# Operations that Python's own floats do as NumPy's do, whatever their values are.
_PLAIN = frozenset({"input", "const", "add", "sub", "mul", "neg"})


class NumpyProgram:
    """A plain tape with the names and widths of its inputs and outputs, as NumPy functions."""

    def __init__(
        self, name: str, tape: Tape, inputs: Widths, outputs: Widths, negative: Sequence[bool]
    ) -> None:
        self._name = name
        self._tape = tape
        self._inputs = inputs
        self._outputs = outputs
        self._negative = negative
        self._scalars = [(one, -1) for one, width in inputs for _ in range(abs(width))]
        self._plain = all(node.op in _PLAIN for node in tape.nodes)
        self._functions: dict[str, NumpyFunction] = {}

    def arrays(self, precision: Precision, values: Sequence[Any]) -> tuple[Array, ...]:
        """An array ``(*, n)`` an output, of one ``(*, n)`` an input."""
        taken = self._taken(self._inputs, precision, values)
        batches = [
            array.shape if width < 0 else array.shape[:-1]
            for array, (_, width) in zip(taken, self._inputs, strict=True)
        ]
        shape = self._broadcast(batches)
        if shape == () and self._plain and precision is DOUBLE:
            return self._of_one(taken)
        components = [
            part
            for array, (_, width) in zip(taken, self._inputs, strict=True)
            for part in ([array] if width < 0 else [array[..., k] for k in range(width)])
        ]
        arrays = [_empty(shape, width, precision) for _, width in self._outputs]
        places = [
            part
            for array, (_, width) in zip(arrays, self._outputs, strict=True)
            for part in ([array] if width < 0 else [array[..., k] for k in range(width)])
        ]
        self._run(precision, components, shape, places)
        return tuple(arrays)

    def _of_one(self, taken: Sequence[Array]) -> tuple[Array, ...]:
        """Arrays of one row each, as Python's own floats, which are faster than NumPy's."""
        numbers = [number for one in taken for number in one.ravel().tolist()]
        numbers_out = iter(self._function(DOUBLE)(*numbers))
        return tuple(
            np.array(
                next(numbers_out) if width < 0 else [next(numbers_out) for _ in range(width)],
                np.float64,
            )
            for _, width in self._outputs
        )

    def components(self, precision: Precision, values: Sequence[Any]) -> tuple[Any, ...]:
        """One number or array a component, of one a component; they must be finite."""
        values = [-x if minus else x for x, minus in zip(values, self._negative, strict=False)]
        if all(type(one) is float for one in values) and len(values) == len(self._scalars):
            return self._of_numbers(precision, values)
        taken = self._taken(self._scalars, precision, values)
        shape = self._broadcast([one.shape for one in taken])
        count = sum(abs(width) for _, width in self._outputs)
        components = [np.empty(shape, precision.numpy) for _ in range(count)]
        self._run(precision, taken, shape, components)
        self._check([bool(np.isfinite(one).all()) for one in components])
        if shape == () and not any(isinstance(one, np.ndarray) for one in values):
            return tuple(one.item() for one in components)
        return tuple(one[()] for one in components)

    def _of_numbers(self, precision: Precision, values: Sequence[float]) -> tuple[float, ...]:
        function = self._function(precision)
        if self._plain:
            numbers = tuple(map(float, function(*values)))
        else:
            with np.errstate(all="ignore"):
                numbers = tuple(map(float, function(*map(np.float64, values))))
        self._check([math.isfinite(value) for value in numbers])
        return numbers

    def _check(self, finite: Sequence[bool]) -> None:
        left = iter(finite)
        for name, width in self._outputs:
            own = [next(left) for _ in range(abs(width))]
            if not all(own):
                raise ValueError(
                    f"{self._name}: expected finite numbers in {name}, got NaN or infinite ones"
                )

    def _taken(self, operands: Widths, precision: Precision, values: Sequence[Any]) -> list[Array]:
        if len(values) != len(operands):
            raise ValueError(f"{self._name}: expected {len(operands)} arguments, got {len(values)}")
        return [
            self._array(name, width, precision, value)
            for (name, width), value in zip(operands, values, strict=True)
        ]

    def _array(self, name: str, width: int, precision: Precision, value: Any) -> Array:
        number = width < 0 and type(value) in (int, float)
        if not number and not isinstance(value, np.ndarray | np.generic):
            wanted = "a number or an array" if width < 0 else "an array"
            raise TypeError(
                f"{self._name}: {name}: expected {wanted} of real numbers, "
                f"got {type(value).__name__}"
            )
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError(
                f"{self._name}: {name}: expected real numbers, got the type {array.dtype}"
            )
        if width >= 0 and array.shape[-1:] != (width,):
            raise ValueError(
                f"{self._name}: {name}: expected an array (*, {width}), "
                f"got one of shape {array.shape}"
            )
        return array.astype(precision.numpy, copy=False)

    def _broadcast(self, batches: Sequence[tuple[int, ...]]) -> tuple[int, ...]:
        try:
            shape = np.broadcast_shapes(*batches)
        except ValueError as refused:
            raise ValueError(
                f"{self._name}: expected batches that broadcast together, got "
                f"{', '.join(map(str, dict.fromkeys(batches)))}"
            ) from refused
        if len(shape) > _MOST_DIMENSIONS:
            raise ValueError(
                f"{self._name}: expected at most {_MOST_DIMENSIONS} batch dimensions, "
                f"got {len(shape)}"
            )
        return shape

    def _run(
        self,
        precision: Precision,
        components: Sequence[Array],
        shape: tuple[int, ...],
        places: Sequence[Array],
    ) -> None:
        function, count = self._function(precision), prod(shape)
        with np.errstate(all="ignore"):
            if count <= _TILE:
                for place, value in zip(places, function(*components), strict=True):
                    place[...] = value
                return
            whole = [one if one.ndim == 0 else np.broadcast_to(one, shape) for one in components]
            rows = [one if one.ndim < 2 else one.reshape(count) for one in whole]
            for start in range(0, count, _TILE):
                part = slice(start, start + _TILE)
                results = function(*[one if one.ndim == 0 else one[part] for one in rows])
                for place, value in zip(places, results, strict=True):
                    _rows(place, count)[part] = value

    def _function(self, precision: Precision) -> NumpyFunction:
        if precision.numpy not in self._functions:
            self._functions[precision.numpy] = numpy_function(self._tape, precision)
        return self._functions[precision.numpy]


def _empty(shape: tuple[int, ...], width: int, precision: Precision) -> Array:
    """An array ``(*shape, width)``; components lie one after the other where there are many."""
    if width < 0:
        return np.empty(shape, precision.numpy)
    if prod(shape) < _BLOCK:
        return np.empty((*shape, width), precision.numpy)
    return np.moveaxis(np.empty((width, *shape), precision.numpy), 0, -1)


def _rows(place: Array, count: int) -> Array:
    """A component of a long result, which lies in one piece, as rows."""
    return place.reshape(count)


SYMBOL = "motorcade_program"

# Arguments are one number or array a component; the results are in a tuple.
NumpyFunction = Callable[..., tuple[Any, ...]]

_INDEPENDENT = """\
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif"""


def plain_tape(tape: Tape) -> Tape:
    """The tape with one input x of all components, and one output of all."""
    first: dict[str, int] = {}
    count = 0
    for operand in tape.inputs:
        first[operand.name] = count
        count += operand.width
    nodes = tuple(
        node._replace(source=("x", first[node.source[0]] + node.source[1]))
        if node.op == "input"
        else node
        for node in tape.nodes
    )
    results = tuple(index for row in tape.results for index in row)
    vector = Operand("x", tuple(map(str, range(count))))
    return Tape(
        (vector,), (Operand("out", tuple(map(str, range(len(results))))),), nodes, (results,)
    )


def c_source(tape: Tape, precision: Precision) -> str:
    """A C file with the function `SYMBOL` of a plain tape, as ``native/rows.h`` calls it.

    Raises ValueError: numbers too large for the precision.
    """
    branched = without_repeated_choices(tape)
    written = statements(branched, vector_dialect(precision))
    real, (operand,) = precision.c, branched.inputs
    read = branched.components_read("x")
    loop = [
        *(f"const {real} {_x(k, operand)} = in{k}[i];" for k in read),
        *declarations(written.body, f"const {real}", "const _Bool"),
        *(f"out{k}[i] = {value};" for k, value in enumerate(written.results[0])),
    ]
    lines = [
        "#include <math.h>",
        "#include <stddef.h>",
        functions_called(loop),
        _INDEPENDENT,
        f"void {SYMBOL}(const {real} *const *in, {real} *const *out, size_t blocks);",
        *WIDEST,
        f"void {SYMBOL}(const {real} *const *in, {real} *const *out, size_t blocks)",
        "{",
        *(f"    const {real} *restrict in{k} = in[{k}];" for k in read),
        *(f"    {real} *restrict out{k} = out[{k}];" for k in range(len(written.results[0]))),
        *(["    (void)in;"] if not read else []),
        "    INDEPENDENT",
        f"    for (size_t i = 0; i < {BLOCK} * blocks; ++i) {{",
        *(f"        {line}" for line in loop),
        "    }",
        "}",
    ]
    return "\n".join(lines) + "\n"


def numpy_function(tape: Tape, precision: Precision) -> NumpyFunction:
    """The Python function of a plain tape, in a precision.

    Raises ValueError: numbers too large for the precision.
    """
    branched = without_repeated_choices(tape)
    written = statements(branched, library_dialect(precision))
    (operand,) = branched.inputs
    parameters = ", ".join(_x(k, operand) for k in range(operand.width))
    results = ", ".join(written.results[0])
    lines = [
        "import numpy as np",
        "from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent",
        f"def run({parameters}):",
        *(f"    {line}" for line in assignments(written.body, lead=4)),
        f"    return ({results},)" if results else "    return ()",
    ]
    names: dict[str, Any] = {}
    exec(compile("\n".join(lines) + "\n", "<program>", "exec"), names)  # our own text
    function: NumpyFunction = names["run"]
    return function


def _x(k: int, operand: Operand) -> str:
    return component_name("x", k, operand.width)
