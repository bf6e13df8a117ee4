"""Forty runs on a Dask cluster: the process pool's table, whatever is killed in the middle."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

distributed = pytest.importorskip("distributed")

from motorcade.replays.comparison.sweep import read_sweep, run_sweep  # noqa: E402
from motorcade.replays.engine import jobs  # noqa: E402
from motorcade.replays.pipeline.job import pipeline_graph  # noqa: E402

pytestmark = pytest.mark.slow

Config = Callable[..., Path]

SWEEP = """
import sys
from pathlib import Path
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.replays.engine import jobs
from motorcade.replays.comparison.sweep import read_sweep, run_sweep
jobs._code = lambda function: "code"
if __name__ == "__main__":
    plan = read_sweep(Path(sys.argv[1]), pipeline_graph())
    print(run_sweep(plan, Path(sys.argv[2]), sys.argv[3]).failed)
"""


@pytest.fixture(autouse=True)
def _steady_code(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The sources may be edited while tests run; here a key changes only by what a test does."""
    monkeypatch.setattr(jobs, "_code", lambda function: "code")
    return


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Two workers of one thread each, which a nanny starts again when they die."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as made:
        yield made


@pytest.fixture
def forty(config: Config) -> Path:
    return config(
        knobs="smoothed.representations = 'motor'\nsmoothed.order = [1, 2]",
        seeds=str(list(range(10))),
    )


def finished(out: Path) -> int:
    return len(list(out.glob("runs/*/outcome")))


def when_some_are_done(out: Path, some: int, act: Callable[[], None]) -> threading.Thread:
    """Act once `some` runs are finished; the thread ends then, or after five minutes."""

    def watch() -> None:
        for _ in range(3000):
            if finished(out) >= some:
                act()
                return
            time.sleep(0.1)

    thread = threading.Thread(target=watch)
    thread.start()
    return thread


def test_a_cluster_that_loses_a_worker_gives_the_table_of_the_process_pool(
    forty: Path, cluster: Any, tmp_path: Path
) -> None:
    plan = read_sweep(forty, pipeline_graph())
    here = run_sweep(plan, tmp_path / "here", "processes")
    assert (here.done, here.failed) == (40, 0)
    there = tmp_path / "there"
    victim = cluster.workers[0].pid
    killer = when_some_are_done(there, 5, lambda: os.kill(victim, signal.SIGKILL))
    result = run_sweep(plan, there, cluster.scheduler_address)
    killer.join()
    assert not Path(f"/proc/{victim}").exists()
    assert (result.done, result.failed) == (40, 0)
    assert result.rows == here.rows
    for name in ("sweep.csv", "sweep.parquet", "sweep.html"):
        assert (there / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


def test_a_sweep_that_is_killed_goes_on_where_it_was(forty: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    script = tmp_path / "sweep_here.py"
    script.write_text(SWEEP)
    command = [sys.executable, str(script), str(forty), str(out), "processes"]
    running = subprocess.Popen(command, start_new_session=True)
    when_some_are_done(out, 6, lambda: os.killpg(running.pid, signal.SIGKILL)).join()
    assert running.wait() == -signal.SIGKILL
    before = {path: path.stat().st_mtime_ns for path in out.glob("runs/*/outcome")}
    assert 6 <= len(before) < 40
    result = run_sweep(read_sweep(forty, pipeline_graph()), out, "processes")
    assert (result.done, result.done_before, result.failed) == (40 - len(before), len(before), 0)
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in before.items())
    assert len(result.rows) == 40 * 3
