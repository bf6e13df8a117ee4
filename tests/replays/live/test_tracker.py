"""Poses of frames that come: right, doubted for a reason, and none where none is known."""

import numpy as np
import pytest

from motorcade.replays.live import LiveFrame, LiveTracker
from motorcade.replays.live.tracker import PREDICTED_S, FirstMarker
from motorcade.tracking import SingleMarker, board_named
from tests.replays.live.drawn import BOARD, CAMERA, STEP_NS, frames, image_of, world_T_camera


@pytest.mark.parametrize("seed", [11, 12])
def test_poses_and_what_is_said_of_them_are_right(seed: int) -> None:
    tracker = LiveTracker(BOARD, CAMERA)
    off_px, held_out = [], []
    for index, frame in enumerate(frames(12, seed)):
        pose = tracker.update(frame)
        assert pose.state == "tracking", pose.why
        true = CAMERA.project(world_T_camera(index, seed).inverse().apply(BOARD.points_m))
        drawn = CAMERA.project(pose.world_T_camera.inverse().apply(BOARD.points_m))
        off_px.append(np.linalg.norm(drawn - true, axis=-1))
        held_out.append(pose.held_out_px)
    assert np.median(off_px) < 0.1
    stated = np.median(np.concatenate(held_out))
    assert np.median(off_px) < 2.0 * stated, "what is stated is no less than half of what is"
    assert stated < 0.3


def test_what_is_out_of_sight_is_predicted_briefly_and_then_lost() -> None:
    tracker = LiveTracker(BOARD, CAMERA)
    poses = [tracker.update(frame) for frame in frames(8, 3)]
    covered = np.full_like(image_of(world_T_camera(0, 3)), 128)
    states, last = [], poses[-1]
    for later in range(1, 8):
        pose = tracker.update(LiveFrame(last.time_ns + later * STEP_NS, covered))
        states.append(pose.state)
        assert (pose.world_T_camera is None) == (pose.state == "lost")
        assert not pose.measured
        assert (pose.state == "weak") == (later * STEP_NS <= PREDICTED_S * 1e9)
    back = world_T_camera(20, 3)
    seen = tracker.update(LiveFrame(last.time_ns + 20 * STEP_NS, image_of(back)))
    assert (seen.measured, seen.state) == (True, "relocalised")
    assert np.linalg.norm(seen.world_T_camera.translation_m - back.translation_m) < 0.005
    later = tracker.update(LiveFrame(last.time_ns + 40 * STEP_NS, image_of(back)))
    assert later.state == "tracking"


def test_another_board_gives_no_pose() -> None:
    tracker = LiveTracker(BOARD, CAMERA)
    for frame in frames(3, 5, board_named("checkerboard_8x5_30mm")):
        pose = tracker.update(frame)
        assert (pose.state, pose.world_T_camera) == ("searching", None)
        assert BOARD.name in pose.why


def test_the_camera_is_found_from_the_board_with_its_doubt() -> None:
    tracker = LiveTracker(BOARD)
    for index in range(60):
        frame = LiveFrame(index * 120_000_000, image_of(world_T_camera(4 * index, 8)))
        pose = tracker.update(frame)
        fit = tracker.calibration._fit if tracker.calibration else None
        if fit is not None:
            fit.exception()  # wait for it, so that the machine's load plays no part
        if pose.state == "tracking":
            break
    tracker.close()
    assert pose.state == "tracking", tracker.camera_status
    sigma = tracker.calibration.calibrated.sigma_focal
    assert abs(tracker.camera.fx / CAMERA.fx - 1.0) < max(3.0 * sigma, 0.01)
    assert "±" in tracker.camera_status


def test_a_board_seen_from_one_side_alone_gives_no_camera() -> None:
    tracker = LiveTracker(BOARD)
    for index in range(12):
        frame = LiveFrame(index * 120_000_000, image_of(world_T_camera(0, 8)))
        assert tracker.update(frame).state == "searching"
    tracker.close()
    assert tracker.camera is None
    assert "move round the board" in tracker.camera_status


def test_the_marker_that_is_seen_first_is_the_world() -> None:
    board = SingleMarker("tag36h11", 5, 0.12)
    pose = world_T_camera(0, 1)
    tracker = LiveTracker(FirstMarker("tag36h11", 0.12), CAMERA)
    blank = np.full((CAMERA.height, CAMERA.width), 128, np.uint8)
    assert "not in view" in tracker.update(LiveFrame(0, blank)).why
    seen = tracker.update(LiveFrame(STEP_NS, image_of(pose, board)))
    assert tracker.target == board
    assert seen.measured
    assert np.linalg.norm(seen.world_T_camera.translation_m - pose.translation_m) < 0.01
    assert len(seen.held_out_px) == 0, "four corners spare none"


def test_what_does_not_fit_is_refused_with_its_reason() -> None:
    tracker = LiveTracker(BOARD, CAMERA)
    tracker.update(LiveFrame(5, np.zeros((240, 320), np.uint8)))
    with pytest.raises(ValueError, match="expected a stamp after 5 ns, got 5 ns"):
        tracker.update(LiveFrame(5, np.zeros((240, 320), np.uint8)))
    with pytest.raises(ValueError, match="expected 320 x 240 pixels as the camera has"):
        tracker.update(LiveFrame(6, np.zeros((480, 640), np.uint8)))
    with pytest.raises(ValueError, match="expected a camera with SLAM"):
        LiveTracker("slam")
