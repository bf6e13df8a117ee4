"""Feeds numbered inputs to what reads them, each within bounds of time and memory.

The inputs of a kind are fed by a process of its own, so that one that crashes it, or hangs where
Python cannot interrupt, is a fault like any other: a new process goes on behind it. An input is
made by the seed and its number alone, whatever was fed before.
"""

from __future__ import annotations

import faulthandler
import importlib
import logging
import multiprocessing
import os
import resource
import signal
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

__all__ = ["KINDS", "Feed", "OverLimit", "Result", "SkippedError", "feed_of", "fresh", "run"]

KINDS = (
    "scripts",
    "rigs",
    "looks",
    "packed",
    "recordings",
    "manifests",
    "containers",
    "trajectories",
    "scenes",
    "casts",
    "settings",
    "archives",
    "commands",
    "kernels",
    "generated",
)
"""What is fed: modules of `tests.fuzz.kinds`, each with a `prepare(folder)` that gives a `Feed`."""

Feed = Callable[[np.random.Generator], str]
"""Makes an input, feeds it, and says how it ended; any exception that comes out is a fault."""

PROCESSOR_S = 10.0
WALL_S = 60
"""Without what it waited for a processor that others had: the machine may be busy."""
PATIENCE_S = 60
"""How long beyond that an input may hold out against being interrupted."""
ADDRESSES_BYTES = 6 << 30
GROWTH_BYTES = 1 << 30
FILE_BYTES = 1 << 30
REPOSITORY = Path(__file__).parents[2]
_over_at_s = 0.0


class OverLimit(BaseException):
    """An input took too long; no handler of errors may take it for one of a reader's."""


class SkippedError(Exception):
    """The machine lacks what a kind needs."""


@dataclass
class Result:
    """What came of a kind's inputs.

    Fields:
        kind, seed: which.
        inputs: how many were fed.
        ended: how many ended in each way, faults among them.
        faults: place and message of each, without repeats of one place beyond the third.
        slowest: processor time of the slowest input, and its number.
        peak_bytes: most memory held.
        seconds: in all.
    """

    kind: str
    seed: int
    inputs: int = 0
    ended: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    slowest: tuple[float, int] = (0.0, 0)
    peak_bytes: int = 0
    seconds: float = 0.0
    places: Counter[str] = field(default_factory=Counter)

    def add(self, number: int, ended: str, message: str, processor_s: float) -> None:
        """Count an input."""
        self.inputs += 1
        self.ended[ended] += 1
        self.slowest = max(self.slowest, (processor_s, number))
        if ended == "FAULT":
            place = message.partition(": ")[0]
            self.places[place] += 1
            if self.places[place] <= 3:
                self.faults.append(f"{self.kind} --seed {self.seed} --only {number}: {message}")


def fresh(seed: int, number: int) -> np.random.Generator:
    """The random numbers that make an input."""
    return np.random.default_rng([seed, number])


def feed_of(kind: str, folder: Path) -> Feed:
    """What a kind's inputs are fed to, with its samples made in a folder."""
    feed: Feed = importlib.import_module(f"tests.fuzz.kinds.{kind}").prepare(folder)
    return feed


def run(kind: str, seed: int, inputs: int, seconds: float, tell: Callable[[str], None]) -> Result:
    """Feed inputs 0 to `inputs`, or as many as the time allows.

    Raises:
        SkippedError: the machine lacks what the kind needs.
    """
    result, begun = Result(kind, seed), time.monotonic()
    context = multiprocessing.get_context("fork")
    at = context.Value("q", 0, lock=False)
    while at.value < inputs and time.monotonic() - begun < seconds:
        first, (ours, theirs) = at.value, context.Pipe(duplex=False)
        with tempfile.TemporaryFile("w+") as errors:
            told = len(result.faults)
            until = begun + seconds
            worker = context.Process(
                target=_work, args=(kind, seed, (first, inputs), until, at, theirs, errors.fileno())
            )
            worker.start()
            theirs.close()
            _listen(worker, ours, at, result)
            worker.join()
            for fault in result.faults[told:]:
                tell(fault)
            if worker.exitcode == 0:
                break
            errors.seek(0)
            why = f"process ended with {worker.exitcode}: {errors.read()[-1500:]}"
            if result.inputs == 0 and first == 0 and at.value == 0:
                raise RuntimeError(f"{kind}: {why}")
            result.add(at.value, "FAULT", why, 0.0)
            tell(result.faults[-1])
            at.value += 1
    result.seconds = time.monotonic() - begun
    return result


def _listen(worker: Any, pipe: Any, at: Any, result: Result) -> None:
    """Take what a worker reports until it ends; end it where it hangs."""
    last, since = -1, 0.0
    while True:
        if pipe.poll(0.5):
            try:
                report = pipe.recv()
            except EOFError:
                return
            if isinstance(report, str):
                raise SkippedError(report)
            (entries, result.peak_bytes) = report[0], max(result.peak_bytes, report[1])
            for entry in entries:
                result.add(*entry)
            continue
        if at.value != last:
            last, since = at.value, _own_time_s(worker.pid)
        elif _own_time_s(worker.pid) - since > WALL_S + PATIENCE_S:
            worker.kill()


def _work(
    kind: str,
    seed: int,
    numbers: tuple[int, int],
    until: float,
    at: Any,
    pipe: Any,
    errors: int,
) -> None:
    """Feed inputs and report them; runs in a process of its own."""
    os.dup2(errors, 2)
    faulthandler.enable(errors)
    logging.getLogger("motorcade").setLevel(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as name:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                feed = feed_of(kind, Path(name))
        except SkippedError as why:
            pipe.send(str(why))
            return
        _limit(os.sysconf("SC_PAGE_SIZE"))
        warnings.simplefilter("error")
        entries, reported = [], time.monotonic()
        for number in range(*numbers):
            at.value = number
            entries.append((number, *_one(feed, fresh(seed, number))))
            now = time.monotonic()
            if now - reported > 0.5 or entries[-1][1] == "FAULT":
                pipe.send((entries, _peak_bytes()))
                entries, reported = [], now
            if now > until:
                break
        pipe.send((entries, _peak_bytes()))


def _limit(page_bytes: int) -> None:
    held = int(Path("/proc/self/statm").read_text().split()[0]) * page_bytes
    most = held + ADDRESSES_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    for one in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(one, _over)


def _over(number: int, frame: FrameType | None) -> None:
    if number == signal.SIGPROF:
        raise OverLimit(f"took more than {PROCESSOR_S:g} s of a processor")
    left_s = _over_at_s - _own_time_s("self")
    if left_s <= 0.0:
        raise OverLimit(f"waited for more than {WALL_S} s")
    signal.alarm(ceil(left_s))


def _own_time_s(process: int | str | None) -> float:
    """The time, less what the main thread of a process waited for a processor."""
    try:
        waited_ns = int(Path(f"/proc/{process}/schedstat").read_text().split()[1])
    except (OSError, IndexError):  # gone, or a kernel that does not count
        waited_ns = 0
    return time.monotonic() - 1e-9 * waited_ns


def _one(feed: Feed, rng: np.random.Generator) -> tuple[str, str, float]:
    """How an input ended, what is wrong with that, and its processor time."""
    before, start = _peak_bytes(), time.process_time()
    try:
        with _in_time():
            ended, message = feed(rng), ""
    except KeyboardInterrupt:
        raise
    except BaseException as fault:  # whatever else comes out is what this looks for
        ended, message = "FAULT", f"{_place(fault)}: {type(fault).__name__}: {fault}"[:600]
    grown = _peak_bytes() - before
    if grown > GROWTH_BYTES:
        ended, message = "FAULT", f"memory: grew by {grown >> 20} MiB; {message}"
    return ended, message, time.process_time() - start


@contextmanager
def _in_time() -> Iterator[None]:
    global _over_at_s
    _over_at_s = _own_time_s("self") + WALL_S
    signal.setitimer(signal.ITIMER_PROF, PROCESSOR_S)
    signal.alarm(WALL_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.alarm(0)


def _place(fault: BaseException) -> str:
    """File and line of ours where it came from."""
    if isinstance(fault, AssertionError) and fault.__cause__ is not None:
        fault = fault.__cause__
    frames = traceback.extract_tb(fault.__traceback__)
    ours = [one for one in frames if Path(one.filename).is_relative_to(REPOSITORY)]
    product = [one for one in ours if not Path(one.filename).is_relative_to(REPOSITORY / "tests")]
    chosen = (product or ours or frames)[-1:]
    return " ".join(f"{Path(one.filename).name}:{one.lineno}" for one in chosen) or "?"


def _peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
