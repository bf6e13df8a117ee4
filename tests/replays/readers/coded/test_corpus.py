"""Videos of every coding, container and fault are read as FFmpeg plays them.

Witnesses: the images that went in, OpenCV's own FFmpeg (how many, and which pixels), and ffprobe
(stamps) where it is installed.
"""

import json
import shutil
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.io.readers.frames.video import VideoFrames
from tests.replays.readers.coded.corpus import CASES, Case, number_of, numbered_image, write_case

DAMAGED = ("broken_image", "flipped_bytes", "no_first_key")
OUT_OF_ORDER = ("repeated_stamps", "stored_order")
FEW = (
    Case("h264_b", ".avi"),
    Case("h264_b", ".mp4", "stored_order"),
    Case("h264_b", ".ts", "broken_image"),
    Case("mpeg4", ".mp4", "no_first_key"),
    Case("vp8", ".webm", "no_first_key"),
    Case("mjpeg", ".mov", "broken_image"),
    Case("h264_b", ".mp4", "cut"),
    Case("hevc", ".mp4", "edit_list"),
)


def _check(folder: Path, case: Case) -> None:
    path = write_case(folder, case)
    frames, said = VideoFrames(path).intact(None)
    images = [frame.image() for frame in frames]
    turned = frames.orientation.quarter_turns
    as_stored = [np.rot90(image, turned) for image in images]
    seen, count = _opencv(path)
    left_out = frames._images.damaged
    assert np.all(np.diff(frames.time_ns) > 0)
    assert bool(said) == bool(left_out or frames._images.lost)
    if case.fault in DAMAGED:
        assert 2 <= len(frames) <= 24
        assert frames.notes or case.coding in ("vp8", "vp9", "hevc", "mjpeg", "ffv1", "mpeg4_b")
        return
    # OpenCV stops at the packet that is cut, where FFmpeg's programs show all that is before it;
    # and it may lack a decoder of AV1.
    slack = 2 if case.fault == "cut" else 0
    assert 0 <= len(frames) + len(left_out) - count <= slack or not count
    numbers = [number_of(image) for image in as_stored]
    assert numbers == sorted(numbers)
    for at, image in enumerate(as_stored):
        if frames._places[at] < count:
            assert np.abs(image.astype(int) - seen[frames._places[at]]).mean() < 1.0
        assert (
            np.abs(image.astype(int) - numbered_image(numbers[at], image.shape[1::-1])).mean()
            < 12.0
        )
    for at in np.random.default_rng(1).permutation(len(frames))[:8].tolist():
        assert np.array_equal(frames[at].image(), images[at])
    if shutil.which("ffprobe") and case.fault not in OUT_OF_ORDER:
        told = np.array(_probed(path))
        assert len(told) == len(frames) + len(left_out)
        told = told[frames._places]
        assert np.abs(1e-9 * frames.time_ns - told).max() < 1e-3


def _opencv(path: Path) -> tuple[list[np.ndarray], int]:
    """Images as stored, RGB, and how many."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    found = []
    while (read := capture.read())[0]:
        found.append(read[1][..., ::-1])
    return found, len(found)


def _probed(path: Path) -> list[float]:
    entries = "frame=best_effort_timestamp_time"
    command = ["ffprobe", "-v", "quiet", "-select_streams", "v", "-show_entries", entries]
    done = subprocess.run([*command, "-of", "json", str(path)], capture_output=True, check=True)
    stamps = [
        frame.get("best_effort_timestamp_time") for frame in json.loads(done.stdout)["frames"]
    ]
    known = np.array([np.nan if one is None else float(one) for one in stamps])
    missing = np.isnan(known)  # the last ones, for which FFmpeg counts on
    known[missing] = known[~missing].max() + 0.04 * np.arange(1, 1 + missing.sum())
    return known.tolist()


@pytest.mark.parametrize("case", FEW, ids=lambda case: case.name)
def test_a_few_are_read_as_ffmpeg_plays_them(tmp_path: Path, case: Case) -> None:
    _check(tmp_path, case)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_all_are_read_as_ffmpeg_plays_them(tmp_path: Path, case: Case) -> None:
    _check(tmp_path, case)
