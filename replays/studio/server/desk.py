"""A run's desk: its footage and the session of its scene, as the server asks for them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring import Scene, scene_text
from motorcade.replays.studio.look.document import shown_camera
from motorcade.replays.studio.look.packing import packed
from motorcade.replays.studio.server.filmed import Filmed, open_filmed, spoken
from motorcade.replays.studio.server.footage import Footage
from motorcade.replays.studio.server.journal import Journal
from motorcade.replays.studio.server.ledger import Ledger
from motorcade.replays.studio.server.offers import Answer
from motorcade.replays.studio.server.played import PlayedScene, rows
from motorcade.replays.studio.server.props import GROUND, Props, files_beside
from motorcade.replays.studio.server.session import EditingSession
from motorcade.replays.studio.server.told import ToldScene

SCENE_NAME = "scene.json"


@dataclass(frozen=True, eq=False)
class RunDesk:
    """A run on whose footage a scene is edited.

    Args:
        filmed: the footage.
        session: the scene.
    """

    filmed: Filmed
    session: EditingSession

    @property
    def frames(self) -> int:
        """How many pictures there are."""
        return self.filmed.frames

    @cached_property
    def _footage(self) -> Footage:
        return Footage(self.filmed.recording.frames)

    def about(self) -> dict[str, Any]:
        """What there is, for the page."""
        filmed, scene = self.filmed, self.session.ledger.scene
        poses = rows(filmed.world_T_camera)[:, :7]
        poses[~filmed.has_pose] = np.nan
        first = filmed.ground(filmed.first)
        anchors = dict(scene.anchors) | {
            name: one for name, one in filmed.stands.items() if one not in scene.anchors.values()
        }
        far = np.linalg.norm(
            filmed.world_T_camera.translation_m - first.world_T_plane.translation_m, axis=-1
        )
        size = max(float(far.max()), filmed.height_m)
        return {
            "name": filmed.recording.name,
            "frames": filmed.frames,
            "camera": shown_camera(filmed.camera),
            "time_s": packed(filmed.time_s, "f64"),
            "world_T_camera": packed(poses, "f64"),
            "up": filmed.up.tolist(),
            "depth_m": [0.002 * size, 60.0 * size],
            "height_m": filmed.height_m,
            "anchors": {name: spoken(one) for name, one in anchors.items()},
            "wardrobe": self.session.props.listed(),
            "film": self.film_command(),
        }

    def film_command(self) -> str:
        """What draws the scene into the footage, to be typed where the server runs."""
        scene = self.session.ledger.journal.scene.absolute()
        out = scene.with_name(f"{scene.stem}-film")
        return shlex.join([*self.filmed.words, "--scene", str(scene), "--out", str(out)])

    def frame(self, index: int) -> bytes:
        """A picture as JPEG."""
        return self._footage.jpeg(index)

    def figure(self, number: int) -> bytes | None:
        """A shape as `.glb`."""
        return self.session.played.glb(number)

    def motion(self, number: int) -> dict[str, Any] | None:
        """What joints do, for the page."""
        return self.session.played.motion(number)

    def joined(self, visitor: int) -> Mapping[str, Any]:
        """What a browser is told when it comes."""
        return self.session.joined(visitor)

    def answer(self, visitor: int, message: Mapping[str, Any]) -> Answer:
        """Do what a browser asks for."""
        return self.session.answer(visitor, message)

    def left(self, visitor: int) -> Mapping[str, Any] | None:
        """A browser is gone."""
        return self.session.left(visitor)

    def close(self) -> None:
        """Write the scene as it is, and let others edit it; raises `OSError` where it cannot be."""
        self.session.ledger.close()


def open_desk(run: Path, scene: Path | None = None) -> RunDesk:
    """Open a run for its scene to be edited, where it was left.

    Args:
        run: a folder that `motorcade run` wrote.
        scene: the scene's file; `scene.json` in the run's folder unless told.

    Raises:
        ValueError: a folder that holds no run, a scene that cannot be read.
        OSError: its recording is gone, another process edits the scene, or nothing can be written
            beside it.
    """
    filmed = open_filmed(run)
    file = run / SCENE_NAME if scene is None else scene
    empty = Scene({}, {}, {}, {GROUND: filmed.first})
    journal = Journal(file, scene_text(empty).encode())
    return desk_of(filmed, journal)


def desk_of(filmed: Filmed, journal: Journal) -> RunDesk:
    """The desk of a session; the journal is closed where it cannot be shown.

    Raises:
        ValueError: a line of the session, or a file of the scene, that cannot be read.
    """
    with ExitStack() as refused:
        refused.callback(journal.close)
        folder = journal.scene.absolute().parent
        ledger, props = Ledger(journal), Props(folder, files_beside(folder))
        played = PlayedScene(filmed, folder)
        session = EditingSession(filmed, ledger, played, props, ToldScene(filmed, played, props))
        session.joined(0)  # a scene that cannot be shown is refused here, and not to each browser
        refused.pop_all()
    return RunDesk(filmed, session)
