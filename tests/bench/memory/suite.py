"""`make bench SUITE=memory`: what long recordings take at most, each run in a process of its own.

Recordings are made in the system's folder for temporary files: a hundred thousand small frames of a
checkerboard, run up to the report but for the video, which would take an hour to draw; a tenth of
them with the video; two hours of an IMU at 200 Hz, fused with poses and smoothed, by the library
alone and, from a CSV file, by the pipeline with poses at several rates. Every job starts a new
interpreter, which tells its own peak of memory, and what of that its imports had taken before it
read anything. The limit of the stream counts above the imports.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

__all__ = ["bench_memory", "measured", "memory_table"]

FRAMES, STREAM_S = 100_000, 7200.0
POSES_HZ = (1.0, 5.0, 20.0)
FRAMES_LIMIT_MIB, STREAM_LIMIT_MIB = 1536, 300
_CHILD = "tests.bench.memory.child"


def bench_memory(frames: int = FRAMES, stream_s: float = STREAM_S) -> dict[str, Any]:
    """Make both recordings and run them; MiB and seconds of each job.

    Raises:
        RuntimeError: a job that failed, with what it said.
    """
    rows = []
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for count, film in ((frames, False), (frames // 10, True)):
            footage = str(folder / f"{count}")
            measured("footage", footage, str(count))
            job = f"{count:,} frames, report {'with video' if film else 'without video'}"
            rows.append(
                {"job": job, "limit_mib": FRAMES_LIMIT_MIB}
                | measured("run", footage, "--out", f"{footage}_out", film=film)
            )
        stream = folder / "stream"
        measured("stream", str(stream), str(stream_s))
        job = f"{stream_s / 3600.0:g} h of 200 Hz IMU, poses at 20 Hz, by the library alone"
        rows.append({"job": job, "limit_mib": STREAM_LIMIT_MIB} | measured("fuse", str(stream)))
        for rate_hz in POSES_HZ:
            job = f"{stream_s / 3600.0:g} h of 200 Hz IMU, poses at {rate_hz:g} Hz, fused, smoothed"
            rows.append(
                {"job": job, "limit_mib": STREAM_LIMIT_MIB}
                | measured(
                    "run",
                    str(stream),
                    "--out",
                    str(folder / f"out_{rate_hz:g}"),
                    "--until",
                    "smoothed",
                    "--set",
                    "tracked.by=simulated",
                    "--set",
                    f"simulated_poses.rate_hz={rate_hz}",
                )
            )
    return {"frames": frames, "stream_s": stream_s, "jobs": rows}


def measured(*arguments: str, film: bool = True) -> dict[str, float]:
    """Do a job of `child` in a process of its own: MiB at most, MiB of imports, seconds.

    Args:
        arguments: of `child`.
        film: without it the job finds no OpenGL, and so draws no video.

    Raises:
        RuntimeError: the job failed.
    """
    done = subprocess.run(
        [sys.executable, "-m", _CHILD, *arguments],
        env=dict(os.environ) if film else os.environ | {"PYOPENGL_PLATFORM": "none"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        said = " ".join((done.stderr or done.stdout).split())[-300:]
        raise RuntimeError(f"bench memory: {arguments[0]} ended with {done.returncode}: {said}")
    found = json.loads(done.stdout.splitlines()[-1])
    return {
        "peak_mib": found["peak"] / 2**20,
        "imports_mib": found["imported"] / 2**20,
        "seconds": found["seconds"],
    }


def memory_table(found: Mapping[str, Any]) -> str:
    """A line a job."""
    jobs: Sequence[Mapping[str, Any]] = found["jobs"]
    lines = [f"{'memory at most, MiB':<58}{'peak':>7}{'imports':>9}{'limit':>7}{'seconds':>9}"]
    lines += [
        f"{job['job']:<58}{job['peak_mib']:>7.0f}{job['imports_mib']:>9.0f}"
        f"{job['limit_mib']:>7.0f}{job['seconds']:>9.0f}"
        for job in jobs
    ]
    return "\n".join(lines)
