"""Images as people see them: display matrices, EXIF, and calibrations for whatever axes."""

import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.held import upright_camera
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import (
    AS_STORED,
    ImageOrientation,
    camera_T_turned,
    turned_camera,
)
from tests.replays.readers.test_images import with_orientation

WIDTH, HEIGHT = 96, 64
EVERY = [ImageOrientation(turns, flip) for turns in range(4) for flip in (False, True)]
SENSOR = Camera(WIDTH, HEIGHT, 90.0, 91.0, 45.0, 33.0, "radtan", (-0.1, 0.02, 3e-3, -2e-3))


def _stored() -> np.ndarray:
    """An image whose corners all differ, in large even patches."""
    image = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    image[:24, :40] = 250
    image[-24:, :40] = 200
    image[:24, -40:] = 20
    return image


def _write(
    path: Path,
    matrix: list[int] | None,
    pix_fmt: str = "yuv420p",
    more: dict[str, str] | None = None,
) -> Path:
    codec = "libx264" if pix_fmt == "yuv420p" else "libx265"
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30, options={"crf": "4", **(more or {})})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pix_fmt
        if matrix is not None:
            stream.set_display_matrix(matrix)
        if pix_fmt != "yuv420p":
            stream.codec_context.color_trc = 18
        for index in range(3):
            frame = av.VideoFrame.from_ndarray(_stored(), format="rgb24").reformat(format=pix_fmt)
            frame.pts, frame.time_base = index, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def _matrix(orientation: ImageOrientation) -> list[int]:
    (a, c), (b, d) = (orientation.matrix << 16).tolist()
    return [a, b, 0, c, d, 0, 0, 0, 1 << 30]


@pytest.mark.parametrize("orientation", EVERY, ids=str)
def test_videos_are_read_as_ffmpeg_shows_them(
    tmp_path: Path, orientation: ImageOrientation
) -> None:
    path = _write(tmp_path / "clip.mp4", _matrix(orientation))
    frames = VideoFrames(path)
    image = frames[1].image()
    assert frames.size == image.shape[1::-1] == orientation.size((WIDTH, HEIGHT))
    assert np.abs(image.astype(int) - orientation.upright(_stored())).mean() < 4.0
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg, the second witness, is not installed")
    command = ["ffmpeg", "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    shown = subprocess.run(command, capture_output=True, check=True).stdout
    first = np.frombuffer(shown, np.uint8)[: image.size].reshape(image.shape)
    assert np.abs(image.astype(int) - first).mean() < 4.0


def test_a_matrix_of_zeros_turns_nothing_and_one_askew_is_refused(tmp_path: Path) -> None:
    assert VideoFrames(_write(tmp_path / "none.mp4", None)).orientation == AS_STORED
    askew = [46341, 46341, 0, -46341, 46341, 0, 0, 0, 1 << 30]
    with pytest.raises(RecordingError, match="turned by quarter turns, got one by 45"):
        VideoFrames(_write(tmp_path / "askew.mp4", askew))


def test_more_than_eight_bits_are_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    frames = VideoFrames(_write(tmp_path / "hdr.mp4", None, "yuv420p10le"))
    assert "10 bits a colour (HLG, high dynamic range): they are read with 8" in caplog.text
    assert frames[0].image().dtype == np.uint8


def test_fields_are_told_from_frames(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    VideoFrames(_write(tmp_path / "frames.mp4", None))
    assert not caplog.records
    VideoFrames(_write(tmp_path / "fields.mp4", None, more={"x264-params": "tff=1"}))
    assert "its frames are interlaced" in caplog.text
    assert "ffmpeg -i fields.mp4 -vf bwdif" in caplog.text


def _opened(folder: Path, video: Path, camera: str, more: str = "") -> Camera:
    manifest = folder / "m.toml"
    manifest.write_text(camera + more)
    found = open_recording(video, manifest).camera
    assert found is not None
    return found


@pytest.mark.parametrize("turns", [1, 3])
def test_the_size_tells_for_which_axes_a_camera_was_made(
    tmp_path: Path, turns: int, caplog: pytest.LogCaptureFixture
) -> None:
    video = _write(tmp_path / "clip.mp4", _matrix(ImageOrientation(turns)))
    upright = turned_camera(SENSOR, turns)
    assert _opened(tmp_path, video, camera_toml(SENSOR)) == upright
    assert f"the camera is turned clockwise by {90 * turns} degrees" in caplog.text
    caplog.clear()
    assert _opened(tmp_path, video, camera_toml(upright)) == upright
    assert _opened(tmp_path, video, camera_toml(upright, 90 * turns)) == upright
    assert not caplog.records
    # Held the other way round when it was calibrated, which its own rotation tells:
    other = turned_camera(SENSOR, turns + 2)
    assert _opened(tmp_path, video, camera_toml(other, (90 * turns + 180) % 360)) == upright


def test_a_half_turn_is_told_by_the_key_or_said_to_be_taken_for_granted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    video = _write(tmp_path / "clip.mp4", _matrix(ImageOrientation(2)))
    assert _opened(tmp_path, video, camera_toml(SENSOR)) == SENSOR
    assert "it is taken to be of the images as shown" in caplog.text
    # Doing what the line advises:
    as_stored = camera_toml(SENSOR) + "rotation_deg = 0\n"
    assert _opened(tmp_path, video, as_stored) == turned_camera(SENSOR, 2)
    caplog.clear()
    assert _opened(tmp_path, video, camera_toml(SENSOR, 180)) == SENSOR
    assert not caplog.records


def test_extrinsics_and_truth_turn_with_the_camera(tmp_path: Path) -> None:
    video = _write(tmp_path / "clip.mp4", _matrix(ImageOrientation(1)))
    lines = [f"{k},0,0,9.8,0,0,0" for k in range(0, 2 * 10**8, 10**7)]
    header = "#t,w_x,w_y,w_z,a_x,a_y,a_z"
    (tmp_path / "imu.csv").write_text("\n".join([header, *lines]))
    (tmp_path / "truth.tum").write_text("0.0 1 2 3 0 0 0 1\n0.1 1 2 4 0 0 0 1\n")
    more = """[imu]
file = "imu.csv"
imu_T_camera = [[1.0,0,0,0.1],[0,1.0,0,0.2],[0,0,1.0,0.3],[0,0,0,1]]
[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"
"""
    manifest = tmp_path / "m.toml"
    manifest.write_text(camera_toml(SENSOR) + more)
    found = open_recording(video, manifest)
    assert found.imu_T_camera is not None
    assert found.truth is not None
    assert found.camera is not None
    point = np.array([0.1, -0.05, 1.0])  # in the sensor's axes
    upright = camera_T_turned(1).inverse().apply(point)
    np.testing.assert_allclose(
        found.imu_T_camera.apply(upright), np.add(point, [0.1, 0.2, 0.3]), atol=1e-12
    )
    np.testing.assert_allclose(
        found.truth.motors[0].apply(upright), np.add(point, [1, 2, 3]), atol=1e-12
    )
    stored, shown = SENSOR.project(point), found.camera.project(upright)
    np.testing.assert_allclose(shown, [HEIGHT - 1 - stored[1], stored[0]], atol=1e-9)


@pytest.mark.parametrize(
    ("camera", "rotation_deg", "orientation", "said"),
    [
        (Camera(64, 96, 90, 90, 32, 48), None, AS_STORED, "held the other way"),
        (Camera(64, 96, 90, 90, 32, 48), 0, AS_STORED, "expected width and height 96 x 64"),
        (Camera(80, 60, 90, 90, 40, 30), None, ImageOrientation(1), "with images of 64 x 96"),
        (SENSOR, None, ImageOrientation(1, mirrored=True), "stored mirrored"),
    ],
)
def test_cameras_that_do_not_fit_are_refused(
    camera: Camera, rotation_deg: int | None, orientation: ImageOrientation, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        upright_camera(camera, rotation_deg, (WIDTH, HEIGHT), orientation)


def test_a_camera_held_the_other_way_works_as_the_error_advises(tmp_path: Path) -> None:
    video = _write(tmp_path / "clip.mp4", None)
    held_upright = turned_camera(SENSOR, 1)
    with pytest.raises(RecordingError, match="such as rotation_deg = 90 for a phone held upright"):
        _opened(tmp_path, video, camera_toml(held_upright))
    found = _opened(tmp_path, video, camera_toml(held_upright, 90))
    assert (found.cx, found.cy) == pytest.approx((SENSOR.cx, SENSOR.cy))
    assert found.distortion == SENSOR.distortion


def _photographs(folder: Path, values: list[int]) -> Path:
    """JPEG files of one image as stored, with these EXIF orientations."""
    folder.mkdir()
    stored = cv2.imencode(".jpg", _stored()[..., ::-1])[1].tobytes()
    for number, value in enumerate(values):
        (folder / f"IMG_{number}.jpg").write_bytes(with_orientation(stored, value))
    return folder


@pytest.mark.parametrize("value", [1, 3, 6, 8])
def test_photographs_that_nothing_describes_are_shown_as_they_say(
    tmp_path: Path, value: int, caplog: pytest.LogCaptureFixture
) -> None:
    frames = open_recording(_photographs(tmp_path / "room", [value] * 10)).frames
    orientation = ImageOrientation({1: 0, 3: 2, 6: 1, 8: 3}[value])
    whole, faults = frames.intact(None)
    assert not faults
    assert not caplog.records
    assert whole.first_size() == orientation.size((WIDTH, HEIGHT))
    assert np.abs(whole[4].image().astype(int) - orientation.upright(_stored())).mean() < 4.0


def test_photographs_held_otherwise_than_the_first_are_shown_as_that(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """One camera then holds for all: what it saw of the scene is turned about its axis."""
    values = [6, 1, 6, 6, 8, 6, 6, 6, 6, 6]
    folder = _photographs(tmp_path / "room", values)
    whole, faults = open_recording(folder).frames.intact(None)
    assert not faults
    assert len(whole) == 10
    for frame in whole:
        shown = ImageOrientation(1).upright(_stored())
        assert np.abs(frame.image().astype(int) - shown).mean() < 4.0
    assert "1 of 10 images are turned clockwise by 0 degrees" in caplog.text
    assert "1 of 10 images are turned clockwise by 270 degrees" in caplog.text
    (folder / "IMG_7.jpg").write_bytes(
        with_orientation(cv2.imencode(".jpg", _stored())[1].tobytes(), 2)
    )
    with pytest.raises(RecordingError, match="all mirrored or none, got 1 mirrored"):
        open_recording(folder).frames.intact(None)
