"""Which layout a folder has: each is known by one file or pattern, looked for in a fixed order.

The first that is recognised wins: what is known by more stands before what is known by less.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from shlex import quote
from typing import Protocol

from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.frames import video
from motorcade.replays.io.readers.frames.files import (
    ImageFrames,
    first_look,
    images_in,
)
from motorcade.replays.io.readers.frames.images import SUFFIXES
from motorcade.replays.io.readers.frames.names import stamps_of_names
from motorcade.replays.io.readers.layouts import (
    euroc,
    kitti,
    seven_scenes,
    tum_rgbd,
)
from motorcade.replays.io.readers.ros import recording as ros
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import TEXT_SUFFIXES

LOOSE_IMAGES = "images"
"""Layout of a folder of images and nothing else: frames in the order of their names."""
RATE_HZ = 30.0
"""Assumed of images that tell no time."""
_FEWEST = 3


def _too_few(root: Path) -> int:
    """How many images a folder without other folders holds, where those are too few; else 0."""
    if not root.is_dir() or any(one.is_dir() for one in root.iterdir()):
        return 0
    count = sum(one.suffix.lower() in SUFFIXES for one in root.iterdir())
    return count if count < _FEWEST else 0


def _folder_of_images(root: Path) -> Path | None:
    """The folder, or the only one in it, with three images or more."""
    if not root.is_dir():
        return None
    if _enough(root):
        return root
    inner = [one for one in sorted(root.iterdir()) if one.is_dir() and _enough(one)]
    return inner[0] if len(inner) == 1 else None


def _enough(folder: Path) -> bool:
    images = (one for one in folder.iterdir() if one.suffix.lower() in SUFFIXES)
    return sum(1 for _, _ in zip(images, range(_FEWEST), strict=False)) == _FEWEST


class LayoutReader(Protocol):
    """Reads a folder of one layout; without `own_truth` it leaves the folder's truth aside."""

    def __call__(self, root: Path, *, own_truth: bool = True) -> Recording:
        """Open the folder; raises as `open_recording`."""
        ...


LAYOUTS: tuple[tuple[Callable[[Path], bool], LayoutReader, str], ...] = (
    (euroc.recognise, euroc.read, "EuRoC (mav0/cam0/data.csv)"),
    (tum_rgbd.recognise, tum_rgbd.read, "TUM RGB-D (rgb.txt)"),
    (seven_scenes.recognise, seven_scenes.read, "7-Scenes (frame-000000.color.png)"),
    (kitti.recognise, kitti.read, "KITTI (calib.txt beside image_2, image_0 or image_l)"),
    (tagslam.recognise, tagslam.read, "TagSLAM's corners (tag_detections.bag)"),
    (ros.recognise, ros.read, "a ROS bag (.bag, .mcap, metadata.yaml)"),
    (video.recognise, video.read, "a video file"),
)


_STILLS = (*SUFFIXES, ".heic", ".heif", ".tif", ".tiff", ".webp", ".dng")
_PACKED = (".zip", ".tar", ".tgz", ".gz", ".xz", ".7z", ".rar", ".zst")
_OTHER_VIDEOS = (".gif", ".wmv", ".asf", ".flv", ".f4v", ".ogv", ".mxf")
"""Films that FFmpeg converts and that are not read here."""


def find_layout(root: Path) -> LayoutReader | None:
    """The reader for a folder or file; None where no layout is recognised."""
    return next((read for recognise, read, _ in LAYOUTS if recognise(root)), None)


def read_layout(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a recording whose layout is known, or a folder that holds nothing but images.

    Args:
        root: folder or file.
        own_truth: whether to read the ground truth that lies there; a manifest may name another.

    Raises:
        RecordingError: no known layout, with what was looked for; or what its reader refuses.
    """
    read = find_layout(root)
    if read is not None:
        return read(root, own_truth=own_truth)
    if (folder := _folder_of_images(root)) is not None:
        files = images_in(folder)
        shown_size, orientation = first_look(files)
        time_ns = stamps_of_names(files, RATE_HZ)
        frames = ImageFrames(files, time_ns, orientation=orientation, shown_size=shown_size)
        return Recording(root.resolve().name, root, LOOSE_IMAGES, frames)
    if root.is_dir() and not any(root.iterdir()):
        raise refusal(root, "expected a recording, got an empty folder")
    _refuse_other_images(root)
    few = _too_few(root)
    if few:
        raise refusal(
            root,
            f"expected {_FEWEST} images or more, got {few}: they tell no path",
            advice="`motorcade detect` finds markers in single images",
        )
    looked_for = ", ".join(what for _, _, what in LAYOUTS)
    raise refusal(
        root,
        f"expected a recording, got neither {looked_for} nor motorcade.toml",
        advice="describe any other folder of images in a manifest (docs/manifests)"
        if root.is_dir()
        else f"`motorcade inspect {root}` says whether it holds poses or readings"
        if root.suffix.lower() in TEXT_SUFFIXES
        else "files of poses and readings are for smooth, orient, fuse and evaluate",
    )


def _refuse_other_images(root: Path) -> None:
    """Say what to do with a file that holds images, but no video that is read here.

    Raises:
        RecordingError: such a file.
    """
    kind = root.suffix.lower() if root.is_file() else ""
    if kind in _STILLS:
        raise refusal(
            root,
            "expected a recording, got one image, which tells no path",
            advice="give the video, or a folder with images of one place in the order of their "
            "names",
        )
    if kind in _PACKED:
        problem = f"expected a recording, got what is packed as {kind}"
        raise refusal(root, problem, advice="unpack it, and give the folder or the file within")
    if kind in _OTHER_VIDEOS:
        raise refusal(
            root,
            f"expected a video in one of {' '.join(video.SUFFIXES)}, got {kind}",
            advice="give the video that it was made of, or convert it: "
            f"ffmpeg -i {quote(root.name)} -vf 'crop=trunc(iw/2)*2:trunc(ih/2)*2' "
            f"-pix_fmt yuv420p {quote(root.stem + '.mp4')}",
        )
