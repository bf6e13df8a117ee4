"""Notebooks set multivectors and versors as formulas; what has none is shown as text."""

import numpy as np
import pytest

from motorcade.ga import CGA3, EGA3
from motorcade.ga.drawing.formulas import blade_text, name_text, number_text

MINUS_HALF = {"1": 0.5, "e1^e2": -1.0, "e3": 0.0, "e2^einf": 1.5e-7}


def test_a_multivector_is_a_sum_of_blades() -> None:
    assert CGA3.multivector(MINUS_HALF)._repr_latex_() == (
        r"$\displaystyle 0.5 - \mathbf{e}_{1} \wedge \mathbf{e}_{2} "
        r"+ 1.5 \cdot 10^{-7}\,\mathbf{e}_{2} \wedge \mathbf{e}_{\infty}$"
    )
    assert CGA3.multivector({"e1": -2.0})._repr_latex_() == r"$\displaystyle -2\,\mathbf{e}_{1}$"
    assert CGA3.multivector({"e1": 0.0})._repr_latex_() == r"$\displaystyle 0$"


def test_batches_and_symbols_are_text() -> None:
    assert EGA3.vector([np.zeros(3), 1.0, 2.0])._repr_latex_() is None
    ca = pytest.importorskip("casadi", reason="CasADi is not installed")
    assert EGA3.scalar(ca.SX.sym("x"))._repr_latex_() is None


def test_names_numbers_and_blades() -> None:
    assert [name_text(n) for n in ("x", "x1", "arm", "a_b", "alpha", "_")] == [
        "x", "x_{1}", r"\mathit{arm}", r"\mathit{a\_b}", r"\alpha", r"\mathit{\_}",
    ]  # fmt: skip
    assert [number_text(v) for v in (0.1, -3.0, 1e22)] == ["0.1", "-3", r"1 \cdot 10^{22}"]
    assert (blade_text("1"), blade_text("t^x")) == ("", "t \\wedge x")
