"""Runs in several containers share a cache: neither takes the other's for a dead one's."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CONTAINER = ["unshare", "--user", "--map-root-user", "--pid", "--fork", "--mount-proc"]

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


def contained() -> bool:
    """Whether containers may be made here."""
    if shutil.which("unshare") is None:
        return False
    return subprocess.run([*CONTAINER, "true"], capture_output=True, check=False).returncode == 0


def started(*arguments: object) -> subprocess.Popen[str]:
    """The run, in a container in which it is process 1."""
    return subprocess.Popen(
        [*CONTAINER, sys.executable, "-c", STAGES, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"),
    )


needs_containers = pytest.mark.skipif(not contained(), reason="no PID namespaces are permitted")


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
