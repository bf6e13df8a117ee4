"""Video files, with ffprobe and PyAV as witnesses."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np
import pytest

from motorcade.ga.files import FileError
from motorcade.render import read_frames, video, write_video
from motorcade.render.scene import ImageArray
from motorcade.render.video import (
    KEYFRAME_FRAMES,
    contact_sheet,
    read_stamps_s,
)

UNEVEN_NS = np.array([0, 33_333_333, 66_666_667, 166_666_667, 200_000_000, 233_333_333])


def images(count: int, height: int = 120, width: int = 160) -> Iterator[ImageArray]:
    """Smooth moving gradients, which H.264 keeps well."""
    y, x = np.mgrid[:height, :width]
    for k in range(count):
        wave = 128 + 100 * np.sin((x + 4 * k) / 25.0) * np.cos(y / 30.0)
        yield np.stack([wave, 255 - wave, 0.5 * wave + 40], axis=-1).astype(np.uint8)


def test_frames_and_stamps_come_back(tmp_path: Path) -> None:
    write_video(tmp_path / "v.mp4", images(6), UNEVEN_NS)
    back = list(read_frames(tmp_path / "v.mp4"))
    stamps = np.array([stamp for stamp, _ in back])
    assert np.abs(stamps - UNEVEN_NS).max() <= 1e9 / 90_000 / 2 + 1
    for (_, seen), given in zip(back, images(6), strict=True):
        assert seen.shape == given.shape
        assert np.abs(seen.astype(int) - given).mean() < 3.0


def test_stamps_start_at_the_first(tmp_path: Path) -> None:
    write_video(tmp_path / "v.mp4", images(6), UNEVEN_NS + 1_403_715_273_262_142_976)
    assert next(iter(read_frames(tmp_path / "v.mp4")))[0] == 0


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="ffprobe is not installed")
def test_ffprobe_finds_h264_of_the_right_length(tmp_path: Path) -> None:
    file = tmp_path / "v.mp4"
    write_video(file, images(6), UNEVEN_NS)
    told = subprocess.run(
        [
            "ffprobe",
            "-v",
            "error",
            "-of",
            "json",
            "-show_streams",
            "-show_format",
            "-count_frames",
            str(file),
        ],
        check=True,
        capture_output=True,
        text=True,
    )
    report = json.loads(told.stdout)
    stream = report["streams"][0]
    assert (stream["codec_name"], stream["pix_fmt"]) == ("h264", "yuv420p")
    assert (stream["width"], stream["height"]) == (160, 120)
    assert int(stream["nb_read_frames"]) == 6
    assert stream["color_space"] == "bt709"
    assert "encoder" not in report["format"].get("tags", {})
    assert float(stream["duration"]) == pytest.approx(0.2667, abs=1e-3)


def test_the_index_comes_before_the_images(tmp_path: Path) -> None:
    write_video(tmp_path / "v.mp4", images(6), UNEVEN_NS)
    data = (tmp_path / "v.mp4").read_bytes()
    assert 0 < data.find(b"moov") < data.find(b"mdat")


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    stamps = np.arange(40) * 33_333_333
    for name in ("one.mp4", "two.mp4"):
        write_video(tmp_path / name, images(40, 241, 321), stamps)
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()


def test_any_frame_is_near_a_keyframe_and_stamps_are_told(tmp_path: Path) -> None:
    stamps = np.cumsum(np.tile([33_000_000, 41_000_000], 30))
    write_video(tmp_path / "v.mp4", images(60, 120, 160), stamps)
    with av.open(str(tmp_path / "v.mp4")) as file:
        frames = list(file.decode(video=0))
    keys = [k for k, frame in enumerate(frames) if frame.key_frame]
    assert max(np.diff([*keys, 60])) <= KEYFRAME_FRAMES
    told = read_stamps_s(tmp_path / "v.mp4")
    np.testing.assert_allclose(told, (stamps - stamps[0]) * 1e-9, atol=1e-5)
    np.testing.assert_allclose(told, [frame.time for frame in frames], atol=1e-9)
    with pytest.raises(FileError, match="the file is missing"):
        read_stamps_s(tmp_path / "absent.mp4")


def test_odd_sizes_gain_one_row_and_column(tmp_path: Path) -> None:
    write_video(tmp_path / "v.mp4", images(3, 121, 161), UNEVEN_NS[:3])
    _, seen = next(iter(read_frames(tmp_path / "v.mp4")))
    assert seen.shape == (122, 162, 3)


@pytest.mark.parametrize(
    ("count", "stamps", "message"),
    [
        (5, UNEVEN_NS, "expected 6 frames, got 5"),
        (7, UNEVEN_NS, "expected 6 frames, got more"),
        (2, np.array([0, 0]), "increasing"),
        (2, np.array([0, 5]), "apart and increasing"),
        (2, np.array([5, 0]), "increasing"),
        (2, np.array([0.0, 1.0]), "integers"),
        (0, np.array([], dtype=np.int64), "integers of shape"),
    ],
)
def test_frames_and_stamps_that_do_not_fit_are_refused(
    tmp_path: Path, count: int, stamps: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        write_video(tmp_path / "v.mp4", images(count), stamps)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_leaves_the_earlier_file_alone(tmp_path: Path) -> None:
    file = tmp_path / "v.mp4"
    write_video(file, images(2), UNEVEN_NS[:2])
    before = file.read_bytes()

    def broken() -> Iterator[ImageArray]:
        yield from images(1)
        raise OSError("the disk is gone")

    with pytest.raises(OSError, match="the disk is gone"):
        write_video(file, broken(), UNEVEN_NS[:2])
    assert file.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["v.mp4"]


def test_other_endings_and_shapes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"\.mp4"):
        write_video(tmp_path / "v.avi", images(2), UNEVEN_NS[:2])
    grey = [np.zeros((8, 8), dtype=np.uint8)] * 2
    with pytest.raises(ValueError, match="RGB images"):
        write_video(tmp_path / "v.mp4", grey, UNEVEN_NS[:2])
    mixed = [np.zeros((8, 8, 3), dtype=np.uint8), np.zeros((8, 10, 3), dtype=np.uint8)]
    with pytest.raises(ValueError, match=r"shape \(8, 8, 3\)"):
        write_video(tmp_path / "v.mp4", mixed, UNEVEN_NS[:2])


def test_lossless_video_gives_back_every_byte(tmp_path: Path, rng: np.random.Generator) -> None:
    given = [rng.integers(0, 256, (33, 47, 3), dtype=np.uint8) for _ in UNEVEN_NS]
    write_video(tmp_path / "v.mkv", given, UNEVEN_NS)
    back = list(read_frames(tmp_path / "v.mkv"))
    assert np.abs(np.array([stamp for stamp, _ in back]) - UNEVEN_NS).max() <= 500_000
    for (_, seen), one in zip(back, given, strict=True):
        np.testing.assert_array_equal(seen, one)
    write_video(tmp_path / "again.mkv", given, UNEVEN_NS)
    assert (tmp_path / "v.mkv").read_bytes() == (tmp_path / "again.mkv").read_bytes()


def test_a_contact_sheet_holds_every_frame_in_order() -> None:
    frames = [np.full((60, 80, 3), 20 * k, dtype=np.uint8) for k in range(5)]
    sheet = contact_sheet(frames, columns=3, width=40)
    assert sheet.shape == (2 * 36 + 6, 3 * 46 + 6, 3)
    middles = [sheet[21, 26], sheet[21, 72], sheet[21, 118], sheet[57, 26], sheet[57, 72]]
    np.testing.assert_array_equal(np.array(middles)[:, 0], [0, 20, 40, 60, 80])
    with pytest.raises(ValueError, match="one size"):
        contact_sheet([], 3, 40)
    with pytest.raises(ValueError, match="a label a frame"):
        contact_sheet(frames, 3, 40, labels=["a"])


@pytest.mark.parametrize(
    "text",
    [
        "ffconcat version 1.0\nfile pipe.mp4\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\npipe.ts\n#EXT-X-ENDLIST\n",
    ],
    ids=["ffconcat", "m3u8"],
)
def test_lists_of_other_files_are_no_videos(tmp_path: Path, text: str) -> None:
    """Opening what such a list names would wait for a pipe without end."""
    os.mkfifo(tmp_path / "pipe.mp4")
    os.mkfifo(tmp_path / "pipe.ts")
    (tmp_path / "list.mp4").write_text(text)
    with pytest.raises((OSError, ValueError), match="Invalid"):
        next(read_frames(tmp_path / "list.mp4"))


def test_pipes_and_missing_files_are_refused_as_videos(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mp4")
    with pytest.raises(FileError, match="expected a file, got a folder or a device"):
        next(read_frames(tmp_path / "pipe.mp4"))
    with pytest.raises(FileError, match="the file is missing"):
        next(read_frames(tmp_path / "none.mp4"))


def test_images_beyond_the_limit_are_not_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    image = np.zeros((64, 96, 3), np.uint8)
    write_video(tmp_path / "v.mp4", [image] * 3, np.arange(3) * 40_000_000)
    assert len(list(read_frames(tmp_path / "v.mp4"))) == 3
    monkeypatch.setattr(video, "MAX_PIXELS", 64 * 96 - 1)
    with pytest.raises((OSError, ValueError)):
        next(read_frames(tmp_path / "v.mp4"))


@pytest.mark.parametrize("gap_s", [11.0, 86_400.0, 946_080_000.0])
def test_a_film_does_not_stand_still_through_a_long_gap(tmp_path, rng, gap_s):
    """Neither does it overflow the ticks of its format."""
    stamps = np.arange(6) * 100_000_000
    stamps[3:] += round(gap_s * 1e9)
    frames = [rng.integers(0, 255, (16, 24, 3), dtype=np.uint8) for _ in stamps]
    write_video(tmp_path / "film.mp4", frames, stamps)
    shown = np.array([stamp for stamp, _ in read_frames(tmp_path / "film.mp4")])
    assert np.allclose(np.diff(shown) * 1e-9, [0.1, 0.1, 10.0, 0.1, 0.1], atol=1e-4)


def test_frames_that_are_days_apart_are_no_film(tmp_path, rng):
    stamps = np.arange(4) * 86_400_000_000_000
    with pytest.raises(ValueError, match="expected stamps at most 21600 s apart, got 86400 s"):
        write_video(tmp_path / "film.mp4", [], stamps)
