"""What is kept of all that is done to a scene: every answered step, through kills and restarts."""

import json
import os
import signal
import time
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation.authoring import (
    SceneEditor,
    read_gestures,
    read_scene,
    replay,
    scene_text,
)
from motorcade.replays.studio.write_ahead import WriteAheadLog
from motorcade.replays.tasks.blending import author
from tests.replays.studio.server.stage import FRAMES, Visitor, desk, seen, stands


def play(one: Visitor, rng: np.random.Generator) -> None:
    """Something that a hand may do, at random."""
    names = [about["name"] for about in one.at.joined(9)["scene"]["objects"]]
    kind = rng.choice(["put", "move", "turn", "undo", "redo", "key", "copy", "remove"])
    name = str(rng.choice(names)) if names else ""
    frame = int(rng.integers(FRAMES))
    if kind == "put" or not names:
        one.put()
    elif kind == "move":
        pixel = seen(one.at, frame, stands(one.at, name, frame).translation_m)
        if one.ask("begin", object=name, gesture="move", frame=frame, pixels=[pixel.tolist()])[
            "ok"
        ]:
            one.ask("drag", pixels=[(pixel + rng.normal(size=2) * 20).tolist()])
            one.done("end")
    elif kind == "turn":
        one.done("begin", object=name, gesture="turn", frame=frame)
        one.done("drag", amount=float(rng.normal()))
        one.done("end")
    elif kind in ("undo", "redo"):
        one.done(str(kind))
    elif kind == "key":
        time_s = float(one.at.filmed.time_s[frame])
        one.done("edit", frame=frame, edit={"do": "keyframe", "object": name, "time_s": time_s})
    elif kind == "copy" and len(names) < 4:
        one.done("copy", object=name, frame=frame)
    elif kind == "remove" and len(names) > 2:
        one.done("edit", edit={"do": "remove", "object": name})


def test_all_is_kept_and_replays_to_the_same_bytes(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    at = desk(tmp_path)
    one = Visitor(at)
    for _ in range(60):
        play(one, rng)
    at.close()
    written = (tmp_path / "scene.json").read_bytes()
    again = desk(tmp_path)
    assert again.session.history.can_undo, "the history is kept too"
    again.close()
    assert (tmp_path / "scene.json").read_bytes() == written
    session = tmp_path / "scene.session"
    made = author(session / "start.json", session / "gestures.jsonl")
    assert scene_text(made.scene).encode() == written


def test_a_scene_that_cannot_be_written_is_told_and_its_steps_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(self: WriteAheadLog, scene: bytes) -> None:
        raise OSError("no space left")

    at = desk(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(WriteAheadLog, "save", full)
        Visitor(at).put()
        with pytest.raises(OSError, match="no space left"):
            at.close()
    assert "its steps are kept: no space left" in caplog.text
    again = desk(tmp_path)
    assert len(again.joined(1)["scene"]["objects"]) == 1
    again.close()
    assert (tmp_path / "scene.json").exists()


def test_a_scene_that_was_left_behind_its_steps_is_brought_up_to_them(tmp_path: Path) -> None:
    scene = tmp_path / "scene.json"
    at = desk(tmp_path)
    one = Visitor(at)
    one.put()
    at.close()
    behind = scene.read_bytes()
    at = desk(tmp_path)
    Visitor(at).put()
    at.close()
    whole = scene.read_bytes()
    scene.write_bytes(behind)  # as if the process had been killed before it was written
    (tmp_path / "scene.session" / "written.json").write_text(
        json.dumps([sha256(behind).hexdigest(), sha256(whole).hexdigest()])
    )
    at = desk(tmp_path)
    for _ in range(200):
        if scene.read_bytes() == whole:
            break
        time.sleep(0.05)
    assert scene.read_bytes() == whole
    at.close()


def test_what_was_only_looked_at_is_not_written(tmp_path: Path) -> None:
    told = '{"objects": [\n  {"name": "table"}\n]}\n'
    (tmp_path / "scene.json").write_text(told)
    desk(tmp_path).close()
    assert (tmp_path / "scene.json").read_text() == told


def test_half_a_line_at_the_end_is_left_out(tmp_path: Path) -> None:
    at = desk(tmp_path)
    one = Visitor(at)
    one.put()
    one.put()
    at.close()
    gestures = tmp_path / "scene.session" / "gestures.jsonl"
    whole = gestures.read_bytes()
    gestures.write_bytes(whole[:-7])
    at = desk(tmp_path)
    assert len(at.joined(1)["scene"]["objects"]) == 1
    assert gestures.read_bytes() == whole.splitlines(keepends=True)[0]
    at.close()


def test_a_scene_that_another_program_wrote_is_taken_as_it_is(tmp_path: Path) -> None:
    at = desk(tmp_path)
    Visitor(at).put()
    at.close()
    scene = tmp_path / "scene.json"
    tree = json.loads(scene.read_text())
    tree["objects"][0]["name"] = "Somebody"
    scene.write_text(json.dumps(tree))
    at = desk(tmp_path)
    assert [one["name"] for one in at.joined(1)["scene"]["objects"]] == ["Somebody"]
    at.close()
    old = tmp_path / "scene.session-1" / "gestures.jsonl"
    assert b"Person" in old.read_bytes(), "nothing is thrown away"


def test_one_process_has_a_session(tmp_path: Path) -> None:
    at = desk(tmp_path)
    Visitor(at).put()
    gestures = tmp_path / "scene.session" / "gestures.jsonl"
    with gestures.open("ab") as torn:
        torn.write(b'{"do": "half')
    kept = gestures.read_bytes()
    with pytest.raises(OSError, match=r"scene\.json: another .* is editing this scene; open the"):
        desk(tmp_path)
    assert gestures.read_bytes() == kept, "what the other is writing is not cut"
    at.close()
    desk(tmp_path).close()
    assert gestures.read_bytes() == kept[: kept.rfind(b"\n") + 1]


def test_a_session_that_cannot_be_read_is_let_go(tmp_path: Path) -> None:
    at = desk(tmp_path)
    Visitor(at).put()
    at.close()
    gestures = tmp_path / "scene.session" / "gestures.jsonl"
    whole = gestures.read_bytes()
    gestures.write_bytes(b"no line\n")
    with pytest.raises(ValueError, match=r"gestures\.jsonl:1"):
        desk(tmp_path)
    gestures.write_bytes(whole)
    desk(tmp_path).close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_killed_process_keeps_nobody_out(tmp_path: Path) -> None:
    hears, tells = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            desk(tmp_path)
            os.write(tells, b"!")
            time.sleep(60.0)
        finally:
            os._exit(0)
    os.close(tells)
    assert os.read(hears, 1) == b"!"
    with pytest.raises(OSError, match="another"):
        desk(tmp_path)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    desk(tmp_path).close()


def edits_until_killed(folder: Path, seed: int, told: int) -> None:
    """Of a child: edit at random, and say after each answer what is kept and how the scene is."""
    rng = np.random.default_rng(seed)
    at = desk(folder)
    one, gestures = Visitor(at), folder / "scene.session" / "gestures.jsonl"
    while True:
        play(one, rng)
        kept = len(gestures.read_bytes().splitlines()) if gestures.exists() else 0
        os.write(told, json.dumps([kept, scene_text(at.session.history.scene)]).encode() + b"\n")


@pytest.mark.slow
def test_a_kill_loses_at_most_what_is_in_the_hand(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    desk(tmp_path).close()  # all is imported, and the mannequin read
    heard = 0
    for kill in range(20):
        hears, tells = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(hears)
            edits_until_killed(tmp_path, kill, tells)
        os.close(tells)
        time.sleep(float(rng.uniform(0.3, 1.5)))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        with os.fdopen(hears, "rb") as pipe:
            said = [json.loads(line) for line in pipe if line.endswith(b"\n")]
        at = desk(tmp_path)
        history = at.session.history
        done = read_gestures(history.write_log.gestures)
        if said:
            heard += len(said)
            kept, text = said[-1]
            assert kept <= len(done) <= kept + 2, "a step, and where anchors stood in it"
            start = SceneEditor(read_scene(history.write_log.start))
            assert scene_text(replay(start, done[:kept])) == text, "what was answered is there"
            assert scene_text(replay(start, done[kept:])) == scene_text(history.scene)
        at.close()
    assert heard > 100
