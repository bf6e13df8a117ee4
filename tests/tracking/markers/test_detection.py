"""Marker detection: on photographs reviewed by eye, on exact renderings, and on no markers at all.

`reviewed.json` lists, for each image, markers that a person can make out whole: id, then column
and row of the centre. Every one of the cubes in the photograph carries tag 0, on its top too.
"""

import gc
import json
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.tracking import Camera, MarkerGrid, SingleMarker
from motorcade.tracking.markers import FAMILIES, detect_markers
from motorcade.tracking.markers.detection import read_markers
from motorcade.tracking.markers.families import (
    OPENCV_FAMILIES,
    dictionary,
    marker_cells,
)
from motorcade.tracking.markers.native._quads import find_quads
from tests.bench.tracking.tag_markers import apriltag_detector

REVIEWED: dict[str, list[list[int]]] = json.loads(
    (Path(__file__).parent / "reviewed.json").read_text()
)
SAME_PX = 8.0
GRID = MarkerGrid("tag36h11", 4, 3, 0.05, 0.015)


def load(path: Path) -> np.ndarray:
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert image is not None, path
    return image


def matched(found: list[tuple[int, np.ndarray]], truth: list[list[int]]) -> tuple[int, int]:
    """How many detections are right, each true marker counting once, and how many are not."""
    free, right = [list(one) for one in truth], 0
    for marker, centre in found:
        for one in free:
            if one[0] == marker and np.hypot(*(centre - one[1:])) < SAME_PX:
                free.remove(one)
                right += 1
                break
    return right, len(found) - right


@pytest.mark.parametrize("name", REVIEWED)
def test_all_that_apriltag_or_opencv_find_and_none_that_is_false(name: str, data_dir: Path) -> None:
    image = load(data_dir / "tags" / name)
    ours = [
        (one.marker_id, one.corners_px.mean(axis=0)) for one in detect_markers(image, "tag36h11")
    ]
    peers = [(one.tag_id, one.center - 0.5) for one in apriltag_detector("tag36h11").detect(image)]
    quads, ids, _ = cv2.aruco.ArucoDetector(dictionary("tag36h11")).detectMarkers(image)
    peers += [(int(i), quad[0].mean(axis=0)) for i, quad in zip(ids.ravel(), quads, strict=True)]
    theirs = [one for one in REVIEWED[name] if matched(peers, [one])[0]]
    right, false = matched(ours, REVIEWED[name])
    assert len(theirs) > 0
    assert matched(ours, theirs)[0] == len(theirs)
    assert right >= len(theirs)
    assert false == 0


def test_the_photographs_reference_corners(data_dir: Path) -> None:
    """The reference runs the other way round, from another corner, and is right to a pixel."""
    lines = (data_dir / "tags/photos/33369213973_9d9bb4cc96_c.txt").read_text().splitlines()
    numbers = [line.replace("(", " ").replace(")", " ").replace(",", " ").split() for line in lines]
    reference = np.array([row[1:] for row in numbers if row], float).reshape(-1, 4, 2)
    found = detect_markers(load(data_dir / "tags/photos/33369213973_9d9bb4cc96_c.jpg"), "tag36h11")
    corners = np.stack([one.corners_px for one in found])
    assert len(found) >= len(reference) == 12
    for one in reference:
        gaps = np.linalg.norm(corners[:, :, None] - one, axis=-1).min(axis=-1)
        assert gaps.max(axis=1).min() < 2.0


@pytest.mark.parametrize("yaw_deg", range(-70, 71, 10))
def test_every_rotation_image(yaw_deg: int, data_dir: Path) -> None:
    image = load(data_dir / f"tags/rotations/test_image_rotation_{yaw_deg}.png")
    (one,) = detect_markers(image, "tag36h11")
    assert one.marker_id == 76
    assert one.sharp
    assert one.wrong_cells == 0
    assert one.agreement > 0.95


@pytest.mark.quick_every(4)
@pytest.mark.parametrize("family", [f for f in FAMILIES if not f.endswith("_1000")])
def test_every_family_is_found_upright(family: str, render, look_at, straight_camera) -> None:
    for marker in (0, 13):
        board = SingleMarker(family, marker, 0.12)
        pose = look_at(board, 0.6, 20.0, 50.0, 100.0)
        image = render(board, straight_camera, pose, noise=2.0)
        truth = straight_camera.project(pose.inverse().apply(board.points_m))
        for backend in ("opencv", "loops") if family in OPENCV_FAMILIES else ("loops",):
            (one,) = detect_markers(image, family, straight_camera, backend=backend)
            assert (one.family, one.marker_id, one.sharp) == (family, marker, True)
            assert np.abs(one.corners_px - truth).max() < 0.15


def test_nearer_than_either_library_and_than_corner_refinement(render, look_at) -> None:
    camera = Camera(480, 360, 420.0, 418.0, 242.3, 176.8)
    ours, theirs, refined = [], [], []
    peer = apriltag_detector("tag36h11")
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
    for tilt, azimuth, roll in ((8, 20, 0), (35, 200, 70), (30, 100, 185)):
        pose = look_at(GRID, 0.5, tilt, azimuth, roll)
        image = render(GRID, camera, pose, blur_px=0.8, noise=2.0, seed=roll)
        truth = camera.project(pose.inverse().apply(GRID.points_m)).reshape(-1, 4, 2)
        for one in detect_markers(image, "tag36h11", camera):
            ours.append(one.corners_px - truth[one.marker_id])
        for one in peer.detect(image):
            corners = one.corners[::-1] - 0.5
            theirs.append(corners - truth[one.tag_id])
            start = corners.astype(np.float32).reshape(-1, 1, 2).copy()
            sharp = cv2.cornerSubPix(image, start, (3, 3), (-1, -1), stop).reshape(-1, 2)
            refined.append(sharp - truth[one.tag_id])
    assert len(ours) == len(theirs) == 36
    rms = [
        np.sqrt((np.concatenate(one) ** 2).sum(axis=1).mean()) for one in (ours, theirs, refined)
    ]
    assert rms[0] < 0.8 * rms[1]
    assert rms[0] < 0.4 * rms[2]


@pytest.mark.parametrize("family", ["tag16h5", "tag36h11", "aruco_4x4_50", "aruco_original"])
def test_texture_is_no_marker(family: str, rng: np.random.Generator) -> None:
    for blur_px in (0.6, 1.5, 3.0):
        noise = rng.integers(0, 256, (360, 480)).astype(np.uint8)
        texture = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), blur_px), None, 0, 255, 32)
        assert detect_markers(texture, family) == ()
        assert detect_markers(texture, family, backend="opencv") == ()


def test_real_images_without_markers_hold_none(data_dir: Path) -> None:
    folder = data_dir / "replays"
    files = sorted(folder.glob("kitti_short/**/*.png"))[::17]
    files += sorted(folder.glob("7scenes_redkitchen/**/*color*"))[::70]
    files += sorted(folder.glob("vamr_board/**/*.jpg"))[::120]
    assert len(files) >= 8
    for path in files:
        for family in ("tag16h5", "tag36h11", "aruco_4x4_50"):
            assert detect_markers(load(path), family) == ()


def test_a_wrong_print_is_seen_when_it_is_read_again(render, look_at, straight_camera) -> None:
    """AprilTag's decoder mends two wrong bits of 16 and so finds tags in other families' prints."""
    board = SingleMarker("tag16h5", 3, 0.12)
    pose = look_at(board, 0.5)
    image = render(board, straight_camera, pose)
    truth = straight_camera.project(pose.inverse().apply(board.points_m))[None]
    right = read_markers(image, truth, "tag16h5", np.array([3]))
    assert right.wrong_cells[0] == 0
    assert right.agreement[0] > 0.97
    known = marker_cells("tag16h5", 3)
    for other in (0, 7, 29):
        wrong = read_markers(image, truth, "tag16h5", np.array([other]))
        assert wrong.wrong_cells[0] == np.count_nonzero(known != marker_cells("tag16h5", other))
        assert wrong.agreement[0] < 0.75


def test_a_marker_printed_twice_is_found_twice_and_each_once(
    render, look_at, straight_camera
) -> None:
    board = SingleMarker("tag36h11", 4, 0.05)
    one = render(board, straight_camera, look_at(board, 0.5))
    both = np.hstack([one, one])
    for backend in ("loops", "opencv"):
        found = detect_markers(both, "tag36h11", backend=backend)
        assert [each.marker_id for each in found] == [4, 4]
        gap = found[1].corners_px - found[0].corners_px
        np.testing.assert_allclose(gap, np.tile([480.0, 0.0], (4, 1)), atol=0.02)


def test_at_the_rim_of_the_image_corners_are_not_sharp(render, look_at, straight_camera) -> None:
    board = SingleMarker("tag36h11", 4, 0.12)
    pose = look_at(board, 0.5)
    left = straight_camera.project(pose.inverse().apply(board.points_m))[:, 0].min()
    cut = int(left) - 3
    camera = replace(straight_camera, cx=straight_camera.cx + int(left) + 0.3 - left)
    truth = camera.project(pose.inverse().apply(board.points_m)) - np.array([cut, 0.0])
    image = np.ascontiguousarray(render(board, camera, pose)[:, cut:])
    (one,) = detect_markers(image, "tag36h11", backend="opencv")
    assert not one.sharp
    assert np.abs(one.corners_px - truth).max() < 2.0
    assert board.detect(image) is None


def test_what_creeps_over_a_side_leaves_no_sharp_corner_far_off(
    render, look_at, straight_camera
) -> None:
    board = SingleMarker("tag36h11", 4, 0.05)
    image = render(board, straight_camera, look_at(board, 0.9))
    truth = straight_camera.project(look_at(board, 0.9).inverse().apply(board.points_m))
    x, y = truth[1:3].mean(axis=0)
    sharp = []
    for reach in np.arange(-4.0, 8.0, 0.5):
        covered = cv2.circle(image.copy(), (round(x + 40 - reach), round(y + 12)), 40, 90, -1)
        found = detect_markers(covered, "tag36h11", straight_camera)
        sharp += [one.corners_px for one in found if one.sharp]
    assert len(sharp) > 5
    assert np.linalg.norm(sharp - truth, axis=-1).max() < 0.3


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_prints_without_noise_are_found(shift: float) -> None:
    """There errors on both sides of a corner are equal to the last bit."""
    image, _ = GRID.draw(1200.0)
    move = np.array([[1.0, 0.0, shift], [0.0, 1.0, shift]])
    moved = cv2.warpAffine(image, move, image.shape[::-1], borderValue=255)
    found = detect_markers(cv2.GaussianBlur(moved, (0, 0), 0.8), "tag36h11")
    assert [one.marker_id for one in found] == list(range(12))


def test_threads_do_not_share_a_detector(render, look_at, straight_camera) -> None:
    image = render(GRID, straight_camera, look_at(GRID, 0.5))
    expected = [one.corners_px.tolist() for one in detect_markers(image, "tag36h11")]
    results: list[object] = []

    def work() -> None:
        for _ in range(3):
            found = detect_markers(image, "tag36h11")
            results.append([one.corners_px.tolist() for one in found])

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    gc.collect()
    assert results == [expected] * 9


_THREADS_THAT_END = """
import gc, threading
import numpy as np
from motorcade.tracking.markers import detect_markers

def work():
    image = np.random.default_rng(0).integers(0, 256, (200, 200)).astype(np.uint8)
    for family in ("tag16h5", "tag36h11", "tagStandard41h12"):
        detect_markers(image, family)

for _ in range(5):
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    gc.collect()
    kept = [np.ones(size) for size in range(1, 200)]
"""


def test_threads_may_end_after_they_searched() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _THREADS_THAT_END], capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (2, 500), (5, 5), (6, 6), (7, 300)])
@pytest.mark.parametrize("backend", ["loops", "opencv"])
def test_tiny_images_hold_nothing(shape: tuple[int, int], backend, rng) -> None:
    image = rng.integers(0, 256, shape).astype(np.uint8)
    assert detect_markers(image, "tag36h11", backend=backend) == ()


def test_parts_of_larger_arrays_are_read_as_they_lie(render, look_at, straight_camera) -> None:
    image = render(GRID, straight_camera, look_at(GRID, 0.5))
    wide = np.zeros((image.shape[0], image.shape[1], 3), np.uint8)
    wide[..., 1] = image
    expected = [one.corners_px.tolist() for one in detect_markers(image, "tag36h11")]
    found = detect_markers(wide[..., 1], "tag36h11")
    assert [one.corners_px.tolist() for one in found] == expected


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda p: detect_markers(p, "qr"), "family: expected one of .* got 'qr'"),
        (lambda p: detect_markers(p, "qr", backend="loops"), "family: expected one of"),
        (
            lambda p: detect_markers(p, "tagCircle21h7", backend="opencv"),
            "family: OpenCV does not know tagCircle21h7; it knows tag16h5",
        ),
        (lambda p: detect_markers(p, "tag36h11", backend="zbar"), "backend: .* got 'zbar'"),
        (lambda p: detect_markers(p[None], "tag36h11"), "image: expected a grey uint8 image"),
    ],
)
def test_bad_input_is_refused(call, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        call(np.zeros((40, 40), np.uint8))


def test_equal_neighbours_on_both_sides_of_the_threshold_lose_no_quad() -> None:
    found = 0
    for turn_deg in np.linspace(2.0, 88.0, 40):
        square = np.full((80, 80), 200.0)
        square[24:56, 24:56] = 60.0
        turned = cv2.warpAffine(
            square, cv2.getRotationMatrix2D((40, 40), turn_deg, 1.0), (80, 80), borderValue=(200.0,)
        )
        coarse = np.round(cv2.GaussianBlur(turned, (0, 0), 1.5) / 16.0) * 16.0
        found += len(find_quads(coarse.clip(0, 255).astype(np.uint8), False, 8.0, 2)) > 0
    assert found >= 32


def test_photographs_of_other_tags_hold_none_of_few_bits(data_dir: Path) -> None:
    """Of 16 bits every thirtieth random square is a marker with a bit wrong, whichever it is."""
    files = sorted(data_dir.glob("tags/photos/*.jpg"))
    if not files:
        pytest.skip(f"no photographs below {data_dir}/tags; set MOTORCADE_DATA")
    images = [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in files]
    assert [found for image in images for found in detect_markers(image, "tag16h5")] == []
