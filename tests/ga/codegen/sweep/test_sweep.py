"""A small part of the sweep over code of every target, and that it finds what is broken."""

from pathlib import Path

import pytest

pytest.importorskip("casadi", reason="CasADi, which only code generation needs, is missing")

from motorcade.ga.codegen.precision import DOUBLE, SINGLE
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import TARGETS, c_batch, check_text
from motorcade.ga.codegen.targets.names import RefusedName
from motorcade.ga.script import parse
from tests.ga.codegen.sweep.__main__ import Swept, sweep
from tests.ga.codegen.sweep.runners import WAYS
from tests.ga.gaalop.__main__ import MISSING

QUICK = ("numpy", "casadi", "wgsl", "julia", "latex")


def test_what_needs_no_tool_computes_what_evaluation_does() -> None:
    swept = Swept()
    sweep(range(3), 5, list(QUICK), swept)
    assert swept.faults == []
    assert swept.agree.total() >= 10


@pytest.mark.slow
@pytest.mark.parametrize("way", list(WAYS))
def test_every_target_computes_what_evaluation_does(way: str) -> None:
    swept = Swept()
    sweep(range(40), 6, [way], swept)
    assert [fault for fault in swept.faults if not any(tool in fault for tool in MISSING)] == []


@pytest.mark.parametrize("name", ["motorcade_sin", "motorcade_atan2f", "MOTORCADE_SIN"])
def test_loops_refuse_the_names_of_functions_that_they_carry(name: str, tmp_path: Path) -> None:
    program = compile_script(parse(f"?r = sin({name} + x) + atan2({name}, x);"), "scene")
    with pytest.raises(RefusedName, match=f"variable {name} is reserved in C"):
        c_batch.write(program, SINGLE)


SCRIPT = "?r = x*e1 + sin(x*y)*e2 + min(x, y)*e1^e2 + step(x)*sqrt(y)*e3;\n?s = x - y;"


@pytest.mark.parametrize("target", sorted(set(TARGETS) - {"numpy", "torch", "casadi"}))
def test_a_broken_text_is_told_from_a_whole_one(target: str) -> None:
    """Without an operator, with one twice, with a bracket more or less, cut off."""
    write = TARGETS[target]
    whole = write(compile_script(parse(SCRIPT), "scene"), None if target != "c" else DOUBLE)
    name, text = next(iter(whole.items()))
    check_text(target, name, text)
    if target == "latex":
        broken = [text.replace("{", "", 1), text.replace(r"\end", "%"), text + "}"]
    else:
        broken = [
            text.replace("sin(x * y)", wrong)
            for wrong in ("sin(x y)", "sin(x * / y)", "sin x * y)", "sin(x * y))", "sin(x *)")
        ]
        broken += [] if target == "julia" else [text.rstrip().removesuffix("}")]
    for wrong in broken:
        assert wrong != text
        with pytest.raises(RuntimeError, match=f"target {target}: wrote a file {name} that does"):
            check_text(target, name, wrong)
