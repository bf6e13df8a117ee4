"""The film of a scene, drawn by a process of its own while the page shows how far it is.

One film at a time is drawn on a server, for an hour at most; a server that ends takes it along. The
process is what the page's command line starts, so that both make the same film.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from motorcade.animation.authoring import Scene

LONGEST_S = 3600.0
FILM_NAME = "overlay.mp4"
_START = (
    "import os, sys; os.nice(5); from motorcade.replays.cli import main; "
    "sys.exit(main(sys.argv[1:]))"
)
_SHARE = re.compile(r"drawing: .* (\d+) %")
_LONGEST_LINE = 300
_drawn_now = threading.Lock()
"""Held while a film is being drawn."""


@dataclass
class FilmDrawing:
    """The film of one scene. May be asked by several threads.

    Args:
        words: of the command line that draws it, the program's name first.
        folder: that it leaves the film in.
    """

    words: Sequence[str]
    folder: Path
    _process: subprocess.Popen[str] | None = None
    _said: str = ""
    _share: float | None = None
    _failed: str | None = None
    _scene: Scene | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def film(self) -> Path | None:
        """The film that was drawn last, in this session or before; None without."""
        path = self.folder / FILM_NAME
        return path if path.is_file() and not path.is_symlink() else None

    def start(self, scene: Scene) -> None:
        """Begin to draw a scene, whose file is written.

        Raises:
            ValueError: a film is being drawn already, or there is nobody in the scene.
            OSError: no process can be started.
        """
        if all(scene.part(name).kind == "group" for name in scene.parents):
            raise ValueError("Nobody is in the scene yet.")
        if not _drawn_now.acquire(blocking=False):
            raise ValueError("A film is being drawn already.")
        try:
            process = subprocess.Popen(
                [sys.executable, "-c", _START, *self.words[1:]],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
            )
        except BaseException:
            _drawn_now.release()
            raise
        with self._lock:
            self._process, self._scene = process, scene
            self._said, self._share, self._failed = "opening the recording", None, None
        threading.Thread(target=self._follow, args=(process,), daemon=True).start()

    def stop(self) -> None:
        """End what is being drawn, if anything is."""
        with self._lock:
            process = self._process
        if process is not None:
            process.terminate()

    def close(self) -> None:
        """The same, and wait for it."""
        with self._lock:
            process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def state(self, scene: Scene) -> dict[str, Any]:
        """How far it is, for the page; and whether the film shows the scene as it is now."""
        film = self.film
        with self._lock:
            return {
                "drawing": self._process is not None,
                "said": self._said,
                "share": self._share,
                "failed": self._failed,
                "film": None if film is None else str(film.stat().st_mtime_ns),
                "stale": self._scene is not None and self._scene is not scene,
            }

    def _follow(self, process: subprocess.Popen[str]) -> None:
        """Take down what the process says, until it ends."""
        late = threading.Timer(LONGEST_S, process.kill)
        late.daemon = True
        late.start()
        last = ""
        try:
            assert process.stderr is not None  # it was asked for
            while line := process.stderr.readline(_LONGEST_LINE):
                last = line.strip() or last
                share = _SHARE.search(last)
                with self._lock:
                    self._said = last
                    self._share = 0.01 * int(share.group(1)) if share else self._share
            process.stderr.close()
            code = process.wait()
            late.cancel()
            with self._lock:
                self._process = None
                if code < 0:
                    self._failed = "It was stopped."
                elif code:
                    self._failed = last.removeprefix("motorcade: ") or "It could not be drawn."
        finally:
            _drawn_now.release()
