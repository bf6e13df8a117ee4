"""What is drawn along a path lies where the camera saw it, or off by what the path is off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.readers.frames.files import PictureFrames
from motorcade.replays.recording import Recording
from motorcade.replays.stages.registration import registrations
from motorcade.replays.values.marker_poses import MarkerPoses
from motorcade.replays.values.slam_poses import SlamPoses
from motorcade.tracking import Camera, MarkerMap, PoseMeasurements
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.slam import MapSnapshot

CAMERA = Camera(640, 480, 300.0, 300.0, 319.5, 239.5)
DISTORTED = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, "radtan", (-0.2, 0.05))
DEPTH_M, SHIFT_M = 2.0, 0.01
OFF_PX = 300.0 * SHIFT_M / DEPTH_M


def measured(count: int = 5) -> PoseMeasurements:
    """A camera that looks along z and moves sideways."""
    time_ns = 100_000_000 * np.arange(count)
    places = np.stack([0.1 * np.arange(count), np.zeros(count), np.zeros(count)], axis=-1)
    path = Trajectory(time_ns, Motor.from_translation(places))
    return PoseMeasurements(path, np.tile(1e-6 * np.eye(6), (count, 1, 1)))


def shifted(path: Trajectory) -> Trajectory:
    """All of it to the right, seen from the camera."""
    return path.transformed_by(right=Motor.from_translation([SHIFT_M, 0.0, 0.0]))


def recording(camera: Camera = CAMERA) -> Recording:
    frames = PictureFrames((Path("0.png"),), np.array([0]))
    return Recording("made up", Path(), "images", frames, camera)


def common(found: PoseMeasurements) -> tuple[PoseMeasurements, np.ndarray, np.ndarray]:
    return found, found.trajectory.time_ns, np.zeros(len(found))


def by_markers(camera: Camera) -> MarkerPoses:
    """Two markers at the same depth; the second frame shows none, a third one is not mapped."""
    found = measured()
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
            corners[row] = camera.project(found.trajectory.motors[at].inverse().apply(points))
    stream = CornerStream(camera, found.trajectory.time_ns, frame, ids, corners)
    return MarkerPoses(*common(found), "markers", "as given", marker_map=known, corners=stream)


@pytest.mark.parametrize("camera", [CAMERA, DISTORTED])
def test_mapped_markers_are_drawn_where_they_were_seen(camera: Camera) -> None:
    found = by_markers(camera)
    path = found.measurements.trajectory
    paths = {"measured": path, "off": shifted(path), "short": path[2:4]}
    made = registrations(paths, recording(camera), marker_poses=found)
    np.testing.assert_allclose(made["measured"], np.zeros(4), atol=1e-9)
    np.testing.assert_allclose(made["short"], np.zeros(2), atol=1e-9)
    assert made["off"].shape == (4,)
    if camera is CAMERA:
        np.testing.assert_allclose(made["off"], OFF_PX, rtol=1e-9)


@pytest.mark.parametrize("metres_a_unit", [None, 0.5])
def test_the_points_of_a_map_are_drawn_where_its_keyframes_saw_them(
    metres_a_unit: float | None,
) -> None:
    """The map has a world and a unit of its own, and keyframes of an earlier recording."""
    found = measured()
    path, unit = found.trajectory, metres_a_unit or 1.0
    own_T_world = Motor.random(np.random.default_rng(1))
    rows = np.array([0, 2, 4])
    keyframes = own_T_world @ path.motors[rows]
    keyframes = Motor.from_rotor_translation(keyframes.rotor, keyframes.translation_m / unit)
    points = np.stack([np.linspace(0.0, 0.4, 6), np.zeros(6), np.full(6, DEPTH_M)], axis=-1)
    keyframe_of, point_of = np.divmod(np.arange(18), 6)
    px = CAMERA.project(path.motors[rows][keyframe_of].inverse().apply(points[point_of]))
    of_another = np.concatenate([keyframe_of, [3]])
    known = MapSnapshot(
        time_ns=np.append(path.time_ns[rows], 50_000_000_000),
        world_T_camera=Motor.stack([*keyframes, Motor.identity()]),
        points=own_T_world.apply(points) / unit,
        descriptors=np.zeros((6, 32), np.uint8),
        keyframe_of=of_another,
        point_of=np.append(point_of, 0),
        px=np.concatenate([px, [[0.0, 0.0]]]),
        depth=np.full(19, np.nan),
        metric=False,
    )
    poses = SlamPoses(
        *common(found), "slam", "as given", metres_a_unit=metres_a_unit, slam_map=known
    )
    made = registrations({"measured": path, "off": shifted(path)}, recording(), slam_poses=poses)
    np.testing.assert_allclose(made["measured"], np.zeros(3), atol=1e-9)
    np.testing.assert_allclose(made["off"], OFF_PX, rtol=1e-9)
    elsewhere = Trajectory(path.time_ns + 1, path.motors)
    later = SlamPoses(
        *common(PoseMeasurements(elsewhere, found.covariance)), "slam", "as given", slam_map=known
    )
    assert registrations({"measured": elsewhere}, recording(), slam_poses=later) == {}


def test_nothing_is_said_where_nothing_was_tracked_in_pictures() -> None:
    path = MOTIONS["handheld"].sampled(rate_hz=10.0, duration_s=1.0)
    assert registrations({"measured": path}, recording()) == {}
