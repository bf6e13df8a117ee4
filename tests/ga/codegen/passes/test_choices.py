"""A choice inside one by the same condition is not made again, and values stay what they were."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga.codegen.passes.choices import without_repeated_choices
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.tape import run_tape
from motorcade.ga.script import parse


def test_inner_choices_go_with_their_condition(nodes: Callable[..., Any]) -> None:
    tape = nodes("x", "y")
    condition = tape("lt", 0, 1)
    inner = tape("select", condition, 0, 1)
    kept = tape("keep", condition, tape("sin", 1))
    tape("select", condition, tape("mul", inner, kept), tape("add", inner, kept))
    made = without_repeated_choices(tape.tape())
    assert made.operations() == {"lt": 1, "mul": 1, "select": 1, "sin": 1}
    rng = np.random.default_rng(1)
    inputs = {("x", 0): rng.normal(size=50), ("y", 0): rng.normal(size=50)}
    np.testing.assert_array_equal(run_tape(made, inputs), run_tape(tape.tape(), inputs))


def test_choices_by_other_conditions_stay(nodes: Callable[..., Any]) -> None:
    tape = nodes("x", "y")
    inner = tape("select", tape("lt", 0, 1), 0, 1)
    tape("select", tape("le", 1, 0), tape("sin", inner), inner)
    assert without_repeated_choices(tape.tape()).operations() == tape.tape().operations()


def test_a_side_that_would_have_to_be_computed_twice_stays(nodes: Callable[..., Any]) -> None:
    """A quotient that is used elsewhere too; the other side loses its inner choice."""
    tape = nodes("x", "y")
    condition = tape("lt", 0, 1)
    shared = tape("div", 0, tape("select", condition, 0, 1))
    inner = tape("select", condition, 1, tape("sin", 1))
    outer = tape("select", condition, tape("add", shared, 0), tape("mul", inner, inner))
    tape("add", outer, shared)
    made = without_repeated_choices(tape.tape())
    assert made.operations() == {"add": 2, "div": 1, "lt": 1, "mul": 1, "select": 2, "sin": 1}
    rng = np.random.default_rng(1)
    inputs = {("x", 0): rng.normal(size=50), ("y", 0): rng.normal(size=50)}
    np.testing.assert_array_equal(run_tape(made, inputs), run_tape(tape.tape(), inputs))


@pytest.mark.parametrize("seed", range(8))
def test_values_of_functions_stay_what_they_were(seed: int) -> None:
    script = parse("//#pragma algebra cga3\n?m = exp(t*log(a + b*e1^e2 + c*e1^einf + d*e0^einf));")
    tape = compile_script(script, "power").tape
    made = without_repeated_choices(tape)
    assert len(made.nodes) < len(tape.nodes)
    rng = np.random.default_rng(seed)
    drawn = {o.name: rng.normal(size=200) for o in tape.inputs}
    drawn["a"] = np.abs(drawn["a"]) + rng.choice([0.0, 50.0], 200)
    inputs = {(name, 0): values for name, values in drawn.items()}
    for row, expected in zip(run_tape(made, inputs), run_tape(tape, inputs), strict=True):
        np.testing.assert_allclose(row, expected, rtol=1e-12, equal_nan=True)
