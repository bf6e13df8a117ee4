"""Scripts of any kind: a ScriptError that points into the text, or finite values.

Inputs are random bytes, tokens in any order, changed examples, scripts grown from the grammar,
deep nesting and huge texts; free variables are numbers, batches or symbols.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.script import Script, ScriptError, evaluate, parse
from motorcade.ga.script.algebras import definitions
from motorcade.ga.script.errors import ScriptWarning
from motorcade.ga.script.functions import FUNCTIONS
from motorcade.ga.script.meaning import algebra_of, free_variables
from tests.fuzz.runner import Feed

__all__ = ["MAKERS", "prepare"]

Generator = np.random.Generator
EXAMPLES = Path(__file__).parents[3] / "docs" / "scripts"
TOKENS = [
    *"()+-*/^.~=?!:;,{} \n\t0123456789[]%<>&|#'\"\\@$",
    *("e1", "e2", "e3", "e0", "einf", "ep", "em", "x", "y", "z", "x = ", "?x = ", "?y = ", "m = {"),
    *("m(", "_P(1)", "_P(2)", "_P(", "//", "/*", "*/", "//#pragma ", "output x", "e1^e2", "return"),
    *("range 0 <= x <= 1", "algebra 3 0 1", "algebra 0 0 9", "algebra pga3", "1e300", "1e-320"),
    *("\u00e9", "\x00", "\ud800", "\r\n", "0.5f", "2d", "DefVarsN3();", ":IPNS;", ":Red;", "::x"),
    *("if (", "else {", "else ", "loop {", "break;", "}", "<<", ">>", "&&", "||", "!!", "==", "<="),
    *("#pragma unroll 3\n", "#pragma in2out x -> y\n", "#pragma normalize\n", "#include a.clu\n"),
    *("#pragma algebra dcga\n", "#pragma algebra ccga\n", "#pragma algebra own.toml\n", "[e1^e2]"),
    *(
        "#pragma insert x\n",
        "coefficient(",
        "SIN(",
        "?k = ",
        "::",
        "x = 2;",
        "m = { _P(1) + e1 }",
        "?z = m(x)/x;",
        "x = x*x;",
        "(1+e1)*(1+e2)*(1+e3)*(1+einf)",
    ),
    *(f"{name}(" for name in (*FUNCTIONS, "VecN3", "RotorN3", "SphereN3", "Normalize", "Dual")),
]
FILES = {
    "a.clu": "a = { b(_P(1)) + _P(1)[e1] }\n#include b.clu",
    "b.clu": "#include a.clu\nb = { 2*_P(1) }",
    "own.toml": 'squares = { e1 = 1, o = 0, i = 0 }\nnull_pairs = [["o", "i"]]\nmacros = "b.clu"',
}
BRANCHES = """#pragma in2out s, t -> v, w
#include a.clu
v = 1; n = 0;
#pragma unroll 8
loop { v = v*e1 + a(s); n = n + 1; if (n >= 3 || v[e1] == t) { break; } }
if (s < t && !!(s == 0)) { w = v << e1^e2; } else if (s > 2) w = grade(v & e1^e2, 1)
else { w = coefficient(v, e2^e1); }
?w; ?v;
"""
SEED_SCRIPT = """//#pragma range 0 <= t <= 1
m = { y = _P(1)^e1; y / 2 } x = 3; ?x = x*m(e2) . -~*e3 + VecN3(1,2,3)/(e1 - 2);
B = 0.3*e1^e2 + e1^einf; ?R = exp(t*log(exp(B))) * sqrt(1 + B);
//#pragma output x e1
"""


_SAID = "Normalize Dual VecN3 createPoint createRotor Toroid regProd T1 I einf Rotor"
MACROS = _SAID.split(" ")
_SIGNS = "+ - * / ^ . + - * / ^ . & << >> < == && ||"
OPERATORS = [f" {operator} " for operator in _SIGNS.split(" ")]


def chosen(rng: Generator, items: list[str], count: int) -> list[str]:
    return [items[k] for k in rng.integers(0, len(items), count)]


def random_bytes(rng: Generator) -> str:
    raw = rng.bytes(int(rng.integers(0, 80)))
    return raw.decode("latin-1") if rng.random() < 0.5 else raw.decode("utf-8", "surrogateescape")


def token_soup(rng: Generator) -> str:
    return "".join(chosen(rng, TOKENS, int(rng.integers(0, 40))))


def changed_example(rng: Generator) -> str:
    scripts = [
        SEED_SCRIPT,
        BRANCHES,
        *(path.read_text() for path in sorted(EXAMPLES.glob("*.clu"))),
    ]
    text = scripts[int(rng.integers(0, len(scripts)))]
    for _ in range(int(rng.integers(1, 4))):
        start, other = sorted(rng.integers(0, len(text) + 1, 2).tolist())
        piece = "".join(chosen(rng, TOKENS, int(rng.integers(0, 3))))
        kind = rng.random()
        if kind < 0.6:
            text = text[:start] + piece + text[start + int(rng.integers(0, 6)) :]
        elif kind < 0.8:
            text = text[:start] + text[min(other, start + 40) :]
        else:
            text = text[:start] + text[start:other][:200] * 2 + text[other:]
    return text


def grown_expression(rng: Generator, names: list[str], depth: int) -> str:
    kind = rng.random() if depth > 0 else 0.0
    if kind < 0.25:
        return chosen(rng, names, 1)[0]
    if kind < 0.35:
        prefixed = chosen(rng, ["-", "~", "*", "-~", "!!"], 1)[0]
        sliced = "[e1, 1]" if rng.random() < 0.2 else ""
        return prefixed + grown_expression(rng, names, depth - 1) + sliced
    if kind < 0.6:
        name = chosen(rng, [*FUNCTIONS, *MACROS, "m", "m"], 1)[0]
        count = {"m": 2, "createRotor": 4}.get(name, 3 if name in ("VecN3", "createPoint") else 1)
        count = FUNCTIONS[name].arity if name in FUNCTIONS else count
        arguments = [grown_expression(rng, names, depth - 1) for _ in range(count)]
        return f"{name}({', '.join(arguments)})"
    left, right = (grown_expression(rng, names, depth - 1) for _ in range(2))
    operator = chosen(rng, OPERATORS, 1)[0]
    return f"({left}{operator}{right})" if rng.random() < 0.5 else f"{left}{operator}{right}"


def grown_script(rng: Generator) -> str:
    algebra = chosen(rng, [*definitions(), "2 3 0", "1 0 4", "own.toml", "cga3", "cga3"], 1)[0]
    names = ["e1", "e2", "1", "0.5", "2", "1e-9", "s", "t"]
    names += ["e3", "e0", "einf"] if algebra == "cga3" else []
    body = grown_expression(rng, [*names, "_P(1)", "_P(2)"], 2)
    lines = [f"//#pragma algebra {algebra}", f"m = {{ y = {body}; y + 0*_P(2) }}"]
    for k in range(int(rng.integers(1, 6))):
        mark = chosen(rng, ["", "?", "?", "!", ":"], 1)[0]
        line = f"{mark}v{k} = {grown_expression(rng, names, 4)};"
        names.append(f"v{k}")
        kind = rng.random()
        if kind < 0.15:
            line = f"if ({grown_expression(rng, names[:-1], 2)}) {{ {line} }}"
            line += f" else {{ v{k} = {grown_expression(rng, names[:-1], 2)}; }}"
        elif kind < 0.25:
            condition = grown_expression(rng, names[:-1], 2)
            line = f"#pragma unroll 3\nloop {{ {line} if ({condition}) break; }}"
        lines.append(line)
    return "\n".join(lines)


def deep_nesting(rng: Generator) -> str:
    opening, closing = [("(", ")"), ("-", ""), ("~", ""), ("sin(", ")"), ("m(1,", ")"), ("*", "")][
        int(rng.integers(0, 6))
    ]
    depth = int(rng.integers(1, 400)) if rng.random() < 0.9 else 50_000
    whole = rng.random() < 0.7
    return f"m = {{ _P(1) + _P(2) }} ?x = {opening * depth}0.5{closing * depth if whole else ''};"


def huge_text(rng: Generator) -> str:
    count = int(10 ** rng.uniform(2, 5))
    pieces = [
        "1 + ",
        "x*",
        "x = x*x;",
        "x = exp(x);",
        "f = { 1 }",
        "?x = e1;",
        ";",
        "/**/",
        "a",
        "9",
        "x = x*(1 + e1)*(2 + e2)*(3 + e3);",
        "x = 1/x;",
        "//#pragma return x\n",
        "y, ",
        "\n",
    ]
    piece = chosen(rng, pieces, 1)[0]
    return "x = 0.3 + e2^e1;" + chosen(rng, ["?z = ", "", "f("], 1)[0] + piece * count + "1;?x;"


MAKERS: dict[str, tuple[float, Callable[[Generator], str]]] = {
    "bytes": (0.15, random_bytes),
    "tokens": (0.2, token_soup),
    "examples": (0.3, changed_example),
    "grammar": (0.3, grown_script),
    "nesting": (0.048, deep_nesting),
    "huge": (0.002, huge_text),
}


def variables_of(script: Script, rng: Generator) -> dict[str, Any]:
    kind = rng.random()
    names = free_variables(script, algebra_of(script))
    if kind < 0.02:
        import casadi as ca

        return {name: ca.SX.sym("s") for name in names}
    if kind < 0.1:
        return {name: rng.normal(size=3) for name in names}
    scale = [1.0, 1e-9, 1e9, 1e200, 0.0][int(rng.integers(0, 5))]
    return {name: float(rng.normal()) * scale for name in names}


def check_error(error: ScriptError, text: str, folder: Path) -> None:
    if error.file != "<script>":
        text = FILES[str(Path(error.file).relative_to(folder))]
    lines = text.split("\n")
    if not 1 <= error.line <= len(lines):
        raise AssertionError(f"line {error.line} of {len(lines)}")
    if not 1 <= error.column <= len(lines[error.line - 1]) + 1:
        raise AssertionError(f"column {error.column} of {len(lines[error.line - 1])}")
    if "^" not in str(error):
        raise AssertionError("no caret")


def prepare(folder: Path) -> Feed:
    """Scripts, parsed and evaluated."""
    for file, content in FILES.items():
        (folder / file).write_text(content)
    names = list(MAKERS)
    shares = [MAKERS[name][0] for name in names]

    def feed(rng: Generator) -> str:
        text = MAKERS[str(rng.choice(names, p=shares))][1](rng)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ScriptWarning)
                script = parse(text, folder=folder)
                made = evaluate(script, **variables_of(script, rng))
        except ScriptError as error:
            check_error(error, text, folder)
            return "refused"
        for x in made.values():
            if not all(bool(np.isfinite(v).all()) for v in x.values if is_numeric(v)):
                raise AssertionError(f"got {x}")
        return "valid"

    return feed
