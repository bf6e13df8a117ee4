"""Values of the room read back what was written, and refuse by field what they cannot hold."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import Camera, PoseMeasurements, SingleMarker
from motorcade.tracking.boards.names import BOARD_NAMES, board_named
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.slam.mapping.map import MapSnapshot

CAMERA = Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
CORNERS = np.array([[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]])


@pytest.mark.parametrize(
    "name", [*(name.partition(" ")[0] for name in BOARD_NAMES), "tag36h11_6x4_30mm_gap_9mm_from_24"]
)
def test_a_board_of_a_name_has_that_name(name: str) -> None:
    assert board_named(name).name == name


def test_names_are_read_in_millimetres() -> None:
    single = board_named("tag36h11_id_7_65.5mm")
    assert isinstance(single, SingleMarker)
    assert (single.marker_id, single.side_m) == (7, 0.0655)
    assert board_named("tag36h11_6x4_30mm_gap_9mm").name.endswith("_from_0")
    for wrong in ("checkerboard_9x6", "tag36h11_id_7_65cm", "Checkerboard_9x6_40mm", ""):
        with pytest.raises(ValueError, match=r"board: expected a name such as .*, got"):
            board_named(wrong)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("calib.io_checker_200x150_8x11_15.pdf", "checkerboard_10x7_15mm"),
        ("calib.io_charuco_297x210_5x7_35_26_DICT_4X4", "charuco_aruco_4x4_50_7x5_35mm_26mm"),
        ("calib.io_CHARUCO_800x600_14x20_40_30_DICT_5X5", "charuco_aruco_5x5_250_20x14_40mm_30mm"),
        ("calib.io_circles_200x150_8x10_18_8.33.pdf", "circles_10x8_18mm_8.33mm"),
        ("aprilgrid_6x6_88mm_gap_26.4mm_from_0", "aprilgrid_6x6_88mm_gap_26.4mm"),
    ],
)
def test_names_of_generators_are_names_of_boards(name: str, meant: str) -> None:
    """Of calib.io: rows by columns of squares, as its files are called."""
    assert board_named(name).name == meant


@pytest.mark.parametrize("name", ["calib.io_charuco_200x150_8x11_15", "calib.io_checker_2x1_8x11"])
def test_names_of_files_that_lack_a_number_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="board: expected a name"):
        board_named(name)


def test_depth_is_undistorted_as_images_are() -> None:
    """Of an image whose depths are its own columns: each pixel shows the column it came from."""
    bent = replace(CAMERA, model="radtan", distortion=(-0.2, 0.05, 0.0, 0.0))
    depth = np.tile(np.arange(64, dtype=np.float32), (48, 1))
    np.testing.assert_array_equal(CAMERA.undistort_depth(depth), depth)
    straight = bent.undistort_depth(depth)
    rows, columns = np.nonzero(np.isfinite(straight))
    assert len(rows) > 0.8 * depth.size
    source = bent.distort(np.stack([columns, rows], axis=-1).astype(np.float64))
    assert np.max(np.abs(straight[rows, columns] - source[:, 0])) <= 0.51
    wide = replace(bent, distortion=(0.5, 0.0, 0.0, 0.0))
    assert np.isnan(wide.undistort_depth(depth)[0, 0])  # nothing was seen so far out
    with pytest.raises(ValueError, match=r"depth_m: expected shape \(48, 64\), got \(48, 63\)"):
        bent.undistort_depth(depth[:, :63])


def stream(**changes: Any) -> CornerStream:
    given = {
        "camera": CAMERA,
        "time_ns": np.array([10, 20]),
        "frame": np.array([0, 0, 1]),
        "marker_ids": np.array([3, 5, 3]),
        "corners_px": np.stack([CORNERS] * 3),
    }
    return CornerStream(**(given | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"time_ns": np.array([10.0, 20.0])},
            r"time_ns: expected \(F,\) whole nanoseconds, got",
        ),
        ({"time_ns": np.array([20, 20])}, "time_ns: expected strictly increasing stamps"),
        ({"frame": np.array([0, 1, 0])}, "frame: expected rows of 0 to 1 that never fall"),
        ({"frame": np.array([0, 0, 2])}, "frame: expected rows of 0 to 1 that never fall"),
        ({"frame": np.array([-1, 0, 1])}, "frame: expected rows of 0 to 1 that never fall"),
        ({"marker_ids": np.array([3, 5])}, r"marker_ids: expected \(3,\), got \(2,\)"),
        ({"marker_ids": np.array([3, 3, 3])}, "marker_ids: expected each id once in a frame"),
        ({"corners_px": CORNERS[None]}, r"corners_px: expected \(3, 4, 2\), got \(1, 4, 2\)"),
        ({"corners_px": np.full((3, 4, 2), np.inf)}, "corners_px: expected finite numbers"),
    ],
)
def test_streams_of_corners_refuse(changes: dict[str, Any], message: str) -> None:
    assert len(stream()) == 3
    with pytest.raises(ValueError, match=f"CornerStream.{message}"):
        stream(**changes)


def marker_map(**changes: Any) -> MarkerMap:
    given = {
        "marker_ids": np.array([2, 7]),
        "side_m": np.array([0.1, 0.2]),
        "world_R_marker": Rotor.identity((2,)),
        "origin_m": np.zeros((2, 3)),
    }
    return MarkerMap(**(given | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"marker_ids": np.array([7, 2])}, "marker_ids: expected .* whole numbers that rise"),
        ({"marker_ids": np.array([2, 2])}, "marker_ids: expected .* whole numbers that rise"),
        ({"marker_ids": np.array([2.0, 7.0])}, "marker_ids: expected .* whole numbers that rise"),
        ({"side_m": np.array([0.1])}, r"origin_m: expected 2 of each, got \(\(1,\), \(2,\)"),
        ({"origin_m": np.zeros((3, 3))}, r"origin_m: expected 2 of each, got"),
        ({"side_m": np.array([0.1, 0.0])}, "side_m: expected metres above 0, got 0.0"),
        ({"origin_m": np.full((2, 3), np.nan)}, "origin_m: expected finite numbers"),
    ],
)
def test_maps_of_markers_refuse(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"MarkerMap.*{message}"):
        marker_map(**changes)


def test_files_of_other_content_are_no_marker_maps(tmp_path: Path) -> None:
    file = tmp_path / "map.json"
    marker_map().save(file)
    good = json.loads(file.read_text())
    one = good["markers"][0]
    for content, message in [
        ([], "expected the format"),
        (good | {"format": "motorcade marker map 0"}, "expected the format"),
        (good | {"units": {"side_m": "feet"}}, "expected the units .*, got .*feet"),
        (good | {"markers": {}}, "expected a list of at most 100000 markers"),
        (good | {"markers": [one | {"id": True}]}, "expected ids that are whole numbers"),
        (good | {"markers": [one | {"id": 1.5}]}, "expected ids that are whole numbers"),
        (good | {"markers": [one | {"side_m": [1.0, 2.0]}]}, "expected one number of side_m"),
        (good | {"markers": [{"id": 1}]}, "side_m"),
    ]:
        file.write_text(json.dumps(content))
        with pytest.raises(ValueError, match=rf"^{file}: not a marker map: .*{message}"):
            MarkerMap.load(file)
    file.write_bytes(b" " * (2**24 + 1))
    with pytest.raises(ValueError, match=f"^{file}: expected at most 16777216 bytes"):
        MarkerMap.load(file)


def snapshot(**changes: Any) -> MapSnapshot:
    given = {
        "time_ns": np.array([0, 5]), "world_T_camera": Motor.identity((2,)),
        "points": np.zeros((3, 3)), "descriptors": np.zeros((3, 32), np.uint8),
        "keyframe_of": np.array([0, 1]), "point_of": np.array([2, 0]), "px": np.zeros((2, 2)),
        "depth": np.ones(2), "metric": True,
    }  # fmt: skip
    return MapSnapshot(**(given | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points": np.zeros((3, 2))}, r"points: expected shape \(3, 3\), got \(3, 2\)"),
        ({"px": np.zeros((3, 2))}, r"px: expected shape \(2, 2\), got \(3, 2\)"),
        ({"world_T_camera": Motor.identity((3,))}, r"world_T_camera: expected \(2,\), got \(3,\)"),
        ({"keyframe_of": np.array([0, 2])}, "keyframe_of: expected rows below 2, got others"),
        ({"point_of": np.array([-1, 0])}, "point_of: expected rows below 3, got others"),
    ],
)
def test_snapshots_refuse(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"MapSnapshot.{message}"):
        snapshot(**changes)


def test_a_snapshot_is_read_back_and_other_files_are_none(tmp_path: Path) -> None:
    file = tmp_path / "map.npz"
    snapshot().save(file)
    back = MapSnapshot.load(file)
    np.testing.assert_array_equal(back.point_of, [2, 0])
    assert back.metric is True
    with pytest.raises(ValueError, match=r"expected a name ending in \.npz, got .*map\.txt"):
        snapshot().save(tmp_path / "map.txt")
    np.savez(file, format=np.array("motorcade map 0"))
    with pytest.raises(ValueError, match="expected the format"):
        MapSnapshot.load(file)


def test_measurements_refuse_what_is_no_covariance() -> None:
    path = Trajectory(np.array([1, 2]), Motor.identity((2,)))
    eye = np.tile(np.eye(6), (2, 1, 1))
    skew = eye.copy()
    skew[1, 0, 3] = 0.1
    for wrong, message in [
        (eye[:1], r"expected \(2, 6, 6\), got \(1, 6, 6\)"),
        (skew, "expected symmetric matrices"),
        (eye * np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.0]), "expected positive definite matrices"),
        (eye * np.nan, "expected finite numbers"),
    ]:
        with pytest.raises(ValueError, match=f"PoseMeasurements.covariance: {message}"):
            PoseMeasurements(path, wrong)
