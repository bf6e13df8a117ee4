"""Where poses come from, through the command: board, loose markers, recorded corners, SLAM."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import even_stamps, read_trajectory, write_trajectory
from motorcade.tracking import Camera
from motorcade.tracking.markers.marker_map import MarkerMap
from tests.bench.tracking.tag_flips import tagslam_folder
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import scenario

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
TABLES = """
[frames]
images = "*.png"
rate_hz = 20.0
[camera]
model = "pinhole"
fx = 300.0
fy = 300.0
cx = 159.5
cy = 119.5
[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"
"""
MARKERS = '[markers]\nfamily = "tag36h11"\nside_m = 0.1\n'
PLAIN = ("--set", "smoothed.representations=motor")


def report(out: Path, *arguments: object) -> dict[str, Any]:
    assert main(["run", *map(str, arguments), *PLAIN, "--out", str(out)]) == 0
    found: dict[str, Any] = json.loads((out / "report.json").read_text())
    return found


@pytest.fixture(scope="module")
def tags(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Motor]:
    """Images of six loose markers on a wall, which a manifest names by their family."""
    folder = tmp_path_factory.mktemp("tags") / "tags"
    folder.mkdir()
    rng = np.random.default_rng(4)
    wall = wall_of_markers(3, 2, 0.16, 30.0, rng)
    scene = TagScene(CAMERA, "tag36h11", np.arange(6), 0.1, wall)
    path = handheld_path(16, 0.7)
    for index in range(16):
        cv2.imwrite(str(folder / f"{index:02d}.png"), scene.image(path[index], rng))
    write_trajectory(Trajectory(even_stamps(16, 20.0), path), folder / "truth.tum")
    (folder / "motorcade.toml").write_text(TABLES + MARKERS)
    return folder, wall


def test_loose_markers_are_mapped_and_the_map_serves_again(
    tags: tuple[Path, Motor], tmp_path: Path
) -> None:
    folder, wall = tags
    found = report(tmp_path / "first", folder)
    assert found["camera_poses"]["origin"] == "markers"
    assert "6 loose markers, mapped from this recording alone" in found["camera_poses"]["summary"]
    assert found["camera_poses"]["measured"] == 16
    assert found["align"] == "se3"
    assert found["errors"]["measured"]["ape_rmse_m"] < 0.002
    made = MarkerMap.load(tmp_path / "first" / "marker_map.json")
    base = int(np.argmin(np.linalg.norm(made.world_T_marker.as_twist(), axis=-1)))
    apart = (wall[base].reshape(1) @ made.world_T_marker).inverse() @ wall
    assert np.linalg.norm(apart.translation_m, axis=-1).max() < 0.003
    # The true map, given by hand: the poses are then in its world, with nothing to align.
    known = MarkerMap(np.arange(6), np.full(6, 0.1), wall.rotor, wall.translation_m)
    known.save(folder / "known.json")
    manifest = tmp_path / "known.toml"
    manifest.write_text(TABLES + MARKERS + 'map_file = "known.json"\n')
    again = report(tmp_path / "again", folder, "--manifest", manifest, "--set", "errors.align=none")
    assert "where a map places them" in again["camera_poses"]["summary"]
    assert again["errors"]["measured"]["ape_rmse_m"] < 0.002
    assert again["errors"]["measured"]["rotation_rmse_deg"] < 0.3


def test_loose_markers_are_refined_on_their_print_where_that_is_asked_for(
    tags: tuple[Path, Motor], tmp_path: Path
) -> None:
    pytest.importorskip("kornia", reason="photometric refinement needs torch and kornia")
    few = tmp_path / "few"
    shutil.copytree(tags[0], few)
    for path in sorted(few.glob("*.png"))[5:]:
        path.unlink()
    knob = ("--set", "marker_poses.refine=photometric")
    plain = report(tmp_path / "plain", few)
    found = report(tmp_path / "refined", few, *knob)
    assert found["camera_poses"]["summary"].endswith("refined on their prints")
    assert found["errors"]["measured"]["ape_rmse_m"] < plain["errors"]["measured"]["ape_rmse_m"]
    code = (
        "import sys; sys.modules['torch'] = None; from motorcade.replays.cli import main; "
        "sys.exit(main())"
    )
    arguments = [code, "run", str(few), "--out", str(tmp_path / "none"), *knob]
    done = subprocess.run(
        [sys.executable, "-c", *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert 'pip install "motorcade[photometric]"' in done.stderr.splitlines()[-1]


def test_a_board_that_is_named_but_never_seen_is_skipped_and_said(
    tags: tuple[Path, Motor], tmp_path: Path
) -> None:
    folder, _ = tags
    manifest = tmp_path / "board.toml"
    board = '[board]\ntype = "checkerboard"\ncolumns = 9\nrows = 6\nsquare_m = 0.04\n'
    manifest.write_text(TABLES + MARKERS + board)
    found = report(tmp_path, folder, "--manifest", manifest)
    assert found["camera_poses"]["origin"] == "markers"
    (passed,) = found["camera_poses"]["skipped"]
    assert passed.startswith("board: frames: expected some that show checkerboard")
    assert "Skipped: board" in (tmp_path / "report.html").read_text()


def resumed_in_the_map_of_an_earlier_run(folder: Path, tmp_path: Path) -> None:
    manifest = tmp_path / "resumed.toml"
    again = '[slam]\nmap_file = "../depth/slam_map.npz"\n'
    manifest.write_text((folder / "motorcade.toml").read_text() + again)
    found = report(tmp_path / "again", folder, "--manifest", manifest, "--set", "errors.align=auto")
    assert "in a saved map, with depth" in found["camera_poses"]["summary"]
    assert found["camera_poses"]["measured"] >= 55
    assert found["errors"]["measured"]["ape_rmse_m"] < 0.005


@pytest.mark.slow
def test_without_board_or_markers_slam_gives_a_path_of_free_scale(tmp_path: Path) -> None:
    folder = tmp_path / "room"
    write_recording(folder, scenario("handheld", frames=60), name="room")
    found = report(tmp_path / "depth", folder, "--set", "errors.align=auto")
    assert (found["camera_poses"]["origin"], found["camera_poses"]["scale"]) == ("slam", "metric")
    assert found["align"] == "se3"
    assert found["errors"]["measured"]["ape_rmse_m"] < 0.005
    resumed_in_the_map_of_an_earlier_run(folder, tmp_path)
    (folder / "depth.txt").unlink()
    manifest = folder / "motorcade.toml"
    manifest.write_text(manifest.read_text().partition("[stereo]")[0])
    (folder / "groundtruth.txt").unlink()
    found = report(tmp_path / "one", folder)
    assert (found["camera_poses"]["origin"], found["camera_poses"]["scale"]) == ("slam", "free")
    assert "scale: free" in (tmp_path / "one" / "report.html").read_text()
    path = read_trajectory(tmp_path / "one" / "trajectories" / "camera_poses_motor.tum")
    truth = scenario("handheld", frames=60).truth()
    assert evaluate(path, truth, align="sim3").ape_m.rmse < 0.005


def test_recorded_corners_run_to_a_report_without_a_video(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    source = tagslam_folder() / "test_23"
    if not source.is_dir():
        pytest.skip("no recordings of tags here: set MOTORCADE_DATA to the recordings' folder")
    folder = tmp_path / "test_23"
    shutil.copytree(source, folder)
    found = report(tmp_path / "out", folder)
    assert "overlay: left out: the recording holds corners" in caplog.text
    assert found["camera_poses"]["origin"] == "markers"
    assert "recorded corners of 8 markers" in found["camera_poses"]["summary"]
    # The markers are carried past a camera at rest: the reference is seen from them.
    assert found["errors"]["measured"]["ape_rmse_m"] < 0.002
    assert found["overlay"] is None
    page = (tmp_path / "out" / "report.html").read_text()
    assert "corners of markers and no images" in page
    assert not (tmp_path / "out" / "overlay.mp4").exists()
    assert len(MarkerMap.load(tmp_path / "out" / "marker_map.json")) == 8


@pytest.mark.slow
@pytest.mark.parametrize(("by", "frames"), [("inside", 150), ("afterwards", 90)])
def test_an_imu_gives_one_camera_its_metres(by: str, frames: int, tmp_path: Path) -> None:
    folder = tmp_path / "room"
    write_recording(folder, scenario("handheld", frames=frames), name="room", imu=True)
    (folder / "depth.txt").unlink()
    manifest = folder / "motorcade.toml"
    camera, _, rest = manifest.read_text().partition("[stereo]")
    manifest.write_text(camera + rest[rest.index("[imu]") :])
    inside = "true" if by == "inside" else "false"
    settings = ("errors.align=auto", f"slam_poses.imu_inside={inside}")
    found = report(tmp_path / "out", folder, *(part for one in settings for part in ("--set", one)))
    poses = found["camera_poses"]
    assert (poses["origin"], poses["scale"], found["align"]) == ("slam", "metric", "se3")
    told = poses["inertial"]
    if by == "inside":
        assert "with the IMU inside, metres and up" in poses["summary"]
        assert told["metric_from_s"] < 5.0
        assert told["frames_in_state"]["tracking"] > 10
        # The camera looks level: gravity is along its y, and the report says how surely.
        assert told["gravity_direction"][1] > np.cos(np.deg2rad(30.0))
        assert 0.0 < told["tilt_sigma_deg"] < 1.2
        assert told["states"][-1]["state"] == "tracking"
    else:
        assert "metres and up found by the IMU" in poses["summary"]
        assert told is None
    assert 0.0 < poses["scale_sigma"] < 0.1
    assert (found["imu"]["origin"], found["fused"]["by"]) == ("recorded", "imu")
    assert found["errors"]["fused"]["ape_rmse_m"] < 0.01
    path = read_trajectory(tmp_path / "out" / "trajectories" / "fused_motor.tum")
    truth = scenario("handheld", frames=frames).truth()
    assert evaluate(path, truth, align="sim3").scale == pytest.approx(1.0, abs=0.03)
    # Up is up: but for where it starts and which way it looks, the path needs no alignment.
    tilt = evaluate(path, truth, align="se3")
    assert tilt.rotation_deg.rmse < 0.5
    rise = path.motors.translation_m[:, 2] - truth.motors_at(path.time_ns).translation_m[:, 2]
    assert np.ptp(rise) < 0.02
    page = (tmp_path / "out" / "report.html").read_text()
    assert "The path was fused with the recorded IMU" in page


@pytest.mark.slow
def test_recorded_odometry_bridges_frames_without_a_tag(data_dir: Path, tmp_path: Path) -> None:
    found = report(tmp_path, data_dir / "tags" / "tagslam" / "test_21")
    assert found["camera_poses"]["measured"] == 431  # 402 of them show a tag
    assert found["fused"]["by"] == "nothing"  # the odometry is in the measured poses already
    measured = found["errors"]["measured"]
    assert measured["pairs"] == 430
    assert measured["ape_rmse_m"] <= 0.001
    assert "recorded odometry" in (tmp_path / "report.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "align", "ape_m", "measured"),
    [("test_21", "se3", 0.001, 431), ("test_24", "se3", 0.012, 58)],
)
def test_tagslam_recordings_agree_with_their_reference(
    name: str, align: str, ape_m: float, measured: int, data_dir: Path, tmp_path: Path
) -> None:
    root = data_dir / "tags" / "tagslam" / name
    found = report(tmp_path, root, "--set", f"errors.align={align}")
    assert found["camera_poses"]["measured"] == measured
    assert found["errors"]["measured"]["ape_rmse_m"] <= ape_m
    assert found["errors"]["measured"]["scale"] == pytest.approx(1.0, abs=0.03)
