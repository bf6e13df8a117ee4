"""Footage that needs no run: a camera that goes round a table, and a marker that moves on it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from motorcade.animation.authoring import Scene, SceneAnchor, scene_text
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.view.ground import Ground
from motorcade.replays.studio.desk import RunDesk, desk_of
from motorcade.replays.studio.filmed import Filmed
from motorcade.replays.studio.props import GROUND
from motorcade.replays.studio.write_ahead import WriteAheadLog
from motorcade.tracking import Camera

FRAMES = 12
STRAIGHT = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)


@dataclass(frozen=True)
class Images:
    """Grey images with their number in them."""

    camera: Camera
    time_ns: np.ndarray = field(
        default_factory=lambda: 1_000_000_000 + 40_000_000 * np.arange(FRAMES)
    )

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, index: int) -> SimpleNamespace:
        shape = (self.camera.height, self.camera.width)
        return SimpleNamespace(image=lambda: np.full(shape, 10 * index, dtype=np.uint8))


@dataclass(frozen=True)
class Stands:
    """The table, and marker 7 that slides along it."""

    seen_from: Trajectory
    camera_poses: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(origin="slam"))
    marker_poses: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            marker_map=SimpleNamespace(marker_ids=np.array([7]))
        )
    )

    def asked(
        self, on: str, marker: int | None, floor_m: float
    ) -> tuple[Ground, Trajectory | None]:
        if marker is None:
            return Ground(Motor.identity(), (0.0, 0.0), 0.2, "the table"), None
        stand = Motor.from_rotor_translation(
            Rotor.from_rotation_vector([0.2, 0.1, 0.5]), [0.1, 0.2, 0.05]
        )
        steps = np.zeros((FRAMES, 3))
        steps[:, 0] = 0.02 * np.arange(FRAMES)
        motion = Trajectory(self.seen_from.time_ns, Motor.from_translation(steps), "world", "start")
        return Ground(stand, (0.05, -0.05), 0.1, "marker 7, which moves"), motion


def filmed(camera: Camera = STRAIGHT) -> Filmed:
    """A camera that looks down on the table from half a metre."""
    images = Images(camera)
    poses = []
    for k in range(FRAMES):
        turn = Rotor.from_rotation_vector([0.0, 0.0, 0.03 * k])
        down = Rotor.from_rotation_vector([-np.pi / 2 - 0.7, 0.0, 0.0])  # z ahead, and down
        poses.append(Motor.from_rotor_translation(turn @ down, turn.apply([0.02, -0.6, 0.5])))
    path = Trajectory(images.time_ns, Motor.stack(poses), "world", "camera")
    recording = Recording(
        name="table", root=Path("table"), layout="made", frames=images, camera=camera
    )
    words = "motorcade", "run", str(Path("table").absolute())
    return Filmed(recording, Stands(path), SceneAnchor(), np.zeros(2), 0.2, words)


def desk(folder: Path, camera: Camera = STRAIGHT) -> RunDesk:
    """The desk of a scene in a folder, as it was left."""
    seen = filmed(camera)
    empty = Scene({}, {}, {}, {GROUND: seen.first})
    return desk_of(seen, WriteAheadLog(folder / "scene.json", scene_text(empty).encode()))


class Visitor:
    """A browser of one desk, without the network."""

    def __init__(self, at: RunDesk, number: int = 1) -> None:
        self.at, self.number = at, number
        self.scene = at.joined(number)["scene"]

    def ask(self, do: str, **message: object) -> dict[str, object]:
        answer = self.at.answer(self.number, {"n": 5, "do": do, **message})
        self.news = answer.news
        told = json.loads(json.dumps(answer.reply, allow_nan=False))
        assert told["n"] == 5
        return told

    def done(self, do: str, **message: object) -> dict[str, object]:
        told = self.ask(do, **message)
        assert told["ok"], told
        return told

    def put(self, **message: object) -> str:
        return str(self.done("place", file="mannequin", **message)["object"])


def seen(at: RunDesk, frame: int, point: np.ndarray) -> np.ndarray:
    return at.filmed.camera.project(at.filmed.world_T_camera[frame].inverse().apply(point))


def stands(at: RunDesk, name: str, frame: int) -> Similarity:
    session = at.session
    scene, time_s = session.history.scene, float(at.filmed.time_s[frame])
    return scene.world_T_object(name, time_s, session.anchors(scene, frame))
