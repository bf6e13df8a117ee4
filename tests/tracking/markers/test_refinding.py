"""Markers of a known map that the search misses are found where the map says, and only there."""

import numpy as np
import pytest

from motorcade.tracking import Camera, Detection, MarkerMap, detect_markers
from motorcade.tracking.markers.refinding import refind_markers
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers

CAMERA = Camera(480, 360, 420.0, 418.0, 242.3, 176.8)
FAMILY, SIDE_M = "tag36h11", 0.08
IDS = np.arange(20)


@pytest.fixture(scope="module")
def wall() -> tuple[np.ndarray, np.ndarray, MarkerMap]:
    """An image, where all corners truly are, and the map."""
    rng = np.random.default_rng(4)
    world_T_marker = wall_of_markers(5, 4, 0.14, 20.0, rng)
    scene = TagScene(CAMERA, FAMILY, IDS, SIDE_M, world_T_marker)
    world_T_camera = handheld_path(1, 0.8)[0]
    known = MarkerMap(IDS, np.full(20, SIDE_M), world_T_marker.rotor, world_T_marker.translation_m)
    return scene.image(world_T_camera, rng), scene.corners_px(world_T_camera), known


def hidden_loops(image: np.ndarray, corners_px: np.ndarray) -> np.ndarray:
    """White bars across the left sides, which open the loops but leave four sides to be fitted."""
    made = image.copy()
    for first, last in zip(corners_px[:, 0], corners_px[:, 3], strict=True):
        x, y = np.rint(0.5 * (first + last)).astype(int)
        made[y - 1 : y + 2, x - 4 : x + 5] = 190
    return made


def test_markers_that_are_missed_are_found_again(wall) -> None:
    image, truth, known = wall
    whole = detect_markers(image, FAMILY, CAMERA)
    assert len(whole) == 20
    few = tuple(one for one in whole if one.marker_id in (3, 7, 12))
    again = refind_markers(image, FAMILY, CAMERA, known, few)
    assert [one.marker_id for one in again] == IDS.tolist()
    for one in again:
        assert np.abs(one.corners_px - truth[one.marker_id]).max() < 0.4
        assert one.sharp


def test_more_than_the_search_finds_where_loops_are_open(wall) -> None:
    image, truth, known = wall
    barred = hidden_loops(image, truth[4:])
    found = detect_markers(barred, FAMILY, CAMERA)
    again = refind_markers(barred, FAMILY, CAMERA, known, found)
    assert 4 <= len(found) < 20
    assert len(again) >= len(found) + 4
    for one in again:
        assert np.linalg.norm(one.corners_px - truth[one.marker_id], axis=-1).max() < 1.5


def test_no_marker_is_found_where_none_is(wall) -> None:
    image, truth, known = wall
    bare = image.copy()
    for quad in truth[10:]:
        low, high = np.floor(quad.min(axis=0)).astype(int), np.ceil(quad.max(axis=0)).astype(int)
        bare[low[1] - 3 : high[1] + 4, low[0] - 3 : high[0] + 4] = 120
    found = detect_markers(bare, FAMILY, CAMERA)
    again = refind_markers(bare, FAMILY, CAMERA, known, found)
    assert max(one.marker_id for one in again) < 10


def test_a_map_of_another_wall_adds_nothing(wall) -> None:
    image, _, known = wall
    found = detect_markers(image, FAMILY, CAMERA)[:6]
    other = MarkerMap(IDS, known.side_m, known.world_R_marker, known.origin_m[::-1])
    assert refind_markers(image, FAMILY, CAMERA, other, found) == found
    assert refind_markers(image, FAMILY, CAMERA, known, found[:1]) == found[:1]
    assert refind_markers(image, FAMILY, CAMERA, known, ()) == ()


def test_another_print_in_a_markers_place_is_not_taken_for_it(wall) -> None:
    image, _, known = wall
    found = detect_markers(image, FAMILY, CAMERA)
    few: tuple[Detection, ...] = tuple(one for one in found if one.marker_id < 10)
    renamed = MarkerMap(
        np.concatenate([IDS[:10], IDS[10:] + 100]),
        known.side_m,
        known.world_R_marker,
        known.origin_m,
    )
    assert refind_markers(image, FAMILY, CAMERA, renamed, few) == few
