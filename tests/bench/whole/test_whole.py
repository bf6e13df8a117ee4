"""The page in one run: a job that fails costs itself alone, and the README has the page's rows."""

import json
import time

import pytest

from tests.bench import __main__ as bench
from tests.bench.page import RUNS, page
from tests.bench.tables import SUITES
from tests.bench.whole import running
from tests.bench.whole.jobs import JOBS, MINUTES, Job
from tests.bench.whole.quoted import quoted_rows, rows_of, with_figures_of
from tests.ga.kernels.accuracy_fresh import LIMITS

ACCURACY = Job("accuracy", 100.0)


def test_every_suite_is_on_the_page() -> None:
    assert {job.suite for job in JOBS} == set(SUITES)
    assert len({job.name for job in JOBS}) == len(JOBS)
    assert MINUTES <= 25.0


@pytest.mark.parametrize("suite", ["fusion", "tracking"])
def test_every_part_of_a_suite_is_on_the_page(suite: str) -> None:
    from importlib import import_module

    parts = import_module(f"tests.bench.{suite}.suite").PARTS
    assert {job.part for job in JOBS if job.suite == suite} == set(parts)


def test_sizes_are_arguments_of_what_measures() -> None:
    import inspect
    from importlib import import_module

    for job in JOBS:
        module, measure, _ = SUITES[job.suite]
        suite = import_module(f"tests.bench.{module}")
        called = getattr(suite, measure) if job.part is None else suite.PARTS[job.part][0]
        assert set(job.sizes) <= set(inspect.signature(called).parameters), job.name


def stub(job: Job, limit_s: float):
    if job.suite == "render":
        return None, "failed with 1: no OpenGL"
    fresh = dict.fromkeys(LIMITS, (1e-15, 2.5))
    return {"hard": {"float32": {"log": 2e-7}}, "fresh": {"float32": fresh}}, None


def test_what_fails_is_named_and_the_rest_is_there(monkeypatch) -> None:
    monkeypatch.setattr(running, "_measured", stub)
    figures = running.run_whole([Job("render", 10.0), ACCURACY])
    assert set(figures[RUNS]) == {"render", "accuracy"}
    text = page(figures)
    assert "Left out: render: failed with 1: no OpenGL." in text
    assert "largest error of all kernels where formulas fail, float32" in text
    assert "`make bench SUITE=render`" in text.partition("## Not in this run")[2]


def test_nothing_begins_when_the_time_is_over(monkeypatch) -> None:
    monkeypatch.setattr(running, "_measured", stub)
    figures = running.run_whole([ACCURACY], minutes=0.0)
    assert figures[RUNS]["accuracy"]["left_out"].startswith("not begun")
    assert "accuracy" not in figures


def test_a_job_that_takes_too_long_is_ended_with_all_that_it_started(tmp_path, monkeypatch) -> None:
    mark = tmp_path / "alive"
    child = f"import time; time.sleep(4); open({str(mark)!r}, 'w').write('x')"
    job = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])"
    real = running.subprocess.Popen

    def popen(command, **how):
        return real([command[0], "-c", job], **how)

    monkeypatch.setattr(running.subprocess, "Popen", popen)
    found, fault = running._measured(ACCURACY, 1.0)
    assert (found, fault) == (None, "ended after 1 s")
    time.sleep(4.5)
    assert not mark.exists()


def test_one_job_runs_in_a_process_of_its_own_into_the_readme(tmp_path, monkeypatch) -> None:
    (tmp_path / "docs").mkdir()
    head = "| what | here | beside it | times ours | command |\n|---|---|---|---|---|\n"
    what = "largest error of all kernels where formulas fail, float32 (`log`)"
    row = f"| {what} | 1 | 50 digits | – | `make bench` |\n"
    (tmp_path / "README.md").write_text(f"# Kept\n\n{head}{row}\nKept too.\n")
    monkeypatch.setattr(bench, "JOBS", [ACCURACY])
    monkeypatch.setattr(running, "_measured", stub)
    with pytest.raises(SystemExit, match="0"):
        bench.main(["--into", str(tmp_path)])
    kept = json.loads((tmp_path / "build" / "bench.json").read_text())
    assert kept["accuracy"]["hard"]["float32"] == {"log": 2e-7}
    readme, written = (tmp_path / name for name in ("README.md", "docs/benchmarks.md"))
    assert "| 2.0e-07 |" in readme.read_text()
    assert readme.read_text().startswith("# Kept\n\n")
    assert readme.read_text().endswith("\n\nKept too.\n")
    assert all(row == found for row, found in quoted_rows(readme.read_text(), written.read_text()))


def test_rows_that_the_page_lacks_stay_and_are_told() -> None:
    head = "| what | here | beside it | times ours | command |\n|---|---|---|---|---|\n"
    readme, text = (
        f"{head}| a | 1 | 2 | 2 | c |\n| b | 1 | 2 | 2 | c |\n\n",
        f"{head}| b | 3 | 6 | 2 | c |\n\n",
    )
    assert dict(quoted_rows(readme, text)) == {
        "| a | 1 | 2 | 2 | c |": None,
        "| b | 1 | 2 | 2 | c |": "| b | 3 | 6 | 2 | c |",
    }
    assert rows_of(with_figures_of(readme, text)) == [
        "| a | 1 | 2 | 2 | c |",
        "| b | 3 | 6 | 2 | c |",
    ]
    with pytest.raises(ValueError, match="expected a table"):
        rows_of("nothing")


@pytest.mark.slow
def test_a_suite_is_measured_by_a_process_of_its_own() -> None:
    figures = running.run_whole([Job("blend", 200.0, sizes={"seconds": 0.002, "rounds": 1})])
    assert figures[RUNS]["blend"].get("left_out") is None, figures[RUNS]
    assert figures["blend"]["rows"]
