"""Detection against exact renderings: places, numbering, occlusion; and refusals."""

import cv2
import numpy as np
import pytest

from motorcade.tracking import (
    FAMILIES,
    Board,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    SingleMarker,
    detect_markers,
)
from motorcade.tracking.boards import CircleGrid
from motorcade.tracking.boards.corners import BoardCorners

CHECKERS = Checkerboard(9, 6, 0.03)
GRID = MarkerGrid("tag36h11", 4, 3, 0.05, 0.015)
BOARDS: list[tuple[Board, float]] = [  # and how far a corner may be off, RMS in pixels
    (CHECKERS, 0.06),
    (GRID, 0.06),
    (MarkerGrid("aruco_4x4_50", 5, 3, 0.04, 0.01, first_id=7), 0.06),
    (SingleMarker("tag36h11", 5, 0.12), 0.06),
    (CharucoBoard("aruco_5x5_100", 7, 5, 0.04, 0.028), 0.1),
    (CircleGrid(4, 7, 0.03, 0.02, asymmetric=True), 0.06),
]
every_board = pytest.mark.parametrize(
    ("board", "tolerance_px"), BOARDS, ids=[board.name for board, _ in BOARDS]
)


def true_corners(board: Board, camera: Camera, pose) -> np.ndarray:
    return camera.project(pose.inverse().apply(board.points_m))


@pytest.mark.quick_every(3)
@every_board
@pytest.mark.parametrize("lens", ["straight_camera", "wide_camera"])
def test_corners_lie_where_they_are(
    board: Board, tolerance_px: float, lens: str, request, render, look_at
) -> None:
    camera = request.getfixturevalue(lens)
    errors = []
    for tilt_deg, azimuth_deg, roll_deg in ((8, 20, 0), (35, 200, 70), (30, 100, 185)):
        pose = look_at(board, 0.0012 * camera.fx, tilt_deg, azimuth_deg, roll_deg)
        image = render(board, camera, pose, blur_px=0.8, noise=2.0, seed=roll_deg)
        found = board.detect(image, camera)
        assert found is not None
        assert len(found) >= 0.6 * len(board.points_m)
        np.testing.assert_array_equal(found.points_m, board.points_m[found.ids])
        errors.append(found.corners_px - true_corners(board, camera, pose)[found.ids])
    error = np.concatenate(errors)
    assert np.sqrt((error**2).sum(axis=1).mean()) < tolerance_px
    assert np.abs(error.mean(axis=0)).max() < 0.02


@pytest.mark.parametrize("board", [CircleGrid(7, 6, 0.03, 0.018), CircleGrid(5, 5, 0.03, 0.012)])
def test_circles_that_look_the_same_turned_are_numbered_one_of_the_ways(
    board: CircleGrid, wide_camera, render, look_at
) -> None:
    for tilt_deg, azimuth_deg, roll_deg in ((8, 20, 0), (35, 200, 70), (30, 100, 185)):
        pose = look_at(board, 0.0012 * wide_camera.fx, tilt_deg, azimuth_deg, roll_deg)
        found = board.detect(render(board, wide_camera, pose, noise=2.0), wide_camera)
        assert found is not None
        seen = board.aligned(found, true_corners(board, wide_camera, pose))
        error = seen.corners_px - true_corners(board, wide_camera, pose)[seen.ids]
        assert np.sqrt((error**2).sum(axis=1).mean()) < 0.06


@every_board
def test_the_first_corner_is_the_printed_top_left_one(
    board: Board, tolerance_px: float, straight_camera, render, look_at
) -> None:
    image = render(board, straight_camera, look_at(board, 0.5))
    found = board.detect(image)
    first, last = found.corners_px[0], found.corners_px.mean(axis=0)
    assert found.ids[0] == 0
    assert np.all(first < last)
    np.testing.assert_array_equal(board.points_m[0], 0.0)
    assert np.all(board.points_m[:, 1] <= 0.0)
    assert np.all(board.points_m[:, 2] == 0.0)


def test_marker_corners_run_clockwise(straight_camera, render, look_at) -> None:
    image = render(GRID, straight_camera, look_at(GRID, 0.5, roll_deg=100))
    found = detect_markers(image, "tag36h11")
    assert [one.marker_id for one in found] == list(range(12))
    quads = np.stack([one.corners_px for one in found])
    sides = np.roll(quads, -1, axis=1) - quads
    turns = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    assert np.all(turns > 0.0)


@pytest.mark.parametrize("roll_deg", [0, 90, 180, 270, 33])
def test_a_checkerboard_with_an_odd_sum_is_numbered_by_its_colours(
    roll_deg: int, straight_camera, render, look_at
) -> None:
    pose = look_at(CHECKERS, 0.5, 15.0, 40.0, roll_deg)
    found = CHECKERS.detect(render(CHECKERS, straight_camera, pose))
    expected = true_corners(CHECKERS, straight_camera, pose)
    assert np.abs(found.corners_px - expected[found.ids]).max() < 0.2


@pytest.mark.parametrize(("columns", "rows", "turns"), [(7, 5, 2), (5, 5, 2), (4, 4, 4)])
def test_a_symmetric_checkerboard_is_numbered_upright_or_as_expected(
    columns: int, rows: int, turns: int, straight_camera, render, look_at
) -> None:
    board = Checkerboard(columns, rows, 0.035)
    grid = np.arange(columns * rows).reshape(rows, columns)
    for roll_deg in (0, 20, 200):
        pose = look_at(board, 0.5, 15.0, 40.0, roll_deg)
        expected = true_corners(board, straight_camera, pose)
        found = board.detect(render(board, straight_camera, pose))
        across = found.corners_px[columns - 1] - found.corners_px[0]
        assert across[0] > abs(across[1]) - 1e-9
        right = board.aligned(found, expected)
        assert np.abs(right.corners_px - expected[right.ids]).max() < 0.2
        np.testing.assert_array_equal(right.points_m, board.points_m[right.ids])
        for turn in range(0, 4, 4 // turns):
            other = expected[np.rot90(grid, turn).ravel()]
            assert np.abs(board.aligned(found, other).corners_px - other).max() < 0.2


def test_parts_of_a_board_are_enough_where_corners_carry_numbers(
    straight_camera, render, look_at
) -> None:
    for board in (GRID, CharucoBoard("aruco_5x5_100", 7, 5, 0.04, 0.03)):
        pose = look_at(board, 0.45, 10.0)
        image = render(board, straight_camera, pose)
        image[:, :200] = 90
        found = board.detect(image, straight_camera)
        expected = true_corners(board, straight_camera, pose)[found.ids]
        assert 4 <= len(found) < len(board.points_m)
        assert found.corners_px[:, 0].min() > 199
        assert np.abs(found.corners_px - expected).max() < 0.25


@every_board
def test_nothing_is_found_in_an_empty_image(board: Board, tolerance_px: float) -> None:
    assert board.detect(np.full((240, 320), 128, np.uint8)) is None
    noise = np.random.default_rng(1).integers(0, 256, (240, 320), dtype=np.uint8)
    assert board.detect(noise) is None


def test_sharpening_leaves_out_covered_corners(straight_camera, render, look_at) -> None:
    for board in (CHECKERS, GRID):
        pose = look_at(board, 0.5)
        expected = true_corners(board, straight_camera, pose)
        image = render(board, straight_camera, pose)
        middle = np.rint(expected.mean(axis=0)).astype(int)
        cv2.circle(image, tuple(map(int, middle)), 30, 160, -1)
        given = BoardCorners(np.arange(len(expected)), expected + 0.6, board.points_m)
        sharp = board.refine_corners(image, given, straight_camera)
        covered = np.linalg.norm(expected - middle, axis=1) < 24
        assert covered.any()
        assert not np.isin(np.flatnonzero(covered), sharp.ids).any()
        assert len(sharp) >= 0.6 * len(expected)
        error = np.abs(sharp.corners_px - expected[sharp.ids]).max(axis=1)
        clear = np.linalg.norm(expected[sharp.ids] - middle, axis=1) > 44
        assert error[clear].max() < 0.15


@pytest.mark.parametrize("board", [CHECKERS, BOARDS[4][0]])
def test_of_what_is_half_hidden_no_corner_is_left_beside_its_place(
    board: Board, straight_camera, render, look_at
) -> None:
    pose, rng = look_at(board, 0.5, 10.0), np.random.default_rng(5)
    image = render(board, straight_camera, pose, noise=2.0, seed=1)
    truth = true_corners(board, straight_camera, pose)
    errors = []
    for x in np.linspace(truth[:, 0].min(), truth[:, 0].mean(), 25):
        covered = image.copy()
        cv2.ellipse(covered, (int(x + 160), 240), (160, 250), 20, 0, 360, 150, -1)
        seen = cv2.add(covered, np.rint(rng.normal(2.0, 1.0, image.shape)).astype(np.uint8))
        tried = BoardCorners(np.arange(len(truth)), truth + 0.3, board.points_m)
        sharp = board.refine_corners(seen, tried)
        errors.append(sharp.corners_px - truth[sharp.ids])
    apart = np.linalg.norm(np.concatenate(errors), axis=-1)
    assert len(apart) > 100
    assert apart.max() < 1.0


def test_corners_on_one_spot_are_left_out_of_a_sharpening() -> None:
    image = np.full((100, 100), 90, np.uint8)
    spot = BoardCorners(np.arange(54), np.full((54, 2), 50.0), CHECKERS.points_m)
    assert len(CHECKERS.refine_corners(image, spot)) == 0


def test_the_image_and_the_corners_given_stay_as_they_were(
    straight_camera, render, look_at
) -> None:
    image = render(GRID, straight_camera, look_at(GRID, 0.5))
    copy = image.copy()
    found = GRID.detect(image, straight_camera)
    with pytest.raises(ValueError, match="read-only"):
        found.corners_px[0] = 0.0
    before = found.corners_px.copy()
    GRID.refine_corners(image, found, straight_camera)
    np.testing.assert_array_equal(image, copy)
    np.testing.assert_array_equal(found.corners_px, before)


def test_sharper_than_the_librarys_own_marker_corners(straight_camera, render, look_at) -> None:
    pose = look_at(GRID, 0.5, 25.0, 30.0, 20.0)
    image = render(GRID, straight_camera, pose, noise=2.0)
    expected = true_corners(GRID, straight_camera, pose)
    ours = GRID.detect(image, straight_camera)
    error = np.linalg.norm(ours.corners_px - expected[ours.ids], axis=1)
    start = ours.corners_px.astype(np.float32).reshape(-1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
    theirs = cv2.cornerSubPix(image, start.copy(), (3, 3), (-1, -1), stop).reshape(-1, 2)
    their_error = np.linalg.norm(theirs - expected[ours.ids], axis=1)
    assert np.sqrt((error**2).mean()) < 0.4 * np.sqrt((their_error**2).mean())


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Checkerboard(2, 6, 0.03), r"Checkerboard\.columns: .* at least 3, got 2"),
        (lambda: Checkerboard(9, 6.0, 0.03), r"Checkerboard\.rows: expected a whole number"),
        (lambda: Checkerboard(9, 6, -0.03), r"Checkerboard\.square_m: expected metres above 0"),
        (lambda: Checkerboard(9, 6, float("nan")), r"square_m"),
        (lambda: MarkerGrid("tag99h1", 4, 3, 0.05, 0.01), r"family: expected one of tag16h5"),
        (lambda: MarkerGrid("tag16h5", 6, 6, 0.05, 0.01), r"has ids 0 to 29, .* up to 35"),
        (lambda: MarkerGrid("tag16h5", 0, 6, 0.05, 0.01), r"MarkerGrid\.columns"),
        (lambda: MarkerGrid("tag16h5", 2, 2, 0.05, 0.0), r"MarkerGrid\.gap_m"),
        (lambda: MarkerGrid("tag16h5", 2, 2, 0.05, 0.01, -1), r"MarkerGrid\.first_id"),
        (lambda: SingleMarker("tag36h11", 587, 0.1), r"tag36h11 expects 0 to 586, got 587"),
        (lambda: SingleMarker("tag36h11", 5, 0.0), r"SingleMarker\.side_m"),
        (lambda: CharucoBoard("aruco_4x4_50", 7, 5, 0.03, 0.03), r"less than square_m = 0.03"),
        (lambda: CharucoBoard("aruco_4x4_50", 20, 9, 0.03, 0.02), r"has 50 markers, .* needs 90"),
        (lambda: CharucoBoard("aruco_4x4_50", 2, 9, 0.03, 0.02), r"CharucoBoard\.columns"),
        (lambda: detect_markers(np.zeros((9, 9), np.uint8), "qr"), r"family: .* got 'qr'"),
    ],
)
def test_boards_that_cannot_be_are_refused(make, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        make()


@every_board
@pytest.mark.parametrize(
    "image",
    [np.zeros((40, 40, 3), np.uint8), np.zeros((40, 40)), np.zeros((0, 40), np.uint8), "photo.png"],
)
def test_images_that_are_not_grey_are_refused(
    board: Board, tolerance_px: float, image: object
) -> None:
    with pytest.raises(ValueError, match="image: expected a grey uint8 image"):
        board.detect(image)


@pytest.mark.parametrize(
    ("ids", "corners", "told"),
    [
        ([1, 1], np.zeros((2, 2)), "rising"),
        ([0.5, 1.0], np.zeros((2, 2)), "whole numbers"),
        ([0, 1], np.zeros((3, 2)), r"corners_px: expected \(2, 2\), got \(3, 2\)"),
        ([0, 1], np.full((2, 2), np.nan), "finite"),
    ],
)
def test_corners_that_do_not_fit_are_refused(ids, corners, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        BoardCorners(np.array(ids), corners, np.zeros((2, 3)))


def test_names_tell_boards_apart() -> None:
    names = [board.name for board, _ in BOARDS]
    assert len(set(names)) == len(names)
    assert "tag36h11" in FAMILIES


def test_tags_of_the_recorded_rotations_are_found(data_dir) -> None:
    """OpenCV's detector finds 14 of the 15 (all but the one at 70 degrees)."""
    folder = data_dir / "tags" / "rotations"
    camera = Camera(1056, 792, 329.87297, 332.94611, 528.0, 396.0)
    tag = SingleMarker("tag36h11", 76, 0.065)
    images = sorted(folder.glob("*.png"))
    seen = [tag.detect(cv2.imread(str(image), cv2.IMREAD_GRAYSCALE), camera) for image in images]
    assert len(images) == 15
    assert sum(one is not None for one in seen) >= 14


@pytest.mark.parametrize(
    ("board", "blur_px"),
    [
        (Checkerboard(7, 5, 0.03), 7.5),
        (CharucoBoard("aruco_5x5_50", 7, 5, 0.03, 0.015), 2.5),
        (SingleMarker("tag36h11", 7, 0.1), 3.0),
    ],
)
def test_corners_stay_where_they_are_as_blur_grows(board: Board, blur_px: float) -> None:
    """Blur of a quarter of a square, and of a quarter of a marker's border."""
    drawn, origin = board.draw(pixels_per_m=1000.0)
    turned = np.array([[0.98, 0.15, 30.0], [-0.15, 0.98, 50.0]])
    sharp = cv2.warpAffine(drawn, turned, (400, 300), borderValue=150.0)
    true_px = board.points_m[:, :2] * [1000.0, -1000.0] + origin
    true_px = true_px @ turned[:, :2].T + turned[:, 2]
    start_px = true_px + np.random.default_rng(2).uniform(-1.5, 1.5, true_px.shape)
    start = BoardCorners(np.arange(len(true_px)), start_px, board.points_m)
    refined = board.refine_corners(cv2.GaussianBlur(sharp, (0, 0), blur_px), start)
    assert len(refined) == len(true_px)
    assert np.linalg.norm(refined.corners_px - true_px, axis=-1).max() < 0.1
