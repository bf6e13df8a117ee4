"""Every production of the grammar against a plain evaluator: random scripts, whose meaning is
computed beside their text over 32 coefficients and a table made by sorting words of vectors.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.script import evaluate, parse

Coefficients = np.ndarray[Any, np.dtype[np.float64]]
Tree = tuple[Any, ...]

# The orthogonal basis e1 e2 e3 ep em: number k of a word is vector k.
SQUARES = (1, 1, 1, 1, -1)
WORDS = [tuple(k for k in range(5) if code >> k & 1) for code in range(32)]
GRADES = np.array([len(word) for word in WORDS])
TIGHTNESS = {"+": 1, "-": 1, "*": 2, "/": 3, ".": 4, "^": 5}


def sorted_word(word: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
    """Swap neighbours until a word is sorted, then let pairs annihilate."""
    letters, sign = list(word), 1.0
    for _ in letters:
        for k in range(len(letters) - 1):
            if letters[k] > letters[k + 1]:
                letters[k], letters[k + 1] = letters[k + 1], letters[k]
                sign = -sign
    left: list[int] = []
    for letter in letters:
        if left and left[-1] == letter:
            sign *= SQUARES[left.pop()]
        else:
            left.append(letter)
    return sign, tuple(left)


def cayley() -> Coefficients:
    table = np.zeros((32, 32, 32))
    for i, one in enumerate(WORDS):
        for j, two in enumerate(WORDS):
            sign, word = sorted_word(one + two)
            table[i, j, WORDS.index(word)] = sign
    return table


TABLE = cayley()
R, S, T = np.meshgrid(GRADES, GRADES, GRADES, indexing="ij")
OUTER = TABLE * (R + S == T)
INNER = TABLE * ((abs(R - S) == T) & (R > 0) & (S > 0))


def through(table: Coefficients) -> Callable[[Coefficients, Coefficients], Coefficients]:
    return lambda a, b: np.einsum("i,j,ijk->k", a, b, table)


def one(value: float) -> Coefficients:
    return value * np.eye(32)[0]


def vector(*coordinates: float) -> Coefficients:
    made = np.zeros(32)
    made[[1, 2, 4, 8, 16]] = coordinates
    return made


product, outer, inner = through(TABLE), through(OUTER), through(INNER)
BASIS = {
    "e1": vector(1, 0, 0, 0, 0),
    "e2": vector(0, 1, 0, 0, 0),
    "e3": vector(0, 0, 1, 0, 0),
    "e0": vector(0, 0, 0, -0.5, 0.5),
    "einf": vector(0, 0, 0, 1, 1),
}
VARIABLES = {"s": 0.5, "t": -1.25}


def pseudoscalar() -> Coefficients:
    whole = one(1)
    for name in ("e1", "e2", "e3", "einf", "e0"):
        whole = outer(whole, BASIS[name])
    return whole


def inverse(x: Coefficients) -> Coefficients:
    return np.linalg.solve(np.einsum("j,ijk->ki", x, TABLE), one(1))


def reverse(x: Coefficients) -> Coefficients:
    return x * np.where(GRADES % 4 > 1, -1.0, 1.0)


def matrix(x: Coefficients) -> Coefficients:
    """Multiplication by x from the left."""
    return np.einsum("i,ijk->kj", x, TABLE)


def exponential(x: Coefficients) -> Coefficients:
    """The first column of the matrix's; scripts whose numbers grow too much are let go."""
    assume(float(np.sum(np.abs(x))) < 12)
    return scipy.linalg.expm(matrix(x))[:, 0]


def size_squared(x: Coefficients) -> float:
    """Of what is not nearly null: there the root of a rounding is no small number."""
    value = float(product(x, reverse(x))[0])
    assume(abs(value) > 1e-6 * float(np.sum(x * x)) or not x.any())
    return value


UNARY = {
    "exp": exponential,
    "scalar": lambda x: one(x[0]),
    "-": lambda x: -x,
    "~": reverse,
    "*": lambda x: product(x, inverse(pseudoscalar())),
    "abs": lambda x: one(np.sqrt(abs(size_squared(x)))),
}
BINARY = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": product,
    "^": outer,
    ".": inner,
    "/": lambda a, b: product(a, inverse(b)),
}
NUMERIC = {
    "sin": np.sin,
    "cos": np.cos,
    "atan": np.arctan,
    "floor": np.floor,
    "sign": np.sign,
    "step": lambda x: np.heaviside(x, 1.0),
    "sqrt": np.sqrt,
}
PAIRED = {"min": np.minimum, "max": np.maximum, "atan2": np.arctan2}
PLANES = [k for k in range(32) if GRADES[k] == 2]
# Functions of the versor exp(B), by the matrix functions of SciPy.
OF_VERSOR = {
    "log({})": lambda m: scipy.linalg.logm(m).real[:, 0],
    "sqrt({})": lambda m: scipy.linalg.sqrtm(m).real[:, 0],
    "versor(3*{})": lambda m: m[:, 0],
    "normalize(0.2*{})": lambda m: m[:, 0],
    "log(5*{} + 0)": lambda m: scipy.linalg.logm(5 * m).real[:, 0],
}


@cache
def of_versor(function: str, coefficients: tuple[float, ...]) -> Coefficients:
    planes = np.zeros(32)
    planes[PLANES] = coefficients
    return OF_VERSOR[function](scipy.linalg.expm(matrix(planes)))


def plane_text(coefficients: tuple[float, ...]) -> str:
    names = ("e1", "e2", "e3", "ep", "em")
    terms = [
        f"{value}*{'^'.join(names[k] for k in WORDS[code])}"
        for code, value in zip(PLANES, coefficients, strict=True)
    ]
    return " + ".join(terms)


def meant(tree: Tree, names: dict[str, Coefficients]) -> Coefficients:
    kind = tree[0]
    if kind == "number":
        return one(tree[1])
    if kind == "name":
        return names[tree[1]]
    if kind == "numeric":
        return one(NUMERIC[tree[1]](tree[2]))
    if kind == "paired":
        return one(PAIRED[tree[1]](tree[2], tree[3]))
    if kind == "versor":
        return of_versor(tree[1], tree[2])
    if kind == "unary":
        return UNARY[tree[1]](meant(tree[2], names))
    return BINARY[tree[1]](meant(tree[2], names), meant(tree[3], names))


def written(tree: Tree, least: int = 0) -> str:
    """The text of a tree with no more brackets than the order of precedence needs."""
    kind = tree[0]
    if kind == "number":
        return repr(tree[1])
    if kind == "name":
        return str(tree[1])
    if kind == "numeric":
        return f"{tree[1]}({tree[2]!r})"
    if kind == "paired":
        return f"{tree[1]}({tree[2]!r}, {tree[3]!r})"
    if kind == "versor":
        return str(tree[1]).format(f"exp({plane_text(tree[2])})")
    if kind == "unary":
        if tree[1].isalpha():
            return f"{tree[1]}({written(tree[2])})"
        return f"{tree[1]}{written(tree[2], 6)}"
    tight = TIGHTNESS[tree[1]]
    text = f"{written(tree[2], tight)} {tree[1]} {written(tree[3], tight + 1)}"
    return f"({text})" if tight < least else text


NUMBERS = st.sampled_from([0.0, 0.5, 1.0, 2.0, 3.0, 1e-1])
SMALL_PLANES = st.sampled_from(
    [
        (0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.5, 0.0, 0.0, 0.25),
        (0.25, 0.5, 1e-3, 0.0, 0.25, 0.5, 0.0, 1e-3, 0.0, 0.25),
        (0.0, 0.25, 0.0, 0.5, 0.25, 0.0, 0.5, 0.25, 0.25, 1e-3),
    ]
)


def trees(names: tuple[str, ...]) -> st.SearchStrategy[Tree]:
    leaves = st.one_of(
        NUMBERS.map(lambda n: ("number", n)),
        st.sampled_from(names).map(lambda n: ("name", n)),
        st.tuples(st.just("numeric"), st.sampled_from(sorted(NUMERIC)), NUMBERS),
        st.tuples(st.just("paired"), st.sampled_from(sorted(PAIRED)), NUMBERS, NUMBERS),
        st.tuples(st.just("versor"), st.sampled_from(sorted(OF_VERSOR)), SMALL_PLANES),
    )

    def grown(below: st.SearchStrategy[Tree]) -> st.SearchStrategy[Tree]:
        divisors = leaves.map(lambda leaf: ("binary", "+", ("number", 7.0), leaf))
        return st.one_of(
            st.tuples(st.just("unary"), st.sampled_from(sorted(UNARY)), below),
            st.tuples(st.just("binary"), st.sampled_from("+-*^."), below, below),
            st.tuples(st.just("binary"), st.just("/"), below, divisors),
        )

    return st.recursive(leaves, grown, max_leaves=9)


def check(found: Multivector, expected: Coefficients) -> None:
    orthogonal = found.as_orthogonal()
    made = np.zeros(32)
    for mask, value in zip(orthogonal.masks, orthogonal.values, strict=True):
        made[mask] = value
    size = max(1.0, float(np.max(np.abs(expected))), float(np.max(np.abs(made))))
    np.testing.assert_allclose(made, expected, rtol=0, atol=1e-9 * size)


BASIS_NAMES = tuple(BASIS)
KNOWN = BASIS | {name: one(value) for name, value in VARIABLES.items()}
CALM = settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))


@CALM
@given(trees((*BASIS_NAMES, "s", "t")))
def test_an_expression_means_what_the_plain_evaluator_says(tree: Tree) -> None:
    expected = meant(tree, KNOWN)  # first: what it leaves out, a script may refuse as an overflow
    text = f"u = s + t; ?x = {written(tree)};"
    check(evaluate(parse(text), **VARIABLES)["x"], expected)


@settings(CALM, max_examples=60)
@given(st.data())
def test_statements_run_in_order_and_names_are_assigned_again(data: st.DataObject) -> None:
    names, lines, expected = dict(KNOWN), ["u = s + t;"], {}
    for _ in range(data.draw(st.integers(1, 5))):
        tree = data.draw(trees(tuple(names)))
        target = data.draw(st.sampled_from(["a", "b", "c"]))
        mark = data.draw(st.sampled_from(["", "?", "!", ":"]))
        lines.append(f"{mark}{target} = {written(tree)}; // {target}")
        value = meant(tree, names)
        # Left out where the script has grown beyond what rounding allows to compare.
        names[target] = value if np.max(np.abs(value)) < 1e6 else one(1)
        if names[target] is not value:
            lines.append(f"{mark}{target} = 1;")
        if mark == "?":
            expected[target] = names[target]
    found = evaluate(parse("\n/* a\n comment */".join(lines)), CGA3, **VARIABLES)
    assert list(found) == list(expected)
    for name, value in expected.items():
        check(found[name], value)


@settings(CALM, max_examples=120)
@given(trees((*BASIS_NAMES, "_P(1)", "_P(2)", "y")), trees(BASIS_NAMES), trees(BASIS_NAMES))
def test_a_macro_is_its_body_with_the_arguments_in_place(body: Tree, a: Tree, b: Tree) -> None:
    first, second = meant(a, KNOWN), meant(b, KNOWN)
    text = f"""
        m = {{ y = _P(1) + 2*_P(2); {written(body)} + _P(2)*0 }}
        y = 3;
        ?x = m({written(a)}, {written(b)}) + y;
    """
    names = BASIS | {"_P(1)": first, "_P(2)": second, "y": first + 2 * second}
    check(evaluate(parse(text))["x"], meant(body, names) + one(3))


@pytest.mark.parametrize(
    ("tight", "loose"),
    [(a, b) for a in TIGHTNESS for b in TIGHTNESS if TIGHTNESS[a] > TIGHTNESS[b]],
)
def test_the_tighter_operator_goes_first_on_either_side(tight: str, loose: str) -> None:
    a, b, c = "(1+e1+e2^e3)", "(2-e2+e1^e3)", "(3+e1-e1^e2)"
    for bare, bracketed in (
        (f"{a}{tight}{b}{loose}{c}", f"({a}{tight}{b}){loose}{c}"),
        (f"{a}{loose}{b}{tight}{c}", f"{a}{loose}({b}{tight}{c})"),
    ):
        found = evaluate(parse(f"?x = {bare}; ?y = {bracketed};"))
        assert repr(found["x"]) == repr(found["y"])


@pytest.mark.parametrize(
    ("bare", "bracketed"),
    [
        ("7 - 2 + 1", "(7 - 2) + 1"),
        ("7 - 2 - 1", "(7 - 2) - 1"),
        ("8 / 4 / 2", "(8 / 4) / 2"),
        ("e1 . e1^e2 . e2", "(e1 . (e1^e2)) . e2"),
        ("*e1^e2", "(*e1)^e2"),
        ("~e1^e2*e3", "((~e1)^e2)*e3"),
        ("-e1 . e1", "(-e1) . e1"),
        ("e1**e2", "e1*(*e2)"),
        ("e1*-~*e2", "e1*(-(~(*e2)))"),
        ("8 / *e1", "8 / (*e1)"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*there are no powers")
def test_grouping_is_to_the_left_and_prefixes_are_tightest(bare: str, bracketed: str) -> None:
    found = evaluate(parse(f"?x = {bare}; ?y = {bracketed};"))
    assert repr(found["x"]) == repr(found["y"])
