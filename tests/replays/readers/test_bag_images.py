"""Images and depth of bags: which topic, camera and stamps, and what is left of a cut."""

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import ImageArray
from tests.end_to_end.bags import COUNT, Bag, Drawn, as_plain, scene, stored, write

SEED = 91


@pytest.fixture(scope="module")
def frames() -> list[ImageArray]:
    return scene()


def drawn(tmp_path: Path, frames: list[ImageArray], *words: str) -> Path:
    return write(tmp_path, Drawn(*words), frames, np.random.default_rng(SEED))


@pytest.mark.parametrize(
    "encoding",
    ["rgb8", "bgr8", "bgra8", "yuv422", "yuv422_yuy2", "bayer_gbrg8", "bayer_grbg16", "png"],
)
def test_images_come_back_in_rgb(encoding: str, frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:3], "mcap", encoding, "alone", "headers", "whole")
    image = open_recording(path).frames[1].image()
    np.testing.assert_array_equal(image, as_plain(frames[1], encoding))


@pytest.mark.parametrize("encoding", ["mono8", "mono16", "mono16_12bits", "mono16_big"])
def test_grey_of_any_depth_keeps_its_highest_bits(encoding: str, frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:3], "bag", encoding, "alone", "headers", "whole")
    grey = cv2.cvtColor(frames[1], cv2.COLOR_RGB2GRAY)
    np.testing.assert_array_equal(open_recording(path).frames[1].image(), grey)


@pytest.mark.parametrize("beside", ["depth raw", "depth float", "compressedDepth"])
def test_colour_comes_before_depth_which_is_read_beside_it(beside, frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:4], "mcap", "rgb8", beside, "headers", "whole")
    frame = open_recording(path).frames[2]
    np.testing.assert_array_equal(frame.image(), frames[2])
    depth = frame.depth_m()
    assert depth is not None
    np.testing.assert_allclose(depth, 0.75, rtol=1e-6)


def test_inverse_depth_is_metres(tmp_path: Path) -> None:
    from motorcade.replays.io.readers.ros.frames import decode_depth

    bag = Bag(Drawn("mcap", "rgb8", "alone", "headers", "whole"), np.random.default_rng(SEED))
    metres = np.linspace(0.5, 8.0, 48 * 64).reshape(48, 64)
    scale, offset = 4000.0, -100.0  # what compressed_depth_image_transport writes before the PNG
    packed = np.rint(scale / metres + offset).astype(np.uint16)
    head = np.frombuffer(np.array([0, scale, offset], "<f4").tobytes(), np.uint8)
    data = np.concatenate([head, cv2.imencode(".png", packed)[1].ravel()])
    message = bag.packed(0, "32FC1; compressedDepth png", data, "cam")
    np.testing.assert_allclose(decode_depth(message, tmp_path, "a"), metres, rtol=2e-2)


def test_depth_as_jpeg_is_no_image_and_no_depth(frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:3], "mcap", "jpeg", "jpeg depth", "headers", "whole")
    frame = open_recording(path).frames[1]
    assert frame.depth_m() is None
    assert frame.image().ndim == 3
    name = f"{path}:/camera/aligned_depth_to_color/image_raw/compressed"
    with pytest.raises(RecordingError, match="lossy depth"):
        open_recording(name)


def test_topics_are_named_in_three_ways(frames, tmp_path: Path, capsys) -> None:
    path = drawn(tmp_path, frames[:3], "bag", "rgb8", "named", "headers", "whole")
    bag, topic = str(path).split(":")
    turned = frames[1][::-1]
    np.testing.assert_array_equal(open_recording(bag).frames[1].image(), turned)
    np.testing.assert_array_equal(open_recording(path).frames[1].image(), frames[1])
    manifest = tmp_path / "m.toml"
    manifest.write_text(f'[frames]\ntopic = "{topic}"\n')
    np.testing.assert_array_equal(open_recording(bag, manifest).frames[1].image(), frames[1])
    asked = ["run", bag, "--topic", "/camera/colour", "--out", str(tmp_path / "out")]
    assert main(asked) == 1
    assert "did you mean" in capsys.readouterr().err
    with pytest.raises(RecordingError, match="expected a bag"):
        open_recording(write_image(tmp_path), manifest)


def write_image(folder: Path) -> Path:
    place = folder / "images"
    place.mkdir()
    for number in range(3):
        cv2.imwrite(str(place / f"{number}.png"), np.zeros((8, 8), np.uint8))
    return place


def test_rectified_images_have_the_camera_of_their_projection(frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:3], "mcap", "rgb8", "rectified", "headers", "whole")
    camera = open_recording(path).camera
    assert camera is not None
    assert (camera.width, camera.height, camera.model) == (320, 240, "pinhole")
    np.testing.assert_allclose([camera.fx, camera.fy], 256.0)
    np.testing.assert_allclose([camera.cx, camera.cy], [159.5, 119.5])


@pytest.mark.parametrize(
    ("stamps", "said"),
    [
        ("zero", "received"),
        ("equal", "received"),
        ("in pairs", "received"),
        ("late", "recorded late"),
        ("twice", "came twice"),
    ],
)
def test_stamps_that_tell_nothing_give_way_and_it_is_said(
    stamps: str, said: str, frames, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = drawn(tmp_path, frames[:8], "mcap", "mono8", "depth raw", stamps, "whole")
    with caplog.at_level(logging.WARNING):
        recording = open_recording(path)
    assert said in caplog.text
    assert len(recording.frames) == 8
    grey = [cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in frames[:8]]
    for frame, image in zip(recording.frames, grey, strict=True):
        np.testing.assert_array_equal(frame.image(), image)
        assert frame.depth_m() is not None
    np.testing.assert_allclose(np.diff(recording.frames.time_ns), 50_000_000, atol=2_000_000)


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_bags_that_were_cut_are_read_to_their_last_whole_chunk(
    kind: str, frames, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        path = drawn(tmp_path, frames, kind, "rgb8", "alone", "headers", "cut")
        recording = open_recording(path)
    assert "cut short: read to its last whole chunk" in caplog.text
    count = len(recording.frames)
    assert 0.4 * COUNT < count < COUNT
    for number in (0, count // 2, count - 1):
        np.testing.assert_array_equal(recording.frames[number].image(), frames[number])


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_bags_without_one_whole_chunk_are_refused(kind: str, frames, tmp_path: Path) -> None:
    path = drawn(tmp_path, frames[:2], kind, "rgb8", "alone", "headers", "whole")
    path.write_bytes(path.read_bytes()[:100_000])
    with pytest.raises(RecordingError, match="before its first chunk ends"):
        open_recording(path)


def test_big_endian_bytes_are_known_by_their_flag(frames) -> None:
    _, little, _ = stored(frames[0], "mono16")
    _, big, is_big = stored(frames[0], "mono16_big")
    assert is_big
    np.testing.assert_array_equal(little, big)
    assert little.tobytes() != big.tobytes()


def test_times_of_receipt_that_no_stamp_can_hold_are_refused(
    frames, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MCAP has room for 64 bits of nanoseconds, stamps for 63: no bag of ours gets so far."""
    from motorcade.replays.io.readers.ros import reader

    path = drawn(tmp_path, frames[:3], "mcap", "rgb8", "alone", "headers", "whole")
    assert len(open_recording(path).frames) == 3
    monkeypatch.setattr(reader, "_LATEST_NS", 1)
    with pytest.raises(RecordingError, match="expected times of receipt before 2262, got"):
        open_recording(path)
