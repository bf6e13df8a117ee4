"""Whatever befalls the cache: a run gives what a run without a cache gives, or one clear line.

A machine of random steps runs a small graph with knobs, other sources and other code, and in
between flips bits, cuts, deletes and misplaces files, sets clocks, leaves what killed runs leave,
and has the disk refuse. Its witness calls the stages as plain functions.
"""

import contextlib
import errno
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from motorcade.ga.unfinished import unfinished
from motorcade.replays.engine import artifacts
from motorcade.replays.engine import store as engine
from motorcade.replays.engine.graph import Graph
from motorcade.replays.stages.values.camera_poses import ASIDE

REFUSALS = [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EDQUOT, errno.EIO]
WRITES = [
    (Path, "mkdir"),
    (Path, "write_text"),
    (Path, "rename"),
    (os, "fsync"),
    (np, "savez"),
    (shutil, "move"),
    (tempfile, "mkdtemp"),
]


@dataclass(frozen=True)
class Words:
    content: str

    def digest(self) -> str:
        return f"words {self.content}"


@dataclass(frozen=True)
class Counted:
    letters: dict[str, int]
    note: str | None
    seconds: float = field(default=0.0, metadata=ASIDE)


@dataclass(frozen=True)
class Drawn:
    heights: np.ndarray
    film: Path
    parts: tuple[Counted, ...]


code = 0
# Not hypothesis' own: what is drawn would depend on sizes of files, which hold times.
CHANCE = st.integers(0, 2**32 - 1).map(Random)


def counted(words: Words, *, only: str | None = None) -> Counted:
    kept = [letter for letter in words.content if only is None or letter in only]
    return Counted({letter: kept.count(letter) + code for letter in set(kept)}, only, 2.5)


def drawn(counted: Counted, *, factor: float = 1.0) -> Drawn:
    heights = factor * np.array([counted.letters[key] for key in sorted(counted.letters)], float)
    film = artifacts.new_file("film.bin")
    film.write_bytes(heights.tobytes() * 3)
    return Drawn(heights, film, (counted, counted))


def joined(counted: Counted, drawn: Drawn) -> Counted:
    total = int(drawn.heights.sum()) + len(drawn.film.read_bytes()) + len(drawn.parts)
    return Counted(counted.letters | {"total": total}, None)


def facts(outputs: Any) -> Any:
    """All that a run gave, in comparable form."""
    one = outputs["drawn"]
    return (
        outputs["counted"],
        outputs["joined"],
        one.parts,
        one.heights.tolist(),
        one.film.read_bytes(),
    )


def run(cache: Path, words: str, only: str | None, factor: float) -> Any:
    graph = Graph([joined, drawn, counted], {"words": Words})
    knobs = {"counted": {"only": only}, "drawn": {"factor": factor}}
    with mock.patch.object(engine, "code_digest", return_value=f"code {code}"):
        return facts(graph.run("joined", {"words": Words(words)}, cache, knobs).outputs)


def without_cache(words: str, only: str | None, factor: float) -> Any:
    first = counted(Words(words), only=only)
    second = drawn(first, factor=factor)
    return facts({"counted": first, "drawn": second, "joined": joined(first, second)})


@contextlib.contextmanager
def refusing(number: int, why: int) -> Iterator[None]:
    """Within the block every write from the `number`th on fails."""
    left = [number]

    def failing(real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **options: Any) -> Any:
            left[0] -= 1
            if left[0] < 0:
                raise OSError(why, os.strerror(why))
            return real(*args, **options)

        return call

    with contextlib.ExitStack() as stack:
        for place, name in WRITES:
            stack.enter_context(mock.patch.object(place, name, failing(getattr(place, name))))
        yield


class Cache(RuleBasedStateMachine):
    """Runs and mishaps in any order."""

    @initialize()
    def begin(self) -> None:
        global code
        code = 0
        self.folder = Path(tempfile.mkdtemp())
        self.cache = self.folder / "cache"
        self.quick = mock.patch.object(os, "fsync", return_value=None)  # no power fails here
        self.quick.start()

    def teardown(self) -> None:
        self.quick.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def files(self) -> list[Path]:
        return sorted(path for path in self.folder.rglob("*") if path.is_file())

    def artifacts(self) -> list[Path]:
        return [path for path in sorted(self.cache.glob("[a-z]*-*")) if path.is_dir()]

    @rule(
        words=st.sampled_from(["abba", "motor"]),
        only=st.sampled_from([None, "ab"]),
        factor=st.sampled_from([1.0, 2.0]),
    )
    def runs(self, words: str, only: str | None, factor: float) -> None:
        assert run(self.cache, words, only, factor) == without_cache(words, only, factor)

    @rule(number=st.integers(0, 45), why=st.sampled_from(REFUSALS), factor=st.floats(3.0, 9.0))
    def runs_while_nothing_can_be_written(self, number: int, why: int, factor: float) -> None:
        expected = without_cache("abba", None, factor)
        with refusing(number, why):
            try:
                found = run(self.cache, "abba", None, factor)
            except OSError as fault:
                found, told = expected, str(fault)
            else:
                told = os.strerror(why)
        assert found == expected
        assert os.strerror(why) in told
        assert "\n" not in told
        assert run(self.cache, "abba", None, factor) == expected

    @rule(which=CHANCE)
    def flips_a_bit(self, which: Random) -> None:
        if files := self.files():
            path = which.choice(files)
            data = bytearray(path.read_bytes())
            if data:
                data[which.randrange(len(data))] ^= 1 << which.randrange(8)
                path.write_bytes(data)

    @rule(which=CHANCE)
    def cuts_or_grows_a_file(self, which: Random) -> None:
        if files := self.files():
            path = which.choice(files)
            data = path.read_bytes()
            path.write_bytes(which.choice([data[: which.randrange(len(data) + 1)], data + b"\0"]))

    @rule(which=CHANCE)
    def deletes_a_file(self, which: Random) -> None:
        if files := self.files():
            which.choice(files).unlink()

    @rule(which=CHANCE)
    def sets_one_artifact_in_the_place_of_another(self, which: Random) -> None:
        if len(found := self.artifacts()) > 1:
            one, other = which.sample(found, 2)
            shutil.rmtree(other)
            shutil.copytree(one, other)

    @rule(which=CHANCE)
    def puts_a_file_where_an_artifact_was(self, which: Random) -> None:
        if found := self.artifacts():
            place = which.choice(found)
            shutil.rmtree(place)
            place.write_text("nothing")

    @rule(which=CHANCE, at=st.sampled_from([0, 2**31 - 1, 2**33]))
    def sets_the_clock(self, which: Random, at: int) -> None:
        for path in self.files():
            if which.random() < 0.5:
                os.utime(path, (at, at))

    @rule(which=CHANCE)
    def leaves_what_a_killed_run_leaves(self, which: Random) -> None:
        if found := self.artifacts():
            whole = which.choice(found)
            with unfinished(self.cache) as place:
                head, dash, drawn = place.name.partition("-")  # of another name each time
                dead = place.with_name(head + dash + drawn[::-1])
                shutil.copytree(place, dead)
            shutil.copytree(whole, dead / "artifact")
            for path in sorted((dead / "artifact").rglob("*"))[::2]:
                if path.is_file():
                    path.unlink()

    @rule()
    def other_code_takes_over(self) -> None:
        global code
        code += 1


Cache.TestCase.settings = settings(
    max_examples=20, stateful_step_count=15, deadline=None, phases=[Phase.reuse, Phase.generate]
)
TestAnyOrder = Cache.TestCase


def test_every_byte_of_an_artifact_counts(tmp_path: Path) -> None:
    """Bit by bit through all files: a damaged one is never taken for what was written."""
    expected = run(tmp_path / "cache", "abba", None, 2.0)
    kept = tmp_path / "kept"
    shutil.copytree(tmp_path / "cache", kept)
    rng = np.random.default_rng(4)
    for path in sorted(path for path in kept.rglob("*") if path.is_file()):
        data = path.read_bytes()
        for place in rng.choice(len(data), min(12, len(data)), replace=False):
            shutil.rmtree(tmp_path / "cache")
            shutil.copytree(kept, tmp_path / "cache")
            broken = bytearray(data)
            broken[place] ^= 1 << int(rng.integers(8))
            (tmp_path / "cache" / path.relative_to(kept)).write_bytes(broken)
            stage = tmp_path / "cache" / path.relative_to(kept).parts[0]
            assert artifacts.find_artifact(stage) is None, f"{path.name}, byte {place}"
            assert run(tmp_path / "cache", "abba", None, 2.0) == expected


TOGETHER = """
import sys
from pathlib import Path
import numpy as np
from tests.replays.engine import test_cache_laws as laws

cache, seed = Path(sys.argv[1]), int(sys.argv[2])
rng = np.random.default_rng(seed)
for _ in range(25):
    given = ("abba", None, float(rng.integers(1, 6)))
    assert laws.run(cache, *given) == laws.without_cache(*given), given
print("all well")
"""
LIMITED = """
import resource, sys
from pathlib import Path
from tests.replays.engine import test_cache_laws as laws

cache = Path(sys.argv[1])
expected = laws.without_cache("abba", None, 2.0)
for limit in (0, 1, 60, 130, 300, 700, 1500, 10**6):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        assert laws.run(cache, "abba", None, 2.0) == expected
        ended = "whole"
    except OSError as told:
        ended = str(told)
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
    print(limit, ended)
"""


def started(script: str, *arguments: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", script, *map(str, arguments)],
        cwd=Path(__file__).parents[3],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"),
    )


def test_runs_at_the_same_time_share_a_cache_that_was_damaged(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    for factor in range(1, 6):
        run(cache, "abba", None, float(factor))
    for path in sorted(cache.rglob("value.json")):
        path.write_text(path.read_text().replace("1", "2"))
    processes = [started(TOGETHER, cache, seed) for seed in range(3)]
    for process in processes:
        told, complaint = process.communicate(timeout=240)
        assert told == "all well\n", complaint[-2000:]
    assert not list(cache.glob(".*"))


@pytest.mark.skipif(sys.platform == "win32", reason="has no limit of file sizes")
def test_a_disk_that_takes_no_more_is_told_in_one_line(tmp_path: Path) -> None:
    told, complaint = started(LIMITED, tmp_path / "cache").communicate(timeout=240)
    lines = told.splitlines()
    assert len(lines) == 8, complaint[-2000:]
    assert lines[-1] == "1000000 whole"
    for line in lines[:3]:
        assert "File too large" in line, line
        assert any(name in line for name in ("cannot be written", "film.bin", "/cache'")), line
