"""The pictures of a run as files, for programs that read poses and pictures together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.io.errors import refusal
from motorcade.replays.pipeline.runs import Shown
from motorcade.tracking.cameras.camera import Camera

_QUALITY = 95


@dataclass(frozen=True, eq=False)
class PosedPictures:
    """Pictures that were written, each with where the camera stood.

    Attributes:
        names: (N,) relative to the folder, such as ``images/frame_000012.jpg``.
        world_T_camera: (N,) along the path that the characters are drawn on.
        camera: as filmed, with its distortion.
    """

    names: tuple[str, ...]
    world_T_camera: Motor
    camera: Camera


def write_pictures(shown: Shown, folder: Path, every: int = 1) -> PosedPictures:
    """Write each `every`-th frame that has a pose as a JPEG, as it was filmed.

    Raises:
        ValueError: a step below 1, or a folder that holds pictures already, which would be mixed.
        OSError: a file cannot be written.
    """
    import cv2

    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    place = folder / "images"
    if place.exists() and any(place.iterdir()):
        raise refusal(place, "holds files already", advice="name a new folder")
    place.mkdir(parents=True, exist_ok=True)
    names, stamps = [], []
    first_ns, last_ns = shown.path.time_ns[[0, -1]]
    for number, frame in enumerate(shown.recording.frames):
        if number % every or not first_ns <= frame.time_ns <= last_ns:
            continue
        picture = frame.image()
        ordered = picture if picture.ndim == 2 else picture[..., ::-1]
        _, data = cv2.imencode(".jpg", ordered, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        names.append(f"images/frame_{number:06}.jpg")
        write_bytes(folder / names[-1], data.tobytes())
        stamps.append(frame.time_ns)
    camera = shown.recording.camera
    if camera is None:
        raise refusal(shown.recording.root, "expected a camera, got none")
    poses = shown.path.motors_at(np.array(stamps, dtype=np.int64))
    return PosedPictures(tuple(names), poses, camera)
