"""Manifests: any folder or video file, every key, and one clear line for every mistake."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorcade.ga import Motor, Rotor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.manifest import section
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.tracking.boards import Board, CharucoBoard, Checkerboard, MarkerGrid, SingleMarker
from tests.replays.readers.bag_poses import write_poses

Make = Callable[..., Any]

FRAMES = '[frames]\nimages = "images/*.jpg"\nrate_hz = 25\n'
CAMERA = "[camera]\nfx = 20.0\nfy = 21\ncx = 11.5\ncy = 7.5\n"
BOARD = '[board]\ntype = "checkerboard"\ncolumns = 9\nrows = 6\nsquare_m = 0.04\n'
TRUTH = '[truth]\nfile = "poses.txt"\nformat = "matrix4"\nconvention = "world_T_camera"\n'
IDENTITY = str(np.eye(4).tolist())


def described(root: Path, *tables: str) -> Recording:
    """Open a recording with a manifest that lies elsewhere."""
    described_by = root.parent / "manifest.toml"
    described_by.write_text("".join(tables))
    return open_recording(root, described_by)


def same_poses(a: Motor, b: Motor) -> bool:
    return bool(np.allclose(a.as_matrix(), b.as_matrix(), rtol=0, atol=1e-9))


def test_any_folder_of_images_opens(make: Make) -> None:
    made = make("folder")
    recording = described(made.root, 'name = "desk"\n', FRAMES, CAMERA, BOARD, TRUTH)
    recording.check()
    assert (recording.name, recording.layout) == ("desk", "images")
    assert np.array_equal(recording.frames.time_ns, made.time_ns)
    assert [frame.name for frame in recording.frames][8:10] == ["img_9.jpg", "img_10.jpg"]
    assert recording.camera is not None
    assert (recording.camera.width, recording.camera.height) == (24, 16)
    assert recording.board == Checkerboard(9, 6, 0.04)
    assert same_poses(recording.world_T_board, Motor.identity())
    assert recording.truth is not None
    assert same_poses(recording.truth.poses, made.poses)


def test_images_of_a_lens_that_zooms_come_as_one_focal_length_shows_them(make: Make) -> None:
    made = make("folder")
    plain = described(made.root, FRAMES, CAMERA)
    zoomed = described(made.root, FRAMES, CAMERA, "zoom_s = [0.0, 0.4]\nzoom = [1.0, 4.0]\n")
    zoomed.check()
    frame, taken = zoomed.frames[5], plain.frames[5].image()
    assert frame.zoom == pytest.approx(2.0)
    assert frame.taken is not None
    assert np.array_equal(frame.taken.image(), taken)
    assert not frame.gray()[0].any()  # half as large, with black around it
    centre = frame.image()[8, 12].astype(float)
    assert np.abs(centre - taken[6:11, 10:15].mean(axis=(0, 1))).max() < 40.0
    assert np.array_equal(zoomed.frames[0].image(), taken_first := plain.frames[0].image())
    assert taken_first.shape == frame.image().shape
    assert zoomed.digest() != plain.digest()


def test_a_manifest_inside_the_recording_is_found(make: Make) -> None:
    made = make("folder")
    (made.root / "motorcade.toml").write_text(FRAMES + CAMERA)
    assert open_recording(made.root).camera is not None
    assert described(made.root, FRAMES).camera is None


def test_a_field_of_view_stands_for_a_calibration(make: Make) -> None:
    camera = described(make("folder").root, FRAMES, "[camera]\nfov_deg = 90.0\n").camera
    assert camera is not None
    edges = camera.unproject(np.array([[-0.5, 7.5], [23.5, 7.5]]))
    np.testing.assert_allclose(edges / edges[:, 2:], [[-1, 0, 1], [1, 0, 1]], atol=1e-12)


def test_calibration_may_stand_in_files(make: Make) -> None:
    made = make("folder")
    (made.root / "K.txt").write_text("20 0 11.5\n0, 21, 7.5\n0 0 1\n")
    (made.root / "D.txt").write_text("-0.29 0.08\n")
    table = '[camera]\nmodel = "radtan"\nmatrix_file = "K.txt"\ndistortion_file = "D.txt"\n'
    camera = described(made.root, FRAMES, table).camera
    assert camera is not None
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (20.0, 21.0, 11.5, 7.5)
    assert camera.distortion == (-0.29, 0.08)
    (made.root / "D.txt").write_text("-0.29 0.08 1\n")
    with pytest.raises(RecordingError, match=r"D\.txt: .*distortion: radtan expects .* got 3"):
        described(made.root, FRAMES, table)
    (made.root / "K.txt").write_text("20 0 11.5 0 21 7.5\n")
    with pytest.raises(RecordingError, match=r"K\.txt: expected 9 numbers, got 6"):
        described(made.root, FRAMES, table)


def test_stamps_come_from_a_file_in_any_unit(make: Make) -> None:
    made = make("folder")
    (made.root / "t.txt").write_text("".join(f"{1_000_000.25 + i}\n" for i in range(12)))
    table = '[frames]\nimages = "images/*.jpg"\nstamps = "t.txt"\nstamps_unit = "us"\n'
    assert described(made.root, table).frames.time_ns[:2].tolist() == [1_000_000_250, 1_000_001_250]
    (made.root / "t.txt").write_text("1\n2\n")
    with pytest.raises(RecordingError, match=r"t\.txt: expected 12 stamps for as many .* got 2"):
        described(made.root, table)
    (made.root / "t.txt").write_text("1\n2\n1.5\n")
    with pytest.raises(RecordingError, match=r"t\.txt, line 3: expected increasing stamps"):
        described(made.root, table)


@pytest.mark.parametrize(
    ("table", "board"),
    [
        (BOARD, Checkerboard(9, 6, 0.04)),
        (
            '[board]\ntype="marker_grid"\nfamily="tag36h11"\ncolumns=4\nrows=3\nmarker_m=0.05\n'
            "gap_m=0.02\nfirst_id=7\n",
            MarkerGrid("tag36h11", 4, 3, 0.05, 0.02, 7),
        ),
        (
            '[board]\ntype="marker"\nfamily="tag25h9"\nmarker_id=3\nside_m=0.1\n',
            SingleMarker("tag25h9", 3, 0.1),
        ),
        (
            '[board]\ntype="charuco"\nfamily="aruco_4x4_50"\ncolumns=7\nrows=5\nsquare_m=0.04\n'
            "marker_m=0.03\n",
            CharucoBoard("aruco_4x4_50", 7, 5, 0.04, 0.03),
        ),
        (
            '[board]\ntype="charuco"\nfamily="aruco_4x4_50"\ncolumns=7\nrows=6\nsquare_m=0.04\n'
            "marker_m=0.03\nlegacy=true\n",
            CharucoBoard("aruco_4x4_50", 7, 6, 0.04, 0.03, legacy=True),
        ),
        (
            '[board]\ntype="marker_grid"\nfamily="tag36h11"\ncolumns=4\nrows=3\nmarker_m=0.05\n'
            'gap_m=0.02\norder="up"\nturned_deg=180\n',
            MarkerGrid("tag36h11", 4, 3, 0.05, 0.02, 0, "up", 180),
        ),
        (
            '[board]\ntype="aprilgrid"\ncolumns=6\nrows=6\nmarker_m=0.088\ngap_m=0.0264\n',
            MarkerGrid("tag36h11_border2", 6, 6, 0.088, 0.0264, 0, "up", 0, True),
        ),
    ],
)
def test_every_board_can_be_described(make: Make, table: str, board: Board) -> None:
    root = make("folder").root
    assert described(root, FRAMES, table).board == board
    assert described(root, FRAMES, section.board_toml(board)).board == board


class TestTruth:
    def test_conventions_are_turned_into_world_T_camera(self, make: Make) -> None:
        made = make("folder")
        np.savetxt(made.root / "poses.txt", made.poses.inverse().as_matrix().reshape(-1, 16))
        table = TRUTH.replace('"world_T_camera"', '"camera_T_world"')
        truth = described(made.root, FRAMES, table).truth
        assert truth is not None
        assert same_poses(truth.poses, made.poses)

    def test_poses_of_the_imu_need_its_place(self, make: Make) -> None:
        made = make("folder")
        table = TRUTH.replace('"world_T_camera"', '"world_T_imu"')
        with pytest.raises(RecordingError, match=r"\[truth\] convention: world_T_imu needs imu_T"):
            described(made.root, FRAMES, table)
        (made.root / "imu.csv").write_text("0,1,1,1,1,1,1\n5,1,1,1,1,1,1\n")
        pose = Motor.random(np.random.default_rng(1))
        imu = f'[imu]\nfile = "imu.csv"\nimu_T_camera = {pose.as_matrix().tolist()}\n'
        recording = described(made.root, FRAMES, table, imu)
        assert recording.truth is not None
        assert same_poses(recording.truth.poses, made.poses @ pose)

    def test_a_stated_offset_of_the_imus_clock_is_taken_off(self, make: Make) -> None:
        made = make("folder")
        (made.root / "imu.csv").write_text("0,1,1,1,1,1,1\n5000000,1,1,1,1,1,1\n")
        table = f'[imu]\nfile = "imu.csv"\nimu_T_camera = {IDENTITY}\nclock_offset_s = -0.25\n'
        recording = described(made.root, FRAMES, table)
        assert recording.imu is not None
        assert recording.imu.time_ns.tolist() == [250_000_000, 255_000_000]
        with pytest.raises(RecordingError, match=r"\[imu\] clock_offset_s: expected a number from"):
            described(made.root, FRAMES, table.replace("-0.25", "1e30"))

    def test_the_board_may_be_the_world_in_either_convention(self, make: Make) -> None:
        made = make("folder")
        pose = Motor.random(np.random.default_rng(2))
        board = BOARD + f"world_T_board = {pose.as_matrix().tolist()}\n"
        ours = described(made.root, FRAMES, board, TRUTH + 'board_frame = "motorcade"\n')
        assert ours.truth is not None
        assert same_poses(ours.truth.poses, pose @ made.poses)
        theirs = described(made.root, FRAMES, board, TRUTH + 'board_frame = "opencv"\n')
        assert theirs.truth is not None
        flipped = Motor.from_rotor_translation(
            Rotor.from_matrix(np.diag([1.0, -1.0, -1.0])), np.zeros(3)
        )
        assert same_poses(theirs.truth.poses, pose @ flipped @ made.poses)
        with pytest.raises(RecordingError, match=r"board_frame: expected a \[board\]"):
            described(made.root, FRAMES, TRUTH + 'board_frame = "opencv"\n')

    def test_rotation_vectors_are_opencvs(self, make: Make) -> None:

        made = make("folder")
        rows = np.random.default_rng(3).uniform(-2, 2, (12, 6))
        np.savetxt(made.root / "poses.txt", rows)
        truth = described(made.root, FRAMES, TRUTH.replace("matrix4", "rotation_vector")).truth
        assert truth is not None
        for row, motor in zip(rows, truth.poses, strict=True):
            assert np.allclose(cv2.Rodrigues(row[:3])[0], motor.rotor.as_matrix(), atol=1e-12)
            assert np.allclose(row[3:], motor.translation_m)

    def test_matrices_may_stand_in_blocks_or_one_a_file(self, make: Make) -> None:
        made = make("folder")
        blocks = made.poses.as_matrix()
        np.savetxt(made.root / "poses.txt", blocks.reshape(-1, 4))
        for index, block in enumerate(blocks):
            np.savetxt(made.root / f"pose{index}.mat", block)
        for file in ("poses.txt", "pose*.mat"):
            truth = described(made.root, FRAMES, TRUTH.replace("poses.txt", file)).truth
            assert truth is not None
            assert same_poses(truth.poses, made.poses)

    def test_bags_bring_topics_and_frames(self, make: Make) -> None:
        made = make("folder")
        bag = write_poses(made.root, "bag").rename(made.root / "poses.bag")
        table = TRUTH.replace("matrix4", "bag").replace("poses.txt", "poses.bag")
        for name in ("/odom", "map/base"):
            truth = described(made.root, FRAMES, table + f'topic = "{name}"\n').truth
            assert truth is not None
            assert same_poses(truth.poses, read_trajectory(f"{bag}:{name}").motors)
        for wrong, problem in {
            table: "topic: the key is missing",
            table + 'topic = "/none"\n': "poses.bag: expected a topic of poses or two frames",
            table + 'topic = "/odom"\nrows = 3\n': "rows: not for bag files",
            TRUTH + 'topic = "/odom"\n': "topic: for bags alone, got format matrix4",
            TRUTH.replace("matrix4", "bag"): "file: expected a bag, got 'poses.txt'",
        }.items():
            with pytest.raises(RecordingError, match=problem):
                described(made.root, FRAMES, wrong)

    def test_stamped_formats_bring_their_own_stamps(self, make: Make) -> None:
        made = make("folder")
        recording = described(made.root, FRAMES, TRUTH)
        assert recording.truth is not None
        for fmt in ("tum", "euroc"):
            write_trajectory(recording.truth, made.root / "poses.txt", fmt)
            truth = described(made.root, FRAMES, TRUTH.replace("matrix4", fmt)).truth
            assert truth is not None
            assert same_poses(truth.poses, made.poses)
            assert np.array_equal(truth.time_ns, made.time_ns)
            with pytest.raises(RecordingError, match="rate_hz: not for"):
                described(made.root, FRAMES, TRUTH.replace("matrix4", fmt), "rate_hz = 5\n")

    def test_unstamped_poses_are_counted(self, make: Make) -> None:
        made = make("folder")
        lines = (made.root / "poses.txt").read_text().splitlines()
        (made.root / "poses.txt").write_text("\n".join(lines + lines[:2]))
        with pytest.raises(RecordingError, match="a pose for each of 12 frames, got 14; say how"):
            described(made.root, FRAMES, TRUTH)
        truth = described(made.root, FRAMES, TRUTH, "rows = 12\n").truth
        assert truth is not None
        assert same_poses(truth.poses, made.poses)
        assert len(described(made.root, FRAMES, TRUTH, "rate_hz = 50\n").truth or ()) == 14
        (made.root / "images" / "img_12.jpg").unlink()
        with pytest.raises(RecordingError, match="for each of 11 frames, got 12"):
            described(made.root, FRAMES, TRUTH, "rows = 12\n")


class TestOnTopOfALayout:
    def test_tables_replace_what_the_layout_says(self, make: Make) -> None:
        made = make("tum_rgbd", "unknown camera")
        recording = described(made.root, CAMERA, BOARD)
        recording.check()
        assert recording.layout == "tum_rgbd"
        assert recording.camera is not None
        assert recording.truth is not None
        assert recording.frames[0].depth_m() is not None

    def test_a_readout_time_alone_leaves_the_layouts_camera(self, make: Make) -> None:
        made = make("euroc")
        own = open_recording(made.root)
        rolling = described(made.root, "[camera]\nreadout_s = 0.015\n")
        assert (own.readout_s, rolling.readout_s) == (0.0, 0.015)
        assert rolling.camera == own.camera is not None
        assert rolling.digest() != own.digest()
        with_another = described(made.root, CAMERA, "readout_s = 0.02\n")
        assert with_another.camera != own.camera
        assert with_another.readout_s == 0.02

    def test_a_truth_can_be_chosen_where_the_layout_cannot(self, make: Make) -> None:
        made = make("euroc")
        truth = made.root / "mav0" / "state_groundtruth_estimate0" / "data.csv"
        truth.write_text("broken")
        write = "1 1 0 0 0 0 0 1\n"
        (made.root / "mine.tum").write_text(write)
        table = TRUTH.replace("poses.txt", "mine.tum").replace("matrix4", "tum")
        recording = described(made.root, table.replace("world_T_camera", "world_T_imu"))
        assert recording.truth is not None
        assert recording.imu_T_camera is not None
        expected = recording.imu_T_camera.translation_m + np.array([1.0, 0.0, 0.0])
        assert np.allclose(recording.truth.poses.translation_m[0], expected)

    def test_noise_and_extrinsics_can_be_replaced_alone(self, make: Make) -> None:
        made = make("euroc")
        (made.root / "noise.yaml").write_text(
            "gyroscope_noise_density: 1e-3\ngyroscope_random_walk: 1e-4\n"
            "accelerometer_noise_density: 1.0e-2\naccelerometer_random_walk: 0.1\n"
        )
        table = f'[imu]\nnoise_file = "noise.yaml"\nimu_T_camera = {IDENTITY}\n'
        recording = described(made.root, table)
        assert recording.imu_noise is not None
        assert recording.imu_noise.gyro_density_rad_s_rthz == 1e-3
        assert recording.imu_T_camera is not None
        assert same_poses(recording.imu_T_camera, Motor.identity())

    def test_without_layout_the_frames_are_asked_for(self, make: Make) -> None:
        with pytest.raises(RecordingError, match="frames: the table is missing"):
            described(make("folder").root, CAMERA)


def test_a_missing_or_truncated_image_is_named(
    make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    made = make("folder")
    path = made.root / "images" / "img_7.jpg"
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(RecordingError, match=r"img_7\.jpg, frame 6: the image is truncated"):
        described(made.root, FRAMES, CAMERA).check()
    path.unlink()
    described(made.root, FRAMES, CAMERA)
    assert "1 are not there, the first between img_6.jpg and img_8.jpg" in caplog.text


def test_a_found_manifest_may_not_look_outside(make: Make) -> None:
    made = make("folder")
    outside = made.root.parent / "poses.txt"
    (made.root / "poses.txt").rename(outside)
    for name in ("../poses.txt", str(outside)):
        text = FRAMES + TRUTH.replace("poses.txt", name)
        (made.root / "motorcade.toml").write_text(text)
        with pytest.raises(RecordingError, match="expected a file name inside"):
            open_recording(made.root)
        assert described(made.root, text).truth is not None
    (made.root / "link.txt").symlink_to(outside)
    (made.root / "motorcade.toml").write_text(FRAMES + TRUTH.replace("poses", "link"))
    with pytest.raises(RecordingError, match=r"\[truth\] file: .* got a link out of it"):
        open_recording(made.root)


def test_settings_of_a_found_manifest_may_not_look_outside(make: Make) -> None:
    made = make("folder")
    for name in ("../hero.glb", str(made.root.parent / "hero.glb")):
        text = f"settings = ['placed.character={name}']\n" + FRAMES
        (made.root / "motorcade.toml").write_text(text)
        with pytest.raises(RecordingError, match="expected a file name inside"):
            open_recording(made.root)
    for value in ("mannequin", ""):
        text = f"settings = ['placed.character={value}', 'smoothed.order=1']\n" + FRAMES
        (made.root / "motorcade.toml").write_text(text)
        settings = (f"placed.character={value}", "smoothed.order=1")
        assert open_recording(made.root).settings == settings


def test_files_that_settings_name_lie_in_the_recording(make: Make) -> None:
    made = make("folder")
    text = "settings = ['placed.character=figures/hero.glb']\n" + FRAMES
    (made.root / "motorcade.toml").write_text(text)
    expected = (f"placed.character={made.root / 'figures' / 'hero.glb'}",)
    assert open_recording(made.root).settings == expected
    assert described(made.root, text).settings == expected


def test_knobs_of_files_are_known() -> None:
    named = {
        f"{stage.name}.{name}": str(knob.default)
        for stage in pipeline_graph().stages.values()
        for name, knob in stage.knobs.items()
        if knob.annotation is Path
    }
    assert named == section.FILE_KNOBS


@settings(deadline=None, max_examples=100)
@given(
    place=st.integers(0, 10**6),
    text=st.text(alphabet=st.characters(codec="utf-8"), max_size=6),
    length=st.integers(0, 5),
)
def test_a_garbled_manifest_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, place: int, text: str, length: int
) -> None:
    root = tmp_path_factory.getbasetemp() / "garbled"
    root.mkdir(exist_ok=True)
    whole = 'name = "x"\n' + FRAMES + CAMERA + BOARD + TRUTH
    at = place % len(whole)
    garbled = root / "garbled.toml"
    garbled.write_text(whole[:at] + text + whole[at + length :], newline="")
    with pytest.raises(RecordingError) as refused:
        open_recording(root, garbled)
    assert "\n" not in str(refused.value)
