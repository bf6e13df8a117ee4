"""Where the time of a run goes: by stage, thread and function, of the processor and of the clock.

The command runs in this process. Every few milliseconds each of Python's threads is asked for its
own processor's clock and for what it is doing; what its clock went on by since then belongs to that
function. What all of them do not account for was spent by threads that Python does not know:
OpenGL's, codecs' and linear algebra's. Clock less processor of the main thread is waiting, for
other threads or for other work of the machine.

    python -m tests.bench.stages                                  the demo, from an empty folder
    python -m tests.bench.stages --svg image.svg run clip.mp4   any command, and its image
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from motorcade.render.plots import standing_alone
from motorcade.replays.cli import main as motorcade
from motorcade.replays.pipeline.job import pipeline_graph

__all__ = ["bench_stages", "profiled", "stages_image", "stages_table"]

STEP_S = 0.004
SHOWN = 12
"""Functions in the table; the rest is in the JSON file."""
BEFORE, ELSEWHERE, NATIVE = "recording", "the rest", "outside of Python"
MAIN, WORKERS = "main", "workers"


class Sampler(threading.Thread):
    """Asks the threads of this process what they do, until it is stopped.

    Attributes:
        clock_s: seconds that passed in each stage.
        processor_s: seconds of the processor by (stage, thread, function).
    """

    def __init__(self, stages: Sequence[str]) -> None:
        super().__init__(daemon=True)
        self._stages, self._stopped = frozenset(stages), threading.Event()
        self._main = threading.main_thread().ident
        self.clock_s: defaultdict[str, float] = defaultdict(float)
        self.processor_s: defaultdict[tuple[str, str, str], float] = defaultdict(float)

    def run(self) -> None:
        """Sample until `stop`."""
        seen_s, before_s, all_s = _clocks(self._own), time.perf_counter(), time.process_time()
        while not self._stopped.wait(STEP_S):
            frames = sys._current_frames()
            clocks_s, now_s, total_s = _clocks(self._own), time.perf_counter(), time.process_time()
            stage = self._stage(frames.get(self._main or 0))
            self.clock_s[stage] += now_s - before_s
            known_s = clocks_s[self._own] - seen_s.get(self._own, 0.0)
            for ident, clock_s in clocks_s.items():
                if ident == self._own:
                    continue  # what sampling takes is nobody's
                spent_s = clock_s - seen_s.get(ident, 0.0)
                known_s += spent_s
                thread = MAIN if ident == self._main else WORKERS
                self.processor_s[stage, thread, _function(frames.get(ident))] += spent_s
            rest_s = max(0.0, total_s - all_s - known_s)
            self.processor_s[stage, NATIVE, ELSEWHERE] += rest_s
            seen_s, before_s, all_s = clocks_s, now_s, total_s

    def stop(self) -> None:
        """Sample no more."""
        self._stopped.set()
        self.join()

    @property
    def _own(self) -> int:
        assert self.ident is not None  # it runs
        return self.ident

    def _stage(self, frame: FrameType | None) -> str:
        """The stage whose function the main thread is in."""
        for code in _codes(frame):
            if code.co_name in self._stages:
                return code.co_name
            if code.co_name == "ensure_demo_recording":
                return BEFORE
        return ELSEWHERE


def _clocks(own: int) -> dict[int, float]:
    """Seconds of the processor that each of Python's threads has had; own is always among them."""
    clocks_s = {own: 0.0}
    for thread in threading.enumerate():
        if thread.ident is not None:
            try:
                clock = time.pthread_getcpuclockid(thread.ident)
                clocks_s[thread.ident] = time.clock_gettime(clock)
            except OSError:  # it ended in between
                continue
    return clocks_s


def _codes(frame: FrameType | None) -> Iterator[CodeType]:
    """Code of the functions on a stack, the innermost first."""
    while frame is not None:
        yield frame.f_code
        frame = frame.f_back


def _function(frame: FrameType | None) -> str:
    """The innermost function of ours, as room/file: function."""
    rooms = Path(__file__).resolve().parents[2]
    for code in _codes(frame):
        path = Path(code.co_filename)
        if path.is_relative_to(rooms) and ".venv" not in path.parts and path != Path(__file__):
            return f"{path.relative_to(rooms)}: {code.co_name}"
    return ELSEWHERE


def profiled(work: Callable[[], object]) -> dict[str, Any]:
    """Do some work of this process and say where its time went.

    Returns:
        seconds: of the clock; processor_s; clock_s by stage; and rows of stage, thread, function
        and processor_s, the longest first.
    """
    sampler = Sampler(tuple(pipeline_graph().stages))
    clock_s, processor_s = time.perf_counter(), time.process_time()
    sampler.start()
    try:
        work()
    finally:
        sampler.stop()
    rows = [
        {"stage": stage, "thread": thread, "function": function, "processor_s": spent_s}
        for (stage, thread, function), spent_s in sorted(
            sampler.processor_s.items(), key=lambda item: -item[1]
        )
        if spent_s > 0.0
    ]
    return {
        "seconds": time.perf_counter() - clock_s,
        "processor_s": time.process_time() - processor_s,
        "clock_s": dict(sampler.clock_s),
        "rows": rows,
    }


def bench_stages(command: Sequence[str] = ("demo",)) -> dict[str, Any]:
    """Where the time of a command goes; by default of the demo, from an empty folder.

    Raises RuntimeError: the command failed.
    """
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        words = [*command] if "--out" in command else [*command, "--out", folder]
        statuses: list[int] = []
        found = profiled(lambda: statuses.append(motorcade([*words, "--quiet"])))
    if statuses != [0]:
        raise RuntimeError(f"{' '.join(command)}: ended with {statuses}")
    return {"command": list(command), **found}


def _by_thread(found: Mapping[str, Any]) -> dict[str, Counter[str]]:
    """Seconds of the processor by stage and thread, the longest stages first."""
    stages: dict[str, Counter[str]] = {name: Counter() for name in found["clock_s"]}
    for row in found["rows"]:
        stages[row["stage"]][row["thread"]] += row["processor_s"]
    return dict(sorted(stages.items(), key=lambda item: -sum(item[1].values())))


def stages_table(found: Mapping[str, Any]) -> str:
    """A row a stage with its threads, and the functions that take most."""
    lines = [f"{'seconds of ' + found['command'][0]:<32}{'clock':>8}{'processor':>11}"]
    lines[0] += "".join(f"{name:>19}" for name in (MAIN, WORKERS, NATIVE))
    for stage, threads in _by_thread(found).items():
        spent_s = sum(threads.values())
        lines.append(f"{stage:<32}{found['clock_s'][stage]:>8.2f}{spent_s:>11.2f}")
        lines[-1] += "".join(f"{threads[name]:>19.2f}" for name in (MAIN, WORKERS, NATIVE))
    lines.append(f"{'all':<32}{found['seconds']:>8.2f}{found['processor_s']:>11.2f}")
    python = [row for row in found["rows"] if row["thread"] != NATIVE][:SHOWN]
    lines += ["", f"{'seconds of the processor in':<64}{'stage':>14}{'thread':>9}{'s':>7}"]
    for row in python:
        lines.append(f"{row['function']:<64}{row['stage']:>14}{row['thread']:>9}")
        lines[-1] += f"{row['processor_s']:>7.2f}"
    return "\n".join(lines)


WIDE, BAR, LABEL = 420, 18, 110
SHADES = {MAIN: "#31688e", WORKERS: "#35b779", NATIVE: "#bbbbbb"}
LEAST_S = 0.05
"""Stages that take less are left out of the image."""


def stages_image(found: Mapping[str, Any]) -> str:
    """Bars as SVG: of each stage the processor's time by threads; the clock's stands beside it."""
    stages = {name: of for name, of in _by_thread(found).items() if sum(of.values()) > LEAST_S}
    longest_s = max(sum(threads.values()) for threads in stages.values())
    step, parts = BAR + 10, []
    for name, left in zip(SHADES, (LABEL, LABEL + 90, LABEL + 200), strict=True):
        parts.append(f'<rect x="{left}" y="6" width="12" height="12" fill="{SHADES[name]}"/>')
        parts.append(f'<text x="{left + 16}" y="16">{name}</text>')
    for row, (name, threads) in enumerate(stages.items()):
        x, y = float(LABEL), 30 + row * step
        parts.append(f'<text x="{LABEL - 8}" y="{y + 13}" text-anchor="end">{name}</text>')
        for thread, shade in SHADES.items():
            wide = WIDE * threads[thread] / longest_s
            parts.append(f'<rect x="{x:.1f}" y="{y}" width="{wide:.1f}" height="{BAR}" ')
            parts[-1] += f'fill="{shade}"/>'
            x += wide
        spent = f"{sum(threads.values()):.1f} s; clock {found['clock_s'][name]:.1f} s"
        parts.append(f'<text x="{x + 6:.1f}" y="{y + 13}">{spent}</text>')
    style = 'xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="12"'
    size = f"0 0 {LABEL + WIDE + 150} {30 + step * len(stages)}"
    return f'<svg viewBox="{size}" {style}>{"".join(parts)}</svg>'


def main(words: Sequence[str] | None = None) -> None:
    """Profile a command, print its table, and draw it where that is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.stages", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--svg", type=Path, metavar="FILE", help="draw it there")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    arguments, command = parser.parse_known_args(words)
    found = bench_stages(command or ("demo",))
    print(stages_table(found))
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    if arguments.svg is not None:
        arguments.svg.write_text(standing_alone(stages_image(found)), encoding="utf-8")


if __name__ == "__main__":
    main()
