"""What was done to a scene, kept as it is done: a gesture is on the disk before it is answered.

A session lies beside its scene, in `scene.session/`: `start.json` is the scene that it began with,
`gestures.jsonl` all that was done since, a line each, and both replay to the scene itself::

    motorcade author scene.session/start.json --gestures scene.session/gestures.jsonl -o scene.json

A process that is killed leaves at most half a line at the end, which is what was under way.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from motorcade.ga.files import is_there, read_bounded
from motorcade.replays.files.atomic import write_bytes

MAX_JOURNAL_BYTES = 256 << 20
MAX_SCENE_BYTES = 16 << 20
MAX_MARK_BYTES = 4096


class Journal:
    """The session of one scene.

    Args:
        scene: the scene's file, which need not exist yet.
        start: its bytes where it does not.

    Raises:
        OSError: nothing can be written there.
        ValueError: a file that is too large.
    """

    def __init__(self, scene: Path, start: bytes) -> None:
        self.scene = scene
        self._folder = scene.with_name(f"{scene.stem}.session")
        self._begin(start)

    @property
    def start(self) -> Path:
        """The scene that the session began with."""
        return self._folder / "start.json"

    @property
    def gestures(self) -> Path:
        """What was done since."""
        return self._folder / "gestures.jsonl"

    def lines(self) -> list[dict[str, Any]]:
        """All that was done, in order.

        Raises:
            ValueError: a line that is none; the message names it.
        """
        found = []
        for number, line in enumerate(self._read().splitlines(), 1):
            try:
                found.append(json.loads(line))
            except (ValueError, RecursionError) as fault:
                raise ValueError(f"{self.gestures}:{number}: expected a line of JSON") from fault
        return found

    def append(self, *lines: Mapping[str, Any]) -> None:
        """Put lines on the disk; they are there when this returns.

        Raises:
            OSError: it cannot be written; nothing of it is left then.
        """
        text = "".join(json.dumps(one, separators=(",", ":")) + "\n" for one in lines)
        with self.gestures.open("ab") as file:
            whole = file.tell()
            try:
                file.write(text.encode())
                file.flush()
                os.fsync(file.fileno())
            except OSError:
                file.truncate(whole)
                raise

    def save(self, scene: bytes) -> None:
        """Write the scene itself, all of it or nothing.

        Raises:
            OSError: it cannot be written.
        """
        marks = [*self._marks()[-1:], sha256(scene).hexdigest()]  # either may be found after a kill
        write_bytes(self._folder / "written.json", json.dumps(marks).encode())
        write_bytes(self.scene, scene)

    def _begin(self, start: bytes) -> None:
        """Go on with the session, or begin one where the scene is not what it wrote last."""
        present = read_bounded(self.scene, MAX_SCENE_BYTES) if is_there(self.scene) else None
        known = is_there(self.start) and (
            (present is None and not self._marks())
            or (present is not None and sha256(present).hexdigest() in self._marks())
        )
        if not known:
            if self._folder.exists():
                self._set_aside()
            self._folder.mkdir(parents=True)
            begun = start if present is None else present
            marks = [] if present is None else [sha256(present).hexdigest()]
            write_bytes(self._folder / "written.json", json.dumps(marks).encode())
            write_bytes(self.start, begun)
        data = self._read()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):  # what a killed process was writing
            with self.gestures.open("r+b") as file:
                file.truncate(whole)
                os.fsync(file.fileno())

    def _set_aside(self) -> None:
        """Another program wrote the scene: the old session is kept under another name."""
        number = 1
        while (old := self._folder.with_name(f"{self._folder.name}-{number}")).exists():
            number += 1
        self._folder.rename(old)

    def _read(self) -> bytes:
        if not is_there(self.gestures) or not self.gestures.stat().st_size:
            return b""
        return read_bounded(self.gestures, MAX_JOURNAL_BYTES)

    def _marks(self) -> list[str]:
        """SHA-256 of what was written as the scene last, and before that."""
        path = self._folder / "written.json"
        if not is_there(path):
            return []
        found = json.loads(read_bounded(path, MAX_MARK_BYTES))
        return [str(one) for one in found]
