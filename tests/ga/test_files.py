"""The door for files of others: what it refuses, and what it puts on record."""

from __future__ import annotations

import hashlib
import os
import signal
from pathlib import Path

import pytest

from motorcade.ga.files import (
    MISSING,
    UNSETTLED,
    EmptyFileError,
    FileError,
    admit_file,
    files_now,
    files_read,
    is_there,
    off_record,
    open_bounded,
    put_on_record,
    read_bounded,
)


def state(data: bytes) -> str:
    return f"{len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "poses.txt"
    path.write_bytes(b"0 0 0 1")
    return path


def test_a_file_is_read_up_to_its_limit(file: Path) -> None:
    assert read_bounded(file, 7) == b"0 0 0 1"
    assert read_bounded(file, 2**50) == b"0 0 0 1"  # no memory is set aside for the limit
    with pytest.raises(FileError, match="at most 6 bytes, got 7"):
        read_bounded(file, 6)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["pipe", "folder"])
def test_what_is_no_file_is_refused_and_never_waited_for(tmp_path: Path, make: object) -> None:
    path = tmp_path / "odd"
    make(path)  # type: ignore[operator]
    with pytest.raises(FileError, match="expected a file, got a folder or a device"):
        admit_file(path, 100)


def test_what_takes_a_files_name_before_it_is_opened_is_refused(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = file.stat()
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    monkeypatch.setattr(Path, "stat", lambda path, **_: before)
    signal.alarm(20)  # opening a pipe waits for who writes
    try:
        for opened in (pipe, Path("/dev/null")):
            with pytest.raises(FileError, match="expected a file, got a folder or a device"):
                read_bounded(opened, 100)
            with (
                pytest.raises(FileError, match="expected a file, got a folder or a device"),
                open_bounded(opened, 100),
            ):
                pass
    finally:
        signal.alarm(0)


def test_devices_missing_and_empty_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="expected a file"):
        read_bounded(Path("/dev/zero"), 100)
    with pytest.raises(FileError, match="missing"):
        read_bounded(tmp_path / "none", 100)
    with pytest.raises(FileError, match="expected the name of a file"):
        read_bounded(tmp_path / "a\0b", 100)
    (tmp_path / "void").touch()
    with pytest.raises(EmptyFileError):
        read_bounded(tmp_path / "void", 100)


def test_all_that_comes_through_is_on_record(file: Path, tmp_path: Path) -> None:
    with files_read() as outer:
        with files_read() as inner, open_bounded(file, 100) as opened:
            opened.read(1)
        with pytest.raises(FileError):
            read_bounded(tmp_path / "none", 100)
    assert inner == {file: state(b"0 0 0 1")}
    assert outer == {**inner, tmp_path / "none": MISSING}


def test_nothing_is_on_record_outside_the_block(file: Path) -> None:
    with files_read() as record:
        pass
    read_bounded(file, 100)
    assert record == {}


def test_what_the_program_made_for_itself_stays_off_the_record(file: Path) -> None:
    with files_read() as record:
        with off_record():
            read_bounded(file, 100)
        assert record == {}
        read_bounded(file, 100)
    assert list(record) == [file]


@pytest.mark.parametrize("read", [read_bounded, admit_file])
def test_a_byte_that_changes_is_seen_whatever_the_clock_says(file: Path, read: object) -> None:
    before = file.stat()
    with files_read() as record:
        read(file, 100)  # type: ignore[operator]
    assert files_now(record) == record == {file: state(b"0 0 0 1")}
    file.write_bytes(b"0 0 0 2")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert files_now(record) == {file: state(b"0 0 0 2")}
    file.write_bytes(b"0 0 0 1")
    assert files_now(record) == record
    file.write_bytes(b"0 0 0 1 ")
    assert files_now(record) != record
    file.unlink()
    assert files_now(record) == {file: MISSING}


def refused_as_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def refused_as_link_in_a_circle(path: Path) -> None:
    path.unlink()
    path.symlink_to(path)


REFUSED = {
    "larger": lambda path: path.write_bytes(b"0 " * 100),
    "missing": Path.unlink,
    "empty": lambda path: path.write_bytes(b""),
    "pipe": refused_as_pipe,
    "circle": refused_as_link_in_a_circle,
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("read", [read_bounded, admit_file])
def test_what_was_refused_is_on_record_until_it_can_be_read(
    file: Path, kind: str, read: object
) -> None:
    REFUSED[kind](file)
    with files_read() as record, pytest.raises(FileError):
        read(file, 100)  # type: ignore[operator]
    assert list(record) == [file]
    assert files_now(record) == record
    file.unlink(missing_ok=True)
    file.write_bytes(b"0 0 0 1")
    assert files_now(record) != record


def test_no_file_is_read_that_has_grown_since(file: Path) -> None:
    with files_read() as record:
        read_bounded(file, 100)
    with file.open("wb") as opened:
        opened.truncate(1 << 42)
    assert files_now(record) == {file: f"{1 << 42} bytes"}


def test_a_file_that_is_looked_for_is_on_record_where_there_is_none(file: Path) -> None:
    with files_read() as record:
        assert is_there(file)
        assert not is_there(file.with_suffix(".md5anim"))
        assert not is_there(file / "below")
        assert not is_there(file.parent / "a\0b")
    assert {path.name for path in record} == {"poses.md5anim", "below", "a\0b"}
    assert files_now(record) == record
    file.with_suffix(".md5anim").write_bytes(b"x")
    assert files_now(record) != record


def test_a_file_that_changes_while_it_is_read_twice_has_no_state(file: Path) -> None:
    with files_read() as record:
        read_bounded(file, 100)
        file.write_bytes(b"0 0 0 2")
        read_bounded(file, 100)
    assert record == {file: UNSETTLED}
    assert files_now(record) != record


def test_a_record_can_be_put_on_another(file: Path) -> None:
    with files_read() as record:
        put_on_record({file: state(b"0 0 0 1")})
    assert record == {file: state(b"0 0 0 1")}
    put_on_record(record)
    with files_read() as other:
        put_on_record(record)
        file.write_bytes(b"0 0 0 2")
        read_bounded(file, 100)
    assert other == {file: UNSETTLED}
