"""The benchmark of programs measures one formula in every way, once all ways agree."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga import CGA3
from tests.bench.algebra import programs


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(programs, "ROWS", 50)
        patched.setattr(programs, "JOINTS", 50)
        patched.setattr(programs, "SECONDS", 1e-4)
        return programs.bench_programs(1e-4)


@pytest.mark.slow
def test_both_formulas_are_measured_at_both_sizes(found: dict[str, Any]) -> None:
    for name in ("motor on a point", "even versor on a point"):
        one, many = found[name]["one"], found[name]["many"]
        assert list(one) == list(many)
        assert {"arrays, NumPy", "plain multivectors"} <= set(one)
        assert all(spent > 0 for spent in (*one.values(), *many.values()))
    assert set(found["joint"]) == {"float32", "float64"}


@pytest.mark.slow
def test_the_table_names_every_way_and_what_was_left_out(found: dict[str, Any]) -> None:
    table = programs.programs_table(found | {"left_out": ["kingdon: not installed"]})
    for way in found["motor on a point"]["one"]:
        assert way in table
    assert table.endswith("left out: kingdon: not installed")


def test_ways_that_disagree_are_refused() -> None:
    function = programs._compiled(programs.MOTOR)
    elements = programs._elements(np.random.default_rng(1), 3, 8)
    calls = programs._ways(function, programs.MOTOR, elements, [])
    x = CGA3.multivector(dict(zip(programs.MOTOR.split(), list(elements.T.copy()), strict=True)))
    p = CGA3.multivector(dict(zip(programs.POINT.split(), [1.0, 2.0, 3.0, 1.0, 7.0], strict=True)))
    calls["a wrong one"] = lambda: (
        2 * function.arrays(elements, np.array([1.0, 2.0, 3.0, 1.0, 7.0]))
    )
    with pytest.raises(RuntimeError, match="a wrong one: expected what plain multivectors give"):
        programs._check(calls, function, elements, x, p)
