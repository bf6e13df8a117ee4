"""A sweep gives what single runs give; failures stay apart; what is finished is not run again."""

import csv
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorcade.replays.cli import main
from motorcade.replays.comparison import sweep
from motorcade.replays.comparison.sweep import Summary, read_sweep, run_sweep
from motorcade.replays.engine.jobs import outcomes
from motorcade.replays.pipeline.job import Job, pipeline_graph, run_job
from tests.end_to_end.shared_storage import CONTAINER, can_contain

Config = Callable[..., Path]


def swept(config: Path, out: Path, executor: str = "local") -> Summary:
    return run_sweep(read_sweep(config, pipeline_graph()), out, executor)


def test_figures_are_those_of_single_runs(config: Config, tmp_path: Path) -> None:
    path = config('["one"]', "smoothed.order = [1, 2]\nsmoothed.representations = 'motor'", "[4]")
    summary = swept(path, tmp_path / "out")
    settings = "tracked.by=simulated smoothed.representations=motor convergence.duration_s=1"
    for order in ("1", "2"):
        single = run_job(
            Job(
                tmp_path / "one",
                tmp_path / f"single{order}",
                until="errors",
                settings=(
                    *settings.split(),
                    f"smoothed.order={order}",
                    "imu.seed=4",
                    "simulated_poses.seed=4",
                ),
            )
        )
        for row in summary.rows:
            if row["smoothed.order"] == order:
                figures = single["errors"][row["path"]]
                assert row["ape_rmse_m"] == figures["ape_rmse_m"]
                assert row["lag_ms"] == figures["lag_ms"]
    assert len({row["ape_rmse_m"] for row in summary.rows if row["path"] == "motor"}) == 2


def test_parquet_and_csv_hold_the_same(config: Config, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    path = config('["one", "gone"]', "smoothed.representations = 'motor'", "[0]")
    summary = swept(path, tmp_path / "out")
    with (tmp_path / "out" / "sweep.csv").open() as file:
        from_csv = list(csv.DictReader(file))
    from_parquet = parquet.read_table(tmp_path / "out" / "sweep.parquet").to_pylist()
    assert from_parquet == [dict(row) for row in summary.rows]
    assert from_csv == [
        {name: "" if value is None else str(value) for name, value in row.items()}
        for row in from_parquet
    ]


@pytest.mark.slow
@pytest.mark.skipif(not can_contain(), reason="no containers are permitted")
def test_two_containers_at_once_leave_the_table_of_one(config: Config, tmp_path: Path) -> None:
    path = config(knobs="smoothed.representations = 'motor'\nsmoothed.order = [1, 2]")
    swept(path, tmp_path / "alone")
    script = "import sys; from motorcade.replays.cli import main; sys.exit(main(sys.argv[1:]))"
    arguments = ["sweep", path, "--out", tmp_path / "shared", "--executor", "local"]
    both = [
        subprocess.Popen(
            [*CONTAINER, sys.executable, "-c", script, *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    for one in both:
        _, told = one.communicate(timeout=300)
        assert one.returncode == 0, told[-2000:]
    for name in ("sweep.csv", "sweep.html"):
        expected = (tmp_path / "alone" / name).read_bytes()
        assert (tmp_path / "shared" / name).read_bytes() == expected
    left = [path for path in (tmp_path / "shared").rglob(".*") if path.name != ".cache"]
    assert not left


def test_a_failed_recording_stands_in_the_table_and_is_tried_again(
    config: Config, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = config('["two", "one"]', "smoothed.representations = 'motor'", "[0]")
    hidden = (tmp_path / "two").rename(tmp_path / "elsewhere")
    out = tmp_path / "out"
    assert main(["sweep", str(path), "--out", str(out), "--executor", "local"]) == 1
    assert "1 of 2 runs failed" in capsys.readouterr().err
    page = (out / "sweep.html").read_text()
    assert re.search(r"<li><code>two-\w+</code> .*no such file", page)
    hidden.rename(tmp_path / "two")
    summary = swept(path, out)
    assert (summary.done, summary.done_before, summary.failed) == (1, 1, 0)
    assert {row["status"] for row in summary.rows} == {"done"}


def test_what_is_finished_is_not_run_again_and_what_changed_is(
    config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = config(knobs="smoothed.representations = 'motor'", seeds="[0]")
    called: list[Path] = []

    def counted(job: Job) -> dict[str, Any]:
        called.append(job.recording)
        return run_job(job)

    monkeypatch.setattr(sweep, "run_job", counted)
    first = swept(path, tmp_path / "out")
    assert [place.name for place in called] == ["one", "two"]
    again = swept(path, tmp_path / "out")
    assert len(called) == 2
    assert again.rows == first.rows
    truth = tmp_path / "two" / "truth.tum"
    truth.write_text(truth.read_text().replace("0.1", "0.2", 1))
    swept(path, tmp_path / "out")
    assert [place.name for place in called] == ["one", "two", "two"]
    damaged = next((tmp_path / "out" / "runs").glob("one-*")) / "outcome" / "value.json"
    damaged.write_text(damaged.read_text()[:20])
    assert swept(path, tmp_path / "out").done == 1


def test_a_process_that_dies_takes_only_its_own_job() -> None:
    jobs = ["pass", "import os; os._exit(3)", "1 / 0", "import math"]
    ended = dict(outcomes(exec, jobs, "processes"))
    assert ended["pass"] is None
    assert ended["import math"] is None
    assert "the process died" in str(ended[jobs[1]])
    assert isinstance(ended["1 / 0"], ZeroDivisionError)


def test_an_unknown_executor_is_refused_before_anything_runs(
    config: Config, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = config(seeds="[0]")
    assert main(["sweep", str(path), "--out", str(tmp_path / "o"), "--executor", "cloud"]) == 1
    assert "--executor: expected local, processes" in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


def test_a_cluster_that_is_not_there_is_told_in_one_line(
    config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("motorcade.replays.engine.jobs._ANSWERS_WITHIN_S", 0.5)
    with pytest.raises(RuntimeError, match="no Dask scheduler answers at tcp:"):
        swept(config('["one"]', seeds="[0]"), tmp_path / "out", "tcp://127.0.0.1:9")


def test_a_sweep_names_doubtful_runs_and_fails_where_strict(
    config: Config, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    knobs = "camera_poses.blackouts_s = ['', '0.2,1.9']\nsmoothed.representations = 'motor'"
    asked = ("sweep", config('["one"]', knobs, "[0]"), "--out", tmp_path, "--executor", "local")
    assert main([*map(str, asked)]) == 0
    assert "1 of them are DOUBTFUL" in capsys.readouterr().out
    for _ in range(2):  # whether it was done just now or before
        assert main([*map(str, asked), "--strict", "--json"]) == 1
        told = capsys.readouterr()
        assert "1 of 2 results are doubtful" in told.err
        rows = json.loads(told.out)["rows"]
        assert {(row["camera_poses.blackouts_s"], row["status"]) for row in rows} == {
            ("", "done"),
            ("0.2,1.9", "doubtful"),
        }
        (doubt,) = {row["doubts"] for row in rows if row["doubts"]}
        assert "frames have no pose" in doubt
    assert "<h2>Doubtful</h2>" in (tmp_path / "sweep.html").read_text()
