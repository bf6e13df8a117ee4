"""Branches, loops, parts of multivectors, and what pragmas do to inputs and outputs."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga.script import ScriptError, evaluate, parse
from motorcade.ga.script.errors import ScriptWarning


def values(text: str, **given: object) -> dict[str, dict[str, object]]:
    return {name: dict(x.items()) for name, x in evaluate(parse(text), **given).items()}


COLLATZ = """
steps = 0;
loop {
    if (n == 1) { break; }
    half = floor(n/2);
    if (n == 2*half) { n = half; } else { n = 3*n + 1; }
    steps = steps + 1
}
?steps;
"""
SIDES = """
if (x < 0) { side = -1*e1; other = 1; }
else if (x > 1 && !!(y == 2)) { side = e1 + x*e2; }
else side = y;
?side;
"""


def test_a_loop_runs_until_it_breaks() -> None:
    """Collatz's sequence from 27 takes 111 steps (OEIS A006577)."""
    assert values(COLLATZ, n=27.0) == {"steps": {"1": 111.0}}


def test_the_rounds_of_a_pragma_end_a_loop() -> None:
    text = "p = 1;\n//#pragma unroll 5\nloop { p = p*x; if (p > top) { break; } }\n?p;"
    assert values(text, x=2.0, top=1e9) == {"p": {"1": 32.0}}
    assert values(text, x=2.0, top=5.0) == {"p": {"1": 8.0}}
    nested = "s = 0;\n#pragma count 3\nloop {\n#pragma unroll 4\nloop { s = s + 1; } } ?s;"
    assert values(nested) == {"s": {"1": 12.0}}


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (-1.0, 0.0, {"e1": -1.0}),
        (2.0, 3.0, {"e1": 1.0, "e2": 2.0}),
        (2.0, 2.0, {"1": 2.0}),
        (0.5, 7.0, {"1": 7.0}),
    ],
)
def test_one_branch_is_run_where_the_condition_is_known(
    x: float, y: float, expected: dict[str, float]
) -> None:
    assert values(SIDES, x=x, y=y)["side"] == expected


def test_batches_and_symbols_choose_each_coefficient() -> None:
    ca = pytest.importorskip("casadi")
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-1.0, 2.0, 40), rng.integers(1, 4, 40).astype(float)
    batch = evaluate(parse(SIDES), x=x, y=y)["side"]
    symbols = ca.SX.sym("x"), ca.SX.sym("y")
    symbolic = evaluate(parse(SIDES), x=symbols[0], y=symbols[1])["side"]
    function = ca.Function("f", list(symbols), [symbolic.coefficient(b) for b in ("1", "e1", "e2")])
    for k in range(40):
        single = evaluate(parse(SIDES), x=x[k], y=y[k])["side"]
        expected = [float(single.coefficient(b)) for b in ("1", "e1", "e2")]
        found = [np.broadcast_to(batch.coefficient(b), 40)[k] for b in ("1", "e1", "e2")]
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal([float(v) for v in function(x[k], y[k])], expected)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("if (x > 0) { a = 1; } ?a;", "a has no value here"),
        ("loop { if (x > 0) { break; } }", "a condition that is known"),
        ("if (x > 0) { ?a = 1; } else { a = 2; }", "outputs outside of branches"),
    ],
)
def test_what_hangs_on_a_batch_is_refused(text: str, message: str) -> None:
    with pytest.raises(ScriptError, match=message):
        evaluate(parse(text), x=np.array([-1.0, 1.0]))


def test_generated_code_chooses_as_evaluation_does() -> None:
    pytest.importorskip("casadi")
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.codegen.tape import run_tape

    tape = compile_script(parse(SIDES), "sides").tape
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-1.0, 2.0, 30), rng.integers(1, 4, 30).astype(float)
    (rows,) = run_tape(tape, {("x", 0): x, ("y", 0): y})
    expected = evaluate(parse(SIDES), x=x, y=y)["side"]
    for blade, row in zip(tape.outputs[0].components, rows, strict=True):
        np.testing.assert_array_equal(np.broadcast_to(row, 30), expected.coefficient(blade))


def test_strategies_write_branches_that_cannot_be_taken() -> None:
    """One of them sees by itself that 1/d is never below 1/d, the program does not."""
    pytest.importorskip("casadi")
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.codegen.strategies import product, table

    script = parse("if (1/d < 1/d) { v = e1; } else v = d; ?v;")
    program = compile_script(script, "never")
    assert program.tape.outputs[0].components == ("1", "e1")
    for strategy in (product, table):
        assert "out0[1] = 0;" in strategy.write(script, program, None)["never.c"]


def test_parts_by_blade_and_by_grade() -> None:
    x = "(2 + 3*e1 + 5*e1^e2 + 7*e1^e2^e3)"
    assert values(f"?a = {x}[1, e2^e1]; ?b = (-{x})[e1];") == {
        "a": {"1": 2.0, "e1^e2": 5.0},
        "b": {"e1": -3.0},
    }
    assert values(f"?a = grade({x}, 2); ?b = Coefficient({x}, e2^e1^e3);") == {
        "a": {"e1^e2": 5.0},
        "b": {"1": -7.0},
    }
    signs = values(f"?a = reverse({x}); ?b = involute({x}); ?c = conjugate({x});")
    assert [[np.sign(v) for v in x.values()] for x in signs.values()] == [
        [1, 1, -1, -1],
        [1, -1, 1, -1],
        [1, -1, -1, 1],
    ]


def test_contractions_and_the_meet() -> None:
    assert values("?a = e1 << e1^e2; ?b = e1^e2 << e1; ?c = 2 << e1; ?d = e1^e2 >> e2;") == {
        "a": {"e2": 1},
        "b": {},
        "c": {"e1": 2.0},
        "d": {"e1": 1},
    }
    # Two planes of PGA meet in a line by ^, two points join in one by &.
    text = "#pragma algebra pga3\n?l = createPoint(0, 0, 0) & createPoint(0, 0, 2); ?m = e1^e2;"
    made = values(text)
    assert {name: abs(v) for name, v in made["l"].items() if v} == {"e1^e2": 2.0}  # type: ignore[arg-type]
    assert made["m"] == {"e1^e2": 1}


def test_macros_stand_anywhere_and_hide_what_is_not_gaalops() -> None:
    assert values("?a = f(3); f = { g(_P(1)) + 1 } g = { 2*_P(1) }") == {"a": {"1": 7.0}}
    assert values("step = { 5 } min = { _P(1) } ?a = step() + min(3) + min(3, 4);") == {
        "a": {"1": 11.0}
    }
    assert values("Dual = { 2*Dual(_P(1)) } ?a = *e1; ?b = Dual(e1);")["a"] == {"e2^e3^e0^einf": 2}
    assert values("k = 3; f = { k = 1; k + ::k } ?a = f();") == {"a": {"1": 4.0}}


def test_outputs_of_macros_are_named_after_them() -> None:
    made = values("f = {\n\t?k = _P(1) + 1\n\tk\n}\n?a = f(1);\n?b = f(a);")
    assert {name: x["1"] for name, x in made.items()} == {
        "macro_f_k": 2.0,
        "a": 2.0,
        "macro_f_k1": 3.0,
        "b": 3.0,
    }


def test_pragmas_order_inputs_and_outputs() -> None:
    text = "#pragma in2out b, unread, a -> y, x\n?x = a; ?z = 2; y = b;"
    made = values(text, a=1.0, b=2.0)
    assert {name: x["1"] for name, x in made.items()} == {"y": 2.0, "x": 1.0, "z": 2.0}
    pytest.importorskip("casadi")
    from motorcade.ga.codegen.programs import compile_script

    tape = compile_script(parse(text), "ordered").tape
    assert [operand.name for operand in tape.inputs] == ["b", "unread", "a"]


def test_outputs_are_normalised_below_the_pragma() -> None:
    made = values("?a = 3*e1 + 4*e2;\n#pragma normalize\n?b = 3*e1 + 4*e2; ?b_unnormalized;")
    assert made["a"] == made["b_unnormalized"] == {"e1": 3.0, "e2": 4.0}
    assert made["b"] == pytest.approx({"e1": 0.6, "e2": 0.8})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("#pragma insert import os;\n?x = 1;", "my.clu:1:1: no text of a script goes into code"),
        ("#pragma return x typed T as T(x)\nx = 1;", "my.clu:1:1: outputs are multivectors"),
        ("?x = sin(1, 2);", "my.clu:1:6: sin takes 1: what follows is left out"),
        ("#pragma algebra cga\n?x = exp(e1^e2);", "my.clu:2:6: Gaalop takes the scalar part"),
        ("#pragma algebra cga\n?x = 1/(2 + e1);", "my.clu:2:7: Gaalop divides right by versors"),
    ],
)
def test_what_differs_from_gaalop_is_told_where_it_stands(text: str, message: str) -> None:
    with pytest.warns(ScriptWarning, match=message):
        evaluate(parse(text, "my.clu"))


def test_what_agrees_is_not_told() -> None:
    """Warnings are errors in these tests."""
    text = "#pragma algebra cga\n?x = exp(1)*sqrt(4)/(e1 + 2*e2); ?y = log(e1*e1);"
    evaluate(parse(text + "\n#pragma onlyEvaluate x\n#pragma segments x y\n"))


def test_a_script_without_a_folder_names_no_files(tmp_path: Path) -> None:
    (tmp_path / "a.clu").write_text("f = { 1 }")
    text = "#include a.clu\n?x = f();"
    assert evaluate(parse(text, folder=tmp_path))["x"].scalar_part() == 1.0
    with pytest.raises(ScriptError, match="read from a file"):
        parse(text, str(tmp_path / "main.clu"))
