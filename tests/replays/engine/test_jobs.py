"""Jobs are done once, by any executor; what fails or was stopped is told and tried again."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga.arrays import FloatArray
from motorcade.replays.engine.jobs import Batch, check_executor, job_key, run_jobs


@dataclass(frozen=True)
class Sum:
    """Numbers to be added; the sum of none fails."""

    numbers: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Added:
    total: int
    steps: FloatArray
    pairs: tuple[tuple[str, float], ...]


def added(job: Sum) -> Added:
    if not job.numbers:
        raise ValueError("nothing\nto add")
    steps = np.cumsum(np.array(job.numbers, dtype=np.float64))
    return Added(sum(job.numbers), steps, (("first", float(job.numbers[0])),))


JOBS = (Sum((1, 2)), Sum((0, 3, 5)), Sum((7,)))


def run(out: Path, executor: str = "local", jobs: tuple[Sum, ...] = JOBS) -> Batch[Sum, Added]:
    places = {job: out / job_key(added, job.numbers) for job in jobs}
    return run_jobs(added, places, executor, "sums")


@pytest.mark.parametrize("executor", ["local", "processes:2"])
def test_results_come_in_the_jobs_order_and_are_kept(executor: str, tmp_path: Path) -> None:
    first = run(tmp_path, executor)
    assert [one.total for one in first.whole("sums").values()] == [3, 8, 7]
    assert first.results[JOBS[1]].steps.tolist() == [0.0, 3.0, 8.0]
    assert first.results[JOBS[2]].pairs == (("first", 7.0),)
    again = run(tmp_path, executor)
    assert (first.done_before, again.done_before) == (0, 3)
    assert [one.total for one in again.results.values()] == [3, 8, 7]


def test_a_failure_ends_nothing_and_is_tried_again(tmp_path: Path) -> None:
    jobs = (Sum(()), *JOBS)
    for done_before in (0, 3):
        batch = run(tmp_path, jobs=jobs)
        assert (len(batch.results), batch.done_before, batch.left) == (3, done_before, 0)
        assert batch.failures == {Sum(()): "nothing to add"}
    with pytest.raises(RuntimeError, match=r"1 of 4 sums failed; .* first: nothing to add"):
        batch.whole("sums")


def test_a_damaged_result_is_computed_again(tmp_path: Path) -> None:
    run(tmp_path)
    damaged = tmp_path / job_key(added, JOBS[0].numbers) / "value.json"
    damaged.write_text(damaged.read_text()[:9])
    batch = run(tmp_path)
    assert batch.done_before == 2
    assert batch.whole("sums")[JOBS[0]].total == 3


def test_what_another_run_has_done_meanwhile_is_kept_where_it_is(tmp_path: Path) -> None:
    """A reader of it must not find it gone, as it would while one took the other's place."""
    places = {JOBS[0]: tmp_path / job_key(added, JOBS[0].numbers)}
    numbers = []

    def beaten(job: Sum) -> Added:
        run_jobs(added, places, "local", "sums")
        numbers.append(places[job].stat().st_ino)
        return added(job)

    batch = run_jobs(beaten, places, "local", "sums")
    assert batch.whole("sums")[JOBS[0]].total == 3
    assert [places[JOBS[0]].stat().st_ino] == numbers


def test_a_key_covers_the_function_and_the_fields() -> None:
    assert job_key(added, [1, 2]) == job_key(added, (1, 2))
    assert len({job_key(added, [1, 2]), job_key(added, [2, 1]), job_key(run, [1, 2])}) == 3


@pytest.mark.parametrize(
    "name", ["cloud", "processes:0", "processes:", "processes:two", "http://a"]
)
def test_executors_that_are_not_known_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="--executor: expected local, processes, processes:4, or"):
        check_executor(name)
