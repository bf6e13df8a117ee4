"""What is wrong with a script is said where it is wrong, and nothing but ScriptError comes out."""

import dataclasses
import inspect
import pickle
import sys
import warnings
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motorcade.ga.script import ScriptError, evaluate, parse, syntax
from motorcade.ga.script.errors import Place, ScriptWarning, Source
from motorcade.ga.script.meaning import algebra_named, algebra_of

# Text, column, part of the message, part of the hint.
REFUSED = [
    ("?x = ;", 6, "expected an expression, got ';'", "operand"),
    ("?x = (1 + 2;", 12, "expected an operator or '\\)'", "bracket at 1:6"),
    ("?x = 1 + 2);", 11, "expected an operator or ';'", "no bracket is open"),
    ("?x = (1, 2);", 8, "expected '\\)', got ','", "several arguments"),
    ("?x = 1 2;", 8, "expected ';', got '2'", "ends in ';'"),
    ("?x = 2e1b;", 9, "expected an operator after the number 2e1", "product"),
    ("?x = 1e999;", 6, "below 1.8e308", ""),
    ("x = 1", 6, "expected ';', got the end of the script", "ends in"),
    ("x=1; :", 7, "expected an expression, got the end of the script", ""),
    ("x=1; :a", 8, "expected ';', got the end of the script", "ends in"),
    ("?x = 2_;", 7, "expected an operator after the number 2", "product"),
    ("1 = 2;", 1, "expected a name", "name = expression"),
    ("f(3);", 1, "no function or macro f", "define it"),
    ("f = 1; f = g;", 12, "free variables g", "assign them"),
    ("x * 2;", 6, "expected '='", "name = expression"),
    ("?x = [1, [2, 3]](3);", 17, "a place from 1 to 2, got 3", ""),
    ('?x = "a" * 2;', 10, "has no value for string and scalar", ""),
    ('?x = "a;', 6, "expected a token", "no end"),
    ("?x = SVD([1, 2]);", 6, "SVD: there is no function or macro", ""),
    ("a = 1; b -> a; b = 2;", 16, "b refers to another value", "read alone"),
    ("x = 7 % 2; if (Red) { x = 1; }", 16, "condition: expected a scalar", ""),
    ("?x = a[2];", 8, "expected the name of a blade, got '2'", "coefficient(x, e1)"),
    ("?x = 1; ?y = x[e1^e9];", 15, "expected a blade of e1", ""),
    ("?x = 1/*e1;", 7, "this comment has no end", "space between"),
    ("?x = sinn(1);", 6, "no function or macro sinn", "did you mean sin"),
    ("?x = VecN3(1, 2);", 6, "VecN3: expected 1 or 3 arguments, got 2", ""),
    ("?x = sin();", 6, "sin: expected one argument, got 0", ""),
    ("?x = sin(e1);", 6, "sin: expected a scalar, got a multivector with e1", ""),
    ("?x = sqrt(e1);", 6, "sqrt: has no finite real value", ""),
    ("?x = log(e1 + e2^e3);", 6, "log: expected a scalar beside something", ""),
    ("?x = asin(2);", 6, "asin: has no finite real value here", ""),
    ("?x = acos(0 - 3);", 6, "acos: has no finite real value here", ""),
    ("?x = max(1);", 6, "max: expected 2 arguments, got 1", ""),
    ("?x = 2*log(0 - 1);", 8, "log: has no finite real value", ""),
    ("?x = fact(1.5);", 6, "fact: expected whole numbers", ""),
    ("?x = e1 / (e0 - e0);", 9, "expected an invertible multivector", ""),
    ("?x = e1 / einf;", 9, "expected an invertible multivector", ""),
    ("?x = Normalize(e1);", 6, "Normalize: ", ""),
    ("?x = 1e308 * 10;", 12, "got an overflow", ""),
    ("?x = y + z;", 6, "free variables y, z", "y="),
    ("?x;", 2, "free variables x", ""),
    ("e1 = 2;", 1, "e1 is a basis vector", "another name"),
    ("?x = _P(1);", 6, "_P\\(1\\) stands outside a macro", ""),
    ("f = { _P(0) }", 10, "a whole number from 1", ""),
    ("f = { x = 1; }", 14, "expected an expression, got '}'", "ends in"),
    ("f = { g = { 1 } }", 7, "expected an expression", "no other macro"),
    ("?f = { 1 }", 6, "expected an expression", "no mark"),
    ("f = { 1 } f = { 2 }", 11, "f is already defined", ""),
    ("f = { f() } ?x = f();", 7, "no function or macro f", "calls others alone"),
    ("?x = f(); f = { g() } g = { f() }", 29, "at most 32 macros", ""),
    ("SIN = { 1 }", 1, "SIN is already defined", ""),
    ("sin = { 1 }", 1, "sin is already defined", ""),
    ("?x = algebra;", 6, "can be named algebra", "another name"),
    ("?x ^ e2;", 2, "free variables x", "x="),
    ("if x > 0 { y = 1; }", 4, "expected '=', got 'x'", ""),
    ("if (e1) { y = 1; }", 5, "condition: expected a scalar", ""),
    ("if (1 < 2 { y = 1; }", 11, "expected '\\)', got '{'", "if (condition)"),
    ("if (1) { y = 1;", 16, "expected '}', got the end", "a block is"),
    ("?z = e1 < 2;", 9, "expected a scalar", ""),
    ("if (0) { y = 1; } ?y;", 20, "y has no value here", ""),
    ("loop { x = 1; }", 1, "expected at most 100000 steps", "end in a break"),
    ("x = 1; break;", 8, "expected a break inside a loop", ""),
    ("while (1) { x = 1; }", 11, "expected '='", "loop {"),
    ("?x = coefficient(e1, e1 + e2);", 6, "one basis blade", ""),
    ("?x = grade(e1, 0.5);", 6, "a grade from 0 to 5", ""),
    ("?a = 7 % 0;", 8, "a divisor that is not 0", ""),
    ("?a = 2.5fx;", 9, "expected an operator after the number 2.5", "2.5*f"),
    ("?x = n;", 6, "free variables n", "einf"),
    ("?x = <1>;", 6, "expected an expression, got '<'", ""),
    ("#pragma unroll 0", 1, "cannot be read", "N from 1"),
    ("#pragma in2out x", 1, "cannot be read", "-> OUTPUT"),
    ("#pragma import a.clu", 1, "only a script that is read from a file", ""),
    ("#include ../a.clu", 1, "cannot be read", "beside the script"),
    ("//#pragma bogus x", 1, "expected a pragma output", ""),
    ("//#pragma range 2 <= x <= 1", 1, "cannot be read", "LOW <= NAME"),
    ("//#pragma output", 1, "cannot be read", "BLADE"),
    ("x = 1; //#pragma output x e1^e9", 8, "expected a blade", ""),
    ("//#pragma algebra sti", 1, "expected an algebra 2d, ega2", "P Q R"),
    ("//#pragma algebra 9 9 9", 1, "basis vectors", ""),
    ("?x = \u00b2;", 6, "expected a token", ""),
]


@pytest.mark.parametrize(("text", "column", "message", "hint"), REFUSED)
def test_an_error_has_its_place_and_hint(text: str, column: int, message: str, hint: str) -> None:
    with pytest.raises(ScriptError, match=message) as caught:
        evaluate(parse(text, "my.clu"))
    error = caught.value
    assert (error.file, error.line, error.column) == ("my.clu", 1, column)
    assert error.source_line == text
    assert hint in error.hint


def test_an_error_shows_its_line_with_a_caret() -> None:
    with pytest.raises(ScriptError) as caught:
        parse("a = 1;\n/* two\nlines */\tb = ) 2;\r\n", "arm.clu")
    assert str(caught.value) == (
        "arm.clu:3:14: expected an expression, got ')'\n"
        "    lines */\tb = ) 2;\n"
        "            \t    ^\n"
        "hint: an operand is a name, a number or a bracket"
    )


def test_an_error_in_a_long_line_shows_its_part() -> None:
    with pytest.raises(ScriptError) as caught:
        parse("?x = " + "1 + " * 500 + "%;")
    _, shown, caret, _ = str(caught.value).split("\n")
    assert len(shown) < 120
    assert shown[caret.index("^")] == "%"


def test_an_error_survives_pickling() -> None:
    with pytest.raises(ScriptError) as caught:
        parse("?x = (;")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_variables_are_checked_by_name() -> None:
    script = parse("?x = t;")
    for value in (float("nan"), 1j, "one", 10**400, np.array([1.0, np.inf])):
        with pytest.raises(ValueError, match="variable t"):
            evaluate(script, t=value)
    with pytest.raises(ValueError, match="expected t, got also u"):
        evaluate(script, t=1.0, u=2.0)


@pytest.mark.parametrize("opening", ["(", "-", "~", "* ", "sin(", "f(1+(2-", "~(", "e1^("])
def test_deep_nesting_is_refused(opening: str) -> None:
    with pytest.raises(ScriptError, match="levels of nesting"):
        parse("?x = " + opening * 20_000)
    with pytest.raises(ScriptError, match="levels of nesting"):
        parse("?x = " + opening * 201 + "1;")


def test_nesting_up_to_the_limit_costs_no_stack_of_the_caller() -> None:
    text = "?x = " + "(1 + 2*" * 200 + "3" + ")" * 200 + ";?y = " + "1 + " * 5000 + "1;"
    limit = sys.getrecursionlimit()
    try:
        sys.setrecursionlimit(len_of_stack() + 60)
        made = evaluate(parse(text))
    finally:
        sys.setrecursionlimit(limit)
    assert made["y"].scalar_part() == 5001.0


def len_of_stack() -> int:
    depth, frame = 0, sys._getframe()
    while frame.f_back is not None:
        depth, frame = depth + 1, frame.f_back
    return depth


def doubling(levels: int) -> str:
    first = "m0 = { _P(1) + _P(1) }\n"
    return first + "\n".join(
        f"m{k} = {{ m{k - 1}(_P(1)) + m{k - 1}(_P(1)) }}" for k in range(1, levels)
    )


FULL = "x = (1 + e1)*(2 + e2)*(3 + e3)*(2 - e0)*(2 - einf)/32;"
GROWING = "".join(f"x = x*(1 + e{k});" for k in range(1, 11))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("/" * 1_000_001, "at most 1000000 characters"),
        (";" * 300_000, "at most 200000 tokens"),
        ("?x = " + "1 + " * 30_000 + "1;", "at most 20000 operations"),
        ("?x = f(" + "1," * 300 + "1);", "at most 100 arguments"),
        (doubling(25) + "?x = m24(1);", "at most 100000 steps"),
        (FULL + "y = x*x;" * 200 + "?y;", "at most 200000 terms"),
        (FULL + "y = x + x;" * 4000 + "?y;", "at most 200000 terms"),
        (FULL + "x = exp(x/9);" * 10 + "?x;", "at most 200000 terms"),
        ("//#pragma algebra 5 5 0\nx = 1;" + GROWING + "?y = x*x;", "at most 200000 terms"),
        ("//#pragma algebra 5 5 0\nx = 1;" + GROWING + "?y = exp(x);", "at most 200000 terms"),
        ("//#pragma algebra 5 5 0\nx = 1;" + GROWING + "?y = 1/x;", "at most 200000 terms"),
        (
            "m0 = { 1 }"
            + "".join(f"m{k} = {{ m{k - 1}() }}" for k in range(1, 60))
            + "?x = m59();",
            "at most 32 macros",
        ),
    ],
    ids=lambda text: text[:30],
)
def test_enormous_scripts_are_refused(text: str, message: str) -> None:
    with pytest.raises(ScriptError, match=message):
        evaluate(parse(text))


def test_names_of_many_macros_are_found_once() -> None:
    """Each macro reads those above it: the names that all of them read are counted once."""
    text = "".join(f"m{k} = {{ {f'm{k - 1}() + ' * (k > 0)}x{k} }}\n" for k in range(5000))
    with pytest.raises(ScriptError, match="free variables x0, x1, x2") as caught:
        evaluate(parse(text + "?y = m4999();"))
    assert caught.value.line == 1


PIECES = [
    *"()+-*/^.~=?!:;,{} \n\t0123456789",
    *(
        "e1",
        "e2",
        "e0",
        "einf",
        "x",
        "y = ",
        "?x = ",
        "m = {",
        "m(",
        "_P(1)",
        "_P(",
        "sqrt(",
        "abs(",
    ),
    *("invert(", "fact(", "log(", "VecN3(", "//", "/*", "*/", "//#pragma ", "output x", "e1^e2"),
    *(
        "range 0 <= x <= 1",
        "algebra 3 0 1",
        "algebra ",
        "1e300",
        "1e-320",
        "\u00e9",
        "\x00",
        "\ud800",
    ),
    *("?y = e1*e2;", "x = 2;", "m = { _P(1) + e1 }", "?z = m(x)/x;", "return x", "Normalize("),
]
FUZZ = settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))


def only_script_errors(text: str) -> None:
    error = refusal(text)
    if error is not None:
        lines = text.split("\n")
        assert 1 <= error.line <= len(lines)
        assert 1 <= error.column <= len(lines[error.line - 1]) + 1
        assert "^" in str(error)


def refusal(text: str) -> ScriptError | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ScriptWarning)  # pieces may happen to read like a power
        try:
            evaluate(parse(text))
        except ScriptError as error:
            return error
    return None


@FUZZ
@given(st.lists(st.sampled_from(PIECES), max_size=40).map("".join))
def test_no_text_brings_anything_but_script_errors(text: str) -> None:
    only_script_errors(text)


@FUZZ
@given(st.text(max_size=60))
def test_no_unicode_brings_anything_but_script_errors(text: str) -> None:
    only_script_errors(text)


WHOLE = """//#pragma range 0 <= t <= 1
m = { y = _P(1)^e1; y / 2 } x = 3; ?x = x*m(e2) . -~*e3 + VecN3(1,2,3)/(e1 - 2);
//#pragma output x e1
"""


@FUZZ
@given(st.integers(0, len(WHOLE)), st.integers(0, 6), st.lists(st.sampled_from(PIECES), max_size=3))
def test_no_change_of_a_script_brings_anything_but_script_errors(
    start: int, dropped: int, pieces: list[str]
) -> None:
    only_script_errors(WHOLE[:start] + "".join(pieces) + WHOLE[start + dropped :])


@pytest.mark.parametrize("column", [1, 2, 49, 50, 51, 52, 150, 249, 250, 251, 300])
def test_long_lines_are_shown_in_part_with_the_caret_under_its_letter(column: int) -> None:
    line = "".join(chr(0x4E00 + k) for k in range(300))
    error = Source(line, "long").error(Place(1, column), "odd")
    _, shown, caret = str(error).split("\n")
    assert shown[caret.index("^")] == line[column - 1]
    assert len(shown.strip()) == 100
    assert shown.strip() in line
    assert error.column == column
    # As much on both sides as there is.
    left = caret.index("^") - 4
    assert left == column - 1 if column <= 50 else left >= 49


def test_lines_of_a_hundred_letters_are_shown_whole() -> None:
    line = "x" * 99 + "]"
    _, shown, caret = str(Source(line, "whole").error(Place(1, 100), "odd")).split("\n")
    assert shown == "    " + line
    assert caret == " " * 103 + "^"


def test_what_is_beside_a_tiny_scalar_is_no_rounding() -> None:
    with pytest.raises(ScriptError, match="expected a scalar, got a multivector with e1"):
        evaluate(parse("?y = sin(1e-20 + 1e-20*e1);"))
    assert evaluate(parse("?y = sin(0.5 + 1e-13*e1);"))["y"].scalar_part() == np.sin(0.5)


@pytest.mark.parametrize(
    ("name", "signature"),
    [
        ("ega2", (2, 0, 0)),
        ("ega3", (3, 0, 0)),
        ("pga2", (2, 0, 1)),
        ("pga3", (3, 0, 1)),
        ("cga2", (3, 1, 0)),
        ("cga3", (4, 1, 0)),
        ("2 1 0", (2, 1, 0)),
        ("0  3 1", (0, 3, 1)),
    ],
)
def test_algebras_are_named_as_in_pragmas(name: str, signature: tuple[int, int, int]) -> None:
    found = algebra_named(name)
    assert found.signature == signature
    text = f"//#pragma algebra {name}\n?x = 1;"
    assert algebra_of(parse(text)) == found


def test_names_that_pragmas_alone_put_out_are_free() -> None:
    script = parse("//#pragma output z\n?x = 1;")
    assert evaluate(script, z=3.0)["z"].scalar_part() == 3.0
    with pytest.raises(ScriptError, match="free variables z") as caught:
        evaluate(script)
    assert (caught.value.line, caught.value.column) == (1, 1)


@pytest.mark.parametrize("name", ["", "cga4", "3 0", "3 0 0 0", "-1 0 0", "3,0,1", "٣ 0 0"])
def test_other_names_of_algebras_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"algebra: expected 2d, ega2, .* or a signature P Q R"):
        algebra_named(name)


def test_macros_of_points_are_those_of_cga3_alone() -> None:
    assert evaluate(parse("?x = VecN3(1, 2, 3);"))["x"].coefficient("einf") == 7.0
    with pytest.raises(ScriptError, match="VecN3"):
        evaluate(parse("//#pragma algebra ega3\n?x = VecN3(1, 2, 3);"))


def test_nodes_are_equal_to_themselves_alone_and_deep_ones_can_be_shown() -> None:
    text = "?x = " + "1 + " * 5000 + "1;"
    one, two = parse(text).statements[0], parse(text).statements[0]
    assert one == one
    assert one != two
    assert len({one, two}) == 2
    kinds = {kind for _, kind in inspect.getmembers(syntax, dataclasses.is_dataclass)}
    kinds -= {syntax.Token}  # which is no node
    assert len(kinds) > 10
    assert {kind.__repr__ for kind in kinds} == {object.__repr__}
    assert {kind.__eq__ for kind in kinds} == {object.__eq__}


def test_factorials_of_what_is_no_number_are_refused() -> None:
    with pytest.raises(ScriptError, match="fact: expected a number, got Fraction"):
        evaluate(parse("?y = fact(x);"), x=Fraction(3))
    assert evaluate(parse("?y = fact(x);"), x=4.0)["y"].scalar_part() == 24.0
