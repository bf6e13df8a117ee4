"""Random scripts compute what the library clifford and a second reading of them compute."""

import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")
pytest.importorskip("clifford", reason="the witness clifford is not installed")

from motorcade.ga.codegen import programs
from motorcade.ga.codegen.tape import run_tape
from tests.ga.gaalop.__main__ import MISSING, differences
from tests.ga.gaalop.scripts import difference, directly
from tests.ga.gaalop.targets import named
from tests.ga.programs.__main__ import TOO_LARGE
from tests.ga.programs.grammar import VOLUMES, grammar_cases
from tests.ga.programs.random_scripts import ALGEBRAS, random_cases


@pytest.mark.quick_every(2)
@pytest.mark.parametrize("name", ["3dpga", "cga"])
def test_random_scripts_evaluate_to_what_clifford_computes(name: str) -> None:
    cases = random_cases(name, 6, 2)
    assert {case.text: difference(case, directly(case)) for case in cases} == dict.fromkeys(
        (case.text for case in cases), ""
    )


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("name", list(VOLUMES))
def test_scripts_of_the_whole_language_evaluate_to_what_a_second_reading_computes(
    name: str,
) -> None:
    cases = grammar_cases(name, 25, 2)
    assert {case.text: difference(case, directly(case)) for case in cases} == dict.fromkeys(
        (case.text for case in cases), ""
    )


@pytest.mark.parametrize("name", list(VOLUMES))
def test_scripts_that_are_recorded_without_casadi_compute_the_same(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "find_spec", lambda module: None)
    for case in grammar_cases(name, 8, 4):
        program = programs.compile_script(case.script, "made", case.algebra)
        rows = run_tape(program.tape, {(key, 0): value for key, value in case.given.items()})
        outputs = [operand.name for operand in program.tape.outputs]
        made = named(program, dict(zip(outputs, rows, strict=True)))
        assert difference(case, made) == "", case.text


@pytest.mark.slow
def test_scripts_of_the_whole_language_compute_the_same_in_every_target() -> None:
    cases = [case for name in VOLUMES for case in grammar_cases(name, 10, 3)]
    for target, told in differences(cases):
        told = {name: why for name, why in told.items() if not why.startswith(TOO_LARGE)}
        if not any(why.startswith(MISSING) for why in told.values()):
            assert told == {}, target


@pytest.mark.slow
def test_random_scripts_compute_the_same_in_every_target() -> None:
    cases = [case for name in ALGEBRAS for case in random_cases(name, 20, 3)]
    for target, told in differences(cases):
        if not any(why.startswith(MISSING) for why in told.values()):
            assert told == {}, target
