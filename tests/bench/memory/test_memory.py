"""The memory suite: each job tells of its own process, and one that fails says why."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.bench.memory.suite import bench_memory, measured, memory_table

HELD = 300
HOARDER = f"""
from tests.bench.memory import child
held = b"x" * ({HELD} << 20)
print(child.peak_bytes())
"""


def test_the_table_shows_peaks_beside_their_limits() -> None:
    job = {
        "job": "two hours",
        "limit_mib": 300,
        "peak_mib": 268.6,
        "imports_mib": 73.2,
        "seconds": 40.2,
    }
    head, line = memory_table({"jobs": [job]}).splitlines()
    assert line.split() == ["two", "hours", "269", "73", "300", "40"]
    assert len(head) == len(line)


def test_a_peak_is_that_of_the_process_alone() -> None:
    ours = b"y" * (500 << 20)
    told = subprocess.run([sys.executable, "-c", HOARDER], capture_output=True, check=True)
    assert len(ours) > HELD << 20
    assert HELD << 20 < int(told.stdout) < (HELD + 100) << 20


def test_a_job_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match=r"run ended with 1: .*no such file"):
        measured("run", str(tmp_path / "nowhere"), "--out", str(tmp_path / "out"))


@pytest.mark.slow
def test_short_recordings_go_through(opengl: None) -> None:
    found = bench_memory(frames=120, stream_s=20.0)
    assert len(found["jobs"]) == 6
    for job in found["jobs"]:
        assert job["imports_mib"] < job["peak_mib"] < 1000.0
