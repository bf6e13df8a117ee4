"""Tracking through recordings: rendered ones with exact truth, and the real checkerboard."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import (
    Board,
    BoardTrack,
    BoardTracker,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    PoseMeasurements,
    SingleMarker,
    TrackingError,
    track_board,
)
from motorcade.tracking.board_tracking.tracker import guessed_turns
from motorcade.tracking.measurements import MarkerObservation

STEP_NS = 33_333_333
CHECKERS = Checkerboard(9, 6, 0.03)
BOARDS: list[tuple[Board, float, float]] = [  # and the RMS error allowed: millimetres, degrees
    (CHECKERS, 0.5, 0.06),
    (Checkerboard(7, 5, 0.04), 0.5, 0.06),
    (MarkerGrid("tag36h11", 4, 3, 0.05, 0.015), 0.4, 0.05),
    (SingleMarker("tag36h11", 5, 0.12), 1.5, 0.2),
    (CharucoBoard("aruco_5x5_100", 7, 5, 0.04, 0.028), 0.8, 0.1),
]
every_board = pytest.mark.parametrize(
    ("board", "position_mm", "angle_deg"), BOARDS, ids=[board.name for board, *_ in BOARDS]
)


@pytest.fixture(scope="module")
def sequence(render, look_at):
    """``sequence(board, camera, frames)`` -> true poses and images along a smooth path."""
    known: dict[tuple[Board, Camera], tuple[list[Motor], list[np.ndarray]]] = {}

    def make(board: Board, camera: Camera, frames: int) -> tuple[list[Motor], list[np.ndarray]]:
        poses, images = known.setdefault((board, camera), ([], []))
        for frame in range(len(poses), frames):
            phase = frame / 20.0
            distance = (1.15 + 0.2 * np.sin(5.0 * phase)) * 1e-3 * camera.fx
            tilt = 15.0 + 25.0 * np.sin(3.0 * phase)
            pose = look_at(board, distance, tilt, 60.0 + 150.0 * phase, -30.0 + 80.0 * phase)
            poses.append(pose)
            images.append(render(board, camera, pose, blur_px=0.8, noise=2.0, seed=frame))
        return poses[:frames], [image.copy() for image in images[:frames]]

    return make


def stamped(images: list[np.ndarray]) -> list[tuple[int, np.ndarray]]:
    return [(frame * STEP_NS, image) for frame, image in enumerate(images)]


def errors(found: Motor, true: Motor) -> tuple[np.ndarray, np.ndarray]:
    twist = (found.inverse() @ true).as_twist()
    turned, moved = np.linalg.norm(twist[..., :3], axis=-1), np.linalg.norm(twist[..., 3:], axis=-1)
    return 1e3 * moved, np.degrees(turned)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.quick_every(2)
@every_board
def test_a_rendered_path_is_followed(
    board: Board, position_mm: float, angle_deg: float, wide_camera, sequence
) -> None:
    poses, images = sequence(board, wide_camera, 12)
    track = track_board(stamped(images), wide_camera, board)
    assert track.count("lost") == 0
    assert track.count("tracked") >= 10
    found = track.measurements.trajectory.poses
    moved, turned = errors(found, Motor.stack(poses))
    assert rms(moved) < position_mm
    assert rms(turned) < angle_deg
    assert track.error_px.max() < 0.2
    for observation in track.observations:
        assert observation.candidates.shape == (2,)
        assert observation.candidate_error_px[0] <= observation.candidate_error_px[1]


def test_claimed_covariance_covers_the_error(straight_camera, sequence) -> None:
    board = MarkerGrid("tag36h11", 4, 3, 0.05, 0.015)
    poses, images = sequence(board, straight_camera, 12)
    measurements = track_board(stamped(images), straight_camera, board).measurements
    delta = (measurements.trajectory.poses.inverse() @ Motor.stack(poses)).as_twist()
    squared = np.einsum("ni,nij,nj->n", delta, np.linalg.inv(measurements.covariance), delta)
    assert 0.02 < squared.mean() < 6.0


def test_what_is_covered_is_lost_and_comes_back(straight_camera, sequence) -> None:
    poses, images = sequence(CHECKERS, straight_camera, 10)
    for frame in (3, 4, 5):
        images[frame] = np.full_like(images[frame], 120)
    track = track_board(stamped(images), straight_camera, CHECKERS)
    assert list(track.states[3:6]) == ["lost"] * 3
    assert track.states[6] == "detected"
    assert track.count("lost") == 3
    np.testing.assert_array_equal(
        track.measurements.trajectory.time_ns, np.delete(np.arange(10) * STEP_NS, [3, 4, 5])
    )
    moved, _ = errors(track.measurements.trajectory.poses[3], poses[6])
    assert moved < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("board", [CHECKERS, BOARDS[2][0], BOARDS[4][0]], ids=lambda b: b.name)
def test_frames_in_any_order_are_measured_as_those_in_theirs(
    board: Board, straight_camera, sequence
) -> None:
    poses, images = sequence(board, straight_camera, 40)
    for seed in range(4):
        order = np.random.default_rng(seed).permutation(40)
        track = track_board(stamped([images[row] for row in order]), straight_camera, board)
        seen = order[track.states != "lost"]
        moved, _ = errors(
            track.measurements.trajectory.poses, Motor.stack([poses[k] for k in seen])
        )
        assert moved.max() < 4.0
        assert len(seen) >= 38


def test_a_board_that_looks_the_same_turned_is_doubted_where_it_jumps(
    straight_camera, render, look_at
) -> None:
    board = Checkerboard(5, 5, 0.04)
    rolls = [0.0, 4.0, 8.0, 95.0, 99.0]
    shown = [render(board, straight_camera, look_at(board, 0.5, 20.0, 30.0, r)) for r in rolls]
    jumps = track_board(stamped(shown), straight_camera, board)
    assert guessed_turns(board, jumps) == 1
    assert guessed_turns(board, track_board(stamped(shown[:3]), straight_camera, board)) == 0


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("board", [CHECKERS, BOARDS[2][0], BOARDS[4][0]], ids=lambda b: b.name)
def test_a_hand_over_the_board_costs_corners_not_the_pose(
    board: Board, straight_camera, sequence
) -> None:
    poses, images = sequence(board, straight_camera, 12)
    for frame in range(3, 8):
        cv2.circle(images[frame], (150 + 15 * frame, 170), 40, 150, -1)
    track = track_board(stamped(images), straight_camera, board)
    counts = np.array([len(one.ids) for one in track.observations])
    assert track.count("lost") == 0
    assert counts[3:8].max() < counts[1]
    assert counts[-1] >= 0.9 * len(board.points_m), "corners come back once they are seen again"
    moved, turned = errors(track.measurements.trajectory.poses, Motor.stack(poses))
    assert moved.max() < 4.0
    assert turned.max() < 0.5


def test_a_symmetric_board_keeps_its_numbering_while_it_turns(
    straight_camera, render, look_at
) -> None:
    board = Checkerboard(5, 5, 0.04)
    poses = [look_at(board, 0.5, 20.0, 30.0, 20.0 * frame) for frame in range(11)]
    images = [render(board, straight_camera, pose) for pose in poses]
    tracker = BoardTracker(straight_camera, board, redetect_every=2)
    frames = [tracker.update(image, time) for time, image in stamped(images)]
    assert {frame.state for frame in frames} == {"detected", "tracked"}
    for frame, pose in zip(frames, poses, strict=True):
        assert errors(frame.world_T_camera, pose)[1] < 0.5


def test_a_jump_is_caught_by_a_new_search(straight_camera, render, look_at) -> None:
    near = render(CHECKERS, straight_camera, look_at(CHECKERS, 0.5, 10.0))
    there = look_at(CHECKERS, 0.7, 40.0, 200.0, 130.0)
    tracker = BoardTracker(straight_camera, CHECKERS)
    assert tracker.update(near, 0).state == "detected"
    frame = tracker.update(render(CHECKERS, straight_camera, there), STEP_NS)
    assert frame.state == "detected"
    assert errors(frame.world_T_camera, there)[0] < 1.0


def test_the_same_images_give_the_same_bytes(straight_camera, sequence) -> None:
    board = BOARDS[4][0]
    _, images = sequence(board, straight_camera, 5)
    copies = [image.copy() for image in images]
    tracks = [track_board(stamped(images), straight_camera, board) for _ in range(2)]
    first, second = (
        b"".join(
            array.tobytes()
            for array in (
                track.measurements.trajectory.motors.coefficients,
                track.measurements.covariance,
                track.error_px,
                *(seen.corners_px for seen in track.observations),
                *(seen.candidates.coefficients for seen in track.observations),
            )
        )
        for track in tracks
    )
    assert first == second
    for image, copy in zip(images, copies, strict=True):
        np.testing.assert_array_equal(image, copy)


def test_frames_that_cannot_be_are_refused(straight_camera) -> None:
    grey = np.full((360, 480), 90, np.uint8)
    tracker = BoardTracker(straight_camera, CHECKERS)
    assert tracker.update(grey, 10) is None
    with pytest.raises(ValueError, match="time_ns: expected more than 10, got 10"):
        tracker.update(grey, 10)
    with pytest.raises(ValueError, match="time_ns: expected whole nanoseconds"):
        tracker.update(grey, 0.5)
    with pytest.raises(ValueError, match=r"image: expected 480 x 360 pixels .* got 360 x 480"):
        tracker.update(grey.T.copy(), 20)
    with pytest.raises(ValueError, match="redetect_every"):
        BoardTracker(straight_camera, CHECKERS, redetect_every=0)


def test_a_recording_without_the_board_is_refused(straight_camera) -> None:
    grey = np.full((360, 480), 90, np.uint8)
    with pytest.raises(TrackingError, match=r"checkerboard_9x6_30mm, got it in none of 2"):
        track_board([(0, grey), (1, grey)], straight_camera, CHECKERS)
    with pytest.raises(TrackingError, match="none of 0"):
        track_board([], straight_camera, CHECKERS)


@pytest.mark.parametrize(
    ("covariance", "told"),
    [
        (np.eye(6), r"expected \(2, 6, 6\), got \(6, 6\)"),
        (np.zeros((2, 6, 6)), "positive definite"),
        (np.tile(np.eye(6) + np.eye(6, k=1), (2, 1, 1)), "symmetric"),
        (np.full((2, 6, 6), np.nan), "finite"),
    ],
)
def test_covariances_that_cannot_be_are_refused(covariance: np.ndarray, told: str) -> None:
    trajectory = Trajectory(np.array([0, 1]), Motor.identity((2,)))
    with pytest.raises(ValueError, match=told):
        PoseMeasurements(trajectory, covariance)


def test_observations_that_do_not_fit_are_refused() -> None:
    both, good = Motor.identity((2,)), np.zeros((4, 2))
    with pytest.raises(ValueError, match=r"corners_px: expected \(4, 2\), got \(3, 2\)"):
        MarkerObservation(0, np.arange(4), good[:3], both, np.zeros(2))
    with pytest.raises(ValueError, match="candidates: expected 2 poses"):
        MarkerObservation(0, np.arange(4), good, both[0], np.zeros(2))
    with pytest.raises(ValueError, match=r"candidate_error_px: .* finite"):
        MarkerObservation(0, np.arange(4), good, both, np.array([0.1, np.inf]))


def test_a_track_must_agree_with_itself(straight_camera, sequence) -> None:
    _, images = sequence(CHECKERS, straight_camera, 2)
    track = track_board(stamped(images), straight_camera, CHECKERS)
    rest = (track.observations, track.measurements, track.error_px)
    with pytest.raises(ValueError, match="states: expected lost, detected, tracked only"):
        BoardTrack(track.time_ns, np.array(["seen", "seen"]), *rest)
    with pytest.raises(ValueError, match="observations: expected the 1 stamps"):
        BoardTrack(track.time_ns, np.array(["lost", "tracked"]), *rest)


# The real checkerboard -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def checkerboard_track(data_dir: Path) -> tuple[BoardTrack, np.ndarray]:
    folder = data_dir / "replays" / "vamr_board"
    matrix = np.loadtxt(folder / "K.txt")
    distortion = tuple(np.loadtxt(folder / "D.txt"))
    camera = Camera(
        752, 480, matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], "radtan", distortion
    )
    images = sorted((folder / "images").glob("*.jpg"))
    frames = (
        (round(frame * 1e9 / 30), cv2.imread(str(image), cv2.IMREAD_GRAYSCALE))
        for frame, image in enumerate(images)
    )
    reference = np.loadtxt(folder / "poses.txt")[: len(images)]
    return track_board(frames, camera, Checkerboard(9, 6, 0.04)), reference


def test_every_frame_of_the_recorded_checkerboard_is_tracked(checkerboard_track) -> None:
    track, _ = checkerboard_track
    assert len(track) == 250
    assert track.count("lost") == 0
    assert track.count("tracked") > 235
    assert rms(track.error_px) < 0.2
    assert min(len(one.ids) for one in track.observations) >= 50


def test_the_recorded_checkerboard_agrees_with_its_reference(checkerboard_track) -> None:
    """Aligned by SE3 it is as near as any method comes to a reference that is itself noisy."""
    track, reference = checkerboard_track
    found = track.measurements.trajectory.poses
    view = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(reference[:, :3]), reference[:, 3:]
    )
    true = view.inverse()
    ours, theirs = found.translation_m, true.translation_m
    align, _ = Rotation.align_vectors(theirs - theirs.mean(axis=0), ours - ours.mean(axis=0))
    residual = theirs - theirs.mean(axis=0) - align.apply(ours - ours.mean(axis=0))
    assert rms(np.linalg.norm(residual, axis=1)) < 0.62e-3
    turned = Rotation.from_matrix(true.rotor.as_matrix()).inv() * (
        align * Rotation.from_matrix(found.rotor.as_matrix())
    )
    assert np.degrees(rms(turned.magnitude())) < 0.21
