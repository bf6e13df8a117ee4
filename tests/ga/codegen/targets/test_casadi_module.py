"""A script as a CasADi module says what its evaluation says, and has the right derivatives."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from motorcade.ga.codegen.precision import SINGLE
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import casadi, numpy
from motorcade.ga.script import parse


def function(program: Any, loaded: Any) -> Any:
    (text,) = casadi.write(program, None).values()
    return getattr(loaded(text, program.name), program.name)()


def test_it_agrees_with_evaluation(script: str, cases: Any, loaded: Any) -> None:
    case = cases(script, "float64")
    made = function(case.program, loaded)
    assert made.name_in() == list(case.inputs)
    assert made.name_out() == list(case.expected)
    results = made(**{name: values[None] for name, values in case.inputs.items()})
    rows = np.concatenate([np.array(results[name]) for name in case.expected])
    case.checked(case.by_place(rows), 1e-12)


def test_its_derivatives_are_those_of_the_numpy_module(
    script: str, cases: Any, loaded: Any
) -> None:
    case = cases(script, "float64")
    made = function(case.program, loaded)
    (text,) = numpy.write(case.program, None).values()
    plain = getattr(loaded(text, script), script)
    here = {name: values[7] for name, values in case.inputs.items()}
    derivative = made.jacobian()(**here)
    step = 1e-6
    for variable, value in here.items():
        ahead, behind = (plain(**(here | {variable: value + s})) for s in (step, -step))
        for output, blades in ahead.items():
            if not blades:
                continue
            quotient = [(v - behind[output][b]) / (2 * step) for b, v in blades.items()]
            exact = np.array(derivative[f"jac_{output}_{variable}"]).ravel()
            np.testing.assert_allclose(exact, quotient, rtol=1e-6, atol=1e-6 * _size(exact))


def _size(values: np.ndarray) -> float:
    return max(1.0, float(np.abs(values).max()))


def test_an_input_and_an_output_may_have_one_name(loaded: Any) -> None:
    made = function(compile_script(parse("x = x + 1;\n?x;\n?none = y - y;"), "shared"), loaded)
    results = made(x=ca.DM(2.0), y=0.0)
    assert float(results["x"]) == 3.0
    assert results["none"].shape == (0, 1)


def test_it_is_in_double_precision_only() -> None:
    program = compile_script(parse("?a = x;"), "one")
    with pytest.raises(ValueError, match="target casadi: expected precision float64, got float32"):
        casadi.write(program, SINGLE)
