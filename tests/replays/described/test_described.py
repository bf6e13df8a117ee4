"""Recordings of which nothing was told: what is found out, said, written and repeated."""

import json
import tomllib
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from motorcade.fusion.imu import ImuStream
from motorcade.ga import Motor, Rotor
from motorcade.render import write_video
from motorcade.replays import Job, open_recording, run_job
from motorcade.replays.cli.main import main
from motorcade.replays.demo import write_recording
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.described.describing import described
from motorcade.replays.pipeline.described.footage import (
    GOPRO_IMU_R_CAMERA,
    camera_by_turning,
    camera_by_view,
    check_axes,
    seen_turns,
)
from motorcade.replays.pipeline.described.values import sampled_images
from motorcade.tracking import Checkerboard, MarkerGrid

FOCAL_PX = 510.0  # of the room's camera, which is not told here


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seconds of a room with six tags on its wall, 80 mm wide and 20 mm apart."""
    folder = tmp_path_factory.mktemp("room")
    write_recording(folder / "room", frames=60)
    names = sorted((folder / "room" / "images").glob("*.jpg"))
    images = [cv2.imread(str(name))[..., ::-1] for name in names]
    write_video(folder / "clip.mp4", images, np.arange(len(names)) * 33_333_333)
    return folder / "clip.mp4"


def result_files(out: Path) -> dict[str, bytes]:
    kept = [*(out / "trajectories").glob("*.tum")]
    return {path.name: path.read_bytes() for path in kept}


@pytest.mark.slow
def test_a_clip_alone_gives_its_camera_its_board_and_a_manifest_that_repeats_it(
    clip: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, again = tmp_path / "out", tmp_path / "again"
    assert main(["run", str(clip), "--out", str(out), "--until", "errors"]) == 0
    log = json.loads((out / "run.json").read_text())
    said = [line.partition(":")[0] for line in log["assumed"]]
    assert said == ["camera", "target", "size", "tracking", "up"]
    assert all("; override: " in line for line in log["assumed"])
    manifest = tomllib.loads((out / "manifest.toml").read_text())
    assert manifest["camera"]["fx"] == pytest.approx(FOCAL_PX, rel=0.01)
    board = manifest["board"]
    assert (board["family"], board["columns"], board["rows"]) == ("tag36h11", 3, 2)
    assert board["gap_m"] / board["marker_m"] == pytest.approx(0.25, rel=0.01)
    assert board["metric"] is False
    named = ["--manifest", str(out / "manifest.toml"), "--out", str(again)]
    assert main(["run", str(clip), *named, "--until", "errors"]) == 0
    assert result_files(again) == result_files(out) != {}
    assert not (again / "manifest.toml").exists()


@pytest.mark.slow
def test_what_is_told_is_not_looked_for(clip: Path, tmp_path: Path) -> None:
    told = ("described.fov_deg=65", "described.size_m=0.08")
    run_job(Job(clip, tmp_path / "out", until="camera_poses", settings=told))
    manifest = tomllib.loads((tmp_path / "out" / "manifest.toml").read_text())
    assert manifest["board"]["marker_m"] == 0.08
    assert "metric" not in manifest["board"]
    assert manifest["camera"]["fx"] == pytest.approx(320.0 / np.tan(np.deg2rad(32.5)))
    log = json.loads((tmp_path / "out" / "run.json").read_text())
    assert log["manifest"] == str(tmp_path / "out" / "manifest.toml")
    assert not any(one.startswith("described") for one in log["settings"])


def test_a_manifest_without_a_camera_is_completed(clip: Path, tmp_path: Path) -> None:
    given = tmp_path / "board.toml"
    board = MarkerGrid("tag36h11", 3, 2, 0.08, 0.02)
    keys = f'family = "{board.family}"\ncolumns = 3\nrows = 2\nmarker_m = 0.08\ngap_m = 0.02\n'
    given.write_text(f'name = "mine"\n[board]\ntype = "marker_grid"\n{keys}')
    told = ("described.fov_deg=65",)
    run_job(Job(clip, tmp_path / "out", given, until="camera_poses", settings=told))
    manifest = tomllib.loads((tmp_path / "out" / "manifest.toml").read_text())
    assert manifest["name"] == "mine"
    assert manifest["board"]["marker_m"] == 0.08
    assert "camera" in manifest


def test_knobs_for_a_recording_that_names_its_camera_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_recording(tmp_path / "room", frames=3)
    options = ["--out", str(tmp_path / "out"), "--set", "described.size_m=0.1"]
    assert main(["run", str(tmp_path / "room"), *options]) == 1
    assert "described.size_m" in capsys.readouterr().err


def test_images_that_tell_nothing_are_refused_with_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "grey"
    folder.mkdir()
    for number in range(6):
        cv2.imwrite(str(folder / f"{number}.png"), np.full((120, 160), 90, np.uint8))
    assert main(["run", str(folder), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert "expected images with something to see" in error
    assert "0-5 plain" in error
    assert "described.fov_deg" not in error  # no view makes a path of them
    assert main(["inspect", str(folder)]) == 0
    assert "with something to see" in capsys.readouterr().out


def test_a_folder_of_images_says_its_rate_and_where_they_lie(tmp_path: Path) -> None:
    (tmp_path / "set" / "shots").mkdir(parents=True)
    (tmp_path / "set" / "notes").mkdir()
    for number in range(4):
        cv2.imwrite(str(tmp_path / "set" / "shots" / f"{number}.png"), np.zeros((48, 64), np.uint8))
    recording = open_recording(tmp_path / "set")
    found = described(recording, target="none", fov_deg=60.0, rate_hz=10.0)
    path = tmp_path / "manifest.toml"
    path.write_text(found.manifest(""))
    again = open_recording(tmp_path / "set", path)
    assert len(again.frames) == 4
    assert again.duration_s == pytest.approx(0.3)


def turned_clip(path: Path, turned_deg: int = 0, pixel_aspect: Fraction | None = None) -> Path:
    """Four images of texture, to be shown turned, or wider than they are stored."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        if pixel_aspect is not None:
            stream.codec_context.sample_aspect_ratio = pixel_aspect
        if turned_deg:
            stream.set_display_matrix([-65536, 0, 0, 0, -65536, 0, 0, 0, 1 << 30])
        rng = np.random.default_rng(2)
        for index in range(4):
            image = rng.integers(0, 255, (64, 96, 3), dtype=np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="rgb24").reformat(format="yuv420p")
            frame.pts, frame.time_base = index, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def test_a_camera_that_was_found_is_said_to_be_of_the_images_as_shown(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clip = turned_clip(tmp_path / "clip.mp4", turned_deg=180)
    found = described(open_recording(clip), target="none", fov_deg=60.0)
    (tmp_path / "manifest.toml").write_text(found.manifest(""))
    assert tomllib.loads(found.tables)["camera"]["rotation_deg"] == 180
    camera = open_recording(clip, tmp_path / "manifest.toml").camera
    assert camera is not None
    assert not caplog.records  # nothing about it is taken for granted


def test_oblong_pixels_are_refused_with_what_makes_them_square(tmp_path: Path) -> None:
    clip = turned_clip(tmp_path / "tape.mp4", pixel_aspect=Fraction(4, 3))
    with pytest.raises(ValueError, match=r"1\.33 times as wide .* -i tape\.mp4 -vf 'scale=trunc"):
        described(open_recording(clip), target="none")


def test_of_a_few_images_every_one_is_looked_at(tmp_path: Path) -> None:
    sample = sampled_images(open_recording(turned_clip(tmp_path / "clip.mp4")).frames)
    assert sample.places == (0, 1, 2, 3)


def turning_frames(folder: Path, imu_R_camera: np.ndarray) -> tuple[Recording, ImuStream]:
    """A texture far away seen by a camera that turns about all axes, and its gyroscope."""
    rng = np.random.default_rng(4)
    noise = cv2.GaussianBlur(rng.integers(0, 255, (900, 900)).astype(np.float32), (0, 0), 3.0)
    wall = cv2.normalize(noise, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    camera = camera_by_view((320, 240), 60.0)
    seconds = np.arange(20) / 30.0
    turn = np.stack([0.2 * np.sin(4 * seconds), 0.3 * np.sin(3 * seconds), 0.5 * seconds], axis=-1)
    world_R_camera = Rotor.from_rotation_vector(turn)
    far = np.array([[900.0, 0.0, 449.5], [0.0, 900.0, 449.5], [0.0, 0.0, 1.0]])
    files = []
    for number, pose in enumerate(world_R_camera.as_matrix()):
        to_image = camera.matrix @ pose.T @ np.linalg.inv(far)
        files.append(folder / f"{number}.png")
        cv2.imwrite(str(files[-1]), cv2.warpPerspective(wall, to_image, (320, 240)))
    time_ns = np.rint(1e9 * seconds).astype(np.int64)
    poses = Motor.from_rotor_translation(world_R_camera, np.zeros((20, 3)))
    rates = 30.0 * poses[:-1].local(poses[1:])[:, :3] @ imu_R_camera.T
    stamps = (time_ns[:-1] + time_ns[1:]) // 2
    imu = ImuStream(stamps, rates, np.tile([0.0, 0.0, 9.81], (19, 1)))
    return Recording("turning", folder, "images", ImageFrames(tuple(files), time_ns)), imu


@pytest.mark.parametrize(
    ("imu_R_camera", "verdict"), [(GOPRO_IMU_R_CAMERA, "agree"), (np.eye(3), "contradict")]
)
def test_images_say_whether_an_imu_sits_as_stated(
    imu_R_camera: np.ndarray, verdict: str, tmp_path: Path
) -> None:
    recording, imu = turning_frames(tmp_path, imu_R_camera)
    camera = camera_by_view((320, 240), 60.0)
    turns = seen_turns(recording.frames, imu)
    assert check_axes(turns, camera, GOPRO_IMU_R_CAMERA).verdict == verdict


def test_a_gyroscope_tells_the_focal_length(tmp_path: Path) -> None:
    recording, imu = turning_frames(tmp_path, GOPRO_IMU_R_CAMERA)
    found = camera_by_turning(seen_turns(recording.frames, imu), (320, 240))
    assert found is not None
    true_px = camera_by_view((320, 240), 60.0).fx
    assert found.camera.fx == pytest.approx(true_px, rel=0.02)
    assert abs(found.camera.fx / true_px - 1.0) < 4.0 * found.sigma + 0.005


@pytest.mark.slow
def test_a_board_that_is_named_is_taken_in_its_own_units(clip: Path, tmp_path: Path) -> None:
    options = ["--board", "tag36h11_3x2_80mm_gap_20mm", "--set", "described.fov_deg=65"]
    until = ["--until", "camera_poses", "--out", str(tmp_path / "out")]
    assert main(["run", str(clip), *options, *until]) == 0
    board = tomllib.loads((tmp_path / "out" / "manifest.toml").read_text())["board"]
    assert (board["marker_m"], board["gap_m"]) == (0.08, pytest.approx(0.02))
    assert "metric" not in board


def test_a_board_that_no_image_shows_is_refused_with_the_one_that_is_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "boards"
    folder.mkdir()
    image, _ = Checkerboard(7, 5, 0.03).draw(pixels_per_m=1000.0)
    for number in range(4):
        cv2.imwrite(str(folder / f"{number}.png"), image)
    options = ["--board", "checkerboard_9x6", "--out", str(tmp_path / "out")]
    assert main(["run", str(folder), *options]) == 1
    error = capsys.readouterr().err
    assert "checkerboard_9x6 is in 0 of 4 images; they show a checkerboard of 7 x 5" in error
    assert main(["run", str(folder), "--board", "9x6", "--out", str(tmp_path / "out")]) == 1
    assert "expected a name such as checkerboard_9x6" in capsys.readouterr().err
