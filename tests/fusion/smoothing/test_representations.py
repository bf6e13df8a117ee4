"""Laws of the representation protocol, on all seven of them."""

import numpy as np
import pytest

from motorcade.fusion.smoothing.representations import (
    REPRESENTATIONS,
    Representation,
    representation_named,
    restored,
)
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

CHOSEN = pytest.mark.parametrize("representation", REPRESENTATIONS.values(), ids=REPRESENTATIONS)
SCALED = pytest.mark.parametrize("scaled", [False, True], ids=["rigid", "scaled"])


def path(rng: np.random.Generator, scaled: bool, count: int = 400) -> Motor | Similarity:
    """A path that wanders through all orientations, half turns and gimbal lock among them."""
    steps = 0.3 * rng.standard_normal((count, 6))
    poses = [Motor.random(rng)]
    for step in steps[1:]:
        poses.append(poses[-1] @ Motor.from_twist(step))
    motors = Motor.stack(poses)
    if not scaled:
        return motors
    scale = np.exp(0.2 * np.sin(0.1 * np.arange(count)))
    return Similarity.from_motor_scale(motors, scale)


def distance(a: Motor | Similarity, b: Motor | Similarity) -> FloatArray:
    if isinstance(a, Motor):
        a = Similarity.from_motor_scale(a)
    if isinstance(b, Motor):
        b = Similarity.from_motor_scale(b)
    return np.linalg.norm((a.inverse() @ b).as_twist(), axis=-1)


def dimensions(representation: Representation, scaled: bool) -> tuple[int, int]:
    d = {"motor": 6, "similarity": 7, "rotor": 6, "dual_quaternion": 8, "quaternion": 7}
    D = {"motor": 8, "similarity": 12, "rotor": 7, "dual_quaternion": 8, "quaternion": 7}
    more = int(scaled and representation.scale_beside)
    return D.get(representation.name, 6) + more, d.get(representation.name, 6) + more


@CHOSEN
@SCALED
def test_poses_come_back_from_their_coordinates(
    representation: Representation, scaled: bool, rng: np.random.Generator
) -> None:
    poses = path(rng, scaled)
    coordinates = representation.coordinates(poses)
    assert coordinates.shape == (len(poses), dimensions(representation, scaled)[0])
    assert distance(representation.poses(coordinates), poses).max() < 1e-7
    back = representation.poses(coordinates.reshape(20, 20, -1))
    assert back.shape == (20, 20)


@CHOSEN
@SCALED
def test_moving_by_a_difference_arrives(
    representation: Representation, scaled: bool, rng: np.random.Generator
) -> None:
    coordinates = representation.coordinates(path(rng, scaled))
    x, base = coordinates[:-1], coordinates[1:]
    vector = representation.local(x, base)
    assert vector.shape == (len(x), dimensions(representation, scaled)[1])
    arrived = representation.retract(base, vector)
    assert distance(representation.poses(arrived), representation.poses(x)).max() < 1e-9
    again = representation.local(arrived, base)
    np.testing.assert_allclose(again, vector, rtol=0, atol=1e-9)


@CHOSEN
@SCALED
def test_nothing_moves_by_nothing(
    representation: Representation, scaled: bool, rng: np.random.Generator
) -> None:
    x = representation.coordinates(path(rng, scaled))
    vector = representation.local(x, x)
    np.testing.assert_allclose(vector, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(representation.retract(x, vector), x, rtol=0, atol=1e-12)


@CHOSEN
@SCALED
def test_differences_broadcast_over_batches(
    representation: Representation, scaled: bool, rng: np.random.Generator
) -> None:
    coordinates = representation.coordinates(path(rng, scaled, 30))
    table = representation.local(coordinates[:, None], coordinates[None, :5])
    for i in range(5):
        np.testing.assert_allclose(
            table[:, i], representation.local(coordinates, coordinates[i]), atol=1e-12
        )


@CHOSEN
@SCALED
def test_a_path_is_written_down_as_its_poses_follow_each_other(
    representation: Representation, scaled: bool, rng: np.random.Generator
) -> None:
    poses = path(rng, scaled)
    whole = representation.coordinates(poses)
    previous = whole[0]
    for i in range(1, len(poses)):
        alone = representation.coordinates(poses[i : i + 1])[0]
        previous = representation.continued(alone, previous)
        np.testing.assert_allclose(previous, whole[i], rtol=0.0, atol=1e-14)  # turns are summed


@pytest.mark.parametrize("name", ["quaternion", "dual_quaternion", "euler_unwrapped"])
def test_those_that_follow_never_leap(name: str, rng: np.random.Generator) -> None:
    axis = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    turns = Motor.from_twist(np.linspace(0.0, 30.0, 600)[:, None] * axis)
    shuffled = Motor(turns.coefficients * rng.choice([-1.0, 1.0], (600, 1)))
    coordinates = REPRESENTATIONS[name].coordinates(shuffled)
    assert np.abs(np.diff(coordinates, axis=0)).max() < 0.06
    assert np.abs(np.diff(REPRESENTATIONS["euler"].coordinates(shuffled), axis=0)).max() > 6.0


@CHOSEN
def test_rigid_paths_stay_rigid(representation: Representation, rng: np.random.Generator) -> None:
    poses = path(rng, False)
    trajectory = Trajectory(np.arange(len(poses)), poses, "map", "head")
    made = restored(representation, representation.coordinates(poses), trajectory)
    assert isinstance(made.poses, Motor)
    assert (made.parent, made.child) == ("map", "head")
    assert distance(made.poses, poses).max() < 1e-7


def test_twists_of_motors_do_not_depend_on_the_world(rng: np.random.Generator) -> None:
    motor, similarity = REPRESENTATIONS["motor"], REPRESENTATIONS["similarity"]
    poses, world = path(rng, False), Motor.random(rng)
    for one in (motor, similarity):
        x, y = one.coordinates(poses), one.coordinates(world @ poses)
        here, there = one.local(x[1:], x[:-1]), one.local(y[1:], y[:-1])
        np.testing.assert_allclose(here, there, atol=1e-11)


def test_single_precision_is_computed_in_double(rng: np.random.Generator) -> None:
    poses = path(rng, False)
    assert isinstance(poses, Motor)
    for one in REPRESENTATIONS.values():
        assert one.coordinates(poses.astype(np.float32)).dtype == np.float64


def test_unknown_names_are_refused_with_those_there_are() -> None:
    with pytest.raises(ValueError, match=r"representation: expected one of motor,.*got 'matrix'"):
        representation_named("matrix")


@pytest.mark.parametrize("name", ["quaternion", "dual_quaternion"])
def test_averages_that_cancel_are_refused(name: str) -> None:
    one = REPRESENTATIONS[name]
    x = one.coordinates(Motor.identity((1,)))
    with pytest.raises(ValueError, match="non-zero"):
        one.retract(x, -x)
