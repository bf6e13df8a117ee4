"""Work ahead in a thread: in order, what is raised at its own turn, nothing begun after the end."""

import threading
from collections.abc import Iterator

import pytest

from motorcade.ga.lookahead import ITEMS, ahead


@pytest.mark.parametrize("count", [0, 1, ITEMS, ITEMS + 1, 40])
def test_results_come_in_order_from_one_other_thread(count: int) -> None:
    where = set()

    def squared(number: int) -> int:
        where.add(threading.get_ident())
        return number * number

    assert list(ahead(squared, range(count))) == [k * k for k in range(count)]
    assert len(where) == min(count, 1)
    assert threading.get_ident() not in where


def test_what_the_work_raises_comes_at_its_turn() -> None:
    results = ahead(lambda number: 1 / (3 - number), range(10))
    assert [next(results) for _ in range(3)] == [1 / 3, 1 / 2, 1.0]
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_items_are_taken_only_a_few_ahead_and_none_after_the_reader_has_left() -> None:
    taken: list[int] = []

    def items() -> Iterator[int]:
        for k in range(1000):
            taken.append(k)
            yield k

    results = ahead(str, items())
    assert next(results) == "0"
    assert len(taken) == ITEMS + 1
    results.close()  # type: ignore[attr-defined]
    assert len(taken) == ITEMS + 1
