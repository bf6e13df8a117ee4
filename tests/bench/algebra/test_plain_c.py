"""The bench of plain C: its program compiles and measures, and ratios are to the least of ours."""

from __future__ import annotations

import shutil

import pytest

from tests.bench.algebra.plain_c.__main__ import SCRIPTS, kernels_of, measured, table


def test_ours_is_the_lesser_of_its_two_measures_and_peers_stand_behind_it() -> None:
    figures = [("plane", "ours", 2.0), ("plane", "klein", 4.0), ("plane", "ours, again", 1.0)]
    (line,) = table(figures)
    assert line.split() == ["plane", "1.00", "klein", "4.00", "(0.25)"]


def test_every_row_has_a_function_and_a_pass_can_be_left_out() -> None:
    text = kernels_of("float32", [])
    assert [name for name in SCRIPTS if text.count(f"void {name}(") != 2] == []
    assert kernels_of("float32", ["rows"]) != text


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler here")
def test_it_measures_both_precisions_without_peers() -> None:
    for precision in ("float32", "float64"):
        figures = measured(precision, None, [])
        assert {who for _, who, _ in figures} >= {"ours", "ours, again"}
        assert all(0.0 < ns < 1e4 for _, _, ns in figures)
