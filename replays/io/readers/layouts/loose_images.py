"""A folder of images and nothing else: frames in the order of their names, at an assumed rate."""

from __future__ import annotations

from pathlib import Path

from motorcade.replays.io.readers.frames.files import ImageFrames, images_in
from motorcade.replays.io.readers.frames.images import SUFFIXES
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import even_stamps

LAYOUT = "images"
RATE_HZ = 30.0
FEWEST = 3


def recognise(root: Path) -> bool:
    """Whether the folder, or the only one in it that holds any, holds three images or more."""
    return root.is_dir() and _folder(root) is not None


def read(root: Path) -> Recording:
    """Read the images; they tell no time, so thirty a second are assumed.

    Raises:
        RecordingError: more images than can be read.
    """
    files = images_in(_folder(root) or root)
    frames = ImageFrames(files, even_stamps(len(files), RATE_HZ))
    return Recording(root.resolve().name, root, LAYOUT, frames)


def too_few(root: Path) -> int:
    """How many images a folder without other folders holds, where those are too few; else 0."""
    if not root.is_dir() or any(one.is_dir() for one in root.iterdir()):
        return 0
    count = sum(one.suffix.lower() in SUFFIXES for one in root.iterdir())
    return count if count < FEWEST else 0


def _folder(root: Path) -> Path | None:
    """The folder of images; None where there is none, or several."""
    if _enough(root):
        return root
    inner = [one for one in sorted(root.iterdir()) if one.is_dir() and _enough(one)]
    return inner[0] if len(inner) == 1 else None


def _enough(folder: Path) -> bool:
    images = (one for one in folder.iterdir() if one.suffix.lower() in SUFFIXES)
    return sum(1 for _, _ in zip(images, range(FEWEST), strict=False)) == FEWEST
