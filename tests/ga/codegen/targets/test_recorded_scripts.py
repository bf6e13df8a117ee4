"""Scripts are recorded without CasADi too, and mean the same."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen import programs
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.recording import Symbol, recorded_symbols
from motorcade.ga.codegen.tape import Operand, run_tape
from motorcade.ga.script import evaluate, parse
from tests.ga.codegen.targets.conftest import scripts


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Program]:
    """Compiles a text as where CasADi is not installed."""
    monkeypatch.setattr(programs, "find_spec", lambda name: None)
    return lambda text: compile_script(parse(text), "scene")


def computed(program: Program, values: dict[str, Any]) -> dict[str, Any]:
    rows = run_tape(program.tape, {(name, 0): value for name, value in values.items()})
    return {
        o.name: program.algebra.multivector(dict(zip(o.components, row, strict=True)))
        for o, row in zip(program.tape.outputs, rows, strict=True)
    }


@pytest.mark.parametrize("name", list(scripts()))
def test_what_is_recorded_means_what_evaluation_says(
    name: str, recorded: Callable[[str], Program], cases: Any
) -> None:
    program, case = recorded(scripts()[name]), cases(name, "float64")
    assert {o.name: o.components for o in program.tape.outputs} == {
        o.name: o.components for o in case.program.tape.outputs
    }
    head = {key: value[:500] for key, value in case.inputs.items()}
    made = run_tape(program.tape, {(key, 0): value for key, value in head.items()})
    for operand, row in zip(program.tape.outputs, made, strict=True):
        for blade, value in zip(operand.components, row, strict=True):
            wanted = case.expected[operand.name][blade][:500]
            size = max(np.abs(v[:500]).max() for v in case.expected[operand.name].values())
            np.testing.assert_allclose(
                np.broadcast_to(value, wanted.shape), wanted, rtol=1e-9, atol=1e-11 * size
            )


def test_random_scripts_mean_what_they_say(
    random_script: Callable[[np.random.Generator], str], recorded: Callable[[str], Program]
) -> None:
    rng = np.random.default_rng(20)
    compared = 0
    while compared < 25:
        text = random_script(rng)
        program = recorded(text)
        values = {o.name: rng.uniform(0.5, 1.5) for o in program.tape.inputs}
        made, expected = computed(program, values), evaluate(parse(text), **values)
        for name, wanted in expected.items():
            size = max(map(abs, wanted.values), default=1.0)
            assert made[name].isclose(wanted, rtol=1e-9, atol=1e-9 * size), text
        compared += 1


def test_nothing_of_casadi_is_loaded_and_every_target_is_written(tmp_path: Path) -> None:
    text = "?a = exp(x*e1^e2)*(y*e1 + z*e2) + step(w)*e3 + abs(x*e1 + 2*e2);\n?b = 2;"
    (tmp_path / "scene.clu").write_text(text)
    use = (
        "import sys; sys.modules['casadi'] = None\n"
        "from pathlib import Path\n"
        "from motorcade.ga.codegen.generate import generate\n"
        "from motorcade.ga.codegen.targets import TARGETS\n"
        "for target in TARGETS: assert generate(Path('scene.clu'), target=target).files\n"
        "print(len(TARGETS))"
    )
    done = subprocess.run(
        [sys.executable, "-c", use], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert int(done.stdout) >= 12


BRANCHES = """
k = 0;
loop { if (k == 2) { break; } k = k + 1; }
if (x < y && k > 1) { v = x*e1; } else { v = y*e2 + k*e1; }
if (0*x + 1 > 0) { w = 1; } else { w = 2; }
?v; ?w;
"""


@pytest.mark.parametrize(("x", "y"), [(1.0, 2.0), (2.0, 1.0)])
def test_branches_are_recorded(recorded: Callable[[str], Program], x: float, y: float) -> None:
    made, expected = (
        computed(recorded(BRANCHES), {"x": x, "y": y}),
        evaluate(parse(BRANCHES), x=x, y=y),
    )
    for name, wanted in expected.items():
        assert made[name].isclose(wanted)


def alone(code: str, folder: Path) -> str:
    """What Python code prints where CasADi cannot be imported."""
    (folder / "blocked.py").write_text(f"import sys\nsys.modules['casadi'] = None\n{code}")
    done = subprocess.run(
        [sys.executable, "blocked.py"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_functions_are_compiled_without_casadi(tmp_path: Path) -> None:
    made = alone(
        """
import numpy as np
from motorcade.ga import CGA3, compile
from motorcade.ga.codegen import program
from motorcade.ga.codegen.functions import compile_function
motor = "1 e2^e3 e3^e1 e1^e2 e1^einf e2^einf e3^einf e1^e2^e3^einf"

@program(point="e1 e2 e3 e0 einf", motor=motor)
def moved(point, motor, angle):
    turned = motor.sandwich(point)
    return {"at": turned, "half": (0.5*angle*CGA3.blade("e1^e2")).exp() * motor}

rng = np.random.default_rng(1)
point, versor = rng.normal(size=5), rng.normal(size=8)
made = moved.arrays(point, versor, 0.3)
x = CGA3.multivector(dict(zip("e1 e2 e3 e0 einf".split(), point)))
m = CGA3.multivector(dict(zip(motor.split(), versor)))
same = m.sandwich(x)
blades = moved.program.tape.outputs[0].components
print(np.allclose(made["at"], [same[blade] for blade in blades]))
def square(a):
    return a * a

print(compile_function(square, a="e1 e2").arrays(np.array([3.0, 4.0])))
print(compile("?a = abs(x*e1 + 2*e2);")(x=1.5)["a"]["1"])

def branched(a):
    return a if a.values[0] > 0 else -a

try:
    program(branched)
except ValueError as refused:
    print(refused)
""",
        tmp_path,
    )
    assert made.splitlines()[:3] == ["True", "25.0", "2.5"]
    assert "expected the same operations for all values, got a branch on one" in made


def test_strategies_need_no_casadi(tmp_path: Path) -> None:
    text = "m = exp(x*e1^e2); ?a = m*(y*e1 + e2*z)*~m; ?b = abs(a)*step(w); ?c = *a . e1;"
    (tmp_path / "scene.clu").write_text(text)
    use = """
from pathlib import Path
from motorcade.ga.codegen.generate import STRATEGIES, generate
for strategy in STRATEGIES:
    files = generate(Path('scene.clu'), strategy=strategy).files
    print(strategy, 'void scene(' in files['scene.c'])
"""
    assert set(alone(use, tmp_path).splitlines()) == {
        "table True",
        "table-code True",
        "product True",
    }


def test_mistakes_are_those_of_scripts(recorded: Callable[[str], Program]) -> None:
    with pytest.raises(ValueError, match="scene: expected finite values, got nan"):
        recorded("?a = x + log(0*x - 1);")
    with pytest.raises(ValueError, match="expected a script with outputs, got none"):
        recorded("a = x;")
    assert recorded("?a = x - x;").tape.outputs[0].components == ()
    assert recorded("?a = 3*e1;").tape.operations() == {}


def test_a_symbol_is_a_scalar_and_has_no_truth_value() -> None:
    ((x, y),) = recorded_symbols([Operand("v", ("e1", "e2"))])
    assert (x - x).is_zero()
    assert not (x - y).is_zero()
    assert isinstance(np.float64(2.0) * x, Symbol)
    assert (2.0 * x * np.float64(3.0)).node == (x * 2.0 * 3.0).node
    for ask in (lambda: bool(x < y), lambda: x in (1.0,), lambda: {x: 1}):
        with pytest.raises(TypeError, match=r"truth value|unhashable"):
            ask()
    with pytest.raises(TypeError):
        x + "text"
    with pytest.raises(TypeError, match="the value of a symbol is not known"):
        float(x)
    assert float(x - x + 2.0) == 2.0
    assert [repr(one) for one in (x, y, x - x)] == ["v", "v1", "0.0"]
