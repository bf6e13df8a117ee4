"""What befalls files on their way, and files that are no clips."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np

__all__ = ["emptied", "halved", "image", "sound_alone", "text", "without_images"]


def halved(path: Path) -> None:
    """Cut at half its bytes."""
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def emptied(path: Path) -> None:
    """Nothing in it."""
    path.write_bytes(b"")


def text(path: Path) -> None:
    """Words under a video's name."""
    path.write_text("This is a note, and no video.\n", encoding="utf-8")


def image(path: Path) -> None:
    """A photograph."""
    cv2.imwrite(str(path), np.full((270, 480, 3), 120, np.uint8))


def without_images(path: Path) -> None:
    """A video track that holds no image, as where recording was stopped at once."""
    _write(path, sound=False)


def sound_alone(path: Path) -> None:
    """No video track at all."""
    _write(path, sound=True)


def _write(path: Path, *, sound: bool) -> None:
    with av.open(str(path), "r") as source:
        chosen = source.streams.audio[0] if sound else source.streams.video[0]
        whole = path.with_name("part.mp4")
        with av.open(str(whole), "w") as file:
            stream = file.add_stream_from_template(chosen)
            file.start_encoding()
            for packet in source.demux(chosen) if sound else ():
                if packet.size:
                    packet.stream = stream
                    file.mux(packet)
    whole.replace(path)
