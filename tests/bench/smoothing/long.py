"""`make bench SUITE=smoother_speed`: whole-path smoothers on long paths, seconds and memory a pose.

    python -m tests.bench.smoothing.long [POSES]     another length than 100,000, such as 1000000

Each way runs on one core in a process of its own. Memory is what its peak adds to what the process
held with the path, beside the arrays that it returns.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from motorcade.fusion.motions.degradations import Outliers
from motorcade.fusion.smoothing import smooth, smoothed_automatically
from motorcade.ga import Motor, Trajectory
from tests.bench.smoothing.smooth import noisy_path
from tests.bench.timing import on_one_core

__all__ = ["LongRow", "bench_long", "long_table"]

POSES, WARM_UP_POSES = 100_000, 2_000
OUTLIERS = "auto, 1 % outliers"


@dataclass(frozen=True)
class LongRow:
    """One way over one path: its length, seconds of the processor, bytes a pose or None."""

    way: str
    poses: int
    seconds: float
    bytes_a_pose: float | None


def _smoothed(method: str, representation: str | None = None) -> Callable[[Trajectory], int]:
    def run(path: Trajectory) -> int:
        made = smooth(path, method, representation)
        return int(made.poses.coefficients.nbytes)

    return run


def _automatically(path: Trajectory) -> int:
    found = smoothed_automatically(path)
    arrays = found.trajectory.poses.coefficients, found.weights, found.deviations
    return sum(one.nbytes for one in arrays)


# By name: what runs on a path, and returns the bytes of what it makes.
_WAYS: Mapping[str, Callable[[Trajectory], int]] = {
    OUTLIERS: _automatically,
    "auto": _automatically,
    "robust_map, motors": _smoothed("robust_map", "motor"),
    "RTS, motors": _smoothed("rts_constant_velocity", "motor"),
    "RTS, rotors": _smoothed("rts_constant_velocity", "rotor"),
    "RTS, quaternions": _smoothed("rts_constant_velocity", "quaternion"),
    "spline": _smoothed("spline"),
    "local_polynomial": _smoothed("local_polynomial"),
}


def bench_long(poses: int = POSES) -> dict[str, Any]:
    """Measure every way over so many poses; `rows` are those of `LongRow`."""
    rows = []
    with tempfile.TemporaryDirectory() as folder, on_one_core():
        clean, wrong = Path(folder, "clean.npz"), Path(folder, "wrong.npz")
        path = noisy_path(poses)
        _write(path, clean)
        _write(Outliers(0.01, 0.3, 0.5).apply(path, np.random.default_rng(poses)), wrong)
        for way in _WAYS:
            given = wrong if way == OUTLIERS else clean
            command = [sys.executable, "-m", "tests.bench.smoothing.long", "--one", way, str(given)]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            rows.append(json.loads(done.stdout.splitlines()[-1]))
    return {"rows": rows}


def long_table(figures: Mapping[str, Any]) -> str:
    """A row a way."""
    lines = [
        f"{'smoothing long paths, one core':<32}{'poses':>10}{'seconds':>10}{'µs':>8}{'bytes':>8}"
    ]
    for row in figures["rows"]:
        size = "unknown" if row["bytes_a_pose"] is None else f"{row['bytes_a_pose']:.0f}"
        each = 1e6 * row["seconds"] / row["poses"]
        lines.append(
            f"{row['way']:<32}{row['poses']:>10,}{row['seconds']:>10.3f}{each:>8.2f}{size:>8}"
        )
    return "\n".join([*lines, "µs and bytes are of a pose"])


def _write(path: Trajectory, file: Path) -> None:
    np.savez(file, time_ns=path.time_ns, poses=path.motors.coefficients)


def _measured(way: str, file: Path) -> LongRow:
    """One way in this process, on a path that was written."""
    given = np.load(file)
    path = Trajectory(given["time_ns"], Motor(given["poses"]))
    _WAYS[way](path[:WARM_UP_POSES])
    before = _held("VmRSS:", forget_peak=True)
    start = process_time()
    returned = _WAYS[way](path)
    seconds = process_time() - start
    peak, added = _held("VmHWM:"), None
    if before is not None and peak is not None:
        added = max(0.0, peak - before - returned) / len(path)
    return LongRow(way, len(path), seconds, added)


def _held(line: str, *, forget_peak: bool = False) -> int | None:
    """Bytes that Linux tells of this process; None elsewhere."""
    process = Path("/proc/self")
    if not (process / "clear_refs").exists():
        return None
    if forget_peak:
        (process / "clear_refs").write_text("5")
    return 1024 * int((process / "status").read_text().split(line)[1].split()[0])


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--one", way, file]:
            print(json.dumps(asdict(_measured(way, Path(file)))))
        case [count]:
            print(long_table(bench_long(int(count))))
        case _:
            print(long_table(bench_long()))
