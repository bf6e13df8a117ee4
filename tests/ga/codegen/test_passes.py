"""The optimiser keeps values, finds what is zero, never what is not, and reaches its counts."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")
pytest.importorskip("mpmath", reason="mpmath, which only the generator needs, is not installed")

from motorcade.ga.codegen.passes import finite_field
from motorcade.ga.codegen.passes.fingerprints import fingerprints
from motorcade.ga.codegen.passes.merge import sampled
from motorcade.ga.codegen.passes.optimize import PASSES, optimized
from motorcade.ga.codegen.passes.stats import (
    Operations,
    cost_of,
    count_operations,
    table_of_passes,
)
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder
from motorcade.ga.script import evaluate, parse

SCRIPTS = Path(__file__).resolve().parents[3] / "docs" / "scripts"
ScriptMaker = Callable[[np.random.Generator], str]
ROTOR = "R = w + x*e2^e3 + y*e3^e1 + z*e1^e2;"
TABLE_2 = """
T1 = 1 - 0.5*(tr1X*e1 + tr1Y*e2 + tr1Z*e3)*einf;
T2 = 1 - 0.5*(tr2X*e1 + tr2Y*e2 + tr2Z*e3)*einf;
motor1 = T1*(w1 + x1*e2^e3 + y1*e3^e1 + z1*e1^e2);
motor2 = T2*(w2 + x2*e2^e3 + y2*e3^e1 + z2*e1^e2);
m = motor1*(1 - alpha) + motor2*alpha;
?x = m*e1^einf/m; ?y = m*e2^einf/m; ?z = m*e3^einf/m; ?t = m*e0^einf/m;
"""


def compiled(text: str) -> Program:
    return compile_script(parse(text, "test.clu"), "test")


def traced(text: str) -> Tape:
    """A script as it is before any pass: components that are zero are still there."""
    kept: list[Tape] = []

    def untouched(tape: Tape) -> tuple[Tape, tuple[()]]:
        kept.append(tape)
        return tape, ()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("motorcade.ga.codegen.programs.optimized", untouched)
        compiled(text)
    return kept[0]


def values_of(tape: Tape) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    values, errors = sampled(tape)
    return {
        (output.name, blade): (values[k], errors[k])
        for output, row in zip(tape.outputs, tape.results, strict=True)
        for blade, k in zip(output.components, row, strict=True)
    }


def check_same_values(before: Tape, after: Tape) -> None:
    """Where a value was defined it is the same to rounding; components that are gone were zero."""
    old, new = values_of(before), values_of(after)
    assert set(new) <= set(old)
    for key, (value, error) in old.items():
        made, bound = new.get(key, (np.zeros_like(value), np.zeros_like(value)))
        known = np.isfinite(value) & np.isfinite(error)
        within = 64 * (error + bound) + 1e-300
        assert np.all(np.abs(made - value)[known] <= within[known]), key


@pytest.mark.parametrize("seed", range(60))
def test_each_pass_keeps_the_values_of_random_scripts(
    seed: int, random_script: ScriptMaker
) -> None:
    text = random_script(np.random.default_rng(seed))
    try:
        tape = traced(text)
    except ValueError as refused:
        pytest.skip(f"a script without meaning: {refused}")
    for _, apply in PASSES:
        made = apply(tape)
        check_same_values(tape, made)
        tape = made


@pytest.mark.parametrize("seed", range(60, 120))
def test_programs_compute_what_scripts_mean_and_keep_no_zeros(
    seed: int, random_script: ScriptMaker
) -> None:
    from motorcade.ga.codegen.tape import run_tape

    rng = np.random.default_rng(seed)
    script = parse(random_script(rng), "test.clu")
    try:
        program = compile_script(script, "test")
    except ValueError as refused:
        pytest.skip(f"a script without meaning: {refused}")
    tape = program.tape
    given = {operand.name: rng.uniform(-2, 2, 7) for operand in tape.inputs}
    made = run_tape(tape, {(name, 0): value for name, value in given.items()})
    for (name, expected), operand, row in zip(
        evaluate(script, **given).items(), tape.outputs, made, strict=True
    ):
        assert name == operand.name
        size = max([1.0, *(float(np.max(np.abs(part))) for part in expected.values)])
        found = dict(zip(operand.components, row, strict=True))
        for blade in {**dict(expected.items()), **found}:
            off = np.abs(expected.coefficient(blade) - found.get(blade, 0.0))
            assert np.all(off <= 1e-12 * size), (name, blade)
        for blade, value in found.items():
            assert np.any(value != 0.0), f"{name} {blade} is zero"


ZEROS = [
    "(a + b)*(a + b) - a*a - b*b - 2*a*b",
    "(a*a - b*b)/(a - b) - a - b",
    "a/b*b - a",
    "1/(1/a) - a",
    "sqrt(a)*sqrt(a) - a",
    "sqrt(a*a) - abs(a)",
    "abs(a) - abs(-a)",
    "abs(a*b) - abs(a)*abs(b)",
    "sqrt(4*a) - 2*sqrt(a)",
    "abs(-6*a) - 6*abs(a)",
    "abs(a)*abs(a) - a*a",
    "abs(a*a + b*b) - a*a - b*b",
    "sin(a)*sin(a) + cos(a)*cos(a) - 1",
    "sin(a) + sin(-a)",
    "cos(a - b) - cos(b - a)",
    "tan(a)*cos(a) - sin(a)",
    "exp(a)*exp(-a) - 1",
    "asin(a) + asin(-a)",
    "atan(a) + atan(-a)",
    "ceil(a) + floor(-a)",
    "sin(a*b + b) - sin(b*(a + 1))",
    "a/(a*a)*a - 1",
    "a/sqrt(a*a + b*b)*a/sqrt(a*a + b*b) + b*b/(a*a + b*b) - 1",
]


@pytest.mark.parametrize("text", ZEROS)
def test_true_zeros_are_found(text: str) -> None:
    program = compiled(f"?value = {text};")
    assert program.tape.outputs == (Operand("value", ()),)
    assert program.tape.nodes == ()


NO_ZEROS = [
    "sqrt(a*a) - a", "sqrt(a*a) + a", "abs(a) - a", "abs(a) + a", "sqrt((a - b)*(a - b)) - a + b",
    "sqrt(a*a)*sqrt(b*b) - a*b", "sqrt(a*a*b*b) - a*b", "abs(a)*abs(b) - a*b",
    "1000000*a + sqrt(b*b) - b - 1000000*a", "1 + 0.00000000000000000001*(sqrt(a*a) - a) - 1",
    "sin(2*a) - 2*sin(a)", "abs(sin(a)) - sin(a)", "sqrt(1 - sin(a)*sin(a)) - cos(a)",
    "cos(a) - cos(b)", "acos(a) + acos(-a)", "asin(sin(a)) - a", "log(a*a) - 2*log(a)",
    "exp(a + b) - exp(a)*exp(b)*1.0000001", "floor(a) - a", "ceil(a) - floor(a)",
    "a*a*a*a*a - a", "2305843009213693952*a - a", "4611686018427387904*a*0.5 - a",
    "0.1*a + 0.2*a - 0.3*a", "a/(a + 0.0000000001) - 1",
]  # fmt: skip


@pytest.mark.parametrize("text", NO_ZEROS)
def test_no_false_zero_is_claimed(text: str) -> None:
    program = compiled(f"?value = {text};")
    assert program.tape.outputs == (Operand("value", ("1",)),)
    check_same_values(traced(f"?value = {text};"), program.tape)


@pytest.mark.parametrize("sign", "+-")
@pytest.mark.parametrize("others", range(8))
def test_no_cancellation_hides_a_sign_that_was_guessed(others: int, sign: str) -> None:
    """Beside 1e20 float64 does not see a; the field takes sqrt(a²) for a at some points."""
    first = "".join(f"?u{k} = x{k};" for k in range(others))
    large = "100000000000000000000"
    program = compiled(f"{first} ?value = {large}*b + sqrt(a*a) {sign} a - {large}*b;")
    assert program.tape.outputs[-1] == Operand("value", ("1",))


@pytest.mark.parametrize("others", range(8))
def test_signs_that_no_sample_has_are_not_forgotten(others: int) -> None:
    """Wherever the optimiser looks, a is below 100000, and -a above -100000."""
    first = "".join(f"?u{k} = x{k};" for k in range(others))
    for value in ("abs(a - 100000) + a - 100000", "sqrt((a + 100000)*(a + 100000)) - a - 100000"):
        program = compiled(f"{first} ?value = {value};")
        assert program.tape.outputs[-1] == Operand("value", ("1",)), value


def test_nothing_is_replaced_by_what_is_defined_at_fewer_places() -> None:
    """Wherever the optimiser looks, all of these are numbers."""
    from motorcade.ga.codegen.tape import run_tape

    powers = "c = a*a; p = c*c; d = b*b; q = d*d;"
    for before, value in (
        ("sqrt(a + 1000)*sqrt(a + 1000)", "a + 1000"),
        ("a/(a - 777)*(a - 777)", "2*a - a"),
        ("(p*p - q*q)/(a - b)", " + ".join("*".join("a" * k + "b" * (7 - k)) for k in range(8))),
    ):
        tape = compiled(f"{powers} ?first = {before}; ?second = {value}; ?b;").tape
        for a in (-2000.0, 777.0):
            made = run_tape(tape, {("a", 0): np.float64(a), ("b", 0): np.float64(a)})
            assert np.isfinite(made[1][0]), (before, a)


def test_a_sign_that_was_guessed_needs_another_proof() -> None:
    tape = traced("?value = sqrt(a*a + 2*a*b + b*b)*a;")
    prints = fingerprints(tape)
    root = next(k for k, node in enumerate(tape.nodes) if node.op == "sqrt")
    a, b = (next(k for k, node in enumerate(tape.nodes) if node.source[0] == name) for name in "ab")
    for value, x, y in zip(*(prints.values[k] for k in (root, a, b)), strict=True):
        total = finite_field.add(x, y)
        assert value in (total, finite_field.negative(total))
    assert prints.uncertain[root]
    assert not prints.uncertain[a]


def test_rotor_sandwiches_have_no_odd_parts_and_unit_rotors_no_norm() -> None:
    program = compiled(f"{ROTOR} ?image = R*(a*e1 + b*e2 + c*e3)*~R;")
    assert program.tape.outputs == (Operand("image", ("e1", "e2", "e3")),)
    program = compiled(f"{ROTOR} U = R/abs(R); ?one = U*~U; ?same = U*~U*a;")
    assert program.tape.outputs == (Operand("one", ("1",)), Operand("same", ("1",)))
    assert program.tape.operations() == {}, "1 and a are all that is left"
    program = compiled(f"{ROTOR} P = VecN3(a, b, c); ?image = R*P/R;")
    assert program.tape.outputs[0].components == ("e1", "e2", "e3", "e0", "einf")


def test_table_2_keeps_to_its_operations() -> None:
    program = compiled(TABLE_2)
    counts = count_operations(program.tape)
    assert [output.components for output in program.tape.outputs] == [
        *[("e1^einf", "e2^einf", "e3^einf")] * 3,
        ("e1^einf", "e2^einf", "e3^einf", "e0^einf", "e1^e2^e3^einf"),
    ]
    assert counts.multiplications <= 83
    assert counts.additions <= 54
    assert counts.divisions == 1
    assert counts.transcendental == 0


@pytest.mark.parametrize("path", sorted(SCRIPTS.glob("*.clu")), ids=lambda path: path.stem)
def test_example_scripts_keep_their_values(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    tape, after = traced(text), compiled(text).tape
    check_same_values(tape, after)
    assert cost_of(after) <= cost_of(tape)


def test_reciprocals_are_shared() -> None:
    divisions = {
        "?u = a/c; ?v = b/c; ?w = a*b/(c*c);": 1,
        "?u = 1/(a*b); ?v = 1/a; ?w = 1/b;": 2,
        "?u = a/b + c/d;": 2,
        "?u = a/3;": 0,
        "?u = a/(b + c); ?v = a/sqrt(b + c);": 1,
        "n = a*a + b*b; ?u = a/sqrt(n); ?v = b/n; ?w = a/(n*sqrt(n));": 1,
    }
    for text, wanted in divisions.items():
        assert compiled(text).tape.operations().get("div", 0) == wanted, text


@pytest.mark.parametrize(
    ("text", "operations"),
    [
        ("?y = a/b;", {"div": 1}),
        ("?y = a/b; ?z = c/b;", {"div": 1, "mul": 2}),
        ("?y = a*(c/b);", {"div": 1, "mul": 1}),
        ("?y = (a/b + c)*b - a;", {"mul": 1}),
        ("?y = (a/sqrt(b) + c)*b - a*sqrt(b);", {"mul": 1}),
        ("?y = (a*sqrt(b) + c)*sqrt(b) - a*b;", {"mul": 1, "sqrt": 1}),
    ],
)
def test_quotients_are_single_and_cancel(text: str, operations: dict[str, int]) -> None:
    assert compiled(text).tape.operations() == operations


def test_common_factors_and_terms_are_taken_out() -> None:
    operations = {
        "?u = a*b + a*c;": {"add": 1, "mul": 1},
        "?u = a*b + a*c + d; ?v = b + c;": {"add": 2, "mul": 1},
        "?u = a*b + c*d + a; ?v = a*b + c*d - b;": {"add": 2, "mul": 2, "sub": 1},
        "?u = (a + b)*(a + b) - (a - b)*(a - b);": {"mul": 2},
        "?u = a*a*a*a*a*a*a*a;": {"mul": 3},
    }
    for text, wanted in operations.items():
        assert compiled(text).tape.operations() == wanted, text


def test_long_sums_and_high_powers_stay_what_they_are() -> None:
    terms = " + ".join(f"x{k}*y{k}" for k in range(400))
    assert compiled(f"?u = {terms};").tape.operations() == {"add": 399, "mul": 400}
    squares = "".join(f"a{k + 1} = a{k}*a{k};" for k in range(100))
    assert compiled(f"a0 = x + y; {squares} ?a100;").tape.operations() == {"add": 1, "mul": 100}
    chain = "".join(f"a{k + 1} = a{k}*a{k} + y;" for k in range(60))
    assert compiled(f"a0 = x; {chain} ?a60;").tape.operations() == {"add": 60, "mul": 60}


def test_divisors_that_are_always_zero_are_refused() -> None:
    with pytest.raises(ValueError, match="test: expected divisors that are not zero"):
        compiled("?u = 1/((a + b)*(a - b) - a*a + b*b);")


def test_constants_are_folded_where_they_are_finite() -> None:
    builder = TapeBuilder()
    x = builder.input("x", 0)
    two, three = builder.constant(2.0), builder.constant(3.0)
    assert builder.nodes[builder.operation("mul", two, three)].value == 6.0
    assert builder.operation("add", x, builder.operation("sub", two, two)) == x
    assert builder.nodes[builder.operation("div", two, builder.constant(0.0))].op == "div"
    condition = builder.operation("lt", two, three)
    assert builder.operation("select", condition, x, two) == x
    assert builder.nodes[builder.operation("log", builder.constant(-1.0))].op == "log"


def test_the_passes_say_what_they_did() -> None:
    program = compiled(TABLE_2)
    assert [done.name for done in program.passes] == [name for name, _ in PASSES]
    assert program.passes[-1].after == count_operations(program.tape)
    for done, following in zip(program.passes, program.passes[1:], strict=False):
        assert done.after == following.before
    lines = table_of_passes(program.passes).splitlines()
    assert len(lines) == len(PASSES) + 2
    assert lines[1].split()[0] == "traced"
    assert lines[-1].split()[-5:-1] == [
        str(part)
        for part in (
            program.passes[-1].after.additions,
            program.passes[-1].after.multiplications,
            program.passes[-1].after.divisions,
            program.passes[-1].after.transcendental,
        )
    ]


def test_operations_are_counted_by_kind_and_divisions_cost_most() -> None:
    counts = count_operations(compiled("?y = a*b*c + d/sqrt(x) - sin(z);").tape)
    found = counts.additions, counts.multiplications, counts.divisions, counts.transcendental
    assert found == (2, 2, 1, 2)
    costs = [cost_of(compiled(f"?y = {text};").tape) for text in ("a + b", "a*b", "a/b")]
    assert costs[0] == costs[1] < costs[2]
    assert count_operations(compiled("?y = a;").tape) == Operations(0, 0, 0, 0)


def test_the_same_script_gives_the_same_tape_whatever_hashes_are() -> None:
    code = (
        "import sys, hashlib\n"
        "from motorcade.ga.script import parse\n"
        "from motorcade.ga.codegen.programs import compile_script\n"
        "tape = compile_script(parse(sys.argv[1], 't.clu'), 't').tape\n"
        "print(hashlib.sha256(repr(tape).encode()).hexdigest())"
    )
    text = TABLE_2 + "?s = sin(alpha)/(alpha*w1) + sqrt(w1*w1)/alpha;"
    made = set()
    for seed in ("0", "1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", code, text],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        made.add(done.stdout)
    assert len(made) == 1
    assert optimized(traced(text))[0] == compiled(text).tape


def test_searches_are_left_out_of_long_tapes_and_the_table_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tape = traced(TABLE_2 + "?zero = (m + 1)*(m - 1) - m*m + 1;")
    short, _ = optimized(tape)
    monkeypatch.setattr("motorcade.ga.codegen.passes.optimize.LONGEST_SEARCHED", 50)
    monkeypatch.setattr("motorcade.ga.codegen.passes.merge._LONGEST_COMPARED", 50)
    made, passes = optimized(tape)
    check_same_values(tape, made)
    assert made.outputs == short.outputs, "zeros are proved on tapes of any length"
    assert cost_of(made) > cost_of(short)
    assert [done.name for done in passes if done.skipped] == ["collect like terms", "factor"]
    shown = table_of_passes(passes).splitlines()
    assert [line.split()[-1] for line in shown if line.startswith("factor")] == ["skipped"]
    assert shown[-1] == "skipped: too many operations for this pass"
