"""A script as a torch module says what its evaluation says, and its gradients are CasADi's."""

from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import casadi
from motorcade.ga.codegen.targets import torch as target
from motorcade.ga.script import parse

torch = pytest.importorskip("torch", reason="torch is not installed")

MIXED = "?b = x*e1 + 2*e2;\n?a = x*y*e1 + 3;\n?zero = y*e1 - y*e1;\n?x;"


def function(program: Any, loaded: Any) -> Any:
    (text,) = target.write(program, None).values()
    return getattr(loaded(text, program.name), program.name)


def mixed(loaded: Any) -> Any:
    return function(compile_script(parse(MIXED), "mixed"), loaded)


@pytest.mark.parametrize(("precision", "bound"), [("float64", 1e-12), ("float32", 1e-5)])
def test_it_agrees_with_evaluation(
    script: str, precision: str, bound: float, cases: Any, loaded: Any
) -> None:
    case = cases(script, precision)
    given = {name: torch.from_numpy(values) for name, values in case.inputs.items()}
    made = function(case.program, loaded)(**given)
    case.checked(made, bound)
    assert {str(v.dtype) for blades in made.values() for v in blades.values()} == {
        f"torch.{precision}"
    }


def test_gradients_are_those_of_casadi(script: str, cases: Any, loaded: Any) -> None:
    case = cases(script, "float64")
    given = {
        variable: torch.tensor(values[:64], requires_grad=True)
        for variable, values in case.inputs.items()
    }
    made = function(case.program, loaded)(**given)
    (text,) = casadi.write(case.program, None).values()
    symbolic = getattr(loaded(text, script), script)()
    derivative = symbolic.jacobian().map(64)(**{n: v[None, :64] for n, v in case.inputs.items()})
    for output, blades in made.items():
        for place, value in enumerate(blades.values()):
            tensors = list(given.values())
            gradients = (
                torch.autograd.grad(value.sum(), tensors, retain_graph=True, allow_unused=True)
                if value.requires_grad
                else [None] * len(tensors)
            )
            for variable, gradient in zip(given, gradients, strict=True):
                rows = np.array(derivative[f"jac_{output}_{variable}"])[place]
                found = np.zeros(64) if gradient is None else gradient.numpy()
                np.testing.assert_allclose(found, rows, rtol=1e-9, atol=1e-9)


def test_components_broadcast_and_keep_the_type(loaded: Any) -> None:
    x = torch.ones(3, 1, dtype=torch.float32)
    made = mixed(loaded)(x=x, y=torch.arange(4, dtype=torch.float32))
    parts = [v for blades in made.values() for v in blades.values()]
    assert {v.shape for v in parts} == {(3, 4)}
    assert {v.dtype for v in parts} == {torch.float32}
    made["x"]["1"][:] = 7.0
    assert (x == 1.0).all()


def test_whole_numbers_become_the_default_type_and_plain_numbers_are_refused(loaded: Any) -> None:
    made = mixed(loaded)(x=torch.tensor(1), y=torch.tensor(2))
    assert made["a"]["e1"].dtype == torch.get_default_dtype()
    with pytest.raises((TypeError, AttributeError)):
        mixed(loaded)(x=1.0, y=torch.tensor(2))
    with pytest.raises(TypeError, match=r"expected real numbers, got torch\.complex64"):
        mixed(loaded)(x=torch.tensor(1j), y=torch.tensor(2))
