"""Films of videos: frame times, colours and sound of the original, with PyAV and ffprobe as
witnesses.
"""

import json
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import numpy as np
import pytest

from motorcade.render import read_frames, write_video
from motorcade.render.video import CopiedSound, _counted, read_original

CLOCK = Fraction(1, 600)  # a phone's
TICKS = np.cumsum([0, 20, 20, 21, 40, 19, 20, 20, 60, 20, 20, 20])
CODINGS = {  # matrix, primaries, transfer, levels
    "BT.709": (1, 1, 1, 1),
    "BT.601": (6, 6, 6, 1),
    "BT.709, full": (1, 1, 1, 2),
    "BT.2020": (9, 9, 14, 1),
    "P3, HLG": (9, 12, 18, 1),
    "not told": (2, 2, 2, 0),
}


def _image(index: int) -> np.ndarray:
    y, x = np.mgrid[:64, :96]
    wave = 128 + 90 * np.sin((x + 3 * index) / 15.0) * np.cos(y / 20.0)
    return np.stack([wave, 255 - wave, 0.6 * wave + 60], axis=-1).astype(np.uint8)


def _write(path: Path, coding: tuple[int, ...] = CODINGS["BT.709"], sound: str = "aac") -> Path:
    """A clip with uneven stamps, B-frames and, longer than its images, sound."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=30, options={"crf": "8"})
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        context = stream.codec_context
        context.time_base = CLOCK
        context.colorspace, context.color_primaries, context.color_trc = coding[:3]
        context.color_range = coding[3]
        matrix = {2: 5, 6: 5}.get(coding[0], coding[0])
        track = file.add_stream(sound, rate=44_100, layout="mono") if sound else None
        for index, tick in enumerate(TICKS):
            rgb = av.VideoFrame.from_ndarray(_image(index), format="rgb24")
            frame = rgb.reformat(
                format="yuv420p", dst_colorspace=matrix, dst_color_range=max(coding[3], 1)
            )
            frame.pts, frame.time_base = int(tick), CLOCK
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
        if track is not None:
            rng = np.random.default_rng(0)
            for start in range(0, 22_050, 1024):
                noise = rng.uniform(-0.2, 0.2, (1, 1024)).astype(np.float32)
                heard = av.AudioFrame.from_ndarray(noise, format="fltp", layout="mono")
                heard.rate, heard.pts, heard.time_base = 44_100, start, Fraction(1, 44_100)
                file.mux(track.encode(heard))
            file.mux(track.encode(None))
    return path


def _made(source: Path, film: Path) -> Path:
    given = list(read_frames(source))
    stamps = np.array([stamp for stamp, _ in given])
    write_video(film, (image for _, image in given), stamps, read_original(source))
    return film


def _packets(path: Path, kind: str) -> list[tuple[float, bytes]]:
    with av.open(str(path)) as file:
        stream = next(one for one in file.streams if one.type == kind)
        packets = [one for one in file.demux(stream) if one.size]
        return [(float(one.pts * one.time_base), bytes(one)) for one in packets]


def test_frame_times_are_the_originals(tmp_path: Path) -> None:
    source = _write(tmp_path / "clip.mp4")
    film = _made(source, tmp_path / "film.mp4")
    for path in (source, film):
        with av.open(str(path)) as file:
            stamps = [one.pts * one.time_base for one in file.decode(video=0)]
        assert stamps == [int(tick) * CLOCK for tick in TICKS]


@pytest.mark.parametrize("sound", ["aac", "mp3", "ac3"])
def test_sound_is_copied_packet_by_packet_and_in_step(tmp_path: Path, sound: str) -> None:
    source = _write(tmp_path / "clip.mp4", sound=sound)
    film = _made(source, tmp_path / "film.mp4")
    before, after = _packets(source, "audio"), _packets(film, "audio")
    assert len(before) >= 15
    assert [data for _, data in after] == [data for _, data in before]
    apart = np.subtract([at for at, _ in after], [at for at, _ in before])
    assert np.abs(apart).max() <= 1.0 / 44_100


@pytest.mark.parametrize("last", [2, 5, 8])
def test_the_sound_of_a_part_ends_with_it(tmp_path: Path, last: int) -> None:
    source = _write(tmp_path / "clip.mp4")
    images = [image for _, image in read_frames(source)][: last + 1]
    stamps = [round(1e9 * float(tick * CLOCK)) for tick in TICKS]
    part = replace(read_original(source), until_ns=stamps[last + 1])
    write_video(tmp_path / "film.mp4", images, np.array(stamps[: last + 1]), part)
    before = [one for one in _packets(source, "audio") if one[0] < 1e-9 * stamps[last + 1]]
    assert [data for _, data in _packets(tmp_path / "film.mp4", "audio")] == [
        data for _, data in before
    ]


def test_sound_that_begins_with_the_first_image_is_kept(tmp_path: Path) -> None:
    """A film's start is in whole nanoseconds, and may be rounded to after the sound's."""
    source = _write(tmp_path / "clip.mp4")
    begins = [Fraction(1024 * k, 44_100) for k in range(20)]
    late_ns = next(round(one * 10**9) for one in begins if round(one * 10**9) > one * 10**9)
    with av.open(str(source)) as taken, av.open(str(tmp_path / "film.mp4"), "w") as film:
        sound = CopiedSound(taken, film, late_ns)
        assert 0 in [packet.dts for packet in sound.until(1.0)]


def test_sound_stays_in_step_where_the_video_starts_late(tmp_path: Path) -> None:
    source, late = _write(tmp_path / "clip.mp4"), tmp_path / "late.mkv"
    with av.open(str(source)) as taken, av.open(str(late), "w") as file:
        tracks = [file.add_stream_from_template(one) for one in taken.streams]
        for packet in taken.demux():
            if packet.size and packet.dts is not None:
                moved = Fraction(3) if packet.stream.type == "video" else Fraction(11, 4)
                shift = int(moved / packet.time_base)
                packet.stream = tracks[packet.stream_index]
                packet.pts, packet.dts = packet.pts + shift, packet.dts + shift
                file.mux(packet)
    film = _made(late, tmp_path / "film.mp4")
    assert min(at for at, _ in _packets(film, "video")) == 0.0
    heard = {data: at for at, data in _packets(late, "audio")}
    kept = _packets(film, "audio")
    assert 0 < len(kept) < len(heard)  # the first quarter of a second has no images
    assert max(abs(at - (heard[data] - 3.0)) for at, data in kept) < 2e-3  # Matroska counts in ms


def test_sound_of_an_avi_moves_by_less_than_a_packet(tmp_path: Path) -> None:
    """Its clock counts packets of 26 ms, and its first image is shown after two others."""
    source, kept = _write(tmp_path / "clip.mp4", sound="mp3"), tmp_path / "clip.avi"
    with av.open(str(source)) as taken, av.open(str(kept), "w") as file:
        track = file.add_stream_from_template(taken.streams.audio[0])
        for packet in taken.demux(audio=0):
            if packet.size:
                packet.stream = track
                file.mux(packet)
    before = {data: at for at, data in _packets(kept, "audio")}
    with av.open(str(kept)) as taken, av.open(str(tmp_path / "film.mp4"), "w") as film:
        for packet in CopiedSound(taken, film, 66_666_667).until(10.0):
            film.mux(packet)
    after = _packets(tmp_path / "film.mp4", "audio")
    assert len(after) > 10
    assert max(abs(before[data] - at - 0.0666667) for at, data in after) < 1e-3


@pytest.mark.parametrize("name", CODINGS)
def test_colours_are_coded_as_in_the_original(tmp_path: Path, name: str) -> None:
    source = _write(tmp_path / "clip.mp4", CODINGS[name])
    film = _made(source, tmp_path / "film.mp4")
    seen = []
    for path in (source, film):
        with av.open(str(path)) as file:
            frame = next(file.decode(video=0))
            told = (frame.colorspace, frame.color_primaries, frame.color_trc, frame.color_range)
            seen.append((tuple(map(int, told)), [_plane(one) for one in frame.planes]))
    assert seen[0][0] == seen[1][0] == CODINGS[name]
    for before, after in zip(seen[0][1], seen[1][1], strict=True):  # coded numbers, not colours
        assert np.abs(before.astype(int) - after).mean() < 2.0
    if shutil.which("ffprobe") is None:
        pytest.skip("ffprobe, the second witness, is not installed")
    keys = "color_space,color_primaries,color_transfer,color_range"
    told = [_probed(path, f"stream={keys}") for path in (source, film)]
    assert told[0] == told[1]


def _plane(plane: av.video.plane.VideoPlane) -> np.ndarray:
    rows = np.frombuffer(bytes(plane), np.uint8).reshape(-1, plane.line_size)
    return rows[: plane.height, : plane.width]


def _probed(path: Path, entries: str) -> dict[str, str]:
    command = ["ffprobe", "-v", "error", "-select_streams", "v", "-show_entries", entries]
    done = subprocess.run([*command, "-of", "json", str(path)], capture_output=True, check=True)
    return dict(json.loads(done.stdout)["streams"][0])


def test_sound_that_the_film_cannot_hold_is_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    film = _made(_write(tmp_path / "clip.mkv", sound="wavpack"), tmp_path / "film.mp4")
    with av.open(str(film)) as file:
        held = len(file.streams.audio)
    assert held == 0
    assert "sound of" in caplog.text
    assert "(wavpack) is left out" in caplog.text


def test_a_silent_video_makes_a_silent_film(tmp_path: Path) -> None:
    film = _made(_write(tmp_path / "clip.mp4", sound=""), tmp_path / "film.mp4")
    with av.open(str(film)) as file:
        assert [one.type for one in file.streams] == ["video"]


def test_only_mp4_keeps_what_the_original_had(tmp_path: Path) -> None:
    original = read_original(_write(tmp_path / "clip.mp4"))
    with pytest.raises(ValueError, match=r"write_video\(original\): expected a film in \.mp4"):
        write_video(tmp_path / "film.mkv", [_image(0)], np.array([0]), original)


def packets(dts: list[int], time_base: Fraction, frame_size: int) -> Iterator[Any]:
    """Packets of one track of 44.1 kHz with these stamps."""
    context = SimpleNamespace(frame_size=frame_size, sample_rate=44_100)
    for stamp in dts:
        yield SimpleNamespace(
            size=300,
            dts=stamp,
            pts=stamp,
            duration=1,
            time_base=time_base,
            stream_index=1,
            stream=SimpleNamespace(codec_context=context),
        )


def test_sound_whose_stamps_repeat_is_counted_by_how_long_it_sounds() -> None:
    """As an AVI gives AAC that stands several packets a chunk."""
    a_frame = Fraction(1024, 44_100)
    counted = _counted(packets([0, 0, 0, 0, 1, 1, 1, 2], a_frame, 1024))
    assert [packet.dts for packet in counted] == list(range(8))
    fine = _counted(packets([7, 7, 7, 8, 8], Fraction(1, 1000), 1024))
    assert [packet.dts for packet in fine] == [7, 30, 53, 77, 100]


@pytest.mark.parametrize("stamps", [[0, 1, 2, 3], [0, 23, 46, 70, 300, 323]])
def test_sound_whose_stamps_rise_keeps_them(stamps: list[int]) -> None:
    assert [one.dts for one in _counted(packets(stamps, Fraction(1, 1000), 1024))] == stamps
