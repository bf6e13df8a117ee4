"""`make bench SUITE=smooth`: smoothing on one core beside scipy and plain NumPy, and memory a pose.

Jobs: the RTS smoother over 100,000 poses, a Gaussian window of 31 over 1,000,000, a 1€ filter fed
from Python pose by pose, and the robust estimate with and without wrong poses. Rivals work on
quaternions beside translations (see `smooth_rivals`).
What is too slow to run whole is run on part and scaled up, which the row's name says.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, cast

import numpy as np

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers, PlanarFlips
from motorcade.fusion.smoothing import OneEuro, smooth
from motorcade.ga import Motor, Trajectory
from tests.bench.smoothing.rivals import (
    NumpyOneEuro,
    ScipyOneEuro,
    numpy_gaussian,
    numpy_rts,
    scipy_gaussian,
)
from tests.bench.timing import on_one_core

__all__ = ["bench_smooth", "compact_path", "smooth_table"]

RATE_HZ = 30.0
RTS_POSES, RTS_NUMPY_POSES = 100_000, 1_000
GAUSSIAN_POSES, SIGMA_INTERVALS = 1_000_000, 3.75
STREAM_POSES = 2_000
ROBUST_POSES = 3_000
MEMORY_POSES, SLOW_MEMORY_POSES = (50_000, 250_000), (6_000, 16_000)

Ways = Mapping[str, tuple[Callable[[], object], float]]


@dataclass(frozen=True)
class SmoothRow:
    """One job done one way: seconds, and how many times as long as ours it took."""

    job: str
    way: str
    seconds: float
    over_ours: float


def bench_smooth(rounds: int = 5) -> dict[str, Any]:
    """Measure everything; medians of `rounds`.

    Returns a JSON-ready tree: `rows` (see `SmoothRow`; of streams the
    seconds of one update) and
    `bytes_a_pose`, the peak of memory that each further pose adds, trajectories included.
    """
    with on_one_core():
        rows = [*_rts(rounds), *_gaussian(rounds), *_stream(rounds), *_robust()]
    memory = {
        "rts_constant_velocity": _bytes_a_pose('smooth(path, "rts_constant_velocity")'),
        "rts_constant_acceleration": _bytes_a_pose('smooth(path, "rts_constant_acceleration")'),
        "robust_map": _bytes_a_pose('smooth(path, "robust_map")', SLOW_MEMORY_POSES),
        "spline": _bytes_a_pose('smooth(path, "spline")', SLOW_MEMORY_POSES),
        "gaussian, window of 31": _bytes_a_pose('smooth(path, "gaussian", sigma_s=0.125)'),
        "one_euro, streaming": _bytes_a_pose(
            "chosen = OneEuro()\nfor k in range(len(path)):\n"
            "    chosen.update(path.poses[k], int(path.time_ns[k]))"
        ),
        "the trajectory itself": _bytes_a_pose("pass"),
    }
    return {"rows": [asdict(row) for row in rows], "bytes_a_pose": memory}


def smooth_table(found: Mapping[str, Any]) -> str:
    """A row a job and way, then memory."""
    lines = [f"{'smoothing, one core':<78}{'time':>12}{'of ours':>10}"]
    for row in found["rows"]:
        seconds = row["seconds"]
        text = f"{seconds:.3f} s" if seconds > 1e-3 else f"{1e6 * seconds:.2f} µs"
        lines.append(f"{row['job'] + ': ' + row['way']:<78}{text:>12}{row['over_ours']:>10.1f}")
    lines += ["", "bytes that each further pose adds to the peak of memory"]
    for name, size in found["bytes_a_pose"].items():
        lines.append(f"{name:<78}{'unknown' if size is None else f'{size:.0f}':>12}")
    return "\n".join(lines)


def noisy_path(poses: int) -> Trajectory:
    """Handheld motion at 30 Hz with 5 mm and 0.5° of noise, the same in every run."""
    truth = MOTIONS["handheld"].sampled(RATE_HZ, (poses - 1) / RATE_HZ)
    return Gaussian(0.005, np.deg2rad(0.5)).apply(truth, np.random.default_rng(poses))


def _motors(path: Trajectory) -> Motor:
    return cast(Motor, path.poses)


def _rows(job: str, rounds: int, ways: Ways) -> list[SmoothRow]:
    """Time the ways in turns, in seconds of the processor; each has a factor for partial work."""
    spent: dict[str, list[float]] = {way: [] for way in ways}
    for _ in range(rounds):
        for way, (call, factor) in ways.items():
            start = process_time()
            call()
            spent[way].append(factor * (process_time() - start))
    found = {way: median(times) for way, times in spent.items()}
    ours = next(iter(found.values()))
    return [SmoothRow(job, way, seconds, seconds / ours) for way, seconds in found.items()]


def _rts(rounds: int) -> list[SmoothRow]:
    path = noisy_path(RTS_POSES)
    part = path[:RTS_NUMPY_POSES]
    q, t = _motors(part).as_quaternion_translation()
    densities = np.array([2.0, 1.0])
    scale = RTS_POSES / RTS_NUMPY_POSES
    return _rows(
        f"RTS over {RTS_POSES:,} poses",
        rounds,
        {
            "motors": (lambda: smooth(path, "rts_constant_velocity", "motor"), 1.0),
            "rotors": (lambda: smooth(path, "rts_constant_velocity", "rotor"), 1.0),
            "quaternions, compiled too": (
                lambda: smooth(path, "rts_constant_velocity", "quaternion"),
                1.0,
            ),
            "NumPy on quaternions (1,000, scaled)": (
                lambda: numpy_rts(part.time_s, q, t, densities),
                scale,
            ),
        },
    )


def _gaussian(rounds: int) -> list[SmoothRow]:
    path = noisy_path(GAUSSIAN_POSES)
    q, t = _motors(path).as_quaternion_translation()
    sigma_s = SIGMA_INTERVALS / RATE_HZ
    return _rows(
        f"Gaussian window of 31 over {GAUSSIAN_POSES:,} poses",
        rounds,
        {
            "motors": (lambda: smooth(path, "gaussian", "motor", sigma_s=sigma_s), 1.0),
            "quaternions, by time too": (
                lambda: smooth(path, "gaussian", "quaternion", sigma_s=sigma_s),
                1.0,
            ),
            "scipy on quaternions, by index": (lambda: scipy_gaussian(q, t, SIGMA_INTERVALS), 1.0),
            "NumPy on quaternions, by index": (lambda: numpy_gaussian(q, t, SIGMA_INTERVALS), 1.0),
        },
    )


def _stream(rounds: int) -> list[SmoothRow]:
    path = noisy_path(STREAM_POSES)
    poses, stamps, seconds = list(_motors(path)), path.time_ns.tolist(), path.time_s.tolist()
    pairs = [(q, t) for q, t in zip(*_motors(path).as_quaternion_translation(), strict=True)]

    def ours() -> Motor:
        update = OneEuro().update
        for pose, stamp in zip(poses, stamps, strict=True):
            made = update(pose, stamp)
        return made

    def rival(kind: type[NumpyOneEuro] | type[ScipyOneEuro]) -> None:
        update = kind().update
        for (q, t), at in zip(pairs, seconds, strict=True):
            update(q, t, at)

    each = 1.0 / STREAM_POSES
    return _rows(
        "one update of a 1€ filter from Python",
        rounds,
        {
            "motors": (ours, each),
            "NumPy on quaternions": (lambda: rival(NumpyOneEuro), each),
            "scipy's rotations": (lambda: rival(ScipyOneEuro), each),
        },
    )


def _robust() -> list[SmoothRow]:
    path = noisy_path(ROBUST_POSES)
    rng = np.random.default_rng(1)
    degraded = PlanarFlips(0.02).apply(Outliers(0.05, 0.3, 0.5).apply(path, rng), rng)
    rad = float(np.deg2rad(0.5))

    def estimated(given: Trajectory) -> Trajectory:
        return smooth(given, "robust_map", "motor", noise_m=0.005, noise_rad=rad)

    return _rows(
        f"robust estimate over {ROBUST_POSES:,} poses, motors",
        1,
        {
            "no wrong poses": (lambda: estimated(path), 1.0),
            "5 % outliers, 2 % flips in runs": (lambda: estimated(degraded), 1.0),
        },
    )


def _bytes_a_pose(job: str, sizes: tuple[int, int] = MEMORY_POSES) -> float | None:
    """Growth of a fresh process's peak memory from the smaller path to the larger one.

    None where the system does not tell (it is read from Linux's /proc).
    """
    if not Path("/proc/self/status").exists():
        return None
    peaks = []
    for poses in sizes:
        program = (
            "from motorcade.fusion.smoothing import OneEuro, smooth\n"
            "from tests.bench.smoothing.smooth import compact_path\n"
            f"path = compact_path({poses})\n{job}\n"
            "from pathlib import Path\n"
            "status = Path('/proc/self/status').read_text()\n"
            "print(status.split('VmHWM:')[1].split()[0])\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True
        )
        peaks.append(1024.0 * float(done.stdout))
    return (peaks[1] - peaks[0]) / (sizes[1] - sizes[0])


def compact_path(poses: int) -> Trajectory:
    """A circle written down with little more memory than the poses take."""
    stamps = np.arange(poses, dtype=np.int64) * 33_333_333
    coefficients = np.zeros((poses, 8))
    np.cos(stamps * 1e-10, out=coefficients[:, 0])
    np.sin(stamps * 1e-10, out=coefficients[:, 3])
    return Trajectory(stamps, Motor(coefficients))


def main() -> None:
    """Only the RTS smoothers, and how many times as long as quaternions' the motors' takes."""
    with on_one_core():
        rows = _rts(7)
    print(smooth_table({"rows": [asdict(row) for row in rows], "bytes_a_pose": {}}))
    seconds = {row.way.partition(",")[0]: row.seconds for row in rows}
    print(f"motors over quaternions: {seconds['motors'] / seconds['quaternions']:.2f}")


if __name__ == "__main__":
    main()
