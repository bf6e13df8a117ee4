"""Tapes that are read back from CasADi: the values of its own functions, powers by products."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.recording import trace
from motorcade.ga.codegen.tape import Operand, Tape, run_tape

ca = pytest.importorskip("casadi")
ONE = Operand("x", ("1",))


def traced(function: Callable[[Any], Any]) -> Tape:
    return trace("made", [ONE], [Operand("y", ("1",))], lambda x: [[function(x[0])]])


@pytest.mark.parametrize("exponent", [0, 1, 2, 3, 7, 64, -1, -2, -5, 0.5, 1.5, -0.5, -2.5, 63.5])
def test_whole_and_half_powers_are_products_and_roots(exponent: float) -> None:
    tape = traced(lambda x: ca.power(x, exponent) * 1.25)
    x = np.array([0.3, 1.0, 2.7])
    made = np.broadcast_to(run_tape(tape, {("x", 0): x})[0][0], 3)
    np.testing.assert_allclose(made, 1.25 * x**exponent, rtol=1e-14)
    assert not {node.op for node in tape.nodes} & {"exp", "log"}
    assert len(tape.nodes) <= 2 * np.log2(max(2, abs(exponent))) + 6


@pytest.mark.parametrize("exponent", [0.3, -1.7, 64.5, -65.5])
def test_other_powers_go_through_logarithms(exponent: float) -> None:
    tape = traced(lambda x: ca.power(x, exponent))
    x = np.array([0.9, 1.0, 1.1])
    np.testing.assert_allclose(run_tape(tape, {("x", 0): x})[0][0], x**exponent, rtol=1e-12)
    assert {"exp", "log"} <= {node.op for node in tape.nodes}


def test_powers_of_two_variables_are_those_of_casadi() -> None:
    tape = trace(
        "made",
        [Operand("x", ("1", "e1"))],
        [Operand("y", ("1",))],
        lambda x: [[ca.power(x[0], x[1])]],
    )
    x = np.array([0.4, 1.9]), np.array([-1.2, 3.1])
    made = run_tape(tape, {("x", 0): x[0], ("x", 1): x[1]})[0][0]
    np.testing.assert_allclose(made, x[0] ** x[1], rtol=1e-14)


def test_operations_that_no_target_has_are_named() -> None:
    with pytest.raises(ValueError, match="made: expected operations that the emitters know, got"):
        traced(ca.erf)


def test_outputs_of_another_width_are_refused() -> None:
    with pytest.raises(ValueError, match=r"made: expected outputs of \[1\] components, got \[2\]"):
        trace("made", [ONE], [Operand("y", ("1",))], lambda x: [[x[0], x[0]]])
