"""`make bench SUITE=programs`: formulas compiled at run time, beside other libraries in one run.

Each is measured at one call and at 100,000 rows: as a function of arrays and of multivectors, as
NumPy source, written out in plain multivectors, and as kingdon and clifford have it; what is not
installed is named. All give the same numbers before they are timed. For the motor log and exp a
joint is timed as generated C and as the library's kernel.

The target ``c``, one call at a time, is measured in one run and with the same flags beside GLM,
Eigen, klein, libvsr and Gaalop's C by ``python -m tests.bench.algebra.plain_c --peers FOLDER``:
composition, inversion, points, planes, lines, log, exp, interpolation and blend in both precisions,
as ratios. The folder holds checkouts of what no package has; what is not found is named.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import CGA3, Motor, Multivector, kernels
from motorcade.ga.arrays import FloatArray
from motorcade.ga.codegen.functions import CompiledFunction, compile_function
from motorcade.ga.codegen.generate import read_script
from motorcade.ga.codegen.programs import compile_script
from tests.bench.timing import median_seconds, on_one_core, seconds_a_call

__all__ = ["bench_programs", "programs_table"]

ROWS = 100_000
JOINTS = 10_000
SECONDS = 0.5
MOTOR = "1 e2^e3 e3^e1 e1^e2 e1^einf e2^einf e3^einf e1^e2^e3^einf"
POINT = "e1 e2 e3 e0 einf"
EVEN = " ".join(blade for blade in CGA3.blades if blade == "1" or blade.count("^") in (1, 3))
SCRIPT = Path(__file__).parent / "table3" / "scripts" / "motor.clu"
OUTPUTS = 12
_VECTORS = tuple(1 << k for k in range(CGA3.dimension))

Calls = dict[str, Callable[[], object]]


def bench_programs(seconds: float = SECONDS) -> dict[str, Any]:
    """Microseconds of each way, formula and size, and what was left out; a JSON-ready tree."""
    left_out: list[str] = []
    rng = np.random.default_rng(7)
    found: dict[str, Any] = {"threads": kernels.threads(), "left_out": left_out}
    for name, blades in (("motor on a point", MOTOR), ("even versor on a point", EVEN)):
        function = _compiled(blades)
        width = len(blades.split())
        many = _elements(rng, ROWS, width)
        found[name] = {
            size: {
                way: 1e6 * median_seconds(call, seconds)
                for way, call in _ways(function, blades, elements, left_out).items()
            }
            | _clifford_us(many[0], blades, len(np.atleast_2d(elements)), seconds, left_out)
            for size, elements in (("one", many[0]), ("many", many))
        }
    found["joint"] = _joints(left_out)
    found["left_out"] = sorted(set(left_out))
    return found


def sandwich(x: Any, p: Any) -> Any:
    """The formula that is timed."""
    return x * p * ~x


def _compiled(blades: str) -> CompiledFunction:
    return compile_function(sandwich, x=blades, p=POINT)


def _elements(rng: np.random.Generator, count: int, width: int) -> FloatArray:
    """Motors, or products of four vectors, with one component after the other."""
    if width == len(MOTOR.split()):
        return np.asfortranarray(Motor.random(rng, (count,)).coefficients)
    first, *others = (CGA3.vector(list(rng.normal(size=(5, count)))) for _ in range(4))
    for vector in others:
        first = first * vector
    return np.stack([first[blade] for blade in EVEN.split()]).T


def _ways(
    function: CompiledFunction, blades: str, elements: FloatArray, left_out: list[str]
) -> Calls:
    """All ways to compute the sandwich, once they agree."""
    point = np.array([1.0, 2.0, 3.0, 1.0, 7.0])
    names = blades.split()
    columns = elements.tolist() if elements.ndim == 1 else list(elements.T.copy())
    x = CGA3.multivector(dict(zip(names, columns, strict=True)))
    p = CGA3.multivector(dict(zip(POINT.split(), point.tolist(), strict=True)))
    rows = np.ascontiguousarray(elements)
    single, one = np.asfortranarray(elements.astype(np.float32)), point.astype(np.float32)
    compiled = function.wait() and function.wait("float32")
    if not compiled:
        left_out.append(f"compiled C: {function.backend()}")
    calls: Calls = {}
    if compiled:
        calls["arrays, C"] = lambda: function.arrays(elements, point)
        calls["arrays in rows, C"] = lambda: function.arrays(rows, point)
        calls["arrays, float32, C"] = lambda: function.arrays(single, one)
        calls["multivectors, C"] = lambda: function(x, p)
    with _as_numpy():
        plain = compile_function(sandwich, x=blades, p=POINT)
        plain.arrays(elements, point)
    calls["arrays, NumPy"] = lambda: plain.arrays(elements, point)
    calls["multivectors, NumPy"] = lambda: plain(x, p)
    calls["plain multivectors"] = lambda: x * p * ~x
    if blades == MOTOR:
        coordinates = point[:3]
        calls["the shipped kernel"] = lambda: kernels.MOTORS.apply(elements, coordinates)
    try:
        calls["kingdon"] = _kingdon(x, p)
    except ModuleNotFoundError as missing:
        left_out.append(f"kingdon: not installed ({missing.name})")
    _check(calls, function, elements, x, p)
    return calls


@contextmanager
def _as_numpy() -> Iterator[None]:
    kept = os.environ.get("MOTORCADE_PROGRAMS")
    os.environ["MOTORCADE_PROGRAMS"] = "numpy"
    try:
        yield
    finally:
        del os.environ["MOTORCADE_PROGRAMS"]
        if kept is not None:
            os.environ["MOTORCADE_PROGRAMS"] = kept


def _check(
    calls: Calls, function: CompiledFunction, elements: FloatArray, x: Multivector, p: Multivector
) -> None:
    """Refuse ways that do not give what plain multivectors do."""
    expected = x * p * ~x
    blades = function.program.tape.outputs[0].components
    wanted = np.stack([np.asarray(expected[blade]) for blade in blades], axis=-1)
    for way, call in calls.items():
        made: Any = call()
        if way == "kingdon":
            made = np.stack([_of_kingdon(made, mask) for mask in _VECTORS], axis=-1)
            whole = dict(zip(*_orthogonal(expected), strict=True))
            against = np.stack([np.asarray(whole[mask]) for mask in _VECTORS], axis=-1)
        else:
            against = wanted
        if isinstance(made, Multivector):
            made = np.stack([np.asarray(made[blade]) for blade in blades], axis=-1)
        if way == "the shipped kernel":
            made = np.concatenate([made, wanted[..., 3:]], axis=-1)
        tolerance = 1e-4 if made.dtype == np.float32 else 1e-10
        if not np.allclose(made, against, rtol=tolerance, atol=tolerance * np.abs(against).max()):
            raise RuntimeError(f"bench programs: {way}: expected what plain multivectors give")


def _of_kingdon(made: Any, mask: int) -> FloatArray:
    value: FloatArray = np.asarray(made.values()[made.keys().index(mask)])
    return value


def _kingdon(x: Multivector, p: Multivector) -> Callable[[], object]:
    """The same in kingdon, on the orthogonal basis that it has; it compiles products itself.

    Its function of the sandwich is taken where that gives what its products give, which of
    elements with all even blades it does not (kingdon 3.0.0).
    """
    from kingdon import Algebra

    algebra = Algebra(4, 1, 0)

    def made(element: Multivector) -> Any:
        whole = element.as_orthogonal()
        keys, values = [], []
        for mask, value in zip(whole.masks, whole.values, strict=True):
            keys.append(mask)
            values.append(np.asarray(value) if np.ndim(value) else float(value))
        return algebra.multivector(keys=tuple(keys), values=values)

    one, other = made(x), made(p)
    whole = one * other * ~one
    alike = all(
        np.allclose(_of_kingdon(one.sw(other), mask), _of_kingdon(whole, mask)) for mask in _VECTORS
    )
    return (lambda: one.sw(other)) if alike else (lambda: one * other * ~one)


def _clifford_us(
    element: FloatArray, blades: str, count: int, seconds: float, left_out: list[str]
) -> dict[str, float]:
    """The same in clifford, which takes one element at a time."""
    try:
        from clifford import Cl
    except ModuleNotFoundError as missing:
        left_out.append(f"clifford: not installed ({missing.name})")
        return {}
    layout, _ = Cl(4, 1)
    places = {blade: k for k, blade in enumerate(layout.bladeTupList)}

    def made(values: FloatArray, names: str) -> Any:
        whole = CGA3.multivector(dict(zip(names.split(), values.tolist(), strict=True)))
        row = np.zeros(32)
        for mask, value in zip(*_orthogonal(whole), strict=True):
            row[places[tuple(k + 1 for k in range(5) if mask >> k & 1)]] = value
        return layout.MultiVector(row)

    x, p = made(element, blades), made(np.array([1.0, 2.0, 3.0, 1.0, 7.0]), POINT)
    return {"clifford": 1e6 * count * median_seconds(lambda: x * p * ~x, seconds)}


def _orthogonal(x: Multivector) -> tuple[tuple[int, ...], tuple[Any, ...]]:
    whole = x.as_orthogonal()
    return whole.masks, whole.values


def _joints(left_out: list[str]) -> dict[str, dict[str, float]]:
    """Nanoseconds a joint of the script of a motor's log and exp, and of the shipped kernel."""
    program = compile_script(read_script(SCRIPT), "motor")
    function = CompiledFunction(program, single=False)
    found: dict[str, dict[str, float]] = {}
    rng = np.random.default_rng(3)
    with on_one_core():
        for scalar in ("float32", "float64"):
            poses = Motor.random(rng, (2, JOINTS)).coefficients.astype(scalar)
            given = [*poses[0].T.copy(), *poses[1].T.copy(), np.full(JOINTS, 0.3, scalar)]
            own: dict[str, float] = {}
            if function.wait(scalar):
                spent = median_seconds(partial(function.arrays, *given), SECONDS)
                own["script, compiled at run time"] = 1e9 * spent / JOINTS
            else:
                left_out.append(f"script as C: {function.backend(scalar)}")
            blocks = [kernels.Block(8, JOINTS, scalar) for _ in range(2)]
            for block, pose in zip(blocks, poses, strict=True):
                block.array[:] = pose
            out = kernels.Block(OUTPUTS, JOINTS, scalar)
            spent = seconds_a_call("screw_blend_matrix", SECONDS, *blocks, 0.3, out)
            own["the shipped kernel"] = 1e9 * spent / JOINTS
            found[scalar] = own
    return found


def programs_table(found: Mapping[str, Any]) -> str:
    """Microseconds a call, a row a way; nanoseconds a joint."""
    lines = []
    for name in ("motor on a point", "even versor on a point"):
        sizes = found[name]
        lines.append(f"{name:<32}{'one, us':>12}{f'{ROWS}, us':>14}")
        for way, spent in sizes["one"].items():
            lines.append(f"{way:<32}{spent:>12.2f}{sizes['many'][way]:>14.1f}")
        lines.append("")
    lines.append(f"{'motor log and exp, ns a joint':<32}{'float32':>12}{'float64':>14}")
    for way in found["joint"]["float32"]:
        own = [found["joint"][scalar][way] for scalar in ("float32", "float64")]
        lines.append(f"{way:<32}{own[0]:>12.2f}{own[1]:>14.2f}")
    lines += ["", f"threads: {found['threads']}; joints on one core"]
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)
