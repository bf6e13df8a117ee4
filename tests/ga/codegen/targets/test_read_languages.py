"""WGSL and Julia, which nothing here compiles, are read back and agree with evaluation."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import DOUBLE, SINGLE
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.targets import julia, wgsl
from motorcade.ga.codegen.targets.names import typed
from motorcade.ga.script import parse
from tests.ga.codegen.conftest import Nodes
from tests.ga.codegen.targets.reader import Expressions

NAMED = {
    "sqrt": np.sqrt, "abs": np.abs, "floor": np.floor, "ceil": np.ceil, "min": np.minimum,
    "max": np.maximum, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
}  # fmt: skip


def two_sided(*args: Any) -> Any:
    return np.arctan(*args) if len(args) == 1 else np.arctan2(*args)


def read_wgsl(text: str, inputs: dict[str, Any]) -> list[Any]:
    """Every store in order; types of declarations are held against their values."""
    functions = NAMED | {"atan2": np.arctan2, "select": lambda no, yes, c: np.where(c, yes, no)}
    head, body = re.sub(r"//.*", "", text).split("{", 1)
    parameters = re.findall(r"(\w+): (f32|ptr)", head)
    assert [name for name, kind in parameters if kind == "f32"] == list(inputs)
    names, stored, reader = dict(inputs), [], Expressions(functions)
    for line in " ".join(body.removesuffix("}\n").split()).split(";"):
        if found := re.fullmatch(r" *let (\w+): (bool|f32) = (.*)", line):
            value = names[found[1]] = reader.value(found[3], names)
            assert (np.asarray(value).dtype == bool) == (found[2] == "bool"), line
        elif found := re.fullmatch(r" *\(\*out_(\w+)\)\[(\d+)\] = (.*)", line):
            stored.append(reader.value(found[3], names))
        else:
            assert not line.strip(), line
    return stored


def read_julia(text: str, inputs: dict[str, Any]) -> dict[str, list[Any]]:
    """The fields of the named tuple that is returned."""
    lines = [line.split("#")[0] for line in text.splitlines()]
    body = "\n".join(lines).split(")", 1)[1]
    functions = dict(NAMED) | {"ifelse": np.where, "atan": two_sided}
    for own, domain, called in re.findall(r"(\w+)\(v\) = (.*) \? (\w+)\(v\)", body):
        assert domain
        assert own == f"real_{called}", "a function of Julia with a guard"
        functions[own] = NAMED[called]
    names, reader = dict(inputs), Expressions(functions)
    body, returned = body.split("return (;")
    for line in re.split(r"\n(?=    \w)", body):  # a line that goes on is indented deeper
        found = re.fullmatch(r"\s*(\w+) = (.*?)\s*", line, re.S)
        if found:
            names[found[1]] = reader.value(found[2], names)
        else:
            assert not line.strip() or line.strip().startswith(("(", "real_")), line
    fields = re.findall(
        r'\n        (?:var"(\w+)"|(\w+)) =\s*\((.*?)\),(?=\n {8}\w|\n    \))', returned, re.S
    )
    return {a or b: reader.values(row, names) for a, b, row in fields}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_wgsl_agrees_with_evaluation(script: str, cases: Any) -> None:
    case = cases(script, "float32")
    (text,) = wgsl.write(case.program, None).values()
    made = read_wgsl(text, {n: v.astype(np.float64) for n, v in case.inputs.items()})
    rows = np.array(
        [np.broadcast_to(value, len(case.inputs[next(iter(case.inputs))])) for value in made]
    )
    case.checked(case.by_place(rows), 1e-5)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("precision", [None, SINGLE, DOUBLE], ids=str)
def test_julia_agrees_with_evaluation(script: str, precision: Any, cases: Any) -> None:
    case = cases(script, "float64")
    (text,) = julia.write(case.program, precision).values()
    made = read_julia(text, case.inputs)
    assert list(made) == [o.name for o in case.program.tape.outputs]
    count = len(next(iter(case.inputs.values())))
    rows = np.array([np.broadcast_to(v, count) for row in made.values() for v in row])
    case.checked(case.by_place(rows), 1e-12 if precision is not SINGLE else 1e-5)


def compiled(text: str, name: str = "scene") -> Program:
    return compile_script(parse(text), name)


def test_julia_brackets_what_goes_on_in_the_next_line() -> None:
    terms = " + ".join(f"sin(x{i})*cos(y{i})" for i in range(12))
    (text,) = julia.write(compiled(f"?a = {terms};"), None).values()
    depth = 0
    for line in text.splitlines():
        assert depth > 0 or not line.startswith(" " * 8), "a line that goes on is in brackets"
        depth += line.count("(") - line.count(")")
    made = read_julia(text, {f"{n}{i}": float(i) for i in range(12) for n in "xy"})
    expected = sum(np.sin(i) * np.cos(i) for i in range(12))
    assert made["a"] == [pytest.approx(expected, rel=1e-14)]


def test_julia_names_fields_that_it_keeps() -> None:
    (text,) = julia.write(compiled("?end = x;\n?_ = 2*x;\n?fine = 3*x;"), None).values()
    assert read_julia(text, {"x": 2.0}) == {"end": [2.0], "_": [4.0], "fine": [6.0]}


def test_wgsl_refuses_what_no_shader_may_hold() -> None:
    build = Nodes("x")
    build("add", 0, build("log", build.constant(-2.0)))
    program = replace(compiled("?out = x;"), tape=build.tape())
    with pytest.raises(ValueError, match=r"target wgsl: expected finite values, got log\(-2\)"):
        wgsl.write(program, None)
    with pytest.raises(ValueError, match="target wgsl: expected precision float32, got float64"):
        wgsl.write(compiled("?a = x;"), DOUBLE)


def test_conditions_and_numbers_are_kept_apart() -> None:
    build = Nodes("x", "y")
    less = build("lt", 0, 1)
    both = build("and", less, 0)
    chosen = build("select", 1, both, less)
    build("add", chosen, build("not", chosen))
    tape = typed(build.tape())
    booleans = {"lt", "ne", "and", "not"}
    for node in tape.nodes:
        kinds = [tape.nodes[k].op in booleans for k in node.args]
        if node.op in ("and", "not"):
            assert all(kinds)
        elif node.op == "select":
            assert kinds == [True, False, False]
        else:
            assert not any(kinds)
