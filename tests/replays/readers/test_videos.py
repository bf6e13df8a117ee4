"""Videos: the container's stamps, images equal to a plain pass, whatever the order asked for."""

import pickle
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.packets import said_of_cut
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.frames.views import frames_between
from motorcade.replays.io.readers.opening import open_recording


@pytest.fixture
def shown(video_file: Path) -> list[tuple[int, np.ndarray]]:
    """Stamps (ns) and images by a plain pass of PyAV."""
    with av.open(str(video_file)) as container:
        return [
            (round(1e9 * frame.pts * frame.time_base), frame.to_ndarray(format="rgb24"))
            for frame in container.decode(video=0)
        ]


def test_stamps_and_images_are_those_of_a_plain_pass(
    video_file: Path, shown: list[tuple[int, np.ndarray]]
) -> None:
    frames = open_recording(video_file).frames
    assert frames.time_ns.tolist() == [stamp for stamp, _ in shown]
    assert len(set(np.diff(frames.time_ns).tolist())) > 1
    for frame, (_, image) in zip(frames, shown, strict=True):
        assert np.array_equal(frame.image(), image)


def test_any_order_gives_the_same_images(
    video_file: Path, shown: list[tuple[int, np.ndarray]]
) -> None:
    frames = VideoFrames(video_file)
    for index in [30, 29, 59, 0, 0, 11, 12, 13, 47, 48, *np.random.default_rng(0).permutation(60)]:
        assert np.array_equal(frames[int(index)].image(), shown[index][1]), index


def test_reading_in_order_opens_the_file_once(
    video_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = VideoFrames(video_file)
    opened = []
    plain = av.open
    monkeypatch.setattr(
        "av.open", lambda path, **options: opened.append(path) or plain(path, **options)
    )
    for frame in frames:
        frame.image()
        frame.gray()
    assert len(opened) == 1


def test_a_video_can_be_sent_to_another_process(video_file: Path) -> None:
    frames = VideoFrames(video_file)
    first = frames[3].image()
    assert np.array_equal(pickle.loads(pickle.dumps(frames))[3].image(), first)


def test_a_part_tells_when_the_whole_goes_on(video_file: Path) -> None:
    whole = VideoFrames(video_file)
    stamps = whole.time_ns.tolist()
    parts = [
        frames_between(whole, stamps[first], stamps[last]) for first, last in ((0, 3), (2, -1))
    ]
    assert [part.followed_ns for part in (whole, *parts)] == [None, stamps[4], None]
    again = pickle.loads(pickle.dumps(parts[0]))
    assert again.followed_ns == stamps[4]


def test_a_manifest_gives_a_video_its_camera(video_file: Path, tmp_path: Path) -> None:
    manifest = tmp_path / "clip.toml"
    camera = "[camera]\nfx = 60\nfy = 60\ncx = 31.5\ncy = 23.5\n"
    manifest.write_text(camera)
    recording = open_recording(video_file, manifest)
    recording.check()
    assert recording.camera is not None
    assert (recording.camera.width, recording.camera.height) == (64, 48)
    folder = tmp_path / "folder"
    folder.mkdir()
    video_file.rename(folder / "clip.mp4")
    manifest.write_text('[frames]\nvideo = "clip.mp4"\n' + camera)
    assert open_recording(folder, manifest).layout == "video"
    manifest.write_text('[frames]\nvideo = "clip.mp4"\nrate_hz = 30\n')
    with pytest.raises(RecordingError, match="rate_hz: not for a video"):
        open_recording(folder, manifest)
    manifest.write_text('[frames]\nvideo = "clip.mp4"\n' + camera + "width = 65\nheight = 48\n")
    with pytest.raises(RecordingError, match="expected 65 x 48 pixels as the camera has, got 64"):
        open_recording(folder, manifest)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.6])
def test_a_video_whose_index_is_cut_off_is_refused(video_file: Path, share: float) -> None:
    data = video_file.read_bytes()
    video_file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(
        RecordingError,
        match=r"clip\.mp4: (the video is truncated: its box 'mdat'|the file is empty)",
    ):
        open_recording(video_file)


def test_a_video_whose_index_stands_in_front_is_counted(video_file: Path, tmp_path: Path) -> None:
    front = tmp_path / "front.mp4"
    with (
        av.open(str(video_file)) as source,
        av.open(str(front), "w", options={"movflags": "faststart"}) as target,
    ):
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.size:
                packet.stream = stream
                target.mux(packet)
    assert len(VideoFrames(front)) == 60
    data = front.read_bytes()
    front.write_bytes(data[: len(data) * 3 // 4])
    frames, _ = VideoFrames(front).intact(None)
    assert 20 < len(frames) < 60
    assert "the video is truncated: its box 'mdat'" in frames.notes[0]
    whole = VideoFrames(video_file)
    for index in (len(frames) - 1, 0):
        assert np.array_equal(frames[index].image(), whole[index].image())


def test_fewer_images_than_the_index_promises_are_said(
    video_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motorcade.replays.io.readers.frames import packets

    plain = packets.stored_packets
    monkeypatch.setattr(packets, "stored_packets", lambda *given: islice(plain(*given), 50))
    assert "expected 60 images, got 50: what is there is read" in VideoFrames(video_file).notes[0]
    monkeypatch.setattr(packets, "_unedited", lambda path: 60)
    packets.scan.cache_clear()
    assert not VideoFrames(video_file).notes  # as where an edit list cuts the others away


@pytest.mark.parametrize("keys_apart", ["12", "300"])
def test_a_clip_trimmed_by_an_edit_list_holds_what_is_shown(
    tmp_path: Path, keys_apart: str
) -> None:
    """As phones trim: all images stay in the file, from the keyframe on, and some are hidden.

    Where keyframes are far apart, the only one is among the hidden.
    """
    path = tmp_path / "trimmed.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "0", "g": keys_apart})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv444p"
        for index in range(-7, 20):
            image = np.full((48, 64, 3), 100 + 4 * index, np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts, frame.time_base = index, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    for frames in (open_recording(path).frames, open_recording(path).intact().frames):
        assert frames.time_ns.tolist() == [round(1e9 * index / 30) for index in range(20)]
        assert [int(frames[index].image()[0, 0, 0]) for index in (0, 19)] == [100, 176]


@pytest.mark.parametrize(
    ("name", "codec", "box"),
    [
        ("clip.mkv", "libx264", "Segment"),
        ("clip.webm", "libvpx-vp9", "Segment"),
        ("clip.avi", "mjpeg", "RIFF"),
    ],
)
def test_of_a_cut_file_what_is_there_is_read_and_that_is_said(
    tmp_path: Path, name: str, codec: str, box: str
) -> None:
    path = tmp_path / name
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30)
        stream.width, stream.height = 64, 48
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        for index in range(30):
            image = np.full((48, 64, 3), 4 * index, np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts, frame.time_base = index, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    assert len(open_recording(path).frames) == 30
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    frames, _ = VideoFrames(path).intact(None)
    assert 0 < len(frames) < 30
    assert f"the video is truncated: its box {box}" in frames.notes[0].replace("'", "")
    for index in (len(frames) - 1, 0):
        assert abs(int(frames[index].image()[0, 0, 0]) - 4 * index) <= 6


def test_an_avi_that_dropped_images_is_read_in_any_order(tmp_path: Path) -> None:
    path = tmp_path / "dropped.avi"  # whose sound lies behind all images, too
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=30)
        sound = container.add_stream("pcm_s16le", rate=48_000, layout="mono")
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuvj420p"
        stream.codec_context.time_base = Fraction(1, 600)
        for index in range(40):
            image = np.full((48, 64, 3), 5 * index, np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts, frame.time_base = 20 * index, Fraction(1, 600)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
        heard = av.AudioFrame.from_ndarray(np.zeros((1, 64_000), np.int16), "s16", "mono")
        heard.sample_rate = 48_000
        container.mux(sound.encode(heard))
    frames = VideoFrames(path)
    assert len(frames) == 40
    for index in (30, 7, 8, 39, 0):
        assert abs(int(frames[index].image()[0, 0, 0]) - 5 * index) <= 3


def test_a_matroska_file_of_untold_length_passes(tmp_path: Path) -> None:
    path = tmp_path / "live.webm"
    unknown = b"\x1a\x45\xdf\xa3\x80\x18\x53\x80\x67\x01" + 7 * b"\xff"
    for data in (unknown, unknown[:4], unknown[:6], unknown[:9]):
        path.write_bytes(data)
        assert not said_of_cut(path)
    path.write_bytes(unknown[:9] + b"\x82" + b"x")
    assert "box Segment of 2 bytes at 5 is not whole" in said_of_cut(path)


def test_a_file_that_is_no_video_is_refused(tmp_path: Path) -> None:
    for content in (b"not a video at all", bytes(1000), np.random.default_rng(0).bytes(5000)):
        path = tmp_path / "fake.mp4"
        path.write_bytes(content)
        with pytest.raises(RecordingError, match="cannot be read as a video"):
            open_recording(path)


def test_of_broken_stamps_the_most_that_increase_are_kept() -> None:
    from motorcade.replays.io.readers.frames.packets import _increasing

    step, far = 40_000_000, 10**15
    even = [step * k for k in range(8)]
    for told, counted in (
        (even, 0),
        ([*even[:3], far, *even[4:]], 1),  # one leaps ahead
        ([far, far + step, *even[2:]], 2),  # a clock that was set back
        ([None, None, *even[2:7], None], 3),
    ):
        known = {at: one for at, one in enumerate(told) if one is not None}
        assert _increasing(known, 8, step) == (even, counted)
    stands, counted = _increasing(dict(enumerate([*even[:6], even[5], even[5]])), 8, step)
    assert (stands[:5], stands[7], counted) == (even[:5], even[5], 2)  # spread between two
    assert np.all(np.diff(stands) > 0)
    assert _increasing({}, 3, step) == (even[:3], 3)
