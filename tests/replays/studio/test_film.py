"""Films for pages: every frame once, at its number's time, and a keyframe never far before it."""

from pathlib import Path

import av
import numpy as np
import pytest

from motorcade.replays.web.film import KEYFRAME_FRAMES, film_rate_hz, film_size, write_film


def images(count: int, shape: tuple[int, ...] = (48, 64, 3)) -> list[np.ndarray]:
    return [np.full(shape, 8 + 5 * k, np.uint8) for k in range(count)]


def stamps(count: int, rate_hz: float) -> np.ndarray:
    return np.round(np.arange(count) * 1e9 / rate_hz).astype(np.int64)


@pytest.mark.parametrize("rate_hz", [3.0, 20.0, 29.97, 30.0, 120.0])
def test_frames_stand_at_their_numbers_whatever_the_stamps(tmp_path: Path, rate_hz: float) -> None:
    count = 40
    time_ns = stamps(count, rate_hz)
    time_ns[7:] += 1_000_000  # a late frame changes no clock
    time_ns[31:] += 4_000_000_000  # nor does a gap
    path = tmp_path / "film.mp4"
    write_film(path, iter(images(count)), time_ns)
    rate = film_rate_hz(time_ns)
    assert abs(rate / rate_hz - 1.0) < 1e-3
    with av.open(str(path)) as file:
        frames = list(file.decode(video=0))
    assert len(frames) == count
    for k, frame in enumerate(frames):
        assert abs(frame.time - k / rate) < 1e-4
        assert abs(float(frame.to_ndarray(format="rgb24").mean()) - (8 + 5 * k)) < 3
    keys = [k for k, frame in enumerate(frames) if frame.key_frame]
    assert keys[0] == 0
    assert max(np.diff([*keys, count])) <= max(1, min(KEYFRAME_FRAMES, 0.5 * rate))


def test_grey_images_of_odd_size_are_padded(tmp_path: Path) -> None:
    path = tmp_path / "odd.mp4"
    write_film(path, images(3, (47, 63)), stamps(3, 30.0))
    with av.open(str(path)) as file:
        assert (file.streams.video[0].width, file.streams.video[0].height) == (64, 48)


def test_images_are_made_smaller_whole(tmp_path: Path) -> None:
    size = film_size(192, 108, 96)
    assert size == (96, 54)
    assert film_size(30, 20, 96) == (30, 20)
    path = tmp_path / "small.mp4"
    halves = np.zeros((108, 192, 3), np.uint8)
    halves[:, 96:] = 200
    write_film(path, [halves, halves], stamps(2, 30.0), size)
    with av.open(str(path)) as file:
        frame = next(file.decode(video=0)).to_ndarray(format="rgb24")
    assert frame.shape[:2] == (54, 96)
    assert frame[:, :46].max() < 12
    assert abs(int(frame[:, 50:].min()) - 200) < 12


def test_another_number_of_images_leaves_no_file(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with pytest.raises(ValueError, match="expected 5 frames, got 3"):
        write_film(path, images(3), stamps(5, 30.0))
    with pytest.raises(ValueError, match=r"ends in \.mp4"):
        write_film(tmp_path / "film.avi", images(3), stamps(3, 30.0))
    assert not list(tmp_path.iterdir())
