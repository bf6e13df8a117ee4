"""A print that is not flat is found by views that had no part in it, and what else bends is not."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import BoardTrack, Camera, Checkerboard
from motorcade.tracking.board_tracking.flatness import bent_track, print_shape
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.measurements import MarkerObservation, PoseMeasurements
from motorcade.tracking.pose import planar_candidates, refine

BOARD = Checkerboard(8, 6, 0.03)
CAMERA = Camera(1280, 720, 900.0, 900.0, 640.0, 360.0)
NOISE_PX = 0.2


def looking_at_the_board(rng: np.random.Generator, count: int) -> Motor:
    """``board_T_camera`` from up to 50 degrees aside, 0.4 to 0.6 m away."""
    poses = []
    middle = BOARD.points_m.mean(axis=0)
    low, high = (0.0, 0.0, 0.4), (0.9, 2.0 * np.pi, 0.6)
    for tilt, around, away in rng.uniform(low, high, (count, 3)):
        aside = Rotor.from_rotation_vector(tilt * np.array([np.cos(around), np.sin(around), 0.0]))
        turned = aside @ Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
        poses.append(
            Motor.from_rotor_translation(turned, middle - away * turned.apply([0.0, 0.0, 1.0]))
        )
    return Motor.stack(poses)


def from_one_side(rng: np.random.Generator, count: int) -> Motor:
    """``board_T_camera`` of a camera that is held still, but for half a degree and 5 mm."""
    held = looking_at_the_board(rng, 1)[0]
    turned = 0.01 * rng.standard_normal((count, 3))
    shake = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(turned), 0.005 * rng.standard_normal((count, 3))
    )
    return held @ shake


def tracked(
    rng: np.random.Generator,
    points_m: np.ndarray,
    seen_by: Camera = CAMERA,
    views: Callable[[np.random.Generator, int], Motor] = looking_at_the_board,
) -> tuple[BoardTrack, Motor]:
    """The track of a board that is stated flat, where its corners really lie at `points_m`."""
    truth, observations, refined = views(rng, 40), [], []
    ids = np.arange(len(points_m))
    for row, pose in enumerate(truth):
        px = seen_by.project(pose.inverse().apply(points_m))
        px = px + NOISE_PX * rng.standard_normal(px.shape)
        corners = BoardCorners(ids, px, BOARD.points_m)
        both = planar_candidates(corners, CAMERA)
        observations.append(MarkerObservation(row, ids, px, both.world_T_camera, both.error_px))
        refined.append(refine(corners, CAMERA, both.world_T_camera[0]))
    trajectory = Trajectory(
        np.arange(len(truth)), Motor.stack([pose.world_T_camera for pose in refined])
    )
    measured = PoseMeasurements(trajectory, np.stack([pose.covariance for pose in refined]))
    states = np.full(len(truth), "tracked")
    errors = np.array([pose.error_px for pose in refined])
    return BoardTrack(trajectory.time_ns, states, tuple(observations), measured, errors), truth


def curled(rng: np.random.Generator, share: float) -> np.ndarray:
    """Corners of a print rolled about a random axis, its rim so much of its width off."""
    flat = BOARD.points_m
    about = rng.uniform(0.0, np.pi)
    along = (flat - flat.mean(axis=0)) @ [np.cos(about), np.sin(about), 0.0]
    height = share * max(BOARD.size_m) * (along / np.abs(along).max()) ** 2
    return np.asarray(flat + height[:, None] * (0.0, 0.0, 1.0))


@pytest.mark.parametrize("seed", range(4))
def test_a_curled_print_is_found_and_its_poses_are_nearer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true_m = curled(rng, 0.03)
    track, truth = tracked(rng, true_m)
    bent, corners_m, shape = bent_track(track, BOARD.points_m, CAMERA)
    assert shape is not None
    assert shape.is_bent
    assert shape.bent_px < 0.5 * shape.flat_px
    assert np.median(bent.error_px) < 1.3 * np.sqrt(2.0) * NOISE_PX < np.median(track.error_px)
    plane = np.column_stack([np.ones(len(true_m)), BOARD.points_m[:, :2]])  # goes to the poses
    off = corners_m[:, 2] - true_m[:, 2]
    off = off - plane @ np.linalg.lstsq(plane, off, rcond=None)[0]
    assert np.sqrt(np.mean(off**2)) < 0.1 * np.ptp(true_m[:, 2])
    # World frames of both may differ by that plane: distances between cameras may not.
    steps = [
        np.linalg.norm(np.diff(motors.translation_m, axis=0), axis=1)
        for motors in (
            truth,
            bent.measurements.trajectory.motors,
            track.measurements.trajectory.motors,
        )
    ]
    assert np.median(np.abs(steps[1] - steps[0])) < np.median(np.abs(steps[2] - steps[0]))


@pytest.mark.parametrize("seed", range(6))
def test_a_flat_print_stays_as_it_is(seed: int) -> None:
    track, _ = tracked(np.random.default_rng(100 + seed), BOARD.points_m)
    bent, corners_m, shape = bent_track(track, BOARD.points_m, CAMERA)
    assert shape is not None
    assert not shape.is_bent
    assert bent is track
    assert corners_m is BOARD.points_m


@pytest.mark.parametrize("seed", range(4))
def test_squares_that_are_none_and_a_lens_that_bends_are_no_curl(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    stretched = BOARD.points_m * (1.02, 1.0, 1.0)
    shape = print_shape(tracked(rng, stretched)[0], BOARD.points_m, CAMERA)
    assert shape is not None
    assert not shape.is_bent
    barrel = Camera(1280, 720, 900.0, 900.0, 640.0, 360.0, "radtan", (-0.08, 0.0, 0.0, 0.0))
    shape = print_shape(tracked(rng, BOARD.points_m, barrel)[0], BOARD.points_m, CAMERA)
    assert shape is not None
    assert not shape.is_bent


@pytest.mark.parametrize("seed", [9018, *range(300, 308)])
def test_a_lens_that_bends_is_no_curl_from_one_side_either(seed: int) -> None:
    rng = np.random.default_rng(seed)
    terms = (float(rng.choice([-0.15, -0.08, 0.08])), 0.0, 0.0, 0.0)
    lens = Camera(1280, 720, 900.0, 900.0, 640.0, 360.0, "radtan", terms)
    shape = print_shape(
        tracked(rng, BOARD.points_m, lens, from_one_side)[0], BOARD.points_m, CAMERA
    )
    assert shape is not None
    assert not shape.is_bent


def test_few_views_tell_nothing() -> None:
    track, _ = tracked(np.random.default_rng(7), curled(np.random.default_rng(7), 0.03))
    few = BoardTrack(
        track.time_ns[:6],
        track.states[:6],
        track.observations[:6],
        PoseMeasurements(track.measurements.trajectory[:6], track.measurements.covariance[:6]),
        track.error_px[:6],
    )
    assert bent_track(few, BOARD.points_m, CAMERA)[2] is None
