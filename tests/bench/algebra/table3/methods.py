"""The methods of Table 3: what each takes, and its C, written and compiled on the spot.

The C of the algebra's methods comes from the scripts beside this file, by each strategy; the loop
over joints around it is written here and the script's function is inlined into it, as is what is
written by hand for quaternions. All is compiled by one compiler with the same options.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.codegen.generate import STRATEGIES
from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.targets import c, c_batch
from motorcade.ga.script import Script, parse
from tests.bench.algebra.glm import NotMeasured, Scalar

__all__ = ["ARRAY_METHODS", "METHODS", "Blends", "Method", "compile_blends"]

HERE = Path(__file__).parent
FLAGS = (
    *("-std=c11", "-D_POSIX_C_SOURCE=199309L", "-O3", "-march=native"),
    *("-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast"),
)
PRECISIONS: dict[Scalar, Precision] = {"float32": SINGLE, "float64": DOUBLE}
# Where a script's outputs go: columns of a 4x4 matrix by columns.
_COLUMNS = {"x": 0, "y": 4, "z": 8, "t": 12}
_CACHE_LINE, _PAGE = 64, 4096
_PLACEMENTS, _GAP = 9, 7 * _CACHE_LINE
_LAST_ROW = "out[3] = out[7] = out[11] = 0, out[15] = 1;"


@dataclass(frozen=True)
class Method:
    """One way to blend poses.

    Args:
        name: of the C function.
        label: as tables print it.
        rows: two poses of joints as the numbers that the function takes, ``(joints, width)``.
        path: which path of `reference` it must follow: ``slerp``, ``screw`` or ``linear``.
        script: the file that it is written from, empty where it is written by hand.
        strategy: how it is written from the script; ``c-batch`` for arrays of joints.
    """

    name: str
    label: str
    rows: Callable[[Motor], FloatArray]
    path: str
    script: str = ""
    strategy: str = ""

    @property
    def arrays(self) -> bool:
        """Whether it takes one array a component, and gives 3x4 matrices likewise."""
        return self.strategy == "c-batch" or self.name.endswith("_arrays")


def _quaternions(poses: Motor) -> FloatArray:
    return np.concatenate(poses.as_quaternion_translation(), axis=-1)


def _rotors(poses: Motor) -> FloatArray:
    return np.concatenate([poses.rotor.coefficients, poses.translation_m], axis=-1)


def _dual_quaternions(poses: Motor) -> FloatArray:
    return poses.as_dual_quaternion()


def _motors(poses: Motor) -> FloatArray:
    return poses.coefficients


_SCRIPTS = (
    ("rotor", "EGA rotor log/exp + lerp", _rotors, "slerp"),
    ("motor", "CGA motor log/exp", _motors, "screw"),
    ("motor_linear", "CGA motor linear", _motors, "linear"),
)
METHODS = (
    Method("quaternion", "quaternion slerp + lerp", _quaternions, "slerp"),
    Method("dual_quaternion", "dual quaternion", _dual_quaternions, "linear"),
    *(
        Method(
            f"{name}_{strategy.replace('-', '_')}",
            f"{label}, {strategy}",
            rows,
            path,
            name,
            strategy,
        )
        for name, label, rows, path in _SCRIPTS
        for strategy in ("table", "table-code", "product", "program")
    ),
)
ARRAY_METHODS = (
    Method("dual_quaternion_arrays", "dual quaternion, arrays", _dual_quaternions, "linear"),
    *(
        Method(f"{name}_arrays", f"{label}, c-batch", rows, path, name, "c-batch")
        for name, label, rows, path in _SCRIPTS
    ),
)


class Blends:
    """Compiled blends in one precision."""

    def __init__(self, library: Path, scalar: Scalar) -> None:
        self.scalar = scalar
        self._library = ctypes.CDLL(str(library))

    @cached_property
    def _seconds(self) -> Any:
        real = ctypes.c_float if self.scalar == "float32" else ctypes.c_double
        timed = self._library.seconds
        timed.restype = ctypes.c_double
        timed.argtypes = [ctypes.c_void_p] * 3 + [real, ctypes.c_void_p] + [ctypes.c_size_t] * 2
        return timed

    def call(self, method: Method, first: Motor, second: Motor, fraction: float) -> Call:
        """The blend of two poses of some joints, ready to be called."""
        return Call(self, method, first, second, fraction)


class Call:
    """A blend with its data: `seconds` runs it and takes the time, `matrices` reads the result."""

    def __init__(
        self, blends: Blends, method: Method, first: Motor, second: Motor, fraction: float
    ) -> None:
        self.joints = len(first.coefficients)
        self._method, self._fraction = method, fraction
        self._timed = blends._seconds
        self._function = getattr(blends._library, method.name)
        rows = [method.rows(poses) for poses in (first, second)]
        stored = [part.T if method.arrays else part for part in rows]
        arrays = [*stored, np.zeros((self.joints, 16))]
        placed = [_placed(arrays, blends.scalar, k * _GAP) for k in range(_PLACEMENTS)]
        self._placements = cycle(placed)
        self._used = placed[0]

    def seconds(self, times: int) -> float:
        """Seconds of `times` calls, each time with the data elsewhere."""
        self._used = next(self._placements)
        places = [array.ctypes.data for array in self._used]
        return float(
            self._timed(
                ctypes.cast(self._function, ctypes.c_void_p),
                places[0],
                places[1],
                self._fraction,
                places[2],
                self.joints,
                times,
            )
        )

    def matrices(self) -> FloatArray:
        """The matrices of the last call, ``(joints, 3, 4)``."""
        out = self._used[-1]
        if self._method.arrays:
            numbers = out.ravel()[: 12 * self.joints]
            return numbers.reshape(3, 4, self.joints).transpose(2, 0, 1).astype(np.float64)
        by_columns = out.reshape(self.joints, 4, 4).transpose(0, 2, 1)
        return by_columns[:, :3].astype(np.float64)


def _placed(arrays: list[FloatArray], scalar: Scalar, gap: int) -> list[FloatArray]:
    """Copies in one stretch of memory, each on a cache line, `gap` bytes further apart than needed.

    Where arrays lie towards each other can cost a tenth and more; so figures are medians over
    several placements, the same for all methods.
    """
    size = np.dtype(scalar).itemsize
    steps = [-(-array.size * size // _CACHE_LINE) * _CACHE_LINE + gap for array in arrays]
    memory = np.zeros(sum(steps) + _PAGE, dtype=np.uint8)
    start = -memory.ctypes.data % _PAGE
    made = []
    for step, array in zip(steps, arrays, strict=True):
        made.append(memory[start : start + array.size * size].view(scalar).reshape(array.shape))
        made[-1][:] = array
        start += step
    return made


def compile_blends(folder: Path, scalar: Scalar, methods: Iterable[Method]) -> Blends:
    """Write and compile methods in one precision.

    Raises:
        NotMeasured: there is no C compiler.
    """
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise NotMeasured("table3: no C compiler here (apt-get install gcc)")
    precision = PRECISIONS[scalar]
    sources = [HERE / "rivals.c"]
    for method in methods:
        if method.script:
            source = folder / f"{method.name}_{scalar}.c"
            source.write_text(_source(method, precision))
            sources.append(source)
    library = folder / f"blends_{scalar}.so"
    command = [compiler, *FLAGS, f"-DREAL={precision.c}", "-shared", "-fPIC"]
    command += [*map(str, sources), "-lm", "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"table3: the generated C does not compile: {done.stderr[:400]}")
    return Blends(library, scalar)


def script(name: str) -> Script:
    """A script beside this file."""
    file = HERE / "scripts" / f"{name}.clu"
    return parse(file.read_text(encoding="utf-8"), file.name)


@cache
def _program(name: str) -> Program:
    """The program of a script; its function stays inside the file that it is written to."""
    return compile_script(script(name), f"{name}_pose")


def _source(method: Method, precision: Precision) -> str:
    """The script's function, and the loop around it."""
    program = _program(method.script)
    name = program.name
    if method.strategy in STRATEGIES:
        files = STRATEGIES[method.strategy](script(method.script), program, precision)
    else:
        files = (c_batch if method.strategy == "c-batch" else c).write(program, precision)
    loop = _array_loop if method.arrays else _loop
    return loop(method, program, precision.c, files[f"{name}.c"])


def _loop(method: Method, program: Program, real: str, text: str) -> str:
    """Rows in, 4x4 matrices by columns out; the script's function is inlined."""
    inputs = [_place(o.name, "{0}[{1}]", "f") for o in program.tape.inputs]
    outputs = [f"out + {_COLUMNS[o.name]}" for o in program.tape.outputs]
    types = ", ".join([real] * len(inputs) + [f"{real} *"] * len(outputs))
    width = (len(inputs) - 1) // 2
    return (
        f"#include <stddef.h>\n"
        f"static inline __attribute__((always_inline)) void {program.name}({types});\n{text}\n"
        f"void {method.name}(const {real} *a, const {real} *b, {real} f, {real} *out, "
        f"size_t joints)\n{{\n"
        f"    for (size_t i = 0; i < joints; ++i, a += {width}, b += {width}, out += 16) {{\n"
        f"        {program.name}({', '.join([*inputs, *outputs])});\n        {_LAST_ROW}\n"
        "    }\n}\n"
    )


def _array_loop(method: Method, program: Program, real: str, text: str) -> str:
    """One array a component in, 3x4 matrices by rows out; the fraction as an array of its own."""
    inputs = [_place(o.name, "{0} + {1} * joints", "fractions") for o in program.tape.inputs]
    outputs = [
        f"out + {4 * row + _COLUMNS[o.name] // 4} * joints"
        for o in program.tape.outputs
        for row in range(len(o.components))
    ]
    types = ", ".join(["size_t"] + [f"const {real} *"] * len(inputs) + [f"{real} *"] * len(outputs))
    return (
        f"#include <stddef.h>\n"
        f"static inline __attribute__((always_inline)) void {program.name}({types});\n{text}\n"
        f"void {method.name}(const {real} *a, const {real} *b, {real} f, {real} *out, "
        f"size_t joints)\n{{\n"
        f"    {real} fractions[joints];\n"
        "    for (size_t i = 0; i < joints; ++i) fractions[i] = f;\n"
        f"    {program.name}(joints, {', '.join([*inputs, *outputs])});\n}}\n"
    )


def _place(variable: str, template: str, fraction: str) -> str:
    """Where ``a3`` of the script is found in the rows, or ``f``."""
    return fraction if variable == "f" else template.format(variable[0], variable[1:])
