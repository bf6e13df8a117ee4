"""Planes are found where they were made, in points, in drawn depth and in a real kitchen."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import Camera
from motorcade.tracking.planes import (
    Plane,
    find_planes,
    find_planes_in_depth,
)
from tests.textured_room.renderer import Renderer
from tests.textured_room.scenarios import SCENARIOS
from tests.textured_room.scene import furnished_room

SIGMA_M = 0.005
TRUE = (([0.0, 0.0, 1.0], 0.0), ([1.0, 0.0, 0.0], 0.0), ([0.0, -0.6, 0.8], 0.3))


def scene(rng: np.random.Generator, clutter: int = 1000) -> np.ndarray:
    """Three planes of 2000, 1500 and 700 points with noise, and clutter, in a box of 3 m."""
    clouds = []
    for (normal, distance), count in zip(TRUE, (2000, 1500, 700), strict=True):
        points = rng.uniform(0.2, 2.8, (count, 3))
        off = points @ normal - distance - SIGMA_M * rng.standard_normal(count)
        clouds.append(points - off[:, None] * np.array(normal))
    return np.concatenate([*clouds, rng.uniform(0.2, 2.8, (clutter, 3))])


def tilt_deg(plane: Plane, normal: np.ndarray | list[float]) -> float:
    return float(np.rad2deg(np.arccos(np.clip(plane.normal @ np.asarray(normal), -1.0, 1.0))))


def test_all_planes_are_found_where_they_are(rng: np.random.Generator) -> None:
    found = find_planes(scene(rng), SIGMA_M, rng, seen_from_m=[2.0, 1.0, 2.9])
    assert len(found.planes) == 3
    for which, (normal, distance) in enumerate(TRUE):
        plane = found.planes[which]
        assert tilt_deg(plane, normal) < 0.1
        assert plane.distance_m == pytest.approx(distance, abs=0.002)
        assert plane.support == np.count_nonzero(found.labels == which)
    begin = 0
    for which, count in enumerate((2000, 1500, 700)):
        assert np.mean(found.labels[begin : begin + count] == which) > 0.98
        begin += count
    assert np.mean(found.labels[begin:] >= 0) < 0.06


def test_the_same_state_finds_the_same_planes(rng: np.random.Generator) -> None:
    points = scene(rng)
    first, again = (find_planes(points, SIGMA_M, np.random.default_rng(7)) for _ in range(2))
    np.testing.assert_array_equal(first.labels, again.labels)
    for a, b in zip(first.planes, again.planes, strict=True):
        np.testing.assert_array_equal(a.world_T_plane.coefficients, b.world_T_plane.coefficients)


def test_found_planes_move_with_the_points(rng: np.random.Generator) -> None:
    points, motion = scene(rng, clutter=0), Motor.random(rng)
    still = find_planes(points, SIGMA_M, rng, seen_from_m=[2.0, 1.0, 2.9])
    eye = motion.apply([2.0, 1.0, 2.9])
    moved = find_planes(motion.apply(points), SIGMA_M, rng, seen_from_m=eye)
    for a, b in zip(still.planes, moved.planes, strict=True):
        assert tilt_deg(b, a.transformed_by(motion).normal) < 0.02
        assert b.distance_m == pytest.approx(a.transformed_by(motion).distance_m, abs=1e-3)


def test_a_small_plane_in_much_clutter_is_found(rng: np.random.Generator) -> None:
    points = rng.uniform(-2.0, 2.0, (6000, 3))
    patch = rng.uniform((0.0, 0.0), (0.6, 0.6), (400, 2))
    points[:400] = np.column_stack([patch, 1.0 + SIGMA_M * rng.standard_normal(400)])
    found = find_planes(points, SIGMA_M, rng, most=1)
    assert len(found.planes) == 1
    assert tilt_deg(found.planes[0], [0.0, 0.0, -1.0]) < 1.0


def test_clutter_alone_holds_no_plane(rng: np.random.Generator) -> None:
    assert find_planes(rng.uniform(-2.0, 2.0, (3000, 3)), SIGMA_M, rng).planes == ()


def test_points_turned_another_way_do_not_belong(rng: np.random.Generator) -> None:
    points = scene(rng, clutter=0)[:2000]
    normals = np.tile([0.0, 0.0, -1.0], (2000, 1))
    normals[:200] = [1.0, 0.0, 0.0]
    found = find_planes(points, SIGMA_M, rng, normals=normals)
    assert np.all(found.labels[:200] == -1)
    assert np.mean(found.labels[200:] == 0) > 0.98


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((11, 3)), "find_planes.points_m.: expected 12 or more points"),
        (np.outer(np.arange(30.0), [1.0, 1.0, 0.0]), "do not lie on one line"),
        (np.full((30, 3), np.nan), "expected finite numbers, got 90 NaN"),
        (np.zeros((30, 3)), "do not lie on one line"),
        (np.zeros((30, 2)), "expected shape"),
    ],
)
def test_points_without_planes_are_refused(
    points: np.ndarray, message: str, rng: np.random.Generator
) -> None:
    with pytest.raises(ValueError, match=message):
        find_planes(points, SIGMA_M, rng)


def test_other_bad_input_is_refused(rng: np.random.Generator) -> None:
    points = scene(rng)
    with pytest.raises(ValueError, match="expected metres above 0"):
        find_planes(points, 0.0, rng)
    with pytest.raises(ValueError, match="expected metres above 0"):
        find_planes(points, np.ones(3), rng)
    with pytest.raises(ValueError, match="expected most >= 1"):
        find_planes(points, SIGMA_M, rng, most=0)
    with pytest.raises(ValueError, match="unit vectors"):
        find_planes(points, SIGMA_M, rng, normals=2.0 * points)
    camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    with pytest.raises(ValueError, match="expected surfaces to see, got 0 pixels"):
        find_planes_in_depth(np.full((48, 64), np.nan), camera, rng)
    with pytest.raises(ValueError, match="expected shape"):
        find_planes_in_depth(np.ones((48, 63)), camera, rng)


def test_planes_of_a_drawn_room_are_its_panels(rng: np.random.Generator) -> None:
    room = furnished_room(np.random.default_rng(0))
    renderer = Renderer(room)
    camera = renderer.sensor.camera
    panels = []
    for panel in room.panels:
        normal = np.cross(panel.down_m, panel.right_m)
        normal /= np.linalg.norm(normal)
        panels.append((normal, normal @ panel.corner_m))
    for frame in (0, 130, 250):
        pose = SCENARIOS["loop"].truth().motors[frame]
        _, depth = renderer.draw(pose)
        found = find_planes_in_depth(depth, camera, rng)
        assert len(found.planes) >= 2
        assert np.mean(found.labels >= 0) > 0.7
        planes = [plane.transformed_by(pose) for plane in found.planes]
        for plane in planes:
            # Within a real camera's noise (4 cm at 5 m) a plane takes in the first centimetres of
            # its neighbours, which turns small ones.
            degrees, metres = (0.05, 0.001) if plane.support > 2000 else (0.5, 0.03)
            assert any(
                tilt_deg(plane, normal) < degrees and abs(plane.distance_m - distance) < metres
                for normal, distance in panels
            )


@pytest.mark.parametrize("frame", [0, 60])
def test_floor_table_and_cupboards_of_a_real_kitchen(data_dir: Path, frame: int) -> None:
    recording = open_recording(data_dir / "replays" / "7scenes_redkitchen")
    depth = recording.frames[frame].depth_m()
    assert depth is not None
    assert recording.camera is not None
    found = find_planes_in_depth(depth, recording.camera, np.random.default_rng(0))
    image_up = np.array([0.0, -1.0, 0.0])
    level = [plane for plane in found.planes if plane.normal @ image_up > 0.7]
    floor = max(level, key=lambda plane: -plane.distance_m)
    table = min(
        (plane for plane in level if np.prod(plane.size_m) > 0.3),
        key=lambda plane: -plane.distance_m,
    )
    assert tilt_deg(table, floor.normal) < 3.0
    # A table's height, by the tape measures of furniture makers.
    assert 0.65 < floor.normal @ (table.centre_m - floor.centre_m) < 0.80
    upright = [plane for plane in found.planes if abs(plane.normal @ floor.normal) < 0.2]
    assert len(upright) >= 2
    for wall in upright:
        assert abs(90.0 - tilt_deg(wall, floor.normal)) < 4.0
