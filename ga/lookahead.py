"""Work on the items of a sequence in another thread, a few of them before they are asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# Enough to bridge a slow item; each waiting one holds an image in memory.
ITEMS = 4


def ahead(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """`work` of every item, in order, up to `ITEMS` of them before they are asked for.

    Decoding, straightening and encoding leave Python's lock while they compute, so they can go on
    while another thread draws. The items are taken in the reader's thread, the work is done in one
    other thread, an item after another. What either raises reaches the reader at that item's turn;
    a reader that leaves waits for the work under way.
    """
    with ThreadPoolExecutor(1) as worker:
        waiting: deque[Future[Result]] = deque()
        try:
            for item in items:
                waiting.append(worker.submit(copy_context().run, work, item))
                if len(waiting) > ITEMS:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()
