"""Comma files are read by their header: order, names, units; what stays open is refused."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import read_trajectory

TIME_NS = 1_403_715_273_262_142_976 + 5_000_000 * np.arange(50)
EUROC = ("w_x", "w_y", "w_z", "a_x", "a_y", "a_z")


@pytest.fixture(scope="module")
def stream() -> ImuStream:
    rng = np.random.default_rng(0)
    rate = rng.normal(0.0, 0.5, (50, 3))
    force = rng.normal(0.0, 0.5, (50, 3)) + np.array([0.0, 0.0, 9.81])
    return ImuStream(TIME_NS, rate, force)


@pytest.fixture(scope="module")
def path() -> Trajectory:
    return Trajectory(TIME_NS, Motor.random(np.random.default_rng(1), (50,)))


def written(
    file: Path, header: str | None, stamps: Sequence[object], columns: Sequence[FloatArray]
) -> Path:
    rows = zip(stamps, *(column.tolist() for column in columns), strict=True)
    lines = [",".join(map(str, row)) for row in rows]
    file.write_text("\n".join([*([] if header is None else [header]), *lines]) + "\n")
    return file


def seconds() -> list[str]:
    return [f"{stamp // 10**9}.{stamp % 10**9:09d}" for stamp in TIME_NS.tolist()]


def columns_of(stream: ImuStream) -> dict[str, FloatArray]:
    values = np.concatenate([stream.angular_rate_rad_s, stream.specific_force_m_s2], axis=1)
    return dict(zip(EUROC, values.T, strict=True))


HEADERS = {
    "#timestamp [ns],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2],w_RS_S_x [rad s^-1],"
    "w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]": ("a_x", "a_y", "a_z", "w_x", "w_y", "w_z"),
    "timestamp,gyro_z,gyro_y,gyro_x,acc_x,acc_y,acc_z": ("w_z", "w_y", "w_x", "a_x", "a_y", "a_z"),
    "t_ns,ax,ay,az,gx,gy,gz": ("a_x", "a_y", "a_z", "w_x", "w_y", "w_z"),
    "time,linear_acceleration.x,linear_acceleration.y,linear_acceleration.z,angular_velocity.x,"
    "angular_velocity.y,angular_velocity.z": ("a_x", "a_y", "a_z", "w_x", "w_y", "w_z"),
    "# stamp, AccelX (m/s^2), AccelY (m/s^2), AccelZ (m/s^2), GyroX (rad/s), GyroY (rad/s), "
    "GyroZ (rad/s)": ("a_x", "a_y", "a_z", "w_x", "w_y", "w_z"),
}


@pytest.mark.parametrize("header", HEADERS)
def test_an_imu_file_is_read_by_the_names_of_its_columns(
    header: str, stream: ImuStream, tmp_path: Path
) -> None:
    columns = columns_of(stream)
    ordered = [columns[name] for name in HEADERS[header]]
    found = read_imu(written(tmp_path / "imu.csv", header, TIME_NS.tolist(), ordered))
    assert np.array_equal(found.time_ns, TIME_NS)
    assert np.array_equal(found.angular_rate_rad_s, stream.angular_rate_rad_s)
    assert np.array_equal(found.specific_force_m_s2, stream.specific_force_m_s2)


def test_other_columns_may_stand_between_them(stream: ImuStream, tmp_path: Path) -> None:
    header = "id,stamp [ns],mag_x,w_x,w_y,w_z,b_w_x,a_x,a_y,a_z,temperature"
    other = np.full(50, 7.0)
    columns = [np.array(TIME_NS, dtype=object), other, *columns_of(stream).values()]
    columns = [*columns[:5], other, *columns[5:], other]
    found = read_imu(written(tmp_path / "imu.csv", header, range(50), columns))
    assert np.array_equal(found.time_ns, TIME_NS)
    assert np.array_equal(found.angular_rate_rad_s, stream.angular_rate_rad_s)
    assert np.array_equal(found.specific_force_m_s2, stream.specific_force_m_s2)


@pytest.mark.parametrize(
    "rate_unit", ["w_x_deg_s,w_y_deg_s,w_z_deg_s", "wx (°/s),wy (dps),wz [deg/s]"]
)
@pytest.mark.parametrize("force_unit", ["a_x [g],a_y [g],a_z [g]", "acc_x_g,acc_y_g,acc_z_g"])
def test_units_of_the_header_are_heeded(
    rate_unit: str, force_unit: str, stream: ImuStream, tmp_path: Path
) -> None:
    columns = [
        *np.rad2deg(stream.angular_rate_rad_s).T,
        *(stream.specific_force_m_s2 / 9.80665).T,
    ]
    header = f"time_s,{rate_unit},{force_unit}"
    found = read_imu(written(tmp_path / "imu.csv", header, seconds(), columns))
    assert np.array_equal(found.time_ns, TIME_NS)
    assert np.allclose(found.angular_rate_rad_s, stream.angular_rate_rad_s, rtol=1e-14, atol=0)
    assert np.allclose(found.specific_force_m_s2, stream.specific_force_m_s2, rtol=1e-14, atol=0)


@pytest.mark.parametrize("unit", ["us", "ms", "s", "ns"])
def test_stamps_are_in_the_unit_that_the_header_states(
    unit: str, stream: ImuStream, tmp_path: Path
) -> None:
    size = {"s": 9, "ms": 6, "us": 3, "ns": 0}[unit]
    stamps = [f"{stamp}e-{size}" for stamp in TIME_NS.tolist()]
    header = f"#timestamp [{unit}],{','.join(EUROC)}"
    found = read_imu(
        written(tmp_path / "imu.csv", header, stamps, list(columns_of(stream).values()))
    )
    assert np.array_equal(found.time_ns, TIME_NS)


@pytest.mark.parametrize("header", [None, "timestamp," + ",".join(EUROC), "# recorded, by hand"])
def test_seconds_are_told_from_nanoseconds(
    header: str | None, stream: ImuStream, path: Trajectory, tmp_path: Path
) -> None:
    found = read_imu(
        written(tmp_path / "imu.csv", header, seconds(), list(columns_of(stream).values()))
    )
    assert np.array_equal(found.time_ns, TIME_NS)
    wxyz, translation_m = path.motors.as_quaternion_translation()
    columns = [*translation_m.T, *wxyz.T]
    poses = read_trajectory(written(tmp_path / "path.csv", None, seconds(), columns))
    assert np.array_equal(poses.time_ns, TIME_NS)


def test_fractions_of_a_nanosecond_are_rounded_as_before(stream: ImuStream, tmp_path: Path) -> None:
    stamps = [f"{stamp}.4" for stamp in TIME_NS.tolist()]
    found = read_imu(written(tmp_path / "imu.csv", None, stamps, list(columns_of(stream).values())))
    assert np.array_equal(found.time_ns, TIME_NS)


@pytest.mark.parametrize(
    ("header", "order"),
    [
        ("timestamp,tx,ty,tz,qx,qy,qz,qw", (0, 1, 2, 4, 5, 6, 3)),
        ("qw,qx,qy,qz,x,y,z,time_s", (3, 4, 5, 6, 0, 1, 2)),
        ("time,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,"
         "pose.orientation.y,pose.orientation.z,pose.orientation.w", (0, 1, 2, 4, 5, 6, 3)),
    ],
)  # fmt: skip
def test_a_trajectory_is_read_by_the_names_of_its_columns(
    header: str, order: tuple[int, ...], path: Trajectory, tmp_path: Path
) -> None:
    wxyz, translation_m = path.motors.as_quaternion_translation()
    columns = [[*translation_m.T, *wxyz.T][place].tolist() for place in order]
    at_the_end = header.endswith("time_s")
    rows = (
        zip(*columns, seconds(), strict=True)
        if at_the_end
        else zip(seconds(), *columns, strict=True)
    )
    file = tmp_path / "path.csv"
    file.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]))
    found = read_trajectory(file)
    assert np.array_equal(found.time_ns, TIME_NS)
    assert np.abs(path.motors.local(found.motors)).max() < 1e-12


REFUSED = {
    "timestamp,ax,ay,az,foo,bar,baz": "expected a header that names stamp w_x",
    "timestamp,wx,wy,wz,ax,ay,ay": "got a_y twice",
    "timestamp [fortnights],wx,wy,wz,ax,ay,az": "expected stamps in ns, us, ms or s",
    "timestamp,wx,wy [rpm],wz,ax,ay,az": "expected one of the units rad/s",
}


@pytest.mark.parametrize("header", REFUSED)
def test_a_header_that_leaves_something_open_is_refused_in_one_line(
    header: str, stream: ImuStream, tmp_path: Path
) -> None:
    file = written(
        tmp_path / "imu.csv", header, TIME_NS.tolist(), list(columns_of(stream).values())
    )
    with pytest.raises(RecordingError) as refused:
        read_imu(file)
    assert REFUSED[header] in str(refused.value)
    assert "\n" not in str(refused.value)
    assert str(file) in str(refused.value)


def test_seconds_under_a_header_of_nanoseconds_are_refused(
    stream: ImuStream, tmp_path: Path
) -> None:
    header = f"#timestamp [ns],{','.join(EUROC)}"
    file = written(tmp_path / "imu.csv", header, seconds(), list(columns_of(stream).values()))
    with pytest.raises(RecordingError, match=r"as the header says, got .1403715273"):
        read_imu(file)


def test_a_header_that_nobody_knows_leaves_the_order_as_it_is(
    stream: ImuStream, tmp_path: Path
) -> None:
    file = written(
        tmp_path / "imu.csv", "A,B,C,D,E,F,G", TIME_NS.tolist(), list(columns_of(stream).values())
    )
    assert np.array_equal(read_imu(file).angular_rate_rad_s, stream.angular_rate_rad_s)
