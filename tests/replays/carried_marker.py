"""A marker that is carried about before a camera whose path is known, drawn by the tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.recording import Frame, FrameSequence, ImageArray, LooseMarkers, Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.tracking import Board, Camera, PoseMeasurements
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
FRAMES, RATE_HZ, SIDE_M, ID = 40, 20.0, 0.1, 7
TIME_NS = np.rint(np.arange(FRAMES) * 1e9 / RATE_HZ).astype(np.int64)


class Images:
    """Frames in memory."""

    def __init__(self, images: Sequence[ImageArray]) -> None:
        self.images, self.time_ns = images, TIME_NS

    def __len__(self) -> int:
        return len(self.images)

    def __getitem__(self, index: int) -> Frame:
        return Frame(int(self.time_ns[index]), str(index), self.images[index].copy)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def check(self, camera: Camera | None) -> None: ...

    def intact(self, camera: Camera | None) -> tuple[FrameSequence, tuple[str, ...]]:
        return self, ()

    def content(self) -> Iterator[bytes]:
        return iter(())


def wandering(frame: int) -> Motor:
    """Carried about before the camera, and turned, smoothly."""
    t = frame / RATE_HZ
    place = [0.12 * np.sin(1.5 * t) - 0.05, 0.08 * np.sin(2.1 * t) + 0.05, 0.05 * np.sin(t)]
    turn = Rotor.from_rotation_vector([0.5 * np.sin(1.2 * t), 0.4, 0.6 * np.sin(0.9 * t)])
    return Motor.from_rotor_translation(turn, place)


def still(frame: int) -> Motor:
    return wandering(5)


@cache
def drawn(where: Callable[[int], Motor], hidden: range) -> tuple[ImageArray, ...]:
    """Images of the marker along the camera's path."""
    rng = np.random.default_rng(3)
    cameras = handheld_path(FRAMES, 0.7)
    images = []
    for k in range(FRAMES):
        ids = np.array([], dtype=np.int64) if k in hidden else np.array([ID])
        poses = Motor.stack([where(k)])[: len(ids)]
        scene = TagScene(CAMERA, "tag36h11", ids, SIDE_M, poses)
        images.append(scene.image(cameras[k], rng))
    return tuple(images)


def recorded(
    where: Callable[[int], Motor], hidden: range = range(0), board: Board | None = None
) -> tuple[Recording, Integrity, CameraPoses]:
    """Images of one marker by a camera whose path is known."""
    images = drawn(where, hidden)
    recording = Recording(
        "drawn",
        Path("drawn"),
        "images",
        Images(images),
        CAMERA,
        board=board,
        world_T_board=where(0),
        markers=LooseMarkers("tag36h11", SIDE_M),
    )
    path = Trajectory(TIME_NS, handheld_path(FRAMES, 0.7))
    measured = PoseMeasurements(path, np.tile(np.eye(6) * 1e-6, (FRAMES, 1, 1)))
    nothing = np.full(FRAMES, np.nan)
    origin = "slam" if board is None else "board"
    found = CameraPoses(measured, TIME_NS, nothing, origin, "as given")
    return recording, Integrity((), {}, path, "smoothed"), found


def write_carried(folder: Path, size: int = 2) -> None:
    """A recording on disk: three markers on a wall, and one that is carried about before them.

    Args:
        folder: to write into.
        size: factor on the images' 320 by 240 pixels.
    """
    rng = np.random.default_rng(8)
    wall, cameras = wall_of_markers(3, 1, 0.16, 20.0, rng), handheld_path(FRAMES, 0.7)
    big = Camera(
        size * CAMERA.width,
        size * CAMERA.height,
        size * CAMERA.fx,
        size * CAMERA.fy,
        size * (CAMERA.cx + 0.5) - 0.5,
        size * (CAMERA.cy + 0.5) - 0.5,
    )
    (folder / "images").mkdir(parents=True)
    for k in range(FRAMES):
        poses = Motor.concatenate([wall, Motor.stack([wandering(k)])])
        scene = TagScene(big, "tag36h11", np.array([1, 2, 3, ID]), SIDE_M, poses)
        image = scene.image(cameras[k], rng)
        if not cv2.imwrite(str(folder / "images" / f"{k:04d}.png"), image):
            raise OSError(f"{folder}: cannot be written")
    lines = [
        f'settings = ["marker_poses.moving={ID}", "smoothed.representations=motor"]',
        "[frames]",
        'images = "images/*.png"',
        f"rate_hz = {RATE_HZ}",
        "[camera]",
        'model = "pinhole"',
        *(f"{name} = {getattr(big, name)}" for name in ("fx", "fy", "cx", "cy")),
        "[markers]",
        'family = "tag36h11"',
        f"side_m = {SIDE_M}",
    ]
    (folder / "motorcade.toml").write_text("\n".join(lines) + "\n")
