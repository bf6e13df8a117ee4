"""`motorcade detect`: what it prints and writes, for images of every kind and for bad ones."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.replays.cli import main
from motorcade.replays.io.readers.manifest.section import camera_toml, read_camera
from motorcade.replays.tasks.images import draw, drawing_names, markers_in
from motorcade.tracking import Camera, MarkerGrid, SingleMarker

GRID = MarkerGrid("tag36h11", 3, 2, 0.04, 0.01, first_id=5)
SCALE = 2000.0
CAMERA = Camera(400, 300, 400.0, 401.0, 199.0, 151.0)


@pytest.fixture
def printed() -> tuple[np.ndarray, np.ndarray]:
    """The drawn grid, softened, and where its corners lie in it: ``(6, 4, 2)``."""
    image, origin = GRID.draw(SCALE)
    corners = np.array(origin) + SCALE * GRID.points_m[:, :2] * (1.0, -1.0)
    return cv2.GaussianBlur(image, (0, 0), 0.8), corners.reshape(-1, 4, 2)


def run_json(capsys, *arguments: object) -> tuple[int, dict, str]:
    status = main(["detect", *map(str, arguments), "--family", "tag36h11", "--json"])
    out, err = capsys.readouterr()
    return status, json.loads(out), err


def test_grey_colour_and_sixteen_bits_give_the_same(printed, tmp_path: Path, capsys) -> None:
    image, corners = printed
    dark = np.clip(image.astype(float) * 16.0, 0, 4095).astype(np.uint16)  # 12 bits used
    kinds = {
        "grey.png": image,
        "colour.png": np.dstack([image] * 3),
        "alpha.png": np.dstack([image] * 3 + [np.full_like(image, 255)]),
        "deep.png": dark,
        "deep_colour.png": np.dstack([dark] * 3),
        "grey.pgm": image,
        "colour.bmp": np.dstack([image] * 3),
    }
    for name, pixels in kinds.items():
        cv2.imwrite(str(tmp_path / name), pixels)
    status, found, _ = run_json(capsys, *(tmp_path / name for name in kinds))
    assert status == 0
    assert [Path(one["file"]).name for one in found["images"]] == list(kinds)
    for one in found["images"]:
        assert (one["width_px"], one["height_px"]) == image.shape[::-1]
        assert [row["id"] for row in one["markers"]] == [5, 6, 7, 8, 9, 10]
        seen = np.array([row["corners_px"] for row in one["markers"]])
        np.testing.assert_allclose(seen, corners, atol=0.05)
        assert all(row["sharp"] and row["wrong_cells"] == 0 for row in one["markers"])
        assert "candidates" not in one["markers"][0]


def test_bad_images_are_told_and_the_others_done(printed, tmp_path: Path, capsys) -> None:
    image, _ = printed
    cv2.imwrite(str(tmp_path / "good.png"), image)
    whole = (tmp_path / "good.png").read_bytes()
    (tmp_path / "half.png").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "words.png").write_text("no image")
    names = ["half.png", "missing.png", "good.png", "words.png"]
    status, found, err = run_json(capsys, *(tmp_path / name for name in names))
    assert status == 1
    assert [len(one.get("markers", [])) for one in found["images"]] == [0, 0, 6, 0]
    lines = err.strip().splitlines()
    assert len(lines) == 4
    for line, told in zip(lines, ("half.png", "missing.png", "words.png", "3 of 4"), strict=True):
        assert told in line
    assert "truncated" in found["images"][0]["error"]


def test_poses_come_with_a_camera_and_a_size(tmp_path: Path, capsys) -> None:
    board = SingleMarker("tag36h11", 7, 0.065)
    turn = Rotor.from_rotation_vector([0.0, 0.6, 0.0]) @ Rotor.from_rotation_vector([np.pi, 0, 0])
    camera_T_marker = Motor.from_rotor_translation(turn, [-0.03, -0.02, 0.3])
    image, origin = board.draw(4000.0)
    corners = CAMERA.project(camera_T_marker.apply(board.points_m)).astype(np.float32)
    plane = (np.array(origin) + 4000.0 * board.points_m[:, :2] * (1.0, -1.0)).astype(np.float32)
    warp = cv2.getPerspectiveTransform(plane, corners)
    seen = cv2.warpPerspective(image, warp, (400, 300), flags=cv2.INTER_AREA, borderValue=255)
    cv2.imwrite(str(tmp_path / "tag.png"), cv2.GaussianBlur(seen, (0, 0), 0.8))
    (tmp_path / "camera.toml").write_text(camera_toml(CAMERA))
    status, found, _ = run_json(
        capsys,
        tmp_path / "tag.png",
        "--size-m",
        0.065,
        "--camera",
        tmp_path / "camera.toml",
        "--draw",
        tmp_path / "drawn",
    )
    assert status == 0
    (row,) = found["images"][0]["markers"]
    first, second = row["candidates"]
    assert first["reprojection_rmse_px"] < second["reprojection_rmse_px"]
    ratio = first["reprojection_rmse_px"] / second["reprojection_rmse_px"]
    assert row["ambiguity"] == pytest.approx(ratio)
    place = first["camera_T_marker"]["translation_m"]
    np.testing.assert_allclose(place, camera_T_marker.translation_m, atol=1e-3)
    assert abs(np.dot(first["camera_T_marker"]["rotation_wxyz"], turn.as_quaternion())) > 0.9998
    drawn = cv2.imread(str(tmp_path / "drawn" / "tag.png"))
    first_corner = np.rint(row["corners_px"][0]).astype(int)
    column, row_ = first_corner
    near = drawn[row_ - 3 : row_ + 4, column - 3 : column + 4].astype(int)
    assert ((near[..., 2] > 150) & (near[..., :2].max(axis=-1) < 60)).any()


def test_the_table_for_people(printed, tmp_path: Path, capsys) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), printed[0])
    cv2.imwrite(str(tmp_path / "b.png"), np.full((50, 60), 90, np.uint8))
    both = [str(tmp_path / "a.png"), str(tmp_path / "b.png")]
    assert main(["detect", *both, "--family", "tag36h11"]) == 0
    out = capsys.readouterr().out
    assert "a.png: 6 markers" in out
    assert "b.png: 0 markers" in out
    assert "id   10" in out


def test_what_cannot_be_is_told_in_one_line(printed, tmp_path: Path, capsys) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), printed[0])
    (tmp_path / "camera.toml").write_text(camera_toml(CAMERA))
    image, camera = str(tmp_path / "a.png"), str(tmp_path / "camera.toml")
    for extra, told in (
        (["--family", "qr"], "family: expected one of"),
        (["--family", "tag36h11", "--size-m", "0.1"], "--size-m: expected --camera FILE with it"),
        (["--family", "tag36h11", "--camera", camera], "expected 400 x 300 pixels"),
        (["--family", "tag36h11", "--camera", str(tmp_path / "no.toml")], "no.toml"),
        (["--family", "tag36h11", "--camera", camera, "--size-m", "-1"], "size_m: expected metres"),
    ):
        assert main(["detect", image, *extra]) == 1
        assert told in capsys.readouterr().err
    with pytest.raises(SystemExit) as stopped:
        main(["detect", image])
    assert stopped.value.code == 2


def test_drawings_keep_apart_and_images_stay_as_they_were(printed, tmp_path: Path) -> None:
    names = drawing_names([Path("x/a.png"), Path("y/a.jpg"), Path("b.png"), Path("z/a.png")])
    assert names == ["a.png", "a_2.png", "b.png", "a_3.png"]
    cv2.imwrite(str(tmp_path / "a.png"), printed[0])
    (found,) = markers_in([tmp_path / "a.png"], "tag36h11")
    before = found.gray.copy()
    assert draw(found).shape == (*before.shape, 3)
    np.testing.assert_array_equal(found.gray, before)


@pytest.mark.parametrize(
    "camera",
    [
        CAMERA,
        Camera(752, 480, 420.5, 419.25, 359.1, 237.7, "radtan", (-0.29, 0.09, 1e-5, -2e-17)),
        Camera(752, 480, 1 / 3, 419.25, -3.0, 237.7, "equidistant", (0.1, -0.2, 0.3, 0.4)),
    ],
)
def test_cameras_are_read_back_as_they_were_written(camera: Camera, tmp_path: Path) -> None:
    (tmp_path / "camera.toml").write_text(camera_toml(camera))
    assert read_camera(tmp_path / "camera.toml") == camera
