"""What the suites of conversions and of the compiler print holds every figure they measured."""

from typing import Any

import numpy as np
import pytest

from tests.bench.algebra import compiler, conversions


def test_the_table_holds_every_figure_and_dashes_for_what_scipy_lacks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(conversions, "COUNT", 40)
    done: list[Any] = []

    def counted(call: Any) -> float:
        done.append(call())
        return 1e-6 * len(done)

    monkeypatch.setattr(conversions, "_seconds", counted)
    found = conversions.bench_conversions()
    table = conversions.conversions_table(found)
    assert all(result is not None for result in done)
    assert len(done) == 14 + 2 * (24 + 8) + 6
    for group in found.values():
        for name, row in group.items():
            line = next(line for line in table.splitlines() if line.startswith(f"{name} "))
            for value in row.values():
                assert f"{value:.2f}" in line
    assert "–" in next(line for line in table.splitlines() if line.startswith("Motor.as_twist"))


def test_a_script_is_compiled_in_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is missing")
    monkeypatch.setattr(compiler, "PROCESSES", 1)
    row = compiler._compiled("sum", "?y = a*b + a*c;")
    assert (row["mul"], row["add"], row["div"]) == (1, 1, 0)
    assert np.isfinite(row["ms"])
    assert compiler.compiler_table([row]).splitlines()[1].split()[:4] == ["sum", "1", "1", "0"]
