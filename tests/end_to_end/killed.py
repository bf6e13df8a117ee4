"""Kills `motorcade run` at random moments and resumes it: the results must be those of a quiet run.

    python -m tests.end_to_end.killed --kills 50 --seed 1

A small recording of a board is run once undisturbed. Then it is run, killed by SIGKILL at a random
moment, and run again, after four kills to its end; then anew in another folder, until so many kills
have struck. After every end the trajectories, the video and `report.json` are the same bytes, and
the run log is the same but for times and for what lay in the cache. A stage whose output lay in the
cache after a kill is never computed again, and nothing half-written is left. The program ends with
1 where that fails.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.end_to_end import conftest as small

# The sources may be edited while this runs; here a key changes only by what is run.
RUN = """
import sys
from motorcade.replays.engine import store
store.code_digest = lambda function, given: "the same code"
from motorcade.replays.cli import main
sys.exit(main(sys.argv[1:]))
"""
OF_ONE_RUN = ("seconds", "frames_per_s", "cached")
SLOWEST_S = 600.0
KILLS_A_RUN = 4


@dataclass(frozen=True)
class Ended:
    """Kills that struck, runs that came to their end, and what was wrong."""

    kills: int
    ends: int
    faults: tuple[str, ...]


def started(recording: Path, out: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-c", RUN, "run", str(recording), "--out", str(out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def results(out: Path) -> dict[str, Any]:
    """Digests of the files by name, and the run log without what differs from run to run."""
    files = [*(out / "trajectories").glob("*.tum"), *out.glob("*.mp4"), *out.glob("report.*")]
    found: dict[str, Any] = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(files)
    }
    run_log = re.sub(r'"[^"]*/\.cache/', '"OUT/.cache/', (out / "run.json").read_text())
    found["run.json"] = _of_any_run(json.loads(run_log))
    return found


def _of_any_run(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _of_any_run(item) for key, item in tree.items() if key not in OF_ONE_RUN}
    if isinstance(tree, list):
        return [_of_any_run(item) for item in tree]
    return tree


def finished(out: Path) -> dict[str, tuple[int, int]]:
    """Stages that lie in the cache: each folder's number on disk and when it was sealed."""
    return {
        path.parent.name: (path.parent.stat().st_ino, path.stat().st_mtime_ns)
        for path in (out / ".cache").glob("[a-z]*-*/artifact.json")
    }


def killed_at_random(
    recording: Path, folder: Path, kills: int, seed: int, tell: Callable[[str], None]
) -> Ended:
    """Do it; `folder` holds what the runs leave."""
    rng = np.random.default_rng(seed)
    began = time.perf_counter()
    quiet = started(recording, folder / "quiet")
    _, complaint = quiet.communicate(timeout=SLOWEST_S)
    if quiet.returncode != 0:
        raise RuntimeError(f"the undisturbed run failed: {complaint.decode()[-300:]}")
    whole_s = time.perf_counter() - began
    expected = results(folder / "quiet")
    tell(f"undisturbed: {whole_s:.1f} s, {len(expected)} results")
    struck, ends, faults = 0, 0, list[str]()
    while struck < kills:
        out, before = folder / f"run{ends}", dict[str, tuple[int, int]]()
        last = min(struck + KILLS_A_RUN, kills)
        while True:
            process = started(recording, out)
            moment_s = float(rng.uniform(0.0, whole_s)) if struck < last else SLOWEST_S
            try:
                _, complaint = process.communicate(timeout=moment_s)
                break
            except subprocess.TimeoutExpired:
                os.kill(process.pid, signal.SIGKILL)
                process.communicate()
                struck += 1
            after = finished(out)
            again = [name for name, mark in before.items() if after.get(name) != mark]
            if again:
                faults.append(f"kill {struck}: computed again: {', '.join(again)}")
            before = after
            tell(f"kill {struck} after {moment_s:.1f} s: {len(after)} stages are finished")
        ends += 1
        if process.returncode != 0:
            faults.append(f"end {ends}: status {process.returncode}: {complaint.decode()[-300:]}")
            break
        after = finished(out)
        if any(after.get(name) != mark for name, mark in before.items()):
            faults.append(f"end {ends}: a finished stage was computed again")
        if results(out) != expected:
            faults.append(f"end {ends}: other results than those of the undisturbed run")
        left = [path for path in out.rglob(".*") if path.name != ".cache"]
        if left:
            faults.append(f"end {ends}: left behind: {', '.join(path.name for path in left)}")
        tell(f"end {ends} after {struck} kills: {'as undisturbed' if not faults else faults[-1]}")
    return Ended(struck, ends, tuple(faults))


def main() -> int:
    """Run as the module says; 0 where all was well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        recording = small.write_board(Path(made) / "small_board")
        ended = killed_at_random(
            recording,
            Path(made),
            arguments.kills,
            arguments.seed,
            lambda line: print(line, flush=True),
        )
    print(f"{ended.kills} kills, {ended.ends} runs to their end, {len(ended.faults)} faults")
    for fault in ended.faults:
        print(fault)
    return 1 if ended.faults else 0


if __name__ == "__main__":
    sys.exit(main())
