"""Recordings of 200 poses with long gaps, through every command and every function that takes them.

    python -m tests.end_to_end.gaps
    python -m tests.end_to_end.gaps --doors evaluate "smooth spline" --gaps "30 days"

Gaps of a second to thirty years stand in the middle of the poses, after every tenth of them, and
between all of them; one more path begins with a stamp of 0 before those of today. Each door (a
command line or a function) is given each path in a process of its own, after the imports, with at
most 300 MiB of memory besides (RLIMIT_AS) and two seconds of processor time (or half as much again
as it takes without a gap). It must give a
result or refuse it in one line (`ValueError`, `TrackingError`; commands: exit code 1 or 2). The
table shows seconds and MiB of the dearest path of each door and gap; the program ends with 1 where
any is too dear, or ends otherwise.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.end_to_end.gap_doors import DOORS, FRESH, Line
from tests.end_to_end.gap_paths import STEP_NS, Case, shapes

SECOND = 10**9
GAPS = {
    "1 s": SECOND,
    "1 min": 60 * SECOND,
    "1 h": 3600 * SECOND,
    "1 day": 86_400 * SECOND,
    "30 days": 30 * 86_400 * SECOND,
    "30 years": 30 * 365 * 86_400 * SECOND,
}
MOST_S, MOST_MIB = 2.0, 300.0
# Times what the same door takes without a gap, where that is more.
MOST_TIMES = 1.5
# Where a door hangs or waits, it is ended after so many seconds.
HANGS_S = 300


@dataclass(frozen=True)
class Outcome:
    """What one door did with one path: how it ended, at what price."""

    how: str
    seconds: float
    mib: float
    reason: str = ""

    def fault(self, usual: Outcome) -> bool:
        """Whether it ended otherwise than it may, or was too dear."""
        late = self.seconds > max(MOST_S, MOST_TIMES * usual.seconds)
        large = self.mib > usual.mib + MOST_MIB
        return self.how not in ("result", "refused") or late or large


def tried(door: str, case: Case) -> Outcome:
    """Run a door on a path in a process of its own, bounded in time and memory."""
    return _spawned(FRESH[door], case) if door in FRESH else _forked(DOORS[door], case)


def _spawned(lines: Iterable[Line], case: Case) -> Outcome:
    words = [[word if isinstance(word, str) else word(case) for word in line] for line in lines]
    child = subprocess.Popen(
        [sys.executable, "-c", _LINES.format(words)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stderr is not None
    last = child.stderr.read().strip().rpartition("\n")[2]
    _, status, used = os.wait4(child.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    how = "result" if code == 0 else "refused" if code in (1, 2) else f"ended by {code}"
    if "unexpected" in last or "allocate" in last:
        how = last
    return Outcome(
        how, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0, last if code else ""
    )


_LINES = """
import signal, sys
signal.alarm(600)
from motorcade.replays.cli.main import main
for words in {}:
    code = main(words)
    if code:
        sys.exit(code)
"""


def _forked(door: Callable[[Case], object], case: Case) -> Outcome:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            _in_the_child(door, case, writing)
        except BaseException:
            traceback.print_exc(file=sys.__stderr__)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as told:
        text = told.read()
    _, status, used = os.wait4(child, 0)
    seconds = used.ru_utime + used.ru_stime
    if not text:
        ended = os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
        return Outcome(f"ended by {ended}", seconds, float("nan"))
    mib, how, reason = text.split("\n", 2)
    return Outcome(how, seconds, float(mib), reason)


def _in_the_child(door: Callable[[Case], object], case: Case, told: int) -> None:
    sys.stdout = sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115
    signal.alarm(HANGS_S)
    held = _kib("VmHWM")  # of the imports
    most = (_kib("VmSize") + int(MOST_MIB * 1024)) * 1024
    free = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (most, free[1]))
    ended: Exception | None = None
    try:
        door(case)
    except Exception as fault:
        ended = fault
    resource.setrlimit(resource.RLIMIT_AS, free)
    how = "result" if ended is None else _named(ended)
    mib = (_kib("VmHWM") - held) / 1024.0
    os.write(told, f"{mib}\n{how}\n{ended or ''}".encode())


def _named(ended: Exception) -> str:
    from motorcade.tracking import TrackingError

    if type(ended) in (ValueError, ModuleNotFoundError) or isinstance(ended, TrackingError):
        return "refused"
    if isinstance(ended, ValueError) and type(ended).__module__.startswith("motorcade."):
        return "refused"
    if type(ended) is RuntimeError and " failed; the others are kept" in str(ended):
        return "refused"  # by jobs, which say what each was refused for
    where = traceback.extract_tb(ended.__traceback__)[-1]
    return f"{type(ended).__name__}: {str(ended)[:80]} ({Path(where.filename).name}:{where.lineno})"


def _kib(name: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name + ":"):
            return int(line.split()[1])
    raise KeyError(name)


def table(doors: Iterable[str], gaps: Iterable[str], folder: Path, *, reasons: bool) -> int:
    """Print a row a door; the number of faults."""
    gaps = tuple(gaps)
    print(f"{'':34}" + "".join(f"{name:>16}" for name in ("no gap", *gaps, "0, then today")))
    faults = []
    for door in doors:
        usual = _without_gaps(door, folder)
        cells = [_cell(usual, fault=usual.how != "result")]
        for gap in (*gaps, None):
            worst = Outcome("refused", 0.0, 0.0)
            for shape, stamps in shapes(None if gap is None else GAPS[gap]).items():
                case = Case.of(stamps, folder / f"{gap} {shape}")
                found = tried(door, case)
                if reasons and found.reason:
                    print(f"  {gap}, {shape}: {found.how}: {found.reason}")
                if found.fault(usual):
                    faults.append(f"{door}, {gap}, {shape}: {found}")
                worst = max(
                    worst,
                    found,
                    key=lambda one: (one.fault(usual), one.how == "result", one.seconds),
                )
            cells.append(_cell(worst, worst.fault(usual)))
        print(f"{door:34}" + "".join(f"{cell:>16}" for cell in cells), flush=True)
    for fault in faults:
        print(fault)
    return len(faults)


def _cell(found: Outcome, fault: bool) -> str:
    mark = "!" if fault else "-" if found.how == "refused" else ""
    return f"{mark} {found.seconds:.2f} s {found.mib:4.0f} MiB"


def _without_gaps(door: str, folder: Path) -> Outcome:
    """What a door takes for a path without gaps, once that what is imported late is there."""
    case = Case.of(next(iter(shapes(STEP_NS).values())), folder / "even")
    if door in DOORS:
        with Path(os.devnull).open("w") as nothing, redirect_stdout(nothing):
            DOORS[door](case)
    return tried(door, Case.of(case.time_ns, folder / "usual"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    every = [*DOORS, *FRESH]
    parser.add_argument("--doors", nargs="+", default=every, choices=every)
    parser.add_argument("--gaps", nargs="+", default=list(GAPS), choices=list(GAPS))
    parser.add_argument("--reasons", action="store_true", help="say why paths are refused")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        faults = table(arguments.doors, arguments.gaps, Path(folder), reasons=arguments.reasons)
    print(f"{faults} faults; {time.monotonic() - began:.0f} s; '-': all such paths are refused")
    return 1 if faults else 0


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    sys.exit(main())
