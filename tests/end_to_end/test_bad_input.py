"""Bad input through the command: what can be left out is, and is counted; the rest is refused."""

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking import Camera
from tests.textured_room.paths import handheld
from tests.textured_room.recording import write_recording
from tests.textured_room.renderer import Sensor
from tests.textured_room.scenarios import Scenario

SMALL = Sensor(Camera(160, 120, 140.0, 140.0, 79.5, 59.5))


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a job that must fail: exit 1, one line on standard error, which is returned."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 1
    error = capsys.readouterr().err
    assert error.startswith("motorcade: ")
    assert error.count("\n") == 1
    return error


@pytest.fixture
def own(board_recording: Path, tmp_path: Path) -> Path:
    """The board's recording, to be damaged."""
    folder = tmp_path / "own"
    shutil.copytree(board_recording, folder)
    return folder


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A few small frames with depth."""
    folder = tmp_path / "room"
    write_recording(folder, Scenario(handheld, 6, sensor=SMALL), name="room")
    return folder


def test_damaged_images_in_the_middle_are_left_out_told_and_counted(
    own: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    whole = (own / "007.png").read_bytes()
    flipped = bytearray((own / "012.png").read_bytes())
    flipped[len(flipped) // 2] ^= 0xFF
    (own / "007.png").write_bytes(whole[: len(whole) // 2])
    (own / "012.png").write_bytes(flipped)
    (own / "013.png").write_bytes(b"")
    out = tmp_path / "out"
    assert main(["run", str(own), "--out", str(out)]) == 0
    assert [line for line in caplog.messages if line.startswith("left out: ")] == [
        f"left out: {own / '007.png'}, frame 7: the image is truncated (a PNG without end); "
        "copy the file again",
        f"left out: {own / '012.png'}, frame 12: the image is corrupt (a PNG checksum does not "
        "fit); copy the file again",
        f"left out: {own / '013.png'}, frame 13: the file is empty",
    ]
    found = json.loads((out / "report.json").read_text())
    assert found["camera_poses"]["measured"] == found["camera_poses"]["frames"] == 21
    assert len(found["camera_poses"]["damaged_images"]) == 3
    assert "3 damaged images were left out" in (out / "report.html").read_text()
    # The others keep their stamps.
    stamps = read_trajectory(out / "trajectories" / "camera_poses_motor.tum").time_ns
    kept = np.delete(np.arange(24), [7, 12, 13])
    np.testing.assert_allclose(stamps, kept * 50_000_000, atol=1)


def test_too_much_damage_is_refused(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for index in range(1, 24, 2):
        (own / f"{index:03d}.png").write_bytes(b"no image")
    error = refused(capsys, "run", own, "--out", tmp_path / "out")
    assert "12 of 24 frames cannot be used, the first: " in error
    assert "001.png, frame 1: expected a PNG, JPEG" in error


def test_images_of_another_size_are_named(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """A logo in the folder is no frame; a camera that half of the images do not fit is refused."""
    image = cv2.imread(str(own / "012.png"), cv2.IMREAD_GRAYSCALE)
    cv2.imwrite(str(own / "012.png"), image[:200])
    assert main(["run", str(own), "--out", str(tmp_path / "out"), "--until", "tracked"]) == 0
    fault = "012.png, frame 12: expected 320 x 240 pixels as the camera has, got 320 x 200"
    assert any(line.startswith("left out: ") and fault in line for line in caplog.messages)
    for index in range(1, 24, 2):
        cv2.imwrite(str(own / f"{index:03d}.png"), image[:200])
    error = refused(capsys, "run", own, "--out", tmp_path / "out")
    assert "13 of 24 frames cannot be used, the first: " in error
    assert "expected 320 x 240 pixels as the camera has, got 320 x 200" in error


def test_of_images_that_nothing_describes_the_commonest_size_is_taken(tmp_path: Path) -> None:
    """An image of another size is left out wherever its name puts it, the first one too."""
    shown = np.full((48, 64, 3), 90, np.uint8)
    for name in ("a_logo.png", *(f"b{index}.png" for index in range(9))):
        cv2.imwrite(str(tmp_path / name), shown[: 20 if name == "a_logo.png" else 48])
    frames, faults = open_recording(tmp_path).frames.intact(None)
    assert isinstance(frames, ImageFrames)
    assert [path.name for path in frames.files] == [f"b{index}.png" for index in range(9)]
    assert frames.first_size() == (64, 48)
    assert len(faults) == 1
    assert "expected 64 x 48 pixels as 9 of 10 images have" in faults[0]


def test_depth_that_is_not_on_the_colour_pixels_is_refused(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = sorted((room / "depth").glob("*.png"))[3]
    depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(path), depth[::2, ::2])
    error = refused(capsys, "run", room, "--out", tmp_path / "out")
    assert f"{path.name}, depth of frame 3: expected 160 x 120" in error
    assert "depth on pixels of its own needs [depth_camera]" in error
    cv2.imwrite(str(path), (depth >> 8).astype(np.uint8))
    error = refused(capsys, "run", room, "--out", tmp_path / "out")
    assert "expected one channel of uint16, got uint8" in error


def test_damaged_depth_costs_the_depth_alone(
    room: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = sorted((room / "depth").glob("*.png"))[2]
    path.write_bytes(path.read_bytes()[:100])
    arguments = ["run", str(room), "--until", "camera_poses", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--set", "tracked.by=simulated"]) == 0
    assert f"left out: {path}, depth of frame 2: the image is truncated" in caplog.text
    recording = open_recording(room).intact()
    depths = [frame.depth_m() is not None for frame in recording.frames]
    assert depths == [True, True, False, True, True, True]
    with pytest.raises(RecordingError, match="depth of frame 2: the image is truncated"):
        open_recording(room).check()


def test_missing_intrinsics_are_doubted_and_half_stated_ones_refused(
    room: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    (room / "motorcade.toml").unlink()
    (room / "groundtruth.txt").unlink()
    asked = [str(room), "--out", str(tmp_path / "out"), "--until", "camera_poses"]
    assert main(["run", *asked]) == 0
    assert "how wide it sees is hardly known" in caplog.text
    (room / "motorcade.toml").write_text('[camera]\nmodel = "pinhole"\nfx = 140.0\nfy = 140.0\n')
    assert "[camera] cx: the key is missing" in refused(
        capsys, "run", room, "--out", tmp_path / "out"
    )
