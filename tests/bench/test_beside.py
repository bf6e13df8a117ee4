"""Runs beside each other: what differs is named, what is equal is not."""

from tests.bench.beside import differ, figures, table


def test_figures_are_found_at_any_depth_but_for_the_machine() -> None:
    tree = {"machine": {"cores": 2}, "suite": {"rows": [{"ms": 1.5, "by": "us"}, {"ms": 2}]}}
    assert dict(figures(tree)) == {"/suite/rows[0]/ms": 1.5, "/suite/rows[1]/ms": 2.0}


def test_only_what_differs_is_printed() -> None:
    before, after = {"a": 1.0, "b": 1.0, "old": 1.0}, {"a": 1.005, "b": 1.1, "new": 1.0}
    lines = list(table(before, after, share=0.01))
    assert [line.split()[-1] for line in lines] == ["b", "before", "after"]


def test_nan_equals_nan_only() -> None:
    nan = float("nan")
    assert not differ(nan, nan, 0.01)
    assert differ(nan, 1.0, 0.01)
