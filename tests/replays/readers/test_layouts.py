"""Known layouts: what was written is found, in our conventions; what does not fit is refused."""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.layouts.detect import LAYOUTS
from motorcade.replays.io.readers.layouts.tum_rgbd import nearest
from motorcade.replays.io.readers.opening import open_recording
from tests.replays.conftest import HEIGHT, MAKERS, WIDTH

Make = Callable[..., Any]
KNOWN = tuple(name for name in MAKERS if name != "folder")
REPOSITORY = Path(__file__).resolve().parents[3]


def same_poses(a: Motor, b: Motor) -> bool:
    return bool(np.allclose(a.as_matrix(), b.as_matrix(), rtol=0, atol=1e-12))


def replace_line(path: Path, number: int, text: str) -> None:
    lines = path.read_text().splitlines()
    lines[number - 1] = text
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("layout", KNOWN)
def test_frames_stamps_and_images_are_found(make: Make, layout: str) -> None:
    made = make(layout)
    recording = open_recording(made.root)
    assert recording.layout == layout
    assert recording.name == "recording"
    assert np.array_equal(recording.frames.time_ns, made.time_ns)
    assert len(recording.frames) == len(made.time_ns)
    for index, frame in enumerate(recording.frames):
        expected = np.random.default_rng(index).integers(
            0, 256, (16, 24) if layout == "euroc" else (16, 24, 3), dtype=np.uint8
        )
        shown = frame.image()
        assert np.array_equal(shown if shown.ndim == 2 else shown[..., ::-1], expected)
    assert recording.duration_s == pytest.approx((made.time_ns[-1] - made.time_ns[0]) * 1e-9)


@pytest.mark.parametrize("layout", KNOWN)
def test_a_whole_recording_passes_its_check(make: Make, layout: str) -> None:
    recording = open_recording(make(layout).root)
    recording.check()


@pytest.mark.parametrize("layout", KNOWN)
def test_the_digest_is_of_content_and_not_of_place(make: Make, layout: str) -> None:
    made = make(layout)
    digest = open_recording(made.root).digest()
    elsewhere = made.root.parent / "elsewhere"
    elsewhere.mkdir()
    moved = made.root.rename(elsewhere / "recording")
    recording = open_recording(moved)
    assert recording.digest() == recording.digest() == digest
    path = next(moved.rglob(recording.frames[1].name))
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    image[0, 0] ^= 1
    cv2.imwrite(str(path), image)
    assert open_recording(moved).digest() != digest


def test_the_digest_covers_calibration_but_not_comments(make: Make) -> None:
    made = make("euroc")
    sensor = made.root / "mav0" / "cam0" / "sensor.yaml"
    digest = open_recording(made.root).digest()
    sensor.write_text(sensor.read_text() + "# a comment\n")
    assert open_recording(made.root).digest() == digest
    sensor.write_text(sensor.read_text().replace("1e-05", "2e-05"))
    assert open_recording(made.root).digest() != digest


class TestEuroc:
    def test_truth_is_of_the_camera(self, make: Make) -> None:
        made = make("euroc")
        truth = open_recording(made.root).truth
        assert truth is not None
        assert (truth.parent, truth.child) == ("world", "camera")
        assert same_poses(truth.poses, made.poses @ made.camera_in_body)

    def test_camera_and_imu_are_related_through_the_body(self, make: Make) -> None:
        made = make("euroc")
        recording = open_recording(made.root)
        expected = np.linalg.solve(made.imu_in_body.as_matrix(), made.camera_in_body.as_matrix())
        assert recording.imu_T_camera is not None
        assert np.allclose(recording.imu_T_camera.as_matrix(), expected, atol=1e-12)
        assert recording.imu is not None
        assert len(recording.imu) == 60
        assert recording.imu_noise is not None
        assert recording.imu_noise.accel_walk_m_s3_rthz == 3e-3
        assert recording.camera is not None
        assert recording.camera.distortion == (-0.28, 0.07, 0.0002, 1e-5)

    def test_mav0_itself_opens_too(self, make: Make) -> None:
        assert len(open_recording(make("euroc").root / "mav0").frames) == 6

    def test_images_may_be_missing_at_the_end_only(self, make: Make) -> None:
        made = make("euroc")
        data = made.root / "mav0" / "cam0" / "data"
        (data / f"{made.time_ns[5]}.png").unlink()
        assert len(open_recording(made.root).frames) == 5
        (data / f"{made.time_ns[2]}.png").unlink()
        with pytest.raises(RecordingError, match=f"{made.time_ns[2]}.png, frame 2: .*missing"):
            open_recording(made.root)
        for path in data.iterdir():
            path.unlink()
        with pytest.raises(RecordingError, match=r"expected the images that .* got none"):
            open_recording(made.root)

    def test_truth_beside_mav0_is_taken_and_superseded_files_are_not(self, make: Make) -> None:
        made = make("euroc")
        estimate = made.root / "mav0" / "state_groundtruth_estimate0"
        for path in estimate.iterdir():
            path.unlink()
        estimate.rmdir()
        assert open_recording(made.root).truth is None
        (made.root / "README.txt").write_text("nothing to see\n")
        (made.root / "V1.txt").write_text("1 1 0 0 0 0 0 1\n")
        (made.root / "V1_original.txt").write_text("1 2 0 0 0 0 0 1\n")
        truth = open_recording(made.root).truth
        assert truth is not None
        assert same_poses(
            truth.poses,
            Motor.from_quaternion_translation([[1, 0, 0, 0]], [[1, 0, 0]]) @ made.camera_in_body,
        )
        (made.root / "other.txt").write_text("1 2 0 0 0 0 0 1\n")
        with pytest.raises(RecordingError, match=r"V1\.txt, other\.txt; choose one in a manifest"):
            open_recording(made.root)

    @pytest.mark.parametrize(
        ("line", "text", "message"),
        [
            (10, "distortion_coefficients: [1, 2, 3]", "expects 2 or 4 or 5 or 8 .* got 3"),
            (10, "distortion_coefficients: [1, a, 3, 4]", "distortion_coefficients: expected num"),
            (9, "distortion_model: fancy", "distortion_model: expected one of"),
            (8, "intrinsics: [1, 2, 3]", "intrinsics: expected 4 numbers, got 3"),
            (8, "intrinsics: [-1, 2, 3, 4]", "fx: expected pixels above 0"),
            (7, "resolution: [24.5, 16]", "width, height: expected whole pixels"),
            (6, "  data: [1, 2]", "T_BS: expected 4 rows of 4 numbers"),
            (6, f"  data: {[2.0] * 16}", "T_BS: expected a rotation"),
            (2, "{{{{", "expected YAML"),
        ],
    )
    def test_a_bad_calibration_is_refused(
        self, make: Make, line: int, text: str, message: str
    ) -> None:
        made = make("euroc")
        sensor = made.root / "mav0" / "cam0" / "sensor.yaml"
        replace_line(sensor, line, text)
        with pytest.raises(RecordingError, match=message) as refused:
            open_recording(made.root)
        assert str(sensor) in str(refused.value)
        assert "\n" not in str(refused.value)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("5,1,1,1,1,1,1", "line 4: expected stamps in increasing order"),
            ("1403715273277142976,nan,1,1,1,1,1", "line 4, w_x: expected a finite number"),
            ("1403715273277142976,1,1,1,1", "line 4: expected 7 or more columns"),
        ],
    )
    def test_a_bad_imu_row_is_refused(self, make: Make, text: str, message: str) -> None:
        made = make("euroc")
        replace_line(made.root / "mav0" / "imu0" / "data.csv", 4, text)
        with pytest.raises(RecordingError, match=message):
            open_recording(made.root)

    def test_a_listing_may_not_lead_outside(self, make: Make) -> None:
        made = make("euroc")
        listing = made.root / "mav0" / "cam0" / "data.csv"
        replace_line(listing, 3, f"{made.time_ns[1]},../../imu0/data.csv")
        with pytest.raises(RecordingError, match="line 3: expected a file name inside"):
            open_recording(made.root)

    def test_an_imu_of_another_time_fails_the_check(self, make: Make) -> None:
        made = make("euroc")
        path = made.root / "mav0" / "imu0" / "data.csv"
        path.write_text("5,1,1,1,1,1,1\n6,1,1,1,1,1,1\n")
        recording = open_recording(made.root)
        with pytest.raises(RecordingError, match="expected IMU and frames to overlap"):
            recording.check()


class TestSevenScenes:
    def test_truth_depth_and_nominal_cameras(self, make: Make) -> None:
        """The published poses are the depth camera's, and its 585 px for 640 pixels of width."""
        made = make("seven_scenes")
        recording = open_recording(made.root)
        frames, scale = recording.frames, WIDTH / 640
        assert isinstance(frames, ImageFrames)
        assert frames.depth_camera is not None
        assert recording.truth is not None
        colour_T_depth = frames.depth_camera.colour_T_depth
        assert same_poses(recording.truth.poses @ colour_T_depth, made.poses)
        assert -0.027 <= colour_T_depth.translation_m[0] <= -0.025
        assert recording.camera is not None
        assert recording.camera == frames.colour_camera
        assert (recording.camera.fx, recording.camera.cx) == (525.0 * scale, 320.0 * scale)
        assert frames.depth_camera.camera.fx == 585.0 * scale
        measured, depth = frames.measured_depth(2), frames[2].depth_m()
        assert measured is not None
        assert depth is not None
        assert np.isnan(measured[0, :2]).all()
        assert measured[5, 5] == pytest.approx(1.002)
        assert depth[HEIGHT // 2, WIDTH // 2] == pytest.approx(1.002)

    def test_the_depth_cameras_file_is_not_the_colour_cameras(self, make: Make) -> None:
        made = make("seven_scenes")
        np.savetxt(made.root / "camera-intrinsics.txt", [[70, 0, 31], [0, 71, 23], [0, 0, 1]])
        recording = open_recording(made.root)
        assert isinstance(recording.frames, ImageFrames)
        assert recording.frames.depth_camera is not None
        assert recording.frames.depth_camera.camera.fy == 71.0
        assert recording.camera is not None
        assert recording.camera.fy == 525.0 * WIDTH / 640

    def test_a_scene_with_one_sequence_opens_and_with_two_asks(self, make: Make) -> None:
        made = make("seven_scenes")
        scene = made.root.parent / "scene"
        scene.mkdir()
        made.root.rename(scene / "seq-01")
        assert open_recording(scene).name == "seq-01"
        (scene / "seq-02").mkdir()
        (scene / "seq-02" / "frame-000000.color.png").touch()
        with pytest.raises(RecordingError, match="expected one sequence, got seq-01, seq-02"):
            open_recording(scene)

    @pytest.mark.parametrize(
        ("name", "message"),
        [
            ("frame-000002.color.png", "frame-000001.color.png followed by frame-000003"),
            ("frame-000002.depth.png", "frame-000002.depth.png, frame 2: the file is missing"),
            ("frame-000002.pose.txt", "frame-000002.pose.txt, frame 2: the file is missing"),
        ],
    )
    def test_a_missing_file_is_named(self, make: Make, name: str, message: str) -> None:
        made = make("seven_scenes")
        (made.root / name).unlink()
        with pytest.raises(RecordingError, match=message):
            open_recording(made.root)

    def test_a_nan_pose_is_refused(self, make: Make) -> None:
        made = make("seven_scenes")
        (made.root / "frame-000003.pose.txt").write_text("nan " * 16)
        with pytest.raises(RecordingError, match=r"frame-000003\.pose\.txt: expected finite"):
            open_recording(made.root)


class TestTumRgbd:
    def test_depth_is_the_nearest_within_reach(self, make: Make) -> None:
        recording = open_recording(make("tum_rgbd").root)
        found = [frame.depth_m() for frame in recording.frames]
        # The third depth image is 0.05 s late and so 0.0167 s after the fourth colour one.
        assert [depth is not None for depth in found] == [True, True, False, True, True]
        assert found[0] is not None
        assert found[0][0, 0] == pytest.approx(1.5)
        assert recording.truth is not None

    def test_depth_of_another_clock_is_said(self, make: Make) -> None:
        made = make("tum_rgbd")
        assert open_recording(made.root).doubts == ()
        listed = made.root / "depth.txt"
        rows = [line.split() for line in listed.read_text().splitlines() if line[0] != "#"]
        listed.write_text("".join(f"{float(stamp) + 1.0:.6f} {name}\n" for stamp, name in rows))
        recording = open_recording(made.root)
        assert not any(frame.depth_m() is not None for frame in recording.frames)
        (doubt,) = recording.doubts
        assert doubt.startswith("0 of 5 colour images have one of depth within 0.02 s")
        assert "begins +1.0" in doubt

    def test_association_agrees_with_trying_all_pairs(self) -> None:
        rng = np.random.default_rng(3)
        wanted, given = (np.unique(rng.integers(0, 10_000, 200)) for _ in range(2))
        for stamps in (given, given[:1]):
            gaps = np.abs(wanted[:, None] - stamps[None])
            best = np.where(gaps.min(axis=1) <= 30, gaps.min(axis=1), -1)
            ours = nearest(wanted, stamps, 30)
            assert np.array_equal(np.where(ours < 0, -1, np.abs(stamps[ours] - wanted)), best)

    def test_the_camera_is_known_by_the_folders_name(self, make: Make) -> None:
        made = make("tum_rgbd")
        assert open_recording(made.root).camera is None
        named = made.root.rename(made.root.parent / "rgbd_dataset_freiburg1_xyz")
        recording = open_recording(named)
        assert recording.camera is not None
        assert recording.camera.distortion[4] == pytest.approx(1.163314)
        with pytest.raises(RecordingError, match=r"frame 0: expected 640 x 480 .* got 24 x 16"):
            recording.check()

    def test_a_listed_image_that_is_missing_is_named(self, make: Make) -> None:
        made = make("tum_rgbd")
        (made.root / "rgb" / "4.png").unlink()
        with pytest.raises(RecordingError, match=r"4\.png, frame 4: .* line 6 of .*rgb\.txt"):
            open_recording(made.root)

    def test_equal_stamps_keep_the_first_image(
        self, make: Make, caplog: pytest.LogCaptureFixture
    ) -> None:
        made = make("tum_rgbd")
        replace_line(made.root / "rgb.txt", 3, "1305031102.175304 rgb/1.png")
        with caplog.at_level(logging.WARNING):
            recording = open_recording(made.root)
        assert [frame.name for frame in recording.frames] == ["0.png", "2.png", "3.png", "4.png"]
        assert "on line 3;" in caplog.messages[0]

    def test_decreasing_stamps_are_refused(self, make: Make) -> None:
        made = make("tum_rgbd")
        replace_line(made.root / "rgb.txt", 3, "1305031101.0 rgb/1.png")
        with pytest.raises(RecordingError, match=r"rgb\.txt, line 3: expected stamps in incr"):
            open_recording(made.root)


class TestKitti:
    def test_the_world_is_turned_up_and_the_camera_shifted(self, make: Make) -> None:
        made = make("kitti")
        truth = open_recording(made.root).truth
        assert truth is not None
        # P2's fourth column is fx times the shift: a point of camera 0 lies at x + 4 / 20 in it.
        centre = made.poses.apply([-0.2, 0.0, 0.0])
        upright = np.stack([centre[:, 2], -centre[:, 0], -centre[:, 1]], axis=-1)
        assert np.allclose(truth.poses.translation_m, upright, atol=1e-12)

    def test_colour_goes_before_grey_and_rows_need_no_names(self, make: Make) -> None:
        made = make("kitti")
        assert open_recording(made.root).frames[0].image().ndim == 3
        (made.root / "image_2").rename(made.root / "elsewhere")
        calibration = made.root / "calib.txt"
        rows = [line.partition(": ")[2] for line in calibration.read_text().splitlines()[:2]]
        calibration.write_text("\n".join(rows))
        recording = open_recording(made.root)
        assert recording.frames[0].image().ndim == 2
        assert recording.camera is not None
        assert (recording.camera.fx, recording.camera.cy) == (20.0, 7.5)

    def test_without_times_the_rate_is_ten_hertz(self, make: Make) -> None:
        made = make("kitti")
        (made.root / "times.txt").unlink()
        assert open_recording(made.root).frames.time_ns.tolist() == [
            0,
            100_000_000,
            200_000_000,
            300_000_000,
        ]

    @pytest.mark.parametrize(
        ("file", "line", "text", "message"),
        [
            ("calib.txt", 3, "P2: 1 2 3", "line 3, 'P2:': expected 12 finite numbers, got 3"),
            ("calib.txt", 3, "P2: a b c", "line 3, 'P2:': expected numbers"),
            ("calib.txt", 3, "Q2: 1 2 3", "expected a row P2:, got"),
            ("calib.txt", 3, "P2: 20 0 9 1e308 0 20 7 0 0 0 1 0", "numbers within 1e\\+09, got 1e"),
            ("calib.txt", 3, "P2: 0.001 0 9 1e9 0 20 7 0 0 0 1 0", "a shift within 1e\\+09 m, got"),
            ("calib.txt", 3, "P2: 20 0 9 0 0 20 7 0 0 0 0 0", "expected fx 0 cx"),
            ("calib.txt", 3, "P2: 20 1 9 0 0 20 7 0 0 0 1 0", "expected fx 0 cx"),
            ("calib.txt", 3, "P2: -20 0 9 0 0 20 7 0 0 0 1 0", "expected focal lengths from"),
            ("poses.txt", 2, "nan " * 12, "line 2, m11: expected a finite number"),
            ("poses.txt", 2, "# gone", "expected 4 poses for as many images, got 3"),
            ("times.txt", 2, "# gone", "expected 4 stamps for as many images, got 3"),
            ("times.txt", 3, "0.0001", "line 3: expected increasing stamps"),
        ],
    )
    def test_a_bad_file_is_refused(
        self, make: Make, file: str, line: int, text: str, message: str
    ) -> None:
        made = make("kitti")
        replace_line(made.root / file, line, text)
        with pytest.raises(RecordingError, match=message):
            open_recording(made.root)


def test_an_empty_or_unknown_folder_is_refused_with_what_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="expected a recording, got an empty folder"):
        open_recording(tmp_path)
    (tmp_path / "notes.txt").touch()
    with pytest.raises(RecordingError, match=r"EuRoC .*TUM RGB-D .*7-Scenes .*KITTI .*manifest"):
        open_recording(tmp_path)
    with pytest.raises(RecordingError, match="no such file or folder"):
        open_recording(tmp_path / "nothing")
    with pytest.raises(RecordingError, match="expected a recording, got neither"):
        open_recording(tmp_path / "notes.txt")


def test_a_truncated_image_is_found_by_the_check_and_when_read(make: Make) -> None:
    made = make("euroc")
    path = made.root / "mav0" / "cam0" / "data" / f"{made.time_ns[3]}.png"
    path.write_bytes(path.read_bytes()[:-20])
    recording = open_recording(made.root)
    recording.frames[2].image()
    for act in (recording.check, recording.frames[3].image):
        with pytest.raises(RecordingError, match=f"{path.name}, frame 3: the image is truncated"):
            act()


def test_each_layout_is_on_the_page_of_recordings_and_has_a_sample() -> None:
    rows = (REPOSITORY / "docs" / "recordings.md").read_text()
    for _, _, what in LAYOUTS:
        assert f"| {what.partition(' (')[0]}" in rows, what
    folder = REPOSITORY / "replays" / "io" / "readers" / "layouts"
    modules = {path.stem for path in folder.glob("*.py")}
    assert modules - {"__init__", "detect"} == set(KNOWN)


@pytest.mark.parametrize("name", ["calibration.txt", "imu.txt"])
def test_files_that_tum_layout_does_not_have_are_named(
    make: Make, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    made = make("tum_rgbd")
    open_recording(made.root)
    assert name not in caplog.text
    (made.root / name).write_text("525 525 319.5 239.5\n")
    open_recording(made.root)
    assert f"{name}: not read in TUM's layout" in caplog.text
