"""Poses of other libraries go in and come out as they came, smoothed as trajectories are."""

from __future__ import annotations

import datetime
import logging
import sys
import types

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smooth
from motorcade.fusion.smoothing.given import with_trajectories
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

STILL = np.tile([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], (5, 1))
MASKED = np.ma.masked_array(STILL, np.isin(np.arange(35), [7, 23]).reshape(5, 7))
NAN_ROWS = np.where(np.isin(np.arange(35), [7, 23]).reshape(5, 7), np.nan, STILL)
COLUMNS = ["x", "y", "z", "qx", "qy", "qz", "qw"]


def noisy(count: int = 40) -> Trajectory:
    true = MOTIONS["tumble"].sampled(30.0, (count - 1) / 30.0).rigid
    return Gaussian(0.005, 0.01).apply(true, np.random.default_rng(1))


def rows_of(path: Trajectory) -> FloatArray:
    wxyz, position_m = path.motors.as_quaternion_translation()
    return np.concatenate([position_m, wxyz[:, 1:], wxyz[:, :1]], axis=-1)


def unchanged(path: Trajectory) -> Trajectory:
    return path


def smoothed(path: Trajectory) -> Trajectory:
    return smooth(path, "gaussian")


def differs_in_rotation_and_position(ours: FloatArray, expected: FloatArray) -> tuple[float, float]:
    turned = Rotation.from_quat(ours[:, 3:]).inv() * Rotation.from_quat(expected[:, 3:])
    return float(turned.magnitude().max()), float(np.abs(ours[:, :3] - expected[:, :3]).max())


@pytest.mark.parametrize("signs", [False, True])
def test_rows_come_back_to_the_last_digits(signs: bool) -> None:
    """Signs that leap from row to row come back as they were."""
    path = noisy()
    rows = rows_of(path)
    if signs:
        rows[:, 3:] *= np.where(np.random.default_rng(2).random((len(rows), 1)) < 0.5, -1.0, 1.0)
    back = with_trajectories(rows, path.time_s, unchanged)
    np.testing.assert_allclose(back, rows, rtol=0.0, atol=1e-15)
    ours = with_trajectories(rows, path.time_s, smoothed)
    expected = rows_of(smooth(path, "gaussian"))
    assert max(differs_in_rotation_and_position(ours, expected)) < 1e-7


def test_rows_with_stamps_matrices_and_stacks() -> None:
    path = noisy()
    rows, expected = rows_of(path), rows_of(smooth(path, "gaussian"))
    stamped = np.column_stack([path.time_s, rows])
    ours = smooth(stamped, "gaussian")
    np.testing.assert_array_equal(ours[:, 0], path.time_s)
    assert max(differs_in_rotation_and_position(ours[:, 1:], expected)) < 1e-7
    matrices = path.motors.as_matrix()
    by_matrix = smooth(matrices, "gaussian", time_s=path.time_s)
    assert by_matrix.shape == (40, 4, 4)
    np.testing.assert_allclose(by_matrix, smooth(path, "gaussian").motors.as_matrix(), atol=1e-7)
    np.testing.assert_allclose(
        with_trajectories(matrices, path.time_s, unchanged), matrices, rtol=0.0, atol=2e-15
    )
    two = smooth(np.stack([rows, rows[::-1]]), "gaussian", time_s=path.time_s)
    assert two.shape == (2, 40, 7)
    assert max(differs_in_rotation_and_position(two[0], expected)) < 1e-7
    assert smooth(rows.astype(np.float32), "gaussian", time_s=path.time_s).dtype == np.float32


def test_lists_pairs_and_matrices_of_three_rows() -> None:
    path = noisy()
    rows, matrices = rows_of(path), path.motors.as_matrix()
    expected = with_trajectories(rows, path.time_s, smoothed)
    by_lists = with_trajectories(rows.tolist(), path.time_s, smoothed)
    assert isinstance(by_lists, list)
    np.testing.assert_allclose(by_lists, expected, atol=1e-12)
    by_arrays = with_trajectories(list(matrices), path.time_s, smoothed)
    by_three = with_trajectories(matrices[:, :3], path.time_s, smoothed)
    np.testing.assert_allclose(np.stack(by_arrays)[:, :3], by_three, atol=1e-12)
    np.testing.assert_allclose(by_three[:, :, 3], expected[:, :3], atol=1e-12)
    wxyz = rows[:, [6, 3, 4, 5]]
    for turns in (Rotor.from_quaternion(wxyz), Rotation.from_quat(rows[:, 3:])):
        positions, turned = with_trajectories((rows[:, :3], turns), path.time_s, smoothed)
        assert isinstance(turned, type(turns))
        xyzw = (
            turned.as_quaternion()[:, [1, 2, 3, 0]]
            if isinstance(turned, Rotor)
            else turned.as_quat()
        )
        both = np.column_stack([positions, xyzw])
        assert max(differs_in_rotation_and_position(both, expected)) < 1e-7


@pytest.mark.parametrize("name", ["handheld", "tumble", "screw"])
def test_the_order_of_quaternions_beside_positions_is_asked_for(name: str) -> None:
    """Neither order is told by the path: rotations from pose to pose are as large in both."""
    true = MOTIONS[name].sampled(30.0, 2.0).rigid
    wxyz, positions = true.motors.as_quaternion_translation()
    xyzw = wxyz[:, [1, 2, 3, 0]]
    steps = [
        (Rotor.from_quaternion(one[:-1]).inverse() @ Rotor.from_quaternion(one[1:])).angle()
        for one in (wxyz, xyzw)
    ]
    np.testing.assert_allclose(*steps, atol=1e-9)
    time_s = np.arange(len(wxyz)) / 30.0
    for given in (wxyz, xyzw, xyzw.tolist()):
        with pytest.raises(ValueError, match=r"give Rotor.from_quaternion.*Rotation.from_quat"):
            smooth((positions, given), time_s=time_s)
    by_rotor = smooth((positions, Rotor.from_quaternion(wxyz)), "gaussian", time_s=time_s)
    by_scipy = smooth((positions, Rotation.from_quat(xyzw)), "gaussian", time_s=time_s)
    back = by_rotor[1].as_quaternion()[:, [1, 2, 3, 0]]
    assert (Rotation.from_quat(back).inv() * by_scipy[1]).magnitude().max() < 1e-12
    with pytest.raises(ValueError, match="one beside each position, got shape"):
        smooth((positions, Rotor.from_quaternion(wxyz[1:])), time_s=time_s)


def test_columns_as_ros_names_them() -> None:
    pandas = pytest.importorskip("pandas")
    path = noisy()
    for before, mark in (("pose.pose.", "."), ("field.pose.", "."), ("", "_"), ("/pose/", "/")):
        turn = "orientation" if mark != "_" else "rotation"
        place = "position" if mark != "_" else "translation"
        names = [f"{before}{place}{mark}{axis}" for axis in "xyz"]
        names += [f"{before}{turn}{mark}{axis}" for axis in "xyzw"]
        table = pandas.DataFrame(rows_of(path), columns=names)
        table["field.header.stamp"] = path.time_ns + 1_700_000_000_000_000_000
        made = smooth(table, "gaussian")
        expected = smooth(rows_of(path), "gaussian", time_s=path.time_s)
        np.testing.assert_allclose(made[names], expected, atol=1e-9)
    twice = table.rename(columns=lambda name: f"other{name}").join(table)
    with pytest.raises(ValueError, match="expected the columns of one pose, got those of other"):
        smooth(twice, "gaussian", time_s=path.time_s)


def test_scipy_and_motors() -> None:
    path = noisy()
    expected = smooth(path, "gaussian", "rotor")
    transform = RigidTransform.from_matrix(path.motors.as_matrix())
    made = smooth(transform, "gaussian", "rotor", time_s=path.time_s)
    assert isinstance(made, RigidTransform)
    np.testing.assert_allclose(made.as_matrix(), expected.motors.as_matrix(), atol=1e-7)
    turned = Rotation.from_quat(rows_of(path)[:, 3:])
    made = smooth(turned, "gaussian", "rotor", time_s=path.time_s)
    assert isinstance(made, Rotation)
    both = (made.inv() * Rotation.from_quat(rows_of(expected)[:, 3:])).magnitude()
    assert both.max() < 1e-7
    motors = smooth(path.motors, "gaussian", time_s=path.time_s)
    assert isinstance(motors, Motor)
    by_name = smooth({"hand": path.motors, "head": path.motors}, "gaussian", time_s=path.time_s)
    np.testing.assert_array_equal(by_name["head"].coefficients, motors.coefficients)


def test_tables_keep_their_columns_and_index() -> None:
    pandas = pytest.importorskip("pandas")
    path = noisy()
    stamps = pandas.to_datetime(path.time_ns, utc=True)
    table = pandas.DataFrame(rows_of(path), columns=COLUMNS, index=stamps).assign(note="kept")
    made = smooth(table, "gaussian")
    assert list(made.columns) == [*COLUMNS, "note"]
    assert made.index.equals(table.index)
    expected = rows_of(smooth(path, "gaussian"))
    assert max(differs_in_rotation_and_position(made[COLUMNS].to_numpy(), expected)) < 1e-7
    by_column = table.reset_index(drop=True).assign(timestamp=path.time_s)
    again = smooth(by_column, "gaussian")[COLUMNS].to_numpy()
    assert max(differs_in_rotation_and_position(again, expected)) < 1e-6
    with pytest.raises(ValueError, match="none named qw; did you mean q_w"):
        smooth(table.rename(columns={"qw": "q_w"}))
    with pytest.raises(ValueError, match="time_s: expected a column named"):
        smooth(table.reset_index(drop=True))


def test_paths_of_evo_without_stamps() -> None:
    trajectory = pytest.importorskip("evo.core.trajectory")
    path = noisy()
    rows = rows_of(path)
    given = trajectory.PosePath3D(rows[:, :3], rows[:, [6, 3, 4, 5]])
    with pytest.raises(ValueError, match="expected the stamps of these poses, got none"):
        smooth(given)
    made = smooth(given, "gaussian", time_s=path.time_s)
    assert type(made) is trajectory.PosePath3D
    expected = smooth(path, "gaussian").motors.translation_m
    np.testing.assert_allclose(made.positions_xyz, expected, atol=1e-9)


def test_evo_and_gtsam() -> None:
    trajectory = pytest.importorskip("evo.core.trajectory")
    gtsam = pytest.importorskip("gtsam")
    path = noisy()
    rows, expected = rows_of(path), rows_of(smooth(path, "gaussian"))
    theirs = trajectory.PoseTrajectory3D(
        rows[:, :3], rows[:, [6, 3, 4, 5]], path.time_s, meta={"frame_id": "map"}
    )
    made = smooth(theirs, "gaussian")
    assert isinstance(made, trajectory.PoseTrajectory3D)
    assert made.meta == {"frame_id": "map"}
    np.testing.assert_array_equal(made.timestamps, path.time_s)
    ours = np.column_stack([made.positions_xyz, made.orientations_quat_wxyz[:, [1, 2, 3, 0]]])
    assert max(differs_in_rotation_and_position(ours, expected)) < 1e-6
    poses = [gtsam.Pose3(matrix) for matrix in path.motors.as_matrix()]
    made = smooth(poses, "gaussian", time_s=path.time_s)
    np.testing.assert_allclose(
        [one.matrix() for one in made], smooth(path, "gaussian").motors.as_matrix(), atol=1e-6
    )


def test_stamps_of_every_kind_are_the_same_stamps() -> None:
    """Seconds, datetimes with and without a zone, numpy's and whole nanoseconds of them."""
    path = noisy()
    zone = datetime.timezone(datetime.timedelta(hours=2))
    start = datetime.datetime(2026, 5, 4, 12, 0, tzinfo=zone)
    moments = [start + datetime.timedelta(milliseconds=33 * k) for k in range(len(path))]
    plain = [one.astimezone(datetime.UTC).replace(tzinfo=None) for one in moments]
    seen = []

    def keep(one: Trajectory) -> Trajectory:
        seen.append(one.time_ns)
        return one

    for stamps in (moments, plain, np.array(plain, dtype="datetime64[us]")):
        with_trajectories(path.motors, stamps, keep)
    with_trajectories(path.motors, [one.timestamp() for one in moments], keep)
    for other in seen[:3]:
        np.testing.assert_array_equal(other, seen[0])
    np.testing.assert_allclose(seen[3] - seen[3][0], seen[0] - seen[0][0], atol=300)


class Tensor:
    """As much of torch.Tensor as is asked of one."""

    device, __module__ = "cuda:1", "torch"

    def __init__(self, numbers: FloatArray) -> None:
        self.numbers, self.dtype, self.shape = numbers, numbers.dtype, numbers.shape

    def detach(self) -> Tensor:
        return self

    cpu = detach

    def numpy(self) -> FloatArray:
        return self.numbers

    def is_floating_point(self) -> bool:
        return self.dtype.kind == "f"

    def to(self, where: object) -> Tensor:
        if where == self.device:
            return self
        return Tensor(self.numbers.astype(where))


def test_what_torch_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stand-in, since torch itself is large: precision and shape come back, single or many."""
    stand_in = types.SimpleNamespace(
        from_numpy=Tensor, stack=lambda made: Tensor(np.stack([one.numbers for one in made]))
    )
    monkeypatch.setitem(sys.modules, "torch", stand_in)
    path = noisy()
    rows = rows_of(path)
    for given in (rows, rows.astype(np.float32), np.stack([rows, rows]), path.motors.as_matrix()):
        made = with_trajectories(Tensor(given), path.time_s, unchanged)
        assert isinstance(made, Tensor)
        assert made.dtype == given.dtype
        np.testing.assert_allclose(made.numbers, given, atol=1e-15 if given.itemsize == 8 else 1e-7)
    found = smooth(Tensor(rows), "gaussian", time_s=path.time_s, full=True)
    assert found.at([0.01, 0.5]).shape == (2, 7)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_tensors_come_back(precision: str) -> None:
    torch = pytest.importorskip("torch")
    path = noisy()
    rows = torch.tensor(rows_of(path), dtype=getattr(torch, precision))
    atol = 1e-15 if precision == "float64" else 1e-7
    for given in (rows, torch.stack([rows, rows]), torch.tensor(path.motors.as_matrix())):
        made = with_trajectories(given, path.time_s, unchanged)
        assert (made.dtype, made.device) == (given.dtype, given.device)
        assert torch.allclose(made, given, rtol=0.0, atol=max(atol, 2e-15))


def test_tensors_stay_tensors() -> None:
    torch = pytest.importorskip("torch")
    path = noisy()
    rows = rows_of(path)
    made = smooth(torch.tensor(np.stack([rows, rows])), "gaussian", time_s=path.time_s)
    assert made.shape == (2, 40, 7)
    expected = rows_of(smooth(path, "gaussian"))
    assert max(differs_in_rotation_and_position(made[0].numpy(), expected)) < 1e-7


def test_columns_that_are_nearly_named_right_are_told() -> None:
    pandas = pytest.importorskip("pandas")
    path = noisy()
    table = pandas.DataFrame(rows_of(path), columns=COLUMNS)
    for wrong, says in (
        (table.rename(columns={"x": "X"}), "none named x; did you mean X?"),
        (table.rename(columns={"x": "tx"}), "none named x; did you mean tx?"),
        (table.drop(columns="qw"), "none named qw; known here: none"),
        (table.assign(Time=path.time_s), "or time_s; did you mean Time?"),
        (table.assign(note=1), "an index of stamps, or time_s$"),
    ):
        with pytest.raises(ValueError, match=says.replace("?", r"\?")):
            smooth(wrong)


def test_columns_that_come_twice_or_hold_no_numbers_are_named() -> None:
    pandas = pytest.importorskip("pandas")
    path = noisy()
    table = pandas.DataFrame(rows_of(path), columns=COLUMNS).assign(time_s=path.time_s)
    twice = pandas.concat([table, table["x"]], axis=1)
    for wrong, says in (
        (twice, "poses: expected one column of a name, got 2 named x$"),
        (table.assign(qw="a"), "poses: expected numbers in column qw, could not convert"),
        (table.assign(qz=1j), "poses: expected real numbers in column qz, got complex"),
    ):
        with pytest.raises(ValueError, match=says):
            smooth(wrong)


def test_columns_of_zoned_datetimes_are_stamps() -> None:
    """The night in which clocks go back is as long as it is."""
    pandas = pytest.importorskip("pandas")
    path = noisy()
    start = pandas.Timestamp("2026-10-25T00:59:59.5", tz="UTC").value
    utc = pandas.to_datetime(path.time_ns - path.time_ns[0] + start, utc=True)
    table = pandas.DataFrame(rows_of(path), columns=COLUMNS)
    by_zone = table.assign(stamp=utc.tz_convert("Europe/Berlin"))
    assert len(set(by_zone["stamp"].dt.tz_localize(None).dt.hour)) == 1
    made = smooth(by_zone, "gaussian")
    expected = smooth(table, "gaussian", time_s=path.time_s)
    np.testing.assert_allclose(made[COLUMNS], expected[COLUMNS], atol=1e-9)
    assert made["stamp"].equals(by_zone["stamp"])


@pytest.mark.parametrize(
    ("stamps", "says"),
    [
        (["2026-01-01T12:00:00+02:00"] * 5, "got text such as '2026.*pandas.to_datetime reads it"),
        ([datetime.datetime(2026, 1, 1)] + [datetime.datetime.now(datetime.UTC)] * 4, "got both"),
        ([datetime.date(2026, 1, 1)] * 5, "expected seconds or datetimes, got date 2026-01-01"),
        ([None] * 5, "expected a moment for every pose, got None"),
    ],
)
def test_what_are_no_stamps_is_refused(stamps: list[object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        smooth(STILL, time_s=stamps)


@pytest.mark.parametrize(
    ("given", "time_s", "kind", "says"),
    [
        (np.zeros((5, 6)), np.arange(5.0), ValueError, r"expected an array \(N, 7\)"),
        (STILL, None, ValueError, "expected the stamps of these poses, got none"),
        (STILL, np.arange(4.0), ValueError, "expected 5 stamps"),
        (STILL, np.arange(5) * 33_333_333, ValueError, "divide nanoseconds by 1e9"),
        (STILL, np.array(["2026-01-01"] * 4 + ["NaT"], "datetime64[ns]"), ValueError, "got NaT"),
        (np.zeros((0, 7)), [], ValueError, "expected at least one"),
        (np.ones((5, 8)), np.arange(5.0), ValueError, "expected none beside rows"),
        (np.ones((5, 7)), np.arange(5.0), ValueError, "a length off by 1"),
        (np.ones((5, 4, 4)), np.arange(5.0), ValueError, "matrix"),
        (np.full((5, 7), np.nan), np.arange(5.0), ValueError, "finite"),
        (NAN_ROWS, np.arange(5.0), ValueError, "2 with NaN or infinity: 1, 3; leave"),
        (2.0 * np.eye(4)[None, :3], [0.0], ValueError, "which Similarity.from_matrix reads"),
        ((STILL[:, :3], STILL[:4, 3:]), np.arange(5.0), ValueError, "tell the order of their"),
        (["a", "b"], [0.0, 1.0], TypeError, "expected a Trajectory, an array"),
        (STILL, np.arange(5) / 30.0 + 1e10, ValueError, "divide milliseconds by 1e3, nanos"),
        (STILL, np.arange("2500", "2505", dtype="M8[Y]"), ValueError, "of 1970, got 2500"),
        (STILL, [datetime.datetime(2500, 1, 1 + k) for k in range(5)], ValueError, "of 1970"),
        (MASKED, np.arange(5.0), ValueError, "poses: expected .*, got 2 masked: 1, 3; leave"),
        (MASKED[None], np.arange(5.0), ValueError, "got 2 masked: 1, 3; leave"),
        (STILL, np.ma.masked_less(np.arange(5.0), 1.0), ValueError, "time_s: .* 1 masked: 0;"),
        (STILL + 1j, np.arange(5.0), ValueError, "poses: expected real numbers, got dtype complex"),
        ("poses.tum", None, TypeError, "expected a Trajectory, an array"),
    ],
)
def test_what_is_no_path_is_refused(given: object, time_s: object, kind: type, says: str) -> None:
    with pytest.raises(kind, match=says):
        smooth(given, time_s=time_s)


@pytest.mark.parametrize(("unit", "warned"), [(1.0, False), (1e3, True)])
def test_stamps_that_look_like_milliseconds_are_told(
    unit: float, warned: bool, rng: np.random.Generator, caplog: pytest.LogCaptureFixture
) -> None:
    path = Gaussian(0.005, 0.01).apply(MOTIONS["handheld"].sampled(30.0, 2.0).rigid, rng)
    with caplog.at_level(logging.WARNING, "motorcade.smooth"):
        smooth(rows_of(path), time_s=unit * path.time_s)
    assert ("stamps lie 33.3 s apart. Are they milliseconds?" in caplog.text) == warned


def test_near_misses_of_names_are_told() -> None:
    with pytest.raises(ValueError, match="did you mean robust_map"):
        smooth(noisy(), "robustmap")
    with pytest.raises(ValueError, match="did you mean sigma_s"):
        smooth(noisy(), "gaussian", sigma=0.1)
