"""Gaalop's scripts and macros, where they lie beside the recordings: all agree."""

from pathlib import Path

import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga.script.algebras import definitions
from tests.ga.gaalop.__main__ import MISSING, differences, usual_data
from tests.ga.gaalop.macros import algebras, disagreements, theirs
from tests.ga.gaalop.scripts import difference, directly, read_cases


@pytest.fixture(scope="module")
def gaalop() -> Path:
    """The folder with Gaalop's scripts in it."""
    if not (usual_data() / "gaalop").is_dir():
        pytest.skip("Gaalop's scripts are not here: set MOTORCADE_DATA to their folder")
    return usual_data()


def test_scripts_evaluate_to_what_gaalop_computes(gaalop: Path) -> None:
    cases = [case for case in read_cases(gaalop) if case.expected is not None]
    assert len(cases) > 100
    told = {case.name: difference(case, directly(case)) for case in cases}
    assert {name: why for name, why in told.items() if why} == {}


def test_a_wrong_coefficient_is_told(gaalop: Path) -> None:
    case = next(c for c in read_cases(gaalop) if c.name == "prod_geo11")
    made = directly(case)
    assert isinstance(made, dict)
    made["r"]["e1^e2"] *= 1 + 1e-8
    assert difference(case, made).startswith("r: e1^e2 is")
    assert difference(case, {}) == "no output r"


def test_macros_are_gaalops(gaalop: Path) -> None:
    """Every macro of every algebra, against Gaalop's definition of it on random arguments."""
    found = {name: disagreements(gaalop, name, rounds=1) for name in algebras(gaalop)}
    assert {name: wrong for name, (_, wrong) in found.items() if wrong} == {}
    assert sum(count for count, _ in found.values()) >= 183
    for name in algebras(gaalop):
        missing = {
            key
            for key in theirs(gaalop, name)
            if key not in definitions()[name].macros and key[0] not in ("Dual", "reverse")
        }
        assert missing == set()


@pytest.mark.slow
def test_scripts_compute_in_every_target_what_gaalop_computes(gaalop: Path) -> None:
    cases = [case for case in read_cases(gaalop) if case.expected is not None]
    for target, told in differences(cases):
        missing = {why for why in told.values() if why.startswith(MISSING)}
        if not missing:
            assert told == {}, target
