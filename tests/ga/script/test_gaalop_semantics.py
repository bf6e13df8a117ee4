"""The same numbers as Gaalop's published semantics.

Products, duals, division by versors and the conformal macros are compared with the `clifford`
package and with values derived by hand from the published definitions: `^` outer, `.` Hestenes'
inner product, `*x` is x I⁻¹, einf = ep + em, e0 = ½ (em - ep) (Hildenbrand, "Foundations of
Geometric Algebra Computing", 2013, chapters 3 and 8, and the macros that Gaalop ships for its
algebra 5d). Blades are read by name, and one that is missing is zero.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga.algebra import Multivector
from motorcade.ga.script import evaluate, parse
from motorcade.ga.script.errors import ScriptWarning


def coefficients(x: Multivector) -> dict[str, float]:
    return {name: float(value) for name, value in x.items() if abs(value) > 1e-12}


# Script, and the coefficients by name: all others are zero. By hand, from e0·einf = -1.
GOLDEN: list[tuple[str, dict[str, float]]] = [
    # The table of inner products of the basis.
    ("e1 . e1", {"1": 1}),
    ("e0 . einf", {"1": -1}),
    ("e0 . e0", {}),
    ("einf . einf", {}),
    ("e0 * einf", {"1": -1, "e0^einf": 1}),
    ("einf * e0", {"1": -1, "e0^einf": -1}),
    ("ep . ep", {"1": 1}),
    ("em . em", {"1": -1}),
    ("einf - ep - em", {}),
    ("e0 - 0.5*(em - ep)", {}),
    # Hestenes' inner product: the grade |r - s|, and zero with a scalar on either side.
    ("2 . e1", {}),
    ("e1 . 2", {}),
    ("2 . 3", {}),
    ("e1 . e1^e2", {"e2": 1}),
    ("e1^e2 . e1", {"e2": -1}),
    ("e1^e2 . e1^e2", {"1": -1}),
    ("e1^e2 . e2^e3", {}),
    ("(1 + e1) . (3 + e1)", {"1": 1}),
    # Outer product; the reverse turns the factors round.
    ("e2 ^ e1", {"e1^e2": -1}),
    ("e1 ^ e1", {}),
    ("2 ^ e1", {"e1": 2}),
    ("~(1 + e1 + e1^e2 + e1^e2^e3 + e1^e2^e3^e0)", {
        "1": 1, "e1": 1, "e1^e2": -1, "e1^e2^e3": -1, "e1^e2^e3^e0": 1,
    }),
    # The dual is x I⁻¹ with I = e1^e2^e3^einf^e0 and I² = -1.
    ("(e1^e2^e3^einf^e0) * (e1^e2^e3^einf^e0)", {"1": -1}),
    ("*1", {"e1^e2^e3^e0^einf": 1}),
    ("*(e1^e2^e3^einf^e0)", {"1": 1}),
    ("**e1", {"e1": -1}),
    ("*e1", {"e2^e3^e0^einf": 1}),
    # einf I = -e123 ∧ (einf ⌟ einf∧e0) = -e123∧einf, and I⁻¹ = -I; likewise e0 I = e123∧e0.
    ("*einf", {"e1^e2^e3^einf": 1}),
    ("*e0", {"e1^e2^e3^e0": -1}),
    # Precedence: ^ before . before / before *.
    ("2*e1^e2 . e2", {"e1": 2}),
    ("e1*e2/e2*e1", {"1": 1}),
    ("1 - 2 + 3", {"1": 2}),
    # Division by a versor is the product with its inverse.
    ("1 / e1", {"e1": 1}),
    ("e1 / (2*e2)", {"e1^e2": 0.5}),
    ("1 / (e1^e2)", {"e1^e2": -1}),
    ("e1 / (3*e1 + 4*e2)", {"1": 0.12, "e1^e2": 0.16}),
    # A point lies on the null cone, at the distance that its product with another says.
    ("createPoint(1, 2, 3)", {"e1": 1, "e2": 2, "e3": 3, "e0": 1, "einf": 7}),
    ("VecN3(1, 2, 3) . VecN3(1, 2, 3)", {}),
    ("VecN3(1, 2, 3) . VecN3(1, 5, 7)", {"1": -12.5}),
    # SphereN3 is the outer form: its dual vanishes on the points at that distance.
    ("SphereN3(VecN3(0, 0, 0), 2) ^ VecN3(0, 2, 0)", {}),
    ("*SphereN3(VecN3(1, 0, 0), 2)", {"e1": -1, "e0": -1, "einf": 1.5}),
    ("SphereN3(1, 0, 0, 2) - SphereN3(VecN3(1, 0, 0), 2)", {}),
    ("TranslatorN3(1, 2, 3)", {"1": 1, "e1^einf": -0.5, "e2^einf": -1, "e3^einf": -1.5}),
    ("TranslatorN3(1, 2, 3) * e0 * ~TranslatorN3(1, 2, 3)", {
        "e1": 1, "e2": 2, "e3": 3, "e0": 1, "einf": 7,
    }),
    ("RotorN3(0, 0, 2, 1.2)", {"1": np.cos(0.6), "e1^e2": -np.sin(0.6)}),
    ("RotorN3(0, 3, 0, 1.2)", {"1": np.cos(0.6), "e1^e3": np.sin(0.6)}),
    ("Dual(e1) - *e1", {}),
    ("Normalize(-3*createPoint(1, 2, 3))", {"e1": 1, "e2": 2, "e3": 3, "e0": 1, "einf": 7}),
    ("normalize(3*e1 + 4*e2)", {"e1": 0.6, "e2": 0.8}),
    ("SQRT(16)*Cos(0)", {"1": 4}),
    ("coefficient(3*e1 + 5*e1^e2, e2^e1)", {"1": -5}),
    ("abs(3*e1 + 4*e2)", {"1": 5}),
    ("abs(e1^e2 - 2)", {"1": np.sqrt(5)}),
]  # fmt: skip


@pytest.mark.parametrize(("written", "expected"), GOLDEN, ids=[text for text, _ in GOLDEN])
def test_the_published_value_by_the_name_of_the_blade(
    written: str, expected: dict[str, float]
) -> None:
    found = evaluate(parse(f"?x = {written};"))["x"]
    assert coefficients(found) == pytest.approx(expected, abs=1e-12)
    for name in found.algebra.blades:
        assert found.coefficient(name) == pytest.approx(expected.get(name, 0.0), abs=1e-12)


OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "*": lambda a, b: a * b,
    "^": lambda a, b: a ^ b,
    ".": lambda a, b: a | b,
    "/": lambda a, b: a / b,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
}


@pytest.mark.parametrize("operator", OPERATORS)
def test_clifford_finds_the_same_products(operator: str) -> None:
    """On whole multivectors; the divisors of `/` are versors."""
    pytest.importorskip("clifford")
    g3c = pytest.importorskip("clifford.g3c")
    names = (g3c.e1, g3c.e2, g3c.e3, g3c.e4, g3c.e5)
    scalar = 0 * g3c.e1 + 1
    rng = np.random.default_rng(15)

    ours = ("e1", "e2", "e3", "ep", "em")

    def versor() -> tuple[str, Any]:
        texts, theirs = [], scalar
        for row in rng.integers(-3, 4, (3, 5)) + np.diag([9, 9, 9, 0, 0])[:3]:
            texts.append(" + ".join(f"({v})*{n}" for v, n in zip(row, ours, strict=True)))
            theirs = theirs * sum(int(v) * e for v, e in zip(row, names, strict=True))
        return "(" + " * ".join(f"({text})" for text in texts) + ")", theirs

    def whole() -> tuple[str, Any]:
        made, theirs = versor()
        other, its = versor()
        return f"({made} + {other}*e1 + 2)", theirs + its * g3c.e1 + 2

    for _ in range(4):
        (left, a), (right, b) = whole(), versor() if operator == "/" else whole()
        found = evaluate(parse(f"?x = {left} {operator} {right};"))["x"].as_orthogonal()
        expected = OPERATORS[operator](a, b)
        theirs = dict(zip(expected.layout.bladeTupList, expected.value, strict=True))
        size = max(1.0, float(np.abs(expected.value).max()))
        for blade, value in theirs.items():
            mask = sum(1 << k - 1 for k in blade)
            value_here = dict(zip(found.masks, found.values, strict=True)).get(mask, 0.0)
            assert value_here / size == pytest.approx(value / size, abs=1e-10)


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ("?a = x^2;", "1:7", "an outer product, with a number no more than a factor"),
        ("?a = (x + e1)^0.5;", "1:14", "there are no powers"),
        ("?a = x**e1;", "1:7", "a product with a dual; there are no powers"),
        ("?a = x;\n// #pragma output a e1", "2:1", "a comment, and no pragma"),
        ("?a = x;\n//\t#include m.clu", "2:1", "a comment, and no pragma"),
    ],
)
def test_what_other_languages_mean_something_else_by_is_warned_of(
    text: str, place: str, what: str
) -> None:
    with pytest.warns(ScriptWarning, match=f"^f.clu:{place}: .*{what}"):
        parse(text, "f.clu")


@pytest.mark.parametrize(
    "text", ["?a = x^e1;", "?a = x* *e1;", "?a = x ^ 2;", "?a = **e1;", "// a #pragma\n?a=2^x;"]
)
def test_what_means_the_same_is_not_warned_of(text: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parse(text)
