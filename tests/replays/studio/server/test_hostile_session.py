"""Sessions in folders that others made, on disks that are full, and with files edited by hand."""

import json
import os
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.replays.studio.server.stage import Visitor, desk

OTHERS = "not yours\nand no end of line"


def begun(folder: Path) -> Path:
    """A session of one step; its gestures."""
    at = desk(folder)
    Visitor(at).put()
    at.close()
    return folder / "scene.session" / "gestures.jsonl"


@contextmanager
def files_of_at_most(size: int) -> Iterator[None]:
    """A disk that is full: a file takes so many bytes, and a part of what goes beyond."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    heard = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, heard)


@pytest.mark.parametrize("whole", [False, True])
def test_no_link_leads_what_is_written_out_of_the_session(tmp_path: Path, whole: bool) -> None:
    run = tmp_path / "run"
    run.mkdir()
    gestures, victim = begun(run), tmp_path / "victim"
    told = gestures.read_text() if whole else OTHERS
    victim.write_text(told)
    gestures.unlink()
    gestures.symlink_to(victim)
    if whole:
        one = Visitor(desk(run))
        assert not one.ask("place", file="mannequin")["ok"]
    else:
        with pytest.raises(OSError, match="gestures"):
            desk(run)
    assert victim.read_text() == told


def test_no_link_and_no_pipe_is_a_session(tmp_path: Path) -> None:
    elsewhere, run, piped = (tmp_path / name for name in ("elsewhere", "run", "piped"))
    for folder in (elsewhere, run, piped):
        folder.mkdir()
    begun(elsewhere)
    (run / "scene.json").write_bytes((elsewhere / "scene.json").read_bytes())
    (run / "scene.session").symlink_to(elsewhere / "scene.session")
    with pytest.raises(OSError, match="a link"):
        desk(run)
    gestures = begun(piped)
    gestures.unlink()
    os.mkfifo(gestures)
    one = Visitor(desk(piped))
    assert not one.ask("place", file="mannequin")["ok"], "and nobody waits for the pipe"


def test_a_full_disk_leaves_no_part_of_a_step(tmp_path: Path) -> None:
    gestures = begun(tmp_path)
    kept = gestures.read_bytes()
    at = desk(tmp_path)
    one = Visitor(at)
    before = at.session.history.scene
    with files_of_at_most(len(kept) + 20):
        assert not one.ask("place", file="mannequin")["ok"]
        assert gestures.read_bytes() == kept
        assert at.session.history.scene is before
        assert not at.session.history.can_redo, "a step that no line tells"
    name = one.put()
    at.close()
    again = desk(tmp_path)
    assert name in again.session.history.scene.parents
    again.close()


def test_a_scene_that_could_not_be_written_again_and_again_goes_on(tmp_path: Path) -> None:
    begun(tmp_path)
    at = desk(tmp_path)
    write_log, old = at.session.history.write_log, (tmp_path / "scene.json").read_bytes()
    with files_of_at_most(400):
        for k in range(3):
            with pytest.raises(OSError, match="written"):
                write_log.save(old + b" " * (k + 1000))
    assert (tmp_path / "scene.json").read_bytes() == old
    at.close()
    again = desk(tmp_path)
    assert again.session.history.can_undo, "it is the same session"
    assert not (tmp_path / "scene.session-1").exists()


def test_a_step_that_changes_nothing_leaves_anchors_as_the_file_has_them(tmp_path: Path) -> None:
    begun(tmp_path)
    at = desk(tmp_path)
    one, time_s = Visitor(at), float(at.filmed.time_s[5])
    one.done("hang", object="Person", on="marker 7", frame=0)
    for parent in ("marker 7", None, "marker 7"):  # the first of them changes nothing
        edit = {"do": "reparent", "object": "Person", "parent": parent, "time_s": time_s}
        one.done("edit", frame=5, edit=edit)
    made = at.session.history.scene.as_json()
    at.close()
    again = desk(tmp_path)
    assert again.session.history.scene.as_json() == made
    again.close()


@pytest.mark.parametrize("mark", ["5", "null", '{"a": 1}', "[[1]]", "x", "[" * 4000, ""])
def test_marks_that_are_none_lose_nothing(tmp_path: Path, mark: str) -> None:
    gestures = begun(tmp_path)
    kept = gestures.read_bytes()
    scene = json.loads((tmp_path / "scene.json").read_text())
    (gestures.parent / "written.json").write_text(mark)
    at = desk(tmp_path)
    assert [one["name"] for one in at.joined(1)["scene"]["objects"]] == [
        one["name"] for one in scene["objects"]
    ]
    at.close()
    assert (tmp_path / "scene.session-1" / "gestures.jsonl").read_bytes() == kept
