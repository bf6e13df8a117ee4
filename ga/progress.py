"""Progress of what takes more than a second: bars on a terminal, lines where there is none.

On a terminal loops show a bar with their rate and the time that remains; what is one long step
shows for how long it has been running. Elsewhere, as through a pipe, a line says the same whenever
four seconds have passed without one, so that nobody waits without a word. Bars and lines come from
one process at a time: those of several would write over each other.
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
LINE_EVERY_S = 4.0
_TICK_S = 0.5
log = logging.getLogger("motorcade.progress")
"""Disabled where none is asked for, so that a command can say so without importing this."""


class _Lines:
    """Lines on standard error, no more than one in `LINE_EVERY_S`, whoever writes them."""

    def __init__(self) -> None:
        self.steps: list[str] = []  # that run now, the innermost last: it alone says so
        self._last_s = time.monotonic()
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Something else was just said, or something begins: the wait starts anew."""
        self._last_s = time.monotonic()

    def say(self, text: str, patience: float = 1.0) -> None:
        """Write a line if the last was so many times `LINE_EVERY_S` ago."""
        with self._lock:
            now = time.monotonic()
            if now - self._last_s < patience * LINE_EVERY_S:
                return
            self._last_s = now
        print(text, file=sys.stderr, flush=True)


_lines = _Lines()


def show_progress(shown: bool) -> None:
    """Whether this process shows progress from here on, where there is any to show."""
    log.disabled = not shown


def track(items: Iterable[Item], what: str, total: int) -> Iterator[Item]:
    """Yield `items`, showing how far along the loop is, and the time that remains at its rate."""
    if not _heard():
        yield from items
    elif _shown():
        from tqdm import tqdm

        yield from tqdm(items, desc=what, total=total, leave=False, delay=DELAY_S)
    else:
        start = time.monotonic()
        if not _lines.steps:
            _lines.begin()
        for done, item in enumerate(items, 1):
            if done < total:
                _lines.say(_share(what, done, total, time.monotonic() - start))
            yield item


def _share(what: str, done: int, total: int, passed_s: float) -> str:
    left = _clock(passed_s / done * (total - done))
    return f"{what}: {done} of {total}, {100 * done // total} %, {left} left"


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
    if not _heard():
        yield
        return
    over, start = threading.Event(), time.monotonic()
    bar = None
    if _shown():
        from tqdm import tqdm

        bar = tqdm(desc=what, bar_format="{desc}: {elapsed}", leave=False, delay=DELAY_S)
    elif not _lines.steps:
        _lines.begin()
    _lines.steps.append(what)

    def tick() -> None:
        while not over.wait(_TICK_S):
            if bar is not None:
                bar.update()
            elif _lines.steps[-1] == what:  # a loop inside tells more: it goes first
                _lines.say(f"{what}: {time.monotonic() - start:.0f} s so far", 1.2)

    ticker = threading.Thread(target=tick, daemon=True)
    ticker.start()
    try:
        yield
    finally:
        over.set()
        ticker.join()
        _lines.steps.remove(what)
        if bar is not None:
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
    if not log.disabled and stages.getEffectiveLevel() > logging.INFO:
        stages.setLevel(logging.INFO)
    if recording:
        stages.addFilter(named)
    try:
        yield stages
    finally:
        stages.setLevel(before)
        stages.removeFilter(named)


def _heard() -> bool:
    """Whether this process says how far it is, in bars or in lines."""
    return not log.disabled and multiprocessing.parent_process() is None


def _shown() -> bool:
    """Whether it does so in bars."""
    return _heard() and sys.stderr.isatty()
