"""Edits of trajectories: evo's own functions as witness, laws, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from evo.core import lie_algebra
from evo.core import trajectory as evo_trajectory

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.trajectory_edits import (
    downsampled,
    inverted,
    merged,
    motion_filtered,
    path_lengths_m,
    propagated,
    scaled,
    shifted,
)


def walk(rng: np.random.Generator, count: int = 200, turn_rad: float = 0.1) -> Trajectory:
    """A random walk with steps of about a decimetre."""
    steps = Rotor.from_rotation_vector(turn_rad * rng.standard_normal((count, 3)))
    turns = [Rotor.random(rng)]
    for step in steps[1:]:
        turns.append(turns[-1] @ step)
    place = np.cumsum(0.1 * rng.standard_normal((count, 3)), axis=0)
    stamps = np.cumsum(rng.integers(10**7, 10**8, count))
    return Trajectory(stamps, Motor.from_rotor_translation(Rotor.stack(turns), place))


def evos(path: Trajectory) -> evo_trajectory.PoseTrajectory3D:
    wxyz, place = path.motors.as_quaternion_translation()
    return evo_trajectory.PoseTrajectory3D(np.array(place), np.array(wxyz), 1e-9 * path.time_ns)


def assert_same(ours: Trajectory, theirs: evo_trajectory.PoseTrajectory3D) -> None:
    assert len(ours) == theirs.num_poses
    np.testing.assert_allclose(ours.motors.as_matrix(), np.array(theirs.poses_se3), atol=1e-9)
    np.testing.assert_allclose(1e-9 * ours.time_ns, theirs.timestamps, atol=1e-9)


@pytest.mark.parametrize("most", [1, 2, 7, 199, 200, 1000])
def test_downsampled_keeps_what_evo_keeps(rng: np.random.Generator, most: int) -> None:
    path = walk(rng)
    theirs = evos(path)
    theirs.downsample(most)
    assert_same(downsampled(path, most), theirs)


@pytest.mark.parametrize(("distance_m", "angle_rad"), [(0.5, 0.3), (0.0, 9.0), (1e9, 0.2), (3, 9)])
def test_motion_filtered_keeps_what_evo_keeps(
    rng: np.random.Generator, distance_m: float, angle_rad: float
) -> None:
    path = walk(rng)
    theirs = evos(path)
    theirs.motion_filter(distance_m, angle_rad)
    ours = motion_filtered(path, distance_m, angle_rad)
    assert_same(ours, theirs)
    assert 0 < len(ours) < len(path) or distance_m == 0.0


def test_merged_is_evos_merge(rng: np.random.Generator) -> None:
    path = walk(rng)
    parts = [path[1::3], path[::3], path[2::3]]
    assert_same(merged(parts), evo_trajectory.merge([evos(one) for one in parts]))
    assert_same(merged(parts), evos(path))


def test_merged_keeps_the_first_of_equal_stamps_and_every_scale(rng: np.random.Generator) -> None:
    path = walk(rng, 5)
    moved = path.transformed_by(Motor.from_translation([1.0, 0.0, 0.0]))
    assert_same(merged([path, moved]), evos(path))
    grown = Trajectory(path.time_ns + 1, Similarity.from_motor_scale(path.motors, 2.0))
    scale = merged([path, grown]).poses
    assert isinstance(scale, Similarity)
    np.testing.assert_allclose(scale.scale, [1.0, 2.0] * 5)


def test_propagated_drifts_as_evos_does(rng: np.random.Generator) -> None:
    path, right = walk(rng), Motor.random(rng)
    theirs = evos(path)
    theirs.transform(right.as_matrix(), right_mul=True, propagate=True)
    ours = propagated(path, right)
    size = np.abs(theirs.positions_xyz).max()
    np.testing.assert_allclose(
        ours.motors.as_matrix(), np.array(theirs.poses_se3), atol=1e-9 * size
    )
    assert_same(propagated(path, Motor.identity()), evos(path))


def test_scaled_and_length_are_evos(rng: np.random.Generator) -> None:
    path = walk(rng)
    theirs = evos(path)
    np.testing.assert_allclose(path_lengths_m(path), theirs.distances)
    theirs.scale(2.5)
    assert_same(scaled(path, 2.5), theirs)
    assert path_lengths_m(path[:1]).tolist() == [0.0]


def test_inverted_is_the_inverse_and_its_own_inverse(rng: np.random.Generator) -> None:
    path = walk(rng)
    turned = inverted(path)
    assert (turned.parent, turned.child) == (path.child, path.parent)
    expected = [lie_algebra.se3_inverse(one) for one in evos(path).poses_se3]
    np.testing.assert_allclose(turned.motors.as_matrix(), expected, atol=1e-12)
    assert_same(inverted(turned), evos(path))


def test_shifted_moves_the_stamps_alone(rng: np.random.Generator) -> None:
    path = walk(rng)
    np.testing.assert_array_equal(shifted(path, -7).time_ns, path.time_ns - 7)


def test_what_is_refused(rng: np.random.Generator) -> None:
    path = walk(rng, 3)
    other = Trajectory(path.time_ns, path.poses, "map", "camera")
    grown = Trajectory(path.time_ns, Similarity.from_motor_scale(path.motors, 2.0))
    for problem, edit in {
        "expected 1 pose or more, got 0": lambda: downsampled(path, 0),
        "distance_m: expected 0 or more, got nan": lambda: motion_filtered(path, np.nan, 1.0),
        "angle_rad: expected 0 or more, got -1": lambda: motion_filtered(path, 1.0, -1.0),
        "expected 2 or more poses, got 1": lambda: motion_filtered(path[:1], 1.0, 1.0),
        "expected one trajectory or more, got none": lambda: merged([]),
        "expected poses world_T_camera, got map_T_camera": lambda: merged([path, other]),
        "within 146 years": lambda: shifted(path, 2**62 - 1),
        "expected less than 2": lambda: shifted(path, 2**62),
        "expected a factor above 0, got 0": lambda: scaled(path, 0.0),
        "expected rigid poses": lambda: scaled(grown, 2.0),
    }.items():
        with pytest.raises(ValueError, match=problem):
            edit()
