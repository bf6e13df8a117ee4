"""What docs/cluscript.md says is so: functions, macros, algebras, limits, and its examples."""

import re
from pathlib import Path

import pytest

from motorcade.ga.script import ScriptError, evaluate, parse
from motorcade.ga.script.algebras import definitions
from motorcade.ga.script.expressions import MAX_ARGUMENTS, MAX_NESTING, MAX_OPERATIONS
from motorcade.ga.script.functions import FUNCTIONS
from motorcade.ga.script.run import MAX_MACRO_DEPTH, MAX_STEPS, MAX_TERMS
from motorcade.ga.script.syntax import MAX_SCRIPT_CHARACTERS, MAX_TOKENS

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "cluscript.md").read_text()


def section(title: str) -> str:
    return PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]


def test_every_function_macro_and_algebra_is_on_the_page() -> None:
    text = section("Functions")
    assert [name for name in FUNCTIONS if not re.search(rf"`[^`]*\b{name}\b", text)] == []
    for name, definition in definitions().items():
        assert f"`{name}`" in section("Algebras")
        macros = {macro for macro, _ in definition.macros if macro[0] != "_"}
        assert [macro for macro in macros if not re.search(rf"\b{macro}\b", PAGE)] == []


def test_the_limits_are_those_of_the_page() -> None:
    limits = [
        MAX_SCRIPT_CHARACTERS,
        MAX_TOKENS,
        MAX_OPERATIONS,
        MAX_NESTING,
        MAX_ARGUMENTS,
        MAX_MACRO_DEPTH,
        MAX_STEPS,
        MAX_TERMS,
    ]
    rows = [row.split("|")[2] for row in section("Errors").split("\n") if row.startswith("| ")]
    written = [int(n.replace(",", "")) for row in rows for n in re.findall(r"[\d,]*\d", row)]
    assert written == limits


def test_every_script_is_on_the_page() -> None:
    for path in DOCS.glob("scripts/*.clu"):
        assert f"(scripts/{path.name})" in PAGE


def test_the_examples_of_the_page_compute() -> None:
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert code is not None
    names: dict[str, object] = {}
    exec(code[1], names)
    last = code[1].strip().split("\n")[-1].partition("#")
    assert eval(last[0], names) == pytest.approx(float(last[2]))
    macro = section("Macros").split("```")[1]
    made = evaluate(parse(macro), a=1.0, b=4.0)
    assert made["m"].scalar_part() == 2.5


def test_the_error_of_the_page_comes_out() -> None:
    shown = section("Errors").split("```")[1].strip()
    with pytest.raises(ScriptError) as caught:
        evaluate(parse("a = 1; l = 2;\nelbow = l*sinn(a);", "arm.clu"))
    assert str(caught.value) == shown
