"""Opening a recording: by its manifest, or by the layout that its folder has."""

from __future__ import annotations

from pathlib import Path

from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers import manifest as manifests
from motorcade.replays.io.readers.layouts import euroc
from motorcade.replays.io.readers.layouts.detect import read_layout
from motorcade.replays.io.readers.ros import recording as ros
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.replays.io.trajectories import split_bag_name


def open_recording(path: Path | str, manifest: Path | str | None = None) -> Recording:
    r"""Open a folder of any known layout, or a video file.

    Args:
        path: a recording of a layout in `docs/recordings.md` (`BAG:/topic` names a bag's
            images), or any folder with a manifest.
        manifest: TOML file that describes the recording or adds to its layout (see
            `docs/manifests`). It may lie anywhere. Without it, `motorcade.toml` in the folder is
            used where there is one; since that one came with the recording, it may not point
            outside the folder.

    Raises:
        RecordingError: nothing there, no known layout (the message lists what was looked for), or
            whatever the layout's reader refuses.

    Twenty grey images at 30 Hz, described by a manifest:

    >>> import tempfile
    >>> import cv2, numpy as np
    >>> from pathlib import Path
    >>> from motorcade.replays import open_recording
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for number in range(20):
    ...         name = str(Path(folder) / f"{number:02}.png")
    ...         written = cv2.imwrite(name, np.full((48, 64), 128, np.uint8))
    ...     manifest = Path(folder) / "motorcade.toml"
    ...     count = manifest.write_text('[frames]\nimages = "*.png"\nrate_hz = 30.0')
    ...     recording = open_recording(folder)
    ...     shape = recording.frames[3].image().shape
    >>> len(recording.frames), round(recording.duration_s, 3), shape
    (20, 0.633, (48, 64))
    """
    root, topic = recording_and_topic(path)
    try:
        if not root.exists():
            raise refusal(root, "no such file or folder")
        if not (root.is_dir() or root.is_file()):
            raise refusal(root, "expected a folder or a file, got a pipe or a device")
        if manifest is not None:
            return manifests.read(root, Path(manifest), may_leave=True, topic=topic)
        if (root / manifests.LOCAL_NAME).exists():
            local = root / manifests.LOCAL_NAME
            return manifests.read(root, local, may_leave=False, topic=topic)
        return read_layout(root) if topic is None else ros.read(root, topic=topic)
    except OSError as fault:
        where = fault.filename or root
        raise refusal(where, f"cannot be read: {fault.strerror or fault}") from fault


def recording_and_topic(path: Path | str) -> tuple[Path, str | None]:
    """A recording, and the topic that is named in it, `BAG:/topic`; None where none is.

    >>> recording_and_topic("clip.mp4")
    (PosixPath('clip.mp4'), None)
    """
    named = None if Path(path).exists() else split_bag_name(path)
    return (Path(path), None) if named is None else (named[0], named[1] or None)


def read_frames_of(path: Path) -> FrameSequence:
    """The images of a recording whose camera need not be known yet.

    Raises:
        RecordingError: as `open_recording`.
    """
    if path.is_dir() and euroc.recognise(path) and not (path / manifests.LOCAL_NAME).exists():
        return euroc.read_images(path)
    return open_recording(path).frames
