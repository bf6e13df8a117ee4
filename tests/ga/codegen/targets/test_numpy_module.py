"""A script as a NumPy module says what its evaluation says, in the type and shape of its inputs."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import DOUBLE, SINGLE
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets.numpy import write
from motorcade.ga.script import parse

MIXED = "?b = x*e1 + 2*e2;\n?a = x*y*e1 + 3;\n?zero = y*e1 - y*e1;\n?x;"


def written(text: str, loaded: Callable[[str, str], Any], precision: Any = None) -> Any:
    files = write(compile_script(parse(text), "mixed"), precision)
    assert list(files) == ["mixed.py"]
    return loaded(files["mixed.py"], "mixed")


@pytest.mark.parametrize(("precision", "bound"), [("float64", 1e-12), ("float32", 1e-5)])
def test_it_agrees_with_evaluation(
    script: str, precision: str, bound: float, cases: Any, loaded: Any
) -> None:
    case = cases(script, precision)
    (text,) = write(case.program, None).values()
    made = getattr(loaded(text, script), script)(**case.inputs)
    case.checked(made, bound)
    assert all(v.dtype == precision for blades in made.values() for v in blades.values())


def test_a_module_has_one_function_and_needs_numpy_only(loaded: Any) -> None:
    module = written(MIXED, loaded)
    public = {name for name in vars(module) if not name.startswith("_")}
    assert public == {"mixed", "np"}
    assert module.__all__ == ["mixed"]
    assert module.mixed.__code__.co_varnames[: module.mixed.__code__.co_argcount] == ("x", "y")


def test_outputs_come_in_the_order_of_the_script(loaded: Any) -> None:
    made = written(MIXED, loaded).mixed(x=2.0, y=3.0)
    assert made == {
        "b": {"e1": 2.0, "e2": 2.0},
        "a": {"1": 3.0, "e1": 6.0},
        "zero": {},
        "x": {"1": 2.0},
    }
    assert list(made) == ["b", "a", "zero", "x"]
    assert all(type(v) is np.float64 for blades in made.values() for v in blades.values())


def test_all_components_have_the_shape_to_which_the_variables_broadcast(loaded: Any) -> None:
    x, y = np.arange(3.0)[:, None], np.arange(4.0)
    made = written(MIXED, loaded).mixed(x=x, y=y)
    assert {v.shape for blades in made.values() for v in blades.values()} == {(3, 4)}
    np.testing.assert_array_equal(made["a"]["e1"], x * y)
    made["x"]["1"][:] = 7.0
    np.testing.assert_array_equal(x[:, 0], np.arange(3.0))


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        ((np.float32(1), np.float32(2)), "float32"),
        ((np.ones(2, np.float32), 2.0), "float32"),
        ((np.ones(2, np.float32), 2), "float32"),
        ((np.ones(2, np.float32), np.float64(2)), "float64"),
        ((1, 2), "float64"),
        (([1, 2], np.ones(2, np.int8)), "float64"),
    ],
)
def test_the_type_is_that_of_the_variables(given: Any, kind: str, loaded: Any) -> None:
    made = written(MIXED, loaded).mixed(*given)
    assert {v.dtype for blades in made.values() for v in blades.values()} == {np.dtype(kind)}


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE], ids=lambda p: p.numpy)
def test_a_precision_is_that_of_the_results(precision: Any, loaded: Any) -> None:
    made = written(MIXED, loaded, precision).mixed(x=np.ones(2), y=1.0)
    assert made["a"]["e1"].dtype == precision.numpy


def test_constants_need_no_variables(loaded: Any) -> None:
    made = written("?a = 2*e1 + sqrt(2);", loaded).mixed()
    assert made == {"a": {"1": np.sqrt(2.0), "e1": 2.0}}


def test_what_is_no_real_number_is_refused(loaded: Any) -> None:
    with pytest.raises(TypeError, match="mixed: expected real numbers, got complex128"):
        written(MIXED, loaded).mixed(x=1j, y=np.ones(2))


def test_outside_a_domain_the_result_is_nan_without_a_warning(loaded: Any) -> None:
    made = written("?a = sqrt(x)/y;", loaded).mixed(x=[-1.0, 4.0], y=[1.0, 0.0])
    np.testing.assert_array_equal(made["a"]["1"], [np.nan, np.inf])
