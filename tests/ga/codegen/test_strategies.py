"""Every strategy computes what the script says, in calls as its model has them."""

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.strategies import product, table
from motorcade.ga.codegen.targets import c
from motorcade.ga.script import Script, evaluate, parse
from motorcade.ga.script.syntax import RangePragma

COMPILER = shutil.which("gcc") or shutil.which("cc")
WARNINGS = ["-std=c99", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror"]
SCRIPTS = Path(__file__).parents[3] / "docs" / "scripts"
EXAMPLES = sorted(path.stem for path in SCRIPTS.glob("*.clu"))
SNIPPETS = {
    "products": "a = x*e1 + y*e2^einf; b = 2 - z*e3*e0; ?p = a*b; ?o = a^b; ?i = a.b; ?d = *a;",
    "sums": "a = x*e1 + 1; b = y*e2 - x*e1; ?s = a + b; ?d = b - a; ?n = -a; ?m = 2 - b;",
    "inverses": "v = x*e1 + y*e2 + z*e3; ?i = 1/v; ?m = invert(2 + x*e1^e2 + y*e1^e2^e3^einf);",
    "anything": "//#pragma algebra 2 0 0\n?i = invert(3 + x*e1 + y*e1^e2); ?q = x / (2 + y*e2);",
    "functions": "c = cos(x)*e1 + atan2(y, 2)*e2; ?n = abs(c)*max(x, y)*c; ?h = step(x);",
    "parts": "//#pragma output p 1 e1^e2\np = (1 + x*e1 + y*e2)*(z + e1 - x*e2);",
    "nothing": "?z = e1^e1 + 0*x; ?c = 2*e1^e2 + 3; ?x;",
    "macros": "turn = { _P(1)*_P(2)*~_P(1) } r = 1 + x*e1^e2; ?a = turn(r, turn(r, e1 + y*e3));",
    "projective": "//#pragma algebra pga3\nm = 1 + x*e0^e1 - y*e1^e2; ?p = m*e1^e2^e3*~m;",
    "names": "t0 = x*e1; ?v1 = t0*e2 + s0*in; ?names_mv = names_steps*t0; ?x = in + t1;",
    "nested": "?d = Dual(VecN3(x, y, z)); ?s = SphereN3(x, y, z, 2)/normalize(e1 + y*e2);",
}
Write = Callable[..., dict[str, str]]
STRATEGIES: dict[str, Write] = {
    "table": table.write,
    "table-code": table.write_code,
    "product": product.write,
}


def texts() -> dict[str, str]:
    found = {name: (SCRIPTS / f"{name}.clu").read_text() for name in EXAMPLES}
    return found | SNIPPETS


def inputs(
    script: Script, program: Program, rng: np.random.Generator, rows: int
) -> dict[str, np.ndarray]:
    bounds = {p.name: (p.low, p.high) for p in script.pragmas if isinstance(p, RangePragma)}
    names = [operand.name for operand in program.tape.inputs]
    anywhere = (0.2, 2.0) if program.name in EXAMPLES else (-2.0, 2.0)
    return {name: rng.uniform(*bounds.get(name, anywhere), rows) for name in names}


def computed(
    strategy: Write,
    script: Script,
    program: Program,
    given: dict[str, np.ndarray],
    folder: Path,
    precision: Precision = DOUBLE,
) -> dict[str, np.ndarray]:
    """The outputs of the compiled code, each of shape (rows, blades)."""
    for file, text in strategy(script, program, precision).items():
        (folder / file).write_text(text)
    library = folder / f"{program.name}.so"
    source = folder / f"{program.name}.c"
    build = [str(COMPILER), *WARNINGS, "-shared", "-fPIC", str(source), "-lm", "-o", str(library)]
    done = subprocess.run(build, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    real = ctypes.c_double if precision is DOUBLE else ctypes.c_float
    function = getattr(ctypes.CDLL(str(library)), program.name)
    outputs = [operand for operand in program.tape.outputs if operand.components]
    function.argtypes = [real] * len(given) + [ctypes.POINTER(real)] * len(outputs)
    rows = len(next(iter(given.values())))
    made = {o.name: np.zeros((rows, o.width), dtype=precision.numpy) for o in outputs}
    places = [(made[o.name].ctypes.data, made[o.name].strides[0]) for o in outputs]
    for k, values in enumerate(zip(*given.values(), strict=True)):
        out = (ctypes.cast(at + k * step, ctypes.POINTER(real)) for at, step in places)
        function(*values, *out)
    return made


@pytest.mark.quick_every(4)
@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("strategy", STRATEGIES.values(), ids=STRATEGIES)
@pytest.mark.parametrize("name", [*EXAMPLES, *SNIPPETS])
def test_compiled_calls_compute_what_the_script_says(
    name: str, strategy: Write, rng: np.random.Generator, tmp_path: Path
) -> None:
    script = parse(texts()[name])
    program = compile_script(script, name)
    given = inputs(script, program, rng, 10_000)
    made = computed(strategy, script, program, given, tmp_path)
    expected = evaluate(script, None, **given)
    for output in filter(lambda operand: operand.components, program.tape.outputs):
        values = [expected[output.name].coefficient(blade) for blade in output.components]
        rows = np.stack([np.broadcast_to(value, 10_000) for value in values], axis=1)
        scale = np.maximum(1.0, np.linalg.norm(rows, axis=1, keepdims=True))
        assert np.max(np.abs(made[output.name] - rows) / scale) < 1e-12


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("strategy", STRATEGIES.values(), ids=STRATEGIES)
def test_single_precision_is_written_in_floats(
    strategy: Write, rng: np.random.Generator, tmp_path: Path
) -> None:
    script = parse(texts()["table2"])
    program = compile_script(script, "table2")
    given = inputs(script, program, rng, 100)
    made = computed(strategy, script, program, given, tmp_path, SINGLE)
    expected = evaluate(script, None, **given)["t"]
    assert "double" not in (tmp_path / "table2.c").read_text()
    for k, blade in enumerate(program.tape.outputs[-1].components):
        value = np.broadcast_to(expected.coefficient(blade), 100)
        np.testing.assert_allclose(made["t"][:, k], value, rtol=3e-4, atol=3e-4)


def test_a_table_is_interpreted_once_for_each_product() -> None:
    script = parse("a = x*e1 + y*e2; b = a*a*a; ?c = b*b + (a^b);")
    text = table.write(script, compile_script(script, "script"), None)["script.c"]
    assert text.count("script_product(&script_geometric, ") == 5
    assert text.count("script_product(&script_outer, ") == 1
    assert text.count("static script_mv script_product(") == 1


def test_a_table_as_code_has_one_function_for_each_kind_of_product() -> None:
    script = parse("a = x*e1 + y*e2; b = a*a*a; ?c = b*b + (a^b);")
    text = table.write_code(script, compile_script(script, "script"), None)["script.c"]
    assert text.count("script_geometric(&") == 5
    assert text.count("static script_mv script_geometric(") == 1
    assert text.count("static script_mv script_outer(") == 1
    assert "_terms" not in text


def test_equal_types_share_a_function_and_equal_products_are_done_again() -> None:
    script = parse("a = x*e1 + y*e2; b = z*e1 + x*e2; ?c = a*b; ?d = b*a; ?e = a*b;")
    text = product.write(script, compile_script(script, "script"), None)["script.c"]
    function = next(line for line in text.splitlines() if "geometric_mv3_mv3" in line)
    called = function.split()[3].split("(")[0]
    assert text.count(f"{called}(const") == 1
    assert text.count(f" = {called}(v") == 3


def test_the_page_on_strategies_shows_what_they_write() -> None:
    page = (SCRIPTS.parent / "strategies.md").read_text()
    (clu,) = re.findall(r"```clu\n(.*?)```", page, re.DOTALL)
    shown = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    script = parse(clu)
    program = compile_script(script, "square")
    written = [write(script, program, None) for write in STRATEGIES.values()]
    written.append(c.write(program, None))
    assert len(shown) == len(written)
    for snippet, files in zip(shown, written, strict=True):
        assert all(line in files["square.c"] for line in snippet.splitlines())
