"""Image files: sizes as OpenCV sees them; a truncated or corrupt file never gives an image."""

import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.files import (
    ImageFrames,
    image_glob,
    inside,
)
from motorcade.replays.io.readers.frames.images import (
    image_orientation,
    image_size,
    read_depth,
    read_gray,
    read_image,
)
from motorcade.replays.io.readers.frames.names import numbered, refuse_gaps, stamps_of_names
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking.cameras.camera import ImageOrientation

ENDINGS = (".png", ".jpg", ".bmp", ".ppm", ".pgm")


def encoded(ending: str, seed: int = 0, size: tuple[int, int] = (37, 21)) -> bytes:
    rng = np.random.default_rng(seed)
    shape = (size[1], size[0]) if ending == ".pgm" else (size[1], size[0], 3)
    done, data = cv2.imencode(ending, rng.integers(0, 256, shape, dtype=np.uint8))
    assert done
    return data.tobytes()


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_size_is_the_decoded_one(ending: str) -> None:
    for size in ((1, 1), (37, 21), (640, 3)):
        assert image_size(encoded(ending, size=size)) == size


def test_progressive_jpegs_and_ones_with_bytes_behind_are_whole() -> None:
    image = np.zeros((9, 14, 3), np.uint8)
    _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])
    assert image_size(data.tobytes()) == (14, 9)
    assert image_size(data.tobytes() + b"\0\0maker's notes") == (14, 9)


@pytest.mark.parametrize("ending", ENDINGS)
@settings(deadline=None, max_examples=40)
@given(cut=st.floats(0.0, 1.0, exclude_max=True))
def test_a_truncated_image_is_refused(ending: str, cut: float) -> None:
    data = encoded(ending)
    with pytest.raises(ValueError, match=r"truncated|corrupt|expected"):
        image_size(data[: int(cut * len(data))])


@settings(deadline=None, max_examples=60)
@given(place=st.integers(8, 10**6), bit=st.integers(0, 7))
def test_a_flipped_bit_in_a_png_is_refused(place: int, bit: int) -> None:
    data = bytearray(encoded(".png"))
    data[8 + place % (len(data) - 8)] ^= 1 << bit
    with pytest.raises(ValueError, match=r"corrupt|truncated"):
        image_size(bytes(data))


@settings(deadline=None, max_examples=200)
@given(
    start=st.sampled_from([b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"BM", b"P5 ", b"P6 9 9 255 "]),
    rest=st.binary(max_size=200),
)
def test_garbage_is_refused(start: bytes, rest: bytes) -> None:
    with pytest.raises(ValueError, match=r"truncated|corrupt|expected"):
        image_size(start + rest)


def test_a_size_that_fills_the_memory_is_refused_before_decoding() -> None:
    with pytest.raises(ValueError, match="expected at most 100000000 pixels"):
        image_size(
            b"BM"
            + (70).to_bytes(4, "little")
            + bytes(8)
            + (40).to_bytes(4, "little")
            + (10**6).to_bytes(4, "little") * 2
            + bytes(60)
        )


def test_pixels_are_rgb_or_grey_as_stored(tmp_path: Path) -> None:
    red = np.zeros((4, 6, 3), np.uint8)
    red[..., 2] = 255
    cv2.imwrite(str(tmp_path / "red.png"), red)
    cv2.imwrite(str(tmp_path / "grey.png"), red[..., 2])
    assert read_image(tmp_path / "red.png", "frame 0", (6, 4))[0, 0].tolist() == [255, 0, 0]
    assert read_image(tmp_path / "grey.png", "frame 0", (6, 4)).shape == (4, 6)


@pytest.mark.parametrize("value", range(1, 10))
@pytest.mark.parametrize("ending", [".jpg", ".png"])
def test_images_are_upright_as_opencv_shows_them(tmp_path: Path, value: int, ending: str) -> None:
    data = with_orientation(encoded(ending), value)
    path = tmp_path / f"a{ending}"
    path.write_bytes(data)
    shown = cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
    assert shown.shape[:2] == ((37, 21) if value in (5, 6, 7, 8) else (21, 37))
    size = shown.shape[1::-1]
    assert np.array_equal(read_image(path, "frame 0", size), shown)
    assert np.array_equal(read_gray(path, None, size), cv2.imread(str(path), cv2.IMREAD_GRAYSCALE))


def with_orientation(data: bytes, value: int, order: str = "big") -> bytes:
    """A JPEG or PNG file with an EXIF orientation in front."""
    tag = b"".join(number.to_bytes(2, order) for number in (274, 3))
    entry = tag + (1).to_bytes(4, order) + value.to_bytes(2, order) + b"\0\0"
    mark = b"MM" if order == "big" else b"II"
    head = mark + (42).to_bytes(2, order) + (8).to_bytes(4, order) + (1).to_bytes(2, order)
    tiff = head + entry + bytes(4)
    if data.startswith(b"\xff\xd8"):
        body = b"Exif\0\0" + tiff
        return data[:2] + b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body + data[2:]
    chunk = len(tiff).to_bytes(4, "big") + b"eXIf" + tiff
    return data[:33] + chunk + zlib.crc32(b"eXIf" + tiff).to_bytes(4, "big") + data[33:]


def test_an_orientation_is_found_in_either_order_of_bytes_and_never_beyond_the_end() -> None:
    data = with_orientation(encoded(".jpg"), 6, "little")
    assert image_orientation(data) == ImageOrientation(1)
    for cut in range(len(data)):
        assert image_orientation(data[:cut]).quarter_turns in (0, 1)


def test_depth_is_metres_and_nan_where_unknown(tmp_path: Path) -> None:
    stored = np.array([[0, 65535, 1000], [1, 2500, 65534]], np.uint16)
    cv2.imwrite(str(tmp_path / "d.png"), stored)
    metres = read_depth(tmp_path / "d.png", "frame 0", None, 1000.0)
    assert np.allclose(metres, [[np.nan, np.nan, 1.0], [0.001, 2.5, 65.534]], equal_nan=True)
    cv2.imwrite(str(tmp_path / "d.png"), stored.astype(np.uint8))
    with pytest.raises(RecordingError, match="expected one channel of uint16, got uint8"):
        read_depth(tmp_path / "d.png", "frame 0", None, 1000.0)


def test_an_image_of_another_size_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(encoded(".png"))
    with pytest.raises(RecordingError, match=r"a\.png, frame 7: expected 640 x 480 .* got 37 x 21"):
        read_image(tmp_path / "a.png", "frame 7", (640, 480))


def test_frames_are_read_when_asked_for(tmp_path: Path) -> None:
    files = tuple(tmp_path / f"{i}.png" for i in range(3))
    frames = ImageFrames(files, np.array([0, 5, 9]), (37, 21))
    kept = [frames[0], frames[-1]]
    files[2].write_bytes(encoded(".png", seed=2))
    assert kept[1].time_ns == 9
    assert kept[1].gray().shape == (21, 37)
    assert kept[1].depth_m() is None
    with pytest.raises(RecordingError, match="frame 0: the file is missing"):
        kept[0].image()
    with pytest.raises(IndexError):
        frames[3]


def test_gray_is_bt_601_luma(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(encoded(".png"))
    frame = ImageFrames((tmp_path / "a.png",), np.array([0]))[0]
    luma = frame.image() @ np.array([0.299, 0.587, 0.114])
    assert np.abs(frame.gray() - luma).max() < 0.51


def test_stamps_must_increase_and_fit() -> None:
    for stamps in ([0, 0], [1, 0], [0]):
        with pytest.raises(ValueError, match="expected 2 increasing stamps"):
            ImageFrames((Path("a.png"), Path("b.png")), np.array(stamps))


def test_files_are_in_natural_order(tmp_path: Path) -> None:
    for number in (10, 9, 1, 100):
        (tmp_path / f"img_{number}.png").touch()
    files = image_glob(tmp_path, "*.png")
    assert numbered(files) == [1, 9, 10, 100]


def test_a_gap_in_the_numbers_is_refused_by_name() -> None:
    files = [Path(f"img_{i:04d}.jpg") for i in (1, 2, 3, 5, 6)]
    with pytest.raises(RecordingError, match=r"img_0003\.jpg followed by img_0005\.jpg"):
        refuse_gaps(files, "copy it again")
    refuse_gaps([Path(f"{i}.jpg") for i in (0, 5, 10, 15)], "copy it again")


def test_stamps_leave_gaps_where_numbers_do(rng: np.random.Generator) -> None:
    """Images thinned at random have the stamps that they had in the whole series."""
    for step in (1, 4):
        kept = np.sort(rng.choice(300, 120, replace=False))
        kept[:2] = 0, 1
        kept = np.unique(kept)
        time_ns = stamps_of_names([Path(f"img_{7 + step * k:04d}.jpg") for k in kept], 25.0)
        np.testing.assert_array_equal(time_ns, kept * 40_000_000)


@pytest.mark.parametrize("digits", [9, 6, 3])
@pytest.mark.parametrize("point", ["", "."])
def test_names_that_are_times_are_the_stamps(digits: int, point: str) -> None:
    stamps = np.array([1403636579, 1403636580, 1403636582]) * 10**9 + [763_000_000, 1_000_000, 0]
    names = [f"{ns // 10**9}{point}{ns % 10**9 // 10 ** (9 - digits):0{digits}d}" for ns in stamps]
    time_ns = stamps_of_names([Path(f"{name}.png") for name in names], 30.0)
    np.testing.assert_array_equal(time_ns, stamps)


def test_dates_in_names_are_the_stamps_and_never_counts_of_images() -> None:
    """As Android ("IMG_20190812_153045") and Pixels ("PXL_..., with thousandths) name them."""
    seconds = [Path(f"IMG_20190812_{clock}.jpg") for clock in ("235958", "235959")]
    seconds.append(Path("IMG_20190813_000002.jpg"))
    np.testing.assert_array_equal(np.diff(stamps_of_names(seconds, 30.0)), [10**9, 3 * 10**9])
    fine = [Path(f"PXL_20210103_120000{ms}.jpg") for ms in ("007", "250")]
    assert np.diff(stamps_of_names(fine, 30.0)).tolist() == [243_000_000]
    burst = [Path(f"IMG_20190812_153045_{k}.jpg") for k in (1, 2, 3)]
    np.testing.assert_array_equal(stamps_of_names(burst, 10.0), [0, 10**8, 2 * 10**8])
    no_dates = [Path(f"20209999{k:06d}.png") for k in (1, 2, 4)]
    np.testing.assert_array_equal(stamps_of_names(no_dates, 10.0), [0, 10**8, 3 * 10**8])


@pytest.mark.parametrize(
    "numbers", [(1000, 34_512, 67_211, 101_009), (1, 2, 3, 9_000_000), (7, 7, 8)]
)
def test_numbers_that_count_no_images_are_refused(numbers: tuple[int, ...]) -> None:
    with pytest.raises(RecordingError, match="need \\[frames\\] stamps"):
        stamps_of_names([Path(f"{k}/{k}.png") for k in numbers], 30.0)


def test_a_manifest_says_how_many_numbers_are_not_there(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for number in (3, 4, 5, 8, 9):
        cv2.imwrite(str(tmp_path / f"{number:03d}.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "motorcade.toml").write_text('[frames]\nimages = "*.png"\nrate_hz = 10.0\n')
    frames = open_recording(tmp_path).frames
    np.testing.assert_array_equal(frames.time_ns, np.array([0, 1, 2, 5, 6]) * 100_000_000)
    assert "of 7 images by their numbers 2 are not there, the first between 005.png" in caplog.text


def test_series_of_several_cameras_are_refused_by_their_patterns() -> None:
    def names(*patterns: str) -> list[Path]:
        return [Path(one.format(k)) for k in range(6) for one in patterns]

    with pytest.raises(RecordingError, match=r"cam0_\*\.png and cam1_\*\.png; say which"):
        refuse_gaps(names("cam0_{:04d}.png", "cam1_{:04d}.png"), "copy it again")
    with pytest.raises(RecordingError, match=r"\*\.png and \*\.jpg; say which"):
        refuse_gaps(names("{:04d}.png", "{:04d}.jpg")[:-1], "copy it again")
    refuse_gaps([Path("IMG_1.jpg"), Path("IMG_2.jpg"), Path("DSC_7.jpg")], "copy it again")
    seconds = [Path(f"12-{minute}-{second:02d}.jpg") for minute in (30, 31) for second in range(40)]
    refuse_gaps([one for one in seconds if one.name > "12-30-25"][:50], "copy it again")


@pytest.mark.parametrize("name", ["/etc/passwd", "../a.png", "a/../../b", "", "a\\b", "a\0b", "."])
def test_names_that_lead_outside_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(RecordingError, match="line 4: expected a file name inside"):
        inside(tmp_path, name, tmp_path / "rgb.txt", 4)
