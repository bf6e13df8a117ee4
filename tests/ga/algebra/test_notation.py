"""Multivectors are written as scripts write them; notebooks set them and versors as formulas."""

import numpy as np
import pytest

from motorcade.ga import CGA3, EGA3, Algebra, DualQuaternion, Motor, Multivector, Rotor, Similarity
from motorcade.ga.notation import blade_text, name_text, number_text
from motorcade.ga.script import evaluate, parse

MINUS_HALF = {"1": 0.5, "e1^e2": -1.0, "e3": 0.0, "e2^einf": 1.5e-7}


def test_text_is_that_of_a_script(rng: np.random.Generator) -> None:
    assert repr(CGA3.multivector(MINUS_HALF)) == "0.5 - e1^e2 + 1.5e-07*e2^einf"
    assert repr(CGA3.multivector({"e1": -2, "e2": np.float32(0.5)})) == "-2*e1 + 0.5*e2"
    assert repr(CGA3.multivector({"e1": 0.0})) == "0"
    for _ in range(20):
        x = CGA3.multivector(dict(zip(CGA3.blades, rng.normal(size=32), strict=True)))
        assert evaluate(parse(f"?x = {x!r};"))["x"].isclose(x, 1e-6)


def test_batches_are_short() -> None:
    x = EGA3.multivector({"1": np.array([1.0, 2.5]), "e1": np.zeros((1000, 3)), "e2": -1.0})
    assert repr(x) == "[1, 2.5] + [0, 0, …, 0, 0](1000, 3)*e1 - e2"
    assert repr(EGA3.scalar(np.zeros((2, 0)))) == "[](2, 0)"
    assert repr(EGA3.scalar(np.array(2.0))) == "2"


def test_symbols_are_short() -> None:
    ca = pytest.importorskip("casadi", reason="CasADi is not installed")
    x = ca.SX.sym("x")
    assert repr(EGA3.multivector({"e1": x, "e2": x + 1})) == "x*e1 + ((x+1))*e2"
    for k in range(50):
        x = x * x + k
    assert len(repr(EGA3.scalar(x))) < 80


def test_sums_longer_than_anybody_reads_are_cut() -> None:
    large = Algebra(8)
    whole = large.multivector(dict.fromkeys(large.blades, -2.0))
    assert repr(whole).endswith(" + …")
    assert repr(whole).count("*") == 63
    assert str(whole._repr_latex_()).endswith(r" + \dots$")


def test_a_multivector_is_a_formula() -> None:
    x = CGA3.multivector(MINUS_HALF)
    assert x._repr_latex_() == (
        r"$\displaystyle 0.5 - \mathbf{e}_{1} \wedge \mathbf{e}_{2} "
        r"+ 1.5 \cdot 10^{-7}\,\mathbf{e}_{2} \wedge \mathbf{e}_{\infty}$"
    )
    assert CGA3.multivector({"e1": -2.0})._repr_latex_() == r"$\displaystyle -2\,\mathbf{e}_{1}$"
    assert CGA3.multivector({"e1": 0.0})._repr_latex_() == r"$\displaystyle 0$"


def test_notebooks_need_nothing_that_sets_formulas() -> None:
    assert CGA3.multivector(MINUS_HALF)._repr_html_() == (
        "<span>0.5 − <b>e</b><sub>1</sub>∧<b>e</b><sub>2</sub> + "
        "1.5·10<sup>−7</sup> <b>e</b><sub>2</sub>∧<b>e</b><sub>∞</sub></span>"
    )
    assert Algebra(1, names=("t",)).blade("t")._repr_html_() == "<span><i>t</i></span>"


def test_batches_and_symbols_are_text() -> None:
    batch = EGA3.vector([np.zeros(3), 1.0, 2.0])
    assert batch._repr_latex_() is None
    assert batch._repr_html_() is None
    assert Motor.identity((2,))._repr_latex_() is None
    assert Motor.identity((2,))._repr_html_() is None
    ca = pytest.importorskip("casadi", reason="CasADi is not installed")
    assert EGA3.scalar(ca.SX.sym("x"))._repr_latex_() is None


@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity])
def test_a_versor_is_the_formula_of_its_multivector(
    kind: type[Rotor | Motor | Similarity], rng: np.random.Generator
) -> None:
    versor = kind.random(rng)
    same = CGA3.multivector(dict(zip(kind._blades, versor.coefficients.tolist(), strict=True)))
    point = rng.normal(size=3)
    assert np.allclose(versor.apply(point), position(same.sandwich(lifted(point))))
    # In the order of their coefficients, which is the documented one, and not in the algebra's.
    assert terms(versor._repr_latex_()) == terms(same._repr_latex_())
    assert str(versor._repr_html_()).count("<b>e</b>") == str(same._repr_html_()).count("<b>e</b>")


def test_versors_are_formulas_in_their_own_order() -> None:
    assert Rotor([0.5, 0.5, -0.5, 0.5])._repr_latex_() == (
        r"$\displaystyle 0.5 + 0.5\,\mathbf{e}_{2} \wedge \mathbf{e}_{3} "
        r"- 0.5\,\mathbf{e}_{3} \wedge \mathbf{e}_{1} + 0.5\,\mathbf{e}_{1} \wedge \mathbf{e}_{2}$"
    )
    assert Motor.from_translation([2.0, 0.0, 0.0])._repr_html_() == (
        "<span>1 − <b>e</b><sub>1</sub>∧<b>e</b><sub>∞</sub></span>"
    )
    assert not hasattr(DualQuaternion, "_repr_latex_")


def lifted(point: np.ndarray) -> Multivector:
    x, y, z = point.tolist()
    return CGA3.vector([x, y, z, 1.0, 0.5 * (x * x + y * y + z * z)])


def position(point: Multivector) -> list[float]:
    return [point[name] / point["e0"] for name in ("e1", "e2", "e3")]


def terms(formula: str | None) -> set[str]:
    """The sizes of a formula's terms, without signs, which the order of a blade's vectors turns."""
    assert formula is not None
    body = formula.removeprefix(r"$\displaystyle ").removesuffix("$").replace(" - ", " + ")
    return {term.partition(r"\,")[0].lstrip("-") for term in body.split(" + ")}


def test_names_numbers_and_blades() -> None:
    assert [name_text(n) for n in ("x", "x1", "arm", "a_b", "alpha", "_")] == [
        "x", "x_{1}", r"\mathit{arm}", r"\mathit{a\_b}", r"\alpha", r"\mathit{\_}",
    ]  # fmt: skip
    assert [number_text(v) for v in (0.1, -3.0, 1e22)] == ["0.1", "-3", r"1 \cdot 10^{22}"]
    assert (blade_text("1"), blade_text("t^x")) == ("", "t \\wedge x")
