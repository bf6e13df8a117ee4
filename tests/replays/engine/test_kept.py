"""What was made of files holds for as long as they are as they were read, and no longer."""

import errno
import fcntl
import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from motorcade.ga import unfinished as locks_module
from motorcade.ga.files import MISSING, files_read, is_there, off_record, read_bounded
from motorcade.replays.engine import jobs as jobs_module
from motorcade.replays.engine import store as engine
from motorcade.replays.engine.artifacts import Stored
from motorcade.replays.engine.graph import Graph, GraphRun
from motorcade.replays.engine.jobs import Batch, run_jobs

calls: list[str] = []


@dataclass(frozen=True)
class Place:
    """A source that reads a file of its own, which its digest covers."""

    folder: Path

    def digest(self) -> str:
        return read_bounded(self.folder / "source.txt", 100).decode()

    def image(self) -> str:
        with off_record():
            return read_bounded(self.folder / "source.txt", 100).decode()


@dataclass(frozen=True)
class Words:
    text: str


def told(place: Place, *, script: Path = Path("nobody")) -> Words:
    """The words of a script; one that begins with @ names a file beside it, if that is there."""
    calls.append("told")
    if not is_there(script):
        return Words(f"{place.image()}: silence")
    lines = []
    for line in read_bounded(script, 1000).decode().split():
        beside = script.with_name(line[1:])
        if line.startswith("@"):
            line = read_bounded(beside, 1000).decode() if is_there(beside) else "..."
        lines.append(line)
    return Words(" ".join(lines))


def louder(told: Words) -> Words:
    calls.append("louder")
    return Words(told.text.upper())


def counted(place: Place) -> Words:
    calls.append("counted")
    return Words(str(len(place.image())))


def joined(louder: Words, counted: Words) -> Words:
    calls.append("joined")
    return Words(f"{louder.text} {counted.text}")


@pytest.fixture(autouse=True)
def _forget_calls() -> None:
    calls.clear()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "source.txt").write_text("here")
    (tmp_path / "script.txt").write_text("to be @verb")
    (tmp_path / "verb").write_text("or")
    return tmp_path


def run(folder: Path, script: Path | None = None) -> str:
    graph = Graph([told, louder, counted, joined], {"place": Place})
    knobs = {"told": {"script": script or folder / "script.txt"}}
    run: GraphRun = graph.run("joined", {"place": Place(folder)}, folder / "cache", knobs)
    return str(run.outputs["joined"].text)


def change(folder: Path, name: str, text: str) -> None:
    (folder / name).write_text(text)


def test_a_changed_file_recomputes_its_stage_and_what_follows_from_it(folder: Path) -> None:
    assert run(folder) == "TO BE OR 4"
    calls.clear()
    change(folder, "verb", "OR")
    assert run(folder) == "TO BE OR 4"
    assert calls == ["told", "louder"]  # as that gave what it gave before
    calls.clear()
    change(folder, "verb", "and")
    assert run(folder) == "TO BE AND 4"
    assert calls == ["told", "louder", "joined"]


def test_files_that_change_back_lead_back_to_what_was_made_of_them(folder: Path) -> None:
    states = [("script.txt", "to be @verb"), ("script.txt", "@verb"), ("verb", "nor")]
    expected = []
    for name, text in states:
        change(folder, name, text)
        expected.append(run(folder))
    assert expected == ["TO BE OR 4", "OR 4", "NOR 4"]
    calls.clear()
    change(folder, "verb", "or")
    assert run(folder) == "OR 4"
    change(folder, "script.txt", "to be @verb")
    assert run(folder) == "TO BE OR 4"
    assert calls == []


def test_a_file_that_was_looked_for_and_appears_later_counts(folder: Path) -> None:
    (folder / "verb").unlink()
    assert run(folder) == "TO BE ... 4"
    change(folder, "verb", "")
    change(folder, "verb", "has")
    assert run(folder) == "TO BE HAS 4"
    (folder / "verb").unlink()
    calls.clear()
    assert run(folder) == "TO BE ... 4"
    assert calls == []


def test_what_a_source_reads_is_covered_by_its_digest_alone(folder: Path) -> None:
    graph = Graph([counted], {"place": Place})
    with files_read() as record:
        found = graph.run("counted", {"place": Place(folder)}, folder / "cache")
    assert (record, found.records[0].files) == ({}, {})
    run(folder)
    calls.clear()
    change(folder, "source.txt", "there")
    assert run(folder) == "TO BE OR 5"
    assert calls == ["told", "counted", "joined"]


def test_a_knob_s_file_is_meant_from_wherever_the_run_stands(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in (("one", "i"), ("two", "ii")):
        (folder / name).mkdir()
        change(folder / name, "script.txt", "@part")
        change(folder / name, "part", text)
    for name, text in (("one", "I 4"), ("two", "II 4"), ("one", "I 4")):
        monkeypatch.chdir(folder / name)
        assert run(folder, Path("script.txt")) == text
    assert calls.count("told") == 2


def test_what_is_taken_from_the_cache_is_on_record_as_if_it_were_read(folder: Path) -> None:
    with files_read() as first:
        run(folder)
    with files_read() as again:
        run(folder)
    assert calls == ["told", "louder", "counted", "joined"]
    assert {path.name for path in first} == {"script.txt", "verb"}
    assert again == first


def test_a_file_that_changes_while_it_is_read_is_never_taken_for_known(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def restless(place: Place, *, script: Path = folder / "verb") -> Words:
        calls.append("restless")
        first = read_bounded(script, 100).decode()
        script.write_text(first + "!")
        return Words(first + read_bounded(script, 100).decode())

    monkeypatch.setattr(engine, "code_digest", lambda function, given: "the same code")
    graph = Graph([restless], {"place": Place})
    for expected in ("oror!", "or!or!!", "or!!or!!!"):
        found = graph.run("restless", {"place": Place(folder)}, folder / "cache")
        assert found.outputs["restless"].text == expected
    assert len(list((folder / "cache").iterdir())) == 1


def test_the_faster_of_two_runs_does_not_lend_what_it_made_of_other_files(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = engine.artifacts.write_artifact

    def overtaken(value: object, place: Path, seconds: float, files: dict[Path, str]) -> object:
        if place.name.startswith("told"):
            monkeypatch.setattr(engine.artifacts, "write_artifact", write)
            write(Words("another's"), place, seconds, {folder / "verb": MISSING})
        return write(value, place, seconds, files)

    monkeypatch.setattr(engine.artifacts, "write_artifact", overtaken)
    assert run(folder) == "TO BE OR 4"
    assert run(folder) == "TO BE OR 4"
    assert calls.count("told") == 2  # once in vain


def test_a_cache_that_is_flipped_between_two_files_grows_by_no_more_than_both(folder: Path) -> None:
    for _ in range(4):
        for text in ("or", "and"):
            change(folder, "verb", text)
            run(folder)
    assert calls.count("told") == 2
    assert len(list((folder / "cache").glob("told-*"))) == 2


@dataclass(frozen=True)
class Letter:
    path: Path


def read_letter(job: Letter) -> Words:
    calls.append(job.path.name)
    return Words(read_bounded(job.path, 100).decode())


def test_jobs_are_done_again_whose_files_have_changed(tmp_path: Path) -> None:
    jobs = {Letter(tmp_path / name): tmp_path / f"{name}.done" for name in "abc"}
    for job in jobs:
        job.path.write_text(job.path.name)

    def done() -> Batch[Letter, Words]:
        calls.clear()
        return run_jobs(read_letter, jobs, "local", "letters")

    assert done().done_before == 0
    assert done().done_before == 3
    before = (tmp_path / "b").stat()
    (tmp_path / "b").write_text("B")
    os.utime(tmp_path / "b", ns=(before.st_atime_ns, before.st_mtime_ns))
    batch = done()
    assert (calls, batch.done_before) == (["b"], 2)
    assert [one.text for one in batch.whole("letters").values()] == ["a", "B", "c"]
    (tmp_path / "c").unlink()
    batch = done()
    assert batch.failures == {Letter(tmp_path / "c"): f"{tmp_path / 'c'}: the file is missing"}
    assert len(batch.results) == 2


def letter_jobs(folder: Path) -> dict[Letter, Path]:
    """One job whose result is kept, of a file that has changed since."""
    job = {Letter(folder / "letter"): folder / "letter.done"}
    (folder / "letter").write_text("old")
    run_jobs(read_letter, job, "local", "letters")
    (folder / "letter").write_text("changed")
    return job


@pytest.mark.parametrize("locks", [True, False])
def test_two_runs_that_replace_the_same_stale_result_agree_on_one(
    locks: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The slower one saw the old result, and must not take away what the faster put there."""
    jobs = letter_jobs(tmp_path)
    found = jobs_module.find_artifact
    seen = []

    def overtaken(folder: Path) -> Stored | None:
        stored = found(folder)
        if len(calls) == 2:  # the job is done, but not its result stored
            monkeypatch.setattr(jobs_module, "find_artifact", found)
            run_jobs(read_letter, jobs, "local", "letters")
            seen.append(folder.stat().st_ino)
        return stored

    if not locks:
        monkeypatch.setattr(fcntl, "flock", refuse_to_lock)
    monkeypatch.setattr(jobs_module, "find_artifact", overtaken)
    batch = run_jobs(read_letter, jobs, "local", "letters")
    assert [one.text for one in batch.whole("letters").values()] == ["changed"]
    assert [folder.stat().st_ino for folder in jobs.values()] == seen


def refuse_to_lock(file: int, kind: int) -> None:
    raise OSError(errno.ENOLCK, "No locks available")


def test_a_stale_result_is_replaced_where_someone_keeps_the_folder_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(locks_module, "WAIT_S", 0.05)
    jobs = letter_jobs(tmp_path)
    folder = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(folder, fcntl.LOCK_EX)
    batch = run_jobs(read_letter, jobs, "local", "letters")
    os.close(folder)
    assert [one.text for one in batch.whole("letters").values()] == ["changed"]
