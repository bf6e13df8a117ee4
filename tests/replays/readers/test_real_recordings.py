"""Real recordings: counts and figures that are known of them, conventions checked by witnesses."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking.boards import Checkerboard

MANIFESTS = Path(__file__).parents[3] / "docs" / "manifests"


def test_vamr_board_truth_is_opencvs_in_our_board_frame(data_dir: Path) -> None:
    root = data_dir / "replays" / "vamr_board"
    recording = open_recording(root, MANIFESTS / "vamr_board.toml")
    recording.check()
    assert len(recording.frames) == 250
    assert recording.camera is not None
    assert recording.truth is not None
    assert np.array_equal(recording.truth.time_ns, recording.frames.time_ns)
    steps = np.diff(recording.truth.poses.translation_m, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(1.12, abs=0.05)
    assert (recording.truth.poses.translation_m[:, 2] > 0.2).all()
    board = recording.board
    assert isinstance(board, Checkerboard)
    points = board.points_m
    rows = np.loadtxt(root / "poses.txt")[:250]
    down = points * [1.0, -1.0, -1.0]
    matrix, distortion = recording.camera.matrix, np.array([*recording.camera.distortion, 0, 0])
    for index in (0, 100, 249):
        expected, _ = cv2.projectPoints(down, rows[index, :3], rows[index, 3:], matrix, distortion)
        in_camera = recording.truth.poses[index].inverse().apply(points)
        assert np.abs(recording.camera.project(in_camera) - expected[:, 0]).max() < 1e-6


def test_euroc_frames_that_were_left_out_are_left_out(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "euroc_V1_01")
    recording.check()
    assert len(recording.frames) == 20
    assert recording.imu is not None
    assert recording.imu.duration_s == pytest.approx(145.6, abs=0.05)
    assert recording.truth is not None
    assert recording.truth.time_ns[0] <= recording.frames.time_ns[0]
    assert recording.truth.duration_s > 143.0


def test_euroc_truth_is_of_the_frame_that_the_imu_measures_in(data_dir: Path) -> None:
    """Rates of the ground truth against the gyroscope, gravity against the accelerometer."""
    recording = open_recording(data_dir / "replays" / "euroc_V1_01")
    truth, imu = recording.truth, recording.imu
    assert truth is not None
    assert imu is not None
    assert recording.imu_T_camera is not None
    world_T_imu = truth.poses @ recording.imu_T_camera.inverse()
    turn = Rotation.from_matrix(world_T_imu.rotor.as_matrix())
    time_s = (truth.time_ns - truth.time_ns[0]) * 1e-9
    imu_s = (imu.time_ns - truth.time_ns[0]) * 1e-9
    inside = (imu_s > 1.0) & (imu_s < time_s[-1] - 1.0)
    spline = RotationSpline(time_s, turn)
    rate = spline(imu_s[inside], 1)
    smooth = np.stack(
        [np.convolve(axis, np.full(11, 1 / 11), "same") for axis in imu.angular_rate_rad_s.T],
        axis=1,
    )[inside]
    apart, _ = Rotation.align_vectors(smooth - smooth.mean(axis=0), rate - rate.mean(axis=0))
    assert np.degrees(apart.magnitude()) < 0.05
    up = spline(imu_s[inside]).apply(imu.specific_force_m_s2[inside])
    accelerated = CubicSpline(time_s, world_T_imu.translation_m)(imu_s[inside], 2)
    assert np.abs((up - accelerated).mean(axis=0) - [0.0, 0.0, 9.81]).max() < 0.1


def test_the_first_release_of_that_truth_can_be_chosen(data_dir: Path, tmp_path: Path) -> None:
    manifest = tmp_path / "first.toml"
    example = (MANIFESTS / "euroc_v1_01.toml").read_text()
    manifest.write_text(example.replace("V1_01_easy.txt", "V1_01_easy_original.txt", 2))
    truth = open_recording(data_dir / "replays" / "euroc_V1_01", manifest).truth
    assert truth is not None
    assert truth.duration_s == pytest.approx(143.5, abs=0.1)


def test_redkitchen_is_read_with_depth_and_unit_rotations(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "7scenes_redkitchen")
    recording.check()
    assert len(recording.frames) == 200
    assert recording.truth is not None
    steps = np.linalg.norm(np.diff(recording.truth.poses.translation_m, axis=0), axis=1)
    assert steps.sum() == pytest.approx(1.32, abs=0.05)
    assert isinstance(recording.frames, ImageFrames)
    depth = recording.frames.measured_depth(7)
    path = data_dir / "replays/7scenes_redkitchen/frame-000007.depth.png"
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    unknown = (stored == 0) | (stored == 65535)
    assert depth is not None
    assert np.array_equal(np.isnan(depth), unknown)
    assert np.allclose(depth[~unknown], stored[~unknown] / 1000.0)


def test_depth_and_truth_of_redkitchen_agree(data_dir: Path) -> None:
    """A point of one depth image, moved by the poses, lies on the surface of another."""
    recording = open_recording(data_dir / "replays" / "7scenes_redkitchen")
    camera, truth = recording.camera, recording.truth
    assert camera is not None
    assert truth is not None
    first, second = (recording.frames[i].depth_m() for i in (0, 20))
    assert first is not None
    assert second is not None
    v, u = (axis.ravel() for axis in np.mgrid[20:460:8, 20:620:8])
    depth = first[v, u]
    v, u, depth = (axis[np.isfinite(depth)] for axis in (v, u, depth))
    points = camera.unproject(np.stack([u, v], axis=1)) * depth[:, None]
    moved = (truth.poses[20].inverse() @ truth.poses[0]).apply(points)
    pixels = np.rint(camera.project(moved)).astype(int)
    seen = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1)
    there = second[pixels[seen, 1], pixels[seen, 0]]
    assert np.nanmedian(np.abs(there - moved[seen, 2])) < 0.02


def test_kitti_drives_forward_on_the_level(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "kitti_short")
    recording.check()
    assert len(recording.frames) == 51
    assert recording.truth is not None
    path = recording.truth.poses.translation_m
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(51.8, abs=0.1)
    assert path[5, 0] > 4.0
    assert np.abs(path[:, 2]).max() < 1.5


def test_gopro_video_keeps_its_stamps(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "gopro" / "karma.mp4")
    assert len(recording.frames) == 362
    assert recording.frames.time_ns[:3].tolist() == [0, 33_366_667, 66_733_333]
    assert recording.frames[361].image().shape == (480, 854, 3)


def test_a_deleted_image_of_vamr_board_is_named(
    data_dir: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Its poses go row by row with its images: they would be another's from there on."""
    root = tmp_path / "vamr_board"
    (root / "images").mkdir(parents=True)
    for name in ("K.txt", "D.txt", "poses.txt"):
        (root / name).symlink_to(data_dir / "replays" / "vamr_board" / name)
    for path in (data_dir / "replays" / "vamr_board" / "images").iterdir():
        if path.name != "img_0100.jpg":
            (root / "images" / path.name).symlink_to(path)
    with pytest.raises(RecordingError, match=r"expected a pose for each of 249 frames, got 250"):
        open_recording(root, MANIFESTS / "vamr_board.toml")
    assert "the first between img_0099.jpg and img_0101.jpg" in caplog.text
