"""Runs in several containers share a cache: neither takes the other's for a dead one's."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.end_to_end.shared_storage import CONTAINER, can_contain

STAGES = """
import sys, time
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from motorcade.replays.engine import store
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.engine.graph import Graph

cache, waits_for = Path(sys.argv[1]), sys.argv[2:]


@dataclass(frozen=True)
class Text:
    content: str

    def digest(self):
        return self.content


@dataclass(frozen=True)
class Film:
    path: Path


def film(text: Text) -> Film:
    path = new_file("film.bin")
    path.write_bytes(b"first half, ")
    if waits_for:
        print("half", flush=True)
        while not Path(*waits_for).exists():
            time.sleep(0.01)
    with path.open("ab") as file:
        file.write(b"second half")
    return Film(path)


with mock.patch.object(store, "code_digest", return_value="the same code"):
    made = Graph([film], {"text": Text}).run("film", {"text": Text("a")}, cache)
print(made.outputs["film"].path.read_text())
"""


def started(*arguments: object) -> subprocess.Popen[str]:
    """The run, in a container in which it is process 1."""
    return subprocess.Popen(
        [*CONTAINER, sys.executable, "-c", STAGES, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"),
    )


needs_containers = pytest.mark.skipif(not can_contain(), reason="no PID namespaces are permitted")


@needs_containers
def test_a_run_in_one_container_leaves_alone_what_another_is_building(tmp_path: Path) -> None:
    cache, go = tmp_path / "cache", tmp_path / "go"
    slow = started(cache, go)
    assert slow.stdout is not None
    assert slow.stdout.readline() == "half\n"
    quick = started(cache)
    assert quick.communicate(timeout=60)[0] == "first half, second half\n"
    shutil.rmtree(next(cache.glob("film-*")))
    go.touch()
    told, complaint = slow.communicate(timeout=60)
    assert told == "first half, second half\n", complaint[-2000:]
    assert not list(cache.glob(".*"))


@needs_containers
def test_what_a_killed_container_left_is_removed_by_the_next(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    doomed = started(cache, tmp_path / "never")
    assert doomed.stdout is not None
    assert doomed.stdout.readline() == "half\n"
    (inner,) = Path(f"/proc/{doomed.pid}/task/{doomed.pid}/children").read_text().split()
    os.kill(int(inner), 9)
    doomed.communicate(timeout=60)
    assert len(list(cache.glob(".*"))) == 1
    assert started(cache).communicate(timeout=60)[0] == "first half, second half\n"
    assert not list(cache.glob(".*"))


FULL = """
import os, subprocess, sys
from pathlib import Path
from motorcade.replays.io.files import write_bytes
from tests.replays.engine import test_cache_laws as laws

disk = Path(sys.argv[1])
subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "none", disk], check=True)
expected = laws.without_cache("abba", None, 2.0)
write_bytes(disk / "path.tum", b"earlier")
page = os.sysconf("SC_PAGE_SIZE")
for pages in range(0, 31, 2):
    with (disk / "filler").open("wb") as filler:
        filler.truncate(0)
        os.posix_fallocate(filler.fileno(), 0, 128 * 1024 - (pages + 1) * page)
    for attempt in (
        lambda: write_bytes(disk / "path.tum", b"later" * 2000),
        lambda: laws.run(disk / "cache", "abba", None, 2.0) == expected or 1 / 0,
    ):
        try:
            attempt()
            print("done")
        except OSError as told:
            print(str(told).replace(str(disk), "DISK"))
    left = [path.name for path in disk.rglob(".*")]
    assert not left, left
    assert (disk / "path.tum").read_bytes() in (b"earlier", b"later" * 2000)
"""


@needs_containers
def test_a_full_disk_is_told_in_one_line_and_leaves_what_was_there(tmp_path: Path) -> None:
    done = subprocess.run(
        [*CONTAINER, sys.executable, "-c", FULL, tmp_path],
        cwd=Path(__file__).parents[3],
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    written, run = done.stdout.splitlines()[::2], done.stdout.splitlines()[1::2]
    for lines in (written, run):
        assert lines[-1] == "done"
        full = [line for line in lines if line != "done"]
        assert full
        assert all("No space left on device: 'DISK" in line for line in full), full
