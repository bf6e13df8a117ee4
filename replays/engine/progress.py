"""Progress of what takes more than a second: bars on a terminal, and a line a stage everywhere.

Loops show a bar with their rate and the time that remains; what is one long step shows for how long
it has been running. Bars are for a terminal, and for one process at a time: those of several would
write over each other. Loops that take minutes say the same in lines where there is no terminal.
Lines stay, and go above the bars.
"""

from __future__ import annotations

import logging
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

Item = TypeVar("Item")

DELAY_S = 1.0
_TICK_S = 0.5
LINE_EVERY_S = 10.0
_asked_for = True


def show_progress(shown: bool) -> None:
    """Whether this process shows progress from here on, where there is any to show."""
    global _asked_for
    _asked_for = shown


def track(items: Iterable[Item], what: str, total: int) -> Iterator[Item]:
    """Yield `items`, showing how far along the loop is."""
    if not _shown():
        yield from items
        return
    from tqdm import tqdm

    yield from tqdm(items, desc=what, total=total, leave=False, delay=DELAY_S)


def track_jobs(items: Iterable[Item], what: str, total: int) -> Iterator[Item]:
    """As `track`; where there is no terminal, a line on standard error every ten seconds.

    A line tells how many are done, and the time that remains at the rate so far.
    """
    if not _asked_for or _shown() or multiprocessing.parent_process() is not None:
        yield from track(items, what, total)
        return
    start = last = time.monotonic()
    for done, item in enumerate(items, 1):
        now = time.monotonic()
        if now - last >= LINE_EVERY_S and done < total:
            last, left_s = now, (now - start) / done * (total - done)
            share = f"{done} of {total} {what}, {100 * done // total} %"
            print(f"{share}, {_clock(left_s)} left", file=sys.stderr, flush=True)
        yield item


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return (
        f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"
        if minutes >= 60
        else f"{minutes}:{rest:02d}"
    )


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
    if _asked_for and stages.getEffectiveLevel() > logging.INFO:
        stages.setLevel(logging.INFO)
    if recording:
        stages.addFilter(named)
    try:
        yield stages
    finally:
        stages.setLevel(before)
        stages.removeFilter(named)


def _shown() -> bool:
    return _asked_for and sys.stderr.isatty() and multiprocessing.parent_process() is None
