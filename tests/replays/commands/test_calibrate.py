"""`motorcade calibrate`: images and videos of a board in, a camera file and an image out."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.replays.cli import main
from motorcade.replays.io.readers.manifest.section import read_board, read_camera
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import (
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    SingleMarker,
)
from motorcade.tracking.boards import board_named
from motorcade.tracking.boards.corners import BoardCorners

BOARD = Checkerboard(7, 4, 0.03)
CAMERA = Camera(320, 240, 300.0, 298.0, 161.0, 117.0)


def take(pose: Motor) -> np.ndarray:
    """The drawn board as the camera sees it from `pose` (world_T_camera)."""
    scale = 4000.0
    image, origin = BOARD.draw(scale)
    corners = BOARD.points_m[[0, 6, 27, 21]]
    plane = np.array(origin) + scale * corners[:, :2] * (1.0, -1.0)
    pixels = CAMERA.project(pose.inverse().apply(corners))
    warp = cv2.getPerspectiveTransform(plane.astype(np.float32), pixels.astype(np.float32))
    small = cv2.GaussianBlur(image, (0, 0), 3.0)
    return cv2.warpPerspective(small, warp, (320, 240), flags=cv2.INTER_AREA, borderValue=128)


def tilted(index: int, tilt_deg: float = 35.0) -> Motor:
    """A view of the board's middle, tilted another way for each index."""
    azimuth = 2.0 * index
    axis = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    tilt = Rotor.from_rotation_vector(np.radians(tilt_deg) * axis)
    rotor = tilt @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    middle = BOARD.points_m.mean(axis=0) + 0.012 * np.array([np.sin(index), np.cos(index), 0.0])
    return Motor.from_rotor_translation(rotor, middle + tilt.apply([0.0, 0.0, 0.3]))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    images = tmp_path / "images"
    images.mkdir()
    for index in range(9):
        cv2.imwrite(str(images / f"view_{index}.png"), take(tilted(index)))
    return images


def test_a_folder_of_images_gives_the_camera(folder: Path, tmp_path: Path, capsys) -> None:
    cv2.imwrite(str(folder / "small.png"), np.zeros((100, 100), np.uint8))
    cv2.imwrite(str(folder / "nothing.png"), np.full((240, 320), 90, np.uint8))
    (folder / "torn.png").write_bytes((folder / "view_0.png").read_bytes()[:2000])
    out = tmp_path / "out" / "camera.toml"
    named = ["--board", BOARD.name, "-o", str(out), "--model", "pinhole", "--json"]
    assert main(["calibrate", str(folder), *named]) == 0
    printed, err = capsys.readouterr()
    found = json.loads(printed)
    assert (found["images_searched"], found["images_with_board"]) == (10, 9)
    assert len(found["unreadable"]) == len(err.strip().splitlines()) == 2
    assert "small.png" in err
    assert "torn.png" in err
    assert found["views_used"] == 9
    assert found["reprojection_rmse_px"] < 0.1
    assert 0.0 < found["coverage"] <= 1.0
    camera = read_camera(out)
    for key in ("fx", "fy", "cx", "cy"):
        away = abs(getattr(camera, key) - getattr(CAMERA, key))
        assert away < 3.0 * found["standard_deviation"][f"{key}_px"] < 12.0
    assert camera.fx == found["camera"]["fx_px"]
    image = cv2.imread(str(out.with_name("camera_coverage.png")))
    assert image.shape[0] > 300
    assert image.std() > 10.0


def test_the_file_is_a_manifest_for_the_video_that_it_came_from(
    folder: Path, tmp_path: Path, capsys
) -> None:
    import av

    path = tmp_path / "board.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("h264", rate=30, options={"crf": "12"})
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        for index in range(9):
            image = take(tilted(index))
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(stream.encode())
    out = tmp_path / "camera.toml"
    named = ["--board", BOARD.name, "-o", str(out), "--model", "pinhole"]
    assert main(["calibrate", str(path), *named]) == 0
    told = capsys.readouterr().out
    assert "found in 9 of 9 images; 9 views used, 0 left out" in told
    assert "camera_coverage.png" in told
    recording = open_recording(path, out)
    assert recording.camera == read_camera(out)
    assert abs(recording.camera.fx - CAMERA.fx) < 6.0


def test_what_gives_no_camera_is_told_in_one_line(folder: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "camera.toml"

    def refusal_of(*arguments: object) -> str:
        assert main(["calibrate", *map(str, arguments), "-o", str(out)]) == 1
        err = capsys.readouterr().err.strip()
        assert len(err.splitlines()) == 1
        assert not out.exists()
        return err

    two = [folder / "view_0.png", folder / "view_1.png"]
    assert "at least 3 that show the board, got 2" in refusal_of(*two, "--board", BOARD.name)
    other = refusal_of(*two, "--board", "tag36h11_id_7_65mm")
    assert "in none of 2 that could be read, 0 could not" in other
    assert "expected a name such as" in refusal_of(*two, "--board", "chessboard")
    for missing in (tmp_path / "no.mp4", tmp_path / "no.png", tmp_path / "no_folder"):
        said = f"motorcade: {missing}: the file is missing"
        assert refusal_of(missing, "--board", BOARD.name) == said
        assert refusal_of(*two, missing, "--board", BOARD.name) == said
    for index in range(5):
        cv2.imwrite(str(tmp_path / f"flat_{index}.png"), take(tilted(index, 0.0)))
    flat = [tmp_path / f"flat_{index}.png" for index in range(5)]
    assert "tilt" in refusal_of(*flat, "--board", BOARD.name, "--model", "pinhole")


@pytest.mark.parametrize(
    "board",
    [
        Checkerboard(9, 6, 0.04),
        CharucoBoard("aruco_5x5_100", 7, 5, 0.04, 0.0285),
        MarkerGrid("tag36h11", 6, 4, 0.03, 0.009),
        MarkerGrid("aruco_4x4_1000", 2, 2, 0.0305, 0.001, 7),
        SingleMarker("aruco_mip_36h12", 7, 0.065),
    ],
    ids=lambda board: board.name,
)
def test_boards_are_known_by_their_names(board) -> None:
    assert board_named(board.name) == board
    assert read_board(board.name) == board


def test_boards_are_read_from_files(tmp_path: Path) -> None:
    path = tmp_path / "board.toml"
    path.write_text('[board]\ntype = "checkerboard"\ncolumns = 9\nrows = 6\nsquare_m = 0.04\n')
    assert read_board(str(path)) == Checkerboard(9, 6, 0.04)
    path.write_text("[camera]\n")
    with pytest.raises(ValueError, match=r"board\.toml, board: the table is missing"):
        read_board(str(path))
    with pytest.raises(ValueError, match="at least 3, got 2"):
        read_board("checkerboard_2x6_40mm")
    assert board_named("tag36h11_6x4_30mm_gap_9mm") == MarkerGrid("tag36h11", 6, 4, 0.03, 0.009)


def test_the_lens_that_predicts_held_out_views_is_taken_and_a_worse_one_doubted(
    tmp_path: Path, capsys, monkeypatch
) -> None:
    fisheye = Camera(320, 240, 110.0, 110.0, 161.0, 117.0, "equidistant", (0.02, -0.01, 0.0, 0.0))
    rng = np.random.default_rng(5)
    images = tmp_path / "images"
    images.mkdir()
    for index in range(12):
        cv2.imwrite(str(images / f"view_{index:02}.png"), np.full((240, 320), index, np.uint8))

    def detect(board: Checkerboard, gray: np.ndarray) -> BoardCorners:
        index = int(gray[0, 0])
        near = Motor.from_rotor_translation(Rotor.identity(), [0.0, 0.0, 0.19])
        aside = Rotor.from_rotation_vector([*rng.uniform(-0.5, 0.5, 2), 0.0])
        pose = tilted(index) @ near @ Motor.from_rotor_translation(aside, np.zeros(3))
        px = fisheye.project(pose.inverse().apply(board.points_m))
        return BoardCorners(np.arange(28), px + 0.1 * rng.normal(size=px.shape), board.points_m)

    monkeypatch.setattr(Checkerboard, "detect", detect)
    out = tmp_path / "camera.toml"
    named = ["calibrate", str(images), "--board", BOARD.name, "-o", str(out)]
    assert main(named) == 0
    assert "lens equidistant" in capsys.readouterr().out
    camera = read_camera(out)
    assert camera.model == "equidistant"
    assert abs(camera.fx - fisheye.fx) < 1.0
    assert main([*named, "--model", "radtan"]) == 0
    assert "say --model equidistant" in capsys.readouterr().err
