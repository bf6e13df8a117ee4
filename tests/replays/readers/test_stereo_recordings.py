"""Rectified pairs: right images are read beside the left ones, and give SLAM its scale."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.slam_poses import slam_poses
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import scenario

SIZE = (64, 48)
MANIFEST = (
    'name = "pairs"\n[frames]\nimages = "rgb/*.png"\nrate_hz = 30\n[camera]\nmodel = "pinhole"\n'
    "width = 640\nheight = 480\nfx = 525.0\nfy = 525.0\ncx = 319.5\ncy = 239.5\n"
    '[truth]\nfile = "groundtruth.txt"\nformat = "tum"\n'
    'convention = "world_T_camera"\n'
)
PAIRS = '[stereo]\nright = "right/*.png"\nbaseline_m = 0.12\n'


def gray(level: int) -> np.ndarray:
    return np.full(SIZE[::-1], level, dtype=np.uint8)


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    """Three pairs as KITTI has them, 0.54 m apart."""
    for index in range(3):
        for camera in (0, 1):
            folder = tmp_path / f"image_{camera}"
            folder.mkdir(exist_ok=True)
            cv2.imwrite(str(folder / f"{index:06d}.png"), gray(10 * camera + index))
    rows = (f"P{k}: 700 0 32 {-700 * 0.54 * k!r} 0 700 24 0 0 0 1 0\n" for k in (0, 1))
    (tmp_path / "calib.txt").write_text("".join(rows))
    return tmp_path


def test_kitti_brings_its_right_images_and_baseline(kitti: Path) -> None:
    recording = open_recording(kitti)
    recording.check()
    assert recording.baseline_m == pytest.approx(0.54)
    for index, frame in enumerate(recording.frames):
        np.testing.assert_array_equal(frame.gray(), gray(index))
        np.testing.assert_array_equal(frame.right(), gray(10 + index))


def test_right_images_count_in_the_digest(kitti: Path) -> None:
    before = open_recording(kitti).digest()
    cv2.imwrite(str(kitti / "image_1" / "000002.png"), gray(99))
    assert open_recording(kitti).digest() != before


def test_a_pair_without_its_right_image_is_refused(kitti: Path) -> None:
    (kitti / "image_1" / "000002.png").unlink()
    with pytest.raises(RecordingError, match="expected the 3 names of the left images"):
        open_recording(kitti)


def test_a_damaged_right_image_takes_its_frame_along(kitti: Path) -> None:
    path = kitti / "image_1" / "000001.png"
    path.write_bytes(path.read_bytes()[:-20])
    frames, told = open_recording(kitti).frames.intact(None)
    assert len(frames) == 2
    assert len(told) == 1
    assert "right of frame 1" in told[0]
    np.testing.assert_array_equal(frames[1].right(), gray(12))


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A walk of 60 frames, to be read as pairs without its depth."""
    root = tmp_path_factory.mktemp("room") / "pairs"
    write_recording(root, scenario("handheld", frames=60, seed=5), name="room")
    return root


def opened(room: Path, manifest: str) -> Recording:
    path = room.parent / "manifest.toml"
    path.write_text(manifest)
    return open_recording(room, path)


def test_pairs_give_poses_in_metres(room: Path) -> None:
    recording = opened(room, MANIFEST + PAIRS)
    assert recording.frames[0].depth_m() is None
    found = slam_poses(recording)
    assert found.metric
    assert len(found.measurements) == 60
    assert recording.truth is not None
    error = evaluate(found.measurements.trajectory, recording.truth, align="se3")
    assert error.ape_m.rmse < 0.01
    # The scale is that of the world: how far apart two places are needs no alignment.
    ours, truth = (
        np.linalg.norm(np.diff(one.motors.translation_m[[0, 40]], axis=0))
        for one in (found.measurements.trajectory, recording.truth)
    )
    assert truth > 0.2
    assert ours == pytest.approx(truth, rel=0.03)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("[stereo]\nbaseline_m = 0.12\n", r"\[stereo\] right: the key is missing"),
        ('[stereo]\nright = "right/*.png"\n', r"\[stereo\] baseline_m: the key is missing"),
        (PAIRS.replace("0.12", "-1.0"), "baseline_m"),
        (PAIRS.replace("right/*.png", "right/0.0*.png"), "expected 60 images, got"),
    ],
)
def test_pairs_that_cannot_be_are_refused(room: Path, change: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        opened(room, MANIFEST + change)
