"""What was done to a scene, kept as it is done: a gesture is on the disk before it is answered.

A session lies beside its scene, in `scene.session/`: `start.json` is the scene that it began with,
`gestures.jsonl` all that was done since, a line each, and both replay to the scene itself::

    motorcade author scene.session/start.json --gestures scene.session/gestures.jsonl -o scene.json

A process that is killed leaves at most half a line at the end, which is what was under way. One
process at a time has a session: it keeps a lock on `scene.session.lock`, which the system ends
together with the process.

A scene and its history, each step of it on the disk before it counts.
"""

from __future__ import annotations

import json
import logging
import os
import stat
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from motorcade.animation.authoring import (
    Dragged,
    Edit,
    Gesture,
    Scene,
    SceneEditor,
    gesture_of,
    read_scene,
    scene_text,
)
from motorcade.animation.authoring.gestures import AnchorsStand, HistoryStep, Together
from motorcade.ga import Similarity
from motorcade.ga.files import is_there, read_bounded
from motorcade.ga.unfinished import try_lock
from motorcade.replays.io.files import write_bytes

log = logging.getLogger("motorcade.studio")

MAX_GESTURES_BYTES = 256 << 20
MAX_SCENE_BYTES = 16 << 20
MAX_MARK_BYTES = 4096


class WriteAheadLog:
    """The session of one scene, which is this one's alone until it is closed.

    Its file `start` is the scene that it began with, `gestures` what was done since.

    Args:
        scene: the scene's file, which need not exist yet.
        start: its bytes where it does not.

    Raises OSError: another has the session, nothing can be written there, or a link or a pipe is in
    the place of its files; ValueError: a file that is too large.
    """

    def __init__(self, scene: Path, start: bytes) -> None:
        self.scene = scene
        self._folder = scene.with_name(f"{scene.stem}.session")
        self.start, self.gestures = self._folder / "start.json", self._folder / "gestures.jsonl"
        self._last: list[str] = []
        self._lock = self._taken()
        try:
            self._begin(start)
        except BaseException:
            self.close()
            raise

    def lines(self) -> list[dict[str, Any]]:
        """All that was done, in order.

        Raises ValueError: a line that is none; the message names it.
        """
        gestures = []
        for number, line in enumerate(self._read().splitlines(), 1):
            try:
                gestures.append(json.loads(line))
            except (ValueError, RecursionError) as fault:
                raise ValueError(f"{self.gestures}:{number}: expected a line of JSON") from fault
        return gestures

    def append(self, *lines: Mapping[str, Any]) -> None:
        """Put lines on the disk; they are there when this returns.

        Raises OSError: it cannot be written; nothing of it is left then.
        """
        text = "".join(json.dumps(one, separators=(",", ":")) + "\n" for one in lines)
        with self._opened() as file:
            whole = os.fstat(file).st_size
            try:
                left = memoryview(text.encode())
                while left:  # a full disk may take a part of it
                    left = left[os.write(file, left) :]
                os.fsync(file)
            except OSError:
                os.ftruncate(file, whole)
                raise

    def save(self, scene: bytes) -> None:
        """Write the scene itself, all of it or nothing. Raises OSError: it cannot be written."""
        mark = sha256(scene).hexdigest()
        marks = [*self._last, mark]  # either may be found after a kill or a write that failed
        write_bytes(self._folder / "written.json", json.dumps(marks).encode())
        write_bytes(self.scene, scene)
        self._last = [mark]

    def close(self) -> None:
        """Let others have the session."""
        if self._lock is not None:
            os.close(self._lock)
        self._lock = None

    def _taken(self) -> int | None:
        """The session's lock, ours; its file stays, as removing it could free a lock of another."""
        path = self._folder.with_name(f"{self._folder.name}.lock")
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = _opened(path, os.O_RDWR)
        ours = try_lock(lock)
        if ours is False:
            os.close(lock)
            raise OSError(
                f"{self.scene}: another `motorcade author` is editing this scene; open the link "
                "that it printed, or stop it first"
            )
        if ours is None:
            log.warning("%s: no locks here; let only one program edit the scene", path.parent)
        return lock

    def _begin(self, start: bytes) -> None:
        """Go on with the session, or begin one where the scene is not what it wrote last."""
        if self._folder.is_symlink():
            raise OSError(f"{self._folder}: expected a folder, got a link")
        present = read_bounded(self.scene, MAX_SCENE_BYTES) if is_there(self.scene) else None
        self._last = [] if present is None else [sha256(present).hexdigest()]
        known = is_there(self.start) and (
            (present is None and not self._marks())
            or (present is not None and self._last[0] in self._marks())
        )
        if not known:
            if self._folder.exists():
                self._set_aside()
            self._folder.mkdir(parents=True)
            begun = start if present is None else present
            write_bytes(self._folder / "written.json", json.dumps(self._last).encode())
            write_bytes(self.start, begun)
        data = self._read()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):  # what a killed process was writing
            with self._opened() as file:
                os.ftruncate(file, whole)
                os.fsync(file)

    @contextmanager
    def _opened(self) -> Iterator[int]:
        """The gestures, open to be written at their end."""
        file = _opened(self.gestures, os.O_WRONLY | os.O_APPEND)
        try:
            yield file
        finally:
            os.close(file)

    def _set_aside(self) -> None:
        """Another program wrote the scene: the old session is kept under another name."""
        number = 1
        while (old := self._folder.with_name(f"{self._folder.name}-{number}")).exists():
            number += 1
        self._folder.rename(old)

    def _read(self) -> bytes:
        if not is_there(self.gestures) or not self.gestures.stat().st_size:
            return b""
        return read_bounded(self.gestures, MAX_GESTURES_BYTES)

    def _marks(self) -> list[str]:
        """SHA-256 of what was written as the scene last, and before that."""
        path = self._folder / "written.json"
        if not is_there(path):
            return []
        try:
            document = json.loads(read_bounded(path, MAX_MARK_BYTES))
        except (ValueError, RecursionError):
            return []  # it marks nothing: the session is set aside, and the scene is as it is
        return list(map(str, document)) if isinstance(document, list) else []


def _opened(path: Path, way: int) -> int:
    """A file of its own, made where it is not there, to which no link leads.

    A folder that somebody else made may hold a link to any file here.
    """
    file = os.open(path, way | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    about = os.fstat(file)
    if not stat.S_ISREG(about.st_mode) or about.st_nlink != 1:
        os.close(file)
        raise OSError(f"{path}: expected a file of its own")
    return file


_BY_ANCHORS = ("group", "ungroup", "reparent")
"""Edits whose outcome depends on where anchors stand."""


class SceneHistory:
    """The history of one scene, replayed from its write-ahead log.

    Raises ValueError: a start or a line that cannot be read.
    """

    def __init__(self, write_log: WriteAheadLog) -> None:
        self.write_log = write_log
        self._editor = SceneEditor(read_scene(write_log.start))
        lines = write_log.lines()
        for number, line in enumerate(lines, 1):
            self._editor.do(gesture_of(line, f"{write_log.gestures}:{number}"))
        self._writer = ThreadPoolExecutor(1)
        self._saved: Scene | None = None if lines else self.scene
        if lines:  # a process that was killed may have left the scene a step behind
            self._save()

    @property
    def scene(self) -> Scene:
        """As it is now."""
        return self._editor.scene

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return self._editor.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to take again."""
        return self._editor.can_redo

    def do(self, gesture: Gesture, world_T_anchor: Mapping[str, Similarity]) -> None:
        """A whole gesture as one step; where anchors are meanwhile is kept where it matters.

        Raises ValueError: what the scene does not have or may not have; OSError: the step cannot be
        written; the scene is then as it was.
        """
        editor, lines = self._editor, [gesture.as_json()]
        stands: Mapping[str, Similarity] = editor.world_T_anchor
        if _by_anchors(gesture) and not _same(stands, world_T_anchor):
            stands = world_T_anchor
            lines.insert(0, AnchorsStand(stands).as_json())
        if not self._changes(gesture, stands):
            return
        # Written first: nothing is taken back, which would leave a step to redo that no line tells.
        self.write_log.append(*lines)
        editor.stand(stands)
        editor.do(gesture)
        self._save()

    def step(self, way: Literal["undo", "redo"]) -> None:
        """A step back or forth; raises as `do`."""
        self.do(HistoryStep(way), {})

    def _changes(self, gesture: Gesture, world_T_anchor: Mapping[str, Similarity]) -> bool:
        """Whether a gesture makes another scene of this one; raises as `do`."""
        if isinstance(gesture, HistoryStep):
            return self.can_undo if gesture.way == "undo" else self.can_redo
        trial = SceneEditor(self.scene)
        trial.stand(world_T_anchor)
        return trial.do(gesture) is not self.scene

    def saved(self) -> None:
        """Have the scene's file as the scene is now. Raises OSError: it cannot be written."""
        if not is_there(self.write_log.scene):  # nothing was done to the scene that it began with
            self._saved = None
        self._save().result()

    def close(self) -> None:
        """Write the scene as it is, and let others have its session.

        Raises OSError: it cannot be written; its steps are all kept.
        """
        last = self._save()
        self._writer.shutdown()
        self.write_log.close()
        last.result()

    def _save(self) -> Future[None]:
        """Write the scene soon; of many changes at once the last."""
        return self._writer.submit(self._write)

    def _write(self) -> None:
        scene = self.scene
        if scene is self._saved:
            return
        try:
            self.write_log.save(scene_text(scene).encode())
        except OSError as fault:
            log.warning("the scene is not written, its steps are kept: %s", fault)
            raise
        self._saved = scene


def _by_anchors(gesture: Gesture) -> bool:
    """Whether what a gesture makes of a scene depends on where anchors are."""
    if isinstance(gesture, Together):
        return any(map(_by_anchors, gesture.gestures))
    if isinstance(gesture, Dragged):
        return gesture.drag.frame == "global"
    return isinstance(gesture, Edit) and gesture.line["do"] in _BY_ANCHORS


def _same(similarities: Mapping[str, Similarity], other: Mapping[str, Similarity]) -> bool:
    return similarities.keys() == other.keys() and all(
        bool((similarities[name].coefficients == other[name].coefficients).all())
        for name in similarities
    )
