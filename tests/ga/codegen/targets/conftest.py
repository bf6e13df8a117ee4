"""Scripts that every target is written from, random inputs, and plain evaluation as the witness.

The error of a result in a row is the largest of its components' errors, over its largest component
or, where that is less than usual, over the median of all rows' largest: what cancels has the error
of what it cancelled from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only code generation needs, is missing")

from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.script import evaluate, parse
from motorcade.ga.script.syntax import RangePragma

ROWS = 10_000
DOCS = Path(__file__).resolve().parents[4] / "docs" / "scripts"

OBJECTS = """
p = createPoint(x, y, z);
q = createPoint(y, z - 1, x + 2);
?sphere = SphereN3(p, 1 + abs(w));
?line = p ^ q ^ einf;
?meet = *(*line . sphere);
?turned = RotorN3(x, y, z, w) * TranslatorN3(z, x, w);
?moved = turned * p * ~turned;
?divided = (p ^ q) / (3 + x*e1^e2);
?mixed = 0.1 + p + x*e1;
?fixed = 2*e1 - 0.1*e1^einf;
?nothing = unread*e1 - e1*unread;
?p;
//#pragma output p e1 e0
"""
FUNCTIONS = """
//#pragma algebra ega3
s = sin(x) + cos(y)*e1 + tan(z/2)*e2 + exp(x/2)*e3 + log(1 + y*y)*e1^e2 + asin(x/3)*e1^e3;
?first = s + acos(y/3)*e2^e3;
?second = atan(z) + floor(3*x)*e1 + ceil(3*y)*e2 + sqrt(abs(z))*e3 + atan2(x, y)*e1^e2;
?third = min(x, y) + max(y, 0.3)*e1 + sign(z)*e2 + step(w)*e3 + fact(4)*e1^e2 + x/(2 + w)*e1^e3;
?rotor = exp(x*e1^e2 + y*e2^e3 + z*e1^e3);
?logarithm = log(rotor);
"""


def spheres_that_meet(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Three spheres through a point well off the plane of their centres."""
    point = rng.uniform(-0.3, 0.3, (3, ROWS))
    drawn = {}
    for k in range(3):
        centre = 2.0 * np.eye(3)[k, :, None] + rng.uniform(-0.3, 0.3, (3, ROWS))
        drawn |= {f"c{k + 1}{axis}": centre[i] for i, axis in enumerate("xyz")}
        drawn[f"r{k + 1}"] = np.linalg.norm(centre - point, axis=0)
    return drawn


def arm_within_reach(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Links that are neither stretched nor folded, the elbow off the axes.

    Where one of its coordinates nearly vanishes, evaluation takes rounding for other blades.
    """
    upper, lower = rng.uniform(1.0, 2.0, (2, ROWS))
    shoulder = rng.integers(4, size=ROWS) * np.pi / 2 + rng.uniform(0.1, np.pi / 2 - 0.1, ROWS)
    forearm = shoulder - rng.uniform(0.5, 2.5, ROWS)
    x, y = (upper * f(shoulder) + lower * f(forearm) for f in (np.cos, np.sin))
    return {"x": x, "y": y, "upper": upper, "lower": lower}


def similarities(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Unit rotors and positive scales."""
    drawn = {}
    for k in "12":
        rotor = rng.normal(size=(4, ROWS))
        rotor /= np.linalg.norm(rotor, axis=0)
        drawn |= {f"{axis}{k}": part for axis, part in zip("wxyz", rotor, strict=True)}
        drawn[f"scale{k}"] = rng.uniform(0.5, 2.0, ROWS)
    return drawn


# What a script's comment asks of its variables beyond ranges.
DOMAINS: dict[str, Callable[[np.random.Generator], dict[str, np.ndarray]]] = {
    "meet_of_spheres": spheres_that_meet,
    "two_link_arm": arm_within_reach,
    "motor_interpolation": similarities,
}


@dataclass(frozen=True)
class Case:
    """A program, inputs of one row each, and what evaluation says of them."""

    program: Program
    inputs: dict[str, np.ndarray]
    expected: dict[str, dict[str, np.ndarray]]

    def checked(self, made: dict[str, Any], bound: float) -> None:
        """Compare a dictionary of dictionaries with evaluation, in the order of the script."""
        assert list(made) == list(self.expected)
        for name, blades in self.expected.items():
            assert list(made[name]) == list(blades)
            if not blades:
                continue
            values = np.stack([np.asarray(value) for value in made[name].values()])
            wanted = np.stack(list(blades.values()))
            assert values.shape == wanted.shape
            size = np.abs(wanted).max(axis=0)
            error = np.abs(values - wanted).max(axis=0) / np.maximum(size, np.median(size))
            assert error.max() <= bound, f"{name}: {error.max():.3g}, row {error.argmax()}"

    def by_place(self, rows: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
        """Components in the order of the program, one a row, by their names."""
        left = iter(rows)
        outputs = self.program.tape.outputs
        return {o.name: {blade: next(left) for blade in o.components} for o in outputs}


def scripts() -> dict[str, str]:
    """The scripts by name: those above and the documented ones."""
    documented = {
        path.stem: path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("*.clu"))
    }
    return {"objects": OBJECTS, "functions": FUNCTIONS, **documented}


@pytest.fixture(scope="session")
def cases() -> Callable[[str, str], Case]:
    """Makes the case of a script and of inputs in a precision, once."""
    programs: dict[str, Program] = {}
    made: dict[tuple[str, str], Case] = {}

    def case(name: str, precision: str) -> Case:
        if name not in programs:
            programs[name] = compile_script(parse(scripts()[name]), name)
        if (name, precision) not in made:
            made[name, precision] = _case(programs[name], scripts()[name], precision)
        return made[name, precision]

    return case


def _case(program: Program, text: str, precision: str) -> Case:
    script = parse(text)
    ranges = {p.name: (p.low, p.high) for p in script.pragmas if isinstance(p, RangePragma)}
    rng = np.random.default_rng(20240229)
    drawn = {
        o.name: rng.uniform(*ranges.get(o.name, (-2.0, 2.0)), ROWS) for o in program.tape.inputs
    }
    drawn |= DOMAINS.get(program.name, lambda rng: {})(rng)
    inputs = {name: values.astype(precision) for name, values in drawn.items()}
    exact = {name: values.astype(np.float64) for name, values in inputs.items()}
    expected = {}
    for name, x in evaluate(script, **exact).items():
        parts = {blade: np.broadcast_to(value, ROWS) for blade, value in x.items()}
        operand = next(o for o in program.tape.outputs if o.name == name)
        expected[name] = {blade: parts[blade] for blade in operand.components}
        left = [values for blade, values in parts.items() if blade not in operand.components]
        size = max([np.abs(values).max() for values in parts.values()], default=0.0)
        assert all(np.abs(values).max() <= 1e-12 * size for values in left), name
    return Case(program, inputs, expected)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Every test that takes a `script` runs for each script."""
    if "script" in metafunc.fixturenames:
        metafunc.parametrize("script", list(scripts()))


@pytest.fixture(scope="session")
def loaded() -> Callable[[str, str], Any]:
    """Runs the text of a module; what it defines comes as attributes."""

    def load(text: str, name: str) -> Any:
        names: dict[str, Any] = {}
        exec(compile(text, f"{name}.py", "exec"), names)
        return SimpleNamespace(**names)

    return load
