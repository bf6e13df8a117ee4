"""Mutants are small faults, the same for a seed, and are run without writing them."""

import importlib
import os
import sys
import time
from pathlib import Path

import pytest

from tests.mutation.mutants import mutants, sample
from tests.mutation.running import forked, install, module_name

REPOSITORY = Path(__file__).parents[2]
SOURCE = '''"""Doc."""
from __future__ import annotations

def f(x: int | None, y=1.5):
    """Doc of 3."""
    if x is None or not x < 2:
        raise ValueError(f"f(x): {x + 1}, not above {3}")
    assert y > 0
    return [-k @ y for k in x if k]
'''


def changes(source: str) -> set[tuple[str, str]]:
    return {(mutant.before, mutant.after) for mutant in mutants(source)}


def test_every_change_is_one_that_a_fault_may_be() -> None:
    raised = 'raise ValueError(f"f(x): {x + 1}, not above {3}")'
    assert changes(SOURCE) == {
        ("1.5", "2.5"),
        ("x is None or not x < 2", "(x is None and (not x < 2))"),
        ("x is None or not x < 2", "(not (x is None or not x < 2))"),
        ("x is None", "(x is not None)"),
        ("not x < 2", "(x < 2)"),
        ("x < 2", "(x <= 2)"),
        ("2", "3"),
        (raised, "pass"),
        ("return [-k @ y for k in x if k]", "return None"),
        ("-k @ y", "(y @ -k)"),
        ("-k", "(k)"),
        ("k", "(not k)"),
    }


def test_a_mutant_changes_its_own_place_and_nothing_else() -> None:
    source = "def f(a, b):\n    return ('é', a - b, a - b)\n"
    made = {mutant.applied(source).splitlines()[1].strip() for mutant in mutants(source)}
    assert made == {
        "return None",
        "return ('é', (a + b), a - b)",
        "return ('é', a - b, (a + b))",
    }


def test_samples_of_one_seed_are_the_same_and_in_order() -> None:
    found = mutants(SOURCE)
    assert sample(found, 5, "a") == sample(found, 5, "a") != sample(found, 5, "b")
    assert sample(found, 5, "a") == sorted(sample(found, 5, "a"), key=found.index)
    assert sample(found, 100, "a") == found


@pytest.mark.skipif(not (REPOSITORY / "ga").is_dir(), reason="no source tree: a wheel is tested")
def test_a_mutated_module_is_imported_and_its_file_left_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(REPOSITORY)
    file = Path("ga/codegen/passes/optimize.py")
    before = file.read_bytes()

    def work() -> str:
        sys.modules.pop(module_name(file), None)
        install(file, "without_zeros = 'mutated'\n")
        return str(importlib.import_module(module_name(file)).without_zeros)

    assert forked(work, 60.0) == "mutated"
    assert file.read_bytes() == before


def test_what_takes_too_long_is_ended() -> None:
    with pytest.raises(TimeoutError, match=r"nothing came in 1 s"):
        forked(lambda: time.sleep(60), 0.1)


def test_what_computes_too_long_is_ended() -> None:
    def endless() -> None:
        while True:
            pass

    with pytest.raises(ChildProcessError, match="died"):
        forked(endless, 1.0)


def test_a_child_that_dies_is_told_of() -> None:
    with pytest.raises(ChildProcessError, match="died"):
        forked(lambda: os._exit(3), 60.0)
    with pytest.raises(ChildProcessError, match="ZeroDivisionError: division by zero"):
        forked(lambda: 1 / 0, 60.0)
