"""A rolling shutter taken out of tracks: exact projections, line by line, are the witness."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import (
    Board,
    BoardTrack,
    Camera,
    Checkerboard,
    MarkerMap,
    PoseMeasurements,
    SingleMarker,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.pose import refine
from motorcade.tracking.rolling import (
    unrolled_stream,
    unrolled_track,
    with_unsure_readout,
    with_unsure_shutter,
)
from tests.end_to_end.phones.sensor import PhoneCamera

BOARD = Checkerboard(8, 5, 0.03)
CAMERA = Camera(1080, 1920, 1400.0, 1400.0, 530.0, 970.0, "radtan", (0.05, -0.06))
TIME_NS = 33_333_333 * np.arange(30)
READOUTS = [(0.0, 0.02), (0.0, -0.02), (-0.02, 0.0), (0.02, 0.0)]


def path(time_s: np.ndarray) -> Motor:
    """A hand above the board that moves, turns and trembles; world_T_camera."""
    time = np.asarray(time_s, np.float64)
    turn = np.stack(
        [np.pi - 0.4 + 0.1 * np.sin(2.0 * time), 0.3 * np.sin(1.7 * time), 0.1 * np.cos(time)], -1
    )
    place = np.stack(
        [
            0.1 + 0.05 * np.sin(3.0 * time) + 0.002 * np.sin(30.0 * time),
            0.15 + 0.04 * np.cos(2.5 * time),
            0.5 + 0.05 * np.sin(2.0 * time),
        ],
        axis=-1,
    )
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)


def filmed(points_m: np.ndarray, shutter_s: tuple[float, float]) -> list[np.ndarray]:
    """Where a phone sees points, each line at its own time."""
    phone = PhoneCamera(CAMERA, shutter_s)
    return [phone.project(path, time, points_m) for time in 1e-9 * TIME_NS]


def tracked(corners_px: list[np.ndarray], board: Board = BOARD) -> BoardTrack:
    """A track as it comes of a tracker that knows no rolling shutter."""
    ids, seen, found = np.arange(len(board.points_m)), [], []
    for time_ns, px in zip(TIME_NS, corners_px, strict=True):
        near = path(np.array(1e-9 * time_ns))
        found.append(refine(BoardCorners(ids, px, board.points_m), CAMERA, near))
        seen.append(MarkerObservation(time_ns, ids, px, Motor.stack([near, near]), np.zeros(2)))
    poses = Trajectory(TIME_NS, Motor.stack([one.world_T_camera for one in found]))
    covariance = np.stack([one.covariance for one in found])
    errors = np.array([one.error_px for one in found])
    states = np.full(len(TIME_NS), "detected")
    return BoardTrack(TIME_NS, states, tuple(seen), PoseMeasurements(poses, covariance), errors)


def off_m(poses: Motor) -> float:
    apart = poses.translation_m - path(1e-9 * TIME_NS).translation_m
    return float(np.sqrt(np.mean(np.sum(apart**2, axis=-1))))


@pytest.mark.parametrize("shutter_s", READOUTS)
def test_a_boards_poses_are_those_at_the_stamps(shutter_s: tuple[float, float]) -> None:
    track = tracked(filmed(BOARD.points_m, shutter_s))
    unrolled = unrolled_track(track, BOARD, CAMERA, np.array(shutter_s))
    before = off_m(track.measurements.trajectory.motors)
    after = off_m(unrolled.measurements.trajectory.motors)
    assert before > 1e-3  # metres: the shutter does harm here
    assert after < 0.1 * before
    still = np.array(filmed(BOARD.points_m, (0.0, 0.0)))
    bent, straight = (
        np.abs(np.array([one.corners_px for one in some.observations]) - still)
        for some in (track, unrolled)
    )
    assert straight.mean() < 0.1 * bent.mean()
    assert unrolled.error_px.mean() < 0.2 * track.error_px.mean()


def test_a_still_shutter_changes_nothing() -> None:
    track = tracked(filmed(BOARD.points_m, (0.0, 0.0)))
    unrolled = unrolled_track(track, BOARD, CAMERA, np.zeros(2))
    for one, other in zip(track.observations, unrolled.observations, strict=True):
        assert np.array_equal(one.corners_px, other.corners_px)


@pytest.mark.parametrize("shutter_s", READOUTS)
def test_poses_are_no_surer_than_the_read_out_is(shutter_s: tuple[float, float]) -> None:
    """Taken as read at once, poses lie tens of their deviations off; some three, knowing that."""
    track = tracked(filmed(BOARD.points_m, shutter_s))
    unsure_s2 = np.diag(1e-6 + np.square(shutter_s))
    unsure = with_unsure_shutter(track, BOARD, CAMERA, unsure_s2)
    off = track.measurements.trajectory.motors.local(path(1e-9 * TIME_NS))
    sigmas = [
        np.sqrt(np.einsum("ni,nij,nj->n", off, np.linalg.inv(one.measurements.covariance), off))
        for one in (track, unsure)
    ]
    assert np.median(sigmas[0]) > 20.0
    assert np.median(sigmas[1]) < 3.0
    assert sigmas[1].max() < 10.0  # which how the hand trembles adds: nobody knows how fast


def test_a_map_of_one_marker_is_as_unsure_as_that_marker_as_a_board() -> None:
    board, unsure_s2 = SingleMarker("tag36h11", 4, 0.05), np.diag([1e-6, 4e-4])
    track = tracked(filmed(board.points_m, (0.0, 0.02)), board)
    px = np.array([one.corners_px for one in track.observations])
    rows = np.arange(len(px))
    stream = CornerStream(CAMERA, TIME_NS, rows, np.full(len(px), 4), px)
    known = MarkerMap([4], [0.05], Motor.identity((1,)).rotor, [[0.0, 0.0, 0.0]])
    unsure = with_unsure_readout(track.measurements, stream, known, unsure_s2)
    expected = with_unsure_shutter(track, board, CAMERA, unsure_s2).measurements
    np.testing.assert_allclose(unsure.covariance, expected.covariance, rtol=1e-9, atol=1e-15)


def test_markers_corners_are_those_at_the_stamps_and_unknown_ones_stay() -> None:
    turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.3], [0.5, 0.0, 0.0]])
    known = MarkerMap([4, 9], [0.05, 0.05], turns, [[0.0, 0.05, 0.0], [0.15, 0.0, 0.02]])
    shutter_s = (0.0, 0.02)
    rolled, still = (np.array(filmed(known.points_m, one)) for one in (shutter_s, (0.0, 0.0)))
    frame, ids = np.repeat(np.arange(len(TIME_NS)), 3), np.tile([4, 9, 11], len(TIME_NS))
    corners = np.zeros((len(TIME_NS), 3, 4, 2))
    corners[:, :2] = rolled.reshape(-1, 2, 4, 2)
    corners[:, 2] = [[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]]
    stream = CornerStream(CAMERA, TIME_NS, frame, ids, corners.reshape(-1, 4, 2))
    poses = Trajectory(TIME_NS, path(1e-9 * TIME_NS))
    found = unrolled_stream(stream, poses, known, np.array(shutter_s)).corners_px
    found = found.reshape(-1, 3, 4, 2)
    bent = np.abs(rolled - still).mean()
    straight = np.abs(found[:, :2] - still.reshape(-1, 2, 4, 2)).mean()
    assert bent > 0.2  # pixels: the shutter does harm here
    assert straight < 0.1 * bent
    assert np.array_equal(found[:, 2], corners[:, 2])
