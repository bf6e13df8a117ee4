"""Trajectories: what is refused, how poses lie between stamps, how they are kept in files."""

import copy
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, ScrewPath, Similarity, Trajectory, Versor
from motorcade.ga.files import FileError

Distance = Callable[[Versor, Versor], float]
START_NS = 1_403_715_273_262_142_976


@pytest.fixture(params=[Motor, Similarity])
def trajectory(request: pytest.FixtureRequest, rng: np.random.Generator) -> Trajectory:
    stamps = START_NS + np.cumsum(rng.integers(1, 90_000_000, 40))
    return Trajectory(stamps, request.param.random(rng, (40,)), "world", "imu")


@pytest.mark.parametrize("stamps", [[3, 2, 1], [1, 1, 2], [1, 3, 3]])
def test_stamps_that_do_not_increase_are_refused(stamps: list[int]) -> None:
    with pytest.raises(ValueError, match="expected strictly increasing stamps, got"):
        Trajectory(np.array(stamps), Motor.identity((3,)))


def test_the_place_of_the_bad_stamp_is_named() -> None:
    with pytest.raises(ValueError, match="got 15 at index 2 after 20"):
        Trajectory(np.array([10, 20, 15]), Motor.identity((3,)))


@pytest.mark.parametrize(
    "stamps",
    [
        np.array([0.0, 1.0]),
        np.array([False, True]),
        np.array(["a", "b"]),
        np.array([1, 2], dtype=np.uint64),
    ],
)
def test_stamps_that_are_no_signed_integers_are_refused(stamps: np.ndarray) -> None:
    with pytest.raises(ValueError, match="time_ns: expected integer nanoseconds, got dtype"):
        Trajectory(stamps, Motor.identity((2,)))


@pytest.mark.parametrize("shape", [(), (2,), (4,), (3, 1)])
def test_lengths_that_differ_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"Trajectory.poses: expected shape \(3,\)"):
        Trajectory(np.array([1, 2, 3]), Motor.identity(shape))


def test_arrays_are_no_poses() -> None:
    with pytest.raises(ValueError, match="expected a Motor or a Similarity, got ndarray"):
        Trajectory(np.array([1]), np.zeros((1, 8)))


@pytest.mark.parametrize("stamps", [np.zeros(0, dtype=np.int64), np.array(5), np.ones((2, 2), int)])
def test_stamps_of_the_wrong_shape_are_refused(stamps: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"expected shape \(N,\) with N >= 1"):
        Trajectory(stamps, Motor.identity(stamps.shape))


def test_stamps_are_met_exactly(trajectory: Trajectory, distance: Distance) -> None:
    assert distance(trajectory.at(trajectory.time_ns), trajectory.poses) < 1e-14


def test_between_stamps_the_pose_is_on_the_screw(
    trajectory: Trajectory, distance: Distance
) -> None:
    left, right = trajectory.time_ns[6], trajectory.time_ns[7]
    middle = left + (right - left) // 3
    expected = trajectory.poses[6].interpolate(
        trajectory.poses[7], float(middle - left) / float(right - left)
    )
    assert distance(trajectory.at(middle), expected) < 1e-15
    assert trajectory.at(np.full((2, 3), middle)).shape == (2, 3)


@pytest.mark.parametrize("off", [-1, 1])
def test_times_outside_the_span_are_refused(trajectory: Trajectory, off: int) -> None:
    edge = int(trajectory.time_ns[-1 if off > 0 else 0])
    trajectory.at(edge)
    with pytest.raises(ValueError, match=rf"expected stamps in \[.*\], got {edge + off} and 0"):
        trajectory.at([edge, edge + off])


def test_times_in_float_are_refused(trajectory: Trajectory) -> None:
    with pytest.raises(ValueError, match="expected integer nanoseconds"):
        trajectory.at(1.4e18)


def test_one_pose_makes_a_trajectory() -> None:
    one = Trajectory(np.array([7]), Motor.identity((1,)))
    assert one.duration_s == 0.0
    assert one.at(7).shape == ()
    with pytest.raises(ValueError, match="expected stamps in"):
        one.at(8)


def test_resampling_at_the_own_stamps_changes_nothing(
    trajectory: Trajectory, distance: Distance
) -> None:
    again = trajectory.resampled(trajectory.time_ns)
    assert (again.parent, again.child) == ("world", "imu")
    assert distance(again.poses, trajectory.poses) < 1e-14


@pytest.mark.parametrize(
    ("rate_hz", "offsets"),
    [
        (2.0, [0, 500, 1000]),
        (3.0, [0, 333, 667, 1000]),
        (0.4, [0]),
        (1.0, [0, 1000]),
        (0.8, [0]),
        (1e3 / 999, [0, 999]),
    ],
)
def test_even_stamps_start_at_the_first_and_stay_inside(rate_hz: float, offsets: list[int]) -> None:
    path = Trajectory(START_NS + np.array([0, 1_000_000_000]), Motor.identity((2,)), "map", "imu")
    even = path.at_rate(rate_hz)
    np.testing.assert_array_equal(np.rint((even.time_ns - START_NS) / 1e6), offsets)
    assert (even.parent, even.child) == ("map", "imu")


def test_even_stamps_have_the_poses_between(trajectory: Trajectory, distance: Distance) -> None:
    even = trajectory.at_rate(37.0)
    assert np.ptp(np.diff(even.time_ns)) <= 1
    assert distance(even.poses, trajectory.at(even.time_ns)) == 0.0
    assert trajectory.time_ns[-1] - even.time_ns[-1] < 1e9 / 37.0


def test_rates_of_one_pose_a_nanosecond_are_the_last() -> None:
    path = Trajectory(START_NS + np.array([0, 7]), Motor.identity((2,)))
    np.testing.assert_array_equal(path.at_rate(1e9).time_ns, START_NS + np.arange(8))
    for rate_hz in (0.0, -1.0, 1.001e9, np.nan, np.inf):
        with pytest.raises(
            ValueError, match=r"rate_hz: expected a positive number from 1e-9 to 1e9"
        ):
            path.at_rate(rate_hz)


def test_a_trajectory_tells_its_frames_length_and_span() -> None:
    path = Trajectory(np.array([5, 1_250_000_005]), Motor.identity((2,)), "map", "imu")
    assert repr(path) == "Trajectory(map_T_imu, 2 poses, 1.250 s)"


def test_another_format_of_file_is_named(trajectory: Trajectory, tmp_path: Path) -> None:
    np.savez(tmp_path / "next.npz", format=np.array("motorcade trajectory 2"))
    told = "expected the format 'motorcade trajectory 1', got 'motorcade trajectory 2'"
    with pytest.raises(ValueError, match=told):
        Trajectory.load(tmp_path / "next.npz")


def test_frames_move_by_composition(
    trajectory: Trajectory, rng: np.random.Generator, distance: Distance
) -> None:
    kind = type(trajectory.poses)
    map_T_world, imu_T_camera = kind.random(rng), kind.random(rng)
    moved = trajectory.transformed_by(map_T_world, imu_T_camera, parent="map", child="camera")
    assert (moved.parent, moved.child) == ("map", "camera")
    assert distance(moved.poses, map_T_world @ trajectory.poses @ imu_T_camera) == 0.0
    same = trajectory.transformed_by()
    assert (same.parent, same.child) == ("world", "imu")
    np.testing.assert_array_equal(same.poses.coefficients, trajectory.poses.coefficients)


def test_a_motor_moves_similarities_and_a_similarity_scales_motors(
    trajectory: Trajectory, rng: np.random.Generator
) -> None:
    motor, similarity = Motor.random(rng), Similarity.random(rng)
    scaled = trajectory.transformed_by(similarity, motor).poses
    assert isinstance(scaled, Similarity)
    matrix = similarity.as_matrix() @ trajectory.poses.as_matrix() @ motor.as_matrix()
    np.testing.assert_allclose(scaled.as_matrix(), matrix, rtol=0, atol=1e-13)
    moved = trajectory.transformed_by(motor)
    assert type(moved.poses) is type(trajectory.poses)


def test_rigid_leaves_out_the_scale_and_nothing_else(trajectory: Trajectory) -> None:
    rigid, poses = trajectory.rigid, trajectory.poses
    assert (rigid.parent, rigid.child) == (trajectory.parent, trajectory.child)
    np.testing.assert_array_equal(rigid.time_ns, trajectory.time_ns)
    assert isinstance(rigid.poses, Motor)
    np.testing.assert_allclose(rigid.poses.translation_m, poses.translation_m, atol=1e-14)
    assert np.all(rigid.poses.rotor.isclose(poses.rotor))
    assert rigid.rigid is rigid


def test_what_wants_rigid_poses_refuses_similarities(trajectory: Trajectory) -> None:
    stamp = trajectory.time_ns[3]
    if isinstance(trajectory.poses, Motor):
        assert trajectory.motors is trajectory.poses
        assert isinstance(trajectory.motors_at(stamp), Motor)
        return
    for rigid in (
        lambda: trajectory.motors,
        lambda: trajectory.motors_at(stamp),
        lambda: ScrewPath(trajectory).twists(0.0),
    ):
        with pytest.raises(ValueError, match="expected rigid poses, got similarities"):
            rigid()


def test_parts_keep_stamps_and_names(trajectory: Trajectory) -> None:
    for part in (
        trajectory[3:20:2],
        trajectory[np.arange(3, 20, 2)],
        trajectory[np.isin(np.arange(40), np.arange(3, 20, 2))],
    ):
        np.testing.assert_array_equal(part.time_ns, trajectory.time_ns[3:20:2])
        assert part.child == "imu"
    with pytest.raises(ValueError, match="strictly increasing"):
        trajectory[::-1]
    with pytest.raises(ValueError, match="N >= 1"):
        trajectory[:0]
    with pytest.raises(TypeError, match="expected a slice"):
        trajectory[3]


def test_seconds_count_from_the_first_stamp(trajectory: Trajectory) -> None:
    assert trajectory.time_s[0] == 0.0
    assert trajectory.time_s[-1] == pytest.approx(trajectory.duration_s, abs=1e-12)
    expected = (int(trajectory.time_ns[-1]) - int(trajectory.time_ns[0])) / 10**9
    assert trajectory.duration_s == pytest.approx(expected, rel=1e-15)


def test_files_return_every_bit(trajectory: Trajectory, tmp_path: Path) -> None:
    trajectory.save(tmp_path / "one.npz")
    Trajectory.load(tmp_path / "one.npz").save(tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    again = Trajectory.load(tmp_path / "two.npz")
    np.testing.assert_array_equal(again.time_ns, trajectory.time_ns)
    np.testing.assert_array_equal(again.poses.coefficients, trajectory.poses.coefficients)
    assert (again.parent, again.child) == ("world", "imu")
    assert type(again.poses) is type(trajectory.poses)


def test_files_are_plain_arrays_for_numpy(trajectory: Trajectory, tmp_path: Path) -> None:
    trajectory.save(tmp_path / "plain.npz")
    with np.load(tmp_path / "plain.npz", allow_pickle=False) as stored:
        np.testing.assert_array_equal(stored["coefficients"], trajectory.poses.coefficients)


def test_other_names_than_npz_are_refused(trajectory: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"expected a name ending in \.npz"):
        trajectory.save(tmp_path / "poses.txt")


def test_files_that_are_no_trajectories_are_refused(trajectory: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / "poses.npz"
    trajectory.save(path)
    whole = path.read_bytes()
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    (tmp_path / "text.npz").write_text("not an archive")
    (tmp_path / "empty.npz").write_bytes(b"")
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    np.savez(tmp_path / "pickled.npz", format=np.array([{}], dtype=object))
    for name in ("other", "text", "cut", "pickled"):
        with pytest.raises(ValueError, match=rf"{name}.npz: not a saved trajectory"):
            Trajectory.load(tmp_path / f"{name}.npz")
    with pytest.raises(FileError, match="the file is empty"):
        Trajectory.load(tmp_path / "empty.npz")
    with pytest.raises(FileError, match="the file is missing"):
        Trajectory.load(tmp_path / "absent.npz")


def test_trajectories_are_frozen(trajectory: Trajectory) -> None:
    mine = np.array(trajectory.time_ns)
    kept = Trajectory(mine, trajectory.poses)
    mine[0] = 0
    assert kept.time_ns[0] == trajectory.time_ns[0]
    for one in (kept, copy.deepcopy(kept), pickle.loads(pickle.dumps(kept))):
        with pytest.raises(ValueError, match="read-only"):
            one.time_ns[0] = 0


def test_stamps_that_seconds_cannot_tell_apart_have_no_seconds() -> None:
    path = Trajectory(np.array([0, 10**18, 10**18 + 1]), Motor.identity((3,)))
    with pytest.raises(ValueError, match=r"two 1 ns apart after 1e\+09 s; cut the trajectory"):
        _ = path.time_s
    assert path[1:].time_s.tolist() == [0.0, 1e-9]
