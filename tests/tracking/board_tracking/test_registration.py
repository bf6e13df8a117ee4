"""Registration says, in pixels, how far a drawn thing would lie from the footage."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import BoardTrack, Camera, Checkerboard, PoseMeasurements, registration_px
from motorcade.tracking.measurements import MarkerObservation

BOARD = Checkerboard(columns=5, rows=4, square_m=0.05)
CAMERA = Camera(640, 480, 500.0, 500.0, 320.0, 240.0, "radtan", (-0.1, 0.02))
WORLD_T_BOARD = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([0.3, -0.2, 1.0]), [1.0, 2.0, 3.0]
)
TIMES = np.array([0, 10_000_000, 20_000_000])


@pytest.fixture
def truth() -> Trajectory:
    """A camera half a metre above the board, looking down, drifting."""
    facing = Rotor.from_rotation_vector(np.array([[np.pi, 0.0, 0.0], [3.1, 0, 0], [3.0, 0.1, 0]]))
    board_T_camera = Motor.from_rotor_translation(facing, np.tile([0.1, -0.08, 0.5], (3, 1)))
    return Trajectory(TIMES, WORLD_T_BOARD @ board_T_camera)


@pytest.fixture
def seen(truth: Trajectory) -> BoardTrack:
    observations = []
    for stamp, pose in zip(TIMES, truth.poses, strict=True):
        pixels = CAMERA.project((pose.inverse() @ WORLD_T_BOARD).apply(BOARD.points_m))
        ids = np.arange(len(pixels))
        both = Motor.stack([pose, pose])
        observations.append(MarkerObservation(int(stamp), ids, pixels, both, np.zeros(2)))
    measurements = PoseMeasurements(truth, np.tile(1e-6 * np.eye(6), (3, 1, 1)))
    states = np.full(3, "detected")
    return BoardTrack(TIMES, states, tuple(observations), measurements, np.zeros(3))


def test_the_true_path_is_registered_exactly(truth: Trajectory, seen: BoardTrack) -> None:
    found = registration_px(truth, seen, BOARD, CAMERA, WORLD_T_BOARD)
    np.testing.assert_allclose(found, 0.0, atol=1e-9)


def test_a_small_turn_shows_as_its_angle_times_the_focal_length(
    truth: Trajectory, seen: BoardTrack
) -> None:
    turned = truth.transformed_by(right=Motor.from_twist([0.0, 1e-4, 0.0, 0.0, 0.0, 0.0]))
    found = registration_px(turned, seen, BOARD, CAMERA, WORLD_T_BOARD)
    np.testing.assert_allclose(found, 500.0 * 1e-4, rtol=0.1)


def test_frames_outside_the_path_are_left_out(truth: Trajectory, seen: BoardTrack) -> None:
    assert registration_px(truth[1:], seen, BOARD, CAMERA, WORLD_T_BOARD).shape == (2,)
