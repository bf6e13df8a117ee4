"""Scripts in CLUCalc's style, as its manual writes them: values by hand, refusals by the word."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from motorcade.ga.script import ScriptError, evaluate, parse
from motorcade.ga.script.errors import ScriptWarning

PLANETS = """
_DoAnimate = 1; // drawn anew all the time
DefVarsE3();
SetPointSize(6);
Scale = Slider("1. Scale", 0, 2, 0.1, 0.5);
Angle = ((Time * 180) % 360) * RadPerDeg + Pi/2;
R = RotorE3(0, 0, 1, Angle);
:X = Scale*VecE3(1, 0, 0):Red;
:Y = R*X*~R : MBlue;
if (CheckBox("2. Line", 1)) DrawLine(X, Y);
?"Y is drawn";
"""
LISTS = """
Squares = { n = _P(1); n*n; }
L = [];
i = 1;
loop
{
    if (i > 4) break;
    L << Squares(i);
    i = i + 1;
}
?Size(L);
?L(3) + L(1);
Table = [1, 2] + [10, 20];
?Table(2)(1)
?Table(1, 2)
D = []; D("red") = 3; D("blue") = [5, 6];
?D("blue")(2) - D("red");
[a, b] = [7, 8];
?a*b;
?pow(L, 0.5)(4);
?-7 % 3;
?!(2*e1);
M = N = e1 + e2;
?(M == N) + 2*("a" == "b");
Name = "points: " + Size("abcd");
?Name == "points: 4";
"""
CONICS = """
?A = VecC2(1, 2); ?B = VecC2(3, 4);
?A . B;
?R = RotorC2(Pi/3);
?R*A*~R;
"""


def quietly(text: str) -> dict[str, float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ScriptWarning)
        values = evaluate(parse(text))
    return {name: x.scalar_part() for name, x in values.items() if set(x.blades) <= {"1"}}


def test_what_is_drawn_is_the_result_of_a_script_that_prints_nothing() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        values = evaluate(parse(PLANETS))
    named = [str(warning.message).split()[1] for warning in caught]
    assert named == ["SetPointSize", "DrawLine"]
    assert values["X"].coefficient("e1") == 0.5
    assert values["Y"].coefficient("e2") == pytest.approx(0.5)
    assert values["line_10_2"].coefficient("e2") == pytest.approx(0.5)


def test_lists_texts_and_remainders_have_the_values_of_the_manual() -> None:
    lines = {int(name.removeprefix("line_")): x for name, x in quietly(LISTS).items()}
    assert [lines[number] for number in (11, 12, 14, 15)] == [4, 10, 12, 21]
    assert [lines[number] for number in (17, 19, 20, 21)] == [3, 56, 4, -1]
    assert [lines[number] for number in (24, 26)] == [1, 1]
    assert evaluate(parse("?a = !(2*e1);"))["a"].coefficient("e1") == 0.5


def test_conics_are_symmetric_matrices_with_their_inner_product() -> None:
    values = evaluate(parse(CONICS))
    x, y = np.array([1.0, 2.0, 1.0]), np.array([3.0, 4.0, 1.0])
    assert values["line_3"].scalar_part() == pytest.approx((x @ y) ** 2 / 2)
    turn = math.pi / 3
    turned = [math.cos(turn) - 2 * math.sin(turn), math.sin(turn) + 2 * math.cos(turn)]
    point = evaluate(parse(f"?P = VecC2({turned[0]!r}, {turned[1]!r});"))["P"]
    for blade in ("e1", "e2", "e3", "e4", "e5", "e6"):
        assert values["line_5"].coefficient(blade) == pytest.approx(point.coefficient(blade))


def test_euclidean_projective_and_conformal_points_are_told_by_their_functions() -> None:
    line = evaluate(parse("DefVarsP3(); ?L = VecP3(1, 2, 0) ^ VecP3(VecE3(1, 2, 1)); ?L.e4;"))
    assert line["line_1"].coefficient("e3") == pytest.approx(-1)
    point = evaluate(parse("DefVarsN3(); ?D = DilatorN3(2)*VecN3(VecE3(1, 1, 1))*~DilatorN3(2);"))
    weight = point["D"].coefficient("e0")
    assert point["D"].coefficient("e1") / weight == pytest.approx(2)
    assert point["D"].coefficient("einf") / weight == pytest.approx(6)
    near = evaluate(parse("DefVarsN3(); A = VecN3(1) - 0.5*e; ?A*A; ?proj(e1 + e2, e1^e3);"))
    assert near["line_1"].coefficient("e1") == 1


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ('I = ReadData("a.txt");', "ReadData"),
        ("?SVD(Matrix([[1, 2], [3, 4]]));", "SVD"),
        ("?Matrix([[1, 0], [0, 1]]) * Matrix([[1, 0], [0, 1]]);", "products, sums or comparisons"),
        ("f = { b -> _P(1); b = 2; } a = 1; f(a); ?a;", "b refers to another value"),
        ("?[1, 2] | 3;", "expected a token"),
        ("x = Red; if (x) { y = 1; }", "free variables Red"),
        ("_2dView = 1; x = Red; if (x) { y = 1; }", "condition: expected a scalar"),
        ("DefVarsN3(); :C = VecC2(0, 1);", "VecC2 is a macro of c2"),
    ],
)
def test_what_is_missing_is_refused_by_its_word(text: str, word: str) -> None:
    with pytest.raises(ScriptError) as caught:
        quietly(text)
    assert word in str(caught.value)


@pytest.mark.parametrize(
    "growing",
    ["L = [L, L];", "L << L;", "L = L + L;", 's = s + s + "ab";', "s << s;", "L = [L];"],
)
def test_no_list_or_text_grows_without_bound(growing: str) -> None:
    with pytest.raises(ScriptError, match="at most"):
        quietly(f'L = [1, 2]; s = "ab"; loop {{ {growing} }}')


def test_pragmas_of_newer_writers_are_read() -> None:
    text = "#spragma output line e1\n//#pragma return line Line(e1, e2)\nline = e1 + 2*e2;"
    with pytest.warns(ScriptWarning, match="typed"):
        values = evaluate(parse(text))
    assert [str(x) for x in values.values()] == ["e1"]
