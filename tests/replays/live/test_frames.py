"""Frames come at their own pace, the newest first; nothing else is opened than what was named."""

import time

import numpy as np
import pytest

from motorcade.replays.io.recording import Frame, Recording
from motorcade.replays.live.frames import LiveFrame, kind_of, newest, open_frames, paced


class Drawn:
    """Three frames, 0.1 s apart."""

    time_ns = 7 + 100_000_000 * np.arange(3)

    def __len__(self) -> int:
        return 3

    def __getitem__(self, index: int) -> Frame:
        return Frame(int(self.time_ns[index]), "drawn", lambda: np.full((4, 6), index, np.uint8))


class Clock:
    """Goes on by sleeping."""

    now = 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def a_recording() -> Recording:
    return Recording("drawn", None, "images", Drawn())


def test_a_recording_plays_at_its_own_pace() -> None:
    clock = Clock()
    seen = [
        (frame.image[0, 0], clock.now)
        for frame in paced(a_recording(), clock=clock, sleep=clock.sleep)
    ]
    assert [number for number, _ in seen] == [0, 1, 2]
    assert np.allclose([at for _, at in seen], [0.0, 0.1, 0.2])


def test_it_waits_for_nobody() -> None:
    clock = Clock()
    playing = paced(a_recording(), clock=clock, sleep=clock.sleep)
    next(playing)
    clock.now = 0.25
    late = next(playing)
    assert late.image[0, 0] == 2
    assert late.captured_s == pytest.approx(0.2)
    assert next(playing, None) is None


def test_the_newest_frame_wins_and_faults_are_told() -> None:
    def breaks() -> object:
        yield LiveFrame(0, np.zeros((2, 2), np.uint8))
        raise OSError("the camera was unplugged")

    stream = newest(breaks())
    time.sleep(0.1)
    assert next(stream).time_ns == 0
    with pytest.raises(OSError, match="unplugged"):
        next(stream)


@pytest.mark.parametrize(
    ("source", "kind"),
    [("/dev/video2", "device"), ("rtsp://host/a", "rtsp"), ("-", "pipe"), ("a/b.mp4", "recording")],
)
def test_a_source_is_what_its_name_says(source: str, kind: str) -> None:
    assert kind_of(source) == kind


@pytest.mark.parametrize("source", ["http://host/a.m3u8", "concat://a|b", "file:///etc/passwd"])
def test_other_addresses_are_refused(source: str) -> None:
    with pytest.raises(ValueError, match="expected an address of rtsp"):
        next(open_frames(source))
