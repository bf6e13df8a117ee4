"""What is drawn along a path lies where the camera saw it, or off by what the path is off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.marker_poses import _sighted as of_markers
from motorcade.replays.stages.camera.slam_poses import _sighted as of_keyframes
from motorcade.replays.stages.values.camera_poses import SightedPoints
from motorcade.tracking import (
    BoardTrack,
    Camera,
    Checkerboard,
    MarkerMap,
    PoseMeasurements,
    registration_px,
)
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.slam import MapSnapshot

CAMERA = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
DISTORTED = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "radtan", (-0.2, 0.05))
DEPTH_M, SHIFT_M = 2.0, 0.01
OFF_PX = 300.0 * SHIFT_M / DEPTH_M


def measured(count: int = 5) -> Trajectory:
    """A camera that looks along z and moves sideways."""
    time_ns = 100_000_000 * np.arange(count)
    places = np.stack([0.1 * np.arange(count), np.zeros(count), np.zeros(count)], axis=-1)
    return Trajectory(time_ns, Motor.from_translation(places))


def shifted(path: Trajectory) -> Trajectory:
    """All of it to the right, seen from the camera."""
    return path.transformed_by(right=Motor.from_translation([SHIFT_M, 0.0, 0.0]))


def recording(camera: Camera = CAMERA) -> Recording:
    frames = ImageFrames((Path("0.png"),), np.array([0]))
    return Recording("made up", Path(), "images", frames, camera)


def by_markers(camera: Camera) -> SightedPoints:
    """Two markers at the same depth; the second frame shows none, a third one is not mapped."""
    path = measured()
    known = MarkerMap(
        [3, 8],
        [0.2, 0.1],
        Rotor.identity((2,)),
        [[0.0, 0.0, DEPTH_M], [0.3, 0.1, DEPTH_M]],
    )
    frame = np.array([0, 0, 0, 2, 3, 3, 4])
    ids = np.array([3, 5, 8, 8, 3, 8, 3])
    corners = np.zeros((len(ids), 4, 2))
    for row, (at, marker) in enumerate(zip(frame, ids, strict=True)):
        if marker != 5:
            points = known.points_m.reshape(-1, 4, 3)[[3, 8].index(marker)]
            corners[row] = camera.project(path.motors[at].inverse().apply(points))
    return of_markers(CornerStream(camera, path.time_ns, frame, ids, corners), known)


@pytest.mark.parametrize("camera", [CAMERA, DISTORTED])
def test_mapped_markers_are_drawn_where_they_were_seen(camera: Camera) -> None:
    seen, path = by_markers(camera), measured()
    np.testing.assert_allclose(seen.registration_px(path), np.zeros(4), atol=1e-9)
    np.testing.assert_allclose(seen.registration_px(path[2:4]), np.zeros(2), atol=1e-9)
    off = seen.registration_px(shifted(path))
    assert off.shape == (4,)
    if camera is CAMERA:
        np.testing.assert_allclose(off, OFF_PX, rtol=1e-9)


@pytest.mark.parametrize("unit", [1.0, 0.5])
def test_the_points_of_a_map_are_drawn_where_its_keyframes_saw_them(unit: float) -> None:
    """The map has a world and a unit of its own, and keyframes of an earlier recording."""
    path = measured()
    own_T_world = Motor.random(np.random.default_rng(1))
    rows = np.array([0, 2, 4])
    keyframes = own_T_world @ path.motors[rows]
    keyframes = Motor.from_rotor_translation(keyframes.rotor, keyframes.translation_m / unit)
    points = np.stack([np.linspace(0.0, 0.4, 6), np.zeros(6), np.full(6, DEPTH_M)], axis=-1)
    keyframe_of, point_of = np.divmod(np.arange(18), 6)
    px = CAMERA.project(path.motors[rows][keyframe_of].inverse().apply(points[point_of]))
    known = MapSnapshot(
        time_ns=np.append(path.time_ns[rows], 50_000_000_000),
        world_T_camera=Motor.stack([*keyframes, Motor.identity()]),
        points=own_T_world.apply(points) / unit,
        descriptors=np.zeros((6, 32), np.uint8),
        keyframe_of=np.append(keyframe_of, 3),
        point_of=np.append(point_of, 0),
        px=np.concatenate([px, [[0.0, 0.0]]]),
        depth=np.full(19, np.nan),
        metric=False,
    )
    seen = of_keyframes(recording(), known, path, unit)
    assert seen is not None
    np.testing.assert_allclose(seen.registration_px(path), np.zeros(3), atol=1e-9)
    np.testing.assert_allclose(seen.registration_px(shifted(path)), OFF_PX, rtol=1e-9)
    elsewhere = Trajectory(path.time_ns + 1, path.motors)
    assert of_keyframes(recording(), known, elsewhere, unit) is None


def test_a_board_registers_by_its_corners_as_by_the_same_points() -> None:
    """Two programs of the same figure."""
    board, rng, path = (
        Checkerboard(columns=4, rows=3, square_m=0.1),
        np.random.default_rng(3),
        measured(),
    )
    world_T_board = Motor.from_translation([0.0, 0.1, DEPTH_M])
    points, ids = world_T_board.apply(board.points_m), np.arange(len(board.points_m))
    found = PoseMeasurements(path, np.tile(1e-6 * np.eye(6), (len(path), 1, 1)))
    observations = []
    for row, stamp in enumerate(path.time_ns.tolist()):
        px = DISTORTED.project(path.motors[row].inverse().apply(points))
        both = Motor.stack([path.motors[row]] * 2)
        noisy = px + rng.standard_normal(px.shape)
        observations.append(MarkerObservation(stamp, ids, noisy, both, np.ones(2)))
    states = np.full(len(path), "tracked")
    track = BoardTrack(path.time_ns, states, tuple(observations), found, np.ones(len(path)))
    seen = SightedPoints(
        DISTORTED,
        path.time_ns,
        np.repeat(np.arange(len(path)), len(ids)),
        np.tile(points, (len(path), 1)),
        np.concatenate([one.corners_px for one in observations]),
    )
    for one in (path, shifted(path)):
        expected = registration_px(one, track, board, DISTORTED, world_T_board)
        np.testing.assert_allclose(seen.registration_px(one), expected, rtol=1e-9)
