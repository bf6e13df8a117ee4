"""A scene and its history, each step of it on the disk before it counts."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Literal

from motorcade.animation.authoring import (
    AnchorsStand,
    Dragged,
    Edit,
    Gesture,
    HistoryStep,
    Scene,
    SceneEditor,
    Together,
    gesture_of,
    read_scene,
    scene_text,
)
from motorcade.ga import Similarity
from motorcade.replays.studio.server.journal import Journal

log = logging.getLogger("motorcade.studio")

_BY_ANCHORS = ("group", "ungroup", "reparent")
"""Edits whose outcome depends on where anchors stand."""


class Ledger:
    """The history of one scene, replayed from its journal.

    Args:
        journal: the session.

    Raises:
        ValueError: a start or a line that cannot be read.
    """

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self._editor = SceneEditor(read_scene(journal.start))
        lines = journal.lines()
        for number, line in enumerate(lines, 1):
            self._editor.do(gesture_of(line, f"{journal.gestures}:{number}"))
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
        """A whole gesture as one step.

        Args:
            gesture: what is done.
            world_T_anchor: where anchors are while it is; kept where it matters.

        Raises:
            ValueError: what the scene does not have or may not have.
            OSError: the step cannot be written; the scene is then as it was.
        """
        editor, lines = self._editor, [gesture.as_json()]
        stands: Mapping[str, Similarity] = editor.world_T_anchor
        if _by_anchors(gesture) and not _same(stands, world_T_anchor):
            stands = world_T_anchor
            lines.insert(0, AnchorsStand(stands).as_json())
        if not self._changes(gesture, stands):
            return
        # Written first: nothing is taken back, which would leave a step to redo that no line tells.
        self.journal.append(*lines)
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

    def close(self) -> None:
        """Write the scene as it is, and let others have its session.

        Raises:
            OSError: it cannot be written; its steps are all kept.
        """
        last = self._save()
        self._writer.shutdown()
        self.journal.close()
        last.result()

    def _save(self) -> Future[None]:
        """Write the scene soon; of many changes at once the last."""
        return self._writer.submit(self._write)

    def _write(self) -> None:
        scene = self.scene
        if scene is self._saved:
            return
        try:
            self.journal.save(scene_text(scene).encode())
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


def _same(one: Mapping[str, Similarity], other: Mapping[str, Similarity]) -> bool:
    return one.keys() == other.keys() and all(
        bool((one[name].coefficients == other[name].coefficients).all()) for name in one
    )
