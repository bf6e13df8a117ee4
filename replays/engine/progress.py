"""Progress of what takes more than a second: bars on a terminal, and a line a stage everywhere.

Loops show a bar with their rate and the time that remains; what is one long step shows for how long
it has been running. Bars are for a terminal, and for one process at a time: those of several would
write over each other. Lines stay, and go above the bars.
"""

from __future__ import annotations

import logging
import multiprocessing
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

Item = TypeVar("Item")

DELAY_S = 1.0
_TICK_S = 0.5


def track(items: Iterable[Item], what: str, total: int) -> Iterator[Item]:
    """Yield `items`, showing how far along the loop is."""
    if not _shown():
        yield from items
        return
    from tqdm import tqdm

    yield from tqdm(items, desc=what, total=total, leave=False, delay=DELAY_S)


@contextmanager
def reading(what: str, size: int) -> Iterator[Callable[[int], None]]:
    """Within the block, show how much of `size` bytes is read; what it gives takes the place."""
    if not _shown():
        yield lambda place: None
        return
    from tqdm import tqdm

    with tqdm(desc=what, total=size, unit="B", unit_scale=True, leave=False, delay=DELAY_S) as bar:

        def advance(place: int) -> None:
            bar.update(place - bar.n)

        yield advance


@contextmanager
def working(what: str) -> Iterator[None]:
    """Within the block, show for how long it has been running."""
    if not _shown():
        yield
        return
    from tqdm import tqdm

    over = threading.Event()
    bar = tqdm(desc=what, bar_format="{desc}: {elapsed}", leave=False, delay=DELAY_S)

    def tick() -> None:
        while not over.wait(_TICK_S):
            bar.update()

    ticker = threading.Thread(target=tick, daemon=True)
    ticker.start()
    try:
        yield
    finally:
        over.set()
        ticker.join()
        bar.close()


@contextmanager
def log_stages(recording: str = "") -> Iterator[logging.Logger]:
    """Within the block, every stage of a graph tells when it ended, in a line on standard error.

    Lines begin with the name of the `recording`, if one is given; what is logged by the logger
    that this yields stands among them.
    """
    logging.basicConfig(format="%(message)s")  # a worker's process has nothing yet that writes
    stages = logging.getLogger("motorcade.graph")

    def named(record: logging.LogRecord) -> bool:
        record.msg, record.args = f"{recording}: {record.getMessage()}", ()
        return True

    before = stages.level
    if stages.getEffectiveLevel() > logging.INFO:
        stages.setLevel(logging.INFO)
    if recording:
        stages.addFilter(named)
    try:
        yield stages
    finally:
        stages.setLevel(before)
        stages.removeFilter(named)


def _shown() -> bool:
    return sys.stderr.isatty() and multiprocessing.parent_process() is None
