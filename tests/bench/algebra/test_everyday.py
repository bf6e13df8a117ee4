"""The twelve everyday tasks: what all libraries give agrees, and the page has a row for each."""

from __future__ import annotations

from tests.bench.algebra.everyday import OWN, TASKS, measure, page


def test_all_libraries_agree_on_twelve_tasks_and_ours_has_a_call_for_each() -> None:
    rows, left_out = measure(1, 1)
    assert len(rows) == len(TASKS) == 12
    assert all(OWN in row.us for row in rows)
    assert [row.what for row in rows if max(row.apart.values()) > 1e-9] == []
    text = page(rows, left_out)
    assert [task.what for task in TASKS if text.count(task.what) != 2] == []
