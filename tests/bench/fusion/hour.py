"""An hour of an IMU at 1 kHz, simulated along poses of a file and written as it comes.

`python -m tests.bench.fusion.hour` runs the command itself, as .npz and as CSV, with white noise
and walks and with every trouble, and prints each process's seconds (wall, processor) and peak
memory, less that of the same command on two seconds.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from motorcade.fusion.motions import MOTIONS
from motorcade.replays.io.trajectories import write_trajectory

_TROUBLES = """--gyro-flicker 1e-4 1e-4 1e-4 --accel-flicker 1e-3 1e-3 1e-3 --gyro-turn 0.01 0 0
    --gyro-g-sensitivity 1e-4 1e-4 1e-4 --warming-k 20 --gyro-bias-per-k 1e-4 0 0
    --gyro-lowpass-hz 200 --accel-lowpass-hz 200 --accel-delay-s 0.001 --stamp-jitter-s 1e-4
    --dropped 0.001"""


def main() -> None:
    """Print a line a case."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        poses = {}
        for seconds in (2.0, 3600.0):
            poses[seconds] = folder / f"{seconds:g}.tum"
            write_trajectory(MOTIONS["handheld"].sampled(20.0, seconds), poses[seconds])
        spectrum = folder / "rotors.csv"
        spectrum.write_text("60,0,0,0,0,0,0\n75,0,0,0,1,1,1\n90,0,0,0,0,0,0\n")
        cases = {
            "npz": ("imu.npz", []),
            "csv": ("imu.csv", []),
            "npz, every trouble": ("imu.npz", [*_TROUBLES.split(), "--vibration", str(spectrum)]),
        }
        print(
            f"{'an hour at 1 kHz':<24}{'wall s':>9}{'processor s':>13}{'MiB above 2 s of it':>21}"
        )
        for case, (file, options) in cases.items():
            small = _measured(poses[2.0], folder / file, options)
            wall, spent, peak = _measured(poses[3600.0], folder / file, options)
            print(f"{case:<24}{wall:>9.1f}{spent:>13.1f}{peak - small[2]:>21.0f}", flush=True)


def _measured(poses: Path, out: Path, options: list[str]) -> tuple[float, float, float]:
    """Seconds on the wall and of the processor, and peak memory in MiB, of one command."""
    command = [str(Path(sys.executable).parent / "motorcade"), "simulate-imu", str(poses)]
    begun = perf_counter()
    process = subprocess.Popen([*command, "-o", str(out), "--rate-hz", "1000", *options])
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise RuntimeError(f"simulate-imu: exit status {status}")
    spent = usage.ru_utime + usage.ru_stime
    return perf_counter() - begun, spent, usage.ru_maxrss / 1024


if __name__ == "__main__":
    main()
