"""Trajectory files: what is written comes back, other programs read it alike, faults have lines."""

import contextlib
import logging
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from evo.tools import file_interface
from hypothesis import given, settings
from hypothesis import strategies as st

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.tables import stamp_ns
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory

FORMATS = ("tum", "euroc", "kitti")


def some_trajectory(seed: int, count: int, extent_m: float, start_ns: int) -> Trajectory:
    rng = np.random.default_rng(seed)
    steps = rng.integers(1, 10**8, count)
    return Trajectory(start_ns + np.cumsum(steps), Motor.random(rng, (count,), extent_m))


def pose_difference(a: Motor, b: Motor) -> float:
    """Largest difference of the matrices, translations relative to their size."""
    extent = max(1.0, float(np.abs(a.translation_m).max()))
    gap = np.abs(a.as_matrix() - b.as_matrix())
    return max(float(gap[:, :3, :3].max()), float(gap[:, :3, 3].max()) / extent)


def write_lines(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("fmt", FORMATS)
@settings(deadline=None, max_examples=25)
@given(
    seed=st.integers(0, 2**32),
    count=st.integers(1, 20),
    extent_m=st.sampled_from([0.0, 1e-6, 1.0, 1e4]),
    start_ns=st.sampled_from([-(10**12), -5, 0, 1_403_715_273_262_142_976, 2**61]),
)
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory,
    fmt: str,
    seed: int,
    count: int,
    extent_m: float,
    start_ns: int,
) -> None:
    made = some_trajectory(seed, count, extent_m, start_ns)
    path = tmp_path_factory.mktemp("round") / f"path.{fmt}"
    write_trajectory(made, path, fmt)
    back = read_trajectory(path, rate_hz=30.0 if fmt == "kitti" else None)
    assert pose_difference(back.poses, made.poses) < 2e-15
    if fmt != "kitti":
        assert np.array_equal(back.time_ns, made.time_ns)


def test_evo_reads_what_we_write(tmp_path: Path) -> None:
    made = some_trajectory(1, 50, 3.0, 1_305_031_098_665_900_001)
    for fmt in FORMATS:
        write_trajectory(made, tmp_path / fmt, fmt)
    tum = file_interface.read_tum_trajectory_file(tmp_path / "tum")
    euroc = file_interface.read_euroc_csv_trajectory(tmp_path / "euroc")
    kitti = file_interface.read_kitti_poses_file(tmp_path / "kitti")
    for theirs in (tum, euroc, kitti):
        assert np.allclose(np.array(theirs.poses_se3), made.poses.as_matrix(), rtol=0, atol=2e-15)
    for theirs in (tum, euroc):
        assert np.allclose(theirs.timestamps, made.time_ns * 1e-9, rtol=0, atol=3e-7)


def test_we_read_what_evo_writes(tmp_path: Path) -> None:
    made = some_trajectory(2, 50, 3.0, 1_305_031_098_665_900_001)
    write_trajectory(made, tmp_path / "ours.tum")
    theirs = file_interface.read_tum_trajectory_file(tmp_path / "ours.tum")
    file_interface.write_tum_trajectory_file(tmp_path / "theirs.tum", theirs)
    back = read_trajectory(tmp_path / "theirs.tum")
    assert pose_difference(back.poses, made.poses) < 2e-15
    assert np.abs(back.time_ns - made.time_ns).max() < 300


@pytest.mark.parametrize(
    "name",
    [
        "freiburg1_xyz-groundtruth.txt",
        "freiburg1_xyz-rgbdslam.txt",
        "freiburg1_xyz-ORB_kf_mono.txt",
        "fr2_desk_ORB.txt",
    ],
)
def test_real_files_read_as_evo_reads_them(data_dir: Path, name: str) -> None:
    path = data_dir / "trajectories" / name
    ours, theirs = read_trajectory(path), file_interface.read_tum_trajectory_file(path)
    assert len(ours) == theirs.num_poses
    assert np.array_equal(ours.poses.translation_m.round(12), theirs.positions_xyz.round(12))
    assert np.allclose(ours.time_ns * 1e-9, theirs.timestamps, rtol=0, atol=3e-7)
    unit = theirs.orientations_quat_wxyz / np.linalg.norm(
        theirs.orientations_quat_wxyz, axis=1, keepdims=True
    )
    assert np.allclose(ours.poses.rotor.as_quaternion(), unit, rtol=0, atol=1e-15)


def test_an_equal_stamp_keeps_the_first_row_and_names_the_line(
    data_dir: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = data_dir / "trajectories" / "fr2_desk_groundtruth.txt"
    lines = path.read_text().splitlines()
    repeats = [i for i, line in enumerate(lines, 1) if line.startswith("1311868229.5760 ")]
    with caplog.at_level(logging.WARNING):
        ours = read_trajectory(path)
    assert len(ours) == sum(not line.startswith("#") for line in lines) - 1
    assert len(caplog.messages) == 1
    assert f"line {repeats[1]};" in caplog.messages[0]
    kept = ours.at(np.int64(1_311_868_229_576_000_000)).translation_m
    assert np.allclose(kept, [float(x) for x in lines[repeats[0] - 1].split()[1:4]])


@given(
    digits=st.integers(-(2**61) // 10**9, 2**61 // 10**9),
    fraction=st.text("0123456789", max_size=14),
    unit=st.sampled_from([("s", 10**9), ("ms", 10**6), ("us", 1000), ("ns", 1)]),
)
def test_stamps_are_exact(digits: int, fraction: str, unit: tuple[str, int]) -> None:
    text = f"{digits}.{fraction}" if fraction else str(digits)
    exact = Fraction(text) * unit[1]
    assert stamp_ns(text.encode(), unit[0]) == round(exact)


def test_stamps_in_exponent_notation_are_exact() -> None:
    assert stamp_ns(b"1.403715273262142976e+18", "ns") == 1_403_715_273_262_142_976
    assert stamp_ns(b"1.3050310986659e9", "s") == 1_305_031_098_665_900_000


@pytest.mark.parametrize(
    "text",
    [b"nan", b"inf", b"1_0", b"0x10", b"1e99999999", b"", b"1.2.3", b"99999999999", b"\xd9\xa1"],
)
def test_a_stamp_that_is_no_number_is_refused(text: bytes) -> None:
    with pytest.raises(ValueError, match="expected a stamp in s"):
        stamp_ns(text, "s")


def test_formats_are_told_by_their_rows(tmp_path: Path) -> None:
    made = some_trajectory(3, 4, 1.0, 10**18)
    for fmt in FORMATS:
        write_trajectory(made, tmp_path / "no_ending", fmt)
        rate = 10.0 if fmt == "kitti" else None
        assert len(read_trajectory(tmp_path / "no_ending", rate_hz=rate)) == 4


def test_tabs_crlf_byte_order_marks_and_bare_headers_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.tum"
    path.write_bytes(b"\xef\xbb\xbf# x\r\n1.5\t1\t2\t3\t0\t0\t0\t1\r\n\r\n 2.5  1 2 3 0 0 0 1\r\n")
    assert read_trajectory(path).time_ns.tolist() == [1_500_000_000, 2_500_000_000]
    path = write_lines(tmp_path / "b.csv", "time,px,py,pz,qw,qx,qy,qz,vx", "7, 1,2,3, 1,0,0,0, 9")
    assert read_trajectory(path).poses.translation_m.tolist() == [[1.0, 2.0, 3.0]]


def test_more_columns_are_ignored_in_euroc_files_only(tmp_path: Path) -> None:
    write_lines(tmp_path / "a.csv", "1,1,2,3,1,0,0,0,nothing")
    assert len(read_trajectory(tmp_path / "a.csv")) == 1
    write_lines(tmp_path / "a.tum", "1 1 2 3 0 0 0 1 9")
    with pytest.raises(RecordingError, match=r"line 1: expected 8 columns .*got 9"):
        read_trajectory(tmp_path / "a.tum", "tum")


def test_quaternions_are_normalised_as_far_as_text_rounds_them(tmp_path: Path) -> None:
    write_lines(tmp_path / "a.tum", "0 0 0 0 0 0 0 1.009", "1 0 0 0 0.6 0 0 0.8")
    assert np.allclose(
        read_trajectory(tmp_path / "a.tum").poses.rotor.as_quaternion()[0], [1, 0, 0, 0]
    )


def test_matrices_become_the_nearest_rotation(tmp_path: Path) -> None:
    rotation = some_trajectory(4, 1, 1.0, 0).poses.rotor.as_matrix()[0]
    blurred = rotation + 1e-4 * np.random.default_rng(0).standard_normal((3, 3))
    row = " ".join(map(repr, np.column_stack([blurred, [1, 2, 3]]).ravel().tolist()))
    write_lines(tmp_path / "a.kitti", row)
    ours = read_trajectory(tmp_path / "a.kitti", rate_hz=1.0).poses.rotor.as_matrix()[0]
    left, _, right = np.linalg.svd(blurred)
    assert np.allclose(ours, left @ right, atol=1e-14)
    assert np.abs(ours - rotation).max() < 3e-4


GOOD = "1 1 2 3 0 0 0 1"
REFUSALS = {
    "nan pose": ("2 nan 2 3 0 0 0 1", "line 3, tx: expected a finite number, got nan"),
    "infinite": ("2 1 2 1e999 0 0 0 1", "line 3, tz: expected a finite number, got inf"),
    "backwards": ("0.5 1 2 3 0 0 0 1", "line 3: expected stamps in increasing order"),
    "columns": ("2 1 2 3 0 0 0", "line 3: expected 8 columns .* got 7"),
    "word": ("2 1 two 3 0 0 0 1", "line 3, ty: expected a number, got 'two'"),
    "underscore": ("2 1_0 2 3 0 0 0 1", "line 3, tx: expected a number, got '1_0'"),
    "stamp": ("x 1 2 3 0 0 0 1", "line 3: expected a stamp in s, got 'x'"),
    "zero quaternion": ("2 1 2 3 0 0 0 0", "line 3: expected a unit quaternion .* got norm 0"),
    "long quaternion": ("2 1 2 3 0 0 0 1.02", "line 3: expected a unit quaternion .* norm 1.02"),
    "huge quaternion": ("2 1 2 3 0 0 1e300 1", "line 3: expected a unit quaternion"),
    "far away": ("2 1e30 2 3 0 0 0 1", r"line 3: expected a position within 1e\+09 m"),
    "nanoseconds": ("1403715273262142976 1 2 3 0 0 0 1", "line 3: .*too large"),
}


@pytest.mark.parametrize(("row", "message"), REFUSALS.values(), ids=REFUSALS)
def test_a_bad_row_is_refused_with_its_line(tmp_path: Path, row: str, message: str) -> None:
    path = write_lines(tmp_path / "bad.tum", "# a comment", GOOD, row)
    with pytest.raises(RecordingError, match=message) as refused:
        read_trajectory(path, "tum")
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "row", ["2 0 0 0 0 1 0 0 0 0 1 0", "1 0 0 0 0 1 0 0 0 0 -1 0", "0 0 0 0 0 0 0 0 0 0 0 0"]
)
def test_a_matrix_that_is_no_rotation_is_refused(tmp_path: Path, row: str) -> None:
    path = write_lines(tmp_path / "bad.kitti", "1 0 0 0 0 1 0 0 0 0 1 0", row)
    with pytest.raises(RecordingError, match="line 2: expected a rotation"):
        read_trajectory(path, rate_hz=1.0)


def test_kitti_stamps_come_from_exactly_one_place(tmp_path: Path) -> None:
    path = write_lines(tmp_path / "a.kitti", *["1 0 0 0 0 1 0 0 0 0 1 0"] * 3)
    times = write_lines(tmp_path / "times.txt", "0", "1.0370000e-01", "0.25")
    assert read_trajectory(path, times=times).time_ns.tolist() == [0, 103_700_000, 250_000_000]
    assert read_trajectory(path, rate_hz=3.0).time_ns.tolist() == [0, 333_333_333, 666_666_667]
    for choice in ({}, {"times": times, "rate_hz": 3.0}):
        with pytest.raises(ValueError, match="give --times FILE with a stamp for every pose"):
            read_trajectory(path, **choice)
    with pytest.raises(ValueError, match="rate_hz: expected a rate"):
        read_trajectory(path, rate_hz=0.0)
    write_lines(times, "0", "0.1")
    with pytest.raises(RecordingError, match="expected 2 poses for the stamps"):
        read_trajectory(path, times=times)
    write_lines(times, "0", "0.1", "0.1")
    with pytest.raises(RecordingError, match="line 3: expected increasing stamps"):
        read_trajectory(path, times=times)


def test_other_formats_take_no_stamps(tmp_path: Path) -> None:
    path = write_lines(tmp_path / "a.tum", GOOD)
    with pytest.raises(ValueError, match="only KITTI files lack stamps"):
        read_trajectory(path, rate_hz=3.0)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"# only a comment\n", "no row of numbers"),
        (b"\x00\x01\x02", "binary"),
        (b"1 2 3\n", "got 3 columns"),
        (b"1,2,3\n", "got 3 columns"),
        (b"9" * 100_000, "lines of at most"),
    ],
)
def test_a_file_that_is_no_trajectory_is_refused(
    tmp_path: Path, content: bytes, message: str
) -> None:
    path = tmp_path / "bad"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=message):
        read_trajectory(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="the file is missing"):
        read_trajectory(tmp_path / "nothing.tum")
    with pytest.raises(RecordingError, match="expected a file, got a folder"):
        read_trajectory(tmp_path)


@settings(deadline=None, max_examples=150)
@given(data=st.binary(max_size=300), fmt=st.sampled_from([None, *FORMATS]))
def test_garbage_is_refused_and_nothing_else(
    tmp_path_factory: pytest.TempPathFactory, data: bytes, fmt: str | None
) -> None:
    path = tmp_path_factory.getbasetemp() / "garbage"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"."):
        read_trajectory(path, fmt)


@settings(deadline=None, max_examples=150)
@given(place=st.integers(0, 10**6), byte=st.integers(0, 255), fmt=st.sampled_from(FORMATS))
def test_a_changed_byte_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, place: int, byte: int, fmt: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "changed"
    write_trajectory(some_trajectory(6, 3, 1.0, 10**18), path, fmt)
    data = bytearray(path.read_bytes())
    data[place % len(data)] = byte
    path.write_bytes(data)
    # Refused with a ValueError or read; anything else fails the test.
    with contextlib.suppress(ValueError):
        read_trajectory(path, rate_hz=1.0 if fmt == "kitti" else None)


def test_writing_is_all_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = some_trajectory(7, 3, 1.0, 0)
    path = tmp_path / "a.tum"
    write_trajectory(made, path)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="cannot be written"):
        write_trajectory(some_trajectory(8, 3, 1.0, 0), path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["a.tum"]


@pytest.mark.parametrize("fmt", FORMATS)
def test_a_scale_that_no_text_holds_is_refused(tmp_path: Path, fmt: str) -> None:
    rigid, path = some_trajectory(9, 5, 1.0, 0), tmp_path / f"a.{fmt}"
    scale = np.array([1.0, 1.0, 1.0 + 1e-8, 1.0, 1.0])
    grown = Trajectory(rigid.time_ns, Similarity.from_motor_scale(rigid.motors, scale))
    with pytest.raises(ValueError, match=r"expected poses of scale 1, .* got scale 1\.00000001 at"):
        write_trajectory(grown, path, fmt)
    assert not path.exists()
    same = Trajectory(rigid.time_ns, Similarity.from_motor_scale(rigid.motors))
    write_trajectory(same, path, fmt)
    back = read_trajectory(path, rate_hz=30.0 if fmt == "kitti" else None)
    assert pose_difference(back.motors, rigid.motors) < 2e-15


def test_an_unknown_format_is_refused(tmp_path: Path) -> None:
    made = some_trajectory(7, 3, 1.0, 0)
    with pytest.raises(ValueError, match="expected a name ending in"):
        write_trajectory(made, tmp_path / "a.xyz")
    with pytest.raises(ValueError, match="did you mean euroc"):
        write_trajectory(made, tmp_path / "a.xyz", "euro")


def test_a_kitti_file_without_rows_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "poses.txt"
    path.write_text("# nothing\n\n")
    with pytest.raises(ValueError, match="poses"):
        read_trajectory(path, "kitti", rate_hz=10.0)
