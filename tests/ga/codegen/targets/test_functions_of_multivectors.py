"""Programs traced from Python functions: a parameter on several blades is one number a blade."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from motorcade.ga.algebra import EGA3
from motorcade.ga.codegen.functions import compile_function
from motorcade.ga.codegen.targets import TARGETS


def turned(rotor: Any, x: Any, unread: Any) -> Any:
    e1 = EGA3.blade("e1")
    return {"image": rotor * (x * e1) * ~rotor, "norm": rotor.norm()}


TURNED = compile_function(turned, algebra=EGA3, rotor="1 e1^e2 e2^e3", unread="e1 e2")
NAMES = ["rotor0", "rotor1", "rotor2", "x", "unread0", "unread1"]


def written(target: str) -> str:
    return next(iter(TARGETS[target](TURNED.program, None).values()))


@pytest.fixture
def values(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0.5, 2.0, (6, 100))


def expected(values: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
    rotor = EGA3.multivector(dict(zip(["1", "e1^e2", "e2^e3"], values[:3], strict=True)))
    made = turned(rotor, values[3], None)
    return {
        o.name: {
            b: (made[o.name].coefficient(b) if o.name == "image" else made[o.name])
            for b in o.components
        }
        for o in TURNED.program.tape.outputs
    }


def test_the_numpy_module_takes_components(values: np.ndarray, loaded: Any) -> None:
    made = loaded(written("numpy"), "turned").turned(**dict(zip(NAMES, values, strict=True)))
    for name, blades in expected(values).items():
        for blade, value in blades.items():
            np.testing.assert_allclose(made[name][blade], value, rtol=1e-13, atol=1e-13)


def test_the_casadi_function_takes_components(values: np.ndarray, loaded: Any) -> None:
    function = loaded(written("casadi"), "turned").turned()
    assert function.name_in() == NAMES
    made = function(**{name: ca.DM(row).T for name, row in zip(NAMES, values, strict=True)})
    for name, blades in expected(values).items():
        np.testing.assert_allclose(np.array(made[name]), list(blades.values()), rtol=1e-13)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")
def test_c_takes_components(values: np.ndarray, tmp_path: Path) -> None:
    (tmp_path / "turned.c").write_text(written("c-batch"))
    library = tmp_path / "turned.so"
    flags = ["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", str(tmp_path / "turned.c")]
    subprocess.run(["gcc", *flags, "-lm", "-o", str(library)], check=True)
    wanted = [v for blades in expected(values).values() for v in blades.values()]
    out = np.zeros((len(wanted), 100))
    pointers = [ctypes.c_void_p(row.ctypes.data) for row in (*values, *out)]
    ctypes.CDLL(str(library)).turned(ctypes.c_size_t(100), *pointers)
    np.testing.assert_allclose(out, wanted, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("target", list(TARGETS))
def test_the_comment_tells_the_blades_of_a_parameter(target: str) -> None:
    told = written(target)
    assert f"Inputs, in this order: {' '.join(NAMES)}." in told
    assert "rotor: 1 e1^e2 e2^e3" in told
