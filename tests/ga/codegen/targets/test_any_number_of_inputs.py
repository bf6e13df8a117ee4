"""What is written parses and runs whatever the number of inputs and the length of their names."""

import ast
from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only code generation needs, is missing")

from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.targets import TARGETS
from motorcade.ga.script import parse

BLADES = ("e1", "e2", "e3")


def sum_of(names: list[str]) -> Program:
    """A script that reads every name once; without names, a constant."""
    terms = [f"{name}*{BLADES[k % 3]}" for k, name in enumerate(names)]
    text = f"//#pragma algebra ega3\n?r = {' + '.join(terms) or '2*e1'};"
    return compile_script(parse(text), "summed")


def names_of(count: int, length: int) -> list[str]:
    return [f"{'a' * max(length - len(str(k)), 1)}{k}" for k in range(count)]


@pytest.mark.parametrize("length", [1, 9, 40])
def test_python_of_any_number_of_inputs_parses(length: int) -> None:
    for count in range(length % 2, 81, 2 if length > 1 else 1):
        program = sum_of(names_of(count, length))
        for target in ("numpy", "torch", "casadi"):
            (text,) = TARGETS[target](program, None).values()
            ast.parse(text)


@pytest.mark.parametrize("length", [2, 12])
def test_it_runs_and_adds_up(length: int, loaded: Any) -> None:
    rng = np.random.default_rng(length)
    for count in (1, 14, 15, 19, 20, 29, 37, 80):
        names = names_of(count, length)
        (text,) = TARGETS["numpy"](sum_of(names), None).values()
        values = rng.normal(size=count)
        result = loaded(text, "summed").summed(**dict(zip(names, values, strict=True)))["r"]
        for k, blade in enumerate(BLADES[:count]):
            np.testing.assert_allclose(result[blade], values[k::3].sum(), rtol=0.0, atol=1e-12)
