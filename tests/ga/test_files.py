"""The door for files of others: what it refuses, and what it puts on record."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from motorcade.ga.files import (
    MISSING,
    EmptyFileError,
    FileError,
    admit_file,
    files_read,
    off_record,
    open_bounded,
    read_bounded,
)


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "poses.txt"
    path.write_bytes(b"0 0 0 1")
    return path


def test_a_file_is_read_up_to_its_limit(file: Path) -> None:
    assert read_bounded(file, 7) == b"0 0 0 1"
    with pytest.raises(FileError, match="at most 6 bytes, got 7"):
        read_bounded(file, 6)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["pipe", "folder"])
def test_what_is_no_file_is_refused_and_never_waited_for(tmp_path: Path, make: object) -> None:
    path = tmp_path / "odd"
    make(path)  # type: ignore[operator]
    with pytest.raises(FileError, match="expected a file, got a folder or a device"):
        admit_file(path, 100)


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
    assert inner == {file: sha256(b"0 0 0 1")}
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
