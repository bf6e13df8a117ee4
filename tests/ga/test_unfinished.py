"""Places to build in: a living builder keeps its own, a dead one's are removed."""

import errno
import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from motorcade.ga import unfinished as module
from motorcade.ga.unfinished import locked, remove_unfinished, unfinished

DEAD = 4_194_999
"""A number that no process has."""
LOCAL = "30 1 8:1 / / rw - ext4 /dev/sda1 rw\n"
OTHER_HOST = {"host": "other", "boot": "5e1f"}
OTHER_CONTAINER = {"host": "other", "pid_namespace": 1}


def left(folder: Path, **mark: object) -> Path:
    """What a process of this container left that is dead by now, but for what `mark` says."""
    with unfinished(folder) as place:
        own = json.loads((place / "mark").read_text())
    place.mkdir()
    (place / "lock").touch()
    (place / "mark").write_text(json.dumps(own | {"process": DEAD} | mark))
    (place / "film.mp4").write_bytes(b"half of it")
    return place


@contextmanager
def held(place: Path) -> Iterator[None]:
    with (place / "lock").open("r+b") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def without_locks(file: int, operation: int) -> None:
    raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))


def test_a_place_is_its_builders_alone_and_gone_at_the_end(tmp_path: Path) -> None:
    with unfinished(tmp_path / "new") as one, unfinished(tmp_path / "new") as other:
        assert one != other
        (one / "film").write_bytes(b"film")
        (one / "film").rename(tmp_path / "film")
        (other / "left").mkdir()
        remove_unfinished(tmp_path / "new")
        assert one.exists()
        assert (other / "left").exists()
    assert list((tmp_path / "new").iterdir()) == []
    assert (tmp_path / "film").read_bytes() == b"film"


def test_a_place_is_gone_where_its_builder_fails(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), unfinished(tmp_path):
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_takes_nothing_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"Not a directory: '.*/file'"), unfinished(tmp_path / "file"):
        raise AssertionError


def test_a_place_that_cannot_be_marked_is_not_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, text: str) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr(Path, "write_text", full)
    folder = tmp_path / "results"
    with pytest.raises(OSError, match=r"No space left on device: '.*/results'"), unfinished(folder):
        raise AssertionError
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("of", [{}, OTHER_CONTAINER, OTHER_HOST], ids=["us", "container", "host"])
@pytest.mark.parametrize("process", [DEAD, 1])
def test_the_lock_says_whether_a_builder_lives_and_its_number_does_not(
    of: dict[str, object], process: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mounts").write_text(LOCAL)
    monkeypatch.setattr(module, "MOUNTS", tmp_path / "mounts")
    place = left(tmp_path, **of, process=process)
    with held(place):
        remove_unfinished(tmp_path)
        assert (place / "film.mp4").exists()
    remove_unfinished(tmp_path)
    assert not place.exists()


@pytest.mark.parametrize(
    ("of", "process", "removed"),
    [
        ({}, DEAD, True),
        ({}, os.getpid(), False),
        (OTHER_CONTAINER, DEAD, False),
        (OTHER_HOST, DEAD, False),
        ({"boot": None}, DEAD, False),
    ],
    ids=["dead", "alive", "container", "host", "boot unknown"],
)
@pytest.mark.parametrize("later", [True, False])
def test_without_locks_only_a_dead_process_of_ours_is_gone(
    of: dict[str, object],
    process: int,
    removed: bool,
    later: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Neither where the file system has none now, nor where its builder got none."""
    if not later:
        monkeypatch.setattr(fcntl, "flock", without_locks)
    place = left(tmp_path, **of, process=process, locked=later)
    monkeypatch.setattr(fcntl, "flock", without_locks if later else fcntl.flock)
    remove_unfinished(tmp_path)
    assert place.exists() != removed


def test_without_locks_another_users_process_lives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def not_ours(process: int, signal: int) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "kill", not_ours)
    place = left(tmp_path, locked=False)
    remove_unfinished(tmp_path)
    assert place.exists()


def test_a_builder_without_locks_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fcntl, "flock", without_locks)
    with unfinished(tmp_path) as place:
        assert not json.loads((place / "mark").read_text())["locked"]
        monkeypatch.undo()
        remove_unfinished(tmp_path)
        assert place.exists()


@pytest.mark.parametrize(
    ("mount", "removed"),
    [
        ("nfs4 server:/data rw,vers=4.2,local_lock=none", True),
        ("nfs server:/data rw,vers=3,local_lock=all", False),
        ("nfs server:/data rw,vers=3,nolock", False),
        ("lustre mgs:/data rw,localflock", False),
        ("fuse.sshfs host: rw,user_id=0", False),
        ("9p share rw,trans=virtio", False),
    ],
)
def test_another_hosts_free_lock_counts_where_hosts_see_each_others(
    mount: str,
    removed: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    shared = tmp_path / "shared disk"
    elsewhere = "33 30 0:32 / /elsewhere rw - ext4 /dev/sdb1 rw\n"
    point = str(shared.resolve()).replace(" ", r"\040")
    (tmp_path / "mounts").write_text(f"{LOCAL}31 30 0:31 / {point} rw - {mount}\n{elsewhere}")
    monkeypatch.setattr(module, "MOUNTS", tmp_path / "mounts")
    theirs, ours = left(shared, **OTHER_HOST), left(shared, **OTHER_CONTAINER)
    remove_unfinished(shared)
    assert theirs.exists() != removed
    assert not ours.exists()  # of this boot: one kernel keeps the lock
    assert ("process 4194999 of 'other', which may still run" in caplog.text) != removed


HOSTILE = [
    b"[" * 4000,
    b'{"host": "' + b"a" * 9000 + b'"}',
    b'{"host": "a", "boot": null, "pid_namespace": 1e999, "process": 1, "locked": true}',
    b'{"host": "a", "boot": null, "pid_namespace": {}, "process": [], "locked": true}',
]


@pytest.mark.parametrize("mark", [None, *HOSTILE, b"", b'{"host": "a"', b"[]", b'{"host": "a"}'])
def test_a_place_without_a_mark_stays_while_its_builder_may_be_beginning(
    mark: bytes | None, tmp_path: Path
) -> None:
    place = left(tmp_path)
    (place / "mark").unlink()
    if mark is not None:
        (place / "mark").write_bytes(mark)
    with locked(tmp_path):
        remove_unfinished(tmp_path)
        assert place.exists()
        long_ago = time.time() - 2 * module.MARKED_WITHIN_S
        os.utime(place, (long_ago, long_ago))
        with held(place):
            remove_unfinished(tmp_path)
            assert place.exists()
        remove_unfinished(tmp_path)
    assert not place.exists()


@pytest.mark.parametrize("lost", [["mark"], ["lock", "mark"]])
def test_a_place_that_its_builder_was_killed_in_the_middle_of_is_removed(
    lost: list[str], tmp_path: Path
) -> None:
    place = left(tmp_path)
    for name in lost:
        (place / name).unlink()
    if lost == ["mark"]:
        with held(place):
            remove_unfinished(tmp_path)
            assert place.exists()
    remove_unfinished(tmp_path)
    assert not place.exists()


def test_folders_whose_locks_other_hosts_do_not_see_keep_a_place_without_a_mark(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mounts").write_text("31 30 0:31 / / rw - nfs server:/data rw,vers=3,nolock\n")
    monkeypatch.setattr(module, "MOUNTS", tmp_path / "mounts")
    place = left(tmp_path)
    (place / "mark").unlink()
    remove_unfinished(tmp_path)
    assert place.exists()


@pytest.mark.parametrize("name", ["mark", "lock"])
def test_pipes_and_links_in_a_place_neither_hang_nor_lead_elsewhere(
    name: str, tmp_path: Path
) -> None:
    place, kept = left(tmp_path), tmp_path / "kept"
    (place / name).unlink()
    os.mkfifo(place / name)
    remove_unfinished(tmp_path)
    linked = left(tmp_path)
    (linked / name).rename(kept)
    (linked / name).symlink_to(kept)
    remove_unfinished(tmp_path)
    assert kept.exists()
    assert linked.exists() == (name == "lock")


def test_the_first_who_builds_in_a_folder_removes_what_the_dead_left(tmp_path: Path) -> None:
    place = left(tmp_path / "earlier").rename(tmp_path / ".unfinished-0123456789abcdef")
    with unfinished(tmp_path):
        assert not place.exists()


def test_nothing_of_another_name_is_removed(tmp_path: Path) -> None:
    place = left(tmp_path / "elsewhere")
    for name in ("film", ".workspace.1", ".unfinished-1", f"{place.name}.txt", place.name[1:]):
        (tmp_path / name).mkdir()
    (tmp_path / place.name).symlink_to(place)
    before = sorted(tmp_path.iterdir())
    remove_unfinished(tmp_path)
    assert sorted(tmp_path.iterdir()) == before
    assert (place / "film.mp4").exists()
    remove_unfinished(tmp_path / "nowhere")


KILLED = """
import os, signal, sys
from pathlib import Path
from motorcade.ga.unfinished import unfinished

left = int(sys.argv[2])

def killed(event, given):
    global left
    if given and any(name in str(given[0]) for name in (".unfinished-", "lock", "mark")):
        left -= 1
        if left < 0:
            os.kill(os.getpid(), signal.SIGKILL)

sys.addaudithook(killed)
with unfinished(Path(sys.argv[1])):
    pass
"""


def test_a_builder_that_is_killed_at_any_step_leaves_nothing_for_long(tmp_path: Path) -> None:
    """What it leaves is removed by whoever builds next."""
    left_something = 0
    for step in range(100):
        folder = tmp_path / str(step)
        killed = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(step)], check=False)
        if killed.returncode == 0:
            break
        assert killed.returncode == -signal.SIGKILL
        left_something += folder.exists() and any(folder.iterdir())
        with unfinished(folder):
            assert len(list(folder.iterdir())) == 1, step
        assert list(folder.iterdir()) == [], step
    assert step > left_something >= 5


BUILDER = """
import subprocess, sys, time
from pathlib import Path
from motorcade.ga.unfinished import unfinished

with unfinished(Path(sys.argv[1])):
    waiting = [sys.executable, "-c", "import sys; sys.stdin.read()"]
    helper = subprocess.Popen(waiting, stdin=subprocess.PIPE)
    print(helper.pid, flush=True)
    time.sleep(600)
"""


def test_what_a_killed_process_leaves_is_removed_even_while_a_helper_of_it_lives(
    tmp_path: Path,
) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", BUILDER, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as builder:
        assert builder.stdout is not None
        assert int(builder.stdout.readline()) > 0
        remove_unfinished(tmp_path)
        assert len(list(tmp_path.iterdir())) == 1
        builder.kill()
    remove_unfinished(tmp_path)
    assert list(tmp_path.iterdir()) == []
