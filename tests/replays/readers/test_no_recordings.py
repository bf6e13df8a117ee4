"""Files and folders that hold images and are no recording: what people are told to do."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("shot.jpg", "got one image, which tells no path; give the video"),
        ("shot.HEIC", "got one image"),
        ("my film.gif", r"got \.gif; .* ffmpeg -i 'my film\.gif' -vf .* 'my film\.mp4'"),
        ("old.WMV", r"got \.wmv"),
    ],
)
def test_images_that_are_no_video_are_refused_with_what_to_do(
    tmp_path: Path, name: str, told: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"GIF89a")
    with pytest.raises(RecordingError, match=told):
        open_recording(path)


def test_a_folder_of_too_few_images_is_told_so(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "one.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "README.md").write_text("one image")
    with pytest.raises(RecordingError, match="expected 3 images or more, got 1: they tell no"):
        open_recording(tmp_path)
