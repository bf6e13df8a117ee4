"""Markers that slide among others that stand are found; where all stand, none is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, map_markers
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.mapping.estimate import moving_markers

CAMERA = Camera(640, 480, 520.0, 520.0, 318.0, 242.0)
SIDE_M, FRAMES, NOISE_PX = 0.08, 20, 0.15


def seen(seed: int, slides_m: dict[int, float], count: int) -> CornerStream:
    """A camera over a table of tags, some of which slide as it moves."""
    rng = np.random.default_rng(seed)
    place = np.stack([np.arange(count) % 3 * 0.35 - 0.35, np.arange(count) // 3 * 0.4 - 0.2], -1)
    place = np.pad(place + rng.uniform(-0.05, 0.05, place.shape), ((0, 0), (0, 1)))
    turned = Rotor.from_rotation_vector(rng.normal(0.0, 0.3, (count, 3)))
    way = np.pad(rng.normal(size=(count, 2)), ((0, 0), (0, 1)))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    distance = np.array([slides_m.get(marker, 0.0) for marker in range(count)])
    phase, rows, ids, corners = rng.uniform(0.0, 6.0, 3), [], [], []
    for frame in range(FRAMES):
        u = frame / 5.0
        tilt = Rotor.from_rotation_vector(0.35 * np.array([np.sin(u + phase[0]), np.cos(u), 0.0]))
        pose = tilt @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
        eye = tilt.apply(np.array([0.0, 0.0, 1.15 + 0.1 * np.sin(u + phase[1])]))
        world_T_marker = Motor.from_rotor_translation(
            turned, place + way * (distance * frame / FRAMES)[:, None]
        )
        camera_T_marker = Motor.from_rotor_translation(pose, eye).inverse() @ world_T_marker
        px = CAMERA.project(camera_T_marker[:, None].apply(marker_points_m(SIDE_M)))
        rows += [frame] * count
        ids += range(count)
        corners.append(px + NOISE_PX * rng.standard_normal(px.shape))
    stamps = 33_000_000 * np.arange(FRAMES)
    return CornerStream(CAMERA, stamps, np.array(rows), np.array(ids), np.concatenate(corners))


@pytest.mark.parametrize(
    ("slides_m", "count"),
    [
        ({}, 6),
        ({2: 0.25}, 4),
        pytest.param({4: 0.25}, 6, marks=pytest.mark.slow),
        pytest.param({0: 0.25, 1: 0.15, 5: 0.2}, 6, marks=pytest.mark.slow),
        pytest.param({7: 0.1}, 12, marks=pytest.mark.slow),
    ],
)
def test_those_that_slide_are_found_and_no_others(slides_m: dict[int, float], count: int) -> None:
    streams = {"camera": seen(3, slides_m, count)}
    sides = dict.fromkeys(range(count), SIDE_M)
    mapped = map_markers(streams, sides)
    found = moving_markers(streams, mapped, lambda part: map_markers(part, sides), 1.0)
    assert found == tuple(sorted(slides_m))


@pytest.mark.slow
def test_of_two_halves_that_part_neither_is_said_to_move() -> None:
    together = seen(3, {}, 4)
    stream = CornerStream(
        CAMERA,
        together.time_ns,
        together.frame,
        together.marker_ids,
        together.corners_px + np.where(together.marker_ids < 2, together.frame, 0)[:, None, None],
    )
    sides = dict.fromkeys(range(4), SIDE_M)
    mapped = map_markers({"camera": stream}, sides)
    assert (
        moving_markers({"camera": stream}, mapped, lambda part: map_markers(part, sides), 1.0) == ()
    )


def test_one_that_is_pushed_within_a_single_frame_moves_no_pose() -> None:
    stream, sides = seen(3, {}, 6), dict.fromkeys(range(6), SIDE_M)
    rows = (stream.frame == 12) & (stream.marker_ids == 2)
    pushed = replace(stream, corners_px=stream.corners_px + 4.0 * rows[:, None, None])
    by_others, by_all = (
        map_markers({"camera": one}, sides, most_px=1.0) for one in (stream.where(~rows), pushed)
    )
    moved = by_others.trajectory.motors.local(by_all.trajectory.motors)
    precision = np.linalg.inv(by_others.covariance)
    assert np.sqrt(np.einsum("ni,nij,nj->n", moved, precision, moved).max()) < 0.3
