"""A board described wrongly is told of: too few or too many corners, lengths not in metres."""

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.board_audit import audited_board, audited_markers
from motorcade.replays.stages.camera.board_poses import warn_of_size
from motorcade.tracking import (
    BoardTrack,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerMap,
    PoseMeasurements,
    map_markers,
)
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.rolling import unrolled_stream
from motorcade.tracking.targets.chessboards import checkerboard_seen
from motorcade.tracking.targets.stated import compare_layout
from tests.replays.stages.stamps import Stamps
from tests.tracking.board_tracking.test_rolling import CAMERA, TIME_NS, filmed, path

PRINTED = Checkerboard(9, 6, 0.03)
WARP = np.array([[0.9, 0.15, 40.0], [-0.1, 0.85, 60.0], [2e-4, 3e-4, 1.0]])


def image() -> np.ndarray:
    """The print seen askew on a grey table."""
    drawn, _ = PRINTED.draw(1000.0)
    grey = cv2.warpPerspective(drawn, WARP, (480, 360), borderValue=(120.0,))
    return cv2.GaussianBlur(grey, (0, 0), 0.8)


@pytest.mark.parametrize(("columns", "rows"), [(8, 6), (9, 5), (8, 5), (9, 7), (10, 6), (10, 7)])
def test_a_board_of_another_count_is_named_with_its_mend(columns: int, rows: int) -> None:
    finding = compare_layout(Checkerboard(columns, rows, 0.03), [image()] * 3)
    assert finding is not None
    assert finding.verdict == "contradicted"
    assert f"looks like 9 x 6 inner corners, not {columns} x {rows}" in finding.sentence
    assert finding.advice == "say columns = 9, rows = 6"


@pytest.mark.parametrize("stated", [PRINTED, Checkerboard(6, 9, 0.03)])
def test_a_board_of_the_right_count_is_not_doubted(stated: Checkerboard) -> None:
    finding = compare_layout(stated, [image()] * 3)
    assert finding is not None
    assert finding.verdict == "consistent", finding.sentence


@pytest.mark.parametrize("stated", [(9, 6), (6, 9), (8, 5), (10, 7)])
def test_a_stated_size_that_is_tried_first_does_not_change_the_count(
    stated: tuple[int, int],
) -> None:
    assert checkerboard_seen([image()] * 3, stated) == checkerboard_seen([image()] * 3)


def test_markers_in_squares_are_seen_without_being_read() -> None:
    print_ = CharucoBoard("aruco_5x5_50", 10, 7, 0.03, 0.018)
    drawn = cv2.warpPerspective(print_.draw(1000.0)[0], WARP, (480, 360), borderValue=(120.0,))
    for shown, plain in ((image(), True), (cv2.GaussianBlur(drawn, (0, 0), 0.8), False)):
        counted = checkerboard_seen([shown] * 3)
        assert counted is not None
        assert counted.plain is plain


def test_a_board_whose_end_is_never_in_view_is_not_counted() -> None:
    cut = image()[:, :300].copy()
    finding = compare_layout(Checkerboard(8, 6, 0.03), [cut] * 3)
    assert finding is not None
    assert finding.verdict == "unknown", finding.sentence


def test_lengths_that_are_hardly_metres_are_told_of(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "motorcade"):
        warn_of_size(Checkerboard(9, 6, 0.04))
        assert caplog.messages == []
        warn_of_size(Checkerboard(9, 6, 40.0))
    (message,) = caplog.messages
    assert "400 x 280 m large; are its lengths in metres?" in message


def camera_on_board(tilt_rad: float, bent_px: float = 0.0) -> AuditFinding:
    """What thirty views of a board that leans so far say of the camera that took them."""
    rng, count = np.random.default_rng(3), 30
    camera, stamps = Camera(640, 480, 500.0, 500.0, 319.5, 239.5), np.arange(count) * 33_000_000
    k = np.arange(count)
    tilt = tilt_rad * np.stack([np.sin(k), np.cos(1.7 * k), 0.0 * k], axis=-1)
    place = np.stack([0.12 + 0.03 * np.sin(k), 0.07 + 0.02 * np.cos(k), 0.5 + 0.05 * np.sin(3 * k)])
    face_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
    poses = Motor.from_rotor_translation(face_down @ Rotor.from_rotation_vector(tilt), place.T)
    px = camera.project(poses.inverse()[:, None].apply(PRINTED.points_m))
    px += bent_px * np.sin(px / 30.0)[..., ::-1] + 0.1 * rng.standard_normal(px.shape)
    ids, both = np.arange(len(PRINTED.points_m)), np.full(2, 0.1)
    seen = tuple(
        MarkerObservation(int(stamps[row]), ids, px[row], Motor.stack([poses[row]] * 2), both)
        for row in range(count)
    )
    covariance = np.tile(1e-6 * np.eye(6), (count, 1, 1))
    measured = PoseMeasurements(Trajectory(stamps, poses), covariance)
    track = BoardTrack(stamps, np.full(count, "tracked"), seen, measured, np.full(count, 0.1))
    frames = Stamps(stamps)
    recording = Recording("drawn", Path(), "images", frames, camera)  # type: ignore[arg-type]
    (of_camera, *_), *_ = audited_board(recording, PRINTED, track, 0.1)
    return of_camera


@pytest.mark.parametrize(
    ("tilt_rad", "bent_px", "verdict"),
    [
        (0.4, 0.0, "consistent"),
        (0.0, 0.0, "unknown"),  # a board seen face on tells no focal length
        (0.4, 3.0, "unknown"),  # no lens explains the views: that of the manifest neither
    ],
)
def test_a_camera_is_consistent_only_where_views_could_deny_it(
    tilt_rad: float, bent_px: float, verdict: str
) -> None:
    finding = camera_on_board(tilt_rad, bent_px)
    assert finding.verdict == verdict, finding.summary


@pytest.mark.parametrize(("stated_s", "verdict"), [(0.02, "consistent"), (0.0, "contradicted")])
def test_loose_markers_deny_a_read_out_that_nobody_states(stated_s: float, verdict: str) -> None:
    turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.3], [0.2, 0.0, 0.0], [0.0, 0.1, 0.0]])
    places = [[0.0, 0.05, 0.0], [0.12, 0.0, 0.02], [0.05, -0.08, 0.0]]
    room, shutter_s = MarkerMap([4, 7, 9], [0.05] * 3, turns, places), np.array([0.0, 0.02])
    px = np.array(filmed(room.points_m, (0.0, 0.02))).reshape(-1, 4, 2)
    frame, ids = np.repeat(np.arange(len(TIME_NS)), 3), np.tile([4, 7, 9], len(TIME_NS))
    stream = CornerStream(CAMERA, TIME_NS, frame, ids, px)
    if stated_s:
        stream = unrolled_stream(stream, Trajectory(TIME_NS, path(1e-9 * TIME_NS)), room, shutter_s)
    mapped = map_markers({"camera": stream}, room.sides)
    frames = Stamps(TIME_NS)
    recording = Recording("drawn", Path(), "images", frames, CAMERA, readout_s=stated_s)  # type: ignore[arg-type]
    (finding,), off_s, unsure_s2 = audited_markers(recording, stream, mapped, 0.1)
    assert finding.verdict == verdict, finding.summary
    np.testing.assert_allclose(off_s, shutter_s - [0.0, stated_s], atol=1e-3)
    assert np.sqrt(unsure_s2[1, 1]) < 0.002
