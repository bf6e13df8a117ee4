"""Runs of several containers and hosts on one `--out`, and on a disk that is full.

    python -m tests.end_to_end.shared_storage --kills 10 --seed 1

A small recording of a board is run once undisturbed. Then it is run by two containers (PID
namespaces) at once, again with one of them killed at a random moment, beside what processes of
another host build or have left, and on a disk that grows from 64 KiB until all has room. Every run
that ends leaves the results of the undisturbed one and nothing half-written; every other ends in
one line that says why. The program ends with 1 where that fails.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.unfinished import unfinished
from tests.end_to_end import conftest as small
from tests.end_to_end.killed import RUN, SLOWEST_S, results

CONTAINER = ["unshare", "--user", "--map-root-user", "--mount", "--pid", "--fork", "--mount-proc"]
ENDS_WITH_IT = ["--kill-child"]
DISKS = ["64k", "256k", "512k", "1m", "1400k", "1600k", "64m"]
GROWING = """
folder=$1 kept=$2 sizes=$3; shift 3
for size in $sizes; do
    if [ "$size" = "${sizes%% *}" ]
    then mount -t tmpfs -o size=$size none "$folder"
    else mount -o remount,size=$size none "$folder"
    fi || exit 99
    "$@" 2>"$kept/$size.told"
    echo $? >"$kept/$size.status"
done
cp -r "$folder" "$kept/out"
"""


def can_contain() -> bool:
    """Whether this machine lets us make containers."""
    if shutil.which("unshare") is None:
        return False
    return subprocess.run([*CONTAINER, "true"], capture_output=True, check=False).returncode == 0


@dataclass
class Way:
    """One way of disturbing runs of a recording: how many there were, and what was wrong."""

    recording: Path
    out: Path
    expected: Mapping[str, Any]
    runs: int = 0
    faults: list[str] = field(default_factory=list)

    def contained(self, out: Path) -> subprocess.Popen[bytes]:
        return contained(self.recording, out)

    def end(self, run: subprocess.Popen[bytes], out: Path) -> None:
        """Wait for a run, and compare what it made."""
        _, told = run.communicate(timeout=SLOWEST_S)
        self.runs += 1
        if run.returncode != 0:
            self.faults.append(f"status {run.returncode}: {told.decode()[-300:]}")
        else:
            self.compare(out)

    def compare(self, out: Path) -> None:
        found = results(out)
        differ = [name for name in self.expected if found.get(name) != self.expected[name]]
        self.faults += [f"{name} differs from the undisturbed run's" for name in differ]
        self.faults += [f"left {path.name}" for path in out.rglob(".*") if path.name != ".cache"]


def two_at_once(way: Way) -> None:
    both = [way.contained(way.out) for _ in range(2)]
    for run in both:
        run.wait(timeout=SLOWEST_S)
    for run in both:
        way.end(run, way.out)


def one_of_two_killed(way: Way, after_s: float) -> None:
    """And then a third."""
    doomed, other = way.contained(way.out), way.contained(way.out)
    try:
        doomed.communicate(timeout=after_s)
    except subprocess.TimeoutExpired:
        doomed.kill()
        doomed.communicate()
    other.wait(timeout=SLOWEST_S)
    third = way.contained(way.out)
    third.wait(timeout=SLOWEST_S)
    for run in (other, third):
        way.end(run, way.out)


def beside_another_host(way: Way) -> None:
    """It is building something, which is locked, and has left something that is not."""
    for folder in (way.out, way.out / ".cache", way.out / "trajectories"):
        _leave(folder)
    for folder in (way.out, way.out / ".cache"):
        building = _leave(folder)
        with (building / "lock").open("r+b") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            way.contained(way.out).communicate(timeout=SLOWEST_S)
            if not (building / "half").exists():
                way.faults.append("removed what another host was building")
    way.end(way.contained(way.out), way.out)


def on_a_full_disk(way: Way) -> None:
    """Run on it as it grows."""
    kept = way.out.with_name("kept")
    for made in (way.out, kept):
        made.mkdir()
    command = _command(way.recording, way.out)
    script = ["sh", "-c", GROWING, "sh", way.out, kept, " ".join(DISKS), *command]
    grown = subprocess.run([*CONTAINER, *script], capture_output=True, check=False)
    if grown.returncode != 0:
        raise RuntimeError(f"no disk of a size could be made: {grown.stderr.decode()[-300:]}")
    statuses = []
    for size in DISKS:
        statuses.append(int((kept / f"{size}.status").read_text()))
        told = (kept / f"{size}.told").read_text().splitlines()
        full = statuses[-1] == 1 and told[-1].endswith("No space left on device")
        if not (full or statuses[-1] == 0) or any("Traceback" in line for line in told):
            way.faults.append(f"{size}: status {statuses[-1]}: {' '.join(told)[-300:]}")
    way.runs += len(DISKS)
    if statuses[-1] != 0 or 1 not in statuses:
        way.faults.append(f"expected full disks, then room; got statuses {statuses}")
    else:
        way.compare(kept / "out")


def disturbed(recording: Path, folder: Path, kills: int, seed: int) -> Mapping[str, Way]:
    """Runs disturbed in every way, by its name; `folder` holds what they leave."""
    rng = np.random.default_rng(seed)
    began = time.perf_counter()
    quiet = contained(recording, folder / "quiet")
    _, told = quiet.communicate(timeout=SLOWEST_S)
    if quiet.returncode != 0:
        raise RuntimeError(f"the undisturbed run failed: {told.decode()[-300:]}")
    whole_s = time.perf_counter() - began
    expected = results(folder / "quiet")
    ways = {
        "two containers at once": two_at_once,
        "beside another host": beside_another_host,
        "on a full disk": on_a_full_disk,
    } | {
        f"killed after {after_s:.1f} s beside another": partial(one_of_two_killed, after_s=after_s)
        for after_s in rng.uniform(0.0, whole_s, kills)
    }
    done = {}
    for number, (name, disturb) in enumerate(ways.items()):
        done[name] = Way(recording, folder / f"way{number}", expected)
        disturb(done[name])
    return done


def contained(recording: Path, out: Path) -> subprocess.Popen[bytes]:
    """A run in a container of its own, in which it is process 1."""
    return subprocess.Popen(
        [*CONTAINER, *ENDS_WITH_IT, *_command(recording, out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def _command(recording: Path, out: Path) -> list[str]:
    return [sys.executable, "-c", RUN, "run", str(recording), "--out", str(out)]


def _leave(folder: Path) -> Path:
    """What a process of another host has half-built in a folder."""
    with unfinished(folder) as place:
        mark = json.loads((place / "mark").read_text())
    place.mkdir()
    for name in ("lock", "half"):
        (place / name).touch()
    (place / "mark").write_text(json.dumps(mark | {"host": "elsewhere", "boot": "another"}))
    return place


def main() -> int:
    """Run as the module says; 0 where all was well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    if not can_contain():
        sys.exit("no containers are permitted here (unshare --user --pid)")
    with tempfile.TemporaryDirectory() as made:
        recording = small.write_board(Path(made) / "small_board")
        done = disturbed(recording, Path(made), arguments.kills, arguments.seed)
    for name, way in done.items():
        print(f"{name:40}{way.runs:3} runs to their end, {len(way.faults)} faults")
        for fault in way.faults:
            print(f"    {fault}")
    return 1 if any(way.faults for way in done.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
